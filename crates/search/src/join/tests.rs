//! Tests of joining.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::geometry::{crosses, distance2, nearest_on_segment};
use super::*;

type Ring = Vec<[f64; 2]>;
type Segment = [[f64; 2]; 2];

fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Ring {
    vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
}

/// A rectangle with its corners moved inwards by a distance.
fn inset(ring: &Ring, by: f64) -> Ring {
    let [x, y] = ring[0];
    let [width, height] = [ring[2][0] - x, ring[2][1] - y];
    rectangle(x + by, y + by, width - 2.0 * by, height - 2.0 * by)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    distance2(a, b).sqrt()
}

#[derive(Default)]
struct Island {
    outline: Vec<Ring>,
    loops: Vec<Ring>,
    chains: Vec<Ring>,
    seams: Vec<Option<Position>>,
}

/// What is printed of one edge of a loop or chain, as shares of it.
type Printed = Vec<[f64; 2]>;

impl Island {
    fn new(outline: &[Ring], loops: Vec<Ring>, chains: &[&[[f64; 2]]]) -> Self {
        let chains = chains.iter().map(|chain| chain.to_vec()).collect();
        Self { outline: outline.to_vec(), loops, chains, seams: Vec::new() }
    }

    fn solve(&self, settings: &Settings) -> Outcome {
        let [loops, chains, outline] = [&self.loops, &self.chains, &self.outline]
            .map(|lines| lines.iter().map(|line| &line[..]).collect::<Vec<_>>());
        let (chains, seams) = (&chains[..], &self.seams[..]);
        let input = Input { loops: &loops, chains, outline: &outline, seams };
        let outcome = solve(&input, settings);
        self.check(&outcome, settings);
        outcome
    }

    /// Number of beads and its bound with steps of at most a length, with and without splices.
    fn counts(&self, max_step_mm: f64) -> [[usize; 2]; 2] {
        [0.5, 0.0].map(|slit_mm| {
            let joined = self.solve(&Settings { max_step_mm, slit_mm, ..Settings::default() });
            [joined.beads.len(), joined.bound]
        })
    }

    fn lines(&self) -> impl Iterator<Item = (Line, &Ring)> {
        let loops = self.loops.iter().enumerate().map(|(number, ring)| (Line::Loop(number), ring));
        let chains = self.chains.iter().enumerate();
        loops.chain(chains.map(|(number, chain)| (Line::Chain(number), chain)))
    }

    fn edges(line: Line, points: &Ring) -> Vec<Segment> {
        let count = points.len() - usize::from(matches!(line, Line::Chain(_)));
        (0..count).map(|edge| [points[edge], points[(edge + 1) % points.len()]]).collect()
    }

    /// Checks the first ways, the last ways, and each other way together with the first ones of all
    /// other beads.
    fn check(&self, outcome: &Outcome, settings: &Settings) {
        assert!(outcome.bound <= outcome.beads.len(), "{outcome:?}");
        let firsts: Vec<&[Piece]> = outcome.beads.iter().map(|bead| &bead.ways[0][..]).collect();
        self.check_ways(&firsts, settings);
        let lasts = outcome.beads.iter().map(|bead| &bead.ways[bead.ways.len() - 1][..]);
        self.check_ways(&lasts.collect::<Vec<_>>(), settings);
        for (number, bead) in outcome.beads.iter().enumerate() {
            for way in &bead.ways[1..] {
                let mut ways = firsts.clone();
                ways[number] = way;
                self.check_ways(&ways, settings);
            }
        }
    }

