//! The twelve moves of Aali et al., word for word.
//!
//! A move looks at a window anchored at its top-left cell, whose cells are numbered row by row.
//! It applies only where the path's links inside the window are exactly `kept` and `removed`, and
//! only if the result is still one path.
//! Seen from above each is two switches: a flip of two unit cells side by side, a transpose of two
//! that touch at a corner.
//!
//! The second condition follows from the first.
//! The needed links of each window form two strands, and the move leaves two strands between the
//! same pairs of cells; sr, say, takes 0-1-2-5-4-3 and 6-7-8 for 0-3 and 6-7-4-1-2-5-8.
//! Outside the window nothing changes, so one path stays one path, and looking at the window is
//! enough.

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
pub enum VariantKind {
    /// Window of 3 x 3 cells; switches two unit cells that touch at a corner.
    Transpose,
    /// Window of 3 x 2 or 2 x 3 cells; switches two unit cells side by side.
    Flip,
}

/// A variant at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlacedVariant {
    /// The move.
    pub variant: Variant,
    /// Column of the window's top-left cell.
    pub x: u16,
    /// Row of the window's top-left cell.
    pub y: u16,
}

beadwork_base::named_enum! {
    Variant, "variant":
    Nl = "nl",
    Nr = "nr",
    Sl = "sl",
    Sr = "sr",
    Eb = "eb",
    Ea = "ea",
    Wa = "wa",
    Wb = "wb",
    N = "n",
    S = "s",
    E = "e",
    W = "w",
}

beadwork_base::named_enum! {
    VariantKind, "variant kind":
    Transpose = "transpose",
    Flip = "flip",
}

/// A row of the paper's tables, as masks of the twelve links of a 3 x 3 window.
pub(crate) struct Rule {
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    /// All links that lie inside the window.
    pub(crate) window: u16,
    /// The links it must have: kept and removed.
    pub(crate) needed: u16,
    pub(crate) removed: u16,
    pub(crate) added: u16,
    /// Its two switches in the order in which they apply: column and row of the unit cell, and the
    /// links taken out.
    switches: [(u32, u32, Sides); 2],
}

use Sides::{Horizontal as H, Vertical as V};

