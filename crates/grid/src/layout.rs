//! Generated zone layouts: the four of Aali et al. and two more.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use crate::{Region, Zones};

/// A family of zone layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layout {
    /// Two halves: zone 0 where x < width / 2, zone 1 elsewhere.
    LeftRight,
    /// Vertical bands of equal width.
    Stripes,
    /// Squares at random positions, at least one cell apart, each with its own zone, on a
    /// background of zone 0.
    Islands,
    /// Voronoi cells of random centres: each cell belongs to the nearest centre, and to the first
    /// of several equally near ones.
    Voronoi,
    /// Square blocks; the zone number increases by one, modulo the number of zones, with each block
    /// to the right and each block down.
    Checkerboard,
    /// Two halves: zone 0 where y < height / 2, zone 1 elsewhere.
    TopBottom,
}

/// The parameters of a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LayoutSpec {
    /// The family of layouts.
    pub layout: Layout,
    /// Number of zones: 2 for [`Layout::LeftRight`] and [`Layout::TopBottom`], 1..=255 for the
    /// others.
    /// The background of islands counts as a zone, so there is one island fewer.
    pub zones: u8,
    /// Side of an island or of a block of the checkerboard, in cells, at least 1. The other layouts
    /// ignore it.
    pub side: u16,
}

/// Why a layout could not be generated.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum LayoutError {
    /// The family does not allow this number of zones.
    #[error(
        "{layout} layout cannot have {zones} zones: expected {}",
        if layout.has_two_zones() { "2" } else { "1 to 255" }
    )]
    Zones {
        /// The family of layouts.
        layout: Layout,
        /// Requested number of zones.
        zones: u8,
    },
    /// The side of the squares is zero.
    #[error("{layout} layout has squares with sides of 0 cells: expected at least 1")]
    Side {
        /// The family of layouts.
        layout: Layout,
    },
    /// No positions were found for all islands.
    #[error(
        "islands layout: found no room for {islands} islands of {side} x {side} cells, \
         one cell apart, in {width} x {height} cells; try fewer or smaller ones"
    )]
    NoRoom {
        /// Requested number of islands.
        islands: u8,
        /// Side of each island in cells.
        side: u16,
        /// Width of the grid in cells.
        width: u32,
        /// Height of the grid in cells.
        height: u32,
    },
    /// The grid has fewer cells than the Voronoi layout needs centres.
    #[error("voronoi layout: {zones} zones do not fit into {cells} cells")]
    TooManyZones {
        /// Requested number of zones.
        zones: u8,
        /// Number of cells of the grid.
        cells: usize,
    },
}

beadwork_base::named_enum! {
    Layout, "layout":
    LeftRight = "left_right",
    Stripes = "stripes",
    Islands = "islands",
    Voronoi = "voronoi",
    Checkerboard = "checkerboard",
    TopBottom = "top_bottom",
}

impl Layout {
    /// The four families of Aali et al., in the order of the paper's tables.
    pub const PAPER: [Self; 4] = [Self::LeftRight, Self::Stripes, Self::Islands, Self::Voronoi];

    /// Whether the layout depends on the seed.
    pub fn is_random(self) -> bool {
        matches!(self, Self::Islands | Self::Voronoi)
    }

    /// Whether the layout always has two zones.
    fn has_two_zones(self) -> bool {
        matches!(self, Self::LeftRight | Self::TopBottom)
    }
}

impl LayoutSpec {
    /// The parameters of the paper: 3 stripes, 3 islands of 8 x 8 cells (so 4 zones), 3 Voronoi
    /// zones, and 2 halves.
    /// The checkerboard, which the paper does not have, gets 2 zones and blocks of 5 x 5 cells.
    pub fn new(layout: Layout) -> Self {
        let (zones, side) = match layout {
            Layout::LeftRight | Layout::TopBottom => (2, 1),
            Layout::Stripes | Layout::Voronoi => (3, 1),
            Layout::Islands => (4, 8),
            Layout::Checkerboard => (2, 5),
        };
        Self { layout, zones, side }
    }

