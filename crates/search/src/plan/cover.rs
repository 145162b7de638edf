//! The pieces of one layer: with as few of them as can be, or with none across zones.

use std::sync::atomic::AtomicBool;

use beadwork_base::Control;
use beadwork_grid::{Cell, Path, Region, Zones};

use super::ToolCosts;
use crate::exact::{self, SolveError};
use crate::stop::is_cancelled;
use crate::{ZoneCosts, ZoneCostsError};

/// A layer of a part.
/// The number of a cell's zone is that of the tool that prints it.
#[derive(Clone, Copy, Debug)]
pub struct LayerRef<'a> {
    /// Its cells.
    pub region: &'a Region,
    /// Their tools.
    pub zones: &'a Zones,
}

/// How covers are sought.
#[derive(Clone, Copy)]
pub(super) struct Effort<'a> {
    pub(super) seed: u64,
    pub(super) attempts: u32,
    /// Whether straight stretches run along the columns rather than the rows.
    pub(super) columns_first: bool,
    pub(super) cancel: Option<&'a AtomicBool>,
}

/// What crossings cost, for the exact search.
pub(super) struct CrossingCosts {
    costs: ZoneCosts,
    /// What a cost of 1 stands for.
    unit: u64,
}

impl CrossingCosts {
    /// The costs of tool changes: 1 each if all cost the same, which the search is faster with.
    pub(super) fn new(costs: &ToolCosts) -> Result<Self, ZoneCostsError> {
        let count = costs.tools() as u8;
        let pairs = || (0..count).flat_map(|from| (0..count).map(move |to| (from, to)));
        let mut changes =
            pairs().filter(|(from, to)| from != to).map(|(from, to)| costs.cost(from, to));
        let first = changes.next().unwrap_or(1);
        if first > 0 && changes.all(|cost| cost == first) {
            return Ok(Self { costs: ZoneCosts::uniform(count.into()), unit: first.into() });
        }
        let all = pairs().map(|(from, to)| costs.cost(from, to)).collect();
        Ok(Self { costs: ZoneCosts::new(count.into(), all)?, unit: 1 })
    }
}

/// Pieces that hold every cell of a layer once, and how good they are.
#[derive(Clone, Debug)]
pub(super) struct Cover {
    /// The pieces one after the other; where two of different zones happen to meet, the path has
    /// one less.
    pub(super) path: Path,
    pub(super) pieces: u32,
    /// Pieces that any cover of its kind has at least.
    pub(super) piece_bound: u32,
    /// Cost of its crossings, in the unit of the tool costs, in the direction of the path.
    pub(super) cost: u64,
    /// What those of any cover in so many pieces cost at least.
    pub(super) bound: u64,
    is_continuous: bool,
}

impl Cover {
    /// Fewest pieces, then cheapest crossings.
    pub(super) fn continuous(
        layer: LayerRef<'_>,
        costs: &CrossingCosts,
        below: Option<&Path>,
        effort: Effort<'_>,
    ) -> Result<Self, SolveError> {
        let settings = exact::Settings { costs: Some(&costs.costs), ..effort.settings(below) };
        let plan = effort.solve(layer.region, layer.zones, &settings)?;
        let exact::Outcome { path, pieces, piece_bound, cost, bound, .. } = plan;
        let (cost, bound) = (cost * costs.unit, bound * costs.unit);
        Ok(Self { path, pieces, piece_bound, cost, bound, is_continuous: true })
    }

    /// Fewest pieces, none of them across zones.
    pub(super) fn by_zones(
        layer: LayerRef<'_>,
        below: Option<&Path>,
        effort: Effort<'_>,
    ) -> Result<Self, SolveError> {
        let LayerRef { region, zones } = layer;
        let mut order: Vec<Cell> = Vec::with_capacity(region.cell_count() as usize);
        let (mut pieces, mut piece_bound) = (0, 0);
        for tool in tools(layer) {
            let inside = zones.ids().iter().map(|&id| id == tool).collect();
            let zone = Region::from_mask(region.width(), region.height(), inside)
                .expect("the zone has cells");
            let alone = Zones::new(&zone, vec![0; zone.grid_len()]).expect("each cell has a zone");
            let plan = effort.solve(&zone, &alone, &effort.settings(below))?;
            order.extend(plan.path.order());
            pieces += plan.pieces;
            piece_bound += plan.piece_bound;
        }
        let path = Path::in_pieces(region, order).expect("the zones hold every cell once");
        Ok(Self { path, pieces, piece_bound, cost: 0, bound: 0, is_continuous: false })
    }

    /// Its pieces.
    pub(super) fn pieces(&self, zones: &Zones) -> Vec<&[Cell]> {
        let pieces = self.path.iter_pieces();
        if self.is_continuous {
            return pieces.collect();
        }
        pieces.flat_map(|piece| piece.chunk_by(|&a, &b| zones.id(a) == zones.id(b))).collect()
    }
}

impl<'a> Effort<'a> {
    fn settings(self, below: Option<&'a Path>) -> exact::Settings<'a> {
        let Self { seed, attempts, columns_first, .. } = self;
        exact::Settings { seed, attempts, columns_first, below, ..exact::Settings::default() }
    }

    fn solve(
        self,
        region: &Region,
        zones: &Zones,
        settings: &exact::Settings<'_>,
    ) -> Result<exact::Outcome, SolveError> {
        let is_cancelled = || is_cancelled(self.cancel);
        let control = Control { time_is_up: Some(&is_cancelled), ..Control::default() };
        exact::solve(region, zones, settings, &control)
    }
}

/// The tools of a layer, rising.
pub(super) fn tools(layer: LayerRef<'_>) -> Vec<u8> {
    let mut is_used = [false; 256];
    layer.region.cells().for_each(|cell| is_used[usize::from(layer.zones.id(cell))] = true);
    (0..=u8::MAX).filter(|&tool| is_used[usize::from(tool)]).collect()
}
