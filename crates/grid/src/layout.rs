//! Drawn zone layouts: the four of Aali et al. and two more.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use crate::{Region, Zones};

/// A family of zone layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layout {
    /// Zone 0 where x < width / 2, else zone 1.
    LeftRight,
    /// Vertical bands of equal width.
    Stripes,
    /// A background, zone 0, and squares at random places, each a zone of its own, at least one
    /// cell apart.
    Islands,
    /// Each cell belongs to the nearest of randomly chosen cells; of equally near ones, to the
    /// first.
    Voronoi,
    /// Square blocks whose zones rise by one, round and round, to the right and downwards.
    Checkerboard,
    /// Zone 0 where y < height / 2, else zone 1.
    TopBottom,
}

/// A layout with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LayoutSpec {
    /// The family.
    pub layout: Layout,
    /// Number of zones: 2 for left-right and top-bottom, 1..=255 for the others.
    /// Islands have one zone for the background.
    pub zones: u8,
    /// Side of a square in cells, at least 1: of an island or of a checkerboard's block.
    /// The other layouts don't use it.
    pub side: u16,
}

/// Why a layout could not be drawn.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum LayoutError {
    /// The family can't have so many zones.
    #[error("{layout} can't have {zones} zones")]
    Zones {
        /// The family.
        layout: Layout,
        /// Asked number of zones.
        zones: u8,
    },
    /// A square has no cells.
    #[error("{layout} needs squares of at least one cell a side")]
    Side {
        /// The family.
        layout: Layout,
    },
    /// The islands did not fit.
    #[error(
        "found no room for {islands} islands of {side} x {side} cells, one cell apart, in {width} x {height} cells"
    )]
    NoRoom {
        /// Asked number of islands.
        islands: u8,
        /// Side of each in cells.
        side: u16,
        /// Width of the plane in cells.
        width: u32,
        /// Height of the plane in cells.
        height: u32,
    },
    /// Voronoi zones need a cell each to begin with.
    #[error("{zones} voronoi zones don't fit in {cells} cells")]
    TooManyZones {
        /// Asked number of zones.
        zones: u8,
        /// Cells of the plane.
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
    /// The four families of the paper, in the order of its tables.
    pub const PAPER: [Self; 4] = [Self::LeftRight, Self::Stripes, Self::Islands, Self::Voronoi];

    /// Whether the seed matters.
    pub fn is_random(self) -> bool {
        matches!(self, Self::Islands | Self::Voronoi)
    }
}

impl LayoutSpec {
    /// The paper's parameters: 3 stripes, 3 islands of 8 x 8 cells, 3 Voronoi zones; 2 zones for
    /// the others, and blocks of 5 x 5 cells.
    pub fn new(layout: Layout) -> Self {
        let (zones, side) = match layout {
            Layout::LeftRight | Layout::TopBottom => (2, 1),
            Layout::Stripes | Layout::Voronoi => (3, 1),
            Layout::Islands => (4, 8),
            Layout::Checkerboard => (2, 5),
        };
        Self { layout, zones, side }
    }

    /// Draws the zones of a region: on the whole plane, of which the region keeps its cells.
    ///
    /// The same seed gives the same zones on every machine.
    /// Linear in the plane's cells; times the zones for Voronoi.
    pub fn zones(&self, region: &Region, seed: u64) -> Result<Zones, LayoutError> {
        let Self { layout, zones, side } = *self;
        let two_halves = matches!(layout, Layout::LeftRight | Layout::TopBottom);
        if zones == 0 || (two_halves && zones != 2) {
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
            .expect("a layout has a zone below 255 for each cell of the plane"))
    }
}

fn draw(region: &Region, zone: impl Fn(u32, u32) -> u8) -> Vec<u8> {
    let zone = &zone;
    (0..region.height()).flat_map(|y| (0..region.width()).map(move |x| zone(x, y))).collect()
}

