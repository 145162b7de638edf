//! Zone crossings: the links of a path that lead from one zone to another.

use crate::bits::link;
use crate::{Cell, Path, Region, Sides, Switch, Zones};

/// The links of a region that cross from one zone to another.
///
/// Counts the crossings of a path, and the change of that count by a [`Switch`].
/// Jumps between two pieces of a path are not links, so they never count.
///
/// All methods take paths, switches and cells of the region that this was made for, and panic on
/// cells outside its grid.
#[derive(Clone, Debug)]
pub struct Crossings {
    /// For each cell, [`link::RIGHT`] and [`link::BELOW`] if these links cross.
    across: Vec<u8>,
    /// For each corner, the change of the number of crossings by a switch that replaces the
    /// horizontal links by the vertical ones: -2..=2.
    gain: Vec<i8>,
}

impl Crossings {
    /// Finds the links that cross.
    /// Linear in the grid's cells.
    pub fn new(region: &Region, zones: &Zones) -> Self {
        let width = region.width();
        let crosses = |a: Cell, b: Cell| {
            region.contains(a) && region.contains(b) && zones.id(a) != zones.id(b)
        };
        let across = (0..region.grid_len() as Cell).map(|cell| {
            let (x, y) = region.xy(cell);
            let right = x + 1 < width && crosses(cell, cell + 1);
            let below = y + 1 < region.height() && crosses(cell, cell + width);
            (u8::from(right) * link::RIGHT) | (u8::from(below) * link::BELOW)
        });
        let across: Vec<u8> = across.collect();
        let bit = |cell: Cell, bit: u8| {
            across.get(cell as usize).map_or(0, |bits| i8::from(bits & bit != 0))
        };
        let gain = (0..region.grid_len() as Cell).map(|corner| {
            let vertical = bit(corner, link::BELOW) + bit(corner + 1, link::BELOW);
            let horizontal = bit(corner, link::RIGHT) + bit(corner + width, link::RIGHT);
            vertical - horizontal
        });
        Self { gain: gain.collect(), across }
    }

    /// Number of crossings of a path.
    /// Linear in the grid's cells.
    pub fn count(&self, path: &Path) -> u32 {
        path.links
            .iter()
            .zip(&self.across)
            .map(|(links, across)| (links & across).count_ones())
            .sum()
    }

    /// Change of the number of crossings by a switch: -2..=2.
    ///
    /// The change by several switches is the sum of their changes, even if they share a side: a
    /// link that one switch puts in and another takes out cancels.
    #[inline]
    pub fn change(&self, switch: Switch) -> i32 {
        let gain = i32::from(self.gain[switch.corner() as usize]);
        match switch.from() {
            Sides::Horizontal => gain,
            Sides::Vertical => -gain,
        }
    }

    /// Whether a link from this cell to its right neighbour crosses.
    pub fn right(&self, cell: Cell) -> bool {
        self.across[cell as usize] & link::RIGHT != 0
    }

    /// Whether a link from this cell to the neighbour below crosses.
    pub fn below(&self, cell: Cell) -> bool {
        self.across[cell as usize] & link::BELOW != 0
    }
}

#[cfg(test)]
mod tests {
    use beadwork_base::Control;

    use super::*;
    use crate::{Layout, LayoutSpec, Start};

    #[test]
    fn count_of_the_zigzag_is_that_of_a_walk_along_it() {
        let region = Region::rectangle(13, 9).unwrap();
        for layout in Layout::ALL {
            let mut spec = LayoutSpec::new(layout);
            spec.side = 3;
            let zones = spec.zones(&region, 5).unwrap();
            let path = Start::RowZigzag.path(&region, &Control::default()).unwrap();
            let walked = path
                .order()
                .windows(2)
                .filter(|step| zones.id(step[0]) != zones.id(step[1]))
                .count();
            assert_eq!(Crossings::new(&region, &zones).count(&path) as usize, walked, "{layout}");
        }
    }
}
