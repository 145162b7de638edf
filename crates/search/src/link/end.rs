//! Ends of lines, and links between them.

/// A point in the plane, x and y in mm.
pub type Point = [f64; 2];

/// One of the two ends of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct End {
    /// Number of the line, from 0.
    pub line: u32,
    /// Whether this is the end at the last point of the line.
    pub is_last: bool,
}

impl End {
    /// The end with an index: line 0 has the ends 0 and 1, line 1 the ends 2 and 3.
    pub fn from_index(index: usize) -> Self {
        Self { line: (index / 2) as u32, is_last: index % 2 == 1 }
    }

    /// Index of the end: twice the number of the line, plus one for the last point.
    pub fn index(self) -> usize {
        self.line as usize * 2 + usize::from(self.is_last)
    }

    /// The other end of the same line.
    #[must_use]
    pub fn other(self) -> Self {
        Self { line: self.line, is_last: !self.is_last }
    }
}

/// A step by extrusion between the ends of two different lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The two ends, the one with the lower index first.
    pub ends: [End; 2],
    /// The points between the two ends in mm, in order from the first end; empty for a straight
    /// step.
    pub via: Vec<Point>,
    /// Length of the step in mm.
    pub length_mm: f64,
}

impl Link {
    /// The end that the link joins to `end`, which must be one of its own.
    pub fn other(&self, end: End) -> End {
        if self.ends[0] == end { self.ends[1] } else { self.ends[0] }
    }
}
