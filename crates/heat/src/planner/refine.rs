//! Better orders of the lines of a plan, layer by layer.

use beadwork_base::Control;
use beadwork_grid::{Cell, Region};
use beadwork_part::{Axis, Corner, Ends, LineOrder, Lines, Order, Sequence};
use beadwork_search::Stop;

use super::anneal::{Annealing, Problem, anneal};
use crate::model::{Screen, ThermalModel, order_seconds};
use crate::plan::{Draft, HeatPlan, PlanError, PlannedLayer};
use crate::trials::try_orders;

/// Lines to anneal where the draft of a layer is a pattern.
const DEFAULT_LINES: LineOrder =
    LineOrder { sequence: Sequence::Golden, axis: Axis::X, corner: Corner::MinXMinY };

/// Weight of the time beyond the limit in the cost of an order: an order that takes twice as long
/// as permitted costs this many times as much.
const EXCESS_WEIGHT: f64 = 10.0;

/// Odd multipliers that give each layer and each run a seed of its own.
const LAYER_SEED: u64 = 0x9e37_79b9_7f4a_7c15;
const RUN_SEED: u64 = 0xbf58_476d_1ce4_e5b9;

/// The parts of a refinement.
pub(super) struct Refinement<'a, M> {
    /// A print of which nothing is deposited yet.
    pub(super) model: &'a M,
    pub(super) annealing: &'a Annealing,
    pub(super) regions: &'a [Option<Region>],
    /// Cost per second of printing time.
    pub(super) price: f64,
    /// Limit on the printing time of the part, s.
    pub(super) max_seconds: f64,
    pub(super) seed: u64,
}

/// Time of the layers above a layer, as drafted.
struct Above {
    /// Time without travel to the first cell, s.
    seconds: f64,
    /// The layer of that cell, and the cell; `None` without cells above.
    first: Option<(u32, Cell)>,
}

