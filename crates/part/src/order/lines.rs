//! The lines of a layer, in any order.

use beadwork_grid::{Cell, Region};
use thiserror::Error;

use super::sequence::Sequence;
use crate::pattern::view::View;

/// The lines of a layer: the maximal runs of neighbouring cells in its rows, or in its columns.
///
/// Every cell of the layer belongs to exactly one line, and every line has at least one cell.
/// Lines are numbered row by row from a corner, and their cells are listed away from the corner;
/// with lines along y, rows are columns of the grid.
/// A row with holes or gaps has several lines.
/// Rows without cells are not counted.
///
/// A search permutes the numbers of the lines; [`Lines::flatten`] turns them into cells.
///
/// # Example
/// ```
/// use beadwork_grid::Region;
/// use beadwork_part::{Ends, LineOrder};
///
/// let region = Region::rectangle(3, 3)?;
/// let order: LineOrder = "lines-x-sequential-0".parse()?;
/// let lines = order.lines(&region);
/// assert_eq!(lines.iter().collect::<Vec<_>>(), [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
/// let ends = Ends::Nearest { from: Some(5) };
/// assert_eq!(lines.order(&[0, 2, 1], ends)?, [2, 1, 0, 6, 7, 8, 5, 4, 3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lines {
    /// Cells of all lines, line by line.
    cells: Vec<Cell>,
    /// First index into `cells` of each line, and the number of cells.
    starts: Vec<usize>,
    /// First line of each row, and the number of lines.
    row_starts: Vec<usize>,
    grid_width: u32,
}

/// The end from which each line is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Ends {
    /// The first cell of each line as listed, at the end towards the corner.
    Fixed,
    /// The end nearer to the nozzle, which is in the last cell of the line before.
    ///
    /// Distances are Euclidean; if they are equal, the line is printed as listed.
    /// On a rectangle, consecutive lines then alternate in direction, and no other choice of ends
    /// travels less: every travel move goes straight across the lines.
    Nearest {
        /// Cell of the nozzle before the first line, anywhere on the grid; `None` prints the first
        /// line as listed.
        from: Option<Cell>,
    },
}

/// The error of a list of lines that is not a permutation of all lines.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum PermutationError {
    /// The list is too long or too short.
    #[error("permutation has {got} numbers, the layer has {expected} lines")]
    Count {
        /// Number of lines.
        expected: usize,
        /// Length of the list.
        got: usize,
    },
    /// A number is not below the number of lines.
    #[error("permutation contains line {line}, expected numbers below {lines}")]
    Range {
        /// The number.
        line: usize,
        /// Number of lines.
        lines: usize,
    },
    /// A line is listed twice.
    #[error("permutation contains line {0} more than once")]
    Repeated(usize),
}

impl Lines {
    /// The lines of a region along the u axis of a view.
    pub(super) fn new(region: &Region, view: &View) -> Self {
        let mut cells = Vec::with_capacity(region.cell_count() as usize);
        let (mut starts, mut row_starts) = (Vec::new(), Vec::new());
        for v in 0..view.height {
            let first = starts.len();
            let mut is_inside = false;
            for cell in (0..view.width).map(|u| view.cell(u, v)) {
                let was_inside = std::mem::replace(&mut is_inside, region.contains(cell));
                if is_inside {
                    if !was_inside {
                        starts.push(cells.len());
                    }
                    cells.push(cell);
                }
            }
            if starts.len() > first {
                row_starts.push(first);
            }
        }
        row_starts.push(starts.len());
        starts.push(cells.len());
        Self { cells, starts, row_starts, grid_width: region.width() }
    }

    /// Number of lines; at least 1, because regions have cells.
    #[expect(clippy::len_without_is_empty, reason = "a layer always has lines")]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of rows that have lines, at least 1.
    pub fn row_count(&self) -> usize {
        self.row_starts.len() - 1
    }

