//! The links of a path without its order.

use crate::path::link;
use crate::variant::{RULES, below, matches, right};
use crate::{Path, PlacedVariant, Variant};

/// Which neighbours a path links: all that the variants of Aali et al. look at.
///
/// A variant whose window matches keeps the path whole, whatever lies outside.
/// So a record of variants can be replayed on the links alone, in a few nanoseconds each, where a
/// [`Path`] rewrites all positions between the first and the last cut.
///
/// Equal links in planes of equal size are equal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Links {
    width: u32,
    height: u32,
    /// For each cell [`link::RIGHT`] and [`link::BELOW`]; two columns and two rows more than the
    /// plane has, without links, so that windows which stick out match nothing.
    bits: Vec<u8>,
}

/// The links of a row of a window, a byte a cell: three cells and one that no window has.
type Row = u32;

/// A variant by the rows of its window.
#[derive(Clone, Copy)]
struct Pattern {
    /// All links of the window.
    window: [Row; 3],
    /// Those it must have, and no others.
    needed: [Row; 3],
    /// Those that it takes out or puts in.
    changed: [Row; 3],
}

const PATTERNS: [Pattern; 12] = {
    let mut patterns = [Pattern { window: [0; 3], needed: [0; 3], changed: [0; 3] }; 12];
    let mut class = 0;
    while class < RULES.len() {
        let rule = &RULES[class];
        patterns[class] = Pattern {
            window: rows(rule.window),
            needed: rows(rule.needed),
            changed: rows(rule.removed | rule.added),
        };
        class += 1;
    }
    patterns
};

/// Links of a window, as the rules number them, row by row.
const fn rows(links: u16) -> [Row; 3] {
    let mut rows = [0; 3];
    let mut cell = 0;
    while cell < 9 {
        let (x, y) = (cell % 3, cell / 3);
        if x < 2 && links >> right(x, y) & 1 != 0 {
            rows[y as usize] |= (link::RIGHT as Row) << (8 * x);
        }
        if y < 2 && links >> below(x, y) & 1 != 0 {
            rows[y as usize] |= (link::BELOW as Row) << (8 * x);
        }
        cell += 1;
    }
    rows
}

impl Links {
    /// The links of a path.
    pub fn new(path: &Path) -> Self {
        let (width, height) = (path.width(), path.height());
        let stride = width as usize + 2;
        // The last window that begins in the plane reads one byte beyond the two further columns.
        let mut bits = vec![0; stride * (height as usize + 2) + 1];
        for (padded, row) in
            bits.chunks_exact_mut(stride).zip(path.links.chunks_exact(width as usize))
        {
            for (padded, &linked) in padded.iter_mut().zip(row) {
                *padded = linked & (link::RIGHT | link::BELOW);
            }
        }
        Self { width, height, bits }
    }

    /// Makes these a copy of others in a plane of the same size, without allocating.
    ///
    /// # Panics
    /// If the planes have different sizes.
    pub fn copy_from(&mut self, other: &Self) {
        assert_eq!(
            (self.width, self.height),
            (other.width, other.height),
            "links of one plane are copied"
        );
        self.bits.copy_from_slice(&other.bits);
    }

    /// Whether the cell at (x, y) is linked to its right neighbour, and to the one below; neither
    /// outside the plane.
    #[inline]
    pub fn right_and_below(&self, x: u32, y: u32) -> (bool, bool) {
        if x >= self.width || y >= self.height {
            return (false, false);
        }
        let bits = self.bits[y as usize * self.stride() + x as usize];
        (bits & link::RIGHT != 0, bits & link::BELOW != 0)
    }

    /// Columns and rows of the plane.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.bits.len()
    }

    /// Whether a variant applies here, as [`Path::allows_variant`] tells.
    #[inline]
    pub fn allows_variant(&self, placed: PlacedVariant) -> bool {
        self.matching(placed).is_some()
    }

    /// Applies a variant; where it does not apply it changes nothing and gives false.
    #[inline]
    pub fn apply_variant(&mut self, placed: PlacedVariant) -> bool {
        let Some(rows) = self.matching(placed) else { return false };
        let pattern = &PATTERNS[usize::from(placed.variant.class())];
        for (y, (row, changed)) in rows.into_iter().zip(pattern.changed).enumerate() {
            let at = self.place(placed) + y * self.stride();
            self.bits[at..at + 4].copy_from_slice(&(row ^ changed).to_le_bytes());
        }
        true
    }

    /// Takes back a variant that was applied last among those that touch its window.
    ///
    /// # Panics
    /// If its first cell lies outside the plane.
    #[inline]
    pub fn undo_variant(&mut self, placed: PlacedVariant) {
        let pattern = &PATTERNS[usize::from(placed.variant.class())];
        for (y, changed) in pattern.changed.into_iter().enumerate() {
            let at = self.place(placed) + y * self.stride();
            for (byte, changed) in self.bits[at..at + 3].iter_mut().zip(changed.to_le_bytes()) {
                *byte ^= changed;
            }
        }
    }

    /// Visits the variants that apply at a window's first cell, in the order of their classes; none
    /// outside the plane.
    /// O(1).
    #[inline]
    pub fn for_each_variant_at(&self, x: u16, y: u16, mut visit: impl FnMut(PlacedVariant)) {
        if u32::from(x) >= self.width || u32::from(y) >= self.height {
            return;
        }
        let row = |dy: usize| {
            let at = (usize::from(y) + dy) * self.stride() + usize::from(x);
            [self.bits[at], self.bits[at + 1], self.bits[at + 2]]
        };
        let mut classes = matches(row(0), row(1), row(2));
        while classes != 0 {
            let class = classes.trailing_zeros() as u8;
            classes &= classes - 1;
            let variant = Variant::from_class(class).expect("the table holds classes");
            visit(PlacedVariant { variant, x, y });
        }
    }

    /// Visits all variants that apply, by their windows row by row.
    /// Linear in the plane's cells.
    pub fn for_each_variant(&self, mut visit: impl FnMut(PlacedVariant)) {
        for y in 0..self.height as u16 {
            for x in 0..self.width as u16 {
                self.for_each_variant_at(x, y, &mut visit);
            }
        }
    }

    /// The rows of a variant's window, if it applies.
    #[inline]
    fn matching(&self, placed: PlacedVariant) -> Option<[Row; 3]> {
        if u32::from(placed.x) >= self.width || u32::from(placed.y) >= self.height {
            return None;
        }
        let pattern = &PATTERNS[usize::from(placed.variant.class())];
        let row = |y: usize| {
            let at = self.place(placed) + y * self.stride();
            Row::from_le_bytes([
                self.bits[at],
                self.bits[at + 1],
                self.bits[at + 2],
                self.bits[at + 3],
            ])
        };
        let rows = [row(0), row(1), row(2)];
        let differs = |y: usize| rows[y] & pattern.window[y] ^ pattern.needed[y];
        (differs(0) | differs(1) | differs(2) == 0).then_some(rows)
    }

    fn place(&self, placed: PlacedVariant) -> usize {
        usize::from(placed.y) * self.stride() + usize::from(placed.x)
    }

    fn stride(&self) -> usize {
        self.width as usize + 2
    }
}
