//! Settings of slicing, and its errors.

use beadwork_base::Interrupted;
use beadwork_grid::{Region, Zones};
use thiserror::Error;

use super::outline::FillRule;

/// How a model is sliced.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Side of a cell in mm, which is the width of a bead.
    /// More than 0.
    pub cell_mm: f64,
    /// Height of a layer in mm.
    /// More than 0.
    pub layer_mm: f64,
    /// Phase of the cell grid: fractions of a cell, from 0 to below 1, by which the grid is shifted
    /// along x and y relative to the part.
    ///
    /// At `[0.0, 0.0]` the part lies centred in the smallest grid that holds it.
    /// Other phases move the cell centres, and so change which cells the part has along slanted and
    /// round surfaces: the number of beads that a round part needs depends on it.
    /// The grid may gain or lose one column or row.
    pub phase: [f64; 2],
    /// Which points count as inside a body whose surface intersects itself.
    pub fill_rule: FillRule,
    /// Depth in mm to which the colours of top and bottom faces reach into painted bodies; 0 for
    /// not at all.
    ///
    /// Slicers call it the thickness of the top and bottom shells.
    pub colour_depth_mm: f64,
    /// Maximum number of cells in the grids of all layers together; a cell takes two bytes.
    /// A layer counts as at least 64 cells.
    pub max_cells: u64,
}

impl Default for Settings {
    /// Beads of 0.5 mm in layers of 0.25 mm (*Kim et al. 2026*, section on the domain), phase 0,
    /// colours 1 mm deep, at most 2^30 cells.
    fn default() -> Self {
        Self {
            cell_mm: 0.5,
            layer_mm: 0.25,
            phase: [0.0; 2],
            fill_rule: FillRule::default(),
            colour_depth_mm: 1.0,
            max_cells: 1 << 30,
        }
    }
}

/// Why a model could not be sliced.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SliceError {
    /// A length is not positive and finite.
    #[error("{what} is {value} mm: it must be more than 0")]
    Length {
        /// Name of the length.
        what: &'static str,
        /// Its value in mm.
        value: f64,
    },
    /// The depth of colours is negative or not a number.
    #[error("the colour depth is {0} mm: it must be at least 0")]
    ColourDepth(f64),
    /// The phase of the grid is not from 0 to below 1.
    #[error("the grid phase along {axis} is {value}: it must be at least 0 and below 1")]
    Phase {
        /// `"x"` or `"y"`.
        axis: &'static str,
        /// Its value, in cells.
        value: f64,
    },
    /// The settings have another layer height than the cut.
    #[error("the layer height is {got_mm} mm, but the model was cut at {cut_mm} mm")]
    LayerHeight {
        /// Layer height of the [`Cut`](super::Cut), in mm.
        cut_mm: f64,
        /// Layer height of the settings, in mm.
        got_mm: f64,
    },
    /// A side of the grid would have too many cells.
    #[error(
        "beads of {cell_mm} mm make a layer of {width:.0} x {height:.0} cells: \
         the maximum is {max} a side",
        max = Region::MAX_SIDE
    )]
    Side {
        /// Width of a bead in mm.
        cell_mm: f64,
        /// Cells along x.
        width: f64,
        /// Cells along y.
        height: f64,
    },
    /// The layers would have too many cells in total.
    #[error("{layers:.0} layers of {width} x {height} cells are more than {max} cells")]
    Cells {
        /// Number of layers.
        layers: f64,
        /// Cells along x.
        width: u32,
        /// Cells along y.
        height: u32,
        /// [`Settings::max_cells`].
        max: u64,
    },
    /// A body has no material, or one whose number is too large.
    #[error("body {0} has no material, or one numbered beyond {max}", max = Zones::MAX - 1)]
    Material(usize),
    /// No layer has a cell: the part is smaller than a bead.
    #[error(
        "no layer has a cell: the part is thinner than {cell_mm} mm or lower than {layer_mm} mm{}",
        if *.has_negative { ", or negative bodies remove all of it" } else { "" }
    )]
    NoCells {
        /// Width of a bead in mm.
        cell_mm: f64,
        /// Height of a layer in mm.
        layer_mm: f64,
        /// Whether the model has negative bodies.
        has_negative: bool,
    },
    /// The call was cancelled or ran out of time.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
