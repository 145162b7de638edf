//! What islands consist of: loops and chains with widths and features, and beads of them.

use beadwork_gcode::Feature;
use beadwork_part::{Bead, ExtrusionMove};

use crate::join::{self, Piece, Position};

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
    /// At least two points in mm.
    pub(super) points: Vec<[f64; 2]>,
    /// Width in mm of each edge; edge `k` begins at point `k`.
    pub(super) widths_mm: Vec<f64>,
    pub(super) feature: Feature,
}

impl Chain {
    /// A chain through points with a common width, if there are at least two.
    pub(super) fn new(points: Vec<[f64; 2]>, width_mm: f64, feature: Feature) -> Option<Self> {
        let widths_mm = vec![width_mm; points.len().saturating_sub(1)];
        (!widths_mm.is_empty()).then_some(Self { points, widths_mm, feature })
    }

    /// Its first and its last point in mm.
    pub(super) fn ends_mm(&self) -> [[f64; 2]; 2] {
        [self.points[0], self.points[self.points.len() - 1]]
    }
}

/// The loops and chains of a bead as the nozzle prints them, in one of its ways.
pub(super) fn bead(pieces: &[Piece], loops: &[Loop], chains: &[Chain], tool: u8) -> Bead {
    let mut bead = Bead { tool, start_mm: pieces[0].from.point_mm, moves: Vec::new() };
    for piece in pieces {
        let moves = moves(piece, loops, chains);
        let start_mm = piece.from.point_mm;
        if !is_same(bead.end_mm(), start_mm) {
            let before = bead.moves.last().or(moves.first()).copied();
            let after = moves.first().copied().or(before);
            if let (Some(before), Some(after)) = (before, after) {
                bead.moves.push(step(before, after, start_mm));
            }
        }
        bead.moves.extend(moves);
    }
    bead
}

/// The moves of a piece.
fn moves(piece: &Piece, loops: &[Loop], chains: &[Chain]) -> Vec<ExtrusionMove> {
    let (points, widths_mm, feature) = match piece.line {
        join::Line::Loop(number) => {
            (&loops[number].ring, &loops[number].widths_mm, loops[number].feature)
        }
        join::Line::Chain(number) => {
            (&chains[number].points, &chains[number].widths_mm, chains[number].feature)
        }
    };
    let [first, last] =
        if piece.is_reversed { [piece.to, piece.from] } else { [piece.from, piece.to] };
    // The corners on the way, each after the edge that leads to it.
    let mut lines: Vec<(usize, [f64; 2])> = corners(first, last, points)
        .map(|edge| (edge, points[(edge + 1) % points.len()]))
        .collect();
    if !is_same(lines.last().map_or(first.point_mm, |line| line.1), last.point_mm) {
        lines.push((last.edge, last.point_mm));
    }
    if piece.is_reversed {
        let before = lines.iter().rev().skip(1).map(|line| line.1).chain([first.point_mm]);
        lines = lines.iter().rev().map(|line| line.0).zip(before).collect();
    }
    let mut moves: Vec<ExtrusionMove> = lines
        .into_iter()
        .map(|(edge, to_mm)| ExtrusionMove { to_mm, width_mm: widths_mm[edge], feature })
        .collect();
    // Points may repeat.
    let mut here = piece.from.point_mm;
    moves.retain(|step| !is_same(std::mem::replace(&mut here, step.to_mm), step.to_mm));
    moves
}

/// The edges that are passed to their ends from one position to another, in order.
fn corners(
    from: Position,
    to: Position,
    points: &[[f64; 2]],
) -> impl Iterator<Item = usize> + use<> {
    let count = points.len();
    let along = |position: Position| {
        let [x, y] = [0, 1].map(|k| position.point_mm[k] - points[position.edge][k]);
        x * x + y * y
    };
    let is_ahead = from.edge == to.edge && along(from) < along(to);
    let passed = if is_ahead {
        0
    } else if from.edge == to.edge {
        count
    } else {
        (to.edge + count - from.edge) % count
    };
    (0..passed).map(move |step| (from.edge + step) % count)
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
