//! Linking of infill lines: against exhaustive search and a slow twin of the rule, and by
//! properties on regions like those of parts.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod infill;

use std::f64::consts::{FRAC_PI_4, PI};

use beadwork_base::{CancelToken, Control};
use beadwork_search::Stop;
use beadwork_search::link::{
    Bead, DirectedLine, End, Link, Links, LinksError, Method, Outcome, Point, Rule, Settings,
    solve, verify,
};
use infill::{Ring, circle, gear, gear_like, lines, square, star};
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

type Random = Xoshiro256PlusPlus;

fn run(links: &Links, settings: &Settings) -> Outcome {
    let outcome = solve(links, settings, &Control::default());
    check(links, &outcome.beads);
    assert_eq!(outcome.is_optimal(), outcome.stop == Stop::Optimal);
    outcome
}

fn beads_by(links: &Links, method: Method) -> usize {
    run(links, &Settings { method, ..Settings::default() }).beads.len()
}

/// Checks beads without using the code under test.
fn check(links: &Links, beads: &[Bead]) {
    let mut seen: Vec<u32> =
        beads.iter().flat_map(|bead| bead.lines.iter().map(|line| line.line)).collect();
    seen.sort_unstable();
    assert_eq!(seen, (0..links.line_count() as u32).collect::<Vec<_>>());
    let mut used = Vec::new();
    for bead in beads {
        assert_eq!(bead.lines.len(), bead.links.len() + 1);
        for (index, &number) in bead.links.iter().enumerate() {
            let [before, after] = [bead.lines[index], bead.lines[index + 1]];
            let exit = End { line: before.line, is_last: !before.is_reversed };
            let entry = End { line: after.line, is_last: after.is_reversed };
            let ends = links.all()[number as usize].ends;
            assert!(ends == [exit, entry] || ends == [entry, exit]);
            used.push(number);
        }
    }
    for &[a, b] in links.conflicts() {
        assert!(!(used.contains(&a) && used.contains(&b)), "links {a} and {b} cross");
    }
    assert_eq!(verify(links, beads), Ok(()));
}

/// The fewest beads, by trying all sets of links.
fn exhaustive(links: &Links) -> usize {
    /// Joins fragments; the other end of the fragment of each of its ends is known.
    fn extend(links: &Links, next: usize, others: &mut Vec<usize>, used: &mut Vec<u32>) -> usize {
        let Some(link) = links.all().get(next) else { return used.len() };
        let skipped = extend(links, next + 1, others, used);
        let [a, b] = link.ends.map(End::index);
        let is_taken = |end: usize| {
            used.iter().any(|&one| links.link(one).ends.iter().any(|one| one.index() == end))
        };
        let is_excluded = links.conflicts().iter().any(|&[p, q]| {
            (p as usize == next && used.contains(&q)) || (q as usize == next && used.contains(&p))
        });
        if is_taken(a) || is_taken(b) || others[a] == b || is_excluded {
            return skipped;
        }
        let before = others.clone();
        let [far_a, far_b] = [others[a], others[b]];
        (others[far_a], others[far_b]) = (far_b, far_a);
        used.push(next as u32);
        let taken = extend(links, next + 1, others, used);
        used.pop();
        *others = before;
        skipped.max(taken)
    }
    let mut others: Vec<usize> = (0..2 * links.line_count()).map(|end| end ^ 1).collect();
    links.line_count() - extend(links, 0, &mut others, &mut Vec::new())
}

/// Checks all methods, at several widths, against exhaustive search.
fn compare(links: &Links, seed: u64) {
    let fewest = exhaustive(links);
    let mut counts = [0; 4];
    for (count, method) in counts.iter_mut().zip(Method::ALL) {
        for links_first in [false, true] {
            let outcome =
                run(links, &Settings { method, seed, links_first, ..Settings::default() });
            *count = outcome.beads.len();
            assert!(outcome.bound <= fewest && fewest <= *count, "{method}: {links:?}");
        }
    }
    let [nearest, repetitive, break_points, cover] = counts;
    assert!(cover <= repetitive && repetitive <= break_points && break_points <= nearest);
    assert_eq!(cover, fewest, "{links:?}");
    for max_width in [1, 2, 3, 6, 20] {
        let outcome = run(links, &Settings { seed, max_width, ..Settings::default() });
        assert!(outcome.bound <= fewest && fewest <= outcome.beads.len(), "{links:?}");
    }
}

