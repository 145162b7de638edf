//! The cells of a layer.

use ndarray::{ArrayView2, aview1};
use thiserror::Error;

/// The number of a cell of the grid: `y * width + x`, so row by row, x fastest.
pub type Cell = u32;

/// The cells of a layer that are to be printed, within a grid of width x height cells.
///
/// The region is the whole grid, or any subset of its cells; it need not be connected.
///
/// Invariant: it has at least one cell, and no side of the grid is longer than
/// [`Region::MAX_SIDE`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Region {
    width: u32,
    height: u32,
    inside: Vec<bool>,
    cells: u32,
}

/// Why a [`Region`] could not be constructed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum RegionError {
    /// A side of the grid is zero.
    #[error("grid of {width} x {height} cells: sides must be at least 1 cell")]
    ZeroSize {
        /// Width in cells.
        width: u32,
        /// Height in cells.
        height: u32,
    },
    /// A side of the grid is longer than [`Region::MAX_SIDE`].
    #[error("grid of {width} x {height} cells: sides must be at most {} cells", Region::MAX_SIDE)]
    TooLarge {
        /// Width in cells.
        width: u32,
        /// Height in cells.
        height: u32,
    },
    /// The mask does not have one entry for each cell of the grid.
    #[error("mask has {got} entries, the grid {expected} cells")]
    MaskLength {
        /// Width times height.
        expected: usize,
        /// Number of entries of the mask.
        got: usize,
    },
    /// No entry of the mask is true.
    #[error("region has no cells")]
    NoCells,
}

impl Region {
    /// Maximum width and height of the grid, in cells.
    pub const MAX_SIDE: u32 = 4096;

    /// Makes a region of all cells of a grid of `width` x `height` cells.
    pub fn rectangle(width: u32, height: u32) -> Result<Self, RegionError> {
        check_size(width, height)?;
        let cells = width * height;
        Ok(Self { width, height, inside: vec![true; cells as usize], cells })
    }

    /// Makes a region of the cells for which `inside` is true.
    ///
    /// `inside` has one entry for each cell of a grid of `width` x `height` cells, indexed by
    /// [`Cell`].
    pub fn from_mask(width: u32, height: u32, inside: Vec<bool>) -> Result<Self, RegionError> {
        check_size(width, height)?;
        let expected = (width * height) as usize;
        if inside.len() != expected {
            return Err(RegionError::MaskLength { expected, got: inside.len() });
        }
        let cells = inside.iter().filter(|&&cell| cell).count() as u32;
        if cells == 0 {
            return Err(RegionError::NoCells);
        }
        Ok(Self { width, height, inside, cells })
    }

    /// Makes a region of the cells for which an array with the axes `[y, x]` is true.
    ///
    /// The grid takes its height from the first axis and its width from the second.
    ///
    /// ```
    /// use beadwork_grid::Region;
    /// use ndarray::array;
    ///
    /// let mask = array![[true, true, false], [true, true, true]];
    /// let region = Region::from_array(mask.view())?;
    /// assert_eq!((region.width(), region.height(), region.cell_count()), (3, 2, 5));
    /// assert_eq!(region.view(), mask);
    /// # Ok::<(), beadwork_grid::RegionError>(())
    /// ```
    pub fn from_array(inside: ArrayView2<'_, bool>) -> Result<Self, RegionError> {
        let (height, width) = inside.dim();
        let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
        let (width, height) = (side(width), side(height));
        check_size(width, height)?;
        Self::from_mask(width, height, inside.iter().copied().collect())
    }

