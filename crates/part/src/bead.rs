//! Beads as the nozzle prints them.

use beadwork_gcode::Feature;

/// One continuous extrusion with one tool.
///
/// Coordinates are mm on the bed, x to the right and y to the back.
#[derive(Clone, Debug, PartialEq)]
pub struct Bead {
    /// The tool that prints it, which is the number of its material.
    pub tool: u8,
    /// Where it begins.
    pub start_mm: [f64; 2],
    /// The moves that extrude, one after the other.
    /// A closed bead ends where it begins.
    pub moves: Vec<ExtrusionMove>,
}

/// A straight move of the nozzle that extrudes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtrusionMove {
    /// Where it ends, in mm.
    pub to_mm: [f64; 2],
    /// Width of the strip that it fills, in mm: beads this far apart fill an area without gaps.
    pub width_mm: f64,
    /// What it prints.
    pub feature: Feature,
}

/// The beads of a layer in printing order.
///
/// The layers of a print are numbered from the bed up without a gap, because each one rests on the
/// one below.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BeadLayer {
    /// Number of the layer, from 0 at the bed.
    pub number: usize,
    /// The beads; consecutive beads of different tools imply a tool change.
    pub beads: Vec<Bead>,
}

impl Bead {
    /// Length in mm.
    pub fn length_mm(&self) -> f64 {
        self.lines().map(|(from, to, _)| distance_mm(from, to)).sum()
    }

    /// Area in mm²: the sum of length times width of the moves.
    pub fn area_mm2(&self) -> f64 {
        self.lines().map(|(from, to, width_mm)| distance_mm(from, to) * width_mm).sum()
    }

    /// Where it ends, in mm.
    pub fn end_mm(&self) -> [f64; 2] {
        self.moves.last().map_or(self.start_mm, |last| last.to_mm)
    }

    /// The same bead printed from its end to its beginning.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut moves: Vec<ExtrusionMove> = Vec::with_capacity(self.moves.len());
        let mut from_mm = self.start_mm;
        for step in &self.moves {
            moves.push(ExtrusionMove { to_mm: from_mm, ..*step });
            from_mm = step.to_mm;
        }
        moves.reverse();
        Self { tool: self.tool, start_mm: from_mm, moves }
    }

    /// Both ends and the width of each move, in mm.
    pub fn lines(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], f64)> {
        let mut from = self.start_mm;
        self.moves
            .iter()
            .map(move |step| (std::mem::replace(&mut from, step.to_mm), step.to_mm, step.width_mm))
    }
}

fn distance_mm(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [a[0] - b[0], a[1] - b[1]];
    (x * x + y * y).sqrt()
}
