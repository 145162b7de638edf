//! Cheapest simple 2-matchings: paths and cycles through all cells, with as many links as asked and
//! as few crossings as possible.
//!
//! A path through n cells in p pieces is a set of n - p links with at most two at each cell, so the
//! cheapest such set bounds its crossings from below; and its paths and cycles are what
//! [`exact`](crate::exact) joins to one path.

mod board;
mod flow;
mod ladder;
mod paths;
#[cfg(test)]
mod tests;
mod tight;
mod zone_graph;

pub(crate) use board::{Board, Dir, Node, dirs};
pub(crate) use flow::Matching;
pub(crate) use ladder::Grain;
pub(crate) use paths::Paths;
pub(crate) use tight::Classes;
pub(crate) use zone_graph::{Groups, ZoneGraph};