/// Links between random ends.
fn random_links(rng: &mut Random, max_links: usize) -> Links {
    let count = rng.random_range(1..=8_usize);
    let mut point = || [0, 1].map(|_| f64::from(rng.random_range(0..6)));
    let ends: Vec<[Point; 2]> = (0..count).map(|_| [point(), point()]).collect();
    let mut links: Vec<Link> = Vec::new();
    for _ in 0..rng.random_range(0..=max_links) {
        let mut ends = [0, 1].map(|_| End::from_index(rng.random_range(0..2 * count)));
        ends.sort_unstable();
        if ends[0].line != ends[1].line && links.iter().all(|link| link.ends != ends) {
            let length_mm = rng.random_range(0.0..3.0);
            links.push(Link { ends, via: Vec::new(), length_mm });
        }
    }
    let mut conflicts = Vec::new();
    if links.len() > 1 && rng.random_bool(0.5) {
        for _ in 0..rng.random_range(0..6) {
            let pair = [0, 1].map(|_| rng.random_range(0..links.len() as u32));
            if pair[0] != pair[1] {
                conflicts.push(pair);
            }
        }
    }
    Links::new(&ends, links, &conflicts).unwrap()
}

#[test]
fn random_links_give_what_exhaustive_search_gives() {
    let mut rng = Random::seed_from_u64(1);
    for seed in 0..3000 {
        compare(&random_links(&mut rng, 16), seed);
    }
}

/// The beads of nearest neighbour from an end, by scanning all ends at each step.
fn slow_nearest(links: &Links, start: End, links_first: bool) -> Vec<Bead> {
    let mut left: Vec<End> = (0..2 * links.line_count()).map(End::from_index).collect();
    let mut used: Vec<u32> = Vec::new();
    let mut beads = vec![Bead::default()];
    let mut entry = start;
    loop {
        left.retain(|end| end.line != entry.line);
        beads.last_mut().unwrap().lines.push(DirectedLine::from(entry));
        let exit = entry.other();
        let is_usable = |link: u32| {
            let [a, b] = links.all()[link as usize].ends;
            let is_excluded = links
                .conflicts()
                .iter()
                .any(|pair| pair.contains(&link) && used.iter().any(|one| pair.contains(one)));
            !is_excluded && (a == exit && left.contains(&b) || b == exit && left.contains(&a))
        };
        let usable: Vec<u32> =
            (0..links.all().len() as u32).filter(|&link| is_usable(link)).collect();
        let far = |link: u32| links.all()[link as usize].other(exit);
        let by_link = usable.iter().copied().min_by(|&a, &b| {
            links.link(a).length_mm.total_cmp(&links.link(b).length_mm).then(a.cmp(&b))
        });
        let square = |end: End| {
            let [[x, y], [u, v]] = [links.point(exit), links.point(end)];
            (x - u) * (x - u) + (y - v) * (y - v)
        };
        let by_distance =
            left.iter().copied().min_by(|&a, &b| square(a).total_cmp(&square(b)).then(a.cmp(&b)));
        let (next, link) = match (by_link.filter(|_| links_first), by_distance) {
            (Some(link), _) => (far(link), Some(link)),
            (None, Some(end)) => (end, usable.iter().copied().find(|&link| far(link) == end)),
            (None, None) => return beads,
        };
        match link {
            Some(link) => {
                beads.last_mut().unwrap().links.push(link);
                used.push(link);
            }
            None => beads.push(Bead::default()),
        }
        entry = next;
    }
}

/// The best of `rounds` rounds of break points after a first run, by slow runs.
fn slow_break_points(links: &Links, first: Vec<Bead>, links_first: bool, rounds: u32) -> Vec<Bead> {
    let mut best = first;
    for _ in 0..rounds {
        let around: Vec<End> = best
            .windows(2)
            .flat_map(|pair| {
                let [before, after] = [pair[0].lines.last(), pair[1].lines.first()];
                [before.unwrap().exit(), after.unwrap().entry()]
            })
            .collect();
        for start in around {
            let beads = slow_nearest(links, start, links_first);
            if beads.len() < best.len() {
                best = beads;
            }
        }
    }
    best
}

