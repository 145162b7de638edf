//! Proven lower bounds on the pieces of a path and on its crossings.
//!
//! Each file holds one kind of bound, with its proof; [`Bounds`] computes all of them for a layer.
//!
//! | bound | idea |
//! |---|---|
//! | [`components`] | each zone component is visited at least once |
//! | flow | a path is a 2-matching, and the cheapest one is a minimum-cost flow |
//! | segments | a component that one stretch of path cannot fill is visited several times |
//! | scattering | between components that touch only a few hubs, a path crosses to a hub and back |
//! | walk | a path visits the components one after the other, from neighbour to neighbour |
//! | connectivity | a path needs a link that no cheapest 2-matching has |
//! | cuts | 2-matchings pay for cycles in sets of cells that a path may not close |

pub(crate) mod connectivity;
pub(crate) mod cuts;
pub(crate) mod flow;
pub(crate) mod segments;
pub(crate) mod walk;

use beadwork_base::{Control, Interrupted};
use beadwork_grid::{Region, Zones, zone_components};

use crate::CostMatrix;
use crate::matching::{Board, ComponentGraph, ShortestPaths};
use connectivity::Separation;
use cuts::Cuts;

/// Lower bound on the crossings of any path with this number of pieces: zone components minus
/// pieces.
///
/// Along a piece the zone component changes only at crossings, so a piece with c crossings visits
/// at most c + 1 components, and all pieces together visit at most crossings + pieces.
/// Linear in the cells.
pub fn components(region: &Region, zones: &Zones, pieces: u32) -> u32 {
    zone_components(region, zones).count().saturating_sub(pieces)
}

/// Proven lower bounds for one layer: on the number of pieces of any path that covers it, and on
/// the crossings of any path with exactly that number of pieces.
///
/// Each is a sum over the connected components of the region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Bound on the pieces: for each component half the number of links that the cells of a maximum
    /// 2-matching lack, and at least 1.
    pub pieces: u32,
    /// Crossings of the cheapest 2-matching with the number of links that a path has.
    pub flow: u32,
    /// Minimum number of segments, the stretches of a path inside one zone component, minus the
    /// pieces.
    pub segments: u32,
    /// A bound like [`Bounds::segments`] that also counts the crossings to and from hubs:
    /// components whose removal separates others from each other.
    pub scattering: u32,
    /// Minimum number of steps of walks that visit all zone components; `None` if a component of
    /// the region has more than 13 of them, or if a high number of pieces gives the search too many
    /// states.
    pub walk: Option<u32>,
    /// [`Bounds::flow`], plus the cost of a link that no cheapest 2-matching has, where a path
    /// needs one to be connected.
    pub connectivity: u32,
    /// [`Bounds::flow`], raised by Lagrange multipliers on sets of cells that 2-matchings leave as
    /// cycles.
    pub cuts: u32,
}

impl Bounds {
    /// Computes all bounds of a layer, on the calling thread.
    /// Progress counts cells, those of each component of the region once its bounds are known.
    ///
    /// The flow takes nearly linear time in the cells.
    /// The walk takes exponential time in the number of zone components, up to its limit, and the
    /// scattering quadratic time in it.
    /// Connectivity and cuts make a shortest-path search for each link along a border.
    ///
    /// # Errors
    /// If the control interrupts the call.
    ///
    /// # Panics
    /// If the zones belong to a grid of another size, or a cell of the region has no zone.
    pub fn new(region: &Region, zones: &Zones, control: &Control<'_>) -> Result<Self, Interrupted> {
        let costs = CostMatrix::uniform(zones.count() as usize);
        let boards = Board::of_components(region, zones, &costs);
        let mut sum = Self {
            pieces: 0,
            flow: 0,
            segments: 0,
            scattering: 0,
            walk: Some(0),
            connectivity: 0,
            cuts: 0,
        };
        let cells: usize = boards.iter().map(|board| board.cells.len()).sum();
        let mut cells_done = 0;
        for board in &boards {
            control.check()?;
            let (matching, pieces) = flow::cheapest(board);
            let graph = ComponentGraph::of_zones(board);
            let min_segments = flow::min_segments(board, &graph);
            let mut paths = ShortestPaths::new(board);
            let flow = matching.cost() as u32;
            let extra = Separation::find(&matching, pieces)
                .map_or(0, |separation| separation.extra_cost(&matching, pieces, &mut paths));
            control.check()?;
            let cuts = Cuts::Subgradient.bound(&matching, pieces, &mut paths, u64::MAX, control);
            // An interrupted search returns a bound that holds but is too low.
            control.check()?;
            sum.pieces += pieces;
            sum.flow += flow;
            sum.segments += segments::count(&min_segments, pieces);
            sum.scattering += segments::scattering(&graph, &min_segments, pieces);
            sum.walk = sum.walk.zip(walk::min_steps(&graph, pieces)).map(|(sum, walk)| sum + walk);
            sum.connectivity += flow + extra;
            sum.cuts += cuts as u32;
            cells_done += board.cells.len();
            control.report(cells_done, cells);
        }
        Ok(sum)
    }

    /// The highest of the lower bounds on the crossings.
    pub fn crossings(&self) -> u32 {
        let others =
            [self.segments, self.scattering, self.walk.unwrap_or(0), self.connectivity, self.cuts];
        others.into_iter().fold(self.flow, u32::max)
    }
}

#[cfg(test)]
mod tests;
