//! Joins the loops and chains of an island.

use super::bead::{Bead, Line, Piece, Position};
use super::bound::bound;
use super::candidates::{Attachment, attachments};
use super::ends::{First, JoinedLoops};
use super::path::Path;
use super::slits::Scene;
use super::splice::splice;
use super::surroundings::{Chains, Rings};

/// Loops and chains of one island; coordinates are mm.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The corners of each closed loop, at least one; the last is joined to the first.
    pub loops: &'a [&'a [[f64; 2]]],
    /// The points of each open chain, at least one.
    pub chains: &'a [&'a [[f64; 2]]],
    /// The rings of the outline, which steps do not cross.
    pub outline: &'a [&'a [[f64; 2]]],
    /// For each loop, where it should begin or be cut open, if that matters.
    /// Loops without an entry may begin anywhere.
    pub seams: &'a [Option<Position>],
}

/// Settings of [`solve`].
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Maximum length in mm of a step between two loops or chains.
    /// More than the distance between two insets; if it is not more than 0, nothing is joined.
    pub max_step_mm: f64,
    /// Distance in mm that steps keep from the outline, about half the width of a bead.
    /// A step whose ends are nearer to the outline must not come nearer than its ends.
    pub clearance_mm: f64,
    /// Length in mm that is cut out of both lines where a loop is spliced into another line: the
    /// width of a bead, so that the two steps side by side fill what is cut out.
    /// If it is not more than 0, lines are joined end to end only.
    pub slit_mm: f64,
}

impl Default for Settings {
    /// Steps of 1 mm, two beads of 0.5 mm, which may touch the outline; slits of one bead.
    fn default() -> Self {
        Self { max_step_mm: 1.0, clearance_mm: 0.0, slit_mm: 0.5 }
    }
}

/// Joined beads.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The beads; together they print every loop and chain once, apart from slits.
    pub beads: Vec<Bead>,
    /// Proven lower bound on the number of beads.
    pub bound: usize,
}

/// Joins the loops and chains of an island into few beads.
///
/// Takes about O(n log n) for n corners and slits along the loops, as long as few of them lie
/// within a step of each other.
pub fn solve(input: &Input<'_>, settings: &Settings) -> Outcome {
    Loops::new(input.loops, input.outline, input.seams, settings).join(input.chains)
}

/// The loops of an island, prepared to be joined with different chains.
pub struct Loops<'a> {
    /// The corners of each loop.
    rings: &'a [&'a [[f64; 2]]],
    seams: &'a [Option<Position>],
    slit_mm: f64,
    /// `None` if nothing is joined.
    prepared: Option<Prepared>,
}

struct Prepared {
    rings: Rings,
    joined: JoinedLoops,
    /// Pairs of loops with points within reach of each other, whatever lies between.
    near_pairs: Vec<[usize; 2]>,
}

impl<'a> Loops<'a> {
    /// Prepares the loops and the outline of an island; see [`Input`].
    pub fn new(
        loops: &'a [&'a [[f64; 2]]],
        outline: &[&[[f64; 2]]],
        seams: &'a [Option<Position>],
        settings: &Settings,
    ) -> Self {
        let is_valid = settings.max_step_mm > 0.0
            && settings.max_step_mm.is_finite()
            && settings.clearance_mm >= 0.0
            && settings.clearance_mm.is_finite()
            && loops.iter().all(|ring| !ring.is_empty());
        let prepared = is_valid.then(|| {
            let rings = Rings::new(loops, outline, settings.max_step_mm, settings.clearance_mm);
            let joined = JoinedLoops::new(&rings.with(None));
            let near_pairs = rings.with(None).near_pairs();
            Prepared { rings, joined, near_pairs }
        });
        let slit_mm = if settings.slit_mm.is_finite() { settings.slit_mm.max(0.0) } else { 0.0 };
        Self { rings: loops, seams, slit_mm, prepared }
    }

    /// All ends of chains that can be joined to the nearest point of a loop, for callers who choose
    /// the ends of their chains accordingly.
    ///
    /// Sorted by chain, end and loop.
    /// O(n) for n ends, as long as few edges lie within a step of each.
    pub fn attachments(&self, chains: &[[[f64; 2]; 2]]) -> Vec<Attachment> {
        let prepared = self.prepared.as_ref();
        prepared.map_or(Vec::new(), |prepared| attachments(chains, &prepared.rings.with(None)))
    }

    /// Joins the loops and these chains into few beads; see [`solve`].
    pub fn join(&self, chains: &[&[[f64; 2]]]) -> Outcome {
        let Some(prepared) = self.prepared.as_ref().filter(|_| !chains.contains(&&[][..])) else {
            return self.separate(chains);
        };
        let ends: Vec<[[f64; 2]; 2]> =
            chains.iter().map(|chain| [chain[0], chain[chain.len() - 1]]).collect();
        let lines = Chains::new(chains, prepared.rings.reach_mm());
        let near = prepared.rings.with(Some(&lines));
        let attachments = attachments(&ends, &near);
        let candidates = prepared.joined.candidates(&ends, &attachments, &near);
        let bound = bound(&ends, &candidates, &prepared.near_pairs, self.slit_mm > 0.0, &near);

        let loops = self.rings.iter().map(|ring| Path::new(ring, true));
        let paths: Vec<Path> =
            loops.chain(chains.iter().map(|chain| Path::new(chain, false))).collect();
        let scene = Scene {
            paths: &paths,
            loop_count: self.rings.len(),
            near,
            seams: self.seams,
            slit_mm: self.slit_mm,
        };
        let rank =
            |beads: &Vec<Bead>| (beads.len(), beads.iter().map(Bead::piece_count).sum::<usize>());
        let joined = |first| splice(prepared.joined.join(&ends, &candidates, first, &near), &scene);
        let mut results = vec![joined(First::Loops), joined(First::Ends)];
        if self.slit_mm > 0.0 && results.iter().all(|beads| beads.len() > bound) {
            results.push(joined(First::Chains));
        }
        let beads = results.into_iter().min_by_key(rank).unwrap_or_default();
        Outcome { beads, bound }
    }

    /// A bead for each loop and chain.
    fn separate(&self, chains: &[&[[f64; 2]]]) -> Outcome {
        let position = |edge: usize, points: &[[f64; 2]], at: usize| {
            let point_mm = points.get(at).copied().unwrap_or_default();
            Position { edge, point_mm }
        };
        let loops = self.rings.iter().enumerate().map(|(number, ring)| {
            let seam = self.seams.get(number).copied().flatten();
            let begin = seam.unwrap_or_else(|| position(0, ring, 0));
            (Line::Loop(number), begin, begin)
        });
        let chains = chains.iter().enumerate().map(|(number, chain)| {
            let last = chain.len().saturating_sub(1);
            let to = position(last.saturating_sub(1), chain, last);
            (Line::Chain(number), position(0, chain, 0), to)
        });
        let bead = |(line, from, to)| Bead {
            ways: vec![vec![Piece { line, from, to, is_reversed: false }]],
        };
        let beads: Vec<Bead> = loops.chain(chains).map(bead).collect();
        Outcome { bound: beads.len(), beads }
    }
}