    /// Whether each cell of the grid belongs to the region, as an array with the axes `[y, x]`.
    pub fn view(&self) -> ArrayView2<'_, bool> {
        self.as_rows(&self.inside)
    }

    /// Returns a slice indexed by [`Cell`] as an array with the axes `[y, x]`.
    ///
    /// # Panics
    /// If the slice does not have one element for each cell of the grid.
    pub(crate) fn as_rows<'a, T>(&self, values: &'a [T]) -> ArrayView2<'a, T> {
        aview1(values)
            .into_shape_with_order((self.height as usize, self.width as usize))
            .expect("one value for each cell of this region's grid")
    }

    /// Width of the grid, in cells.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height of the grid, in cells.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Number of cells in the region, at least 1.
    pub fn cell_count(&self) -> u32 {
        self.cells
    }

    /// Number of cells of the grid, `width * height`: the length of a slice indexed by [`Cell`].
    pub fn grid_len(&self) -> usize {
        self.inside.len()
    }

    /// Whether every cell of the grid belongs to the region.
    pub fn is_rectangle(&self) -> bool {
        self.cells as usize == self.inside.len()
    }

    /// Whether `cell` belongs to the region; false also for numbers outside the grid.
    pub fn contains(&self, cell: Cell) -> bool {
        self.inside.get(cell as usize).copied().unwrap_or(false)
    }

    /// Number of the cell in column `x` and row `y`, which must lie in the grid (checked in debug
    /// builds).
    pub fn cell(&self, x: u32, y: u32) -> Cell {
        debug_assert!(x < self.width && y < self.height, "({x}, {y}) lies outside the grid");
        y * self.width + x
    }

    /// Column and row `(x, y)` of a cell.
    pub fn xy(&self, cell: Cell) -> (u32, u32) {
        (cell % self.width, cell / self.width)
    }

    /// The cells of the region in ascending order.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.inside.iter().zip(0..).filter_map(|(&inside, cell)| inside.then_some(cell))
    }

    /// The neighbours of a cell that belong to the region, in the order right, below, left, above.
    pub fn neighbours(&self, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
        let (x, y) = self.xy(cell);
        let right = (x + 1 < self.width).then(|| cell + 1);
        let below = (y + 1 < self.height).then(|| cell + self.width);
        let left = (x > 0).then(|| cell - 1);
        let above = (y > 0).then(|| cell - self.width);
        [right, below, left, above].into_iter().flatten().filter(|&other| self.contains(other))
    }

    /// Whether two cells of the grid share a side.
    pub fn adjacent(&self, a: Cell, b: Cell) -> bool {
        let ((ax, ay), (bx, by)) = (self.xy(a), self.xy(b));
        ax.abs_diff(bx) + ay.abs_diff(by) == 1
    }
}

fn check_size(width: u32, height: u32) -> Result<(), RegionError> {
    if width == 0 || height == 0 {
        return Err(RegionError::ZeroSize { width, height });
    }
    if width > Region::MAX_SIDE || height > Region::MAX_SIDE {
        return Err(RegionError::TooLarge { width, height });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use super::*;

    #[test]
    fn sizes_are_checked() {
        assert_eq!(Region::rectangle(0, 3), Err(RegionError::ZeroSize { width: 0, height: 3 }));
        assert_eq!(
            Region::rectangle(5000, 3),
            Err(RegionError::TooLarge { width: 5000, height: 3 })
        );
        assert_eq!(
            Region::from_mask(2, 2, vec![true; 3]),
            Err(RegionError::MaskLength { expected: 4, got: 3 })
        );
        assert_eq!(Region::from_mask(2, 2, vec![false; 4]), Err(RegionError::NoCells));
    }

    #[test]
    fn arrays_have_rows_as_their_first_axis() {
        let mask = array![[true, false, true], [true, true, true]];
        let region = Region::from_array(mask.view()).unwrap();
        assert_eq!((region.width(), region.height()), (3, 2));
        assert!(!region.contains(region.cell(1, 0)) && region.contains(region.cell(1, 1)));
        assert_eq!(region.view(), mask);
        // A transposed array is not in the order of the cells in memory.
        let transposed = Region::from_array(mask.t()).unwrap();
        assert_eq!((transposed.width(), transposed.height()), (2, 3));
        assert_eq!(transposed.view(), mask.t());
        assert!(!transposed.contains(transposed.cell(0, 1)));
    }

    #[test]
    fn arrays_of_wrong_sizes_are_refused() {
        let empty = Array2::from_elem((0, 3), true);
        let error = Region::from_array(empty.view());
        assert_eq!(error, Err(RegionError::ZeroSize { width: 3, height: 0 }));
        let long = Array2::from_elem((1, 4097), true);
        let error = Region::from_array(long.view());
        assert_eq!(error, Err(RegionError::TooLarge { width: 4097, height: 1 }));
    }

    #[test]
    fn neighbours_stay_in_the_region() {
        let ring = Region::from_mask(3, 3, (0..9).map(|cell| cell != 4).collect()).unwrap();
        assert_eq!(ring.neighbours(1).collect::<Vec<_>>(), [2, 0]);
        assert_eq!(ring.neighbours(8).collect::<Vec<_>>(), [7, 5]);
        assert_eq!(ring.cell_count(), 8);
        assert!(!ring.is_rectangle());
        assert!(!ring.contains(9));
        assert!(ring.adjacent(2, 5) && !ring.adjacent(2, 3));
    }
}
