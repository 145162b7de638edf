//! The twelve moves of Aali et al., word for word.
//!
//! A move looks at a window anchored at its top-left cell, whose cells are numbered row by row. It applies only where the
//! path's links inside the window are exactly `kept` and `removed`, and only if the result is still one path. Seen from
//! above each is two switches: a flip of two unit cells side by side, a transpose of two that touch at a corner.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::path::link;
use crate::{Path, Sides, Switch};

/// A move of Aali et al.; the numbers are the classes that the network predicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
#[allow(missing_docs, reason = "the names are the paper's; the table below is their meaning")]
pub enum Variant {
    Nl = 0,
    Nr = 1,
    Sl = 2,
    Sr = 3,
    Eb = 4,
    Ea = 5,
    Wa = 6,
    Wb = 7,
    N = 8,
    S = 9,
    E = 10,
    W = 11,
}

/// The two families of variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Window of 3 x 3 cells; switches two unit cells that touch at a corner.
    Transpose,
    /// Window of 3 x 2 or 2 x 3 cells; switches two unit cells side by side.
    Flip,
}

/// A variant at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Placed {
    /// The move.
    pub variant: Variant,
    /// Column of the window's top-left cell.
    pub x: u16,
    /// Row of the window's top-left cell.
    pub y: u16,
}

/// A name that is no [`Variant`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is none of the variants nl, nr, sl, sr, eb, ea, wa, wb, n, s, e and w")]
pub struct UnknownVariant(pub String);

/// A row of the paper's tables, as masks of the twelve links of a 3 x 3 window.
struct Rule {
    columns: u32,
    rows: u32,
    /// The links it must have: kept and removed.
    needed: u16,
    #[cfg_attr(not(test), allow(dead_code, reason = "the tests check the switches against the tables"))]
    removed: u16,
    #[cfg_attr(not(test), allow(dead_code, reason = "the tests check the switches against the tables"))]
    added: u16,
    /// Its two switches in the order in which they apply: column and row of the unit cell, and the links taken out.
    switches: [(u32, u32, Sides); 2],
}

use Sides::{Horizontal as H, Vertical as V};

/// In the order of the classes. Links are pairs of cell numbers.
const RULES: [Rule; 12] = [
    rule(3, 3, "12 36 67", "01 34 45 78", "03 14 47 58", [(0, 0, H), (1, 1, H)]), // nl
    rule(3, 3, "01 58 78", "12 34 45 67", "14 25 36 47", [(1, 0, H), (0, 1, H)]), // nr
    rule(3, 3, "01 03 78", "12 34 45 67", "14 25 36 47", [(1, 0, H), (0, 1, H)]), // sl
    rule(3, 3, "12 25 67", "01 34 45 78", "03 14 47 58", [(0, 0, H), (1, 1, H)]), // sr
    rule(3, 3, "25 36 67", "03 14 47 58", "01 34 45 78", [(0, 0, V), (1, 1, V)]), // eb
    rule(3, 3, "01 03 58", "14 25 36 47", "12 34 45 67", [(1, 0, V), (0, 1, V)]), // ea
    rule(3, 3, "12 25 36", "03 14 47 58", "01 34 45 78", [(0, 0, V), (1, 1, V)]), // wa
    rule(3, 3, "03 58 78", "14 25 36 47", "12 34 45 67", [(1, 0, V), (0, 1, V)]), // wb
    rule(2, 3, "23", "01 24 35", "02 13 45", [(0, 0, H), (0, 1, V)]),             // n
    rule(2, 3, "23", "02 13 45", "01 24 35", [(0, 1, H), (0, 0, V)]),             // s
    rule(3, 2, "14", "01 25 34", "03 12 45", [(1, 0, V), (0, 0, H)]),             // e
    rule(3, 2, "14", "03 12 45", "01 25 34", [(0, 0, V), (1, 0, H)]),             // w
];

/// Number of the link to the right of the cell at (x, y) of a 3 x 3 window, and below it.
const fn right(x: u32, y: u32) -> u32 {
    y * 2 + x
}

const fn below(x: u32, y: u32) -> u32 {
    6 + y * 3 + x
}

const fn rule(
    columns: u32,
    rows: u32,
    kept: &str,
    removed: &str,
    added: &str,
    switches: [(u32, u32, Sides); 2],
) -> Rule {
    let (kept, removed, added) = (links(columns, kept), links(columns, removed), links(columns, added));
    Rule { columns, rows, needed: kept | removed, removed, added, switches }
}

/// Reads links as the paper writes them, "12 36 67", in a window so many columns wide.
const fn links(columns: u32, text: &str) -> u16 {
    let text = text.as_bytes();
    let mut mask = 0;
    let mut at = 0;
    while at < text.len() {
        let (a, b) = ((text[at] - b'0') as u32, (text[at + 1] - b'0') as u32);
        let (x, y) = (a % columns, a / columns);
        mask |= 1 << if b == a + 1 { right(x, y) } else { below(x, y) };
        at += 3;
    }
    mask
}

/// The transpose that a 3 x 3 window with these links admits, as class number; 255 for none. No window admits two, for
/// their needed links differ.
const TRANSPOSES: [u8; 1 << 12] = {
    let mut table = [u8::MAX; 1 << 12];
    let mut class = 0;
    while class < 8 {
        table[RULES[class as usize].needed as usize] = class;
        class += 1;
    }
    table
};

impl Variant {
    /// All of them, in the order of their classes; the transposes come first.
    pub const ALL: [Self; 12] = [
        Self::Nl,
        Self::Nr,
        Self::Sl,
        Self::Sr,
        Self::Eb,
        Self::Ea,
        Self::Wa,
        Self::Wb,
        Self::N,
        Self::S,
        Self::E,
        Self::W,
    ];

