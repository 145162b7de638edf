//! Compares the exact search with all covers of small regions, and checks its outcomes on larger
//! ones.

use std::sync::Mutex;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use beadwork_base::{CancelToken, Control, Progress};
use beadwork_grid::{Cell, Layout, LayoutSpec, Region, RegionShape, Zones, verify};
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::brute_force::{Problem, cheapest, fewest_and_cheapest};
use super::{
    AttemptReport, Observers, Outcome, Settings, Side, SolveError, Stage, Terminal,
    solve as solve_with,
};
use crate::bound::Bounds;
use crate::{CostMatrix, Stop};

fn solve(region: &Region, zones: &Zones, settings: &Settings<'_>) -> Result<Outcome, SolveError> {
    solve_with(region, zones, settings, &Control::default())
}

/// A rectangle or a mask of up to 25 cells, of up to 4 zones.
fn draw(rng: &mut impl Rng, side: u32) -> (Region, Zones) {
    let (width, height) = (rng.random_range(1..=side), rng.random_range(1..=side));
    let density = [1.0, 1.0, 0.9, 0.8][rng.random_range(0..4)];
    let mask: Vec<bool> = (0..width * height).map(|_| rng.random_bool(density)).collect();
    let Ok(region) = Region::from_mask(width, height, mask) else { return draw(rng, side) };
    let count = rng.random_range(1..=4_u8);
    let seeds: Vec<(u32, u32)> =
        (0..count).map(|_| (rng.random_range(0..width), rng.random_range(0..height))).collect();
    let scattered = rng.random_bool(0.3);
    let ids = (0..width * height).map(|cell| {
        let (x, y) = (cell % width, cell / width);
        let nearest = (0..count).min_by_key(|&zone| {
            let (sx, sy) = seeds[usize::from(zone)];
            x.abs_diff(sx).pow(2) + y.abs_diff(sy).pow(2)
        });
        if scattered { rng.random_range(0..count) } else { nearest.unwrap_or(0) }
    });
    let ids = ids.collect();
    let zones = Zones::new(&region, ids).unwrap();
    (region, zones)
}

/// Checks an outcome by its definition: the path visits all cells once, and pieces, cost and ends
/// are as stated.
fn check(problem: &Problem<'_>, outcome: &Outcome) {
    let Problem { region, zones, costs, start, end } = *problem;
    let order = outcome.path.order();
    assert_eq!(verify(region, order), Ok(outcome.pieces));
    let steps = || order.windows(2).filter(|step| region.adjacent(step[0], step[1]));
    let crossing = |step: &&[Cell]| zones.id(step[0]) != zones.id(step[1]);
    assert_eq!(
        steps().filter(crossing).count(),
        outcome.crossings as usize,
        "{region:?} {:?} {order:?} {start:?} {end:?} {}",
        zones.ids(),
        outcome.pieces
    );
    let cost: u64 =
        steps().map(|step| u64::from(costs.scaled(zones.id(step[0]), zones.id(step[1])))).sum();
    assert_eq!(cost, outcome.cost as u64);
    assert!(start.is_none_or(|cell| order[0] == cell), "the path begins elsewhere");
    assert!(end.is_none_or(|cell| order[order.len() - 1] == cell), "the path ends elsewhere");
}

/// What a test changes about a problem drawn at random.
struct Change {
    costs: Option<CostMatrix>,
    start: Option<Cell>,
    end: Option<Cell>,
}

impl Change {
    const NONE: Self = Self { costs: None, start: None, end: None };
}

