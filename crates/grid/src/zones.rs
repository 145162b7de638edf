//! The materials of a layer.

use ndarray::ArrayView2;
use thiserror::Error;

use crate::{Cell, Region};

/// The zone of each cell of a region.
///
/// Zones are numbered from 0; a number in between may be unused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Zones {
    ids: Vec<u8>,
    count: u32,
}

/// Why [`Zones`] could not be made.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ZonesError {
    /// There is not one zone for each cell of the plane.
    #[error("{got} zones given for a plane of {expected} cells")]
    Length {
        /// Cells of the plane.
        expected: usize,
        /// Zones given.
        got: usize,
    },
    /// The array has not the shape of the grid.
    #[error(
        "zone array is {} x {} cells, the region's grid {} x {}",
        got.0, got.1, expected.0, expected.1
    )]
    Shape {
        /// Width and height of the grid in cells.
        expected: (usize, usize),
        /// Width and height of the array.
        got: (usize, usize),
    },
    /// A cell of the region has the number that means "outside".
    #[error("cell ({x}, {y}) belongs to the region but has no zone")]
    Missing {
        /// Its column.
        x: u32,
        /// Its row.
        y: u32,
    },
}

impl Zones {
    /// What [`Zones::id`] gives for a cell outside the region.
    pub const OUTSIDE: u8 = u8::MAX;

    /// The largest number of zones.
    pub const MAX: u32 = 255;

    /// Zones from one number for each cell of the plane, row by row; numbers of cells outside the
    /// region are ignored.
    pub fn new(region: &Region, mut ids: Vec<u8>) -> Result<Self, ZonesError> {
        if ids.len() != region.grid_len() {
            return Err(ZonesError::Length { expected: region.grid_len(), got: ids.len() });
        }
        let mut count = 0;
        for (cell, id) in (0..).zip(&mut ids) {
            if !region.contains(cell) {
                *id = Self::OUTSIDE;
            } else if *id == Self::OUTSIDE {
                let (x, y) = region.xy(cell);
                return Err(ZonesError::Missing { x, y });
            } else {
                count = count.max(u32::from(*id) + 1);
            }
        }
        Ok(Self { ids, count })
    }

    /// Zones from an array with the axes `[y, x]`, of the shape of the region's grid; numbers of
    /// cells outside the region are ignored.
    ///
    /// ```
    /// use beadwork_grid::{Region, Zones};
    /// use ndarray::array;
    ///
    /// let region = Region::rectangle(3, 2)?;
    /// let ids = array![[0, 0, 1], [0, 2, 1]];
    /// let zones = Zones::from_array(&region, ids.view())?;
    /// assert_eq!(zones.count(), 3);
    /// assert_eq!(zones.view(&region)[[1, 1]], 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_array(region: &Region, ids: ArrayView2<'_, u8>) -> Result<Self, ZonesError> {
        let expected = (region.width() as usize, region.height() as usize);
        let got = (ids.ncols(), ids.nrows());
        if got != expected {
            return Err(ZonesError::Shape { expected, got });
        }
        Self::new(region, ids.iter().copied().collect())
    }

    /// Zones of all cells of the grid of these zones' region, as an array with the axes `[y, x]`;
    /// [`Zones::OUTSIDE`] outside the region.
    ///
    /// # Panics
    /// If the region's grid has another number of cells.
    pub fn view(&self, region: &Region) -> ArrayView2<'_, u8> {
        region.as_rows(&self.ids)
    }

    /// Zone of a cell; [`Zones::OUTSIDE`] outside the region.
    ///
    /// # Panics
    /// If the cell lies outside the plane.
    pub fn id(&self, cell: Cell) -> u8 {
        self.ids[cell as usize]
    }

    /// Zones of all cells of the plane, row by row.
    pub fn ids(&self) -> &[u8] {
        &self.ids
    }

    /// One more than the highest zone number, at least 1.
    pub fn count(&self) -> u32 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_of_the_region_has_a_zone() {
        let region = Region::from_mask(2, 1, vec![true, false]).unwrap();
        assert_eq!(Zones::new(&region, vec![0]), Err(ZonesError::Length { expected: 2, got: 1 }));
        assert_eq!(Zones::new(&region, vec![255, 0]), Err(ZonesError::Missing { x: 0, y: 0 }));
        let zones = Zones::new(&region, vec![7, 3]).unwrap();
        assert_eq!((zones.id(0), zones.id(1), zones.count()), (7, Zones::OUTSIDE, 8));
    }
}
