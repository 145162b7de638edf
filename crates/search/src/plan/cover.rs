//! Covers of one layer with as few pieces as possible, which either cross zone borders or stay
//! within zones.

use beadwork_base::Control;
use beadwork_grid::{Cell, Path, Region, Zones};

use crate::CostMatrix;
use crate::exact::{self, Outcome, SolveError};

/// A layer of a part.
/// The number of a cell's zone is the number of the tool that prints it.
#[derive(Clone, Copy, Debug)]
pub struct LayerRef<'a> {
    /// The cells of the layer.
    pub region: &'a Region,
    /// The tools of the cells.
    pub zones: &'a Zones,
}

/// How covers are searched for.
#[derive(Clone, Copy)]
pub(super) struct Effort<'a> {
    pub(super) seed: u64,
    pub(super) attempts: u32,
    /// Whether straight runs should follow the columns instead of the rows.
    pub(super) columns_first: bool,
    pub(super) control: Control<'a>,
}

/// Costs of crossings for the exact search.
pub(super) struct SearchCosts<'a> {
    tool_costs: &'a CostMatrix,
    /// The cost 1 for each crossing, if all tool changes cost the same: the search is faster with
    /// it.
    uniform: Option<CostMatrix>,
    /// Scaled tool cost of a unit of the search's costs.
    unit: u64,
}

impl<'a> SearchCosts<'a> {
    pub(super) fn new(tool_costs: &'a CostMatrix) -> Self {
        let count = tool_costs.size() as u8;
        let pairs = (0..count).flat_map(|from| (0..count).map(move |to| (from, to)));
        let mut changes = pairs
            .filter(|(from, to)| from != to)
            .map(|(from, to)| u64::from(tool_costs.scaled(from, to)));
        let first = changes.next().unwrap_or(1);
        if first > 0 && changes.all(|cost| cost == first) {
            let uniform = Some(CostMatrix::uniform(count.into()));
            return Self { tool_costs, uniform, unit: first };
        }
        Self { tool_costs, uniform: None, unit: 1 }
    }

    fn costs(&self) -> &CostMatrix {
        self.uniform.as_ref().unwrap_or(self.tool_costs)
    }

    /// A sum of the search's costs as a scaled tool cost.
    fn scaled(&self, sum: f64) -> u64 {
        self.costs().rescaled(sum) * self.unit
    }
}

/// Pieces that together hold every cell of a layer once, and lower bounds on their number and cost.
#[derive(Clone, Debug)]
pub(super) struct Cover {
    /// The pieces one after the other.
    /// Where one piece happens to end next to the start of the following one, the path counts both
    /// as one piece.
    pub(super) path: Path,
    pub(super) pieces: u32,
    /// Proven minimum number of pieces of a cover of this kind.
    pub(super) piece_bound: u32,
    /// Scaled tool cost of the crossings, in the direction of the path.
    pub(super) cost: u64,
    /// Proven minimum of that cost for a cover with this number of pieces.
    pub(super) bound: u64,
    is_continuous: bool,
}

impl Cover {
    /// A cover with the fewest pieces, and of those with the cheapest crossings.
    pub(super) fn continuous(
        layer: LayerRef<'_>,
        costs: &SearchCosts<'_>,
        below: Option<&Path>,
        effort: Effort<'_>,
    ) -> Result<Self, SolveError> {
        let outcome = effort.solve(layer.region, layer.zones, Some(costs.costs()), below)?;
        let Outcome { path, pieces, piece_bound, cost, bound, .. } = outcome;
        let (cost, bound) = (costs.scaled(cost), costs.scaled(bound));
        Ok(Self { path, pieces, piece_bound, cost, bound, is_continuous: true })
    }

    /// A cover with the fewest pieces that cross no zone border.
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
            let one_zone =
                Zones::new(&zone, vec![0; zone.grid_len()]).expect("each cell has a zone");
            let outcome = effort.solve(&zone, &one_zone, None, below)?;
            order.extend(outcome.path.order());
            pieces += outcome.pieces;
            piece_bound += outcome.piece_bound;
        }
        let path = Path::in_pieces(region, order).expect("the zones hold every cell once");
        Ok(Self { path, pieces, piece_bound, cost: 0, bound: 0, is_continuous: false })
    }

    /// Its pieces, each of which lies in one zone unless the cover is continuous.
    pub(super) fn pieces(&self, zones: &Zones) -> Vec<&[Cell]> {
        let pieces = self.path.iter_pieces();
        if self.is_continuous {
            return pieces.collect();
        }
        pieces.flat_map(|piece| piece.chunk_by(|&a, &b| zones.id(a) == zones.id(b))).collect()
    }
}

impl Effort<'_> {
    fn solve(
        &self,
        region: &Region,
        zones: &Zones,
        costs: Option<&CostMatrix>,
        below: Option<&Path>,
    ) -> Result<Outcome, SolveError> {
        let &Self { seed, attempts, columns_first, ref control } = self;
        let settings = exact::Settings {
            seed,
            attempts,
            costs,
            columns_first,
            below,
            ..exact::Settings::default()
        };
        exact::solve(region, zones, &settings, control)
    }
}

/// The tools of a layer, in ascending order.
pub(super) fn tools(layer: LayerRef<'_>) -> Vec<u8> {
    let mut is_used = [false; 256];
    layer.region.cells().for_each(|cell| is_used[usize::from(layer.zones.id(cell))] = true);
    (0..=u8::MAX).filter(|&tool| is_used[usize::from(tool)]).collect()
}