/// Solves many small problems; returns how many outcomes were optimal, and how many were proven
/// optimal.
fn compare(
    count: u64,
    seed: u64,
    side: u32,
    change: impl Fn(&mut Xoshiro256PlusPlus, &Region, &Zones) -> Change,
) -> (u64, u64) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut proven, mut optimal) = (0, 0);
    for number in 0..count {
        let (region, zones) = draw(&mut rng, side);
        let Change { costs, start, end } = change(&mut rng, &region, &zones);
        let uniform = CostMatrix::uniform(zones.count() as usize);
        let problem = Problem {
            region: &region,
            zones: &zones,
            costs: costs.as_ref().unwrap_or(&uniform),
            start,
            end,
        };
        let terminal = |cell: Option<Cell>| cell.map_or(Terminal::Any, Terminal::Cell);
        let settings = Settings {
            seed: number,
            attempts: 200,
            costs: costs.as_ref(),
            start: terminal(start),
            end: terminal(end),
            ..Settings::default()
        };
        let outcome = solve(&region, &zones, &settings).unwrap();
        check(&problem, &outcome);
        let (pieces, cost) = fewest_and_cheapest(&problem);
        let problem = format!(
            "problem {number}: {}x{} {:?} {:?} {start:?} {end:?} {costs:?}",
            region.width(),
            region.height(),
            region.cells().collect::<Vec<_>>(),
            zones.ids()
        );
        assert!(
            outcome.piece_bound <= pieces,
            "{problem}: at least {} pieces, but {pieces} do",
            outcome.piece_bound
        );
        if outcome.pieces == pieces {
            assert!(
                outcome.bound as u64 <= cost,
                "{problem}: at least {}, but {cost} does",
                outcome.bound
            );
        }
        optimal += u64::from((outcome.pieces, outcome.cost as u64) == (pieces, cost));
        proven += u64::from(outcome.is_optimal());
    }
    (optimal, proven)
}

#[test]
fn crossings_of_small_regions() {
    assert_eq!(compare(2500, 1, 5, |_, _, _| Change::NONE), (2500, 2499));
}

#[test]
fn given_ends_in_small_regions() {
    let ends = |rng: &mut Xoshiro256PlusPlus, region: &Region, _: &Zones| {
        let cells: Vec<Cell> = region.cells().collect();
        let mut pick = || Some(cells[rng.random_range(0..cells.len())]);
        let (start, end) = (pick(), pick());
        let only_start = rng.random_bool(0.3) || (start == end && cells.len() > 1);
        Change { start, end: end.filter(|_| !only_start), ..Change::NONE }
    };
    assert_eq!(compare(1500, 2, 4, ends), (1500, 1493));
}

fn draw_costs(rng: &mut impl Rng, zones: u32, symmetric: bool) -> CostMatrix {
    let zones_squared = zones * zones;
    let mut costs: Vec<u32> = (0..zones_squared).map(|_| rng.random_range(0..6)).collect();
    for a in 0..zones as usize {
        costs[a * zones as usize + a] = 0;
        for b in 0..a {
            if symmetric {
                costs[a * zones as usize + b] = costs[b * zones as usize + a];
            }
        }
    }
    let zones = zones as usize;
    CostMatrix::from_fn(zones, |a, b| costs[a * zones + b].into()).unwrap()
}

#[test]
fn costs_of_pairs_in_small_regions() {
    let costs = |rng: &mut Xoshiro256PlusPlus, _: &Region, zones: &Zones| Change {
        costs: Some(draw_costs(rng, zones.count(), true)),
        ..Change::NONE
    };
    assert_eq!(compare(800, 3, 4, costs), (800, 799));
}

/// Where directions differ the search is not exact: 99 of 100 outcomes are optimal, four of five
/// proven.
#[test]
fn costs_of_directions_in_small_regions() {
    let costs = |rng: &mut Xoshiro256PlusPlus, _: &Region, zones: &Zones| Change {
        costs: Some(draw_costs(rng, zones.count(), false)),
        ..Change::NONE
    };
    assert_eq!(compare(800, 4, 4, costs), (790, 650));
}

/// Compares each bound with the optimum over all covers.
#[test]
fn no_bound_exceeds_the_optimum() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut tight = [0; 6];
    let mut problems = 0;
    for number in 0..1500 {
        let (region, zones) = draw(&mut rng, 5);
        let costs = CostMatrix::uniform(zones.count() as usize);
        let problem =
            Problem { region: &region, zones: &zones, costs: &costs, start: None, end: None };
        let bounds = Bounds::new(&region, &zones, &Control::default()).unwrap();
        let (pieces, _) = fewest_and_cheapest(&problem);
        assert!(bounds.pieces <= pieces, "problem {number}: {bounds:?}, but {pieces} pieces do");
        let Some(best) = cheapest(&problem, bounds.pieces) else { continue };
        problems += 1;
        let all = [
            bounds.flow,
            bounds.segments,
            bounds.scattering,
            bounds.walk.unwrap_or(0),
            bounds.connectivity,
            bounds.cuts,
        ];
        for (bound, tight) in all.into_iter().zip(&mut tight) {
            assert!(u64::from(bound) <= best, "problem {number}: {bounds:?}, but {best} does");
            *tight += u32::from(u64::from(bound) == best);
        }
    }
    // How often each bound equals the optimum.
    assert_eq!((tight, problems), ([1310, 1455, 1419, 1364, 1489, 1495], 1497));
}

