//! Generated regions that are not rectangles, with outlines like those of parts.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Region, RegionError};

/// A family of outlines.
///
/// The seed varies sizes and angles, and the position of the centre of discs and rings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RegionShape {
    /// All cells within a circle.
    Disc,
    /// A disc with a concentric round hole.
    Ring,
    /// A smooth closed curve around the centre, whose radius is a sum of random waves.
    Blob,
    /// A rectangle with sides of about 2 : 1, rotated by a random angle.
    RotatedRectangle,
    /// A star with five to seven points.
    Star,
    /// A square without one of its four corners, an L, with arms of random widths.
    L,
}

beadwork_base::named_enum! {
    RegionShape, "shape":
    Disc = "disc",
    Ring = "ring",
    Blob = "blob",
    RotatedRectangle = "rotated_rectangle",
    Star = "star",
    L = "l",
}

impl RegionShape {
    /// Generates the region of the cells whose centres lie inside the outline, on a grid of `width`
    /// x `height` cells.
    ///
    /// The same seed gives the same region on every machine.
    /// On grids of a few cells there may be no cell inside: [`RegionError::NoCells`].
    /// Linear in the grid's cells, at up to about 0.2 microseconds each.
    pub fn region(self, width: u32, height: u32, seed: u64) -> Result<Region, RegionError> {
        let outline = self.outline(&mut ChaCha8Rng::seed_from_u64(seed));
        // Coordinates relative to the grid's centre, in units of half the shorter side.
        let unit = 2.0 / f64::from(width.min(height).max(1));
        let (centre_x, centre_y) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let inside = cells.map(|(x, y)| {
            outline((f64::from(x) + 0.5 - centre_x) * unit, (f64::from(y) + 0.5 - centre_y) * unit)
        });
        Region::from_mask(width, height, inside.collect())
    }

    /// Draws an outline: a function that says whether a point (x, y) lies inside.
    /// Both coordinates are within -1..1 on a square grid.
    fn outline(self, rng: &mut ChaCha8Rng) -> Box<dyn Fn(f64, f64) -> bool> {
        let mut draw = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let (dx, dy) = (draw(-0.05, 0.05), draw(-0.05, 0.05));
        let turn = draw(0.0, std::f64::consts::TAU);
        match self {
            Self::Disc => {
                let radius = draw(0.75, 0.94);
                Box::new(move |x, y| libm::hypot(x - dx, y - dy) < radius)
            }
            Self::Ring => {
                let (outer, inner) = (draw(0.75, 0.94), draw(0.25, 0.55));
                Box::new(move |x, y| (inner..outer).contains(&libm::hypot(x - dx, y - dy)))
            }
            Self::Blob => {
                let waves = [2.0, 3.0, 4.0, 5.0]
                    .map(|count| (count, draw(0.0, 0.18) / count * 2.0, draw(0.0, 6.3)));
                Box::new(move |x, y| {
                    let angle = libm::atan2(y, x);
                    let wave = |(count, size, phase): (f64, f64, f64)| {
                        size * libm::cos(count * angle + phase)
                    };
                    libm::hypot(x, y) < 0.68 + waves.into_iter().map(wave).sum::<f64>()
                })
            }
            Self::RotatedRectangle => {
                let (long, short) = (draw(0.7, 0.85), draw(0.3, 0.45));
                let (sin, cos) = (libm::sin(turn), libm::cos(turn));
                Box::new(move |x, y| {
                    let (along, across) = (x * cos + y * sin, y * cos - x * sin);
                    along.abs() < long && across.abs() < short
                })
            }
            Self::Star => {
                let points = libm::floor(draw(5.0, 8.0));
                let (outer, inner) = (draw(0.8, 0.95), draw(0.35, 0.5));
                Box::new(move |x, y| {
                    // The star has 2 * points equal sectors up to reflection.
                    // In each, its edge is a straight line from an outer corner (a tip) to an inner
                    // corner, so rotate and reflect the point into the first sector.
                    let half = std::f64::consts::PI / points;
                    let angle =
                        libm::fmod(libm::atan2(y, x) + turn + std::f64::consts::TAU, 2.0 * half);
                    let angle = (angle - half).abs();
                    let (tip, inner_corner) =
                        ((outer * libm::cos(half), outer * libm::sin(half)), (inner, 0.0));
                    let radius = libm::hypot(x, y);
                    let point = (radius * libm::cos(angle), radius * libm::sin(angle));
                    // The cross product is positive on the side of the star's centre.
                    let cross = (tip.0 - inner_corner.0) * (point.1 - inner_corner.1)
                        - (tip.1 - inner_corner.1) * (point.0 - inner_corner.0);
                    cross > 0.0
                })
            }
            Self::L => {
                let (arm_x, arm_y, corner) =
                    (draw(-0.3, 0.3), draw(-0.3, 0.3), libm::floor(draw(0.0, 4.0)) as u32);
                Box::new(move |x, y| {
                    let x = if corner & 1 == 0 { x } else { -x };
                    let y = if corner & 2 == 0 { y } else { -y };
                    x.abs().max(y.abs()) < 0.92 && (x < arm_x || y < arm_y)
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Share of the grid that the region covers, and a digest of its cells.
    fn draw(shape: RegionShape, seed: u64) -> (f64, u32) {
        let region = shape.region(60, 60, seed).unwrap();
        let digest =
            region.cells().fold(0_u32, |sum, cell| sum.wrapping_mul(31).wrapping_add(cell));
        (f64::from(region.cell_count()) / 3600.0, digest)
    }

    #[test]
    fn shapes_cover_a_tenth_to_nine_tenths_of_the_grid() {
        for shape in RegionShape::ALL {
            for seed in 0..50 {
                let (share, digest) = draw(shape, seed);
                assert!((0.1..0.9).contains(&share), "{shape} of seed {seed} covers {share}");
                assert_eq!(draw(shape, seed).1, digest);
            }
            assert_ne!(draw(shape, 0).1, draw(shape, 1).1, "{shape}");
        }
    }

    #[test]
    fn names_round_trip() {
        for shape in RegionShape::ALL {
            assert_eq!(shape.name().parse(), Ok(shape));
        }
        assert_eq!(
            "hexagon".parse::<RegionShape>().unwrap_err().to_string(),
            "unknown shape 'hexagon': expected disc, ring, blob, rotated_rectangle, star or l"
        );
    }

    #[test]
    fn grids_without_a_cell_inside_are_refused() {
        assert_eq!(RegionShape::Ring.region(1, 1, 0), Err(RegionError::NoCells));
        assert!(RegionShape::Disc.region(0, 4, 0).is_err());
    }
}
