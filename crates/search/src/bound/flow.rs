//! The bound of the cheapest 2-matching.

use crate::matching::{Board, Grain, Matching, ZoneGraph};

/// The cheapest 2-matching of a connected board with as many links as the fewest pieces leave, and
/// these pieces.
///
/// A cover of n cells in p pieces has n - p links, at most two at each cell.
/// A maximum 2-matching has n - d / 2 links if its cells lack d, so p is at least d / 2, and at
/// least 1; and the crossings of the cover are at least those of the cheapest 2-matching of n - p
/// links.
/// It is a minimum cost flow from the black cells of a chessboard colouring to the white ones, so
/// it counts what colours cost: a zone with more black cells than white ones must be entered and
/// left at black ones.
pub(crate) fn flow(board: &Board) -> (Matching<'_>, u32) {
    let mut matching = Matching::inside_zones(board, Grain::default());
    matching.drop_links_inside(2, |_| 0);
    matching.grow(2);
    let pieces = matching.spare / 2;
    (matching, pieces)
}

/// The same for more pieces than needed, wherever they begin and end: what their crossings cost at
/// least.
pub(crate) fn cost_in(board: &Board, pieces: u32) -> u64 {
    let mut matching = Matching::inside_zones(board, Grain::default());
    matching.drop_links_inside(2 * pieces, |_| 0);
    matching.grow(2 * pieces);
    matching.cost() as u64
}

/// Segments that each zone component needs at least: half of what a maximum 2-matching inside it
/// lacks, but at least 1.
pub(crate) fn need(board: &Board, graph: &ZoneGraph) -> Vec<u32> {
    let mut inside = Matching::inside_zones(board, Grain::default());
    inside.grow_inside_zones();
    let mut lacking = vec![0; graph.count() as usize];
    for &node in &board.cells {
        lacking[graph.component(node) as usize] += u32::from(inside.room[node as usize]);
    }
    lacking.into_iter().map(|lacking: u32| lacking.div_ceil(2).max(1)).collect()
}
