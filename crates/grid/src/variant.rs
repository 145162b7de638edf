//! The twelve moves of Aali et al. ("variants"), found and applied in a path.
//!
//! A move acts on a small **window** of cells.
//! It applies where the links of the path inside the window are exactly those that its rule
//! requires, and replaces some of them.
//! Each move is two switches of unit cells: a **flip** of two that lie side by side, a
//! **transpose** of two that touch at a corner.
//!
//! # Why looking at the window is enough
//! The paper accepts a move only if the result is still one path.
//! This second condition follows from the first, so nothing outside the window needs to be checked.
//! The required links of each window form two strands, and the move leaves two strands between the
//! same pairs of end cells.
//! Take [`Variant::Sr`], with the cells of its window numbered row by row:
//!
//! ```text
//!   0--1--2          0  1--2
//!         |          |  |  |       before: 0-1-2-5-4-3   and   6-7-8
//!   3--4--5   ->     3  4  5
//!                       |  |       after:  0-3           and   6-7-4-1-2-5-8
//!   6--7--8          6--7  8
//! ```
//!
//! Before and after, one strand joins 0 to 3 and the other joins 6 to 8, and together they visit
//! all cells of the window.
//! The rest of the path enters and leaves the window at these four cells as before, so one path
//! stays one path.
//! A test checks this for all twelve moves on random paths, by walking along the links.

use crate::rules::{
    FLIPS_OF_TWO_COLUMNS, FLIPS_OF_TWO_ROWS, MATCHES, RULES, Rule, TRANSPOSES, below, fitting,
    pack, pack_lowest, right, window,
};
use crate::{Path, Switch};

/// A move of Aali et al., with the paper's name.
///
/// The discriminants are the class numbers that the paper's network predicts.
/// The pictures show the links inside the window before and after the move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Variant {
    /// Transpose `nl`:
    /// ```text
    /// o--o--o        o  o--o
    ///                |  |
    /// o--o--o   ->   o  o  o
    /// |              |  |  |
    /// o--o--o        o--o  o
    /// ```
    Nl = 0,
    /// Transpose `nr`:
    /// ```text
    /// o--o--o        o--o  o
    ///                   |  |
    /// o--o--o   ->   o  o  o
    ///       |        |  |  |
    /// o--o--o        o  o--o
    /// ```
    Nr = 1,
    /// Transpose `sl`:
    /// ```text
    /// o--o--o        o--o  o
    /// |              |  |  |
    /// o--o--o   ->   o  o  o
    ///                |  |
    /// o--o--o        o  o--o
    /// ```
    Sl = 2,
    /// Transpose `sr`:
    /// ```text
    /// o--o--o        o  o--o
    ///       |        |  |  |
    /// o--o--o   ->   o  o  o
    ///                   |  |
    /// o--o--o        o--o  o
    /// ```
    Sr = 3,
    /// Transpose `eb`:
    /// ```text
    /// o  o  o        o--o  o
    /// |  |  |              |
    /// o  o  o   ->   o--o--o
    /// |  |  |        |
    /// o--o  o        o--o--o
    /// ```
    Eb = 4,
    /// Transpose `ea`:
    /// ```text
    /// o--o  o        o--o--o
    /// |  |  |        |
    /// o  o  o   ->   o--o--o
    /// |  |  |              |
    /// o  o  o        o--o  o
    /// ```
    Ea = 5,
    /// Transpose `wa`:
    /// ```text
    /// o  o--o        o--o--o
    /// |  |  |              |
    /// o  o  o   ->   o--o--o
    /// |  |  |        |
    /// o  o  o        o  o--o
    /// ```
    Wa = 6,
    /// Transpose `wb`:
    /// ```text
    /// o  o  o        o  o--o
    /// |  |  |        |
    /// o  o  o   ->   o--o--o
    /// |  |  |              |
    /// o  o--o        o--o--o
    /// ```
    Wb = 7,
    /// Flip `n`:
    /// ```text
    /// o--o        o  o
    ///             |  |
    /// o--o   ->   o--o
    /// |  |
    /// o  o        o--o
    /// ```
    N = 8,
    /// Flip `s`:
    /// ```text
    /// o  o        o--o
    /// |  |
    /// o--o   ->   o--o
    ///             |  |
    /// o--o        o  o
    /// ```
    S = 9,
    /// Flip `e`:
    /// ```text
    /// o--o  o        o  o--o
    ///    |  |   ->   |  |
    /// o--o  o        o  o--o
    /// ```
    E = 10,
    /// Flip `w`:
    /// ```text
    /// o  o--o        o--o  o
    /// |  |      ->      |  |
    /// o  o--o        o--o  o
    /// ```
    W = 11,
}

