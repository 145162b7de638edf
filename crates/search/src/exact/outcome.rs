//! The result of the exact search.

use beadwork_grid::{Cell, Path};
use thiserror::Error;

use crate::Stop;

/// The best path found, and proven lower bounds to judge it by.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The path.
    pub path: Path,
    /// Number of pieces of the path.
    pub pieces: u32,
    /// Proven lower bound on the pieces of any path that begins and ends where required.
    pub piece_bound: u32,
    /// Number of steps of the path between two zones.
    pub crossings: u32,
    /// Cost of the crossings, in the unit of [`Settings::costs`](super::Settings::costs); their
    /// number if that is not set.
    pub cost: f64,
    /// Proven lower bound on the cost of any path with this number of pieces that begins and ends
    /// where required.
    /// Where costs depend on the direction it assumes the cheaper direction of each pair of zones,
    /// so there may be no path that meets it.
    /// The same may happen with costs above 10,000 after [scaling](crate::CostMatrix::scale): the
    /// search rounds them down to multiples of 1/10,000 of the largest one.
    pub bound: f64,
    /// Why the search stopped; [`Stop::Optimal`] exactly if [`Outcome::is_optimal`].
    pub stop: Stop,
    /// Number of attempts, summed over all components.
    pub attempts: u32,
}

impl Outcome {
    /// Whether it is proven that no path has fewer pieces, and no path with the same number of
    /// pieces costs less.
    pub fn is_optimal(&self) -> bool {
        self.pieces == self.piece_bound && self.cost <= self.bound
    }
}

/// Reasons why the inputs of [`solve`](super::solve) allow no path.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolveError {
    /// The zones belong to a grid of another size.
    #[error("zones: grid has {got} cells, the region's has {expected}")]
    Zones {
        /// Number of cells of the region's grid.
        expected: usize,
        /// Number of cells of the zones' grid.
        got: usize,
    },
    /// A cell of the region has no zone.
    #[error("cell ({x}, {y}) belongs to the region but has no zone")]
    NoZone {
        /// Column of the cell.
        x: u32,
        /// Row of the cell.
        y: u32,
    },
    /// There are more zones than the costs cover.
    #[error("crossing costs: given for {got} zones, the layer has {expected}")]
    Costs {
        /// Number of zones of the layer.
        expected: u32,
        /// Number of zones that have costs.
        got: usize,
    },
    /// The costs forbid a crossing.
    #[error(
        "crossing from zone {from} to zone {to} is forbidden, which exact search does not support"
    )]
    Forbidden {
        /// The zone before the crossing.
        from: u8,
        /// The zone after it.
        to: u8,
    },
    /// The path of the layer below belongs to a grid of another size.
    #[error(
        "path of the layer below: grid is {} x {} cells, the region's is {} x {}",
        .got[0], .got[1], .expected[0], .expected[1]
    )]
    Below {
        /// Width and height of the region's grid, in cells.
        expected: [u32; 2],
        /// Width and height of the path's grid, in cells.
        got: [u32; 2],
    },
    /// A cell at which the path has to begin or end does not belong to the region.
    #[error("{end} cell {cell} is outside the region")]
    Outside {
        /// "start" or "end".
        end: &'static str,
        /// The cell.
        cell: Cell,
    },
    /// The path has to begin and end at the same cell, but the region has others.
    #[error("start and end are both cell {0}, but the path has more than one cell")]
    SameCell(Cell),
    /// The constraints on start and end allow only one cell, the same for both, but the region has
    /// others.
    #[error("start and end: both allow only the same cell, but the path has more than one cell")]
    NoTwoCells,
}