/// In the order of the classes.
/// Links are pairs of cell numbers.
pub(crate) const RULES: [Rule; 12] = [
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

/// Number of the link to the right of the cell at (x, y) of a 3 x 3 window, and below it: as
/// [`pack`] and [`window`] put them together.
pub(crate) const fn right(x: u32, y: u32) -> u32 {
    if y < 2 { 5 * y + 2 * x } else { 10 + x }
}

pub(crate) const fn below(x: u32, y: u32) -> u32 {
    5 * y + if x < 2 { 2 * x + 1 } else { 4 }
}

const fn rule(
    columns: u32,
    rows: u32,
    kept: &str,
    removed: &str,
    added: &str,
    switches: [(u32, u32, Sides); 2],
) -> Rule {
    let (kept, removed, added) =
        (links(columns, kept), links(columns, removed), links(columns, added));
    let mut window = 0;
    let mut cell = 0;
    while cell < columns * rows {
        let (x, y) = (cell % columns, cell / columns);
        if x + 1 < columns {
            window |= 1 << right(x, y);
        }
        if y + 1 < rows {
            window |= 1 << below(x, y);
        }
        cell += 1;
    }
    Rule { columns, rows, window, needed: kept | removed, removed, added, switches }
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

/// For each set of links in a 3 x 3 window the classes, as bits, whose own window has exactly the
/// needed links.
/// At most one transpose is among them, one flip of three columns and one of two.
const MATCHES: [u16; 1 << 12] = {
    let mut table = [0; 1 << 12];
    let mut links = 0;
    while links < table.len() {
        let mut class = 0;
        while class < RULES.len() {
            if links as u16 & RULES[class].window == RULES[class].needed {
                table[links] |= 1 << class;
            }
            class += 1;
        }
        links += 1;
    }
    table
};

const TRANSPOSES: u16 = 0x0FF;
const FLIPS_OF_TWO_COLUMNS: u16 = 0x300;
const FLIPS_OF_TWO_ROWS: u16 = 0xC00;

impl Variant {
    /// Its class number, 0..12.
    pub fn class(self) -> u8 {
        self as u8
    }

    /// The variant of a class number; `None` from 12 on.
    pub fn from_class(class: u8) -> Option<Self> {
        Self::ALL.get(usize::from(class)).copied()
    }

    /// Transpose or flip.
    pub fn kind(self) -> VariantKind {
        if self.class() < 8 { VariantKind::Transpose } else { VariantKind::Flip }
    }

    /// Columns and rows of its window.
    pub fn window(self) -> (u32, u32) {
        let rule = self.rule();
        (rule.columns, rule.rows)
    }

    fn rule(self) -> &'static Rule {
        &RULES[usize::from(self.class())]
    }
}

impl PlacedVariant {
    /// The two switches it stands for, in the order in which they apply, in a plane so many cells
    /// wide.
    #[inline]
    pub fn switches(self, width: u32) -> [Switch; 2] {
        self.variant.rule().switches.map(|(x, y, from)| {
            Switch::new((u32::from(self.y) + y) * width + u32::from(self.x) + x, from)
        })
    }

    /// Visits the places of links in its window, on all of which it depends: the column and row of
    /// their first cell, whether they lead down rather than to the right, and whether the move
    /// changes them.
    pub fn for_each_link(self, mut visit: impl FnMut(u32, u32, bool, bool)) {
        let rule = self.variant.rule();
        let (left, top) = (u32::from(self.x), u32::from(self.y));
        let changed = rule.removed | rule.added;
        for y in 0..rule.rows {
            for x in 0..rule.columns {
                if x + 1 < rule.columns {
                    visit(left + x, top + y, false, changed >> right(x, y) & 1 != 0);
                }
                if y + 1 < rule.rows {
                    visit(left + x, top + y, true, changed >> below(x, y) & 1 != 0);
                }
            }
        }
    }
}

impl Path {
    /// Whether a variant applies here: its window lies in the plane and has exactly the needed
    /// links.
    /// The result is then a path of as many pieces.
    /// O(1).
    #[inline]
    pub fn allows_variant(&self, placed: PlacedVariant) -> bool {
        let (x, y) = (usize::from(placed.x), usize::from(placed.y));
        let (width, height) = (self.width() as usize, self.height() as usize);
        if x >= width || y >= height {
            return false;
        }
        // Links beyond the plane's end are those of no cell.
        let link =
            |dx: usize, dy: usize| self.links.get((y + dy) * width + x + dx).copied().unwrap_or(0);
        let upper = |dy: usize| pack(link(0, dy), link(1, dy), link(2, dy));
        let links = window(upper(0), upper(1), pack_lowest(link(0, 2), link(1, 2)));
        (MATCHES[links] & fitting(width - x, height - y)) >> placed.variant.class() & 1 != 0
    }

    /// Applies a variant; where it does not apply it changes nothing and gives false.
    pub fn apply_variant(&mut self, placed: PlacedVariant) -> bool {
        self.allows_variant(placed) && self.apply(&placed.switches(self.width()))
    }

    /// Visits all variants of these kinds that apply, by their windows row by row; the result of
    /// each is a path of as many pieces.
    /// Linear in the plane's cells, at a few nanoseconds each.
    pub fn for_each_variant(&self, kinds: &[VariantKind], mut visit: impl FnMut(PlacedVariant)) {
        let (width, height) = (self.width() as usize, self.height() as usize);
        let asked = kinds.iter().fold(0, |classes, kind| match kind {
            VariantKind::Transpose => classes | TRANSPOSES,
            VariantKind::Flip => classes | FLIPS_OF_TWO_COLUMNS | FLIPS_OF_TWO_ROWS,
        });
        // Rows are packed as a whole, since each is part of three windows.
        // What the last windows of a row see of the next one is of no account: only variants that
        // fit are asked for.
        let links = [&self.links[..], &[0; 2]].concat();
        let pairs = self.links.iter().zip(&links[1..]);
        let lowest: Vec<u8> = pairs.clone().map(|(&a, &b)| pack_lowest(a, b)).collect();
        let upper: Vec<u8> = pairs.zip(&links[2..]).map(|((&a, &b), &c)| pack(a, b, c)).collect();
        let no_row = vec![0; width];
        for y in 0..height.saturating_sub(1) {
            let row = |packed: usize| packed * width..(packed + 1) * width;
            let third = lowest.get(row(y + 2)).unwrap_or(&no_row);
            let rows = upper[row(y)].iter().zip(&upper[row(y + 1)]).zip(third);
            for (x, ((&first, &second), &third)) in rows.enumerate() {
                let mut classes = MATCHES[window(first, second, third)] & asked;
                if classes != 0 {
                    classes &= fitting(width - x, height - y);
                }
                while classes != 0 {
                    let class = classes.trailing_zeros() as u8;
                    classes &= classes - 1;
                    let variant = Variant::from_class(class).expect("the table holds classes");
                    visit(PlacedVariant { variant, x: x as u16, y: y as u16 });
                }
            }
        }
    }
}

/// The links of three cells in one of the upper two rows of a window, in the order of [`right`] and
/// [`below`].
#[inline]
fn pack(a: u8, b: u8, c: u8) -> u8 {
    let both = link::RIGHT | link::BELOW;
    (a & both) | (b & both) << 2 | (c & link::BELOW) << 3
}

/// The same of the lowest row, from whose cells no link leads down.
#[inline]
fn pack_lowest(a: u8, b: u8) -> u8 {
    (a & link::RIGHT) | (b & link::RIGHT) << 1
}

/// The links of a window of three packed rows.
#[inline]
fn window(first: u8, second: u8, third: u8) -> usize {
    usize::from(first) | usize::from(second) << 5 | usize::from(third) << 10
}

/// The classes, as bits, that match three rows of three cells, each with its links to the right and
/// below.
///
/// Beside and below the plane no cell has links, and every variant needs some in each row and
/// column of its window: one that sticks out matches nothing.
#[inline]
pub(crate) fn matches(first: [u8; 3], second: [u8; 3], third: [u8; 3]) -> u16 {
    let upper = |[a, b, c]: [u8; 3]| pack(a, b, c);
    MATCHES[window(upper(first), upper(second), pack_lowest(third[0], third[1]))]
}

/// The classes, as bits, whose windows fit where so many columns and rows are left.
/// Their links all lie in the plane, so whatever else the window was packed from does not matter.
#[inline]
fn fitting(columns: usize, rows: usize) -> u16 {
    match (columns, rows) {
        (3.., 3..) => u16::MAX,
        (2, 3..) => FLIPS_OF_TWO_COLUMNS,
        (3.., 2) => FLIPS_OF_TWO_ROWS,
        _ => 0,
    }
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
                assert_eq!(
                    links & (out | into),
                    out,
                    "{variant}: exactly the two links must be there"
                );
                links ^= out | into;
            }
            assert_eq!(links, rule.needed & !rule.removed | rule.added, "{variant}");
            assert_eq!(rule.needed & rule.added, 0, "{variant}");
            assert_eq!((rule.needed | rule.added) & !rule.window, 0, "{variant}");
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