impl<M: ThermalModel> Refinement<'_, M> {
    /// Anneals the lines of each layer in turn, within the limit less what the drafts of the layers
    /// above take, and lets the model decide between the results and the draft.
    ///
    /// Drafts within the limit give a plan within the limit.
    /// After an interruption, the other layers stay as drafted.
    pub(super) fn run(
        &self,
        drafts: &[Draft],
        report: impl Fn(usize),
        control: &Control<'_>,
    ) -> Result<HeatPlan, PlanError> {
        let above = self.above(drafts);
        let uninterrupted = control.uninterrupted();
        let mut state = self.model.clone();
        let mut layers = Vec::with_capacity(drafts.len());
        let (mut spent, mut deposited_layers, mut stop) = (0.0, 0, Stop::Done);
        for (layer, draft) in (0..).zip(drafts) {
            report(layers.len());
            let Some(region) = &self.regions[layers.len()] else {
                layers.push(PlannedLayer::EMPTY);
                continue;
            };
            if let Some(reason) = control.interrupted() {
                stop = reason.into();
            }
            let mut orders = vec![draft.clone()];
            if !stop.is_interrupted() {
                let left = self.max_seconds - spent;
                let above = &above[layers.len()];
                orders.extend(self.annealed(&state, layer, region, draft, left, above, control)?);
            }
            let cells: Vec<&[Cell]> = orders.iter().map(|draft| &draft.cells[..]).collect();
            let seconds = |index: usize| state.order_seconds(layer, cells[index]);
            let score = |index: usize, cost: f64| cost + self.price * seconds(index);
            let trials = try_orders(&state, layer, &cells, 1, score, &uninterrupted)?;
            deposited_layers += cells.len();
            let best = trials.best.into_iter().next().expect("the draft has a cost");
            let seconds = seconds(best.index);
            spent += seconds;
            let Draft { cells, order } = orders.swap_remove(best.index);
            layers.push(PlannedLayer { cells, order, seconds, cost: best.cost });
            state = best.model;
        }
        Ok(HeatPlan { layers, stop, deposited_layers })
    }

    /// The results of the annealing runs of a layer that leave the layers above enough of the
    /// `left` seconds.
    #[expect(clippy::too_many_arguments, reason = "what is known of one layer")]
    fn annealed(
        &self,
        state: &M,
        layer: u32,
        region: &Region,
        draft: &Draft,
        left: f64,
        above: &Above,
        control: &Control<'_>,
    ) -> Result<Vec<Draft>, PlanError> {
        let named = match draft.order {
            Some(Order::Lines(lines)) => lines,
            _ => DEFAULT_LINES,
        };
        let ends = Ends::Nearest { from: state.last_cell() };
        let lines = named.lines(region);
        let start = lines.permutation(named.sequence, ends);
        let screen = state.screen(layer).ok_or(PlanError::NoScreen)?;
        let excess =
            |cells: &[Cell], seconds: f64| seconds + self.above_seconds(above, cells) - left;
        let cost = |cells: &[Cell]| {
            let seconds = state.order_seconds(layer, cells);
            let excess = excess(cells, seconds).max(0.0) / seconds;
            screen.cost(cells) * (1.0 + EXCESS_WEIGHT * excess) + self.price * seconds
        };
        let problem = Problem {
            lines: &lines,
            start: &start,
            tail: self.tail(&lines, &start),
            ends,
            trials: self.annealing.trials_per_layer(self.regions.iter().flatten().count()),
            cost: &cost,
        };
        let seed = self.seed ^ u64::from(layer).wrapping_mul(LAYER_SEED);
        let run = |run: usize| {
            let seed = seed ^ (run as u64).wrapping_mul(RUN_SEED);
            lines.flatten(&anneal(&problem, self.annealing, seed, control), ends)
        };
        let results = control.threads.map_numbers(self.annealing.runs, run);
        let fits = |cells: &Vec<Cell>| excess(cells, state.order_seconds(layer, cells)) <= 0.0;
        Ok(results.into_iter().filter(fits).map(|cells| Draft { cells, order: None }).collect())
    }

    /// Number of lines at the end of an order that are printed in [`Annealing::tail_s`].
    fn tail(&self, lines: &Lines, order: &[usize]) -> usize {
        let cell_s = self.model.part().frame.cell_mm / self.model.process().print_mm_s;
        let mut left = self.annealing.tail_s;
        let is_inside = |&&line: &&usize| {
            let is_inside = left > 0.0;
            left -= lines.line(line).len() as f64 * cell_s;
            is_inside
        };
        order.iter().rev().take_while(is_inside).count()
    }

    /// For each layer, what the drafts above it take.
    fn above(&self, drafts: &[Draft]) -> Vec<Above> {
        let mut above: Vec<Above> = Vec::with_capacity(drafts.len());
        let (mut seconds, mut first): (f64, Option<(u32, Cell)>) = (0.0, None);
        for (layer, draft) in (0..drafts.len() as u32).zip(drafts).rev() {
            above.push(Above { seconds, first });
            if let (Some(&begin), Some(&end)) = (draft.cells.first(), draft.cells.last()) {
                seconds += self.travel_s(end, first) + self.seconds(layer, None, &draft.cells);
                first = Some((layer, begin));
            }
        }
        above.reverse();
        above
    }

    /// Time of the layers above after an order of a layer, s.
    fn above_seconds(&self, above: &Above, cells: &[Cell]) -> f64 {
        above.seconds + cells.last().map_or(0.0, |&last| self.travel_s(last, above.first))
    }

    /// Time of travel from a cell to the first cell of the layers above, s.
    fn travel_s(&self, from: Cell, first: Option<(u32, Cell)>) -> f64 {
        first.map_or(0.0, |(layer, cell)| {
            self.seconds(layer, Some(from), &[cell]) - self.seconds(layer, None, &[cell])
        })
    }

    fn seconds(&self, layer: u32, from: Option<Cell>, cells: &[Cell]) -> f64 {
        order_seconds(self.model.part(), self.model.process(), layer, from, cells)
    }
}
