//! Plans of a whole part: what the layers decide together.
//!
//! A layer of several materials is printed tool by tool, and the tool that ends one layer may begin the next. [`order()`]
//! finds the cheapest order of the tools over all layers of a part, exactly, with a bound that no other way of printing beats;
//! [`fixed_order_cost`] tells what printing every layer in the same rising order costs beside it.
//!
//! # Example
//! ```
//! use beadwork_search::plan::{Constraints, ToolCosts, fixed_order_cost, order};
//!
//! // Four layers of the same two tools: begin each layer with the tool that ended the one before.
//! let layers = vec![vec![0, 1]; 4];
//! let costs = ToolCosts::uniform(2);
//! let best = order(&layers, &costs, &Constraints::default())?;
//! assert_eq!(best.orders, [[0, 1], [1, 0], [0, 1], [1, 0]]);
//! assert_eq!((best.changes, best.least_changes), (4, 4));
//! assert_eq!(fixed_order_cost(&layers, &costs)?.changes, 7);
//! # Ok::<(), beadwork_search::plan::OrderError>(())
//! ```

mod arrange;
mod choice;
mod cover;
mod order;
mod sequence;
mod stack;
mod tool_costs;
mod tools;

pub use cover::LayerRef;
pub use order::{Constraints, FixedOrder, OrderError, ToolOrder, fixed_order_cost, order};
pub use stack::kept_links;
pub use tool_costs::{ToolCosts, ToolCostsError};
pub use tools::{
    FrontierPoint, LayerPlan, Mode, PlanError, Progress, Settings, Stacking, ToolPlan, tools_plan,
};
