//! The 38 named orders in which a layer may be deposited.

mod outline;
mod sheet;
mod sweep;
#[cfg(test)]
mod tests;

use std::fmt;
use std::str::FromStr;

use beadwork_grid::{Cell, Region};
use thiserror::Error;

use self::outline::outlines;
use self::sweep::{Sweep, View, sweep};

pub use self::sheet::pattern_sheet;

/// One of the 38 orders in which the cells of a layer may be deposited.
///
/// Each is an order of the whole plane of which a region keeps its cells: consecutive cells need
/// not be neighbours.
/// A name has the family, the axis along which the lines run where there is a choice, and the
/// **corner** where the order begins: 0 = least x and y, 1 = most x, 2 = most y, 3 = most of both.
/// In the order of their numbers:
///
/// | Numbers | Names | Order |
/// |---|---|---|
/// | 0..=7 | `zigzag-x-0` .. `zigzag-y-3` | lines along the axis, side by side, each second one backwards |
/// | 8..=15 | `raster-x-0` .. `raster-y-3` | the same lines, all in one direction |
/// | 16..=19 | `spiral-in-0` .. `spiral-in-3` | along the row from the corner, then round and round inwards |
/// | 20..=23 | `spiral-out-0` .. `spiral-out-3` | the same reversed: it ends in the corner |
/// | 24..=31 | `contour-zigzag-x-0` .. `contour-zigzag-y-3` | the outlines, then all else as a zigzag |
/// | 32..=35 | `contour-raster-x-0`, `-x-3`, `-y-0`, `-y-3` | the outlines, then all else as a raster |
/// | 36, 37 | `diagonal-0`, `diagonal-1` | diagonals from corner 0 or 1, each second one backwards |
///
/// The orders from the other corners are those from corner 0 in the mirror, and those along y are
/// those along x transposed, outlines included.
/// So a spiral from corner 0 or 3 turns clockwise (seen with y down) and one from corner 1 or 2 the
/// other way.
/// A diagonal zigzag enters its second diagonal at row 0.
///
/// # Outlines
/// A contour takes the cells that have one of their **eight** neighbours outside the region or the
/// plane.
/// With four, an outline would break at each inner corner of the region, where it would step
/// diagonally; with eight, each outline is a closed walk in unit steps.
/// Parts of the region that meet only at a corner have an outline each, holes that meet at a corner
/// share one.
///
/// An outline begins at its cell nearest to the corner, as the crow flies; of equally near ones, at
/// that in the line nearest to the corner.
/// It runs so that a part's outer outline sets out across the axis: along it, a contour with a
/// zigzag inside would be nothing but the spiral on many a rectangle.
/// As it is, a rectangle's outline ends beside the first line of the rest: here the first line of
/// the plane counts as one backwards, so that the second begins at the corner's side.
/// Around a hole it runs the other way, the region on the same hand.
/// Outlines that begin nearer to the corner come first, so that none comes before the one around
/// it; what two of them touch, or one touches twice, as in walls one or two cells wide, comes where
/// it is touched first.
///
/// # Example
/// ```
/// use beadwork_grid::Region;
/// use beadwork_part::Pattern;
///
/// let region = Region::rectangle(4, 3)?;
/// assert_eq!("zigzag-x-1".parse::<Pattern>()?.order(&region), [3, 2, 1, 0, 4, 5, 6, 7, 11, 10, 9, 8]);
/// assert_eq!(Pattern::CONVENTIONAL.order(&region), [0, 4, 8, 9, 10, 11, 7, 3, 2, 1, 5, 6]);
/// assert_eq!(Pattern::CONVENTIONAL.to_string(), "contour-zigzag-x-0");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pattern(u8);

/// A name that is no [`Pattern`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "'{0}' is no pattern: names are like zigzag-x-0, raster-y-3, spiral-in-1, spiral-out-2, contour-zigzag-x-0, \
     contour-raster-y-3 and diagonal-1"
)]
pub struct UnknownPattern(pub String);

/// How a pattern orders a plane.
struct Spec {
    name: &'static str,
    /// Whether the outlines come first.
    contour: bool,
    sweep: Sweep,
    /// Whether its lines run along y.
    transposed: bool,
    corner: u8,
}

const X: bool = false;
const Y: bool = true;

const fn spec(name: &'static str, sweep: Sweep, transposed: bool, corner: u8) -> Spec {
    Spec { name, contour: false, sweep, transposed, corner }
}

const fn contour(name: &'static str, sweep: Sweep, transposed: bool, corner: u8) -> Spec {
    Spec { name, contour: true, sweep, transposed, corner }
}