#[test]
fn merging_two_zones_raises_no_optimum() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
    for number in 0..300 {
        let (region, zones) = draw(&mut rng, 6);
        let merged = zones.ids().iter().map(|&id| if id == 1 { 0 } else { id }).collect();
        let merged = Zones::new(&region, merged).unwrap();
        let [all, fewer] =
            [&zones, &merged].map(|zones| solve(&region, zones, &Settings::default()).unwrap());
        assert!((fewer.pieces, fewer.bound) <= (all.pieces, all.cost), "problem {number}");
    }
}

fn layers() -> impl Iterator<Item = (Region, Zones)> {
    (0..40_u64).map(|seed| {
        let side = 12 + (seed % 19) as u32;
        let region = match RegionShape::ALL.get(seed as usize % 8) {
            Some(shape) => shape.region(side, side, seed).unwrap(),
            None => Region::rectangle(side, side + 1).unwrap(),
        };
        let layout = [Layout::Voronoi, Layout::Islands, Layout::Stripes, Layout::Checkerboard]
            [seed as usize % 4];
        let zones = LayoutSpec { layout, zones: 5, side: 3 }.zones(&region, seed).unwrap();
        (region, zones)
    })
}

#[test]
fn larger_layers_are_covered_and_bounded() {
    let mut proven = 0;
    for (region, zones) in layers() {
        let outcome = solve(&region, &zones, &Settings::default()).unwrap();
        let costs = CostMatrix::uniform(zones.count() as usize);
        check(
            &Problem { region: &region, zones: &zones, costs: &costs, start: None, end: None },
            &outcome,
        );
        assert!(outcome.pieces >= outcome.piece_bound && outcome.cost >= outcome.bound);
        assert_eq!(outcome.is_optimal(), outcome.stop == Stop::Optimal);
        proven += u32::from(outcome.is_optimal());
    }
    assert!(proven >= 38, "only {proven} of 40 are proven");
}

#[test]
fn sides_hold_the_ends() {
    let sides = [Side::Left, Side::Top, Side::Right, Side::Bottom];
    for (number, (region, zones)) in layers().enumerate() {
        let (first, last) = (sides[number % 4], sides[number / 4 % 4]);
        let settings = Settings {
            start: Terminal::Side(first),
            end: Terminal::Side(last),
            attempts: 4,
            ..Settings::default()
        };
        let outcome = solve(&region, &zones, &settings).unwrap();
        let order = outcome.path.order();
        assert!(Terminal::Side(first).cells(&region).contains(&order[0]), "layer {number}");
        assert!(
            Terminal::Side(last).cells(&region).contains(&order[order.len() - 1]),
            "layer {number}"
        );
        assert_eq!(verify(&region, order), Ok(outcome.pieces));
        let free = solve(&region, &zones, &Settings::default()).unwrap();
        assert!((outcome.pieces, outcome.cost) >= (free.piece_bound, free.bound), "layer {number}");
    }
}

#[test]
fn a_seed_determines_the_path() {
    let region = Region::rectangle(40, 30).unwrap();
    let zones =
        LayoutSpec { layout: Layout::Voronoi, zones: 12, side: 1 }.zones(&region, 5).unwrap();
    let outcome = |seed| {
        solve(&region, &zones, &Settings { seed, attempts: 3, ..Settings::default() }).unwrap()
    };
    assert_eq!(outcome(1).path, outcome(1).path);
    assert_ne!(outcome(1).path, outcome(2).path);
}

#[test]
fn interrupted_searches_return_a_valid_path() {
    let region = Region::rectangle(60, 60).unwrap();
    let zones =
        LayoutSpec { layout: Layout::Islands, zones: 30, side: 4 }.zones(&region, 1).unwrap();
    let settings = Settings::default();
    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let cancelled = solve_with(&region, &zones, &settings, &control).unwrap();
    assert_eq!(verify(&region, cancelled.path.order()), Ok(cancelled.pieces));
    assert_eq!((cancelled.stop, cancelled.attempts), (Stop::Cancelled, 1));
    let control = Control { time_is_up: Some(&|| true), ..Control::default() };
    let late = solve_with(&region, &zones, &settings, &control).unwrap();
    assert_eq!(late.stop, Stop::TimeUp);
}

