//! Comparison of the path of a layer with the path of the layer below.

use beadwork_grid::{Cell, Path};

/// Number of links that two paths on grids of the same size have in common.
///
/// Beads that run along those below stack their seams on top of each other; beads that cross those
/// below bind the layers.
/// Linear in the cells of the second path.
///
/// # Panics
/// If the grids differ in size.
pub fn kept_links(below: &Path, path: &Path) -> u32 {
    assert_eq!(
        (below.width(), below.height()),
        (path.width(), path.height()),
        "paths on grids of one size"
    );
    let is_kept = |&cell: &Cell| {
        let right = path.linked_right(cell) && below.linked_right(cell);
        let down = path.linked_below(cell) && below.linked_below(cell);
        u32::from(right) + u32::from(down)
    };
    path.order().iter().map(is_kept).sum()
}
