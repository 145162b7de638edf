//! Replays recorded moves, stops runs early, and anneals with another cost.

use std::sync::Mutex;

use beadwork_base::CancelToken;
use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start, Switch, Zones, cover, verify};
use proptest::prelude::*;

use super::*;
use crate::Stop;

fn instance(width: u32, height: u32, layout: Layout, seed: u64) -> (Region, Zones, Crossings) {
    let region = Region::rectangle(width, height).unwrap();
    let mut spec = LayoutSpec::new(layout);
    spec.side = 3;
    let zones = spec.zones(&region, seed).unwrap();
    let crossings = Crossings::new(&region, &zones);
    (region, zones, crossings)
}

fn run<C: Cost>(start: &Path, cost: &C, settings: &Settings<'_>) -> Outcome {
    solve(start, cost, settings, &Control::default())
}

/// A preset's method with fewer proposals, so that a test can run it often.
fn shortened(preset: Preset) -> Method {
    match preset.method() {
        Method::Pooled(pooled) => Method::Pooled(pooled),
        Method::Free(free) => Method::Free(Free { proposals: 30_000, ..free }),
    }
}

/// Crossings counted along a path.
fn count_crossings(order: &[u32], zones: &Zones, region: &Region) -> i64 {
    let crossing =
        |step: &&[u32]| region.adjacent(step[0], step[1]) && zones.id(step[0]) != zones.id(step[1]);
    order.windows(2).filter(crossing).count() as i64
}

/// Replays the recorded moves one by one, counting the crossings after each, and compares the
/// result with the outcome.
fn check(outcome: &Outcome, start: &Path, region: &Region, zones: &Zones) {
    let mut path = start.clone();
    let mut best = outcome.initial;
    assert_eq!(count_crossings(path.order(), zones, region), outcome.initial);
    for (index, step) in outcome.moves.iter().enumerate() {
        assert!(step.apply(&mut path), "move {index} of the record applies");
        best = best.min(count_crossings(path.order(), zones, region));
    }
    assert_eq!(path, outcome.path, "the record leads to the best path");
    assert_eq!(verify(region, path.order()), Ok(start.pieces()));
    assert_eq!((count_crossings(path.order(), zones, region), best), (outcome.cost, outcome.cost));
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn records_replay_to_the_best_path(
        width in 1_u32..24,
        height in 1_u32..24,
        seed: u64,
        preset in prop::sample::select(&Preset::ALL[..]),
        layout in prop::sample::select(vec![
            Layout::LeftRight,
            Layout::Checkerboard,
            Layout::TopBottom,
        ]),
    ) {
        let (region, zones, crossings) = instance(width, height, layout, seed);
        let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
        let settings = Settings { method: shortened(preset), ..Settings::preset(preset, seed) };
        let outcome = run(&start, &crossings, &settings);
        check(&outcome, &start, &region, &zones);
        let again = run(&start, &crossings, &settings);
        prop_assert_eq!((again.moves, again.accepted), (outcome.moves, outcome.accepted));
    }

    #[test]
    fn paths_in_pieces_are_annealed_too(
        seed: u64,
        holes in prop::collection::vec(0_usize..300, 1..60),
    ) {
        let mut inside = vec![true; 20 * 15];
        holes.iter().for_each(|&hole| inside[hole] = false);
        let region = Region::from_mask(20, 15, inside).unwrap();
        let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
        let start = cover(&region, &Control::default()).unwrap();
        for preset in [Preset::Short, Preset::Fast] {
            let settings = Settings { method: shortened(preset), ..Settings::preset(preset, seed) };
            let outcome = run(&start, &Crossings::new(&region, &zones), &settings);
            check(&outcome, &start, &region, &zones);
        }
    }
}

#[test]
fn annealing_lowers_the_crossings() {
    for preset in Preset::ALL {
        let (region, _, crossings) = instance(30, 30, Layout::Stripes, 0);
        let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
        let outcome = run(&start, &crossings, &Settings::preset(preset, 0));
        assert_eq!((outcome.initial, outcome.stop), (60, Stop::Done));
        assert!(outcome.cost <= 50, "{preset}: {}", outcome.cost);
    }
}

#[test]
fn a_run_stops_at_its_proven_bound_or_its_target() {
    let (region, _, crossings) = instance(20, 20, Layout::LeftRight, 0);
    let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
    for preset in Preset::ALL {
        let settings = Settings { proven_bound: Some(19), ..Settings::preset(preset, 0) };
        let outcome = run(&start, &crossings, &settings);
        assert_eq!(outcome.stop, Stop::Optimal, "{preset}");
        assert!(outcome.cost <= 19 && outcome.proposals < 100_000, "{preset}");
        let settings = Settings { target: Some(19), ..Settings::preset(preset, 0) };
        let same = run(&start, &crossings, &settings);
        assert_eq!((same.stop, same.moves), (Stop::TargetReached, outcome.moves), "{preset}");
    }
}

