//! Curves under construction: loops and chains cut open and connected by steps.

use super::bead::{Line, Piece, Position};
use super::path::Path;
use super::sequence::{Part, Sequence};
use super::steps::Steps;
use crate::disjoint_sets::DisjointSets;

/// Distance in mm below which points are the same.
const SAME_MM: f64 = 1e-4;

/// All loops and chains of an island, cut at some points, with steps between the cuts.
///
/// Without cuts, each loop is a closed curve and each chain an open one.
/// Every cut has two sides, which are ends of what is left of the path, the **arcs**.
/// A step connects two ends, and each end has at most one step, so that the arcs form open and
/// closed curves at any time.
pub(super) struct Curves<'a> {
    /// Loops before chains.
    paths: &'a [Path],
    loop_count: usize,
    ends: Vec<End>,
    /// For each path its ends in order along it.
    on_path: Vec<Vec<usize>>,
    /// Paths of the same curve.
    sets: DisjointSets,
    /// For the representative of each curve, whether it has free ends.
    is_open: Vec<bool>,
    steps: Steps,
}

/// An end of an arc.
struct End {
    path: usize,
    at_mm: f64,
    position: Position,
    /// Whether its arc begins here, in the direction of the path; otherwise it ends here.
    is_begin: bool,
    /// The end at the other side of its step.
    partner: Option<usize>,
}

/// A short interval that is cut out of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slit {
    pub(super) path: usize,
    /// Where it begins and ends along the path in mm.
    pub(super) at_mm: [f64; 2],
}

impl<'a> Curves<'a> {
    /// No cuts; steps will be at most `reach_mm` long.
    pub(super) fn new(paths: &'a [Path], loop_count: usize, reach_mm: f64) -> Self {
        let mut curves = Self {
            paths,
            loop_count,
            ends: Vec::new(),
            on_path: vec![Vec::new(); paths.len()],
            sets: DisjointSets::new(paths.len()),
            is_open: (0..paths.len()).map(|path| path >= loop_count).collect(),
            steps: Steps::new(reach_mm),
        };
        for (number, path) in paths.iter().enumerate().skip(loop_count) {
            let [first, last] = path.chain_ends();
            curves.add_end(number, 0.0, first, true);
            curves.add_end(number, path.length_mm(), last, false);
        }
        curves
    }

    pub(super) fn steps(&self) -> &Steps {
        &self.steps
    }

    /// A number that paths of the same curve have in common.
    pub(super) fn curve(&mut self, path: usize) -> usize {
        self.sets.find(path as u32) as usize
    }

    pub(super) fn is_open(&mut self, path: usize) -> bool {
        let curve = self.curve(path);
        self.is_open[curve]
    }

    fn line(&self, path: usize) -> Line {
        if path < self.loop_count { Line::Loop(path) } else { Line::Chain(path - self.loop_count) }
    }

