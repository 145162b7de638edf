//! The bound by the cheapest 2-matching, a minimum-cost flow.
//!
//! A cover of n cells with p pieces has n - p links, at most two at each cell.
//! So its crossings cost at least as much as the cheapest 2-matching with n - p links.
//! And if the maximum 2-matching has fewer than n - p links, there is no cover with p pieces.
//!
//! The flow accounts for the chessboard colours: a path alternates between black and white cells,
//! so a zone with many more black cells than white ones has to be entered and left at black cells
//! many times.

use crate::matching::{Board, ComponentGraph, LadderLayout, TwoMatching};

/// The cheapest 2-matching for the minimum number of pieces, and that number.
///
/// A 2-matching whose n cells together have room for d more links has n - d / 2 links and d / 2
/// paths; a cover has at least one.
pub(crate) fn cheapest(board: &Board) -> (TwoMatching<'_>, u32) {
    let matching = cheapest_with_pieces(board, 1);
    let pieces = matching.total_room / 2;
    (matching, pieces)
}

/// Lower bound on the cost of a cover with a given number of pieces, wherever they begin and end.
/// The number must not be below the minimum.
pub(crate) fn min_cost(board: &Board, pieces: u32) -> u64 {
    cheapest_with_pieces(board, pieces).cost() as u64
}

/// The cheapest 2-matching with the number of links of a cover with `pieces` pieces, or with the
/// maximum number of links if that is lower.
fn cheapest_with_pieces(board: &Board, pieces: u32) -> TwoMatching<'_> {
    let mut matching = TwoMatching::inside_zones(board, LadderLayout::default());
    matching.remove_links_inside(2 * pieces, |_| 0);
    matching.grow(2 * pieces);
    matching
}

/// For each zone component a lower bound on its segments, the stretches of a path inside it: half
/// the number of links that the cells of a maximum 2-matching inside it lack, and at least 1.
pub(crate) fn min_segments(board: &Board, zones: &ComponentGraph) -> Vec<u32> {
    let mut inside = TwoMatching::inside_zones(board, LadderLayout::default());
    inside.grow_inside_zones();
    let mut lacking = vec![0; zones.count() as usize];
    for &node in &board.cells {
        lacking[zones.component(node) as usize] += u32::from(inside.room[node as usize]);
    }
    lacking.into_iter().map(|lacking: u32| lacking.div_ceil(2).max(1)).collect()
}