    /// Checks that everything is printed once apart from slits, and that all steps are short and
    /// clear.
    fn check_ways(&self, beads: &[&[Piece]], settings: &Settings) {
        let mut slits = 0;
        for (line, points) in self.lines() {
            let edges = Self::edges(line, points);
            let mut printed: Vec<Printed> = vec![Vec::new(); edges.len()];
            let pieces = beads.iter().flat_map(|bead| bead.iter());
            let pieces: Vec<&Piece> = pieces.filter(|piece| piece.line == line).collect();
            assert!(!pieces.is_empty(), "{line:?} is missing");
            pieces.iter().for_each(|piece| print(piece, points, &edges, &mut printed));
            let mut missing_mm = 0.0;
            for (edge, printed) in edges.iter().zip(&mut printed) {
                let length = distance(edge[0], edge[1]);
                printed.retain(|[from, to]| from < to);
                printed.sort_by(|a, b| a[0].total_cmp(&b[0]));
                let twice = printed.windows(2).map(|pair| length * (pair[0][1] - pair[1][0]));
                assert!(twice.fold(0.0, f64::max) < 1e-9, "{line:?} is printed twice: {printed:?}");
                let shares: f64 = printed.iter().map(|[from, to]| to - from).sum();
                missing_mm += length * (1.0 - shares);
            }
            let length: f64 = edges.iter().map(|edge| distance(edge[0], edge[1])).sum();
            if missing_mm > 1e-9 * (1.0 + length) {
                let count = (missing_mm / settings.slit_mm).round();
                assert!((missing_mm - count * settings.slit_mm).abs() < 1e-6, "{missing_mm}");
                slits += count as usize;
                assert!(length >= 2.0 * count * settings.slit_mm - 1e-9, "{line:?} is too short");
            }
        }
        let steps: Vec<Segment> = beads
            .iter()
            .flat_map(|bead| bead.windows(2).map(|pair| [pair[0].to, pair[1].from]))
            .map(|step| step.map(|end| end.point_mm))
            .collect();
        // Closed beads begin and end in the middle of a piece, not in a step.
        let connected = self.loops.len() + self.chains.len() - beads.len();
        assert!(slits.is_multiple_of(2) && steps.len() >= connected, "{slits} {}", steps.len());
        self.check_steps(&steps, settings.max_step_mm);
    }

    fn check_steps(&self, steps: &[Segment], max_step_mm: f64) {
        let outline = self.outline.iter().map(|ring| (Line::Loop(0), ring));
        let lines =
            self.lines().chain(outline).flat_map(|(line, points)| Self::edges(line, points));
        let lines: Vec<Segment> = lines.collect();
        for (number, &step) in steps.iter().enumerate() {
            assert!(distance(step[0], step[1]) <= max_step_mm * (1.0 + 1e-9));
            for &line in lines.iter().chain(&steps[..number]).chain(&steps[number + 1..]) {
                assert!(!crosses(step, line, 1e-3), "{step:?} crosses {line:?}");
            }
        }
    }
}

/// Adds what a piece prints to the edges of its line.
fn print(piece: &Piece, points: &Ring, edges: &[Segment], printed: &mut [Printed]) {
    let Piece { from, to, is_reversed, .. } = *piece;
    let [first, last] = if is_reversed { [to, from] } else { [from, to] };
    if edges.is_empty() {
        assert!([first, last].iter().all(|end| distance(end.point_mm, points[0]) == 0.0));
        return;
    }
    let share = |position: &Position| {
        let [a, b] = edges[position.edge];
        assert!(distance(nearest_on_segment(position.point_mm, a, b), position.point_mm) < 1e-9);
        let length = distance(a, b);
        if length > 0.0 { (distance(a, position.point_mm) / length).min(1.0) } else { 0.0 }
    };
    let [from, to] = [share(&first), share(&last)];
    if first.edge == last.edge && from < to {
        printed[first.edge].push([from, to]);
        return;
    }
    printed[first.edge].push([from, 1.0]);
    let mut edge = (first.edge + 1) % edges.len();
    while edge != last.edge {
        printed[edge].push([0.0, 1.0]);
        edge = (edge + 1) % edges.len();
    }
    printed[edge].push([0.0, to]);
}

#[test]
fn insets_and_infill_become_one_bead() {
    let outline = rectangle(0.0, 0.0, 10.0, 10.0);
    let loops = vec![inset(&outline, 0.25), inset(&outline, 0.75)];
    let island = Island::new(&[outline], loops, &[&[[1.2, 1.2], [8.8, 8.8]]]);
    let joined = island.solve(&Settings::default());
    assert_eq!((joined.beads.len(), joined.bound), (1, 1));
    assert_eq!(joined.beads[0].ways[0].len(), 3, "spliced only if need be");
    assert_eq!(island.counts(0.47), [[2, 2]; 2], "the infill is 0.45 mm away");
    assert_eq!(island.counts(0.3), [[3, 3]; 2]);
}

