//! Paths as CSV and JSON.

use std::fmt::Write;

use beadwork_grid::{Path, Region};
use serde_json::{Value, json};

/// A path as CSV: a header, then one line `piece,x,y` for each cell in the order of the path.
/// Pieces count from 0; x points right, y down.
pub(crate) fn csv(region: &Region, path: &Path) -> String {
    let mut text = "piece,x,y\n".to_owned();
    for (number, piece) in path.iter_pieces().enumerate() {
        for (x, y) in piece.iter().map(|&cell| region.xy(cell)) {
            writeln!(text, "{number},{x},{y}").expect("writing to a string succeeds");
        }
    }
    text
}

/// A path as JSON: an array of pieces, each an array of its cells `[x, y]` in order.
pub(crate) fn json(region: &Region, path: &Path) -> Value {
    let piece = |cells: &[u32]| cells.iter().map(|&cell| region.xy(cell)).collect::<Vec<_>>();
    json!(path.iter_pieces().map(piece).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use beadwork_grid::Region;

    use super::*;

    #[test]
    fn pieces_are_numbered() {
        let region = Region::from_mask(3, 2, vec![true, false, true, true, false, true]).unwrap();
        let path = Path::in_pieces(&region, vec![0, 3, 5, 2]).unwrap();
        assert_eq!(csv(&region, &path), "piece,x,y\n0,0,0\n0,0,1\n1,2,1\n1,2,0\n");
        assert_eq!(json(&region, &path), json!([[[0, 0], [0, 1]], [[2, 1], [2, 0]]]));
    }
}
