//! Cheapest 2-matchings: sets of a given number of links, at most two at each cell, with crossings
//! of minimum cost.
//!
//! # Why
//! A path through n cells in p pieces has n - p links, at most two at each cell.
//! So the cost of the cheapest 2-matching with n - p links is a lower bound on the cost of the
//! path's crossings, and its paths and cycles are what [`exact`](crate::exact) joins to one path.
//!
//! # Minimum-cost flow
//! Colour the cells like a chessboard: every link joins a black cell and a white one.
//! So a 2-matching is a flow in this network, where each link carries one unit (a cell at which the
//! path has to begin or end has capacity 1 instead of 2):
//!
//! ```text
//!           capacity 2          capacity 1          capacity 2
//!           cost 0              cost of the link    cost 0
//!   source ------------> black -----------------> white ------------> sink
//! ```
//!
//! The number of links is the value of the flow.
//! The changes that a flow allows form its *residual graph*, with an arc for every change by one
//! unit:
//!
//! | arc | exists if | meaning | cost |
//! |---|---|---|---|
//! | black to white | they are not linked | insert the link | that of the link |
//! | white to black | they are linked | remove the link | minus that of the link |
//! | source to black | the cell has room for a link | the cell gets one link more | 0 |
//! | black to source | the cell has a link | the cell gets one link less | 0 |
//! | white to sink | the cell has room for a link | the cell gets one link more | 0 |
//! | sink to white | the cell has a link | the cell gets one link less | 0 |
//!
//! A path from source to sink is an *augmenting path*: it inserts and removes links alternately,
//! and leaves one link more.
//! A cycle is an *exchange*: it keeps the number of links.
//! A flow is the cheapest of its value exactly if its residual graph has no cycle of negative cost.
//!
//! # Potentials
//! A **potential** for each node proves that there is no such cycle.
//! The *reduced cost* of an arc from u to v is cost + potential(u) - potential(v).
//! Around a cycle the potentials cancel, so the reduced costs sum to the cost.
//! If no arc has a negative reduced cost, no cycle has a negative cost, and the flow is optimal.
//! Such potentials are a *dual certificate*: a proof that the flow is optimal.
//! They also allow shortest paths to be found by Dijkstra's method, which needs costs that are not
//! negative.
//!
//! # Files
//! - `board.rs`: one component of a region as a padded grid, the graph that all of this works on.
//! - `ladders.rs`: the links inside the zones that the search starts from.
//! - `two_matching.rs`: the links and the potentials.
//! - `grow.rs`: augmenting paths, up to the required number of links.
//! - `shortest_paths.rs`: cheapest exchanges that insert a link, reserve an end or restore an
//!   optimum.
//! - `tight.rs`: which links occur in some cheapest 2-matching.
//! - `component_graph.rs`: groups of cells that some links connect, and the links between them.

mod board;
mod bucket_queue;
mod component_graph;
mod grow;
mod ladders;
mod shortest_paths;
#[cfg(test)]
mod tests;
mod tight;
mod two_matching;

pub(crate) use board::{Board, Dir, Node, dirs, opposite};
pub(crate) use component_graph::{ComponentGraph, Groups};
pub(crate) use ladders::LadderLayout;
pub(crate) use shortest_paths::ShortestPaths;
pub(crate) use tight::TightClasses;
pub(crate) use two_matching::TwoMatching;
