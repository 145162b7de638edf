//! Proven lower bounds.

use beadwork_grid::{Region, Zones, zone_components};

/// Crossings that a cover in so many pieces can't do without: zone components minus pieces.
///
/// Along a piece the zone component changes only at crossings, so a piece with c crossings sees at most c + 1 of them, and
/// all pieces together at most crossings + pieces. Linear in the cells.
pub fn components(region: &Region, zones: &Zones, pieces: u32) -> u32 {
    zone_components(region, zones).count().saturating_sub(pieces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use beadwork_grid::{Layout, LayoutSpec};

    #[test]
    fn layouts_of_the_paper() {
        let region = Region::rectangle(30, 30).unwrap();
        let bound = |layout| components(&region, &LayoutSpec::new(layout).zones(&region, 1).unwrap(), 1);
        assert_eq!(bound(Layout::LeftRight), 1);
        assert_eq!(bound(Layout::Stripes), 2);
        assert_eq!(components(&region, &LayoutSpec::new(Layout::Stripes).zones(&region, 0).unwrap(), 5), 0);
    }
}
