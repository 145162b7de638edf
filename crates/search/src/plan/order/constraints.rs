//! What an order of the tools must obey, and why there may be none.

use thiserror::Error;

/// What an order of the tools must obey.
///
/// Construct it with `..Constraints::default()`: fields may be added.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Constraints {
    /// Pairs of tools: in each layer that uses both, the first of the pair comes before the second.
    pub before: Vec<(u8, u8)>,
    /// The tool with which the first layer that uses any begins.
    pub first: Option<u8>,
    /// The tool that is in the nozzle before the print.
    /// The change from it to the first tool of the print costs as usual and counts as a change.
    pub loaded: Option<u8>,
    /// Whether all layers must follow one permutation of the tools, each leaving out the tools that
    /// it does not use.
    pub same_order: bool,
}

/// Reason why no order of the tools is possible.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum OrderError {
    /// A layer or a constraint uses a tool that has no costs.
    #[error("tool {tool} does not exist: costs are given for {tools} tools")]
    UnknownTool {
        /// The tool.
        tool: u8,
        /// Number of tools that have costs.
        tools: usize,
    },
    /// The pairs of [`Constraints::before`] form a cycle, even if no layer uses all of its tools.
    #[error("tool {a} must come before tool {b}, which must come before tool {a}")]
    Cycle {
        /// A tool of the cycle.
        a: u8,
        /// The next tool of the cycle.
        b: u8,
    },
    /// The first layer with tools does not use the tool with which it must begin.
    #[error("tool {first} cannot come first: the first layer does not use it")]
    FirstMissing {
        /// The tool.
        first: u8,
    },
    /// The first layer must begin with this tool, but another one of its tools must come before it.
    #[error("tool {first} cannot come first: tool {other} must come before it")]
    FirstContradicted {
        /// The tool.
        first: u8,
        /// The other tool.
        other: u8,
    },
    /// No order of the tools of the layers up to this one avoids the forbidden changes.
    #[error("layer {layer}: no order of the tools up to this layer avoids the forbidden changes")]
    Forbidden {
        /// Number of the first such layer, from 0.
        layer: usize,
    },
    /// No order of the many tools of a layer was found that avoids the forbidden changes; there may
    /// be one.
    #[error("layer {layer}: no order of its tools was found that avoids the forbidden changes")]
    NotFound {
        /// Number of the first such layer, from 0.
        layer: usize,
    },
    /// No permutation of all tools was found that avoids the forbidden changes.
    #[error("no order of the tools was found that all layers can follow without forbidden changes")]
    NoPermutation,
}