fn islands(
    region: &Region,
    count: u8,
    side: u16,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<u8>, LayoutError> {
    // A crowded plane can leave no room for the last island, so the whole set is drawn anew after
    // so many failures.
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
        let mut placed: Vec<(u32, u32)> = Vec::new();
        for _ in 0..count {
            let place = (0..DRAWS_PER_ISLAND).find_map(|_| {
                let place =
                    (rng.random_range(0..=width - block), rng.random_range(0..=height - block));
                placed.iter().all(|&other| apart(place, other)).then_some(place)
            });
            let Some(place) = place else { continue 'sets };
            placed.push(place);
        }
        return Ok(draw(region, |x, y| {
            let within = |&(left, top): &(u32, u32)| {
                (left..left + block).contains(&x) && (top..top + block).contains(&y)
            };
            placed.iter().position(within).map_or(0, |island| island as u8 + 1)
        }));
    }
    Err(no_room)
}

fn voronoi(region: &Region, zones: u8, rng: &mut ChaCha8Rng) -> Result<Vec<u8>, LayoutError> {
    let cells = region.grid_len();
    if usize::from(zones) > cells {
        return Err(LayoutError::TooManyZones { zones, cells });
    }
    let mut seeds: Vec<(u32, u32)> = Vec::new();
    while seeds.len() < usize::from(zones) {
        let seed = (rng.random_range(0..region.width()), rng.random_range(0..region.height()));
        if !seeds.contains(&seed) {
            seeds.push(seed);
        }
    }
    let squared =
        |x: u32, y: u32, seed: (u32, u32)| x.abs_diff(seed.0).pow(2) + y.abs_diff(seed.1).pow(2);
    Ok(draw(region, |x, y| {
        let nearest = seeds.iter().enumerate().min_by_key(|&(_, &seed)| squared(x, y, seed));
        nearest.map_or(0, |(zone, _)| zone as u8)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::zone_components;

    fn plane(width: u32, height: u32) -> Region {
        Region::rectangle(width, height).unwrap()
    }

    #[test]
    fn fixed_layouts() {
        let region = plane(5, 2);
        let ids = |layout| LayoutSpec::new(layout).zones(&region, 0).unwrap().ids().to_vec();
        assert_eq!(ids(Layout::LeftRight), [0, 0, 1, 1, 1, 0, 0, 1, 1, 1]);
        assert_eq!(ids(Layout::TopBottom), [0, 0, 0, 0, 0, 1, 1, 1, 1, 1]);
        assert_eq!(ids(Layout::Stripes), [0, 0, 1, 1, 2, 0, 0, 1, 1, 2]);
        let blocks = LayoutSpec { layout: Layout::Checkerboard, zones: 3, side: 1 };
        assert_eq!(blocks.zones(&region, 0).unwrap().ids(), [0, 1, 2, 0, 1, 1, 2, 0, 1, 2]);
    }

    #[test]
    fn islands_lie_apart() {
        let region = plane(30, 30);
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
        assert_eq!(many.zones(&plane(100, 100), 0).unwrap().count(), 65);
    }

    #[test]
    fn a_seed_names_one_layout() {
        let region = plane(20, 10);
        let draw = |seed| LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
        assert_eq!(draw(3), draw(3));
        assert_ne!(draw(3), draw(4));
        assert_eq!(draw(3).count(), 3);
        // Pinned: a change of generator would make every dataset unreadable.
        let digest = draw(3)
            .ids()
            .iter()
            .fold(0_u32, |sum, &id| sum.wrapping_mul(31).wrapping_add(u32::from(id)));
        assert_eq!(digest, 3_013_580_649);
    }

    #[test]
    fn the_most_zones_are_drawn() {
        let region = plane(255, 20);
        for layout in [Layout::Stripes, Layout::Islands, Layout::Voronoi, Layout::Checkerboard] {
            let zones = LayoutSpec { layout, zones: 255, side: 1 }.zones(&region, 0).unwrap();
            assert_eq!(zones.count(), 255, "{layout}");
        }
    }

    #[test]
    fn impossible_layouts_are_refused() {
        let region = plane(10, 10);
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
    }
}