    fn add_end(&mut self, path: usize, at_mm: f64, position: Position, is_begin: bool) -> usize {
        let number = self.ends.len();
        self.ends.push(End { path, at_mm, position, is_begin, partner: None });
        let key = |end: usize| (self.ends[end].at_mm, self.ends[end].is_begin);
        let is_before = |&other: &usize| {
            let (a, b) = (key(other), key(number));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).is_lt()
        };
        let at = self.on_path[path].partition_point(is_before);
        self.on_path[path].insert(at, number);
        number
    }

    /// The other end of the arc of an end.
    fn across(&self, end: usize) -> usize {
        let End { path, is_begin, .. } = self.ends[end];
        let on_path = &self.on_path[path];
        let at = on_path.iter().position(|&other| other == end).expect("ends lie on their path");
        let count = on_path.len();
        on_path[if is_begin { at + 1 } else { at + count - 1 } % count]
    }

    fn connect(&mut self, ends: [usize; 2]) {
        let [a, b] = ends;
        (self.ends[a].partner, self.ends[b].partner) = (Some(b), Some(a));
        self.steps.push(ends.map(|end| self.ends[end].position.point_mm));
        let paths = ends.map(|end| self.ends[end].path as u32);
        self.sets.union(paths[0], paths[1]);
    }

    /// Connects the loops and chains of a sequence end to end, in one of its ways.
    ///
    /// A step that crosses another one is left out, so the sequence becomes two curves.
    pub(super) fn follow(&mut self, sequence: &Sequence, way: usize) {
        let mut before: Option<usize> = None;
        let mut begins = sequence.ways[way].iter();
        for &part in &sequence.parts {
            let [entrance, exit] = match part {
                Part::Loop(ring) => {
                    let &position = begins.next().expect("a way has a point for each loop");
                    let at_mm = self.paths[ring].wrap(self.paths[ring].at_mm(&position));
                    let exit = self.add_end(ring, at_mm, position, false);
                    [self.add_end(ring, at_mm, position, true), exit]
                }
                Part::Chain { number, is_reversed } => {
                    let on_path = &self.on_path[self.loop_count + number];
                    let ends = [on_path[0], on_path[on_path.len() - 1]];
                    if is_reversed { [ends[1], ends[0]] } else { ends }
                }
            };
            if let Some(before) = before {
                let step = [before, entrance].map(|end| self.ends[end].position.point_mm);
                if !self.steps.any_near(step, 0.0) {
                    self.connect([before, entrance]);
                }
            }
            let curve = self.curve(self.ends[exit].path);
            self.is_open[curve] = true;
            before = Some(exit);
        }
    }

    /// Whether a slit keeps a distance from all cuts of its path, and from its ends.
    pub(super) fn is_free(&self, slit: Slit, distance_mm: f64) -> bool {
        let path = &self.paths[slit.path];
        let half_mm = (slit.at_mm[1] - slit.at_mm[0]) / 2.0;
        let centre_mm = path.wrap(slit.at_mm[0] + half_mm);
        let is_far = |&end: &usize| {
            let apart_mm = path.between_mm(self.ends[end].at_mm, centre_mm);
            apart_mm >= half_mm + distance_mm
        };
        self.on_path[slit.path].iter().all(is_far)
    }

    /// Cuts slits out of paths of two curves, of which at least one is closed, and connects them:
    /// begin to begin and end to end, or if `is_crossed` begin to end.
    pub(super) fn splice(&mut self, slits: [Slit; 2], is_crossed: bool) {
        let [a, b] = slits.map(|slit| {
            [0, 1].map(|side| {
                let path = &self.paths[slit.path];
                let at_mm = path.wrap(slit.at_mm[side]);
                self.add_end(slit.path, at_mm, path.position(at_mm), side == 1)
            })
        });
        let is_open = slits.map(|slit| self.is_open(slit.path));
        for side in 0..2 {
            self.connect([a[side], b[if is_crossed { 1 - side } else { side }]]);
        }
        let curve = self.curve(slits[0].path);
        self.is_open[curve] = is_open[0] || is_open[1];
    }

    /// Whether a loop is cut or connected at all.
    pub(super) fn is_cut(&self, path: usize) -> bool {
        !self.on_path[path].is_empty()
    }

    /// Number of cuts of a path, with the ends of a chain counted as one.
    pub(super) fn cut_count(&self, path: usize) -> usize {
        self.on_path[path].len() / 2
    }

    /// The pieces from an end on, to a free end or back to this one.
    fn walk(&self, from: usize) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let mut here = from;
        loop {
            let across = self.across(here);
            let End { path, position, is_begin, partner, .. } = self.ends[across];
            let from_position = self.ends[here].position;
            // Whole loops have a direction of their own.
            let is_whole = path < self.loop_count && from_position == position;
            pieces.push(Piece {
                line: self.line(path),
                from: from_position,
                to: position,
                is_reversed: is_begin && !is_whole,
            });
            match partner {
                Some(next) if next != from => here = next,
                _ => return pieces,
            }
        }
    }

    /// The pieces of all open curves, each with the number of the curve, in the order of their
    /// first free end.
    pub(super) fn open_curves(&mut self) -> Vec<(usize, Vec<Piece>)> {
        let mut found: Vec<(usize, Vec<Piece>)> = Vec::new();
        let mut is_found = vec![false; self.paths.len()];
        for end in 0..self.ends.len() {
            let curve = self.curve(self.ends[end].path);
            if self.ends[end].partner.is_none() && !std::mem::replace(&mut is_found[curve], true) {
                found.push((curve, self.walk(end)));
            }
        }
        found
    }

    /// The pieces of the closed curve of a loop that has cuts, beginning and ending at one of its
    /// points; `None` if the point lies in a slit.
    pub(super) fn closed_curve(&self, ring: usize, begin: Position) -> Option<Vec<Piece>> {
        let path = &self.paths[ring];
        let at_mm = path.wrap(path.at_mm(&begin));
        let is_within = |&end: &usize| {
            let from_mm = self.ends[end].at_mm;
            let size_mm = path.wrap(self.ends[self.across(end)].at_mm - from_mm);
            let offset_mm = path.wrap(at_mm - from_mm);
            self.ends[end].is_begin && offset_mm > SAME_MM && offset_mm < size_mm - SAME_MM
        };
        let entrance = *self.on_path[ring].iter().find(|end| is_within(end))?;
        let mut pieces = self.walk(entrance);
        let first = pieces[0];
        pieces[0] = Piece { from: begin, ..first };
        pieces.push(Piece { to: begin, ..first });
        Some(pieces)
    }

    /// The pieces of the closed curve of a loop that has cuts, beginning and ending at a cut.
    pub(super) fn closed_curve_at_cut(&self, ring: usize) -> Vec<Piece> {
        self.walk(self.on_path[ring][0])
    }
}
