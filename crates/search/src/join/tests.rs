//! Tests of joining.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::geometry::{crosses, distance2, nearest_on_segment};
use super::*;

type Ring = Vec<[f64; 2]>;

fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Ring {
    vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
}

/// A rectangle with its corners moved inwards by a distance.
fn inset(ring: &Ring, by: f64) -> Ring {
    let [x, y] = ring[0];
    let [width, height] = [ring[2][0] - x, ring[2][1] - y];
    rectangle(x + by, y + by, width - 2.0 * by, height - 2.0 * by)
}

struct Island {
    outline: Vec<Ring>,
    loops: Vec<Ring>,
    chains: Vec<[[f64; 2]; 2]>,
}

impl Island {
    fn solve(&self, max_step_mm: f64) -> Outcome {
        let [loops, outline] = [&self.loops, &self.outline]
            .map(|rings| rings.iter().map(|ring| &ring[..]).collect::<Vec<_>>());
        let input = Input { loops: &loops, chains: &self.chains, outline: &outline };
        let outcome = solve(&input, &Settings { max_step_mm, ..Settings::default() });
        self.check(&outcome, max_step_mm);
        outcome
    }

    /// Checks that all loops and chains are printed once, that positions lie on their loops, and
    /// that every step of every way is short and clear.
    fn check(&self, outcome: &Outcome, max_step_mm: f64) {
        let mut seen = vec![0; self.loops.len() + self.chains.len()];
        for bead in &outcome.beads {
            assert!(!bead.ways.is_empty());
            for part in &bead.parts {
                match *part {
                    Part::Loop(number) => seen[number] += 1,
                    Part::Chain { number, .. } => seen[self.loops.len() + number] += 1,
                }
            }
            for way in &bead.ways {
                if bead.parts.len() > 1 {
                    self.check_way(bead, way, max_step_mm);
                }
            }
        }
        assert!(seen.iter().all(|&count| count == 1), "{seen:?}");
        assert!(outcome.bound <= outcome.beads.len());
    }

    fn check_way(&self, bead: &Bead, way: &[OnLoop], max_step_mm: f64) {
        let mut positions = way.iter();
        let mut before: Option<[f64; 2]> = None;
        for part in &bead.parts {
            let (start, end) = match *part {
                Part::Loop(number) => {
                    let at = positions.next().unwrap();
                    let ring = &self.loops[number];
                    let [a, b] = [ring[at.edge], ring[(at.edge + 1) % ring.len()]];
                    let on = nearest_on_segment(at.point_mm, a, b);
                    assert!(distance2(on, at.point_mm) < 1e-12);
                    (at.point_mm, at.point_mm)
                }
                Part::Chain { number, is_reversed } => {
                    let [a, b] = self.chains[number];
                    if is_reversed { (b, a) } else { (a, b) }
                }
            };
            if let Some(before) = before.replace(end) {
                assert!(distance2(before, start).sqrt() <= max_step_mm * (1.0 + 1e-9));
                for ring in self.loops.iter().chain(&self.outline) {
                    for edge in 0..ring.len() {
                        let line = [ring[edge], ring[(edge + 1) % ring.len()]];
                        assert!(!crosses([before, start], line, 1e-3));
                    }
                }
            }
        }
        assert!(positions.next().is_none());
    }
}

#[test]
fn insets_and_infill_become_one_bead() {
    let outline = rectangle(0.0, 0.0, 10.0, 10.0);
    let loops = vec![inset(&outline, 0.25), inset(&outline, 0.75)];
    let chains = vec![[[1.2, 1.2], [8.8, 8.8]]];
    let island = Island { outline: vec![outline], loops, chains };
    let joined = island.solve(1.0);
    assert_eq!((joined.beads.len(), joined.bound), (1, 1));
    assert_eq!(joined.beads[0].parts.len(), 3);
    assert_eq!(island.solve(0.47).beads.len(), 2, "the infill is 0.45 mm away");
    assert_eq!(island.solve(0.3).beads.len(), 3);
}

#[test]
fn a_ring_with_thin_walls_becomes_one_bead() {
    // Insets of both sides of the wall are within reach of each other.
    let outline = [rectangle(0.0, 0.0, 20.0, 20.0), rectangle(2.2, 2.2, 15.6, 15.6)];
    let loops =
        [0.25, 0.75].map(|by| inset(&outline[0], by)).into_iter().chain([-0.75, -0.25].map(|by| {
            let mut hole = inset(&outline[1], by);
            hole.reverse();
            hole
        }));
    let island = Island { loops: loops.collect(), outline: outline.to_vec(), chains: Vec::new() };
    let joined = island.solve(1.0);
    assert_eq!((joined.beads.len(), joined.bound), (1, 1));
    assert!(joined.beads[0].ways.len() > 10, "it may begin anywhere");
}

#[test]
fn steps_keep_the_distance_of_their_ends() {
    // A notch of the outline reaches between two loops, but not across the step.
    let mut outline = rectangle(0.0, 0.0, 10.4, 5.0);
    outline.splice(1..1, [[5.1, 0.0], [5.2, 4.6], [5.3, 0.0]]);
    let loops = vec![rectangle(0.25, 0.25, 4.6, 4.5), rectangle(5.55, 0.25, 4.6, 4.5)];
    let island =
        Island { outline: vec![outline.clone()], loops: loops.clone(), chains: Vec::new() };
    assert_eq!(island.solve(1.0).beads.len(), 1);
    let rings: Vec<&[[f64; 2]]> = loops.iter().map(Vec::as_slice).collect();
    let input = Input { loops: &rings, chains: &[], outline: &[&outline] };
    let settings = Settings { clearance_mm: 0.25, ..Settings::default() };
    assert_eq!(solve(&input, &settings).beads.len(), 2, "0.15 mm above the notch");
    let settings = Settings { clearance_mm: 0.1, ..Settings::default() };
    assert_eq!(solve(&input, &settings).beads.len(), 1);
}

