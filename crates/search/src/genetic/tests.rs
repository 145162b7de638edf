//! Compares replays with slow evaluations and children with their parents, and checks complete
//! runs.

use std::sync::Mutex;

use beadwork_base::{CancelToken, Threads};
use beadwork_grid::{
    Crossings, Layout, LayoutSpec, PlacedVariant, Region, Start, Variant, Zones, cover, verify,
};
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::gene::{Gene, padded};
use super::individual::Individual;
use super::replay::{Replay, State};
use super::run::Birth;
use super::*;
use crate::Stop;
use crate::anneal;
use crate::random::below;

struct Layer {
    region: Region,
    zones: Zones,
    crossings: Crossings,
    start: Path,
}

fn layer(region: Region, layout: Layout, seed: u64) -> Layer {
    let spec = LayoutSpec { side: 3, ..LayoutSpec::new(layout) };
    let zones = spec.zones(&region, seed).unwrap();
    let crossings = Crossings::new(&region, &zones);
    let start = Start::RowZigzag
        .path(&region, &Control::default())
        .unwrap_or_else(|_| cover(&region, &Control::default()).unwrap());
    Layer { region, zones, crossings, start }
}

fn rectangle(width: u32, height: u32, layout: Layout, seed: u64) -> Layer {
    layer(Region::rectangle(width, height).unwrap(), layout, seed)
}

/// A preset with less work, so that a test can run it often.
fn shortened(preset: Preset, seed: u64) -> Settings<'static> {
    let mut settings = Settings::preset(preset, seed);
    settings.seeding.runs = settings.seeding.runs.min(24);
    for method in &mut settings.seeding.methods {
        match method {
            anneal::Method::Pooled(pooled) => pooled.iterations /= 5,
            anneal::Method::Free(free) => free.proposals = 20_000,
        }
    }
    settings.evolution.population = settings.evolution.population.min(20);
    settings.evolution.generations = 15;
    settings
}

/// Crossings counted along a path.
fn count_crossings(layer: &Layer, path: &Path) -> i64 {
    let crosses = |step: &&[u32]| {
        layer.region.adjacent(step[0], step[1])
            && layer.zones.id(step[0]) != layer.zones.id(step[1])
    };
    path.order().windows(2).filter(crosses).count() as i64
}

/// The lowest cost and the number of genes up to it, by applying each gene to a path and counting
/// its crossings.
fn evaluated(layer: &Layer, genes: &[Gene]) -> (i64, usize) {
    let mut path = layer.start.clone();
    let mut best = (count_crossings(layer, &path), 0);
    for (index, gene) in genes.iter().enumerate() {
        if gene.is_some_and(|gene| gene.apply(&mut path)) {
            let cost = count_crossings(layer, &path);
            if cost < best.0 {
                best = (cost, index + 1);
            }
        }
    }
    best
}

fn solve_alone(layer: &Layer, settings: &Settings<'_>) -> Outcome {
    solve(&layer.start, &layer.crossings, settings, &Control::default())
}

fn check(outcome: &Outcome, layer: &Layer, settings: &Settings<'_>) {
    let mut path = layer.start.clone();
    assert!(outcome.moves.iter().all(|step| step.apply(&mut path)), "all recorded moves apply");
    assert_eq!(path, outcome.path, "the record leads to the best path");
    assert_eq!(verify(&layer.region, path.order()), Ok(layer.start.pieces()));
    assert_eq!(
        (count_crossings(layer, &path), count_crossings(layer, &layer.start)),
        (outcome.cost, outcome.initial)
    );
    let generations = &outcome.generations;
    assert!(generations.iter().zip(0..).all(|(generation, number)| generation.number == number));
    assert!(generations.is_sorted_by(|a, b| a.best >= b.best), "the best is never lost");
    assert_eq!(generations.last().unwrap().best, outcome.cost);
    assert!(
        generations
            .iter()
            .all(|it| it.mean >= it.best as f64 && (0.0..=1.0).contains(&it.diversity)),
        "{generations:?}"
    );
    let children = settings.evolution.population as u32;
    assert!(generations.iter().all(|it| it.stayed <= children));
}