    /// Generates the zones of a region.
    ///
    /// The layout covers the whole grid, and the region keeps the zones of its cells.
    /// So on a region that is not a rectangle, some zones may have no cells.
    /// The same seed gives the same zones on every machine; layouts without randomness ignore it.
    ///
    /// Linear in the grid's cells.
    pub fn zones(&self, region: &Region, seed: u64) -> Result<Zones, LayoutError> {
        let Self { layout, zones, side } = *self;
        if zones == 0 || (layout.has_two_zones() && zones != 2) {
            return Err(LayoutError::Zones { layout, zones });
        }
        if side == 0 && matches!(layout, Layout::Islands | Layout::Checkerboard) {
            return Err(LayoutError::Side { layout });
        }
        let (width, height) = (region.width(), region.height());
        let (k, block) = (u32::from(zones), u32::from(side));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let ids = match layout {
            Layout::LeftRight => draw(region, |x, _| u8::from(x >= width / 2)),
            Layout::TopBottom => draw(region, |_, y| u8::from(y >= height / 2)),
            Layout::Stripes => draw(region, |x, _| (x * k / width) as u8),
            Layout::Checkerboard => draw(region, |x, y| ((x / block + y / block) % k) as u8),
            Layout::Islands => islands(region, zones - 1, side, &mut rng)?,
            Layout::Voronoi => voronoi(region, zones, &mut rng)?,
        };
        Ok(Zones::new(region, ids)
            .expect("a layout has a zone below 255 for each cell of the grid"))
    }
}

/// Zone numbers from a function of column and row.
fn draw(region: &Region, zone: impl Fn(u32, u32) -> u8) -> Vec<u8> {
    let zone = &zone;
    (0..region.height()).flat_map(|y| (0..region.width()).map(move |x| zone(x, y))).collect()
}

