//! What islands consist of: loops and chains with widths and features, and beads of them.

use beadwork_gcode::Feature;
use beadwork_part::{Bead, ExtrusionMove};

use crate::join::{self, OnLoop, Part};

/// A closed line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Loop {
    /// Its corners in mm; the last is joined to the first.
    pub(super) ring: Vec<[f64; 2]>,
    /// Width in mm of each edge; edge `k` begins at corner `k`.
    pub(super) widths_mm: Vec<f64>,
    pub(super) feature: Feature,
}

/// An open line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chain {
    pub(super) start_mm: [f64; 2],
    /// At least one.
    pub(super) moves: Vec<ExtrusionMove>,
}

impl Loop {
    /// Adds the moves once around, from a point of the loop back to it.
    fn append(&self, begin: OnLoop, moves: &mut Vec<ExtrusionMove>) {
        let Self { ring, widths_mm, feature } = self;
        let (count, edge) = (ring.len(), begin.edge);
        let mut add = |to_mm: [f64; 2], edge: usize| {
            moves.push(ExtrusionMove { to_mm, width_mm: widths_mm[edge], feature: *feature });
        };
        for step in 0..count {
            let edge = (edge + step) % count;
            add(ring[(edge + 1) % count], edge);
        }
        if !is_same(begin.point_mm, ring[edge]) {
            add(begin.point_mm, edge);
        }
    }
}

impl Chain {
    /// A chain through points with a common width.
    pub(super) fn new(points: &[[f64; 2]], width_mm: f64, feature: Feature) -> Option<Self> {
        let (&start_mm, rest) = points.split_first()?;
        let moves: Vec<ExtrusionMove> =
            rest.iter().map(|&to_mm| ExtrusionMove { to_mm, width_mm, feature }).collect();
        (!moves.is_empty()).then_some(Self { start_mm, moves })
    }

    /// Its first and its last point in mm.
    pub(super) fn ends_mm(&self) -> [[f64; 2]; 2] {
        [self.start_mm, self.moves.last().map_or(self.start_mm, |last| last.to_mm)]
    }

    /// The same chain from its last point to its first.
    fn reversed(&self) -> Self {
        let [_, start_mm] = self.ends_mm();
        let before = self.moves.iter().rev().skip(1).map(|step| step.to_mm);
        let ends = before.chain([self.start_mm]);
        let moves = self.moves.iter().rev().zip(ends);
        let moves = moves.map(|(&step, to_mm)| ExtrusionMove { to_mm, ..step }).collect();
        Self { start_mm, moves }
    }
}

/// The loops and chains of a bead as the nozzle prints them, with loops beginning as in a way.
pub(super) fn bead(
    strand: &join::Bead,
    way: usize,
    loops: &[Loop],
    chains: &[Chain],
    tool: u8,
) -> Bead {
    let mut bead = Bead { tool, start_mm: [0.0; 2], moves: Vec::new() };
    let mut begins = strand.ways[way].iter();
    for (at, part) in strand.parts.iter().enumerate() {
        let (start_mm, moves) = match *part {
            Part::Loop(number) => {
                let begin = *begins.next().expect("a way has a point for each loop");
                let mut moves = Vec::new();
                loops[number].append(begin, &mut moves);
                (begin.point_mm, moves)
            }
            Part::Chain { number, is_reversed } => {
                let chain = &chains[number];
                let chain = if is_reversed { chain.reversed() } else { chain.clone() };
                (chain.start_mm, chain.moves)
            }
        };
        if at == 0 {
            bead.start_mm = start_mm;
        } else if !is_same(bead.end_mm(), start_mm) {
            let before = bead.moves.last().copied();
            bead.moves.push(step(before.unwrap_or(moves[0]), moves[0], start_mm));
        }
        bead.moves.extend(moves);
    }
    bead
}

/// The step from one move to another.
///
/// It is as wide as the narrower one, because it may begin or end in a thin wall.
/// It belongs to what it leads to, but to a skeleton if it leaves one: insets keep a distance from
/// the outline that skeletons do not.
fn step(before: ExtrusionMove, after: ExtrusionMove, to_mm: [f64; 2]) -> ExtrusionMove {
    let is_skeleton = matches!(before.feature, Feature::ThinWall | Feature::GapFill);
    let feature = if is_skeleton { before.feature } else { after.feature };
    ExtrusionMove { to_mm, width_mm: before.width_mm.min(after.width_mm), feature }
}

/// Whether two points are exactly the same, so that no move leads from one to the other.
fn is_same(a: [f64; 2], b: [f64; 2]) -> bool {
    a.map(f64::to_bits) == b.map(f64::to_bits)
}