/// The moves of short annealing runs, with random variants inserted.
fn random_lists(layer: &Layer, count: u64, seed: u64) -> Vec<Vec<Move>> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let list = |seed| {
        let method = anneal::Preset::Short.method();
        let method = match method {
            anneal::Method::Pooled(pooled) => {
                anneal::Method::Pooled(anneal::Pooled { iterations: 150, ..pooled })
            }
            other @ anneal::Method::Free(_) => other,
        };
        let settings =
            anneal::Settings { method, ..anneal::Settings::preset(anneal::Preset::Short, seed) };
        anneal::solve(&layer.start, &layer.crossings, &settings, &Control::default()).moves
    };
    let mut lists: Vec<Vec<Move>> = (0..count).map(list).collect();
    for list in &mut lists {
        for _ in 0..below(&mut rng, 20) {
            let x = below(&mut rng, layer.region.width() as usize) as u16;
            let y = below(&mut rng, layer.region.height() as usize) as u16;
            let variant = Variant::ALL[below(&mut rng, 12)];
            list.insert(
                below(&mut rng, list.len() + 1),
                Move::Variant(PlacedVariant { variant, x, y }),
            );
        }
    }
    lists
}

const CROSSOVERS: [Crossover; 4] = [
    Crossover::OnePoint { first: 0.6 },
    Crossover::OnePoint { first: 0.33 },
    Crossover::TwoPoint,
    Crossover::Window,
];

/// Breeds children of children and evaluates each of them the slow way.
fn breed<S: State>(layer: &Layer, state: &S, lists: &[Vec<Move>], seed: u64) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let length = lists.iter().map(Vec::len).max().unwrap();
    let replay = Replay::new(state, &layer.start, &layer.crossings, length, seed as usize % 12);
    let grid = (layer.region.width(), layer.region.height());
    let mut scratch = state.clone();
    let mut all: Vec<Individual<S>> =
        lists.iter().map(|moves| replay.first(&padded(moves, length), &mut scratch)).collect();
    for number in 0..24 {
        let parents = [below(&mut rng, all.len()), below(&mut rng, all.len())];
        let evolution = Evolution {
            crossover: CROSSOVERS[number % 4],
            mutations: below(&mut rng, 3) as u32,
            ..Evolution::default()
        };
        let parents_of_it = parents.map(|parent| &all[parent]);
        let birth = Birth { parents, seed: rng.next_u64() };
        let genes =
            birth.genes::<S>(parents_of_it.map(|parent| &parent.genes[..]), &evolution, grid);
        assert_eq!(genes.len(), length);
        let child = replay.child(genes, parents_of_it, &mut scratch);
        assert_eq!((child.cost, child.best_at), evaluated(layer, &child.genes));
        assert_eq!(child.is_new, parents_of_it.iter().all(|parent| parent.genes != child.genes));
        all.push(child);
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 150,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// 150 layers, 24 children on each, on links and on paths.
    #[test]
    fn children_cost_what_a_replay_from_the_start_finds(
        width in 4_u32..16,
        height in 4_u32..16,
        seed: u64,
        layout in prop::sample::select(vec![
            Layout::LeftRight,
            Layout::Voronoi,
            Layout::Checkerboard,
        ]),
    ) {
        let layer = rectangle(width, height, layout, seed);
        let lists = random_lists(&layer, 6, seed);
        breed(&layer, &Links::new(&layer.start), &lists, seed);
        let pairs: Vec<Vec<Move>> = lists
            .iter()
            .map(|list| list.iter().map(|step| Move::Pair(step.switches(width))).collect())
            .collect();
        breed(&layer, &layer.start, &pairs, seed);
    }

    #[test]
    fn crossover_keeps_the_order_of_both_parents(
        seed: u64,
        length in 0_usize..60,
        crossover in prop::sample::select(&CROSSOVERS[..]),
    ) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        // All genes are different and identify their parent.
        let gene = |parent: u16, index: usize| {
            let (x, y) = (index as u16, 10 * parent + index as u16 % 10);
            let placed = PlacedVariant { variant: Variant::N, x, y };
            Some(Move::Variant(placed))
        };
        let filled = [below(&mut rng, length + 1), below(&mut rng, length + 1)];
        let parent = |number: usize| -> Vec<Gene> {
            let gene = |index| gene(number as u16, index).filter(|_| index < filled[number]);
            (0..length).map(gene).collect()
        };
        let parents = [parent(0), parent(1)];
        let child = crossover.cross([&parents[0], &parents[1]], (60, 20), &mut rng);
        prop_assert_eq!(child.len(), length);
        for parent in &parents {
            let is_kept = |gene: &&Gene| gene.is_some() && parent.contains(gene);
            let kept: Vec<&Gene> = child.iter().filter(is_kept).collect();
            let mut rest = parent.iter();
            prop_assert!(kept.iter().all(|gene| rest.any(|own| own == *gene)), "{:?}", child);
        }
        if let Crossover::OnePoint { first } = crossover {
            let cut = (first * length as f64) as usize;
            prop_assert_eq!(&child[..cut], &parents[0][..cut]);
            prop_assert_eq!(&child[cut..], &parents[1][cut..]);
        }
        if crossover == Crossover::TwoPoint {
            let differs = |&index: &usize| child[index] != parents[0][index];
            let of_other: Vec<usize> = (0..length).filter(differs).collect();
            prop_assert!(of_other.iter().all(|&index| child[index] == parents[1][index]));
        }
    }
}

