//! Steps of a path between two zones, in all and as changed by switches.

use crate::path::link;
use crate::{Cell, Path, Region, Sides, Switch, Zones};

/// Which links of a region cross from one zone to another.
///
/// Its methods take paths, switches and cells of that region; they panic on cells outside the
/// plane.
#[derive(Clone, Debug)]
pub struct Crossings {
    /// For each cell, whether its links to the right and below cross.
    across: Vec<u8>,
    /// For each corner, by how much a switch from the horizontal to the vertical links changes the
    /// crossings: -2..=2.
    gain: Vec<i8>,
}

impl Crossings {
    /// Notes where zones meet.
    /// Linear in the plane's cells.
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

    /// Crossings of a path.
    /// Linear in the plane's cells.
    pub fn count(&self, path: &Path) -> u32 {
        path.links
            .iter()
            .zip(&self.across)
            .map(|(links, across)| (links & across).count_ones())
            .sum()
    }

    /// By how much a switch changes the crossings: -2..=2.
    /// What several do together is the sum, also where they share a side.
    #[inline]
    pub fn change(&self, switch: Switch) -> i32 {
        let gain = i32::from(self.gain[switch.corner() as usize]);
        match switch.from() {
            Sides::Horizontal => gain,
            Sides::Vertical => -gain,
        }
    }

    /// Whether the link from this cell to its right neighbour crosses.
    pub fn right(&self, cell: Cell) -> bool {
        self.across[cell as usize] & link::RIGHT != 0
    }

    /// Whether the link from this cell to the neighbour below crosses.
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
    fn the_zigzag_crosses_as_often_as_counted_by_walking() {
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
