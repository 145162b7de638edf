//! Checks bounds on layers where they are known, and under changes of the layer that should keep
//! them.

use beadwork_grid::{Cell, Layout, LayoutSpec, Region, RegionShape, Zones};

use super::*;

fn bounds(region: &Region, zones: &Zones) -> Bounds {
    Bounds::new(region, zones, &Control::default()).unwrap()
}

fn square(side: u32) -> Region {
    Region::rectangle(side, side).unwrap()
}

#[test]
fn layouts_of_the_paper() {
    let region = square(30);
    let zones = |layout| LayoutSpec::new(layout).zones(&region, 1).unwrap();
    assert_eq!(components(&region, &zones(Layout::LeftRight), 1), 1);
    assert_eq!(components(&region, &zones(Layout::Stripes), 1), 2);
    assert_eq!(components(&region, &zones(Layout::Stripes), 5), 0);
    let islands = bounds(&region, &zones(Layout::Islands));
    // Three islands that touch only the background: a path may begin in one and end in another, but
    // has to enter and leave the third.
    assert_eq!(
        (islands.pieces, islands.walk, islands.scattering, islands.segments),
        (1, Some(4), 4, 3)
    );
    assert_eq!(islands.crossings(), 4);
}

#[test]
fn odd_blocks_are_bounded_by_their_colours() {
    let region = square(20);
    let zones = LayoutSpec::new(Layout::Checkerboard).zones(&region, 0).unwrap();
    let Bounds { flow, segments, walk, .. } = bounds(&region, &zones);
    assert_eq!((flow, segments, walk), (15, 15, None));
}

/// The layer rotated by 90 degrees (change 0), mirrored (1), or with its zones renumbered (2).
fn changed(region: &Region, zones: &Zones, change: u32) -> (Region, Zones) {
    let (width, height) = (region.width(), region.height());
    let (new_width, new_height) = if change == 0 { (height, width) } else { (width, height) };
    let from = |cell: Cell| -> Cell {
        let (x, y) = (cell % new_width, cell / new_width);
        match change {
            0 => (height - 1 - x) * width + y,
            1 => y * width + (width - 1 - x),
            _ => cell,
        }
    };
    let cells = || (0..new_width * new_height).map(from);
    let mask = cells().map(|cell| region.contains(cell)).collect();
    let count = zones.count() as u8;
    let renumber = |id: u8| if change == 2 && id != Zones::OUTSIDE { (id + 1) % count } else { id };
    let ids = cells().map(|cell| renumber(zones.id(cell))).collect();
    let region = Region::from_mask(new_width, new_height, mask).unwrap();
    let zones = Zones::new(&region, ids).unwrap();
    (region, zones)
}

fn layers() -> impl Iterator<Item = (Region, Zones)> {
    (0..60_u64).map(|seed| {
        let side = 10 + (seed % 13) as u32;
        let region = match RegionShape::ALL.get(seed as usize % 9) {
            Some(shape) => shape.region(side, side + 3, seed).unwrap(),
            None => Region::rectangle(side, side + 3).unwrap(),
        };
        let layout = [Layout::Voronoi, Layout::Islands, Layout::Stripes, Layout::Checkerboard]
            [seed as usize % 4];
        let zones = LayoutSpec { layout, zones: 4, side: 3 }.zones(&region, seed).unwrap();
        (region, zones)
    })
}

#[test]
fn rotating_mirroring_and_renumbering_change_no_bound() {
    for (number, (region, zones)) in layers().enumerate() {
        let original = bounds(&region, &zones);
        for change in 0..3 {
            let (region, zones) = changed(&region, &zones, change);
            let other = bounds(&region, &zones);
            // The cuts depend on which of many optimal 2-matchings they start from.
            let same = Bounds { cuts: original.cuts, ..other };
            assert_eq!(same, original, "layer {number}, change {change}");
        }
    }
}

#[test]
fn merging_two_zones_does_not_raise_the_flow() {
    for (number, (region, zones)) in layers().enumerate() {
        let merged = zones.ids().iter().map(|&id| if id == 1 { 0 } else { id }).collect();
        let merged = Zones::new(&region, merged).unwrap();
        let (all, fewer) = (bounds(&region, &zones), bounds(&region, &merged));
        assert_eq!(fewer.pieces, all.pieces, "layer {number}");
        assert!(fewer.flow <= all.flow, "layer {number}: {fewer:?} after {all:?}");
    }
}

#[test]
fn bound_of_pieces_agrees_with_that_of_the_grid_crate() {
    for (number, (region, zones)) in layers().enumerate() {
        assert_eq!(
            bounds(&region, &zones).pieces,
            beadwork_grid::piece_bound(&region, &Control::default()).unwrap(),
            "layer {number}"
        );
    }
}
