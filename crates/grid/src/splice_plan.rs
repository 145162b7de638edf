//! The plan of a change of a path, with buffers that are reused.

use crate::{Cell, Sides};

/// A link between a cell and its right or lower neighbour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) cell: Cell,
    /// `Horizontal`: to the right neighbour; `Vertical`: to the neighbour below.
    pub(crate) along: Sides,
    /// Whether the path has the link before the change.
    pub(crate) present: bool,
}

/// The effect of several switches on a path, computed as [`splice`](crate::splice) explains.
///
/// Each path owns a plan, so that the buffers are allocated only once.
#[derive(Clone, Debug, Default)]
pub(crate) struct SplicePlan {
    /// The links that change: those that are present are removed, the others added.
    pub(crate) changed: Vec<Link>,
    /// Positions before the removed links, ascending.
    /// Run `r` holds the positions `cuts[r - 1] + 1 ..= cuts[r]`.
    pub(crate) cuts: Vec<u32>,
    /// For each end of a run, the end to which an added link joins it.
    /// End `2 * r` is the first cell of run `r`, end `2 * r + 1` its last cell.
    pub(crate) joined: Vec<u32>,
    /// The runs between the first and the last cut, in the order in which the new path visits them.
    pub(crate) runs: Vec<Run>,
    /// A copy of the part of the order that is rewritten, from before the change.
    pub(crate) old: Vec<Cell>,
}

/// A run of cells whose order on the path does not change, except that it may be reversed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Run {
    /// First and last position on the path before the change.
    pub(crate) first: u32,
    pub(crate) last: u32,
    /// Whether the new path passes the run from its last to its first cell.
    pub(crate) backwards: bool,
}
