//! Sequences of loops and chains that are joined end to end.

use super::bead::Position;

/// A loop or a chain of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// The loop of this number, printed once around.
    Loop(usize),
    /// A chain.
    Chain {
        /// Its number.
        number: usize,
        /// Whether it is printed from its last point to its first.
        is_reversed: bool,
    },
}

/// Loops and chains that are printed one after the other without a lift.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sequence {
    /// The loops and chains in printing order; never empty.
    pub(super) parts: Vec<Part>,
    /// The possible choices of where the loops begin: each has one point for each loop of `parts`,
    /// in their order.
    /// Never empty; a sequence of chains alone has one choice without points.
    ///
    /// A sequence that consists of loops alone may have several: which one is best depends on where
    /// the nozzle comes from.
    pub(super) ways: Vec<Vec<Position>>,
}

impl Sequence {
    /// Whether it consists of loops alone.
    pub(super) fn has_only_loops(&self) -> bool {
        self.parts.iter().all(|part| matches!(part, Part::Loop(_)))
    }

    /// The same sequence printed from its end to its beginning.
    /// Loops are still printed in their own direction.
    #[must_use]
    pub(super) fn reversed(&self) -> Self {
        let reverse = |&part: &Part| match part {
            Part::Loop(number) => Part::Loop(number),
            Part::Chain { number, is_reversed } => {
                Part::Chain { number, is_reversed: !is_reversed }
            }
        };
        let parts = self.parts.iter().rev().map(reverse).collect();
        let ways = self.ways.iter().map(|way| way.iter().rev().copied().collect()).collect();
        Self { parts, ways }
    }

    /// Where it begins in one of the ways, if its chains have these ends.
    pub(super) fn start_mm(&self, way: usize, chains: &[[[f64; 2]; 2]]) -> [f64; 2] {
        match self.parts[0] {
            Part::Loop(_) => self.ways[way][0].point_mm,
            Part::Chain { number, is_reversed } => chains[number][usize::from(is_reversed)],
        }
    }

    /// Where it ends in one of the ways, if its chains have these ends.
    pub(super) fn end_mm(&self, way: usize, chains: &[[[f64; 2]; 2]]) -> [f64; 2] {
        match self.parts[self.parts.len() - 1] {
            Part::Loop(_) => self.ways[way][self.ways[way].len() - 1].point_mm,
            Part::Chain { number, is_reversed } => chains[number][usize::from(!is_reversed)],
        }
    }
}
