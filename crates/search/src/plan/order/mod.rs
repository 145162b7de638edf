//! The cheapest order of the tools over the layers of a part.
//!
//! Within a layer that is a shortest Hamiltonian path over its tools, found for each pair of ends
//! by the dynamic programme of Held and Karp, "A dynamic programming approach to sequencing
//! problems" (J. SIAM 10, 1962); over the layers, a shortest way through their ends.
//! See `within.rs` and `free.rs`; `shared.rs` finds one order for all layers.

mod check;
mod free;
mod shared;
#[cfg(test)]
mod tests;
pub(in crate::plan) mod within;

use thiserror::Error;

use self::check::Layers;
use self::free::{Free, free};
use self::shared::shared;
use super::ToolCosts;

/// The most tools of one layer: the work doubles with each.
const MAX_TOOLS: usize = 12;

/// What an order has to obey.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Constraints {
    /// Pairs of tools: in each layer that uses both, the first of the pair comes before the second.
    pub before: Vec<(u8, u8)>,
    /// The tool that the first layer begins with.
    pub first: Option<u8>,
    /// Whether there is to be one permutation of all tools, of which each layer leaves out those it
    /// does not use.
    pub same_order: bool,
}

/// The tools of each layer in order, what they cost, and what can be proven about it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ToolOrder {
    /// For each layer, its tools in the order of printing, each once.
    pub orders: Vec<Vec<u8>>,
    /// The permutation that all layers follow, if one was asked for: of all tools that any layer
    /// uses.
    pub permutation: Option<Vec<u8>>,
    /// Cost of all changes.
    pub cost: u64,
    /// Number of changes.
    pub changes: u32,
    /// No plan costs less that uses in each layer each of its tools, **as often as it likes** and
    /// with detours over any other tools, provided it begins with [`Constraints::first`] and the
    /// first visits to the tools of a layer obey [`Constraints::before`].
    /// It need not keep one permutation.
    pub bound: u64,
    /// No plan costs less that uses in each layer each of its tools **once** and obeys all
    /// constraints.
    /// At least [`bound`](Self::bound).
    pub once_bound: u64,
    /// No plan of those that [`bound`](Self::bound) speaks of has fewer changes.
    pub least_changes: u32,
}

impl ToolOrder {
    /// Whether no plan that uses each tool of a layer once and obeys the constraints costs less.
    /// False only where one permutation was asked for and the search for it ended early: see
    /// [`order`].
    pub fn is_optimal(&self) -> bool {
        self.cost == self.once_bound
    }

    /// What a plan that uses tools more than once could save at most.
    /// 0 where no detour is cheaper than a direct change, unless one permutation was asked for.
    pub fn gap(&self) -> u64 {
        self.cost - self.bound
    }
}

/// What printing the tools of each layer by rising number costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedOrder {
    /// Cost of all changes.
    pub cost: u64,
    /// Number of changes.
    pub changes: u32,
}

/// Why there is no order.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum OrderError {
    /// A layer uses no tool.
    #[error("layer {layer} uses no tool")]
    EmptyLayer {
        /// Its number, from 0.
        layer: usize,
    },
    /// A layer uses more tools than an exact order can be found for.
    #[error("layer {layer} uses {got} tools, more than {max}", max = MAX_TOOLS)]
    TooManyTools {
        /// Its number, from 0.
        layer: usize,
        /// Its number of tools.
        got: usize,
    },
    /// A layer or a constraint names a tool that has no costs.
    #[error("tool {tool} has no costs, which are given for {tools} tools")]
    UnknownTool {
        /// The tool.
        tool: u8,
        /// Number of tools with costs.
        tools: usize,
    },
    /// The pairs of [`Constraints::before`] go round in a circle, even if no layer uses all of its
    /// tools.
    #[error("tool {a} has to come before tool {b}, and tool {b} before tool {a}")]
    Circle {
        /// A tool of the circle.
        a: u8,
        /// The one that comes after it.
        b: u8,
    },
    /// The first layer does not use the tool it has to begin with.
    #[error("tool {first} can't come first: the first layer doesn't use it")]
    FirstMissing {
        /// The tool.
        first: u8,
    },
    /// The tool to begin with has to come after another one of the first layer.
    #[error("tool {first} can't come first: tool {other} has to come before it")]
    FirstContradicted {
        /// The tool.
        first: u8,
        /// The other tool.
        other: u8,
    },
}