/// Compares nearest neighbour and break points with slow ones; returns by how many beads further
/// rounds improved on the paper's one round.
fn compare_break_points(links: &Links, seed: u64) -> usize {
    let mut saved = 0;
    for links_first in [false, true] {
        let by = |method: Method, rounds: u32| {
            run(links, &Settings { method, seed, links_first, rounds, ..Settings::default() }).beads
        };
        let first = by(Method::Nearest, 1);
        assert_eq!(first, slow_nearest(links, first[0].lines[0].entry(), links_first));
        assert_eq!(first, by(Method::BreakPoints, 0));
        let mut before = first.len();
        for rounds in [1, 2, 3, u32::MAX] {
            let beads = by(Method::BreakPoints, rounds);
            // More rounds than lines change nothing.
            let rounds = rounds.min(links.line_count() as u32);
            assert_eq!(beads, slow_break_points(links, first.clone(), links_first, rounds));
            assert!(beads.len() <= before);
            if rounds > 1 {
                saved += before - beads.len();
            }
            before = beads.len();
        }
    }
    saved
}

#[test]
fn break_points_give_what_slow_ones_give() {
    let mut rng = Random::seed_from_u64(5);
    let mut saved = 0;
    for seed in 0..2000 {
        saved += compare_break_points(&random_links(&mut rng, 16), seed);
    }
    for seed in 0..600 {
        let (rings, spacing, angle) = random_region(&mut rng);
        let lines = lines(&rings, spacing, angle);
        let links = Rule::default().links(&lines, &rings, spacing).unwrap();
        saved += compare_break_points(&links, seed);
    }
    assert!(saved > 20, "further rounds saved {saved} beads");
}

#[test]
fn only_the_first_round_reports_progress() {
    let (rings, spacing) = gear_like(100);
    let lines = lines(&rings, spacing, FRAC_PI_4);
    let links = Rule::default().links(&lines, &rings, spacing).unwrap();
    let nearest = Settings { method: Method::Nearest, links_first: false, ..Settings::default() };
    let first_starts = 2 * (run(&links, &nearest).beads.len() - 1);
    let done = std::sync::Mutex::new(vec![0]);
    let progress = |progress: beadwork_base::Progress| {
        let mut done = done.lock().unwrap();
        done.push(progress.done);
        assert_eq!(done.len(), progress.done + 1);
        assert_eq!(progress.total, first_starts);
    };
    let control = Control { progress: Some(&progress), ..Control::default() };
    let settings = Settings {
        method: Method::BreakPoints,
        links_first: false,
        rounds: u32::MAX,
        ..Settings::default()
    };
    let outcome = solve(&links, &settings, &control);
    assert_eq!(outcome.stop, Stop::Done);
    assert_eq!(done.into_inner().unwrap().last(), Some(&first_starts));
    assert!(outcome.work.runs as usize > first_starts + 1);
}

/// A random star with up to one hole, with few lines.
fn random_region(rng: &mut Random) -> (Vec<Ring>, f64, f64) {
    let spikes = rng.random_range(3..7);
    let mut rings = vec![star([0.0; 2], 10.0, spikes, rng.random_range(0.3..1.2))];
    if rng.random_bool(0.5) {
        let centre = [0, 1].map(|_| rng.random_range(-2.0..2.0));
        rings.push(circle(centre, rng.random_range(0.5..2.0), rng.random_range(3..9)));
    }
    (rings, rng.random_range(1.5..5.0), rng.random_range(0.0..PI))
}

#[test]
fn regions_give_what_exhaustive_search_gives() {
    let mut rng = Random::seed_from_u64(2);
    let mut compared = 0;
    while compared < 600 {
        let (rings, spacing, angle) = random_region(&mut rng);
        let lines = lines(&rings, spacing, angle);
        let links = Rule::default().links(&lines, &rings, spacing).unwrap();
        if links.all().len() <= 18 {
            compare(&links, compared);
            compared += 1;
        }
    }
}

/// Some regions like those of parts.
fn regions() -> Vec<(Vec<Ring>, f64)> {
    let mut regions = vec![gear_like(100), gear_like(500)];
    for (radius, spacing) in [(10.0, 0.5), (20.0, 2.5), (40.0, 2.5)] {
        let bore = circle([0.0; 2], 0.6 * radius, 80);
        regions.push((vec![circle([0.0; 2], radius, 100), bore.clone()], spacing));
        regions.push((vec![gear([0.0; 2], radius, 20, 0.1 * radius), bore], spacing));
        regions.push((vec![star([0.0; 2], radius, 9, 0.45)], spacing));
    }
    let islands = (0..4).map(|x| circle([12.0 * f64::from(x), 0.0], 5.0, 30));
    regions.push((islands.collect(), 1.0));
    regions
}