    /// The lines of a row, from the end towards the corner.
    ///
    /// # Panics
    /// If `row` is not below [`Lines::row_count`].
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.row_starts[row]..self.row_starts[row + 1]
    }

    /// The cells of a line, neighbour by neighbour, from the end towards the corner.
    ///
    /// # Panics
    /// If `line` is not below [`Lines::len`].
    pub fn line(&self, line: usize) -> &[Cell] {
        &self.cells[self.starts[line]..self.starts[line + 1]]
    }

    /// The cells of each line.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[Cell]> {
        (0..self.len()).map(|line| self.line(line))
    }

    /// Returns the number of each line once, with the rows in the order of a sequence.
    ///
    /// The lines of a row follow one another, listed from the end of the row that is nearer to the
    /// nozzle, or always from the end towards the corner with [`Ends::Fixed`].
    /// Takes O(n) for n lines, and what [`Sequence::order`] takes for the rows.
    pub fn permutation(&self, sequence: Sequence, ends: Ends) -> Vec<usize> {
        let mut permutation = Vec::with_capacity(self.len());
        let mut nozzle = Nozzle::new(self, ends);
        for row in sequence.order(self.row_count()) {
            let lines = self.row(row);
            let (first, last) = (lines.start, lines.end - 1);
            let row_ends = (self.line(first)[0], self.line(last)[self.line(last).len() - 1]);
            let begin = permutation.len();
            permutation.extend(lines);
            if nozzle.is_second_nearer(row_ends) {
                permutation[begin..].reverse();
            }
            permutation[begin..].iter().for_each(|&line| {
                nozzle.print(self.line(line));
            });
        }
        permutation
    }

    /// Returns every cell of the layer once: the lines in the order of a permutation, each printed
    /// from the end that `ends` selects.
    ///
    /// Takes O(n) for a layer of n cells.
    ///
    /// # Errors
    /// If `permutation` does not contain the number of each line once.
    pub fn order(&self, permutation: &[usize], ends: Ends) -> Result<Vec<Cell>, PermutationError> {
        let lines = self.len();
        if permutation.len() != lines {
            return Err(PermutationError::Count { expected: lines, got: permutation.len() });
        }
        let mut is_listed = vec![false; lines];
        for &line in permutation {
            match is_listed.get_mut(line) {
                None => return Err(PermutationError::Range { line, lines }),
                Some(true) => return Err(PermutationError::Repeated(line)),
                Some(listed) => *listed = true,
            }
        }
        Ok(self.flatten(permutation, ends))
    }

    /// Returns the cells of some lines, such as the last ones of a layer, in the listed order, each
    /// line printed from the end that `ends` selects.
    ///
    /// With all lines in the list, the cells are those of [`Lines::order`].
    /// With a list in two parts, [`Ends::Nearest`] gives the same cells for the whole list as for
    /// its parts, if the second part begins from the last cell of the first.
    /// Takes O(n) for lines of n cells.
    ///
    /// # Panics
    /// If a number is not below [`Lines::len`].
    pub fn flatten(&self, lines: &[usize], ends: Ends) -> Vec<Cell> {
        let mut cells = Vec::with_capacity(lines.iter().map(|&line| self.line(line).len()).sum());
        let mut nozzle = Nozzle::new(self, ends);
        for &line in lines {
            let line = self.line(line);
            if nozzle.print(line) {
                cells.extend(line.iter().rev());
            } else {
                cells.extend(line);
            }
        }
        cells
    }
}

/// Position of the nozzle between lines.
struct Nozzle {
    /// Its cell; `None` with fixed ends, and before the first line if no cell is given.
    cell: Option<Cell>,
    is_fixed: bool,
    grid_width: u32,
}

impl Nozzle {
    fn new(lines: &Lines, ends: Ends) -> Self {
        let (cell, is_fixed) = match ends {
            Ends::Fixed => (None, true),
            Ends::Nearest { from } => (from, false),
        };
        Self { cell, is_fixed, grid_width: lines.grid_width }
    }

    /// Whether the nozzle is nearer to the second of two cells, and may choose.
    fn is_second_nearer(&self, (first, second): (Cell, Cell)) -> bool {
        let squared = |nozzle: Cell, cell: Cell| {
            let dx = u64::from((nozzle % self.grid_width).abs_diff(cell % self.grid_width));
            let dy = u64::from((nozzle / self.grid_width).abs_diff(cell / self.grid_width));
            dx * dx + dy * dy
        };
        self.cell.is_some_and(|nozzle| squared(nozzle, second) < squared(nozzle, first))
    }

    /// Moves to the end of a line and returns whether the line is printed in reverse.
    fn print(&mut self, line: &[Cell]) -> bool {
        let (first, last) = (line[0], line[line.len() - 1]);
        let is_reversed = self.is_second_nearer((first, last));
        if !self.is_fixed {
            self.cell = Some(if is_reversed { first } else { last });
        }
        is_reversed
    }
}
