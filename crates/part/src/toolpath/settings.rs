//! Settings of toolpaths, and their errors.

use beadwork_base::{Interrupted, named_enum};
use thiserror::Error;

/// The pattern of infill lines.
///
/// The spacing of lines is such that all patterns extrude the same length at the same density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InfillPattern {
    /// Parallel lines, turned by 90 degrees from layer to layer.
    #[default]
    Lines,
    /// Lines in two directions in every layer.
    Grid,
    /// Lines in three directions that meet in points, which makes triangles.
    Triangles,
    /// A honeycomb, made of zigzag lines.
    Hexagons,
    /// Lines in three directions of which no three meet, which makes triangles and hexagons.
    Hybrid,
    /// Closed lines that follow the border of the region.
    Concentric,
}

named_enum! {
    InfillPattern, "infill pattern":
    Lines = "lines",
    Grid = "grid",
    Triangles = "triangles",
    Hexagons = "hexagons",
    Hybrid = "hybrid",
    Concentric = "concentric",
}

/// How toolpaths are laid out.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width of a bead in mm: beads this far apart fill an area without gaps.
    /// From 0.01 to 100.
    pub bead_mm: f64,
    /// Number of insets along each outline, from 0 to 1,000.
    pub perimeters: u32,
    /// Share of the area inside the insets that sparse infill extrudes, from 0 to 1. At 0 there is
    /// no sparse infill, at 1 all infill is solid.
    ///
    /// In between, sparse pieces smaller than 16 squares of a bead (4 mm² for 0.5 mm) are solid,
    /// and smaller solid pieces within larger regions are sparse.
    pub density: f64,
    /// Pattern of sparse infill; solid infill is lines, or concentric if this is concentric and the
    /// density is 1.
    pub pattern: InfillPattern,
    /// Direction of infill lines in degrees, counter-clockwise from the x axis; finite.
    pub angle_degrees: f64,
    /// By how much infill overlaps the innermost inset: a fraction of the bead, from 0 to 0.5.
    ///
    /// Infill lines that are linked along the border of their region extrude there, too.
    /// At 100 % density and the default of 0.05, the extruded area of parts with curved outlines is
    /// 1.00 to 1.02 times the area of the outlines; at 0.25 it is 1.02 to 1.06 times.
    pub infill_overlap: f64,
    /// Number of layers below each top surface that are solid, including the one at the surface.
    pub top_layers: u32,
    /// Number of layers above each bottom surface that are solid, including the one at the surface.
    pub bottom_layers: u32,
    /// Whether gaps between insets, and between them and infill, get beads of varying width.
    ///
    /// In islands with insets, such beads are at least two beads long and one square bead large.
    pub gap_fill: bool,
    /// Whether walls too thin for the outermost inset get beads of varying width; without it such
    /// walls are not printed.
    pub thin_walls: bool,
}

impl Default for Settings {
    /// Beads of 0.5 mm, two insets, 20 % of lines at 45 degrees with an overlap of 5 % of a bead,
    /// three solid layers at the top and three at the bottom, and beads in gaps and thin walls.
    fn default() -> Self {
        Self {
            bead_mm: 0.5,
            perimeters: 2,
            density: 0.2,
            pattern: InfillPattern::default(),
            angle_degrees: 45.0,
            infill_overlap: 0.05,
            top_layers: 3,
            bottom_layers: 3,
            gap_fill: true,
            thin_walls: true,
        }
    }
}

impl Settings {
    /// Maximum extent of a part along x or y, in beads.
    pub const MAX_BEADS: u32 = 1 << 16;

    /// Returns an error if a value is out of range.
    pub fn check(&self) -> Result<(), ToolpathError> {
        let ranges = [
            ("bead width", self.bead_mm, 0.01, 100.0),
            ("number of perimeters", f64::from(self.perimeters), 0.0, 1e3),
            ("infill density", self.density, 0.0, 1.0),
            ("infill angle", self.angle_degrees, -1e6, 1e6),
            ("infill overlap", self.infill_overlap, 0.0, 0.5),
        ];
        for (what, value, min, max) in ranges {
            if !(min..=max).contains(&value) {
                return Err(ToolpathError::Range { what, value, min, max });
            }
        }
        Ok(())
    }

    /// Distance in mm from one line of sparse infill to the next if they had one direction; `None`
    /// at a density of 0.
    pub fn spacing_mm(&self) -> Option<f64> {
        (self.density > 0.0).then(|| self.bead_mm / self.density)
    }
}

/// Reason why toolpaths cannot be laid out.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ToolpathError {
    /// A setting is out of range or not a number.
    #[error("{what} is {value}: it must be from {min} to {max}")]
    Range {
        /// Name of the setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The minimum.
        min: f64,
        /// The maximum.
        max: f64,
    },
    /// The part is too large for its beads.
    #[error(
        "layer {layer} is {side_mm} mm long, more than {} beads of {bead_mm} mm: \
         the bead width may be in another unit than the part",
        Settings::MAX_BEADS
    )]
    Size {
        /// Number of the layer, from 0.
        layer: usize,
        /// Its extent along x or y in mm.
        side_mm: f64,
        /// Width of a bead in mm.
        bead_mm: f64,
    },
    /// The call was cancelled or ran out of time.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
