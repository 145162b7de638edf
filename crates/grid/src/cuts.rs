//! When two switches keep a path in one piece, decided in constant time from positions.
//!
//! # One switch
//! Write the path as a line in the order of its positions.
//! A switch takes out two links, so it cuts the line into three runs; `~~~` is the run between the
//! two cuts.
//! The result depends on the directions in which the path passes the two links.
//!
//! If it passes them in opposite directions, the run between the cuts becomes a cycle: the switch
//! **closes**.
//!
//! ```text
//!   a ---- b ~~.                        a      b ~~.
//!              :                        |      |   :
//!   c ---- d ~~'                        c      d ~~'
//!
//!   .. a b ~~~ d c ..     becomes     .. a c ..   and the cycle   (b ~~~ d)
//! ```
//!
//! If it passes them in the same direction, the run between the cuts is reversed, and the result is
//! still one path: the switch **opens**.
//!
//! ```text
//!   .. a b ~~~ c d ..     becomes     .. a c ~~~ b d ..
//! ```
//!
//! # Two switches
//! Two switches are **interleaved** if exactly one cut of the second lies between the two cuts of
//! the first.
//! Apply the first, then the second:
//!
//! - The first closes, so there is now a path and a cycle.
//!   Interleaved: the second has one link on the cycle and one on the path.
//!   It cuts both there and joins the cycle into the path, whatever the directions of its links:
//!   one path.
//!   Not interleaved: both links lie on the cycle, or both on the path; the second cannot join the
//!   two.
//! - The second closes and the first opens: the same with the roles exchanged, since the result
//!   does not depend on the order in which the two are applied.
//! - Both open.
//!   Interleaved: the first reverses a run with exactly one of the second's two links.
//!   The second's links were passed in the same direction, and are now passed in opposite ones: the
//!   second closes after all.
//!   Not interleaved: the first reverses both or neither, so the second still opens.
//!
//! Together: two switches keep one path exactly if "interleaved" equals "at least one closes".

use crate::bits::square;
use crate::{Cell, Path, Sides, Switch};

/// The positions at which a switch cuts a path, and the effect of the switch alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cuts {
    /// Position before the first cut link: the path is cut between `first` and `first + 1`.
    pub first: u32,
    /// Position before the second cut link, greater than `first`.
    pub second: u32,
    /// Whether the switch alone would turn the positions `first + 1 ..= second` into a cycle.
    /// Otherwise it alone would reverse them and keep one path.
    pub closes: bool,
}

impl Cuts {
    /// Whether two switches with these cuts together keep one path.
    /// The four cuts must be different.
    #[inline]
    #[allow(
        clippy::needless_bitwise_bool,
        reason = "avoids branches: the processor would mispredict half of them"
    )]
    pub fn keep_whole(self, other: Self) -> bool {
        let within = |cut: u32| (self.first < cut) & (cut < self.second);
        (within(other.first) ^ within(other.second)) == (self.closes | other.closes)
    }
}

impl Path {
    /// Returns where a switch that takes the links `from` out of the unit cell at `corner` cuts the
    /// path.
    ///
    /// Both links must be present ([`Path::sides`]); otherwise the result is meaningless.
    ///
    /// # Panics
    /// May panic if no unit cell begins at `corner`.
    #[inline]
    pub fn cuts(&self, corner: Cell, from: Sides) -> Cuts {
        // The links are a-b and c-d, such that a-c and b-d are the other two sides.
        let (a, d) = (corner as usize, corner as usize + self.width as usize + 1);
        let (b, c) = match from {
            Sides::Horizontal => (a + 1, d - 1),
            Sides::Vertical => (d - 1, a + 1),
        };
        let (a, b) = (self.position[a], self.position[b]);
        let (c, d) = (self.position[c], self.position[d]);
        let (one, two) = (a.min(b), c.min(d));
        Cuts { first: one.min(two), second: one.max(two), closes: (a < b) != (c < d) }
    }

    /// Whether applying `first` and then `second` is possible and keeps the number of pieces.
    /// O(1).
    #[inline]
    pub fn allows_pair(&self, first: Switch, second: Switch) -> bool {
        let step = second.corner().wrapping_sub(first.corner()) as i32;
        let width = self.width as i32;
        // If the unit cells lie side by side, they share a side, which the first switch changes
        // before the second is applied.
        // `shared` is that side as seen from the second, `along` its direction.
        let (shared, along) = match step {
            1 => (square::LEFT, Sides::Vertical),
            -1 => (square::RIGHT, Sides::Vertical),
            _ if step == width => (square::TOP, Sides::Horizontal),
            _ if step == -width => (square::BOTTOM, Sides::Horizontal),
            _ => (0, Sides::Horizontal),
        };
        if step == 0 || (shared != 0 && second.from() == along) {
            // The second takes out a link that the first put in.
            // This link has no position on the present path, so the closed form does not apply.
            return self.allows(&[first, second]);
        }
        self.square(first.corner()) == linked_sides(first.from())
            && self.square(second.corner()) ^ shared == linked_sides(second.from())
            && self
                .cuts(first.corner(), first.from())
                .keep_whole(self.cuts(second.corner(), second.from()))
    }
}

/// The bits of a unit cell whose only links are `from`, as a switch requires.
pub(crate) fn linked_sides(from: Sides) -> u8 {
    match from {
        Sides::Horizontal => square::HORIZONTAL,
        Sides::Vertical => square::VERTICAL,
    }
}
