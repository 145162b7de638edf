//! One attempt's second half: from the cheapest 2-matching to paths.
//!
//! The cheapest 2-matching has the right number of links, but some of them may form cycles, and
//! cells that a cover has to connect may be unconnected.
//! The steps below change it until only paths are left, each step at the lowest cost it can:
//!
//! 1. [`connect`]: insert links between groups of zones that no link connects.
//! 2. [`merge`]: join cycles by switches of unit cells, at no cost.
//! 3. [`join_by_exchanges`]: join the remaining cycles by longer exchanges of links, at no cost.
//! 4. Pay for one more link between strands that are still unjoined, and repeat 2 and 3; up to
//!    [`MAX_LINKS_PAID`] times.
//! 5. [`merge_at_any_cost`]: join what is left by switches that may cost something.
//!
//! A 2-matching of n cells with n - p links consists of exactly p paths and any number of cycles: a
//! path has one link less than cells, a cycle has as many.
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
use crate::matching::{Matching, Node, Paths, ZoneGraph};

/// Maximum number of exchanges made in one go to join the last cycles.
const MAX_EXCHANGES: u64 = 100;

/// Maximum number of links that one attempt pays for because cycles could not be joined at no cost.
const MAX_LINKS_PAID: u32 = 5;

/// The state that the completion of a 2-matching needs.
pub(super) struct Completion<'s> {
    /// Groups of cells that a cover has to connect, and the links between them.
    pub(super) graph: &'s ZoneGraph,
    /// Two cells that must not be the ends of one path, if there are any.
    pub(super) separate_ends: Option<[Node; 2]>,
    /// The completion gives up when the cost reaches this limit.
    pub(super) cost_limit: u64,
    pub(super) paths: &'s mut Paths,
    pub(super) rng: &'s mut Xoshiro256PlusPlus,
    pub(super) control: &'s Control<'s>,
    pub(super) stages: Option<&'s StageObserver<'s>>,
}

impl Completion<'_> {
    /// Changes a 2-matching until it has no cycles, as far as possible, and numbers its strands.
    ///
    /// Returns `None` if the cost reaches the limit.
    /// If interrupted, goes straight to the last step.
    pub(super) fn run(self, matching: &mut Matching<'_>) -> Option<Strands> {
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
    matching: &Matching<'_>,
) {
    let Some(stages) = stages else { return };
    let board = matching.board;
    let links_from = |&node: &Node| {
        // Right and below only, so that each link is listed once.
        let linked = (0..2).filter(move |&dir| matching.is_linked(node, dir));
        linked.map(move |dir| [node, board.step(node, dir)].map(|node| board.cell(node)))
    };
    stages(stage, &board.cells.iter().flat_map(links_from).collect::<Vec<[Cell; 2]>>());
}
