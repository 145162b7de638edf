//! Where a loop can be spliced into another loop or a chain.

use super::bead::{Line, Position};
use super::curves::{Curves, Slit};
use super::geometry::crosses;
use super::path::Path;
use super::surroundings::Surroundings;
use crate::segment::{Segment, length};

/// Minimum distance between the two ends of a slit, as a share of its length along the path.
const MIN_CHORD: f64 = 0.7;
/// Length of the run around a slit that should be straight, in multiples of the slit.
const RUN: f64 = 3.0;
/// How much an uneven or bent splice costs, in mm of a step for each mm of deviation.
const DEVIATION_COST: f64 = 2.0;
/// How much a slit costs for each mm of distance from the seam of its loop.
const SEAM_COST: f64 = 0.5;
/// Minimum distance of a step from steps of other splices, in multiples of the slit.
const STEP_DISTANCE: f64 = 0.5;

/// The loops and chains of an island.
pub(super) struct Scene<'a> {
    /// Loops before chains.
    pub(super) paths: &'a [Path],
    pub(super) loop_count: usize,
    pub(super) near: Surroundings<'a>,
    /// For each loop, where it should be cut; may be shorter than the number of loops.
    pub(super) seams: &'a [Option<Position>],
    pub(super) slit_mm: f64,
}

/// A possible splice of a loop into another path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Splice {
    /// The loop and the other path.
    pub(super) paths: [usize; 2],
    /// Centres of both slits, as distances along the paths in mm.
    centres_mm: [f64; 2],
    cost: f64,
}

impl Scene<'_> {
    fn path_of(&self, line: Line) -> usize {
        match line {
            Line::Loop(number) => number,
            Line::Chain(number) => self.loop_count + number,
        }
    }

    /// All splices of some loops into other paths whose steps are short enough, best first.
    ///
    /// Steps are not yet compared with what lies around them.
    /// O(n log n) for paths of n slits, as long as few of them are within reach of each.
    pub(super) fn splices(&self, rings: &[usize]) -> Vec<Splice> {
        let mut found = Vec::new();
        for &ring in rings {
            let path = &self.paths[ring];
            let count = (path.length_mm() / self.slit_mm).floor();
            if count < 2.0 {
                continue;
            }
            // Very long loops are sampled more coarsely.
            let count = count.min(1e5) as usize;
            for sample in 0..count {
                let at_mm = path.length_mm() * (sample as f64 + 0.5) / count as f64;
                for (line, nearest) in self.near.lines_near(path.position(at_mm).point_mm) {
                    let host = self.path_of(line);
                    if host != ring {
                        let centres_mm = [at_mm, self.paths[host].at_mm(&nearest)];
                        let paths = [ring, host];
                        if let Some(cost) = self.cost(paths, centres_mm) {
                            found.push(Splice { paths, centres_mm, cost });
                        }
                    }
                }
            }
        }
        found.sort_by(|a, b| {
            let by_cost = a.cost.total_cmp(&b.cost).then(a.paths.cmp(&b.paths));
            by_cost.then(a.centres_mm[0].total_cmp(&b.centres_mm[0]))
        });
        found
    }

    fn slits(&self, paths: [usize; 2], centres_mm: [f64; 2]) -> [Slit; 2] {
        [0, 1].map(|side| {
            let at_mm = [-0.5, 0.5].map(|share| centres_mm[side] + share * self.slit_mm);
            Slit { path: paths[side], at_mm }
        })
    }

    /// The points of a path at two distances along it; `None` if it has not so much length.
    fn ends(&self, slit: Slit) -> Option<Segment> {
        let path = &self.paths[slit.path];
        let fits = if path.is_loop {
            path.length_mm() >= 2.0 * self.slit_mm
        } else {
            slit.at_mm[0] >= 0.0 && slit.at_mm[1] <= path.length_mm()
        };
        fits.then(|| slit.at_mm.map(|at_mm| path.position(at_mm).point_mm))
    }

    /// Both steps of a splice, and whether they lead from the beginning of one slit to the end of
    /// the other; `None` if they are too long or cross each other.
    fn steps(&self, slits: [Slit; 2]) -> Option<([Segment; 2], bool)> {
        let [a, b] = [self.ends(slits[0])?, self.ends(slits[1])?];
        if length(a).min(length(b)) < MIN_CHORD * self.slit_mm {
            return None;
        }
        let [straight, crossed] = [[[a[0], b[0]], [a[1], b[1]]], [[a[0], b[1]], [a[1], b[0]]]];
        let sum = |steps: [Segment; 2]| length(steps[0]) + length(steps[1]);
        let is_crossed = sum(crossed) < sum(straight);
        let steps = if is_crossed { crossed } else { straight };
        let is_short = steps.iter().all(|&step| length(step) <= self.near.reach_mm());
        (is_short && !crosses(steps[0], steps[1], 0.0)).then_some((steps, is_crossed))
    }

    /// How bad a splice is: long steps, uneven ones, bent paths, and slits far from seams.
    fn cost(&self, paths: [usize; 2], centres_mm: [f64; 2]) -> Option<f64> {
        let slits = self.slits(paths, centres_mm);
        let (steps, _) = self.steps(slits)?;
        let lengths = steps.map(length);
        let mut cost = lengths[0].max(lengths[1]);
        cost += DEVIATION_COST * (lengths[0] - lengths[1]).abs();
        for slit in slits {
            cost += DEVIATION_COST * (RUN * self.slit_mm - self.run_mm(slit)).max(0.0);
            if let Some(Some(seam)) = self.seams.get(slit.path) {
                let path = &self.paths[slit.path];
                let centre_mm = path.wrap(f64::midpoint(slit.at_mm[0], slit.at_mm[1]));
                cost += SEAM_COST * path.between_mm(centre_mm, path.at_mm(seam));
            }
        }
        Some(cost)
    }

    /// Length of the chord of the run around a slit.
    fn run_mm(&self, slit: Slit) -> f64 {
        let path = &self.paths[slit.path];
        let more_mm = (RUN - 1.0) / 2.0 * self.slit_mm;
        let run = [slit.at_mm[0] - more_mm, slit.at_mm[1] + more_mm];
        length(run.map(|at_mm| path.position(at_mm).point_mm))
    }

    /// Splices two curves, of which at least one is closed, if that is possible.
    pub(super) fn try_splice(&self, curves: &mut Curves<'_>, splice: &Splice) -> bool {
        let [a, b] = splice.paths;
        if curves.curve(a) == curves.curve(b) || (curves.is_open(a) && curves.is_open(b)) {
            return false;
        }
        let slits = self.slits(splice.paths, splice.centres_mm);
        if !slits.iter().all(|&slit| curves.is_free(slit, self.slit_mm)) {
            return false;
        }
        let Some((steps, is_crossed)) = self.steps(slits) else { return false };
        let is_clear = steps.iter().all(|&[from, to]| {
            self.near.is_step(from, to)
                && !curves.steps().any_near([from, to], STEP_DISTANCE * self.slit_mm)
        });
        if is_clear {
            curves.splice(slits, is_crossed);
        }
        is_clear
    }
}
