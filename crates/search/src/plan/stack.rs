//! How the path of a layer lies on that of the layer below.

use beadwork_grid::{Cell, Path};

/// Links that two paths on planes of the same size have in common.
///
/// A bead on a bead of the same course continues its seam; one that crosses it binds the layers.
/// Linear in the cells of the second path.
///
/// # Panics
/// If the planes differ in size.
pub fn kept_links(below: &Path, path: &Path) -> u32 {
    assert_eq!(
        (below.width(), below.height()),
        (path.width(), path.height()),
        "paths on one plane"
    );
    let is_kept = |&cell: &Cell| {
        let right = path.linked_right(cell) && below.linked_right(cell);
        let down = path.linked_below(cell) && below.linked_below(cell);
        u32::from(right) + u32::from(down)
    };
    path.order().iter().map(is_kept).sum()
}
