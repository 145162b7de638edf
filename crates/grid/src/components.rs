//! Connected components of a region, and of its zones.

use ndarray::ArrayView2;

use crate::{Cell, Region, Zones};

/// The connected components of a region or of its zones: sets of cells in which every cell can be
/// reached from every other one by steps between cells that share a side.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    label: Vec<u32>,
    count: u32,
}

impl Components {
    /// Label of cells outside the region.
    pub const OUTSIDE: u32 = u32::MAX;

    /// Number of components, at least 1.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Number of the component of a cell; [`Components::OUTSIDE`] outside the region.
    /// Components are numbered from 0 in the order of their lowest cells.
    ///
    /// # Panics
    /// If the cell lies outside the grid.
    pub fn label(&self, cell: Cell) -> u32 {
        self.label[cell as usize]
    }

    /// Number of each cell's component, as an array with the axes `[y, x]`; [`Components::OUTSIDE`]
    /// outside the region.
    ///
    /// `region` must be the region that the components were made for.
    ///
    /// # Panics
    /// If the region's grid has another number of cells.
    pub fn view(&self, region: &Region) -> ArrayView2<'_, u32> {
        region.as_rows(&self.label)
    }
}

/// Finds the connected components of the region.
/// Linear in the grid's cells.
pub fn region_components(region: &Region) -> Components {
    flood(region, |_, _| true)
}

/// Finds the connected components of the zones: connected cells of equal zones.
/// Linear in the grid's cells.
pub fn zone_components(region: &Region, zones: &Zones) -> Components {
    flood(region, |a, b| zones.id(a) == zones.id(b))
}

/// Labels cells by flood fill, with a stack in place of recursion.
fn flood(region: &Region, same: impl Fn(Cell, Cell) -> bool) -> Components {
    let mut label = vec![Components::OUTSIDE; region.grid_len()];
    let mut count = 0;
    let mut open = Vec::new();
    for first in region.cells() {
        if label[first as usize] != Components::OUTSIDE {
            continue;
        }
        label[first as usize] = count;
        open.push(first);
        while let Some(cell) = open.pop() {
            for other in region.neighbours(cell) {
                if label[other as usize] == Components::OUTSIDE && same(cell, other) {
                    label[other as usize] = count;
                    open.push(other);
                }
            }
        }
        count += 1;
    }
    Components { label, count }
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    #[test]
    fn diagonal_cells_do_not_touch() {
        let region = Region::from_mask(2, 2, vec![true, false, false, true]).unwrap();
        let components = region_components(&region);
        assert_eq!((components.count(), components.label(0), components.label(3)), (2, 0, 1));
        assert_eq!(components.label(1), Components::OUTSIDE);
        let labels = array![[0, Components::OUTSIDE], [Components::OUTSIDE, 1]];
        assert_eq!(components.view(&region), labels);
    }

    #[test]
    fn zones_split_a_region() {
        let region = Region::rectangle(3, 1).unwrap();
        let zones = Zones::new(&region, vec![0, 1, 0]).unwrap();
        assert_eq!(zone_components(&region, &zones).count(), 3);
        assert_eq!(region_components(&region).count(), 1);
    }
}