#[test]
fn observers_see_attempts_and_stages() {
    use Stage::{Cheapest, Ladders, Linked, Merged, Settled};

    let region = Region::rectangle(60, 60).unwrap();
    let zones =
        LayoutSpec { layout: Layout::Islands, zones: 30, side: 4 }.zones(&region, 1).unwrap();
    let attempts = AtomicU32::new(0);
    let on_attempt = |report: AttemptReport| attempts.store(report.attempts, Relaxed);
    let stages: Mutex<Vec<Stage>> = Mutex::default();
    let on_stage = |stage: Stage, _: &[[Cell; 2]]| stages.lock().unwrap().push(stage);
    let observers = Observers { attempt: Some(&on_attempt), stage: Some(&on_stage) };
    let outcome = solve(&region, &zones, &Settings { observers, ..Settings::default() }).unwrap();
    assert_eq!(attempts.into_inner(), outcome.attempts);
    assert_eq!(stages.into_inner().unwrap(), [Ladders, Cheapest, Linked, Merged, Settled]);
}

/// Progress counts cells up to a total that stays the same, whether a component takes one attempt
/// or all of them.
#[test]
fn progress_counts_cells() {
    for (region, zones) in layers() {
        for (start, attempts) in [(Terminal::Any, 50), (Terminal::Side(Side::Left), 3)] {
            let reports: Mutex<Vec<Progress>> = Mutex::default();
            let report = |progress| reports.lock().unwrap().push(progress);
            let control = Control { progress: Some(&report), ..Control::default() };
            let settings = Settings { attempts, start, ..Settings::default() };
            solve_with(&region, &zones, &settings, &control).unwrap();
            let reports = reports.into_inner().unwrap();
            let last = reports.last().unwrap();
            assert_eq!(last.done, last.total);
            assert!(reports.iter().all(|report| report.total == last.total));
            assert!(reports.is_sorted_by_key(|report| report.done), "{reports:?}");
            if start == Terminal::Any {
                assert_eq!(last.total, region.cell_count() as usize);
            }
        }
    }
}

#[test]
fn impossible_problems_are_rejected() {
    let region = Region::from_mask(2, 2, vec![true, true, true, false]).unwrap();
    let zones = Zones::new(&region, vec![0, 1, 1, 0]).unwrap();
    let error = |settings: Settings<'_>| solve(&region, &zones, &settings).unwrap_err();
    let at = Terminal::Cell;
    assert_eq!(
        error(Settings { start: at(3), ..Settings::default() }),
        SolveError::Outside { end: "start", cell: 3 }
    );
    assert_eq!(
        error(Settings { end: at(9), ..Settings::default() }),
        SolveError::Outside { end: "end", cell: 9 }
    );
    assert_eq!(
        error(Settings { start: at(1), end: at(1), ..Settings::default() }),
        SolveError::SameCell(1)
    );
    let costs = CostMatrix::uniform(1);
    assert_eq!(
        error(Settings { costs: Some(&costs), ..Settings::default() }),
        SolveError::Costs { expected: 2, got: 1 }
    );
    let other = Region::rectangle(3, 1).unwrap();
    assert_eq!(
        solve(&other, &zones, &Settings::default()).unwrap_err(),
        SolveError::Zones { expected: 3, got: 4 }
    );
    let larger = Region::rectangle(2, 2).unwrap();
    assert_eq!(
        solve(&larger, &zones, &Settings::default()).unwrap_err(),
        SolveError::NoZone { x: 1, y: 1 }
    );
    let apart = Region::from_mask(3, 1, vec![true, false, true]).unwrap();
    let one = Zones::new(&apart, vec![0; 3]).unwrap();
    let left = Terminal::Side(Side::Left);
    let settings = Settings { start: left, end: left, ..Settings::default() };
    assert_eq!(solve(&apart, &one, &settings).unwrap_err(), SolveError::NoTwoCells);
    let plus =
        Region::from_mask(3, 3, (0..9).map(|cell| [1, 3, 4, 5, 7].contains(&cell)).collect())
            .unwrap();
    let one = Zones::new(&plus, vec![0; 9]).unwrap();
    assert_eq!(solve(&plus, &one, &settings).unwrap_err(), SolveError::NoTwoCells);
    let same = Settings { start: at(1), end: Terminal::Side(Side::Top), ..Settings::default() };
    assert_eq!(solve(&plus, &one, &same).unwrap_err(), SolveError::NoTwoCells);
}

