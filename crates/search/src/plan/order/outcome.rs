//! Results of the search for an order of the tools.

use crate::Stop;

/// The tools of each layer in order, their cost, and what is proven about it.
///
/// Costs are in the unit of the cost matrix; if that rounds costs, they are sums of rounded costs.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ToolOrder {
    /// For each layer its tools in the order of printing, each once; empty for a layer without
    /// tools.
    pub orders: Vec<Vec<u8>>,
    /// The permutation of all used tools that all layers follow, if
    /// [`Constraints::same_order`](super::Constraints::same_order) asks for one.
    pub permutation: Option<Vec<u8>>,
    /// Cost of all tool changes.
    pub cost: f64,
    /// Number of tool changes.
    pub changes: u32,
    /// Proven lower bound on the cost of every plan that uses in each layer each of its tools
    /// **once or more often**, possibly with detours over other tools.
    ///
    /// The plan must begin with [`Constraints::first`](super::Constraints::first), and the first
    /// uses of the tools of a layer must obey [`Constraints::before`](super::Constraints::before).
    /// It need not follow one permutation.
    pub bound: f64,
    /// Proven lower bound on the cost of every plan that uses in each layer each of its tools
    /// **exactly once** and obeys all constraints.
    /// At least [`bound`](Self::bound).
    pub once_bound: f64,
    /// Proven lower bound on the number of changes of the plans that [`bound`](Self::bound) refers
    /// to.
    pub min_changes: u32,
    /// Why the search stopped: [`Stop::Optimal`] if [`is_optimal`](Self::is_optimal).
    pub stop: Stop,
}

impl ToolOrder {
    /// Whether it is proven that no plan that uses each tool of a layer once and obeys the
    /// constraints costs less.
    /// See [`order`](super::order) for when it may be false.
    pub fn is_optimal(&self) -> bool {
        self.cost <= self.once_bound
    }

    /// Maximum amount that a plan that uses tools more than once could save.
    pub fn gap(&self) -> f64 {
        self.cost - self.bound
    }
}

/// Cost of printing the tools of each layer in ascending order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedOrder {
    /// Cost of all tool changes, in the unit of the cost matrix.
    pub cost: f64,
    /// Number of tool changes.
    pub changes: u32,
}
