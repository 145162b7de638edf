//! The rules of the twelve moves of Aali et al. as bit masks, and the table that finds the moves
//! which match a window.
//!
//! # Numbering of the links
//! A window of 3 x 3 cells contains twelve links, numbered such that the links of a row of cells
//! are adjacent bits:
//!
//! ```text
//!   cell --0-- cell --2-- cell
//!    |1         |3         |4
//!   cell --5-- cell --7-- cell
//!    |6         |8         |9
//!   cell --10- cell --11- cell
//! ```
//!
//! So the links of a window are a number of 12 bits, and [`MATCHES`] lists for each of the 4096
//! possible windows the moves whose conditions it meets.
//! Smaller windows (2 x 3 and 3 x 2 cells) use the bits of their cells in the top-left corner and
//! ignore the others.

use crate::Sides;
use crate::bits::link;

/// A move as masks of the twelve links of a 3 x 3 window.
pub(crate) struct Rule {
    /// Width and height of the move's window, in cells.
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    /// All links that lie inside the window.
    pub(crate) window: u16,
    /// The links that must be present, while all others of `window` must be absent: those that the
    /// move keeps and those that it removes.
    pub(crate) required: u16,
    pub(crate) removed: u16,
    pub(crate) added: u16,
    /// The two switches that make up the move, in the order in which they apply: column and row of
    /// the unit cell's corner in the window, and the links that are taken out.
    pub(crate) switches: [(u32, u32, Sides); 2],
}

use Sides::{Horizontal as H, Vertical as V};

/// The rules in the order of the classes: size of the window, kept, removed and added links as in
/// the paper's tables, and the two switches.
///
/// A link is written as the numbers of its two cells; the cells of a window are numbered row by row
/// from 0.
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

/// Number of the link from the cell at (x, y) of a window to its right neighbour.
pub(crate) const fn right(x: u32, y: u32) -> u32 {
    if y < 2 { 5 * y + 2 * x } else { 10 + x }
}

/// Number of the link from the cell at (x, y) of a window to the neighbour below.
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
    Rule { columns, rows, window, required: kept | removed, removed, added, switches }
}

/// Parses links as the paper writes them ("12 36 67") in a window of this many columns.
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

/// For each set of links of a 3 x 3 window, the classes (as bits) of the moves whose window
/// contains exactly the required links.
/// At most three classes match: one transpose, one flip of 2 x 3 cells and one of 3 x 2.
pub(crate) const MATCHES: [u16; 1 << 12] = {
    let mut table = [0; 1 << 12];
    let mut links = 0;
    while links < table.len() {
        let mut class = 0;
        while class < RULES.len() {
            if links as u16 & RULES[class].window == RULES[class].required {
                table[links] |= 1 << class;
            }
            class += 1;
        }
        links += 1;
    }
    table
};

/// Classes of the transposes, as bits.
pub(crate) const TRANSPOSES: u16 = 0x0FF;
/// Classes of the flips with a window of two columns and three rows.
pub(crate) const FLIPS_OF_TWO_COLUMNS: u16 = 0x300;
/// Classes of the flips with a window of three columns and two rows.
pub(crate) const FLIPS_OF_TWO_ROWS: u16 = 0xC00;

/// The links of three neighbouring cells in the first or second row of a window, as the five bits
/// of that row.
/// The arguments are the bits of [`link`] of the cells.
/// The third cell's link to the right is dropped, because it leads out of the window.
#[inline]
pub(crate) fn pack(a: u8, b: u8, c: u8) -> u8 {
    let both = link::RIGHT | link::BELOW;
    (a & both) | (b & both) << 2 | (c & link::BELOW) << 3
}

/// The links of the third row of a window, as two bits: the links downwards lead out of the window.
#[inline]
pub(crate) fn pack_lowest(a: u8, b: u8) -> u8 {
    (a & link::RIGHT) | (b & link::RIGHT) << 1
}

/// Index into [`MATCHES`] of the window with three packed rows.
#[inline]
pub(crate) fn window(first: u8, second: u8, third: u8) -> usize {
    usize::from(first) | usize::from(second) << 5 | usize::from(third) << 10
}

/// The classes (as bits) that match three rows of three cells, given as the bits of [`link`] of
/// each cell.
///
/// Cells beyond the last column or row of the grid must be given without links.
/// Then no window that sticks out of the grid matches, since every rule requires a link in each row
/// and column of its window.
#[inline]
pub(crate) fn matches(first: [u8; 3], second: [u8; 3], third: [u8; 3]) -> u16 {
    let upper = |[a, b, c]: [u8; 3]| pack(a, b, c);
    MATCHES[window(upper(first), upper(second), pack_lowest(third[0], third[1]))]
}

/// The classes (as bits) whose windows fit where this many columns and rows of the grid are left.
///
/// A window that fits contains only links of the grid, so for these classes it does not matter what
/// the packed rows hold beyond the grid's end.
#[inline]
pub(crate) fn fitting(columns: usize, rows: usize) -> u16 {
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
        for (class, rule) in RULES.iter().enumerate() {
            let mut links = rule.required;
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
                    "class {class}: exactly the two links must be present"
                );
                links ^= out | into;
            }
            assert_eq!(links, rule.required & !rule.removed | rule.added, "class {class}");
            assert_eq!(rule.required & rule.added, 0, "class {class}");
            assert_eq!((rule.required | rule.added) & !rule.window, 0, "class {class}");
        }
    }

    #[test]
    fn at_most_one_class_of_each_window_size_matches() {
        for classes in MATCHES {
            for group in [TRANSPOSES, FLIPS_OF_TWO_COLUMNS, FLIPS_OF_TWO_ROWS] {
                assert!((classes & group).count_ones() <= 1, "{classes:b}");
            }
        }
    }
}