/// A corner belongs to two sides, so it may serve for either end.
#[test]
fn ends_at_corners_are_kept_to() {
    for (width, height) in [(4, 6), (6, 4), (5, 5), (3, 3)] {
        let region = Region::rectangle(width, height).unwrap();
        let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0).unwrap();
        let sides = [Side::Left, Side::Top, Side::Right, Side::Bottom].map(Terminal::Side);
        let corners = [0, width - 1, (height - 1) * width, height * width - 1].map(Terminal::Cell);
        let all = [&sides[..], &corners[..]].concat();
        for &start in &all {
            for &end in all.iter().filter(|&&end| end != start || sides.contains(&end)) {
                let outcome =
                    solve(&region, &zones, &Settings { start, end, ..Settings::default() })
                        .unwrap();
                let order = outcome.path.order();
                assert!(start.cells(&region).contains(&order[0]), "{start:?} {end:?} {order:?}");
                assert!(
                    end.cells(&region).contains(&order[order.len() - 1]),
                    "{start:?} {end:?} {order:?}"
                );
            }
        }
    }
}

/// Two blocks joined by one link: the only 2-factor has a cycle in each, but a path leads through
/// both.
#[test]
fn a_path_through_two_blocks_is_not_refuted() {
    let mask = |cell: u32| cell % 5 != 2 || cell == 2;
    let region = Region::from_mask(5, 2, (0..10).map(mask).collect()).unwrap();
    let zones = Zones::new(&region, vec![0; 10]).unwrap();
    let outcome = solve(&region, &zones, &Settings::default()).unwrap();
    assert_eq!((outcome.pieces, outcome.piece_bound), (1, 1));
}

/// A layer that differs from the one below in some cells and some zones.
fn next_layer(region: &Region, zones: &Zones, rng: &mut impl Rng) -> Option<(Region, Zones)> {
    let flips = |rng: &mut _| Rng::next_u32(rng).is_multiple_of(12);
    let mask: Vec<bool> =
        (0..region.grid_len() as Cell).map(|cell| region.contains(cell) != flips(rng)).collect();
    let count = zones.count() as u8;
    let ids = zones.ids().iter().map(|&id| {
        if id == Zones::OUTSIDE || flips(rng) { rng.random_range(0..count) } else { id }
    });
    let ids = ids.collect();
    let next = Region::from_mask(region.width(), region.height(), mask).ok()?;
    let zones = Zones::new(&next, ids).ok()?;
    Some((next, zones))
}

#[test]
fn a_start_from_the_layer_below_ends_at_the_same_optimum() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    let mut compared = 0;
    while compared < 600 {
        let (region, zones) = draw(&mut rng, 9);
        let Some((next, next_zones)) = next_layer(&region, &zones, &mut rng) else { continue };
        let below = solve(&region, &zones, &Settings::default()).unwrap();
        let scratch = solve(&next, &next_zones, &Settings::default()).unwrap();
        let aware = Settings { below: Some(&below.path), ..Settings::default() };
        let aware = solve(&next, &next_zones, &aware).unwrap();
        assert_eq!(verify(&next, aware.path.order()), Ok(aware.pieces));
        assert_eq!((aware.pieces, aware.piece_bound), (scratch.pieces, scratch.piece_bound));
        if aware.is_optimal() && scratch.is_optimal() {
            assert_eq!(aware.cost.to_bits(), scratch.cost.to_bits());
        }
        compared += 1;
    }
    let (region, other) = (Region::rectangle(3, 4).unwrap(), Region::rectangle(4, 3).unwrap());
    let zones = |region| LayoutSpec::new(Layout::LeftRight).zones(region, 0).unwrap();
    let below = solve(&other, &zones(&other), &Settings::default()).unwrap();
    let error = solve(
        &region,
        &zones(&region),
        &Settings { below: Some(&below.path), ..Settings::default() },
    );
    assert_eq!(error.unwrap_err(), SolveError::Below { expected: [3, 4], got: [4, 3] });
}

#[test]
fn the_same_layer_again_keeps_what_lies_inside_the_zones() {
    let region = Region::rectangle(30, 30).unwrap();
    for seed in 0..20 {
        let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
        let below = solve(&region, &zones, &Settings::default()).unwrap();
        let aware = Settings { below: Some(&below.path), seed: 1, ..Settings::default() };
        let aware = solve(&region, &zones, &aware).unwrap();
        assert_eq!(aware.cost.to_bits(), below.cost.to_bits());
        let kept = crate::plan::kept_links(&below.path, &aware.path);
        assert!(kept > 790, "{kept} of 899");
    }
}
