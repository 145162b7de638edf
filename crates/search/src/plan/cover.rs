//! The pieces of one layer: with as few of them as can be, or with none across zones.

use std::sync::atomic::AtomicBool;

use beadwork_grid::{Cell, Path, Region, Zones};

use crate::ZoneCosts;
use crate::exact::{self, SolveError};

/// A layer of a part. The number of a cell's zone is that of the tool that prints it.
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

/// Pieces that hold every cell of a layer once, and how good they are.
#[derive(Clone, Debug)]
pub(super) struct Cover {
    pub(super) path: Path,
    /// Pieces that any cover of its kind has at least.
    pub(super) piece_bound: u32,
    /// Cost of its crossings, and what those of any cover in so many pieces cost at least.
    pub(super) cost: u64,
    pub(super) bound: u64,
}

impl Cover {
    /// Fewest pieces, then cheapest crossings.
    pub(super) fn continuous(
        layer: LayerRef<'_>,
        costs: &ZoneCosts,
        below: Option<&Path>,
        effort: Effort<'_>,
    ) -> Result<Self, SolveError> {
        let settings = exact::Settings {
            seed: effort.seed,
            attempts: effort.attempts,
            columns_first: effort.columns_first,
            costs: Some(costs),
            below,
            cancel: effort.cancel,
            ..exact::Settings::default()
        };
        let exact::Plan { path, piece_bound, cost, bound, .. } =
            exact::solve(layer.region, layer.zones, &settings)?;
        Ok(Self { path, piece_bound, cost, bound })
    }

    /// Fewest pieces, none of them across zones.
    pub(super) fn by_zones(
        layer: LayerRef<'_>,
        below: Option<&Path>,
        effort: Effort<'_>,
    ) -> Result<Self, SolveError> {
        let LayerRef { region, zones } = layer;
        let mut order: Vec<Cell> = Vec::with_capacity(region.cell_count() as usize);
        let mut piece_bound = 0;
        for tool in tools(layer) {
            let inside = zones.ids().iter().map(|&id| id == tool).collect();
            let zone =
                Region::from_mask(region.width(), region.height(), inside).expect("the zone has cells");
            let alone = Zones::new(&zone, vec![0; zone.plane_len()]).expect("each cell has a zone");
            let settings = exact::Settings {
                seed: effort.seed,
                attempts: effort.attempts,
                columns_first: effort.columns_first,
                below,
                cancel: effort.cancel,
                ..exact::Settings::default()
            };
            let plan = exact::solve(&zone, &alone, &settings)?;
            order.extend(plan.path.order());
            piece_bound += plan.piece_bound;
        }
        let path = Path::in_pieces(region, order).expect("the zones hold every cell once");
        Ok(Self { path, piece_bound, cost: 0, bound: 0 })
    }

    /// Its pieces, cut where they cross zones if `whole` is false: there two pieces only happen to meet.
    pub(super) fn pieces(&self, zones: &Zones, whole: bool) -> Vec<&[Cell]> {
        let pieces = self.path.iter_pieces();
        if whole {
            return pieces.collect();
        }
        pieces.flat_map(|piece| piece.chunk_by(|&a, &b| zones.id(a) == zones.id(b))).collect()
    }
}

/// The tools of a layer, rising.
pub(super) fn tools(layer: LayerRef<'_>) -> Vec<u8> {
    let mut is_used = [false; 256];
    layer.region.cells().for_each(|cell| is_used[usize::from(layer.zones.id(cell))] = true);
    (0..=u8::MAX).filter(|&tool| is_used[usize::from(tool)]).collect()
}
