//! Joining end to end compared with a slow twin that finds the fewest beads of small islands.
//!
//! The twin samples every loop densely.
//! For each set of loops and chains and each element that a bead of this set may end with, it finds
//! all samples where that bead may end; the next step depends on nothing else.
//! Then it divides the elements into the fewest such sets.
//!
//! A step between samples is permitted either exactly, which gives an upper bound on the minimum
//! over all points of the loops, or within the distance of samples, which gives a lower bound.
//! Where both agree, they are the minimum.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::geometry::{crosses, distance2};
use super::*;

type Point = [f64; 2];
type Ring = Vec<Point>;

/// Distance between samples in mm.
const SAMPLE_MM: f64 = 0.06;

struct Island {
    outline: Vec<Ring>,
    loops: Vec<Ring>,
    chains: Vec<[Point; 2]>,
}

/// Points where the nozzle may enter and leave an element.
struct Element {
    points: Vec<Point>,
    is_loop: bool,
}

impl Island {
    fn solve(&self, max_step_mm: f64) -> Outcome {
        let [loops, outline] = [&self.loops, &self.outline]
            .map(|rings| rings.iter().map(|ring| &ring[..]).collect::<Vec<_>>());
        let chains: Vec<&[Point]> = self.chains.iter().map(|chain| &chain[..]).collect();
        let input = Input { loops: &loops, chains: &chains, outline: &outline, seams: &[] };
        solve(&input, &Settings { max_step_mm, slit_mm: 0.0, ..Settings::default() })
    }

    fn elements(&self) -> Vec<Element> {
        let of_loop = |ring: &Ring| {
            let points = edges(ring).flat_map(|[a, b]| {
                let count = (distance2(a, b).sqrt() / SAMPLE_MM).ceil().max(1.0) as usize;
                (0..count).map(move |step| {
                    let part = step as f64 / count as f64;
                    [0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis]))
                })
            });
            Element { points: points.collect(), is_loop: true }
        };
        let of_chain = |ends: &[Point; 2]| Element { points: ends.to_vec(), is_loop: false };
        self.loops.iter().map(of_loop).chain(self.chains.iter().map(of_chain)).collect()
    }

    /// Whether a step is permitted; if `is_lax`, also if some step between points within half a
    /// sample of its ends may be.
    fn is_step(&self, step: [Point; 2], max_step_mm: f64, is_lax: bool) -> bool {
        let slack = if is_lax { SAMPLE_MM } else { 1e-9 };
        if distance2(step[0], step[1]).sqrt() > max_step_mm + slack {
            return false;
        }
        let margin = if is_lax { SAMPLE_MM } else { 1e-4 };
        let rings = self.loops.iter().chain(&self.outline).flat_map(edges);
        !rings.chain(self.chains.iter().copied()).any(|[a, b]| {
            if !is_lax {
                return crosses(step, [a, b], margin);
            }
            // Steps that pass the end of the edge closely may also pass it on the other side.
            let share = 2.0 * SAMPLE_MM / distance2(a, b).sqrt().max(1e-9);
            let at = |share: f64| [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
            share < 0.5 && crosses(step, [at(share), at(1.0 - share)], margin)
        })
    }

    /// The fewest beads.
    fn fewest(&self, max_step_mm: f64, is_lax: bool) -> usize {
        let elements = self.elements();
        let count = elements.len();
        let first: Vec<usize> = elements
            .iter()
            .scan(0, |sum, element| {
                *sum += element.points.len();
                Some(*sum - element.points.len())
            })
            .collect();
        let points: Vec<Point> =
            elements.iter().flat_map(|element| element.points.iter().copied()).collect();
        let element_of: Vec<usize> = elements
            .iter()
            .enumerate()
            .flat_map(|(number, element)| vec![number; element.points.len()])
            .collect();
        let is_reached = |a: usize, b: usize| {
            element_of[a] != element_of[b]
                && self.is_step([points[a], points[b]], max_step_mm, is_lax)
        };
        let steps: Vec<Vec<usize>> = (0..points.len())
            .map(|a| (0..points.len()).filter(|&b| is_reached(a, b)).collect())
            .collect();

        // For each set of elements, the points where a bead of them may end.
        let mut ends = vec![vec![false; points.len()]; 1 << count];
        for (number, element) in elements.iter().enumerate() {
            for at in 0..element.points.len() {
                ends[1 << number][first[number] + at] = true;
            }
        }
        for set in 1..1_usize << count {
            for from in 0..points.len() {
                if !ends[set][from] {
                    continue;
                }
                for &to in &steps[from] {
                    let element = element_of[to];
                    if set & 1 << element == 0 {
                        // A loop is left where it was entered, a chain at its other end.
                        let exit = if elements[element].is_loop {
                            to
                        } else {
                            first[element] + 1 - (to - first[element])
                        };
                        ends[set | 1 << element][exit] = true;
                    }
                }
            }
        }
        let is_bead: Vec<bool> = ends.iter().map(|ends| ends.contains(&true)).collect();
        let mut fewest = vec![usize::MAX; 1 << count];
        fewest[0] = 0;
        for set in 1..1_usize << count {
            let mut part = set;
            while part > 0 {
                if is_bead[part] {
                    fewest[set] = fewest[set].min(1 + fewest[set & !part]);
                }
                part = (part - 1) & set;
            }
        }
        fewest[(1 << count) - 1]
    }
}

