//! Proven lower bounds.
//!
//! Each bound is a function of its own, with its proof, in a module of its own; [`Bounds`] has them
//! all for one layer.

pub(crate) mod connectivity;
pub(crate) mod cuts;
pub(crate) mod flow;
pub(crate) mod segments;
pub(crate) mod walk;

use beadwork_base::{Control, Interrupted};
use beadwork_grid::{Region, Zones, zone_components};

use crate::ZoneCosts;
use crate::matching::{Board, Paths, ZoneGraph};
use connectivity::Apart;
use cuts::Cuts;

/// Crossings that a cover in so many pieces can't do without: zone components minus pieces.
///
/// Along a piece the zone component changes only at crossings, so a piece with c crossings sees at
/// most c + 1 of them, and all pieces together at most crossings + pieces.
/// Linear in the cells.
pub fn components(region: &Region, zones: &Zones, pieces: u32) -> u32 {
    zone_components(region, zones).count().saturating_sub(pieces)
}

/// Proven lower bounds for one layer: on the pieces of any path that covers it, and on the
/// crossings of any path with as many pieces as that.
///
/// Each is a sum over the connected components of the region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Bound on the pieces: for each component half the number of links that the cells of a maximum
    /// 2-matching lack, and at least 1.
    pub pieces: u32,
    /// Crossings of the cheapest 2-matching with as many links as a cover has.
    pub flow: u32,
    /// Minimum number of segments of the zone components, minus the pieces.
    pub cover: u32,
    /// Count of segments around hubs: components whose removal separates many others.
    pub scattering: u32,
    /// Minimum number of steps of walks that visit all zone components; `None` if a component of
    /// the region has more than 13 of them.
    pub walk: Option<u32>,
    /// [`Bounds::flow`], plus the price of connecting what no cheapest 2-matching connects.
    pub connectivity: u32,
    /// [`Bounds::flow`], raised by Lagrange multipliers on closed sets of cells.
    pub cuts: u32,
}

impl Bounds {
    /// Computes all bounds of a layer, on the calling thread.
    /// Progress counts cells, those of each component of the region once its bounds are known.
    ///
    /// The flow takes nearly linear time in the cells, the walk exponential time in the zone
    /// components up to its limit, the scattering quadratic time in them.
    /// Connectivity and cuts make a shortest-path search for each link along a border.
    ///
    /// # Errors
    /// If the control interrupts the call.
    ///
    /// # Panics
    /// If the zones belong to a grid of another size, or a cell of the region has no zone.
    pub fn new(region: &Region, zones: &Zones, control: &Control<'_>) -> Result<Self, Interrupted> {
        let costs = ZoneCosts::uniform(zones.count());
        let boards = Board::of_components(region, zones, &costs);
        let mut sum = Self {
            pieces: 0,
            flow: 0,
            cover: 0,
            scattering: 0,
            walk: Some(0),
            connectivity: 0,
            cuts: 0,
        };
        let cells: usize = boards.iter().map(|board| board.cells.len()).sum();
        let mut cells_done = 0;
        for board in &boards {
            control.check()?;
            let (matching, pieces) = flow::flow(board);
            let graph = ZoneGraph::new(board);
            let need = flow::need(board, &graph);
            let mut paths = Paths::new(board);
            let flow = matching.cost() as u32;
            let apart = Apart::new(&matching, pieces);
            let extra = apart.map_or(0, |apart| {
                connectivity::connectivity(&apart, &matching, pieces, &mut paths)
            });
            control.check()?;
            let cuts = Cuts::Stepwise.bound(&matching, pieces, &mut paths, u64::MAX, control);
            // An interrupted search for cuts gives a lower bound than a completed one.
            control.check()?;
            sum.pieces += pieces;
            sum.flow += flow;
            sum.cover += segments::cover(&need, pieces);
            sum.scattering += segments::scattering(&graph, &need, pieces);
            sum.walk = sum.walk.zip(walk::walk(&graph, pieces)).map(|(sum, walk)| sum + walk);
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
            [self.cover, self.scattering, self.walk.unwrap_or(0), self.connectivity, self.cuts];
        others.into_iter().fold(self.flow, u32::max)
    }
}

#[cfg(test)]
mod tests;
