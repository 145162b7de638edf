//! Better orders of the lines of a plan, layer by layer.

use beadwork_base::Control;
use beadwork_search::Stop;

use super::anneal::{Annealing, Problem, Temperatures, anneal};
use crate::fill::{Draft, Fill, LineSet};
use crate::model::{ModelDraft, PathOf, PositionOf, Screen, ThermalModel};
use crate::plan::{HeatPlan, PlanError, PlanOf, PlannedLayer, layers, printed_layers};
use crate::trials::try_orders;

/// Weight of the time beyond the limit in the cost of an order: an order that takes twice as long
/// as permitted costs this many times as much.
const EXCESS_WEIGHT: f64 = 10.0;

/// Temperatures of annealing with the screen, and with the model, which begins near the end.
const SCREEN_TEMPERATURES: Temperatures = [0.01, 0.0005];
const MODEL_TEMPERATURES: Temperatures = [0.003, 0.0002];

/// Difference between times that are the same but for rounding, s.
const ROUNDING_S: f64 = 1e-9;

/// Odd multipliers that give each layer and each run a seed of its own.
const LAYER_SEED: u64 = 0x9e37_79b9_7f4a_7c15;
const RUN_SEED: u64 = 0xbf58_476d_1ce4_e5b9;

/// The parts of a refinement.
pub(super) struct Refinement<'a, M> {
    /// A print of which nothing is deposited yet.
    pub(super) model: &'a M,
    pub(super) annealing: &'a Annealing,
    /// Cost per second of printing time.
    pub(super) price: f64,
    /// Limit on the printing time of the part, s.
    pub(super) max_seconds: f64,
    pub(super) seed: u64,
}

/// Time of the layers above a layer, as drafted.
struct Above<P> {
    /// Time without travel to where they begin, s.
    seconds: f64,
    /// Where they begin; `None` without voxels above.
    first: Option<P>,
}

