//! The smallest change of a path: a switch replaces two parallel links of a unit cell by the other
//! two.
//!
//! ```text
//!   a ---- b                a      b
//!                switch     |      |
//!                ----->     |      |
//!   c ---- d                c      d
//! ```
//!
//! Every cell keeps its number of links, so the result is again a set of disjoint paths and cycles.
//! Whether it is one path depends on how the rest of the path joins the four cells: see
//! [`Cuts`](crate::Cuts).

use crate::Cell;

/// Two opposite sides of a unit cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sides {
    /// The top and the bottom side, which are links along x.
    Horizontal,
    /// The left and the right side, which are links along y.
    Vertical,
}

impl Sides {
    /// The other two sides of the unit cell.
    pub fn other(self) -> Self {
        match self {
            Self::Horizontal => Self::Vertical,
            Self::Vertical => Self::Horizontal,
        }
    }
}

/// A change of one unit cell: takes out the links of two opposite sides and puts in the links of
/// the other two.
///
/// Packed into 32 bits, so that long lists of moves stay small.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Switch(u32);

impl Switch {
    /// Makes the switch that takes the links `from` out of the unit cell whose top-left cell is
    /// `corner`.
    ///
    /// `corner` must be below 2^31.
    /// [`Path::allows`](crate::Path::allows) checks whether a path allows the switch.
    pub fn new(corner: Cell, from: Sides) -> Self {
        Self(corner << 1 | u32::from(from == Sides::Vertical))
    }

    /// The top-left cell of the unit cell.
    pub fn corner(self) -> Cell {
        self.0 >> 1
    }

    /// The sides whose links it takes out.
    pub fn from(self) -> Sides {
        if self.0 & 1 == 0 { Sides::Horizontal } else { Sides::Vertical }
    }

    /// The number that stands for this switch in files: twice the corner, plus one if it takes out
    /// vertical links.
    pub fn code(self) -> u32 {
        self.0
    }

    /// The switch of a number from [`Switch::code`].
    pub fn from_code(code: u32) -> Self {
        Self(code)
    }

    /// Zobrist key of the unit cell: 64 pseudo-random bits, the same for a switch and its inverse.
    ///
    /// The exclusive or of the keys of several switches identifies the links that they lead to from
    /// a given path, in whichever order they were applied: switching a unit cell twice restores its
    /// links and cancels its key.
    /// Different links have equal keys only by a collision, of probability about 2^-64 (Zobrist, "A
    /// new hashing method with application for game playing", 1970).
    pub fn zobrist_key(self) -> u64 {
        // The output function of SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom
        // number generators", 2014).
        let mut z = (u64::from(self.corner()) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// The switch that undoes this one.
    pub fn inverse(self) -> Self {
        Self(self.0 ^ 1)
    }
}

impl std::fmt::Debug for Switch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Switch({}, {:?})", self.corner(), self.from())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_keeps_corner_and_sides() {
        for from in [Sides::Horizontal, Sides::Vertical] {
            let switch = Switch::new(4096 * 4096 - 1, from);
            assert_eq!((switch.corner(), switch.from()), (4096 * 4096 - 1, from));
            assert_eq!(Switch::from_code(switch.code()), switch);
            assert_eq!(switch.inverse().from(), from.other());
            assert_eq!(switch.inverse().inverse(), switch);
        }
    }
}