#[test]
fn runs_end_with_a_path_that_their_moves_lead_to() {
    for (seed, preset) in (0..).zip(Preset::ALL) {
        for layout in [Layout::LeftRight, Layout::Voronoi] {
            let layer = rectangle(14, 11, layout, seed);
            let settings = shortened(preset, seed);
            let outcome = solve_alone(&layer, &settings);
            check(&outcome, &layer, &settings);
            assert_eq!((outcome.stop, outcome.generations.len()), (Stop::Done, 16));
        }
    }
}

#[test]
fn regions_in_several_pieces_are_solved() {
    let inside = (0..20 * 15).map(|cell| cell % 7 != 3 || cell < 40).collect();
    let layer = layer(Region::from_mask(20, 15, inside).unwrap(), Layout::Voronoi, 3);
    assert!(layer.start.pieces() > 1);
    for preset in [Preset::Window, Preset::Fast] {
        let settings = shortened(preset, 1);
        check(&solve_alone(&layer, &settings), &layer, &settings);
    }
}

#[test]
fn threads_change_nothing() {
    let layer = rectangle(16, 12, Layout::Voronoi, 5);
    for preset in [Preset::Paper, Preset::Window, Preset::Fast] {
        let alone = solve_alone(&layer, &shortened(preset, 2));
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let control = Control::on(Threads::Pool(&pool));
            let settings = shortened(preset, 2);
            let outcome = solve(&layer.start, &layer.crossings, &settings, &control);
            assert_eq!((&outcome.moves, &outcome.generations), (&alone.moves, &alone.generations));
            assert_eq!((outcome.replayed, outcome.spared), (alone.replayed, alone.spared));
        }
    }
}

#[test]
fn links_and_paths_evolve_alike() {
    let layer = rectangle(16, 12, Layout::Stripes, 5);
    let settings = shortened(Preset::TwoPoint, 4);
    let control = Control::default();
    let population = annealed(&layer.start, &layer.crossings, &settings, &control);
    let (start, crossings) = (&layer.start, &layer.crossings);
    let on_links = run(&Links::new(start), start, crossings, &population, &settings, &control);
    let on_paths = run(start, start, crossings, &population, &settings, &control);
    assert_eq!((on_links.moves, on_links.generations), (on_paths.moves, on_paths.generations));
}

#[test]
fn mutations_keep_to_one_kind_of_moves() {
    let layer = rectangle(16, 12, Layout::Islands, 5);
    let mut settings = shortened(Preset::Fast, 4);
    settings.evolution.mutations = 5;
    let outcome = solve_alone(&layer, &settings);
    check(&outcome, &layer, &settings);
    assert!(outcome.moves.iter().all(|step| matches!(step, Move::Pair(_))));
}