fn edges(ring: &Ring) -> impl Iterator<Item = [Point; 2]> {
    (0..ring.len()).map(|edge| [ring[edge], ring[(edge + 1) % ring.len()]])
}

fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Ring {
    vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
}

/// A rectangle moved inwards.
fn inset(ring: &Ring, by: f64) -> Option<Ring> {
    let [width, height] = [ring[2][0] - ring[0][0] - 2.0 * by, ring[2][1] - ring[0][1] - 2.0 * by];
    (width > 0.1 && height > 0.1)
        .then(|| rectangle(ring[0][0] + by, ring[0][1] + by, width, height))
}

/// Nested insets, some with a hole or a second lobe, and chains that end near them.
fn random_island(rng: &mut Xoshiro256PlusPlus) -> Island {
    let outer = rectangle(0.0, 0.0, rng.random_range(2.5..7.0), rng.random_range(2.5..7.0));
    let depth = rng.random_range(1..4);
    let mut loops: Vec<Ring> =
        (0..depth).filter_map(|k| inset(&outer, 0.25 + 0.5 * f64::from(k))).collect();
    let mut outline = vec![outer.clone()];
    let [width, height] = outer[2];
    if rng.random_range(0..3) == 0 {
        // A hole with one inset around it, somewhere inside.
        let margin = 0.5 * f64::from(depth) + 0.6;
        if width > 2.0 * margin + 0.4 && height > 2.0 * margin + 0.4 {
            let [x, y] = [width, height].map(|size| rng.random_range(margin..size - margin - 0.3));
            let hole = rectangle(x, y, 0.3, 0.3);
            loops.extend(inset(&hole, -0.25));
            outline.push(hole);
        }
    }
    let margin = 0.5 * f64::from(depth) + rng.random_range(0.0..0.3);
    let mut chains = Vec::new();
    if width > 2.0 * margin && height > 2.0 * margin {
        let side = |rng: &mut Xoshiro256PlusPlus| {
            let [x, y] = [width, height].map(|size| rng.random_range(margin..=size - margin));
            match rng.random_range(0..5) {
                0 => [margin, y],
                1 => [width - margin, y],
                2 => [x, margin],
                3 => [x, height - margin],
                _ => [x, y],
            }
        };
        for _ in 0..rng.random_range(0..4) {
            let chain = [side(rng), side(rng)];
            if !chains.iter().any(|&other| crosses(chain, other, 0.0)) {
                chains.push(chain);
            }
        }
    }
    Island { outline, loops, chains }
}

#[test]
fn beads_are_nearly_the_fewest() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let (mut known, mut optimal, mut excess, mut fewest) = (0, 0, 0, 0);
    for case in 0..200 {
        let island = random_island(&mut rng);
        let max_step_mm = rng.random_range(0.3..1.3);
        let joined = island.solve(max_step_mm);
        let [highest, lowest] = [false, true].map(|is_lax| island.fewest(max_step_mm, is_lax));
        assert!(lowest <= highest, "case {case}");
        assert!(joined.beads.len() >= lowest, "case {case}: {} < {lowest}", joined.beads.len());
        assert!(joined.bound <= highest, "case {case}: bound {} > {highest}", joined.bound);
        if lowest == highest {
            known += 1;
            optimal += usize::from(joined.beads.len() == lowest);
            excess += joined.beads.len() - lowest;
            fewest += lowest;
        }
    }
    println!("{known} minima known, {optimal} reached; {excess} more beads than {fewest}");
    assert!(known >= 170 && 10 * optimal >= 9 * known, "{optimal} of {known}");
    assert!(10 * excess <= fewest, "{excess} more than {fewest}");
}