#[test]
fn loops_are_spliced_where_the_ends_of_chains_are_taken() {
    // Insets of a hole in the middle of the infill, which passes it at 0.6 mm.
    let outline = rectangle(0.0, 0.0, 10.0, 10.0);
    let hole = rectangle(4.0, 4.0, 2.0, 2.0);
    let loops = vec![inset(&outline, 0.25), inset(&hole, -0.25), inset(&hole, -0.75)];
    let chain = [[1.2, 1.2], [1.2, 7.35], [8.8, 7.35]];
    let island = Island::new(&[outline, hole], loops, &[&chain]);
    assert_eq!(island.counts(1.0), [[1, 1], [2, 2]]);
    let joined = island.solve(&Settings::default());
    let pieces = &joined.beads[0].ways[0];
    let of_hole =
        |number: usize| pieces.iter().filter(|piece| piece.line == Line::Loop(number)).count();
    assert_eq!([0, 1, 2].map(of_hole), [1, 1, 2], "the outer inset is spliced into the inner one");
    // The chain is 0.6 mm from the nearest inset.
    assert_eq!(island.counts(0.59), [[3, 3]; 2]);
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
    let island = Island::new(&outline, loops.collect(), &[]);
    let joined = island.solve(&Settings::default());
    assert_eq!((joined.beads.len(), joined.bound), (1, 1));
    assert!(joined.beads[0].ways.len() > 10, "it may begin anywhere");
}

#[test]
fn steps_keep_the_distance_of_their_ends() {
    // A notch of the outline reaches between two loops, but not across the step.
    let mut outline = rectangle(0.0, 0.0, 10.4, 5.0);
    outline.splice(1..1, [[5.1, 0.0], [5.2, 4.6], [5.3, 0.0]]);
    let loops = vec![rectangle(0.25, 0.25, 4.6, 4.5), rectangle(5.55, 0.25, 4.6, 4.5)];
    let island = Island::new(&[outline], loops, &[]);
    assert_eq!(island.solve(&Settings::default()).beads.len(), 1);
    let settings = Settings { clearance_mm: 0.25, ..Settings::default() };
    assert_eq!(island.solve(&settings).beads.len(), 2, "0.15 mm above the notch");
    let settings = Settings { clearance_mm: 0.1, ..Settings::default() };
    assert_eq!(island.solve(&settings).beads.len(), 1);
}

#[test]
fn steps_do_not_cross_chains() {
    // A chain of two edges lies between the end of another one and the loop.
    let outline = rectangle(0.0, 0.0, 10.0, 10.0);
    let loops = vec![inset(&outline, 0.25)];
    let straight = [[5.0, 1.0], [5.0, 8.0]];
    let mut island = Island::new(&[outline], loops, &[&straight]);
    assert_eq!(island.counts(1.0)[1], [1, 1]);
    island.chains.push(vec![[4.0, 0.6], [5.0, 0.7], [6.0, 0.6]]);
    let settings = Settings { max_step_mm: 0.9, slit_mm: 0.0, ..Settings::default() };
    let joined = island.solve(&settings);
    assert_eq!(joined.beads.len(), 2, "only the chain in between is joined to the loop");
}

#[test]
fn steps_do_not_cross_what_lies_between_loops() {
    // A skeleton between two insets nearly all around.
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
    for _ in 0..300 {
        let outline = rectangle(0.0, 0.0, 10.0, 10.0);
        let [outer, inner] = [0.25, rng.random_range(0.8..1.6)].map(|by| inset(&outline, by));
        let mut skeleton = inset(&outline, rng.random_range(0.4..0.7));
        let low = skeleton[0];
        skeleton.push([low[0], low[1] + rng.random_range(0.0..2.0)]);
        let island = Island::new(&[outline], vec![outer, inner], &[&skeleton]);
        let counts = island.counts(rng.random_range(0.3..1.6));
        assert!(counts[0][0] <= 3);
    }
}

#[test]
fn chains_share_what_loops_there_are() {
    // Two chains end near the inner loop, which can be joined to one end of each only where both
    // are within reach of the same point.
    let outline = rectangle(0.0, 0.0, 10.0, 10.0);
    let loops = vec![inset(&outline, 0.25)];
    let chains: [&[[f64; 2]]; 2] = [&[[1.0, 1.0], [1.0, 8.0]], &[[1.2, 1.0], [5.0, 5.0]]];
    let mut island = Island::new(&[outline], loops, &chains);
    assert_eq!(island.solve(&Settings::default()).beads.len(), 1);
    island.chains[1] = vec![[5.0, 1.0], [5.0, 5.0]];
    assert_eq!(island.solve(&Settings::default()).beads.len(), 2);
}