/// Islands at random positions, by rejection: a position too close to an earlier island is drawn
/// again.
fn islands(
    region: &Region,
    count: u8,
    side: u16,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<u8>, LayoutError> {
    // The first islands may lie so that no room is left for the last one.
    // So after this many draws for one island, all islands are drawn again.
    const DRAWS_PER_ISLAND: u32 = 200;
    const SETS: u32 = 100;

    let (width, height, block) = (region.width(), region.height(), u32::from(side));
    let no_room = LayoutError::NoRoom { islands: count, side, width, height };
    if block > width || block > height {
        return if count == 0 { Ok(draw(region, |_, _| 0)) } else { Err(no_room) };
    }
    let apart =
        |a: (u32, u32), b: (u32, u32)| a.0.abs_diff(b.0) > block || a.1.abs_diff(b.1) > block;
    'sets: for _ in 0..SETS {
        // Columns and rows of the top-left cells.
        let mut islands: Vec<(u32, u32)> = Vec::new();
        for _ in 0..count {
            let island = (0..DRAWS_PER_ISLAND).find_map(|_| {
                let island =
                    (rng.random_range(0..=width - block), rng.random_range(0..=height - block));
                islands.iter().all(|&other| apart(island, other)).then_some(island)
            });
            let Some(island) = island else { continue 'sets };
            islands.push(island);
        }
        let mut ids = vec![0; region.grid_len()];
        for (&(left, top), id) in islands.iter().zip(1..) {
            for y in top..top + block {
                let first = region.cell(left, y) as usize;
                ids[first..first + block as usize].fill(id);
            }
        }
        return Ok(ids);
    }
    Err(no_room)
}

fn voronoi(region: &Region, zones: u8, rng: &mut ChaCha8Rng) -> Result<Vec<u8>, LayoutError> {
    let cells = region.grid_len();
    if usize::from(zones) > cells {
        return Err(LayoutError::TooManyZones { zones, cells });
    }
    let mut centres: Vec<(u32, u32)> = Vec::new();
    while centres.len() < usize::from(zones) {
        let centre = (rng.random_range(0..region.width()), rng.random_range(0..region.height()));
        if !centres.contains(&centre) {
            centres.push(centre);
        }
    }
    Ok(nearest_centres(region, &centres))
}

/// For each cell the number of the nearest centre, the lowest of several equally near ones.
///
/// Comparing every cell with every centre would take seconds on the largest grids.
/// So the grid is divided into square blocks, and the cells of a block are compared only with its
/// candidates: the centres whose distance to the nearest point of the block is at most the distance
/// that some centre has to the block's farthest point.
/// Any other centre is farther from every cell of the block than that one.
fn nearest_centres(region: &Region, centres: &[(u32, u32)]) -> Vec<u8> {
    const SIDE: u32 = 32;
    let mut ids = vec![0; region.grid_len()];
    let mut candidates: Vec<((u32, u32), u8)> = Vec::new();
    for top in (0..region.height()).step_by(SIDE as usize) {
        let bottom = (top + SIDE).min(region.height()) - 1;
        for left in (0..region.width()).step_by(SIDE as usize) {
            let right = (left + SIDE).min(region.width()) - 1;
            let to_nearest_point = |&(x, y): &(u32, u32)| {
                squared_distance((x.clamp(left, right), y.clamp(top, bottom)), (x, y))
            };
            let to_farthest_point = |&(x, y): &(u32, u32)| {
                let dx = x.abs_diff(left).max(x.abs_diff(right));
                let dy = y.abs_diff(top).max(y.abs_diff(bottom));
                dx * dx + dy * dy
            };
            let limit = centres.iter().map(to_farthest_point).min().unwrap_or(0);
            candidates.clear();
            let numbered = centres.iter().copied().zip(0..);
            candidates.extend(numbered.filter(|(centre, _)| to_nearest_point(centre) <= limit));
            for y in top..=bottom {
                for x in left..=right {
                    let zone = candidates
                        .iter()
                        .min_by_key(|(centre, _)| squared_distance((x, y), *centre))
                        .map_or(0, |&(_, zone)| zone);
                    ids[region.cell(x, y) as usize] = zone;
                }
            }
        }
    }
    ids
}

fn squared_distance(a: (u32, u32), b: (u32, u32)) -> u32 {
    a.0.abs_diff(b.0).pow(2) + a.1.abs_diff(b.1).pow(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::zone_components;

    fn rectangle(width: u32, height: u32) -> Region {
        Region::rectangle(width, height).unwrap()
    }

    #[test]
    fn fixed_layouts() {
        let region = rectangle(5, 2);
        let ids = |layout| LayoutSpec::new(layout).zones(&region, 0).unwrap().ids().to_vec();
        assert_eq!(ids(Layout::LeftRight), [0, 0, 1, 1, 1, 0, 0, 1, 1, 1]);
        assert_eq!(ids(Layout::TopBottom), [0, 0, 0, 0, 0, 1, 1, 1, 1, 1]);
        assert_eq!(ids(Layout::Stripes), [0, 0, 1, 1, 2, 0, 0, 1, 1, 2]);
        let blocks = LayoutSpec { layout: Layout::Checkerboard, zones: 3, side: 1 };
        assert_eq!(blocks.zones(&region, 0).unwrap().ids(), [0, 1, 2, 0, 1, 1, 2, 0, 1, 2]);
    }

    #[test]
    fn islands_lie_apart() {
        let region = rectangle(30, 30);
        for seed in 0..100 {
            let zones = LayoutSpec::new(Layout::Islands).zones(&region, seed).unwrap();
            for island in 1..4 {
                assert_eq!(
                    zones.ids().iter().filter(|&&id| id == island).count(),
                    64,
                    "seed {seed}"
                );
            }
            for cell in region.cells() {
                let touches = region.neighbours(cell).any(|other| {
                    zones.id(cell) != zones.id(other) && zones.id(cell) != 0 && zones.id(other) != 0
                });
                assert!(!touches, "two islands touch, seed {seed}");
            }
        }
        let many = LayoutSpec { layout: Layout::Islands, zones: 65, side: 4 };
        assert!(
            zone_components(&region, &LayoutSpec::new(Layout::Islands).zones(&region, 1).unwrap())
                .count()
                >= 4
        );
        assert_eq!(many.zones(&rectangle(100, 100), 0).unwrap().count(), 65);
    }

    #[test]
    fn a_seed_always_gives_the_same_layout() {
        let region = rectangle(20, 10);
        let draw = |seed| LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
        assert_eq!(draw(3), draw(3));
        assert_ne!(draw(3), draw(4));
        assert_eq!(draw(3).count(), 3);
        // Datasets store only the seed, so a change of the generator would invalidate them.
        let digest = draw(3)
            .ids()
            .iter()
            .fold(0_u32, |sum, &id| sum.wrapping_mul(31).wrapping_add(u32::from(id)));
        assert_eq!(digest, 3_013_580_649);
    }

    #[test]
    fn layouts_can_have_255_zones() {
        let region = rectangle(255, 20);
        for layout in [Layout::Stripes, Layout::Islands, Layout::Voronoi, Layout::Checkerboard] {
            let zones = LayoutSpec { layout, zones: 255, side: 1 }.zones(&region, 0).unwrap();
            assert_eq!(zones.count(), 255, "{layout}");
        }
    }

    #[test]
    fn impossible_layouts_are_refused() {
        let region = rectangle(10, 10);
        let error =
            |layout, zones, side| LayoutSpec { layout, zones, side }.zones(&region, 0).unwrap_err();
        assert_eq!(
            error(Layout::LeftRight, 3, 1),
            LayoutError::Zones { layout: Layout::LeftRight, zones: 3 }
        );
        assert_eq!(
            error(Layout::Stripes, 0, 1),
            LayoutError::Zones { layout: Layout::Stripes, zones: 0 }
        );
        assert_eq!(
            error(Layout::Checkerboard, 2, 0),
            LayoutError::Side { layout: Layout::Checkerboard }
        );
        assert!(matches!(error(Layout::Islands, 4, 8), LayoutError::NoRoom { islands: 3, .. }));
        assert!(matches!(error(Layout::Islands, 4, 80), LayoutError::NoRoom { side: 80, .. }));
        assert_eq!(
            error(Layout::Voronoi, 101, 1),
            LayoutError::TooManyZones { zones: 101, cells: 100 }
        );
        assert_eq!(
            error(Layout::TopBottom, 3, 1).to_string(),
            "top_bottom layout cannot have 3 zones: expected 2"
        );
        assert_eq!(
            error(Layout::Stripes, 0, 1).to_string(),
            "stripes layout cannot have 0 zones: expected 1 to 255"
        );
    }

    #[test]
    fn voronoi_compares_each_cell_with_all_centres_that_matter() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for (width, height, count) in [(150, 70, 1), (97, 130, 7), (64, 64, 60), (40, 200, 255)] {
            let mut draw = |side| rng.random_range(0..side);
            // Centres in few rows, some of them equal, so that there are many ties.
            let centres: Vec<_> = (0..count).map(|_| (draw(width), draw(height) / 9 * 9)).collect();
            let ids = nearest_centres(&rectangle(width, height), &centres);
            for (cell, &id) in (0..).zip(&ids) {
                let cell = (cell % width, cell / width);
                let distance = |&number: &usize| squared_distance(cell, centres[number]);
                let nearest = (0..centres.len()).min_by_key(distance).unwrap();
                assert_eq!(usize::from(id), nearest, "{cell:?} of {width} x {height}");
            }
        }
    }
}