impl<M: ThermalModel> Refinement<'_, M> {
    /// Anneals the lines of each layer in turn, within the limit less what the drafts of the layers
    /// above take, and lets the model decide between the results and the draft.
    ///
    /// Drafts within the limit give a plan within the limit.
    /// After an interruption, the other layers stay as drafted.
    pub(super) fn run(
        &self,
        drafts: &[ModelDraft<M>],
        report: impl Fn(usize),
        control: &Control<'_>,
    ) -> Result<PlanOf<M>, PlanError> {
        let above = self.above(drafts);
        let uninterrupted = control.uninterrupted();
        let mut state = self.model.clone();
        let mut planned = Vec::with_capacity(drafts.len());
        let (mut spent, mut deposited_layers, mut stop) = (0.0, 0, Stop::Done);
        for ((layer, is_printed), draft) in layers(self.model.fill()).zip(drafts) {
            report(planned.len());
            if !is_printed {
                planned.push(PlannedLayer::empty());
                continue;
            }
            if let Some(reason) = control.interrupted() {
                stop = reason.into();
            }
            let mut orders = vec![draft.clone()];
            if !stop.is_interrupted() {
                let left = self.max_seconds - spent;
                let above = &above[planned.len()];
                orders.extend(self.annealed(&state, layer, draft, left, above, control)?);
            }
            let paths: Vec<&PathOf<M>> = orders.iter().map(|draft| &draft.path).collect();
            let seconds = |index: usize| state.path_seconds(layer, paths[index]);
            let score = |index: usize, cost: f64| cost + self.price * seconds(index);
            let trials = try_orders(&state, layer, &paths, 1, score, &uninterrupted)?;
            deposited_layers += paths.len();
            let best = trials.best.into_iter().next().expect("the draft has a cost");
            let seconds = seconds(best.index);
            spent += seconds;
            let Draft { path, name } = orders.swap_remove(best.index);
            planned.push(PlannedLayer { path, order: name, seconds, cost: best.cost });
            state = best.model;
        }
        Ok(HeatPlan { layers: planned, stop, deposited_layers })
    }

    /// The results of the annealing runs of a layer that leave the layers above enough of the
    /// `left` seconds.
    fn annealed(
        &self,
        state: &M,
        layer: u32,
        draft: &ModelDraft<M>,
        left: f64,
        above: &Above<PositionOf<M>>,
        control: &Control<'_>,
    ) -> Result<Vec<ModelDraft<M>>, PlanError> {
        let (fill, from) = (self.model.fill(), state.position());
        let lines = fill.lines(layer, draft.name);
        let start = lines.start(from);
        let screen = state.screen(layer).ok_or(PlanError::NoScreen)?;
        let excess = |path: &PathOf<M>, seconds: f64| {
            let end = fill.ends(layer, path).map(|[_, end]| end);
            let travel = end.zip(above.first).map_or(0.0, |(a, b)| fill.travel_seconds(a, b));
            seconds + above.seconds + travel - left
        };
        // What an order costs, if temperatures alone cost `heat`.
        let with_time = |path: &PathOf<M>, heat: f64| {
            let seconds = state.path_seconds(layer, path);
            let excess = excess(path, seconds).max(0.0) / seconds;
            heat * (1.0 + EXCESS_WEIGHT * excess) + self.price * seconds
        };
        let on_screen = |order: &[usize]| {
            let path = lines.path(order, from);
            with_time(&path, screen.cost(&path))
        };
        let layers = printed_layers(fill);
        let screened = Problem {
            start: &start,
            tail: tail(&lines, &start, self.annealing.tail_s),
            trials: self.annealing.trials_per_layer(layers),
            temperatures: SCREEN_TEMPERATURES,
            cost: &on_screen,
        };
        let trials = self.annealing.model_trials_per_layer(layers);
        let seed = self.seed ^ u64::from(layer).wrapping_mul(LAYER_SEED);
        let run = |run: usize| {
            let seed = seed ^ (run as u64).wrapping_mul(RUN_SEED);
            let own = control.on_one_thread();
            let order = anneal(&screened, seed, &own);
            let tail = tail(&lines, &order, self.annealing.model_tail_s);
            if trials == 0 || tail < 2 {
                return lines.path(&order, from);
            }
            let (begin, _) = order.split_at(order.len() - tail);
            let mut before = state.clone();
            let uninterrupted = own.uninterrupted();
            let print =
                |model: &mut M, path: &PathOf<M>| model.deposit_lines(layer, path, &uninterrupted);
            if print(&mut before, &lines.path(begin, from)).is_err() {
                return lines.path(&order, from);
            }
            let limit = state.path_seconds(layer, &lines.path(&order, from)) + ROUNDING_S;
            let on_model = |order: &[usize]| {
                let path = lines.path(order, from);
                // Most orders take longer, and few of them are worth it.
                if state.path_seconds(layer, &path) > limit {
                    return f64::INFINITY;
                }
                let mut model = before.clone();
                let rest = lines.rest(&order[begin.len()..], before.position());
                // An order that cannot be deposited is reported when it is chosen, so it is not.
                let heat = print(&mut model, &rest).unwrap_or(f64::INFINITY);
                with_time(&path, heat)
            };
            let start = &order[..];
            let temperatures = MODEL_TEMPERATURES;
            let problem = Problem { start, tail, trials, temperatures, cost: &on_model };
            lines.path(&anneal(&problem, !seed, &own), from)
        };
        let results = control.threads.map_numbers(self.annealing.runs, run);
        let fits = |path: &PathOf<M>| excess(path, state.path_seconds(layer, path)) <= 0.0;
        Ok(results.into_iter().filter(fits).map(|path| Draft { path, name: None }).collect())
    }

    /// For each layer, what the drafts above it take.
    fn above(&self, drafts: &[ModelDraft<M>]) -> Vec<Above<PositionOf<M>>> {
        let fill = self.model.fill();
        let mut above = Vec::with_capacity(drafts.len());
        let (mut seconds, mut first) = (0.0, None);
        for (layer, draft) in (0..drafts.len() as u32).zip(drafts).rev() {
            above.push(Above { seconds, first });
            if let Some([begin, end]) = fill.ends(layer, &draft.path) {
                seconds += first.map_or(0.0, |first| fill.travel_seconds(end, first));
                seconds += fill.seconds(layer, None, &draft.path);
                first = Some(begin);
            }
        }
        above.reverse();
        above
    }
}

/// Number of lines at the end of an order that take the given time.
fn tail(lines: &impl LineSet, order: &[usize], seconds: f64) -> usize {
    let mut left = seconds;
    let is_inside = |&&line: &&usize| {
        let is_inside = left > 0.0;
        left -= lines.seconds(line);
        is_inside
    };
    order.iter().rev().take_while(is_inside).count()
}