/// Finds the cheapest order of the tools, where each layer uses each of its tools once.
///
/// `layers` holds the tools of each layer, at least 1 and at most 12, in any order; doubles count
/// once.
/// A change costs the same within a layer and between two; where a layer begins with the tool that
/// ended the one before, there is none.
///
/// Of equally cheap plans, the answer is the one whose orders come first in the alphabet, layer by
/// layer from the first; with [`Constraints::same_order`], one that is the same every time.
/// It takes O(d 2^k k³ + l k²) steps for l layers of at most k tools with d different sets among
/// them, and as many again for each of the two bounds.
///
/// # One permutation
/// With [`Constraints::same_order`], the number of ways that have to be told apart can grow
/// exponentially with the tools of the part, though not where all layers use the same tools.
/// Beyond a million of them, fewer where layers are of many kinds (so that it stays within some
/// seconds and a few hundred MB), the answer is a good permutation, improved by moving one tool at
/// a time; it obeys all constraints, but [`ToolOrder::is_optimal`] may be false.
/// [`ToolOrder::once_bound`] then is the cost of the best plan without the one permutation.
pub fn order(
    layers: &[Vec<u8>],
    costs: &ToolCosts,
    constraints: &Constraints,
) -> Result<ToolOrder, OrderError> {
    let layers = Layers::new(layers, costs, constraints)?;
    let Free { orders, cost } = free(&layers, costs, constraints);
    let with_detours = costs.with_detours();
    let bound =
        if with_detours == *costs { cost } else { free(&layers, &with_detours, constraints).cost };
    let uniform = ToolCosts::uniform(costs.tools() as u8);
    let least_changes = free(&layers, &uniform, constraints).cost as u32;
    if !constraints.same_order {
        let changes = sum(&orders, costs).changes;
        return Ok(ToolOrder {
            orders,
            permutation: None,
            cost,
            changes,
            bound,
            once_bound: cost,
            least_changes,
        });
    }
    let (permutation, proven) =
        shared(&layers, costs, constraints, &Free { orders, cost }, shared::MOST_LABELS)?;
    let follow =
        |set: &[u8]| permutation.iter().copied().filter(|tool| set.contains(tool)).collect();
    let orders: Vec<Vec<u8>> = layers.iter().map(follow).collect();
    let FixedOrder { cost: shared_cost, changes } = sum(&orders, costs);
    let once_bound = if proven { shared_cost } else { cost };
    let permutation = Some(permutation);
    Ok(ToolOrder {
        orders,
        permutation,
        cost: shared_cost,
        changes,
        bound,
        once_bound,
        least_changes,
    })
}

/// What it costs to print the tools of each layer by rising number, the same in every layer: for
/// comparison.
/// The layers are as for [`order`]; linear in their tools.
pub fn fixed_order_cost(layers: &[Vec<u8>], costs: &ToolCosts) -> Result<FixedOrder, OrderError> {
    let layers = Layers::new(layers, costs, &Constraints::default())?;
    let orders: Vec<Vec<u8>> = layers.iter().map(<[u8]>::to_vec).collect();
    Ok(sum(&orders, costs))
}

/// Cost and changes of a plan.
fn sum(orders: &[Vec<u8>], costs: &ToolCosts) -> FixedOrder {
    let visits: Vec<u8> = orders.concat();
    let cost = visits.windows(2).map(|pair| u64::from(costs.cost(pair[0], pair[1]))).sum();
    let changes = visits.windows(2).filter(|pair| pair[0] != pair[1]).count() as u32;
    FixedOrder { cost, changes }
}