/// The two families of variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VariantKind {
    /// Window of 3 x 3 cells; switches two unit cells that touch at a corner.
    Transpose,
    /// Window of 3 x 2 or 2 x 3 cells; switches two unit cells that lie side by side.
    Flip,
}

/// A variant at a position of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlacedVariant {
    /// The variant.
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

impl Variant {
    /// Class number, 0..12.
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

    /// Width and height of the window, in cells.
    pub fn window(self) -> (u32, u32) {
        let rule = self.rule();
        (rule.columns, rule.rows)
    }

    fn rule(self) -> &'static Rule {
        &RULES[usize::from(self.class())]
    }
}

impl PlacedVariant {
    /// The two switches that make up the move, in the order in which they apply, on a grid that is
    /// `width` cells wide.
    #[inline]
    pub fn switches(self, width: u32) -> [Switch; 2] {
        self.variant.rule().switches.map(|(x, y, from)| {
            Switch::new((u32::from(self.y) + y) * width + u32::from(self.x) + x, from)
        })
    }

    /// Calls `visit` for each pair of neighbouring cells in the window: for every link that the
    /// move depends on.
    ///
    /// The arguments are column and row of the left or upper cell, whether the other cell lies
    /// below (rather than to the right), and whether the move changes the link between them.
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
    /// Whether a variant applies: its window lies in the grid and contains exactly the required
    /// links.
    /// Applying it then keeps the number of pieces.
    /// O(1).
    #[inline]
    pub fn allows_variant(&self, placed: PlacedVariant) -> bool {
        let (x, y) = (usize::from(placed.x), usize::from(placed.y));
        let (width, height) = (self.width() as usize, self.height() as usize);
        if x >= width || y >= height {
            return false;
        }
        // Beyond the last cell of the grid there are no links.
        let link =
            |dx: usize, dy: usize| self.links.get((y + dy) * width + x + dx).copied().unwrap_or(0);
        let upper = |dy: usize| pack(link(0, dy), link(1, dy), link(2, dy));
        let links = window(upper(0), upper(1), pack_lowest(link(0, 2), link(1, 2)));
        (MATCHES[links] & fitting(width - x, height - y)) >> placed.variant.class() & 1 != 0
    }

    /// Applies a variant; if it does not apply, changes nothing and returns false.
    ///
    /// Costs as much as [`Path::apply`]: one rewritten position for each cell between the first and
    /// the last cut.
    pub fn apply_variant(&mut self, placed: PlacedVariant) -> bool {
        self.allows_variant(placed) && self.apply(&placed.switches(self.width()))
    }

    /// Calls `visit` for each variant of these kinds that applies, row by row of the windows'
    /// top-left cells.
    /// Applying any one of them keeps the number of pieces.
    /// Linear in the grid's cells, at a few nanoseconds each.
    pub fn for_each_variant(&self, kinds: &[VariantKind], mut visit: impl FnMut(PlacedVariant)) {
        let (width, height) = (self.width() as usize, self.height() as usize);
        let wanted = kinds.iter().fold(0, |classes, kind| match kind {
            VariantKind::Transpose => classes | TRANSPOSES,
            VariantKind::Flip => classes | FLIPS_OF_TWO_COLUMNS | FLIPS_OF_TWO_ROWS,
        });
        // Each row of cells is part of three windows, so all rows are packed once in advance.
        // The last windows of a row then contain cells of the next row.
        // This does no harm: `fitting` removes all classes whose window would reach that far.
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
                let mut classes = MATCHES[window(first, second, third)] & wanted;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_and_names_round_trip() {
        for (class, variant) in (0..).zip(Variant::ALL) {
            assert_eq!((variant.class(), Variant::from_class(class)), (class, Some(variant)));
            assert_eq!(variant.name().parse(), Ok(variant));
        }
        assert_eq!(Variant::from_class(12), None);
    }
}