    /// Its class number, 0..12.
    pub fn class(self) -> u8 {
        self as u8
    }

    /// The variant of a class number; `None` from 12 on.
    pub fn from_class(class: u8) -> Option<Self> {
        Self::ALL.get(usize::from(class)).copied()
    }

    /// Transpose or flip.
    pub fn kind(self) -> Kind {
        if self.class() < 8 { Kind::Transpose } else { Kind::Flip }
    }

    /// Columns and rows of its window.
    pub fn window(self) -> (u32, u32) {
        let rule = self.rule();
        (rule.columns, rule.rows)
    }

    /// The paper's name.
    pub fn name(self) -> &'static str {
        ["nl", "nr", "sl", "sr", "eb", "ea", "wa", "wb", "n", "s", "e", "w"][usize::from(self.class())]
    }

    fn rule(self) -> &'static Rule {
        &RULES[usize::from(self.class())]
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Variant {
    type Err = UnknownVariant;

    fn from_str(name: &str) -> Result<Self, UnknownVariant> {
        Self::ALL
            .into_iter()
            .find(|variant| variant.name() == name)
            .ok_or_else(|| UnknownVariant(name.to_owned()))
    }
}

impl Placed {
    /// The two switches it stands for, in the order in which they apply, in a plane so many cells wide.
    #[inline]
    pub fn switches(self, width: u32) -> [Switch; 2] {
        self.variant
            .rule()
            .switches
            .map(|(x, y, from)| Switch::new((u32::from(self.y) + y) * width + u32::from(self.x) + x, from))
    }
}

impl Path {
    /// Whether a variant applies here: its window lies in the plane, has exactly the needed links, and the result is
    /// still a path of as many pieces. O(1).
    #[inline]
    pub fn allows_variant(&self, placed: Placed) -> bool {
        let [first, second] = placed.switches(self.width());
        self.matches(placed) && self.allows_pair(first, second)
    }

    /// Applies a variant; where it does not apply it changes nothing and gives false.
    pub fn apply_variant(&mut self, placed: Placed) -> bool {
        self.matches(placed) && self.apply(&placed.switches(self.width()))
    }

    /// The variants that apply in windows anchored at (x, y), up to three; their results are all paths of as many pieces.
    pub fn variants_at(&self, x: u16, y: u16, kinds: &[Kind]) -> impl Iterator<Item = Placed> {
        let at = |class: u8| Variant::from_class(class).map(|variant| Placed { variant, x, y });
        let mut found = [None; 3];
        if kinds.contains(&Kind::Transpose) && self.fits(x, y, 3, 3) {
            found[0] = at(TRANSPOSES[usize::from(self.window_links(x, y, 3, 3))]);
        }
        if kinds.contains(&Kind::Flip) {
            if self.fits(x, y, 3, 2) {
                found[1] = flip(self.window_links(x, y, 3, 2), [Variant::E, Variant::W]).and_then(at);
            }
            if self.fits(x, y, 2, 3) {
                found[2] = flip(self.window_links(x, y, 2, 3), [Variant::N, Variant::S]).and_then(at);
            }
        }
        found.into_iter().flatten().filter(|placed| {
            let [first, second] = placed.switches(self.width());
            self.allows_pair(first, second)
        })
    }

    pub(crate) fn matches(&self, placed: Placed) -> bool {
        let rule = placed.variant.rule();
        self.fits(placed.x, placed.y, rule.columns, rule.rows)
            && self.window_links(placed.x, placed.y, rule.columns, rule.rows) == rule.needed
    }

    fn fits(&self, x: u16, y: u16, columns: u32, rows: u32) -> bool {
        u32::from(x) + columns <= self.width() && u32::from(y) + rows <= self.height()
    }

    /// The links inside a window that fits, as a mask.
    fn window_links(&self, x: u16, y: u16, columns: u32, rows: u32) -> u16 {
        let mut mask = 0;
        for row in 0..rows {
            let first = ((u32::from(y) + row) * self.width + u32::from(x)) as usize;
            for (column, bits) in (0..).zip(&self.links[first..first + columns as usize]) {
                if column + 1 < columns {
                    mask |= u16::from(bits & link::RIGHT != 0) << right(column, row);
                }
                if row + 1 < rows {
                    mask |= u16::from(bits & link::BELOW != 0) << below(column, row);
                }
            }
        }
        mask
    }
}

fn flip(links: u16, candidates: [Variant; 2]) -> Option<u8> {
    candidates.into_iter().find(|variant| variant.rule().needed == links).map(Variant::class)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn switches_change_the_links_of_the_table() {
        for variant in Variant::ALL {
            let rule = variant.rule();
            let mut links = rule.needed;
            for (x, y, from) in rule.switches {
                let horizontal = 1 << right(x, y) | 1 << right(x, y + 1);
                let vertical = 1 << below(x, y) | 1 << below(x + 1, y);
                let (out, into) = match from {
                    Sides::Horizontal => (horizontal, vertical),
                    Sides::Vertical => (vertical, horizontal),
                };
                assert_eq!(links & (out | into), out, "{variant}: exactly the two links must be there");
                links ^= out | into;
            }
            assert_eq!(links, rule.needed & !rule.removed | rule.added, "{variant}");
            assert_eq!(rule.needed & rule.added, 0, "{variant}");
        }
    }

    #[test]
    fn classes_and_names_round_trip() {
        for (class, variant) in (0..).zip(Variant::ALL) {
            assert_eq!((variant.class(), Variant::from_class(class)), (class, Some(variant)));
            assert_eq!(variant.name().parse(), Ok(variant));
        }
        assert_eq!(Variant::from_class(12), None);
    }
}
