//! The links of a path without its order.

use crate::bits::link;
use crate::rules::{RULES, below, matches, right};
use crate::{Path, PlacedVariant, Variant};

/// The links of a path: which neighbouring cells it joins, without the order of the cells.
///
/// This is all that the variants of Aali et al. need, since a variant whose window matches keeps
/// the number of pieces, whatever the path does outside the window.
/// Applying a variant to `Links` takes a few nanoseconds, where a [`Path`] rewrites all positions
/// between the first and the last cut.
/// So `Links` are the right choice to replay a list of variants, or to search among them.
///
/// Equality compares the links and the size of the grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Links {
    width: u32,
    height: u32,
    /// [`link::RIGHT`] and [`link::BELOW`] of each cell.
    ///
    /// Two more columns and two more rows than the grid has, all without links, so that a window
    /// may stick out of the grid without a check (it matches nothing then).
    bits: Vec<u8>,
}

/// The links of a row of a window: one byte for each of the three cells, in the order of their
/// columns from the lowest byte, and a fourth byte that belongs to no window.
/// Comparing and changing a row thus takes one operation.
type Row = u32;

/// A rule as masks of the three rows of its window.
#[derive(Clone, Copy)]
struct Pattern {
    /// All links of the window.
    window: [Row; 3],
    /// The links that must be present, while all others of the window must be absent.
    required: [Row; 3],
    /// The links that are removed or added.
    changed: [Row; 3],
}

const PATTERNS: [Pattern; 12] = {
    let mut patterns = [Pattern { window: [0; 3], required: [0; 3], changed: [0; 3] }; 12];
    let mut class = 0;
    while class < RULES.len() {
        let rule = &RULES[class];
        patterns[class] = Pattern {
            window: rows(rule.window),
            required: rows(rule.required),
            changed: rows(rule.removed | rule.added),
        };
        class += 1;
    }
    patterns
};

/// Converts a mask of a rule to three rows.
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
    /// Copies the links of a path.
    /// Linear in the grid's cells.
    pub fn new(path: &Path) -> Self {
        let (width, height) = (path.width(), path.height());
        let stride = width as usize + 2;
        // A row is read as four bytes, so the window of the last cell reads one byte beyond the two
        // extra columns.
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

    /// Makes these links a copy of others on a grid of the same size, without allocating.
    ///
    /// # Panics
    /// If the grids have different sizes.
    pub fn copy_from(&mut self, other: &Self) {
        assert_eq!(
            (self.width, self.height),
            (other.width, other.height),
            "copy_from needs links on grids of one size"
        );
        self.bits.copy_from_slice(&other.bits);
    }

    /// Whether the cell at (x, y) is linked to its right neighbour, and whether to the neighbour
    /// below.
    /// Both are false outside the grid.
    #[inline]
    pub fn right_and_below(&self, x: u32, y: u32) -> (bool, bool) {
        if x >= self.width || y >= self.height {
            return (false, false);
        }
        let bits = self.bits[y as usize * self.stride() + x as usize];
        (bits & link::RIGHT != 0, bits & link::BELOW != 0)
    }

    /// Width and height of the grid, in cells.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Size in memory, in bytes.
    pub fn bytes(&self) -> usize {
        self.bits.len()
    }

    /// Whether a variant applies; agrees with [`Path::allows_variant`].
    /// O(1).
    #[inline]
    pub fn allows_variant(&self, placed: PlacedVariant) -> bool {
        self.matching_rows(placed).is_some()
    }

    /// Applies a variant; if it does not apply, changes nothing and returns false.
    /// O(1).
    #[inline]
    pub fn apply_variant(&mut self, placed: PlacedVariant) -> bool {
        let Some(rows) = self.matching_rows(placed) else { return false };
        let pattern = &PATTERNS[usize::from(placed.variant.class())];
        for (y, (row, changed)) in rows.into_iter().zip(pattern.changed).enumerate() {
            let at = self.index(placed) + y * self.stride();
            self.bits[at..at + 4].copy_from_slice(&(row ^ changed).to_le_bytes());
        }
        true
    }

    /// Undoes a variant that was applied, if none of the links in its window has changed since.
    /// O(1).
    ///
    /// # Panics
    /// If the window's top-left cell lies outside the grid.
    #[inline]
    pub fn undo_variant(&mut self, placed: PlacedVariant) {
        let pattern = &PATTERNS[usize::from(placed.variant.class())];
        for (y, changed) in pattern.changed.into_iter().enumerate() {
            let at = self.index(placed) + y * self.stride();
            for (byte, changed) in self.bits[at..at + 3].iter_mut().zip(changed.to_le_bytes()) {
                *byte ^= changed;
            }
        }
    }

    /// Calls `visit` for each variant that applies with this top-left cell of its window, in the
    /// order of the classes.
    /// Visits nothing if (x, y) lies outside the grid.
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

    /// Calls `visit` for each variant that applies, row by row of the windows' top-left cells.
    /// Linear in the grid's cells.
    pub fn for_each_variant(&self, mut visit: impl FnMut(PlacedVariant)) {
        for y in 0..self.height as u16 {
            for x in 0..self.width as u16 {
                self.for_each_variant_at(x, y, &mut visit);
            }
        }
    }

    /// The rows of a variant's window; `None` if the variant does not apply.
    #[inline]
    fn matching_rows(&self, placed: PlacedVariant) -> Option<[Row; 3]> {
        if u32::from(placed.x) >= self.width || u32::from(placed.y) >= self.height {
            return None;
        }
        let pattern = &PATTERNS[usize::from(placed.variant.class())];
        let row = |y: usize| {
            let at = self.index(placed) + y * self.stride();
            Row::from_le_bytes([
                self.bits[at],
                self.bits[at + 1],
                self.bits[at + 2],
                self.bits[at + 3],
            ])
        };
        let rows = [row(0), row(1), row(2)];
        let differs = |y: usize| rows[y] & pattern.window[y] ^ pattern.required[y];
        (differs(0) | differs(1) | differs(2) == 0).then_some(rows)
    }

    /// Index in `bits` of the top-left cell of a variant's window.
    fn index(&self, placed: PlacedVariant) -> usize {
        usize::from(placed.y) * self.stride() + usize::from(placed.x)
    }

    fn stride(&self) -> usize {
        self.width as usize + 2
    }
}