#[test]
fn chains_share_what_loops_there_are() {
    // Two chains end near the inner loop, which can be joined to one end of each only where both
    // are within reach of the same point.
    let outline = rectangle(0.0, 0.0, 10.0, 10.0);
    let loops = vec![inset(&outline, 0.25)];
    let near = vec![[[1.0, 1.0], [1.0, 8.0]], [[1.2, 1.0], [5.0, 5.0]]];
    let far = vec![[[1.0, 1.0], [1.0, 8.0]], [[5.0, 1.0], [5.0, 5.0]]];
    let mut island = Island { outline: vec![outline], loops, chains: near };
    assert_eq!(island.solve(1.0).beads.len(), 1);
    island.chains = far;
    assert_eq!(island.solve(1.0).beads.len(), 2);
}

#[test]
fn nothing_is_joined_across_the_outline() {
    // Two loops on both sides of a slit.
    let outlines = [rectangle(0.0, 0.0, 5.0, 5.0), rectangle(5.2, 0.0, 5.0, 5.0)];
    let loops = outlines.iter().map(|outline| inset(outline, 0.25)).collect();
    let island = Island { outline: outlines.to_vec(), loops, chains: Vec::new() };
    let joined = island.solve(1.0);
    assert_eq!((joined.beads.len(), joined.bound), (2, 1), "the bound does not know the outline");
}

#[test]
fn the_bound_counts_steps_between_samples() {
    // The tip of the second loop is within reach of the middle of an edge only, far from samples.
    let square = rectangle(0.0, 0.0, 9.0, 9.0);
    let tip = vec![[9.9, 4.05], [14.0, 3.0], [14.0, 6.0]];
    let island = Island { outline: Vec::new(), loops: vec![tip, square], chains: Vec::new() };
    for max_step_mm in [0.91, 0.95, 1.0, 1.2] {
        assert_eq!(island.solve(max_step_mm).bound, 1);
    }
    assert_eq!(island.solve(0.89).bound, 2);
}

#[test]
fn the_bound_counts_steps_to_points_that_are_not_the_nearest() {
    // The nearest point of the loop lies behind a slit.
    let square = rectangle(0.0, 0.0, 4.0, 4.0);
    let slit = rectangle(1.9, 4.1, 0.2, 0.1);
    let island = Island {
        outline: vec![rectangle(-1.0, -1.0, 6.0, 6.0), slit],
        loops: vec![square],
        chains: vec![[[2.0, 4.4], [2.0, 4.9]]],
    };
    assert_eq!(island.solve(1.0).bound, 1);
}

#[test]
fn random_islands_keep_every_part() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut total = [0; 3];
    for _ in 0..400 {
        let outer = rectangle(0.0, 0.0, rng.random_range(4.0..20.0), rng.random_range(4.0..20.0));
        let perimeters = rng.random_range(1..4);
        let mut loops: Vec<Ring> =
            (0..perimeters).map(|k| inset(&outer, 0.25 + 0.5 * f64::from(k))).collect();
        loops.retain(|ring| ring[0][0] < ring[2][0] && ring[0][1] < ring[2][1]);
        let margin = 0.5 * f64::from(perimeters) + 0.2;
        let region = inset(&outer, margin);
        let mut chains = Vec::new();
        if region[0][0] < region[2][0] && region[0][1] < region[2][1] {
            for _ in 0..rng.random_range(0..5) {
                let mut point =
                    || [0, 1].map(|axis| rng.random_range(region[0][axis]..=region[2][axis]));
                let mut ends = [point(), point()];
                ends[0][0] = region[0][0];
                chains.push(ends);
            }
        }
        let elements = loops.len() + chains.len();
        let island = Island { outline: vec![outer], loops, chains };
        let max_step_mm = rng.random_range(0.4..1.6);
        let joined = island.solve(max_step_mm);
        assert_eq!(joined, island.solve(max_step_mm));
        total[0] += elements;
        total[1] += joined.beads.len();
        total[2] += joined.bound;
    }
    assert!(total[2] <= total[1] && total[1] < total[0], "{total:?}");
}

#[test]
fn degenerate_input_is_left_alone() {
    let empty = Input { loops: &[], chains: &[], outline: &[] };
    assert_eq!(solve(&empty, &Settings::default()), Outcome { beads: Vec::new(), bound: 0 });
    let point = [[1.0, 1.0]];
    let chain = [[2.0, 2.0], [2.0, 2.0]];
    let input = Input { loops: &[&point, &[]], chains: &[chain], outline: &[] };
    assert_eq!(solve(&input, &Settings::default()).beads.len(), 3, "a loop without corners");
    let input = Input { loops: &[&point, &point], ..input };
    let joined = solve(&input, &Settings { max_step_mm: 2.0, ..Settings::default() });
    assert_eq!((joined.beads.len(), joined.bound), (1, 1));
    for max_step_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(solve(&input, &Settings { max_step_mm, ..Settings::default() }).beads.len(), 3);
    }
}