#[test]
fn methods_do_better_in_order() {
    for (rings, spacing) in regions() {
        for angle in [0.0, FRAC_PI_4, 1.2] {
            let lines = lines(&rings, spacing, angle);
            let links = Rule::default().links(&lines, &rings, spacing).unwrap();
            let nearest = beads_by(&links, Method::Nearest);
            let break_points = beads_by(&links, Method::BreakPoints);
            let repetitive = beads_by(&links, Method::Repetitive);
            let cover = run(&links, &Settings::default());
            assert!(break_points <= nearest && repetitive <= break_points);
            assert!(cover.beads.len() <= repetitive);
            assert!(cover.is_optimal(), "{} lines", lines.len());
            assert_eq!(cover, run(&links, &Settings::default()));
            let points: usize =
                cover.beads.iter().map(|bead| bead.points(&lines, &links).len()).sum();
            assert!(points >= 2 * lines.len());
        }
    }
}

#[test]
fn bounds_and_beads_meet_as_the_width_grows() {
    let (rings, spacing) = gear_like(500);
    let lines = lines(&rings, spacing, FRAC_PI_4);
    let links = Rule::default().links(&lines, &rings, spacing).unwrap();
    let best = run(&links, &Settings::default());
    assert!(best.is_optimal());
    for max_width in [1, 4, 16] {
        let outcome = run(&links, &Settings { max_width, ..Settings::default() });
        assert!(outcome.bound <= best.bound && outcome.beads.len() >= best.beads.len());
    }
}

#[test]
fn an_interrupted_search_returns_all_lines() {
    let (rings, spacing) = gear_like(500);
    let lines = lines(&rings, spacing, FRAC_PI_4);
    let links = Rule::default().links(&lines, &rings, spacing).unwrap();
    let token = CancelToken::new();
    token.cancel();
    let control = Control { cancel: Some(&token), ..Control::default() };
    for method in [Method::Repetitive, Method::BreakPoints, Method::Cover] {
        let outcome = solve(&links, &Settings { method, ..Settings::default() }, &control);
        check(&links, &outcome.beads);
        assert_eq!(outcome.stop, Stop::Cancelled, "{method}");
    }
}

/// The links by pairs of indices of ends, with their lengths.
fn pairs(links: &Links) -> Vec<(usize, usize, f64)> {
    let of = |link: &Link| (link.ends[0].index(), link.ends[1].index(), link.length_mm);
    links.all().iter().map(of).collect()
}

#[test]
fn a_square_links_along_its_sides() {
    let rings = [square(0.0, 10.0)];
    let lines = [2.0, 4.0, 6.0].map(|y| [[0.0, y], [10.0, y]]);
    let links = Rule::default().links(&lines, &rings, 2.0).unwrap();
    // From 6.0 round the top is 18 long, from 2.0 round the bottom 14.
    let expected = [(0, 1), (0, 2), (1, 3), (2, 4), (3, 5)];
    let found: Vec<(usize, usize)> = pairs(&links).iter().map(|pair| (pair.0, pair.1)).collect();
    // Both ends of one line are not linked.
    assert_eq!(found, expected[1..]);
    assert!(links.conflicts().is_empty());
    assert_eq!(beads_by(&links, Method::Cover), 1);
}

#[test]
fn the_boundary_links_where_straight_steps_leave_the_region() {
    // A notch between the two lines.
    let ring = vec![
        [0.0, 0.0],
        [10.0, 0.0],
        [10.0, 10.0],
        [5.5, 10.0],
        [5.5, 4.0],
        [4.5, 4.0],
        [4.5, 10.0],
        [0.0, 10.0],
    ];
    let lines = [[[4.5, 8.0], [0.0, 8.0]], [[5.5, 8.0], [10.0, 8.0]]];
    let links = Rule::default().links(&lines, std::slice::from_ref(&ring), 2.0).unwrap();
    assert_eq!(pairs(&links), [(0, 2, 9.0)]);
    assert_eq!(links.all()[0].via, [[4.5, 4.0], [5.5, 4.0]]);
    let bead = &run(&links, &Settings::default()).beads[0];
    let points = bead.points(&lines, &links);
    assert_eq!(points.len(), 6);
    // The limits count.
    let rule = Rule { boundary: 4.4, ..Rule::default() };
    assert!(rule.links(&lines, &[ring], 2.0).unwrap().all().is_empty());
}

