//! Plans of a whole part: what the layers decide together.
//!
//! [`tools_plan`] plans a part: the beads of every layer and their order, for the least sum of tool
//! changes and lifts.
//! A layer of several materials may be printed tool by tool, and the tool that ends one layer may
//! begin the next: [`order()`] finds the cheapest order of the tools over all layers of a part,
//! exactly, with a bound that no other way of printing beats; [`fixed_order_cost`] tells what
//! printing every layer in the same rising order costs beside it.
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
//!
//! ```
//! use beadwork_grid::{Layout, LayoutSpec, Region};
//! use beadwork_search::plan::{Constraints, LayerRef, Settings, ToolCosts, tools_plan};
//!
//! let region = Region::rectangle(20, 20)?;
//! let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0)?;
//! let layers = [LayerRef { region: &region, zones: &zones }; 3];
//! let (costs, constraints) = (ToolCosts::uniform(2), Constraints::default());
//! let plan = tools_plan(&layers, &Settings { lift_cost: 1, ..Settings::new(&costs, &constraints) })?;
//! // One bead a layer, from one half to the other and back.
//! assert_eq!((plan.tool_changes(), plan.lifts), (3, 0));
//! assert!(plan.layers.iter().all(|layer| layer.is_optimal()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arrange;
mod choice;
mod cover;
mod covers;
mod options;
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
