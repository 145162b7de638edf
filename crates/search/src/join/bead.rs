//! Beads of loops and chains.

/// A loop or a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Line {
    /// The loop of this number.
    Loop(usize),
    /// The chain of this number.
    Chain(usize),
}

/// A point of a loop or chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// The edge that it lies on; edge `k` runs from point `k` to the next point.
    pub edge: usize,
    /// x and y in mm.
    pub point_mm: [f64; 2],
}

/// What a bead prints of a loop or chain in one go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The loop or chain.
    pub line: Line,
    /// Where it begins.
    pub from: Position,
    /// Where it ends.
    /// A piece of a loop that ends where it begins is the whole loop.
    pub to: Position,
    /// Whether it is printed against the order of the points.
    pub is_reversed: bool,
}

/// What is printed without a lift.
#[derive(Clone, Debug, PartialEq)]
pub struct Bead {
    /// The possible ways to print it, of which the caller chooses one; never empty.
    ///
    /// A way has at least one piece.
    /// Straight steps lead from each piece to the next one; they have no length where the next one
    /// begins at the same point.
    /// Beads of loops alone may have several ways: which one is best depends on where the nozzle
    /// comes from.
    pub ways: Vec<Vec<Piece>>,
}

impl Piece {
    /// Whether it is a whole loop.
    pub fn is_whole_loop(&self) -> bool {
        matches!(self.line, Line::Loop(_)) && self.from == self.to
    }

    /// The same piece from its end to its beginning.
    /// Whole loops keep their direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        if self.is_whole_loop() {
            return *self;
        }
        Self { from: self.to, to: self.from, is_reversed: !self.is_reversed, ..*self }
    }
}

impl Bead {
    /// Number of pieces in its first way.
    /// Of beads that print the same, those with more pieces have more steps.
    pub fn piece_count(&self) -> usize {
        self.ways[0].len()
    }

    /// Whether it consists of loops alone.
    pub fn has_only_loops(&self) -> bool {
        self.ways[0].iter().all(|piece| matches!(piece.line, Line::Loop(_)))
    }

    /// The same bead printed from its end to its beginning.
    /// Whole loops are still printed in their own direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let reversed = |way: &Vec<Piece>| way.iter().rev().map(Piece::reversed).collect();
        Self { ways: self.ways.iter().map(reversed).collect() }
    }

    /// Where the bead begins and ends in one of the ways, x and y in mm.
    pub fn ends_mm(&self, way: usize) -> [[f64; 2]; 2] {
        let pieces = &self.ways[way];
        [pieces[0].from.point_mm, pieces[pieces.len() - 1].to.point_mm]
    }
}
