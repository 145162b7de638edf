//! Replays recorded moves, and compares chains with all possible chains.

use std::collections::HashSet;

use beadwork_base::CancelToken;
use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
use proptest::prelude::*;

use super::*;

fn instance(width: u32, height: u32, layout: Layout, seed: u64) -> (Path, Crossings) {
    let region = Region::rectangle(width, height).unwrap();
    let mut spec = LayoutSpec::new(layout);
    spec.side = 3;
    let zones = spec.zones(&region, seed).unwrap();
    (Start::RowZigzag.path(&region, &Control::default()).unwrap(), Crossings::new(&region, &zones))
}

/// The maximum gain of all chains from a variant, for each length, by a breadth-first search over
/// all links that can be reached.
fn max_gains(
    path: &Path,
    start: &Links,
    cost: &Crossings,
    first: PlacedVariant,
    depth: usize,
) -> Vec<i64> {
    let mut links = start.clone();
    assert!(links.apply_variant(first));
    let change = |placed: PlacedVariant| Cost::change(cost, placed.switches(path.width()));
    let mut front = vec![(links, first, change(first))];
    let mut gains = Vec::new();
    for _ in 0..depth {
        gains.push(front.iter().map(|(.., change)| -change).max().unwrap_or(i64::MIN));
        let mut next = Vec::new();
        for (links, last, sum) in &front {
            for placed in applicable(links) {
                if placed.x.abs_diff(last.x) <= 2 && placed.y.abs_diff(last.y) <= 2 {
                    let mut links = links.clone();
                    links.apply_variant(placed);
                    next.push((links, placed, sum + change(placed)));
                }
            }
        }
        front = next;
    }
    gains
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn records_replay_and_every_chain_gains(
        width in 1_u32..30,
        height in 1_u32..30,
        seed: u64,
        noisy: bool,
        layout in prop::sample::select(vec![
            Layout::LeftRight,
            Layout::Checkerboard,
            Layout::TopBottom,
        ]),
    ) {
        let (start, crossings) = instance(width, height, layout, seed);
        let preset = if noisy { Preset::Noisy } else { Preset::Plain };
        let settings = Settings { beam: 2, depth: 12, ..Settings::preset(preset, seed) };
        let control = Control::default();
        let outcome = solve(&start, &crossings, &settings, &control);
        prop_assert_eq!(outcome.initial, crossings.total(&start));
        prop_assert_eq!(outcome.cost, crossings.total(&outcome.path));
        prop_assert!(outcome.cost <= outcome.initial);
        let mut path = start.clone();
        for step in &outcome.moves {
            prop_assert!(step.apply(&mut path));
        }
        prop_assert_eq!(path.order(), outcome.path.order());
        prop_assert_eq!(solve(&start, &crossings, &settings, &control).moves, outcome.moves);
    }

    /// A beam that drops nothing finds the best of all chains up to two moves.
    /// Longer ones may be missed: of two chains to the same links only one is extended, and the
    /// moves that can follow depend on where it ended.
    #[test]
    fn a_wide_beam_finds_the_best_chain(
        width in 3_u32..8,
        height in 3_u32..8,
        seed: u64,
        detours in 0_usize..6,
        depth in 1_usize..5,
    ) {
        let (start, crossings) = instance(width, height, Layout::Checkerboard, seed);
        let mut links = Links::new(&start);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        for _ in 0..detours {
            let all = applicable(&links);
            if !all.is_empty() {
                links.apply_variant(all[below(&mut rng, all.len())]);
            }
        }
        let settings = Settings { beam: usize::MAX, depth, patience: depth, ..Settings::default() };
        let grower = Grower::new(&start, &crossings, settings.limits());
        for first in applicable(&links) {
            let before = links.clone();
            let found = grower.grow(&mut links, first).0;
            let found = found.map(|chain| (chain.moves.len() as i64, chain.gain));
            prop_assert_eq!(&links, &before);
            let gains = max_gains(&start, &links, &crossings, first, depth);
            let rated = (1_i64..).zip(gains).filter(|&(_, gain)| gain > 0);
            let better = |best: (i64, i64), other: (i64, i64)| {
                if other.1 * best.0 > best.1 * other.0 { other } else { best }
            };
            let best = rated.reduce(better);
            if depth <= 2 {
                prop_assert_eq!(found, best);
            } else if let Some((length, gain)) = found {
                let (best_length, best_gain) = best.unwrap();
                prop_assert!(gain * best_length <= best_gain * length);
            }
        }
    }

    /// A search that is repeated after a change outside its extent finds the same chain.
    #[test]
    fn chains_depend_only_on_the_examined_cells(seed: u64, moves in 1_usize..40) {
        let (start, crossings) = instance(16, 14, Layout::Checkerboard, seed);
        let settings = Settings { beam: 3, depth: 6, ..Settings::default() };
        let grower = Grower::new(&start, &crossings, settings.limits());
        let mut links = Links::new(&start);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        for _ in 0..moves {
            let all = applicable(&links);
            links.apply_variant(all[below(&mut rng, all.len())]);
        }
        let all = applicable(&links);
        let mut grow = |&first| (first, grower.grow(&mut links, first));
        let known: Vec<_> = all.iter().map(&mut grow).collect();
        let changed = all[below(&mut rng, all.len())];
        links.apply_variant(changed);
        let still: HashSet<PlacedVariant> = applicable(&links).into_iter().collect();
        for (first, (found, examined)) in known {
            if !examined.overlaps(Extent::window(changed)) {
                prop_assert!(still.contains(&first));
                prop_assert_eq!(grower.grow(&mut links, first).0, found);
            }
        }
    }
}

#[test]
fn a_search_stops_at_its_bound_or_target_and_when_cancelled() {
    let (start, crossings) = instance(20, 20, Layout::LeftRight, 0);
    let run =
        |settings: &Settings, control: &Control<'_>| solve(&start, &crossings, settings, control);
    let settings = Settings { proven_bound: Some(16), ..Settings::default() };
    let outcome = run(&settings, &Control::default());
    assert_eq!((outcome.stop, outcome.cost), (Stop::Optimal, 16));
    let settings = Settings { target: Some(16), ..Settings::default() };
    let outcome = run(&settings, &Control::default());
    assert_eq!((outcome.stop, outcome.cost), (Stop::TargetReached, 16));
    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let outcome = run(&Settings::default(), &control);
    assert_eq!((outcome.stop, outcome.cost, outcome.moves.len()), (Stop::Cancelled, 20, 0));
}

#[test]
fn a_seed_gives_the_same_search_on_every_machine() {
    let region = Region::rectangle(30, 30).unwrap();
    let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, 1).unwrap();
    let (start, crossings) = (
        Start::RowZigzag.path(&region, &Control::default()).unwrap(),
        Crossings::new(&region, &zones),
    );
    let digest = |preset| {
        let settings = Settings::preset(preset, 9);
        let outcome = solve(&start, &crossings, &settings, &Control::default());
        let mix = |sum: u64, &cell: &u32| sum.wrapping_mul(0x100_0000_01b3) ^ u64::from(cell);
        (outcome.cost, outcome.moves.len(), outcome.path.order().iter().fold(0, mix))
    };
    // A change here changes all datasets that were made with this search.
    assert_eq!(digest(Preset::Plain), (22, 94, 6_068_850_567_377_254_222));
    assert_eq!(digest(Preset::Noisy), (22, 99, 17_636_321_846_822_899_246));
}