#[test]
fn nothing_is_joined_across_the_outline() {
    // Two loops on both sides of a slit.
    let outlines = [rectangle(0.0, 0.0, 5.0, 5.0), rectangle(5.2, 0.0, 5.0, 5.0)];
    let loops = outlines.iter().map(|outline| inset(outline, 0.25)).collect();
    let island = Island::new(&outlines, loops, &[]);
    assert_eq!(island.counts(1.0), [[2, 1]; 2], "the bound does not know the outline");
}

#[test]
fn the_bound_counts_steps_between_samples() {
    // The tip of the second loop is within reach of the middle of an edge only, far from samples.
    let square = rectangle(0.0, 0.0, 9.0, 9.0);
    let tip = vec![[9.9, 4.05], [14.0, 3.0], [14.0, 6.0]];
    let island = Island::new(&[], vec![tip, square], &[]);
    for max_step_mm in [0.91, 0.95, 1.0, 1.2] {
        assert_eq!(island.counts(max_step_mm).map(|[_, bound]| bound), [1, 1]);
    }
    assert_eq!(island.counts(0.89).map(|[_, bound]| bound), [2, 2]);
}

#[test]
fn the_bound_counts_steps_to_points_that_are_not_the_nearest() {
    // The nearest point of the loop lies behind a slit.
    let square = rectangle(0.0, 0.0, 4.0, 4.0);
    let outline = [rectangle(-1.0, -1.0, 6.0, 6.0), rectangle(1.9, 4.1, 0.2, 0.1)];
    let island = Island::new(&outline, vec![square], &[&[[2.0, 4.4], [2.0, 4.9]]]);
    assert_eq!(island.counts(1.0).map(|[_, bound]| bound), [1, 1]);
}

#[test]
fn ends_that_nothing_is_near_are_counted() {
    // Five chains end at one loop, whose two sides take two of their ends.
    let square = rectangle(0.0, 0.0, 9.0, 9.0);
    let x = (0..5).map(|number| 1.6 * f64::from(number) + 1.0);
    let apart: Vec<Ring> = x.map(|x| vec![[x, 8.2], [x, 3.0]]).collect();
    let apart: Vec<&[[f64; 2]]> = apart.iter().map(Vec::as_slice).collect();
    let comb = Island::new(&[], vec![square], &apart);
    assert_eq!(comb.counts(1.0)[0], [5, 4], "eight of ten ends are ends of beads");
}

#[test]
fn loops_are_cut_at_their_seams() {
    let outline = rectangle(0.0, 0.0, 10.0, 10.0);
    let loops = vec![inset(&outline, 0.25), inset(&outline, 0.75)];
    // Infill all around; both ends are far from all loops.
    let chain =
        [[5.0, 5.0], [1.3, 5.0], [1.3, 8.7], [8.7, 8.7], [8.7, 1.3], [1.3, 1.3], [5.0, 3.0]];
    let mut island = Island::new(&[outline], loops, &[&chain]);
    for seam in [[2.0, 0.25], [9.75, 6.0], [0.25, 3.3]] {
        let edge = (0..4).find(|&edge| {
            let [a, b] = [island.loops[0][edge], island.loops[0][(edge + 1) % 4]];
            distance(nearest_on_segment(seam, a, b), seam) < 1e-9
        });
        let seam = Position { edge: edge.unwrap(), point_mm: seam };
        island.seams = vec![Some(seam), None];
        let joined = island.solve(&Settings::default());
        assert_eq!(joined.beads.len(), 1);
        let cut = joined.beads[0].ways[0].iter().find(|piece| piece.line == Line::Loop(0)).unwrap();
        assert!(distance(cut.from.point_mm, seam.point_mm) < 0.6, "{cut:?}");
    }
}

