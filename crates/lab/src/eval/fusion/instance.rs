//! One instance, its target, and the moves and time that each method takes to reach the target.

use std::collections::BTreeMap;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_grid::{Crossings, Layout, LayoutSpec, Path, Region, Start, Zones};
use beadwork_learn::fusion::layer::Layer;
use beadwork_learn::fusion::propose::Proposer;
use beadwork_learn::fusion::walk::{self, Task};
use beadwork_search::anneal::{self, Preset, Settings};
use beadwork_search::{Stop, chains, exact};
use serde::Serialize;

/// An instance with its target.
pub(super) struct Instance {
    pub(super) layout: Layout,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) seed: u64,
    region: Region,
    zones: Zones,
    layer: Layer,
    start: Path,
    /// Crossings of the start path.
    initial: u32,
    /// Fewest crossings that the annealing runs reached.
    target: u32,
    /// The annealing run that reached the target with the fewest moves.
    annealer: Effort,
}

/// The result of one method on one instance.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Effort {
    /// Whether the method reached the target.
    pub(super) reached: bool,
    /// Moves of a walk, including those that were later undone; for the other methods, moves from
    /// the start to the best path.
    pub(super) moves: usize,
    pub(super) seconds: f64,
    /// Crossings of the best path.
    pub(super) crossings: u32,
}

/// The results of all methods on one instance.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    pub(super) layout: &'static str,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) seed: u64,
    pub(super) initial: u32,
    pub(super) target: u32,
    pub(super) methods: BTreeMap<&'static str, Effort>,
}

impl Instance {
    /// The instance of a seed; its target is the best result of `runs` annealing runs.
    ///
    /// # Panics
    /// If `runs` is 0.
    pub(super) fn new(
        layout: Layout,
        (width, height): (u32, u32),
        seed: u64,
        runs: u64,
    ) -> anyhow::Result<Self> {
        let control = &control::cancellable(Threads::One)?;
        let region = Region::rectangle(width, height)?;
        let zones = LayoutSpec::new(layout).zones(&region, seed)?;
        let start = Start::RowZigzag.path(&region, control)?;
        let crossings = Crossings::new(&region, &zones);
        let initial = crossings.count(&start);
        let mut best: Option<Effort> = None;
        for run in 0..runs {
            let begin = Instant::now();
            let settings = Settings::preset(Preset::Paper, run);
            let outcome = anneal::solve(&start, &crossings, &settings, control);
            let seconds = begin.elapsed().as_secs_f64();
            control.check()?;
            let effort = Effort {
                reached: true,
                moves: outcome.moves.len(),
                seconds,
                crossings: outcome.cost as u32,
            };
            let rank = |effort: &Effort| (effort.crossings, effort.moves);
            if best.is_none_or(|best| rank(&effort) < rank(&best)) {
                best = Some(effort);
            }
        }
        let annealer = best.expect("there is at least one run");
        let layer = Layer::new(&region, &zones);
        let target = annealer.crossings;
        Ok(Self {
            layout,
            width,
            height,
            seed,
            region,
            zones,
            layer,
            start,
            initial,
            target,
            annealer,
        })
    }

    /// Runs the methods that are not walks, and adds the results of the two walks.
    pub(super) fn row(&self, fusion: Effort, greedy: Effort) -> anyhow::Result<Row> {
        let control = &control::cancellable(Threads::One)?;
        let crossings = self.layer.crossings();
        let target = Some(i64::from(self.target));
        let begin = Instant::now();
        let settings = Settings { target, ..Settings::preset(Preset::Fast, 0) };
        let fast = anneal::solve(&self.start, crossings, &settings, control);
        let fast = self.effort(fast.moves.len(), begin, fast.cost);
        let begin = Instant::now();
        let settings = chains::Settings { target, ..chains::Settings::default() };
        let chains = chains::solve(&self.start, crossings, &settings, control);
        let chains = self.effort(chains.moves.len(), begin, chains.cost);
        let begin = Instant::now();
        let settings = exact::Settings::default();
        let exact = exact::solve(&self.region, &self.zones, &settings, control)?;
        let exact = self.effort(0, begin, i64::from(crossings.count(&exact.path)));
        control.check()?;
        Ok(Row {
            layout: self.layout.name(),
            width: self.width,
            height: self.height,
            seed: self.seed,
            initial: self.initial,
            target: self.target,
            methods: BTreeMap::from([
                ("annealer", self.annealer),
                ("fast", fast),
                ("chains", chains),
                ("exact", exact),
                ("fusion", fusion),
                ("greedy", greedy),
            ]),
        })
    }

    fn effort(&self, moves: usize, begin: Instant, cost: i64) -> Effort {
        let reached = cost <= i64::from(self.target);
        Effort { reached, moves, seconds: begin.elapsed().as_secs_f64(), crossings: cost as u32 }
    }
}

/// Walks on all instances together, so that the network computes in batches.
///
/// The time is divided among the instances in proportion to their moves.
pub(super) fn walk_all(
    instances: &[Instance],
    proposer: &mut dyn Proposer,
    settings: &walk::Settings<'_>,
    control: &Control<'_>,
) -> anyhow::Result<Vec<Effort>> {
    let mut tasks = Vec::with_capacity(instances.len());
    for Instance { layer, start, target, seed, .. } in instances {
        tasks.push(Task { layer, start, target: *target, seed: *seed });
    }
    let begin = Instant::now();
    let outcomes = walk::solve(&tasks, proposer, settings, control);
    let seconds = begin.elapsed().as_secs_f64();
    control.check()?;
    let all_moves: usize = outcomes.iter().map(|outcome| outcome.total_moves).sum();
    let effort = |outcome: walk::Outcome| {
        let moves = outcome.total_moves;
        Effort {
            reached: outcome.stop == Stop::TargetReached,
            moves,
            seconds: seconds * (moves as f64 / all_moves.max(1) as f64),
            crossings: outcome.crossings,
        }
    };
    Ok(outcomes.into_iter().map(effort).collect())
}
