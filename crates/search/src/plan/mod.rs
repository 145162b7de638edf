//! Plans of whole parts: what the layers decide together.
//!
//! [`tools::solve`] plans a part as cells: the beads of every layer and their order, for the
//! minimum sum of tool changes and lifts.
//! [`beads::solve`] plans a part as insets, skeletons and infill.
//!
//! [`order()`] decides only in which order the layers use their tools.
//! A layer of several materials may be printed tool by tool, and the tool that ends one layer may
//! begin the next.
//! The result comes with a lower bound on the cost of every plan, even of those that use a tool
//! several times in a layer; [`fixed_order_cost`] is the cost of printing every layer in the same
//! ascending order, for comparison.
//!
//! # Examples
//! ```
//! use beadwork_base::Control;
//! use beadwork_search::CostMatrix;
//! use beadwork_search::plan::{Constraints, fixed_order_cost, order};
//!
//! // Four layers of the same two tools: begin each layer with the tool that ended the one before.
//! let layers = vec![vec![0, 1]; 4];
//! let costs = CostMatrix::uniform(2);
//! let best = order(&layers, &costs, &Constraints::default(), &Control::default())?;
//! assert_eq!(best.orders, [[0, 1], [1, 0], [0, 1], [1, 0]]);
//! assert_eq!((best.changes, best.min_changes), (4, 4));
//! assert_eq!(fixed_order_cost(&layers, &costs, None)?.changes, 7);
//! # Ok::<(), beadwork_search::plan::OrderError>(())
//! ```
//!
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Layout, LayoutSpec, Region};
//! use beadwork_search::CostMatrix;
//! use beadwork_search::plan::tools::{self, LayerRef, Settings};
//!
//! let region = Region::rectangle(20, 20)?;
//! let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0)?;
//! let layers = [LayerRef { region: &region, zones: &zones }; 3];
//! let settings = Settings { lift_cost: 1.0, ..Settings::default() };
//! let plan = tools::solve(&layers, &CostMatrix::uniform(2), &settings, &Control::default())?;
//! // Each layer is one bead, from one half to the other or back.
//! assert_eq!((plan.tool_changes(), plan.lifts), (3, 0));
//! assert!(plan.layers.iter().all(|layer| layer.is_optimal()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arrange;
pub mod beads;
mod choice;
mod cover;
mod covers;
mod options;
mod order;
mod sequence;
mod stack;
pub mod tools;

pub use order::{Constraints, FixedOrder, OrderError, ToolOrder, fixed_order_cost, order};
pub use stack::kept_links;