/// Nested insets of a plate with holes, and chains in between.
fn random_island(rng: &mut Xoshiro256PlusPlus) -> Island {
    let [width, height] = [0, 1].map(|_| rng.random_range(4.0..20.0));
    let outer = rectangle(0.0, 0.0, width, height);
    let perimeters = rng.random_range(1..4);
    let mut loops: Vec<Ring> =
        (0..perimeters).map(|k| inset(&outer, 0.25 + 0.5 * f64::from(k))).collect();
    loops.retain(|ring| ring[0][0] < ring[2][0] && ring[0][1] < ring[2][1]);
    let mut outline = vec![outer.clone()];
    let margin = 0.5 * f64::from(perimeters) + 0.2;
    for _ in 0..rng.random_range(0..3) {
        let size = rng.random_range(0.2..3.0);
        let low = margin + 0.5 * f64::from(perimeters);
        if width > 2.0 * low + size && height > 2.0 * low + size {
            let at = [width, height].map(|side| rng.random_range(low..side - low - size));
            let hole = rectangle(at[0], at[1], size, size);
            let insets = (0..perimeters).map(|k| inset(&hole, -0.25 - 0.5 * f64::from(k)));
            let insets: Vec<Ring> = insets.collect();
            let crosses_loops = insets.iter().chain([&hole]).any(|ring| {
                let others = loops.iter().chain(&outline);
                Island::edges(Line::Loop(0), ring).iter().any(|&edge| {
                    others.clone().any(|other| {
                        let other = Island::edges(Line::Loop(0), other);
                        other.iter().any(|&other| crosses(edge, other, 0.0))
                    })
                })
            });
            if !crosses_loops {
                loops.extend(insets);
                outline.push(hole);
            }
        }
    }
    let region = inset(&outer, margin);
    let mut chains: Vec<Ring> = Vec::new();
    if region[0][0] < region[2][0] && region[0][1] < region[2][1] {
        for _ in 0..rng.random_range(0..5) {
            let point = |rng: &mut Xoshiro256PlusPlus| {
                [0, 1].map(|axis| rng.random_range(region[0][axis]..=region[2][axis]))
            };
            let mut chain = vec![point(rng)];
            chain[0][0] = region[0][0];
            for _ in 0..rng.random_range(1..6) {
                chain.push(point(rng));
                // Along the border, as links are.
                if rng.random_range(0..2) == 0 {
                    let mut next = chain[chain.len() - 1];
                    next[0] = region[rng.random_range(0..4)][0];
                    chain.push(next);
                    next[1] = region[rng.random_range(0..4)][1];
                    chain.push(next);
                }
            }
            // Chains do not cross anything.
            let is_clear = |&[a, b]: &[[f64; 2]; 2]| {
                let rings = loops.iter().flat_map(|ring| Island::edges(Line::Loop(0), ring));
                let others = chains.iter().flat_map(|chain| Island::edges(Line::Chain(0), chain));
                !rings.chain(others).any(|line| crosses([a, b], line, 0.0))
            };
            let clear = Island::edges(Line::Chain(0), &chain);
            let count = clear.iter().take_while(|edge| is_clear(edge)).count();
            chain.truncate(count + 1);
            if count > 0 {
                chains.push(chain);
            }
        }
    }
    Island { outline, loops, chains, seams: Vec::new() }
}

#[test]
fn random_islands_keep_every_part() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut total = [0; 4];
    for _ in 0..3000 {
        let mut island = random_island(&mut rng);
        if rng.random_range(0..2) == 0 {
            let corner = |ring: &Ring| {
                let edge = rng.random_range(0..ring.len());
                Some(Position { edge, point_mm: ring[edge] }).filter(|_| rng.random())
            };
            island.seams = island.loops.iter().map(corner).collect();
        }
        let max_step_mm = rng.random_range(0.4..1.6);
        let slit_mm = rng.random_range(0.2..0.7);
        let settings = Settings { max_step_mm, slit_mm, ..Settings::default() };
        let joined = island.solve(&settings);
        assert_eq!(joined, island.solve(&settings));
        let ends = island.solve(&Settings { slit_mm: 0.0, ..settings });
        assert!(joined.beads.len() <= ends.beads.len(), "splices save beads");
        assert!(joined.bound <= ends.bound);
        total[0] += island.loops.len() + island.chains.len();
        total[1] += ends.beads.len();
        total[2] += joined.beads.len();
        total[3] += joined.bound;
    }
    println!("{total:?}");
    assert!(total[3] <= total[2] && total[2] < total[1] && total[1] < total[0], "{total:?}");
}