const SPECS: [Spec; Pattern::COUNT] = [
    spec("zigzag-x-0", Sweep::Zigzag, X, 0),
    spec("zigzag-x-1", Sweep::Zigzag, X, 1),
    spec("zigzag-x-2", Sweep::Zigzag, X, 2),
    spec("zigzag-x-3", Sweep::Zigzag, X, 3),
    spec("zigzag-y-0", Sweep::Zigzag, Y, 0),
    spec("zigzag-y-1", Sweep::Zigzag, Y, 1),
    spec("zigzag-y-2", Sweep::Zigzag, Y, 2),
    spec("zigzag-y-3", Sweep::Zigzag, Y, 3),
    spec("raster-x-0", Sweep::Raster, X, 0),
    spec("raster-x-1", Sweep::Raster, X, 1),
    spec("raster-x-2", Sweep::Raster, X, 2),
    spec("raster-x-3", Sweep::Raster, X, 3),
    spec("raster-y-0", Sweep::Raster, Y, 0),
    spec("raster-y-1", Sweep::Raster, Y, 1),
    spec("raster-y-2", Sweep::Raster, Y, 2),
    spec("raster-y-3", Sweep::Raster, Y, 3),
    spec("spiral-in-0", Sweep::SpiralIn, X, 0),
    spec("spiral-in-1", Sweep::SpiralIn, X, 1),
    spec("spiral-in-2", Sweep::SpiralIn, X, 2),
    spec("spiral-in-3", Sweep::SpiralIn, X, 3),
    spec("spiral-out-0", Sweep::SpiralOut, X, 0),
    spec("spiral-out-1", Sweep::SpiralOut, X, 1),
    spec("spiral-out-2", Sweep::SpiralOut, X, 2),
    spec("spiral-out-3", Sweep::SpiralOut, X, 3),
    contour("contour-zigzag-x-0", Sweep::InnerZigzag, X, 0),
    contour("contour-zigzag-x-1", Sweep::InnerZigzag, X, 1),
    contour("contour-zigzag-x-2", Sweep::InnerZigzag, X, 2),
    contour("contour-zigzag-x-3", Sweep::InnerZigzag, X, 3),
    contour("contour-zigzag-y-0", Sweep::InnerZigzag, Y, 0),
    contour("contour-zigzag-y-1", Sweep::InnerZigzag, Y, 1),
    contour("contour-zigzag-y-2", Sweep::InnerZigzag, Y, 2),
    contour("contour-zigzag-y-3", Sweep::InnerZigzag, Y, 3),
    contour("contour-raster-x-0", Sweep::Raster, X, 0),
    contour("contour-raster-x-3", Sweep::Raster, X, 3),
    contour("contour-raster-y-0", Sweep::Raster, Y, 0),
    contour("contour-raster-y-3", Sweep::Raster, Y, 3),
    spec("diagonal-0", Sweep::Diagonal, X, 0),
    spec("diagonal-1", Sweep::Diagonal, X, 1),
];

impl Pattern {
    /// How many there are.
    pub const COUNT: usize = 38;

    /// All of them, in the order of their numbers.
    pub const ALL: [Self; Self::COUNT] = {
        let mut all = [Self(0); Self::COUNT];
        let mut number = 0;
        while number < Self::COUNT {
            all[number] = Self(number as u8);
            number += 1;
        }
        all
    };

    /// `contour-zigzag-x-0`: what a slicer does unasked, outlines and then parallel lines to and
    /// fro.
    pub const CONVENTIONAL: Self = Self(24);

    /// The pattern of a number; `None` from [`Pattern::COUNT`] on.
    pub fn from_number(number: usize) -> Option<Self> {
        Self::ALL.get(number).copied()
    }

    /// Its number, below [`Pattern::COUNT`].
    /// It never changes: records and learned models hold it.
    pub fn number(self) -> usize {
        usize::from(self.0)
    }

    /// Its name in configurations and on the command line.
    pub fn name(self) -> &'static str {
        self.spec().name
    }

    /// Every cell of the region once, in the order of deposition; the first and the last of them
    /// are where a layer starts and ends.
    ///
    /// Linear in the plane's cells; times the logarithm of their number for the outlines.
    pub fn order(self, region: &Region) -> Vec<Cell> {
        let spec = self.spec();
        let view = View::new(region, spec.transposed, spec.corner);
        let mut order = Vec::with_capacity(region.cell_count() as usize);
        let mut taken = Vec::new();
        if spec.contour {
            order = outlines(region, &view);
            taken = vec![false; region.grid_len()];
            order.iter().for_each(|&cell| taken[cell as usize] = true);
        }
        sweep(spec.sweep, view.width, view.height, |u, v| {
            let cell = view.cell(u, v);
            if region.contains(cell) && (taken.is_empty() || !taken[cell as usize]) {
                order.push(cell);
            }
        });
        if spec.sweep == Sweep::SpiralOut {
            order.reverse();
        }
        order
    }

    fn spec(self) -> &'static Spec {
        const { &SPECS }
            .get(self.number())
            .expect("numbers are made by ALL alone, one for each specification")
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Pattern {
    type Err = UnknownPattern;

    fn from_str(name: &str) -> Result<Self, UnknownPattern> {
        Self::ALL
            .into_iter()
            .find(|pattern| pattern.name() == name)
            .ok_or_else(|| UnknownPattern(name.to_owned()))
    }
}
