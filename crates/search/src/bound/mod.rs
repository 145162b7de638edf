//! Proven lower bounds.
//!
//! Each bound is a function of its own, with its proof, in a module of its own; [`Bounds`] has them
//! all for one layer.

pub(crate) mod connectivity;
pub(crate) mod cuts;
pub(crate) mod flow;
pub(crate) mod segments;
pub(crate) mod walk;

use beadwork_grid::{Region, Zones, zone_components};

use crate::ZoneCosts;
use crate::matching::{Board, Paths, ZoneGraph};
use crate::stop::Interrupt;
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

/// Lower bounds of one layer: of its pieces, and of the crossings of any cover in so many.
///
/// Sums over the connected parts of the region.
/// `None` means that a bound was not to be had in reasonable time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Pieces: half of what the cells of a maximum 2-matching lack, but at least 1, in each part.
    pub pieces: u32,
    /// Crossings of the cheapest 2-matching with cells - pieces links.
    pub flow: u32,
    /// Segments that the zone components need at least, minus pieces.
    pub cover: u32,
    /// The same without hubs: what falls apart must be visited piece by piece.
    pub scattering: u32,
    /// Steps of the shortest walks through all zone components, up to 13 in each part.
    pub walk: Option<u32>,
    /// The flow's, and what it costs to leave what no cheapest 2-matching leaves.
    pub connectivity: u32,
    /// The flow's with weights on closed sets of cells.
    pub cuts: u32,
}

impl Bounds {
    /// All bounds of a layer.
    /// The flow is nearly linear in the cells; the walk is exponential in the zone components up to
    /// its limit, the scattering quadratic in them, and the last two search for each link along a
    /// border.
    ///
    /// # Panics
    /// If the zones were made for a plane of another size, or a cell of the region has none.
    pub fn new(region: &Region, zones: &Zones) -> Self {
        let costs = ZoneCosts::uniform(zones.count());
        let boards = Board::of_parts(region, zones, &costs);
        let mut sum = Self {
            pieces: 0,
            flow: 0,
            cover: 0,
            scattering: 0,
            walk: Some(0),
            connectivity: 0,
            cuts: 0,
        };
        for board in &boards {
            let (matching, pieces) = flow::flow(board);
            let graph = ZoneGraph::new(board);
            let need = flow::need(board, &graph);
            let mut paths = Paths::new(board);
            let flow = matching.cost() as u32;
            let apart = Apart::new(&matching, pieces);
            let extra = apart.map_or(0, |apart| {
                connectivity::connectivity(&apart, &matching, pieces, &mut paths)
            });
            let cuts =
                Cuts::Stepwise.bound(&matching, pieces, &mut paths, u64::MAX, Interrupt::default());
            sum.pieces += pieces;
            sum.flow += flow;
            sum.cover += segments::cover(&need, pieces);
            sum.scattering += segments::scattering(&graph, &need, pieces);
            sum.walk = sum.walk.zip(walk::walk(&graph, pieces)).map(|(sum, walk)| sum + walk);
            sum.connectivity += flow + extra;
            sum.cuts += cuts as u32;
        }
        sum
    }

    /// The greatest of the bounds of the crossings.
    pub fn crossings(&self) -> u32 {
        let others =
            [self.cover, self.scattering, self.walk.unwrap_or(0), self.connectivity, self.cuts];
        others.into_iter().fold(self.flow, u32::max)
    }
}

#[cfg(test)]
mod tests;
