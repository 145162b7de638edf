//! The second half of an attempt: from the cheapest 2-matching to paths.
//!
//! The cheapest 2-matching has the right number of links, but some of them form cycles.
//! The steps below join these to other strands, at no cost where possible:
//!
//! 1. [`connect`]: insert links between groups of zones that no link connects.
//! 2. [`merge`]: join cycles by switches of unit cells, at no cost.
//! 3. [`join_by_exchanges`]: join the remaining cycles by longer exchanges of links, at no cost.
//! 4. [`insert_cheapest`]: insert a link from a remaining cycle to another strand, at a cost, and
//!    repeat 2 and 3; up to [`MAX_LINKS_PAID`] times.
//! 5. [`merge_at_any_cost`]: join what is left by switches that may cost something.
//!
//! A 2-matching of n cells with n - p links consists of exactly p paths and any number of cycles: a
//! path has one link fewer than cells, a cycle has the same number of both.
//! All steps keep the number of links, so once no cycle is left, the paths are a cover with p
//! pieces.
//! A cycle that is still left is cut open and costs one more piece.

use beadwork_base::Control;
use beadwork_grid::Cell;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::connect::{connect, insert_cheapest};
use super::exchange::join_by_exchanges;
use super::merge::{merge, merge_at_any_cost};
use super::settings::{Stage, StageObserver};
use super::strands::Strands;
use crate::matching::{ComponentGraph, Node, ShortestPaths, TwoMatching};

/// Maximum number of searches for exchanges in step 3.
const MAX_EXCHANGES: u64 = 100;

/// Maximum number of links inserted in step 4.
const MAX_LINKS_PAID: u32 = 5;

/// The state that the completion of a 2-matching needs.
pub(super) struct Completion<'s> {
    /// Groups of cells that a cover has to connect, and the links between them.
    pub(super) graph: &'s ComponentGraph,
    /// Two cells that must not be the ends of one path, if there are any.
    pub(super) separate_ends: Option<[Node; 2]>,
    /// The completion gives up when the cost reaches this limit.
    pub(super) cost_limit: u64,
    pub(super) paths: &'s mut ShortestPaths,
    pub(super) rng: &'s mut Xoshiro256PlusPlus,
    pub(super) control: &'s Control<'s>,
    pub(super) stages: Option<&'s StageObserver<'s>>,
}

impl Completion<'_> {
    /// Changes a 2-matching until it has no cycles, as far as possible, and numbers its strands.
    ///
    /// Returns `None` if the cost reaches the limit.
    /// An interruption ends steps 1, 3 and 4 early.
    pub(super) fn run(self, matching: &mut TwoMatching<'_>) -> Option<Strands> {
        let Self { graph, separate_ends, cost_limit, paths, rng, control, stages } = self;
        show_stage(stages, Stage::Cheapest, matching);
        connect(matching, graph, paths, rng, control);
        if matching.cost() as u64 >= cost_limit {
            return None;
        }
        show_stage(stages, Stage::Linked, matching);
        merge(matching);
        show_stage(stages, Stage::Merged, matching);
        let mut strands = Strands::new(matching, separate_ends);
        join_by_exchanges(matching, &mut strands, rng, MAX_EXCHANGES, control);
        for _ in 0..MAX_LINKS_PAID {
            if strands.is_settled() || control.interrupted().is_some() {
                break;
            }
            let links = strands.links_to_settle(matching);
            if !insert_cheapest(matching, &links, paths, rng) {
                break;
            }
            if matching.cost() as u64 >= cost_limit {
                return None;
            }
            merge(matching);
            strands = Strands::new(matching, separate_ends);
            join_by_exchanges(matching, &mut strands, rng, MAX_EXCHANGES, control);
        }
        if strands.cycles > 0 {
            merge_at_any_cost(matching);
            strands = Strands::new(matching, separate_ends);
        }
        show_stage(stages, Stage::Settled, matching);
        Some(strands)
    }
}

/// Passes the links of a 2-matching to a stage observer, if there is one.
pub(super) fn show_stage(
    stages: Option<&StageObserver<'_>>,
    stage: Stage,
    matching: &TwoMatching<'_>,
) {
    let Some(stages) = stages else { return };
    let board = matching.board;
    let links_from = |&node: &Node| {
        // Right and below only, so that each link is listed once.
        let linked = (0..2).filter(move |&dir| matching.is_linked(node, dir));
        linked.map(move |dir| [node, board.neighbour(node, dir)].map(|node| board.cell(node)))
    };
    stages(stage, &board.cells.iter().flat_map(links_from).collect::<Vec<[Cell; 2]>>());
}