#[test]
fn evolution_never_loses_the_best_individual() {
    let layer = rectangle(30, 30, Layout::Islands, 1);
    let mut settings = shortened(Preset::Window, 1);
    settings.seeding.runs = 80;
    settings.evolution = Evolution { population: 60, generations: 60, ..settings.evolution };
    let control = Control::default();
    let population = annealed(&layer.start, &layer.crossings, &settings, &control);
    assert_eq!(population.len(), 60);
    let costs: Vec<i64> =
        population.iter().map(|moves| evaluated(&layer, &padded(moves, moves.len())).0).collect();
    assert!(costs.is_sorted(), "the best come first: {costs:?}");
    let outcome = evolve(&layer.start, &layer.crossings, &population, &settings, &control);
    assert_eq!(outcome.generations[0].best, costs[0]);
    assert!(
        outcome.cost < costs[0],
        "crossover improves on annealing here: {} of {}",
        outcome.cost,
        costs[0]
    );
}

#[test]
fn populations_of_any_size_are_accepted() {
    let layer = rectangle(9, 9, Layout::LeftRight, 0);
    let settings = shortened(Preset::Window, 0);
    let control = Control::default();
    let run = |population: &[Vec<Move>]| {
        evolve(&layer.start, &layer.crossings, population, &settings, &control)
    };
    for population in [&[][..], &[vec![]], &[vec![], vec![]]] {
        let outcome = run(population);
        assert_eq!((outcome.cost, outcome.moves.len(), outcome.length), (9, 0, 0));
    }
    let some = annealed(&layer.start, &layer.crossings, &settings, &control);
    check(&run(&some[..1]), &layer, &settings);
    check(&run(&[&some[..], &some[..]].concat()), &layer, &settings);
    let mut alone = settings.clone();
    alone.evolution = Evolution { population: 1, elites: 6, carry_over: 0.0, ..alone.evolution };
    let outcome = evolve(&layer.start, &layer.crossings, &some, &alone, &control);
    check(&outcome, &layer, &alone);
}

#[test]
fn a_run_stops_at_its_proven_bound_or_its_target() {
    let layer = rectangle(20, 20, Layout::LeftRight, 0);
    let settings = Settings { proven_bound: Some(19), ..shortened(Preset::Paper, 0) };
    let outcome = solve_alone(&layer, &settings);
    assert_eq!((outcome.stop, outcome.generations.len()), (Stop::Optimal, 1));
    assert!(outcome.cost <= 19);
    let settings = Settings { target: Some(19), ..shortened(Preset::Paper, 0) };
    let same = solve_alone(&layer, &settings);
    assert_eq!((same.stop, same.moves), (Stop::TargetReached, outcome.moves));
}

