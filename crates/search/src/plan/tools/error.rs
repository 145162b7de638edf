//! Errors of planning a part.

use beadwork_base::Interrupted;
use thiserror::Error;

use super::settings::Mode;
use crate::exact::SolveError;
use crate::plan::OrderError;

/// Reason why a part cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlanError {
    /// The part has no layers.
    #[error("no layers to plan")]
    NoLayers,
    /// The grid of a layer differs in size from the first layer's grid.
    #[error(
        "layer {layer}: grid is {} x {} cells, the first layer's is {} x {}",
        .got[0], .got[1], .expected[0], .expected[1]
    )]
    GridSize {
        /// Number of the layer, from 0.
        layer: usize,
        /// Width and height of the first layer's grid.
        expected: [u32; 2],
        /// Width and height of this layer's grid.
        got: [u32; 2],
    },
    /// A layer cannot be covered.
    #[error("layer {layer}: {source}")]
    Layer {
        /// Number of the layer, from 0.
        layer: usize,
        /// The reason.
        source: SolveError,
    },
    /// No order of the tools is possible.
    #[error(transparent)]
    Order(#[from] OrderError),
    /// Continuous paths cannot obey a constraint on the order of the tools.
    #[error(
        "mode continuous: tools follow the paths, so no order can be imposed on them; \
         use mode cheapest or free"
    )]
    Constraint,
    /// Continuous paths cannot avoid forbidden changes.
    #[error(
        "mode {mode}: change from tool {from} to tool {to} is forbidden; only mode free can \
         avoid changes"
    )]
    Forbidden {
        /// The mode.
        mode: Mode,
        /// The tool before the change.
        from: u8,
        /// The tool after the change.
        to: u8,
    },
    /// No plan begins with the required tool.
    #[error("tool {first}: no path of the first layer begins with it")]
    First {
        /// The tool.
        first: u8,
    },
    /// The cost of a lift is not a finite nonnegative number.
    #[error("lift cost {0}: expected a finite nonnegative number")]
    LiftCost(f64),
    /// The call was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