#[test]
fn islands_are_not_linked() {
    let right = vec![[10.5, 0.0], [20.0, 0.0], [20.0, 10.0], [10.5, 10.0]];
    let lines = [[[0.0, 5.0], [10.0, 5.0]], [[10.5, 5.0], [20.0, 5.0]]];
    let links = Rule::default().links(&lines, &[square(0.0, 10.0), right], 1.0).unwrap();
    assert!(links.all().is_empty());
    assert_eq!(run(&links, &Settings::default()).bound, 2);
}

#[test]
fn steps_do_not_pass_lines() {
    let rings = [square(0.0, 10.0)];
    let lines = [4.0, 5.0, 6.0].map(|y| [[0.0, y], [10.0, y]]);
    let links = Rule::default().links(&lines, &rings, 1.0).unwrap();
    // The step from the first line to the third is two spacings long, but touches the second.
    assert_eq!(pairs(&links).len(), 4);
}

#[test]
fn crossing_steps_are_conflicts() {
    // Four short lines that point at the corners of a square of 1 mm from outside.
    let lines = [
        [[0.0, 0.0], [-3.0, -3.0]],
        [[1.0, 0.0], [4.0, -3.0]],
        [[1.0, 1.0], [4.0, 4.0]],
        [[0.0, 1.0], [-3.0, 4.0]],
    ];
    let links = Rule::default().links(&lines, &[square(-9.0, 9.0)], 1.0).unwrap();
    assert_eq!(links.all().len(), 6);
    let [a, b] = [0, 1].map(|k| links.link(links.conflicts()[0][k]).ends.map(End::index));
    assert_eq!((links.conflicts().len(), a, b), (1, [0, 4], [2, 6]));
}

#[test]
fn a_predicate_decides_on_pairs_in_reach() {
    let lines: Vec<[Point; 2]> =
        (0..5).map(|y| [[0.0, f64::from(y)], [9.0, f64::from(y)]]).collect();
    let mut calls = Vec::new();
    let links = Links::by_predicate(&lines, 1.5, 0.002, |a, b| {
        calls.push([a, b]);
        a.is_last
    })
    .unwrap();
    assert_eq!(calls.len(), 8);
    assert!(calls.is_sorted());
    assert_eq!(links.all().len(), 4);
    assert_eq!(beads_by(&links, Method::Cover), 3);
}

#[test]
fn degenerate_lines_have_beads() {
    let rings = [square(0.0, 10.0)];
    let mut all: Vec<Vec<Point>> = vec![vec![[0.0, 5.0]; 2]; 60];
    all.extend(vec![vec![[0.0, 6.0], [10.0, 6.0]]; 60]);
    // Along the boundary, and a single point.
    all.push(vec![[0.0, 0.0], [10.0, 0.0]]);
    all.push(vec![[3.0, 0.0]]);
    for spacing in [1e-3, 0.5, 3.0, 1e6] {
        let links = Rule::default().links(&all, &rings, spacing).unwrap();
        for method in Method::ALL {
            let settings = Settings { method, states_per_line: 300, ..Settings::default() };
            let outcome = run(&links, &settings);
            assert!(outcome.bound <= outcome.beads.len());
        }
    }
    let none: [Vec<Point>; 0] = [];
    let links = Rule::default().links(&none, &rings, 1.0).unwrap();
    let outcome = run(&links, &Settings::default());
    assert!(outcome.beads.is_empty() && outcome.is_optimal());
    // No region, and rings without edges.
    let line = [vec![[0.0, 0.0], [1.0, 0.0]]];
    for rings in [vec![], vec![vec![]], vec![vec![[0.0, 0.0]]], vec![vec![[0.0; 2], [1.0, 0.0]]]] {
        assert!(Rule::default().links(&line, &rings, 1.0).unwrap().all().is_empty());
    }
}

