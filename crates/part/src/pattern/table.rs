//! The 38 patterns: their names, numbers and orders.

use std::fmt;
use std::str::FromStr;

use beadwork_grid::{Cell, Region};
use thiserror::Error;

use super::outline::outlines;
use super::sweep::Sweep;
use super::view::View;

/// One of the 38 orders in which the cells of a layer may be deposited.
///
/// A pattern orders all cells of a grid; a region takes its own cells in that order, so consecutive
/// cells need not be neighbours.
/// A name consists of the family, the axis along which lines run where there is a choice, and the
/// **corner** where the order begins: 0 has minimum x and y, 1 maximum x and minimum y, 2 minimum x
/// and maximum y, 3 maximum x and y.
///
/// | Numbers | Names | Order |
/// |---|---|---|
/// | 0..=7 | `zigzag-x-0` .. `zigzag-y-3` | adjacent lines along the axis, alternating in direction |
/// | 8..=15 | `raster-x-0` .. `raster-y-3` | the same lines, all in one direction |
/// | 16..=19 | `spiral-in-0` .. `spiral-in-3` | rings from the outside inwards, beginning along the row of the corner |
/// | 20..=23 | `spiral-out-0` .. `spiral-out-3` | the reverse, which ends in the corner |
/// | 24..=31 | `contour-zigzag-x-0` .. `contour-zigzag-y-3` | outlines first, then the rest as a zigzag |
/// | 32..=35 | `contour-raster-x-0`, `-x-3`, `-y-0`, `-y-3` | outlines first, then the rest as a raster |
/// | 36, 37 | `diagonal-0`, `diagonal-1` | diagonals from corner 0 or 1, alternating in direction |
///
/// The orders from other corners are mirror images of those from corner 0, and the orders along y
/// are transpositions of those along x, outlines included.
/// So `spiral-in` turns clockwise (with y down) from corners 0 and 3, and counter-clockwise from
/// corners 1 and 2; `spiral-out`, its reverse, turns the other way.
/// A diagonal pattern begins its second diagonal in row 0.
///
/// # Outlines
/// The contour patterns begin with the cells that have one of their **eight** neighbours outside
/// the region or the grid.
/// With eight, each outline is a closed walk in unit steps; with four neighbours it would have a
/// diagonal step at each inner corner of the region.
/// Components of the region that touch only at a corner have one outline each; holes that touch at
/// a corner share an outline.
///
/// An outline begins at its cell with the smallest Euclidean distance from the corner; if several
/// are equally distant, at the one in the line closest to the corner.
/// Around a component, its first step goes across the axis: a step along the axis would make a
/// contour zigzag equal to the spiral on many rectangles.
/// So the outline of a rectangle ends next to line 1, the first line of the rest; contour zigzags
/// run odd lines forwards, so that line 1 begins there, on the side of the corner.
/// The outline of a hole runs in the opposite sense, with the region on the same side.
///
/// Outlines are sorted by the distance of their first cell from the corner, so an outer outline
/// comes before the outlines within.
/// A cell that two outlines share, or that one outline visits twice, as in walls one or two cells
/// wide, is deposited at its first visit.
///
/// # Example
/// ```
/// use beadwork_grid::Region;
/// use beadwork_part::Pattern;
///
/// let region = Region::rectangle(4, 3)?;
/// let zigzag: Pattern = "zigzag-x-1".parse()?;
/// assert_eq!(zigzag.order(&region), [3, 2, 1, 0, 4, 5, 6, 7, 11, 10, 9, 8]);
/// let conventional = Pattern::CONVENTIONAL;
/// assert_eq!(conventional.order(&region), [0, 4, 8, 9, 10, 11, 7, 3, 2, 1, 5, 6]);
/// assert_eq!(conventional.to_string(), "contour-zigzag-x-0");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pattern(u8);

/// The error of parsing a name that no [`Pattern`] has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "unknown pattern '{0}': expected a name like zigzag-x-0, raster-y-3, spiral-in-1, \
     spiral-out-2, contour-zigzag-x-0, contour-raster-y-3 or diagonal-1"
)]
pub struct UnknownPattern(pub String);

/// Definition of a pattern.
struct Spec {
    name: &'static str,
    /// Whether the outlines come first.
    has_contour: bool,
    sweep: Sweep,
    /// Whether the lines run along y.
    is_transposed: bool,
    corner: u8,
}

const X: bool = false;
const Y: bool = true;

const fn spec(name: &'static str, sweep: Sweep, is_transposed: bool, corner: u8) -> Spec {
    Spec { name, has_contour: false, sweep, is_transposed, corner }
}

const fn contour(name: &'static str, sweep: Sweep, is_transposed: bool, corner: u8) -> Spec {
    Spec { name, has_contour: true, sweep, is_transposed, corner }
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
    /// Number of patterns.
    pub const COUNT: usize = 38;

    /// All patterns, in the order of their numbers.
    pub const ALL: [Self; Self::COUNT] = {
        let mut all = [Self(0); Self::COUNT];
        let mut number = 0;
        while number < Self::COUNT {
            all[number] = Self(number as u8);
            number += 1;
        }
        all
    };

    /// `contour-zigzag-x-0`: the usual order of a slicer, outlines and then parallel lines back and
    /// forth.
    pub const CONVENTIONAL: Self = Self(24);

    /// The pattern with this number; `None` if it is not below [`Pattern::COUNT`].
    pub fn from_number(number: usize) -> Option<Self> {
        Self::ALL.get(number).copied()
    }

    /// Number of the pattern, below [`Pattern::COUNT`].
    /// Numbers never change, because datasets and trained models contain them.
    pub fn number(self) -> usize {
        usize::from(self.0)
    }

    /// Name in configuration files and on the command line.
    pub fn name(self) -> &'static str {
        self.spec().name
    }

    /// Returns every cell of the region once, in the order of deposition.
    ///
    /// Takes O(n) for a grid of n cells; O(n log n) with outlines.
    pub fn order(self, region: &Region) -> Vec<Cell> {
        let spec = self.spec();
        let view = View::new(region, spec.is_transposed, spec.corner);
        let mut order = Vec::with_capacity(region.cell_count() as usize);
        let mut is_taken = Vec::new();
        if spec.has_contour {
            order = outlines(region, &view);
            is_taken = vec![false; region.grid_len()];
            order.iter().for_each(|&cell| is_taken[cell as usize] = true);
        }
        spec.sweep.for_each(view.width, view.height, |u, v| {
            let cell = view.cell(u, v);
            if region.contains(cell) && (is_taken.is_empty() || !is_taken[cell as usize]) {
                order.push(cell);
            }
        });
        if spec.sweep == Sweep::SpiralOut {
            order.reverse();
        }
        order
    }

    fn spec(self) -> &'static Spec {
        const { &SPECS }.get(self.number()).expect("a pattern has the number of a specification")
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
