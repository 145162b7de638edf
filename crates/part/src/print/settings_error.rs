//! Errors of settings and layers that cannot be printed.

use beadwork_gcode::Feature;
use thiserror::Error;

/// Settings or layers that cannot be printed.
/// Fields are named as in a profile: `tools[1].nozzle_c`, for example.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SettingsError {
    /// A number is not finite, too small or too large.
    #[error("{field} is {value}: it must be {expected}")]
    Value {
        /// Name of the field.
        field: String,
        /// Its value.
        value: f64,
        /// The allowed range.
        expected: &'static str,
    },
    /// A speed of the toolhead exceeds the printer's maximum.
    #[error("{field} is {value}: printer.max_speed_mm_s is {max_speed_mm_s}")]
    TooFast {
        /// Name of the field.
        field: &'static str,
        /// Its value in mm/s.
        value: f64,
        /// The maximum speed in mm/s.
        max_speed_mm_s: f64,
    },
    /// A bead with an oval cross-section is higher than wide.
    #[error(
        "process.cross_section is oval: layer height {layer_mm} mm exceeds bead width {cell_mm} mm"
    )]
    HighBead {
        /// Height of a layer in mm.
        layer_mm: f64,
        /// Width of a bead in mm.
        cell_mm: f64,
    },
    /// The purge matrix does not have one row and one column for each tool.
    #[error(
        "purge.volume_mm3 has a row or column of {got} values: expected {tools}, one for each tool"
    )]
    PurgeSize {
        /// Number of tools.
        tools: usize,
        /// Number of rows, or of values in the first row of another length.
        got: usize,
    },
    /// The grid of the part reaches beyond the bed.
    #[error(
        "the part reaches from ({left_mm}, {front_mm}) to ({right_mm}, {back_mm}) mm, \
         beyond the bed"
    )]
    PartOutside {
        /// Minimum x in mm.
        left_mm: f64,
        /// Minimum y in mm.
        front_mm: f64,
        /// Maximum x in mm.
        right_mm: f64,
        /// Maximum y in mm.
        back_mm: f64,
    },
    /// The part is too high for the printer.
    #[error("the nozzle would rise to {top_mm} mm: printer.bed_mm allows {limit_mm}")]
    TooHigh {
        /// Maximum z of the print in mm, z-hop included.
        top_mm: f64,
        /// Maximum z of the printer in mm.
        limit_mm: f64,
    },
    /// The prime tower reaches beyond the bed.
    #[error("purge.tower reaches beyond the bed")]
    PrimeTowerOutside,
    /// The prime tower overlaps the grid of the part.
    #[error("purge.tower overlaps the part")]
    PrimeTowerOverlaps,
    /// The prime tower has too little depth for what a layer purges.
    #[error("purge.tower.depth_mm is {depth_mm}: the layer that purges most requires {needed_mm}")]
    PrimeTowerDepth {
        /// Depth of the settings in mm.
        depth_mm: f64,
        /// Required depth in mm.
        needed_mm: f64,
    },
    /// The prime tower is too narrow for its outline and one bead within.
    #[error("purge.tower.width_mm is {width_mm}: it must be at least {needed_mm}")]
    PrimeTowerWidth {
        /// Width of the settings in mm.
        width_mm: f64,
        /// Required width in mm.
        needed_mm: f64,
    },
    /// A zone has no tool.
    #[error("layer {layer}: zone {zone} has no tool: the settings define {tools}")]
    TooFewTools {
        /// Number of the layer.
        layer: usize,
        /// The zone.
        zone: u8,
        /// Number of tools.
        tools: usize,
    },
    /// The region or the path of a layer is for a grid of another size than the frame.
    #[error(
        "layer {layer}: {what} is {} x {} cells, the frame is {} x {}",
        got[0], got[1], expected[0], expected[1]
    )]
    LayerSize {
        /// Number of the layer.
        layer: usize,
        /// `"region"` or `"path"`.
        what: &'static str,
        /// Width and height of the region or the path, in cells.
        got: [u32; 2],
        /// Width and height of the frame, in cells.
        expected: [u32; 2],
    },
    /// The zones or the path of a layer belong to other cells than the region.
    #[error("layer {layer}: {what} and region have different cells")]
    LayerCells {
        /// Number of the layer.
        layer: usize,
        /// `"zones"` or `"path"`.
        what: &'static str,
    },
    /// A bead has a tool without settings.
    #[error("layer {layer}, bead {bead}: unknown tool {tool}: the settings define {tools}")]
    BeadTool {
        /// Number of the layer.
        layer: usize,
        /// Index of the bead in its layer.
        bead: usize,
        /// The tool.
        tool: u8,
        /// Number of tools.
        tools: usize,
    },
    /// A bead prints a feature that does not belong to a part.
    #[error(
        "layer {layer}, bead {bead}: feature is {}: it must be a wall, infill or gap fill",
        feature.name()
    )]
    Feature {
        /// Number of the layer.
        layer: usize,
        /// Index of the bead in its layer.
        bead: usize,
        /// The feature.
        feature: Feature,
    },
    /// The numbers of the layers do not ascend.
    #[error("layer {layer} follows layer {before}: layer numbers must ascend")]
    LayerOrder {
        /// Number of a layer.
        layer: usize,
        /// Number of the layer before it.
        before: usize,
    },
    /// A layer would be printed in the air.
    #[error("layer {layer} has nothing to rest on: the layer below has no cells")]
    Gap {
        /// Number of the layer.
        layer: usize,
    },
    /// A layer has no beads, or only beads that are too short to be printed.
    #[error("layer {layer} has no beads: the layers above would have nothing to rest on")]
    NoBeads {
        /// Number of the layer.
        layer: usize,
    },
    /// The print has no layers.
    #[error("there are no layers to print")]
    NoLayers,
}