#[test]
fn a_cancelled_run_keeps_its_best_individual() {
    let layer = rectangle(20, 20, Layout::LeftRight, 0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for threads in [Threads::One, Threads::Pool(&pool)] {
        // Before the start, while annealing, and while breeding.
        for stop_at in [0, 3, 24, 27] {
            let (cancel, seen) = (CancelToken::new(), Mutex::new(0));
            if stop_at == 0 {
                cancel.cancel();
            }
            let progress = |progress: beadwork_base::Progress| {
                assert_eq!(progress.total, 24 + 15);
                let mut seen = seen.lock().unwrap();
                *seen += 1;
                if *seen >= stop_at {
                    cancel.cancel();
                }
            };
            let control = Control {
                threads,
                cancel: Some(&cancel),
                progress: Some(&progress),
                ..Control::default()
            };
            let settings = shortened(Preset::Paper, 0);
            let outcome = solve(&layer.start, &layer.crossings, &settings, &control);
            assert_eq!(outcome.stop, Stop::Cancelled);
            check(&outcome, &layer, &settings);
            // Another thread may have been about to report.
            assert!(*seen.lock().unwrap() <= stop_at + 2, "{stop_at}");
            assert!(stop_at > 0 || outcome.moves.is_empty());
        }
    }
}

#[test]
fn an_interrupted_run_does_not_count_as_optimal() {
    let layer = rectangle(20, 20, Layout::LeftRight, 0);
    let cancel = CancelToken::new();
    let progress = |_| {
        cancel.cancel();
    };
    let control =
        Control { cancel: Some(&cancel), progress: Some(&progress), ..Control::default() };
    let settings = Settings { proven_bound: Some(19), ..shortened(Preset::Paper, 0) };
    let stop = solve(&layer.start, &layer.crossings, &settings, &control).stop;
    assert_eq!(stop, Stop::Cancelled);
    let time_is_up = || true;
    let control = Control { time_is_up: Some(&time_is_up), ..Control::default() };
    let stop = solve(&layer.start, &layer.crossings, &settings, &control).stop;
    assert_eq!(stop, Stop::TimeUp);
}

#[test]
fn observers_see_each_generation() {
    let layer = rectangle(12, 12, Layout::Voronoi, 0);
    let seen = Mutex::new(Vec::new());
    let observer = |generation| seen.lock().unwrap().push(generation);
    let settings = Settings { observer: Some(&observer), ..shortened(Preset::Window, 0) };
    let outcome = solve_alone(&layer, &settings);
    assert_eq!(*seen.lock().unwrap(), outcome.generations);
}

#[test]
fn tolerance_may_be_unlimited() {
    let layer = rectangle(12, 12, Layout::Voronoi, 0);
    let mut settings = shortened(Preset::Window, 0);
    settings.evolution.tolerance = i64::MAX;
    check(&solve_alone(&layer, &settings), &layer, &settings);
}

#[test]
fn presets_have_the_documented_parameters() {
    for preset in Preset::ALL {
        assert_eq!(preset.name().parse(), Ok(preset));
    }
    let (seeding, paper) = Preset::Paper.parameters();
    assert_eq!((seeding.runs, seeding.methods.len()), (920, 5));
    assert_eq!((paper.population, paper.generations, paper.tournament), (200, 500, 3));
    assert_eq!(paper.crossover, Crossover::OnePoint { first: 0.6 });
    assert_eq!((paper.crossover_rate, paper.carry_over, paper.elites), (0.9, 0.6, 6));
    assert_eq!((paper.tolerance, paper.mutations), (2, 0));
    let (two_point, window, short) = (Preset::TwoPoint, Preset::Window, Preset::Short);
    assert_eq!(two_point.parameters().1, Evolution { crossover: Crossover::TwoPoint, ..paper });
    assert_eq!(
        window.parameters().1,
        Evolution { crossover: Crossover::Window, mutations: 1, ..paper }
    );
    assert_eq!([two_point, window].map(|preset| preset.parameters().0), [seeding.clone(), seeding]);
    assert!(short.parameters().0.runs < 200 && short.parameters().1.crossover == Crossover::Window);
    let (fast, evolution) = Preset::Fast.parameters();
    assert_eq!(
        (fast.methods, fast.runs as usize),
        (vec![anneal::Preset::Fast.method()], evolution.population)
    );
    assert_eq!(
        "best".parse::<Preset>().unwrap_err().to_string(),
        "unknown genetic preset 'best': expected paper, two_point, window, short or fast"
    );
}

#[test]
fn a_seed_gives_the_same_run_on_every_machine() {
    let layer = rectangle(20, 20, Layout::Voronoi, 1);
    let digest = |preset| {
        let outcome = solve_alone(&layer, &shortened(preset, 9));
        let mix = |sum: u64, &cell: &u32| sum.wrapping_mul(0x100_0000_01b3) ^ u64::from(cell);
        (outcome.cost, outcome.replayed, outcome.path.order().iter().fold(0, mix))
    };
    // A change here changes all datasets and tables that were made with this algorithm.
    assert_eq!(digest(Preset::Paper), (18, 2_923, 2_603_966_194_604_896_584));
    assert_eq!(digest(Preset::Window), (18, 28_403, 2_603_966_194_604_896_584));
    assert_eq!(digest(Preset::Fast), (8, 7_932, 13_767_836_259_316_050_268));
}
