//! The smallest change of a path: two parallel links of a unit cell for the other two.

use crate::Cell;

/// Which two of a unit cell's four sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sides {
    /// The top and the bottom side: links along x.
    Horizontal,
    /// The left and the right side: links along y.
    Vertical,
}

impl Sides {
    /// The other two.
    pub fn other(self) -> Self {
        match self {
            Self::Horizontal => Self::Vertical,
            Self::Vertical => Self::Horizontal,
        }
    }
}

/// In one unit cell, the links of the sides `from` for the links of the other two.
///
/// Packed into 32 bits, so that long records of moves stay small.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Switch(u32);

impl Switch {
    /// The switch that takes the links `from` out of the unit cell whose top-left cell is `corner`.
    ///
    /// `corner` must be below 2^31; whether a path allows the switch is for
    /// [`Path::allows`](crate::Path::allows) to say.
    pub fn new(corner: Cell, from: Sides) -> Self {
        Self(corner << 1 | u32::from(from == Sides::Vertical))
    }

    /// The top-left cell of its unit cell.
    pub fn corner(self) -> Cell {
        self.0 >> 1
    }

    /// The links it takes out.
    pub fn from(self) -> Sides {
        if self.0 & 1 == 0 { Sides::Horizontal } else { Sides::Vertical }
    }

    /// The number it is written as: twice its corner, plus one if it takes out vertical links.
    pub fn code(self) -> u32 {
        self.0
    }

    /// The switch that is written as this number.
    pub fn from_code(code: u32) -> Self {
        Self(code)
    }

    /// A number of its unit cell's own, 64 bits well mixed.
    /// Links are told by the unit cells that were switched an odd number of times, so the exclusive
    /// or of these numbers is the same, and hardly ever but then, for equal links reached from one
    /// path (Zobrist 1970).
    pub fn zobrist_key(self) -> u64 {
        // The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
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