#[test]
fn nested_squares_leave_as_many_beads_as_chains() {
    // Chains whose ends are out of reach of everything, and which pass the innermost loop.
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
    for _ in 0..1000 {
        let side = rng.random_range(16.0..40.0);
        let outer = rectangle(0.0, 0.0, side, side);
        let depth = rng.random_range(1..6);
        let insets = (0..depth).map(|k| inset(&outer, 0.25 + 0.5 * f64::from(k)));
        let loops: Vec<Ring> = insets.collect();
        let low = 0.5 * f64::from(depth) + rng.random_range(0.1..0.4);
        let count = rng.random_range(0..5);
        let pitch = (side - 2.0 * low - 2.0) / 5.0;
        let chains: Vec<Ring> = (0..count)
            .map(|number| {
                let left = low + 1.0 + pitch * f64::from(number);
                let right = left + rng.random_range(1.6..pitch.max(1.7));
                let middle = [left, right].map(|x| [x, low]);
                vec![[left, side / 2.0], middle[0], middle[1], [right, side / 2.0]]
            })
            .collect();
        let points: Vec<&[[f64; 2]]> = chains.iter().map(Vec::as_slice).collect();
        let island = Island::new(&[outer], loops, &points);
        let [spliced, ends] = island.counts(1.0);
        let expected = chains.len().max(1);
        assert!(spliced[0] <= expected && spliced[0] <= ends[0], "{spliced:?} {ends:?}");
        if chains.iter().zip(chains.iter().skip(1)).all(|(a, b)| b[0][0] - a[3][0] > 1.0) {
            assert_eq!(spliced, [expected; 2]);
        }
    }
}

#[test]
fn degenerate_input_is_left_alone() {
    let empty = Input { loops: &[], chains: &[], outline: &[], seams: &[] };
    assert_eq!(solve(&empty, &Settings::default()), Outcome { beads: Vec::new(), bound: 0 });
    let point = [[1.0, 1.0]];
    let chain = [[2.0, 2.0], [2.0, 2.0]];
    let input = Input { loops: &[&point, &[]], chains: &[&chain], ..empty };
    assert_eq!(solve(&input, &Settings::default()).beads.len(), 3, "a loop without corners");
    let input = Input { loops: &[&point], chains: &[&chain, &[]], ..empty };
    assert_eq!(solve(&input, &Settings::default()).beads.len(), 3, "a chain without points");
    let input = Input { loops: &[&point, &point], chains: &[&chain, &point], ..empty };
    let joined = solve(&input, &Settings { max_step_mm: 2.0, ..Settings::default() });
    assert_eq!((joined.beads.len(), joined.bound), (1, 1));
    for max_step_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(solve(&input, &Settings { max_step_mm, ..Settings::default() }).beads.len(), 4);
    }
    for slit_mm in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
        let settings = Settings { slit_mm, max_step_mm: 2.0, ..Settings::default() };
        assert_eq!(solve(&input, &settings).beads.len(), 1);
    }
}

#[test]
fn degenerate_loops_are_not_cut() {
    // Equal loops, loops without area, loops shorter than two slits.
    let square = rectangle(0.0, 0.0, 5.0, 5.0);
    let chain: &[[f64; 2]] = &[[2.0, 2.0], [2.0, 0.5], [3.5, 0.5], [3.5, 2.0]];
    let island = Island::new(&[], vec![square.clone(), square.clone(), square], &[chain]);
    assert_eq!(island.counts(1.0), [[1, 1], [2, 2]]);
    let flat = vec![[1.0, 0.0], [5.0, 0.0]];
    let island = Island::new(&[], vec![flat.clone(), flat], &[chain]);
    assert_eq!(island.counts(1.0)[0][0], 1);
    let speck = rectangle(3.0, 0.8, 0.2, 0.2);
    let island = Island::new(&[], vec![speck], &[chain]);
    assert_eq!(island.counts(1.0), [[2, 1], [2, 2]]);
}

#[test]
fn many_holes_are_spliced_into_the_chains_between_them() {
    let count = 6;
    let side = 5.0 * f64::from(count);
    let outer = rectangle(0.0, 0.0, side, side);
    let mut loops = vec![inset(&outer, 0.25), inset(&outer, 0.75)];
    let mut chains: Vec<Ring> = Vec::new();
    for row in (0..count).map(|row| 5.0 * f64::from(row)) {
        let mut chain: Ring = vec![[1.3, row + 0.9]];
        for column in (0..count).map(|column| 5.0 * f64::from(column)) {
            let hole = rectangle(column + 2.2, row + 2.2, 1.0, 1.0);
            loops.extend([-0.25, -0.75].map(|by| inset(&hole, by)));
            chain.push([column + 4.3, row + 0.9]);
        }
        chains.push(chain);
    }
    let chains: Vec<&[[f64; 2]]> = chains.iter().map(Vec::as_slice).collect();
    let island = Island::new(&[], loops, &chains);
    let [spliced, ends] = island.counts(1.0);
    assert_eq!(spliced[0], chains.len());
    assert!(ends[0] > 30, "each hole was a bead of its own");
}
