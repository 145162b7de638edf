//! Plans of whole parts, and what is proven about them.

use beadwork_grid::Path;

use crate::plan::{FixedOrder, ToolOrder};

/// How a layer is printed.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LayerPlan {
    /// The path of the layer: every cell once, piece after piece.
    /// Where a piece of the cover happens to end next to the beginning of the following one, the
    /// path joins both.
    pub path: Path,
    /// Whether pieces cross zone borders.
    pub is_continuous: bool,
    /// Number of pieces of the cover that the path is made of; each lies in one zone unless the
    /// layer is continuous.
    pub pieces: u32,
    /// Proven lower bound of the number of pieces of a cover of this kind.
    pub piece_bound: u32,
    /// Number of steps of the path between two zones.
    pub crossings: u32,
    /// Only for a continuous layer: cost of the crossings within its pieces, and a proven lower
    /// bound of that cost for covers with this number of pieces, in the unit of the tool costs.
    pub crossing_cost: Option<[f64; 2]>,
    /// Number of links in common with the path of the layer below; `None` for the first layer.
    pub kept_links: Option<u32>,
}

impl LayerPlan {
    /// Number of lifts between the pieces of the path.
    pub fn lifts(&self) -> u32 {
        self.path.pieces() - 1
    }

    /// Whether it is proven that no cover of this kind has fewer pieces, or the same number of
    /// pieces and cheaper crossings.
    pub fn is_optimal(&self) -> bool {
        self.pieces == self.piece_bound
            && self.crossing_cost.is_none_or(|[cost, bound]| cost <= bound)
    }
}

/// A point on the frontier of lifts against tool costs.
/// Lifts are counted before the paths join pieces that happen to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrontierPoint {
    /// Number of lifts of the whole part.
    pub lifts: u64,
    /// Cost of the tool changes of the whole part.
    pub tool_cost: f64,
    /// The highest cost of a lift, in the unit of the tool costs, at which this point is among the
    /// cheapest; `None` if there is no such limit.
    pub up_to_lift_cost: Option<f64>,
}

/// A plan of a whole part, and what is proven about it.
///
/// Costs are in the unit of the cost matrix; if that rounds costs, they are sums of rounded costs.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ToolPlan {
    /// The layers, from the bottom up.
    pub layers: Vec<LayerPlan>,
    /// The tool in the nozzle before the print, if it is known.
    pub loaded: Option<u8>,
    /// The tools in the order of their use over the whole part.
    pub visits: Vec<u8>,
    /// Cost of all tool changes.
    pub tool_cost: f64,
    /// Number of lifts within layers.
    pub lifts: u64,
    /// The cheapest order of the tools if no piece crossed a zone border, for comparison.
    /// Its [`bound`](ToolOrder::bound) and [`min_changes`](ToolOrder::min_changes) hold for the
    /// tool changes of **every** plan, whatever its mode.
    pub order: ToolOrder,
    /// Cost of printing the tools of every layer in ascending order, for comparison.
    pub fixed: FixedOrder,
    /// Lifts against tool costs, from few lifts to low tool costs, up to 256 points; a single point
    /// unless the mode is [`Mode::Cheapest`](super::Mode::Cheapest).
    pub frontier: Vec<FrontierPoint>,
}

impl ToolPlan {
    /// Number of tool changes, including the one from the loaded tool.
    pub fn tool_changes(&self) -> u64 {
        let begin = self.loaded.is_some_and(|loaded| self.visits.first() != Some(&loaded));
        self.visits.len().saturating_sub(1) as u64 + u64::from(begin)
    }

    /// Cost of tool changes and lifts.
    pub fn cost(&self, lift_cost: f64) -> f64 {
        self.tool_cost + lift_cost * self.lifts as f64
    }
}