#[test]
fn thousands_of_coinciding_lines_have_beads() {
    let lines = vec![[[0.0, 0.0], [1.0, 0.0]]; 4000];
    let links = Rule::default().links(&lines, &[square(-5.0, 5.0)], 1.0).unwrap();
    let outcome = run(&links, &Settings::default());
    assert!(outcome.beads.len() < 4000);
}

#[test]
fn bad_input_is_an_error() {
    let rings = [square(0.0, 10.0)];
    let rule = Rule::default();
    let line = |x: f64| [vec![[0.0, 0.0], [x, 0.0]]];
    let by = |x: f64, spacing: f64| rule.links(&line(x), &rings, spacing).unwrap_err();
    assert_eq!(by(f64::NAN, 1.0), LinksError::LinePoint { line: 0 });
    assert_eq!(by(1e300, 1.0), LinksError::LinePoint { line: 0 });
    assert!(matches!(by(1.0, 0.0), LinksError::Length { name: "spacing", .. }));
    assert!(matches!(by(1.0, f64::NAN), LinksError::Length { .. }));
    let empty: [Vec<Point>; 1] = [vec![]];
    assert_eq!(rule.links(&empty, &rings, 1.0), Err(LinksError::EmptyLine { line: 0 }));
    let ring = [vec![[f64::INFINITY, 0.0]]];
    assert_eq!(rule.links(&line(1.0), &ring, 1.0), Err(LinksError::RingPoint { ring: 0 }));
    let ends = [[[0.0; 2]; 2]; 2];
    let link = |a: usize, b: usize| Link {
        ends: [a, b].map(End::from_index),
        via: Vec::new(),
        length_mm: 0.0,
    };
    let new = |links: Vec<Link>, conflicts: &[[u32; 2]]| Links::new(&ends, links, conflicts);
    assert_eq!(new(vec![link(0, 1)], &[]), Err(LinksError::Link { link: 0 }));
    assert_eq!(new(vec![link(0, 4)], &[]), Err(LinksError::Link { link: 0 }));
    let twice = vec![link(0, 2), link(2, 0)];
    assert_eq!(new(twice, &[]), Err(LinksError::DuplicateLink { link: 1 }));
    assert_eq!(new(vec![link(0, 2)], &[[0, 1]]), Err(LinksError::Conflict { conflict: 0 }));
}

/// Distance of a point from a segment.
fn distance([x, y]: Point, [a, b]: [Point; 2]) -> f64 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let share = ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy).max(1e-30);
    let share = share.clamp(0.0, 1.0);
    (x - a[0] - share * dx).hypot(y - a[1] - share * dy)
}

fn ring_edges(rings: &[Ring]) -> Vec<[Point; 2]> {
    let edges = |ring: &Ring| {
        (0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()]]).collect::<Vec<_>>()
    };
    rings.iter().flat_map(edges).collect()
}

