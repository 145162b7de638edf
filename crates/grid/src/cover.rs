//! Covers: paths in few pieces through regions of any shape.
//!
//! A region need not have a Hamiltonian path, and deciding whether it has one is NP-complete (Itai,
//! Papadimitriou and Szwarcfiter, "Hamilton paths in grid graphs", 1982).
//! This heuristic finds a path in few pieces, in three steps:
//!
//! 1. A maximum 2-matching ([`matching`](crate::matching)): disjoint paths and cycles through all
//!    cells with as many links as possible.
//!    It also bounds the number of pieces from below.
//! 2. Cycles are joined to each other and to paths where they touch; the remaining ones are opened
//!    ([`strands`]).
//! 3. While there are more pieces than the bound, the ends of paths wander at random until two of
//!    them meet ([`rotation`]).

mod rotation;
mod strands;

use beadwork_base::{Control, Interrupted};

use crate::matching::TwoMatching;
use crate::orders::{first_jump, row_zigzag};
use crate::{Path, Region, region_components};
use rotation::{Pieces, work_limit};
use strands::Strands;

/// Lower bound on the number of pieces of any path through all cells of a region.
///
/// It is the sum of the bounds of the region's connected components.
/// For a component of n cells, the bound is n minus the size of a maximum 2-matching, that is, a
/// maximum set of links with at most two at each cell: p pieces have n - p links and at most two at
/// each cell.
/// Every component needs at least one piece.
/// The bound is at least as high as the one from chessboard colours: since a path alternates
/// between black and white cells, a component with d more black than white cells needs d pieces.
///
/// Takes the time of a maximum flow, which is nearly linear in the grid's cells on usual parts.
/// Progress counts cells of the region.
pub fn piece_bound(region: &Region, control: &Control<'_>) -> Result<u32, Interrupted> {
    let matching = TwoMatching::maximum(region, control, region.cell_count() as usize)?;
    Ok(matching.pieces(&region_components(region)).iter().sum())
}

/// Finds a path in few pieces through any region.
///
/// If the row zigzag is one path, it is the result.
/// Otherwise the number of pieces is at least [`piece_bound`] and usually equal to it or larger by
/// one, but not always the minimum.
/// The same region always gives the same path.
///
/// Takes the time of [`piece_bound`], plus a random search that rewrites at most 6000 n cells of a
/// region of n cells, and at most 64 n + 60 million: seconds on the largest regions.
/// Progress counts cells of the matching, then cells rewritten; it jumps to the end if the search
/// reaches the bound early.
pub fn cover(region: &Region, control: &Control<'_>) -> Result<Path, Interrupted> {
    control.check()?;
    let rows = row_zigzag(region);
    let order = if first_jump(region, &rows).is_none() {
        rows
    } else {
        let cells = region.cell_count() as usize;
        let total = cells + work_limit(region) as usize;
        let matching = TwoMatching::maximum(region, control, total)?;
        let bound = matching.pieces(&region_components(region)).iter().sum();
        let mut strands = Strands::new(region, matching);
        strands.join(control)?;
        let mut pieces = Pieces::new(region, strands.into_pieces());
        pieces.wander(region, bound, control)?;
        control.report(total, total);
        pieces.into_order()
    };
    Ok(Path::in_pieces(region, order).expect("the pieces hold every cell once"))
}

#[cfg(test)]
mod tests;