#[test]
fn a_cancelled_run_keeps_its_best_path() {
    let (region, zones, crossings) = instance(20, 20, Layout::LeftRight, 0);
    let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
    for preset in Preset::ALL {
        let cancel = CancelToken::new();
        let seen = Mutex::new(Vec::new());
        let observer = |progress: Progress| {
            let mut seen = seen.lock().unwrap();
            seen.push(progress);
            if seen.len() > 2 {
                cancel.cancel();
            }
        };
        let settings = Settings { observer: Some(&observer), ..Settings::preset(preset, 0) };
        let control = Control { cancel: Some(&cancel), ..Control::default() };
        let outcome = solve(&start, &crossings, &settings, &control);
        assert_eq!(outcome.stop, Stop::Cancelled, "{preset}");
        let seen = seen.lock().unwrap();
        assert_eq!(seen.len(), 3);
        assert_eq!((seen[2].proposals, seen[2].best), (outcome.proposals, outcome.cost));
        assert!(seen[2].proposals < seen[2].planned);
        check(&outcome, &start, &region, &zones);
    }
}

#[test]
fn progress_counts_proposals() {
    let (region, _, crossings) = instance(12, 12, Layout::LeftRight, 0);
    let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
    let settings = Settings::preset(Preset::Short, 0);
    let reports = Mutex::new(Vec::new());
    let progress = |progress: beadwork_base::Progress| {
        reports.lock().unwrap().push((progress.done, progress.total));
    };
    let control = Control { progress: Some(&progress), ..Control::default() };
    solve(&start, &crossings, &settings, &control);
    let mut expected: Vec<_> = (0..=1000).step_by(250).map(|done| (done, 1000)).collect();
    // Flips begin after 600 iterations: the pool is filled then, and 250 iterations later.
    expected.splice(3..4, [(600, 1000), (850, 1000)]);
    assert_eq!(*reports.lock().unwrap(), expected);
    let time_is_up = || true;
    let control = Control { time_is_up: Some(&time_is_up), ..Control::default() };
    let outcome = solve(&start, &crossings, &settings, &control);
    assert_eq!((outcome.stop, outcome.proposals), (Stop::TimeUp, 0));
}

#[test]
fn another_cost_is_annealed() {
    /// Number of links along y, with a factor whose sign makes a search minimise or maximise it.
    struct Steps(i64);

    impl Cost for Steps {
        fn total(&self, path: &Path) -> i64 {
            let vertical =
                path.order().windows(2).filter(|step| step[0].abs_diff(step[1]) == path.width());
            self.0 * vertical.count() as i64
        }

        fn change(&self, switches: [Switch; 2]) -> i64 {
            let change = |switch: Switch| {
                if switch.from() == beadwork_grid::Sides::Vertical { -2 } else { 2 }
            };
            self.0 * switches.map(change).iter().sum::<i64>()
        }

        fn is_sensitive(&self, _: u32, _: u32) -> bool {
            true
        }
    }

    let region = Region::rectangle(20, 21).unwrap();
    let runs = [
        (Steps(1), Preset::Fast, Start::Spiral),
        (Steps(-1), Preset::Fast, Start::Spiral),
        (Steps(-1), Preset::Paper, Start::RowZigzag),
    ];
    for (steps, preset, start) in runs {
        let start = start.path(&region, &Control::default()).unwrap();
        let outcome = run(&start, &steps, &Settings::preset(preset, 0));
        assert!(
            outcome.cost < outcome.initial,
            "{preset}: {} -> {}",
            outcome.initial,
            outcome.cost
        );
        assert_eq!(steps.total(&outcome.path), outcome.cost);
    }
}

#[test]
fn the_temperature_falls_from_hot_to_cold() {
    let Method::Pooled(pooled) = Preset::Paper.method() else {
        panic!("the paper's annealer has a pool")
    };
    let seen = Mutex::new(Vec::new());
    let observer = |progress: Progress| seen.lock().unwrap().push(progress.temperature);
    let (region, _, crossings) = instance(12, 12, Layout::LeftRight, 0);
    let settings = Settings { observer: Some(&observer), ..Settings::preset(Preset::Short, 0) };
    run(&Start::RowZigzag.path(&region, &Control::default()).unwrap(), &crossings, &settings);
    let temperatures = seen.into_inner().unwrap();
    assert!(temperatures.is_sorted_by(|a, b| a >= b));
    assert!((temperatures[0] - 60.0).abs() < 1.0 && *temperatures.last().unwrap() < 10.0);
    assert_eq!(
        (pooled.iterations, pooled.pool, pooled.pool_life, pooled.patience),
        (5000, 5000, 250, 3000)
    );
}

#[test]
fn a_seed_gives_the_same_run_on_every_machine() {
    let (region, _, crossings) = instance(30, 30, Layout::Voronoi, 1);
    let start = Start::RowZigzag.path(&region, &Control::default()).unwrap();
    let digest = |preset| {
        let settings = Settings { method: shortened(preset), ..Settings::preset(preset, 9) };
        let outcome = run(&start, &crossings, &settings);
        let mix = |sum: u64, &cell: &u32| sum.wrapping_mul(0x100_0000_01b3) ^ u64::from(cell);
        (outcome.cost, outcome.accepted, outcome.path.order().iter().fold(0, mix))
    };
    // A change here changes all datasets and tables that were made with this annealer.
    assert_eq!(digest(Preset::Paper), (28, 944, 7_711_421_110_610_308_078));
    assert_eq!(digest(Preset::Fast), (12, 1_638, 10_696_964_616_343_252_386));
}