/// Whether samples of a step show that it is permitted or not, at a tolerance.
/// The distances between samples are known up to half their step.
fn by_samples(
    step: [Point; 2],
    lines: &[Vec<Point>],
    edges: &[[Point; 2]],
    tolerance: f64,
) -> Option<bool> {
    let length = (step[1][0] - step[0][0]).hypot(step[1][1] - step[0][1]);
    let count = (4.0 * length / tolerance).ceil().max(1.0);
    let slack = length / count;
    let mut is_sure = true;
    for sample in 0..=count as usize {
        let share = sample as f64 / count;
        let point = [0, 1].map(|k| step[0][k] + share * (step[1][k] - step[0][k]));
        let crossings = edges.iter().filter(|[a, b]| {
            (a[1] > point[1]) != (b[1] > point[1])
                && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        if crossings.count() % 2 == 0 {
            let near =
                edges.iter().map(|&edge| distance(point, edge)).fold(f64::INFINITY, f64::min);
            if near > tolerance + 1e-9 {
                return Some(false);
            }
            is_sure &= near < tolerance - slack;
        }
        let from_ends = (share * length).min((1.0 - share) * length);
        if from_ends >= 10.0 * tolerance - slack {
            let segments = lines.iter().map(|line| [line[0], line[1]]);
            let near = segments.map(|line| distance(point, line)).fold(f64::INFINITY, f64::min);
            if near < tolerance - 1e-9 && from_ends >= 10.0 * tolerance {
                return Some(false);
            }
            is_sure &= near > tolerance + slack;
        }
    }
    is_sure.then_some(true)
}

#[test]
fn the_rule_permits_what_a_slow_one_permits() {
    let mut rng = Random::seed_from_u64(7);
    let mut known = [0; 2];
    let mut unknown = 0;
    let mut arcs = 0;
    for _ in 0..60 {
        let (rings, spacing, angle) = random_region(&mut rng);
        let spacing = spacing / 2.0;
        let mut lines = lines(&rings, spacing, angle);
        // Rounding, as of coordinates that come from boolean operations.
        for value in lines.iter_mut().flatten().flatten() {
            *value += (rng.next_u64() % 100) as f64 * 1e-6;
        }
        let rule = Rule { tolerance_mm: 0.01, ..Rule::default() };
        let tolerance = rule.tolerance_mm.min(spacing / 100.0);
        let links = rule.links(&lines, &rings, spacing).unwrap();
        let edges = ring_edges(&rings);
        let point = |end: End| lines[end.line as usize][usize::from(end.is_last)];
        let ends: Vec<End> = (0..2 * lines.len()).map(End::from_index).collect();
        // Positions along the rings.
        let mut marks: Vec<(usize, f64, End)> = Vec::new();
        let total = |ring: &Ring| -> f64 {
            ring_edges(std::slice::from_ref(ring))
                .iter()
                .map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1]))
                .sum()
        };
        for &end in &ends {
            for (number, ring) in rings.iter().enumerate() {
                let mut along = 0.0;
                let mut best = (tolerance, f64::NAN);
                for edge in ring_edges(std::slice::from_ref(ring)) {
                    let gap = distance(point(end), edge);
                    if gap < best.0 {
                        let [a, p] = [edge[0], point(end)];
                        best = (gap, along + (p[0] - a[0]).hypot(p[1] - a[1]));
                    }
                    along += (edge[1][0] - edge[0][0]).hypot(edge[1][1] - edge[0][1]);
                }
                if !best.1.is_nan() {
                    marks.push((number, best.1, end));
                }
            }
        }
        for (index, &a) in ends.iter().enumerate() {
            for &b in ends[index + 1..].iter().filter(|b| b.line != a.line) {
                let [p, q] = [point(a), point(b)];
                let length = (q[0] - p[0]).hypot(q[1] - p[1]);
                let found = links.between(a, b).map(|link| links.link(link));
                let straight = if length <= 2.0 * spacing {
                    by_samples([p, q], &lines, &edges, tolerance)
                } else {
                    Some(false)
                };
                let on = |end: End| marks.iter().filter(move |mark| mark.2 == end);
                let mut arc = f64::INFINITY;
                for (from, to) in on(a).flat_map(|from| on(b).map(move |to| (from, to))) {
                    if from.0 != to.0 {
                        continue;
                    }
                    let ring = from.0;
                    let size = total(&rings[ring]);
                    for (from, to) in [(from.1, to.1), (to.1, from.1)] {
                        let length = (to - from).rem_euclid(size);
                        let is_between = |mark: &&(usize, f64, End)| {
                            let along = (mark.1 - from).rem_euclid(size);
                            along > 0.0 && along < length
                        };
                        let mut on_ring = marks.iter().filter(|mark| mark.0 == ring);
                        if !on_ring.any(|mark| is_between(&mark)) {
                            arc = arc.min(length);
                        }
                    }
                }
                let is_arc = arc <= 8.0 * spacing - 3.0 * tolerance;
                match straight {
                    Some(true) => {
                        assert!(found.is_some_and(|link| link.via.is_empty()), "{a:?} {b:?}");
                        known[1] += 1;
                    }
                    Some(false) => {
                        if is_arc {
                            let link = found.unwrap();
                            // Corners within the tolerance of an end are left out.
                            assert!((link.length_mm - arc).abs() < 3.0 * tolerance);
                            arcs += 1;
                        } else if arc > 8.0 * spacing + 3.0 * tolerance {
                            assert!(found.is_none(), "{a:?} {b:?} {found:?}");
                        }
                        known[0] += 1;
                    }
                    None => unknown += 1,
                }
            }
        }
    }
    assert!(known[1] > 500 && arcs > 100 && unknown * 20 < known[1], "{known:?} {arcs} {unknown}");
}
