//! The kinds of instances that the exact search solves.

use beadwork_grid::{Layout, LayoutSpec, Region, RegionShape, Zones};

use crate::paper;

/// Instances of one kind: one for each seed.
pub(super) struct Case {
    /// Heading of the table that lists the case.
    pub(super) group: &'static str,
    pub(super) name: String,
    pub(super) spec: LayoutSpec,
    /// Width of the grid in cells.
    pub(super) width: u32,
    /// Height of the grid in cells.
    pub(super) height: u32,
    /// Shape of the region; `None` for all cells of the grid.
    shape: Option<RegionShape>,
    /// Number of instances.
    pub(super) seeds: u64,
}

impl Case {
    /// The region and the zones of a seed.
    pub(super) fn instance(&self, seed: u64) -> anyhow::Result<(Region, Zones)> {
        let region = match self.shape {
            Some(shape) => shape.region(self.width, self.height, seed)?,
            None => Region::rectangle(self.width, self.height)?,
        };
        let zones = self.spec.zones(&region, seed)?;
        Ok((region, zones))
    }
}

/// All cases: the paper's 24 cells, harder layouts, larger ones and masks.
///
/// Most cases have `seeds` instances; the largest grids and the masks have fewer.
pub(super) fn cases(seeds: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |group, spec: LayoutSpec, (width, height), shape, seeds| {
        let name = name(spec, shape);
        cases.push(Case { group, name, spec, width, height, shape, seeds });
    };
    for cell in paper::cells() {
        // A layout that is not random has one instance, which is solved with different seeds of the
        // search.
        let size = (cell.size.width, cell.size.height);
        add("the paper's layouts", LayoutSpec::new(cell.layout), size, None, seeds);
    }
    let voronoi = |zones| LayoutSpec { zones, ..LayoutSpec::new(Layout::Voronoi) };
    for zones in [8, 12, 30] {
        add("many zones", voronoi(zones), (100, 100), None, seeds);
    }
    let islands = LayoutSpec { layout: Layout::Islands, zones: 65, side: 4 };
    add("many zones", islands, (100, 100), None, seeds);
    add("many zones", LayoutSpec::new(Layout::Checkerboard), (100, 100), None, seeds);
    for (side, divisor) in [(200, 1), (500, 2), (1000, 5)] {
        add("large grids", voronoi(3), (side, side), None, seeds.div_ceil(divisor));
    }
    for shape in RegionShape::ALL {
        for layout in [Layout::LeftRight, Layout::Islands, Layout::Voronoi] {
            add("masks", LayoutSpec::new(layout), (60, 60), Some(shape), seeds.div_ceil(10));
        }
    }
    cases
}

fn name(spec: LayoutSpec, shape: Option<RegionShape>) -> String {
    match (shape, spec.layout) {
        (Some(shape), layout) => format!("{shape} {layout}"),
        (None, Layout::Voronoi) => format!("voronoi {}", spec.zones),
        (None, Layout::Islands) => {
            format!("{} islands of {side}x{side}", spec.zones - 1, side = spec.side)
        }
        (None, layout) => layout.name().to_owned(),
    }
}
