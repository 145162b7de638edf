//! The zones of a layer: areas of different materials.

use ndarray::ArrayView2;
use thiserror::Error;

use crate::{Cell, Region};

/// The zone of each cell of a region: usually, the number of its material.
///
/// Zones are numbered from 0, and numbers may be skipped.
/// A zone need not be connected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Zones {
    ids: Vec<u8>,
    count: u32,
}

/// Why [`Zones`] could not be constructed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ZonesError {
    /// The list of zone numbers does not have one entry for each cell of the grid.
    #[error("zone list has {got} entries, the region's grid {expected} cells")]
    Length {
        /// Number of cells of the grid.
        expected: usize,
        /// Number of entries of the list.
        got: usize,
    },
    /// The shape of the array is not that of the grid.
    #[error(
        "zone array is {} x {} cells, the region's grid {} x {}",
        got.0, got.1, expected.0, expected.1
    )]
    Shape {
        /// Width and height of the grid in cells.
        expected: (usize, usize),
        /// Width and height of the array: the lengths of its second and its first axis.
        got: (usize, usize),
    },
    /// A cell of the region has the zone number [`Zones::OUTSIDE`].
    #[error("cell ({x}, {y}) belongs to the region but has no zone")]
    Missing {
        /// Column of the cell.
        x: u32,
        /// Row of the cell.
        y: u32,
    },
}

impl Zones {
    /// Zone number of cells outside the region.
    pub const OUTSIDE: u8 = u8::MAX;

    /// Maximum number of zones.
    pub const MAX: u32 = 255;

    /// Makes zones from one number for each cell of the region's grid, indexed by [`Cell`].
    /// Numbers of cells outside the region are ignored.
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

    /// Makes zones from an array with the axes `[y, x]` and the shape of the region's grid.
    /// Numbers of cells outside the region are ignored.
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

    /// Zone of each cell of the grid, as an array with the axes `[y, x]`; [`Zones::OUTSIDE`]
    /// outside the region.
    ///
    /// `region` must be the region that the zones were made for.
    ///
    /// # Panics
    /// If the region's grid has another number of cells.
    pub fn view(&self, region: &Region) -> ArrayView2<'_, u8> {
        region.as_rows(&self.ids)
    }

    /// Zone of a cell; [`Zones::OUTSIDE`] outside the region.
    ///
    /// # Panics
    /// If the cell lies outside the grid.
    pub fn id(&self, cell: Cell) -> u8 {
        self.ids[cell as usize]
    }

    /// Zone of each cell of the grid, indexed by [`Cell`].
    pub fn ids(&self) -> &[u8] {
        &self.ids
    }

    /// One more than the highest zone number, at least 1; unused numbers below it count.
    pub fn count(&self) -> u32 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    #[test]
    fn every_cell_of_the_region_has_a_zone() {
        let region = Region::from_mask(2, 1, vec![true, false]).unwrap();
        assert_eq!(Zones::new(&region, vec![0]), Err(ZonesError::Length { expected: 2, got: 1 }));
        assert_eq!(Zones::new(&region, vec![255, 0]), Err(ZonesError::Missing { x: 0, y: 0 }));
        let zones = Zones::new(&region, vec![7, 3]).unwrap();
        assert_eq!((zones.id(0), zones.id(1), zones.count()), (7, Zones::OUTSIDE, 8));
    }

    #[test]
    fn arrays_have_rows_as_their_first_axis() {
        let mask = array![[true, true, false], [true, true, true]];
        let region = Region::from_array(mask.view()).unwrap();
        let zones = Zones::from_array(&region, array![[0, 1, 9], [2, 3, 4]].view()).unwrap();
        assert_eq!(zones.ids(), [0, 1, Zones::OUTSIDE, 2, 3, 4]);
        assert_eq!(zones.view(&region), array![[0, 1, Zones::OUTSIDE], [2, 3, 4]]);
        assert_eq!(zones.id(region.cell(1, 1)), zones.view(&region)[[1, 1]]);
        let columns = array![[0, 2], [1, 3], [9, 4]];
        assert_eq!(Zones::from_array(&region, columns.t()), Ok(zones));
        let error = Zones::from_array(&region, columns.view()).unwrap_err();
        assert_eq!(error, ZonesError::Shape { expected: (3, 2), got: (2, 3) });
        assert_eq!(error.to_string(), "zone array is 2 x 3 cells, the region's grid 3 x 2");
    }
}
