//! Joining the cycles that switches can't join, by exchanges of several links.
//!
//! An *exchange* inserts and removes links alternately along a cycle of cells, or along a path
//! whose first cell has room, which moves to its last cell.
//! It keeps the number of links.
//! A switch of a unit cell is the shortest kind, with two links inserted and two removed.
//! The next one, around two unit cells, inserts three and removes three:
//!
//! ```text
//!    a---b   c          a   b---c
//!            |   <->    |
//!    d---e   f          d   e---f
//! ```
//!
//! Longer exchanges are needed where cycles do not lie side by side, mostly in steps along slanted
//! borders.
//! Exchanges of up to 12 links are tried.
//! The potentials prove that no arc has a negative reduced cost.
//! So an exchange along a cycle costs nothing only if each of its links has reduced cost 0, and the
//! search drops a partial exchange as soon as its sum is positive.
//! (Locked links are exempt from that proof: with them, single links and sums may also be
//! negative.)
//!
//! Whether an exchange joins strands is computed without walking along them, see `strands.rs`.
//! If no exchange around a cycle reduces the number of strands, a random one of those that keep the
//! number is applied.
//! It changes the shape and position of the cycle.
//! Repeating this is a random walk of the cycle, which ends when an exchange joins it to another
//! strand.

use beadwork_base::Control;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::strands::Strands;
use crate::matching::{Dir, Node, TwoMatching, dirs, opposite};

/// Maximum number of links in an exchange, inserted and removed ones together.
const MAX_LENGTH: usize = 12;

/// Maximum number of exchanges evaluated in one search around a cycle.
const MAX_JUDGED: u32 = 4000;

/// Joins cycles to other strands by exchanges that do not raise the cost.
///
/// A path that has both of the ends that must be separate is treated like a cycle, until they lie
/// on different paths.
/// Ends when nothing is left to settle, after `max_exchanges` searches, or when interrupted.
pub(super) fn join_by_exchanges(
    matching: &mut TwoMatching<'_>,
    strands: &mut Strands,
    rng: &mut Xoshiro256PlusPlus,
    max_exchanges: u64,
    control: &Control<'_>,
) {
    let mut searches = 0;
    let mut failures = 0;
    while !strands.is_settled() && searches < max_exchanges && control.interrupted().is_none() {
        let number = pick_cycle(strands, rng)
            .or(strands.joined_ends())
            .expect("there is a cycle or a path with both ends");
        let cells = strands.cells(matching, number);
        // Short exchanges come first: they are few and usually suffice, whereas the number of
        // exchanges grows exponentially with their length.
        let max_length = match failures {
            0 => 6,
            1..6 => 8,
            _ => 10 + 2 * (failures % 2),
        };
        let mut search = Search {
            matching,
            strands,
            steps: Vec::with_capacity(MAX_LENGTH),
            first: 0,
            first_has_room: false,
            max_length,
            judgements_left: MAX_JUDGED,
            reduced_cost: 0,
            joining: None,
            neutral: Vec::new(),
            neutral_count: 0,
            rng,
        };
        search.search_around(&cells);
        let (joining, neutral) = (search.joining.take(), std::mem::take(&mut search.neutral));
        searches += 1;
        if let Some(steps) = joining {
            strands.apply(matching, &steps);
            failures = 0;
        } else {
            if !neutral.is_empty() {
                strands.apply(matching, &neutral);
            }
            failures += 1;
        }
    }
}

/// Picks one of the shortest cycles: a random number of up to 7 is added to each length.
/// `None` if there are no cycles.
fn pick_cycle(strands: &Strands, rng: &mut Xoshiro256PlusPlus) -> Option<u32> {
    let cycles =
        strands.list.iter().enumerate().filter(|(_, strand)| strand.is_cycle && strand.length > 0);
    let key = |length: u32, random: u64| u64::from(length) + (random >> 61);
    let shortest =
        cycles.map(|(number, strand)| (key(strand.length, rng.next_u64()), number)).min();
    shortest.map(|(_, number)| number as u32)
}

/// A depth-first search for exchanges that begin with a link from a given strand to another one.
struct Search<'s, 'a> {
    matching: &'s TwoMatching<'a>,
    strands: &'s mut Strands,
    /// The exchange so far: links inserted and removed in turn, each named by the first of its two
    /// cells along the exchange.
    steps: Vec<(Node, Dir)>,
    /// The cell at which the exchange begins.
    first: Node,
    first_has_room: bool,
    /// Maximum number of steps.
    max_length: usize,
    /// Number of exchanges that may still be evaluated.
    judgements_left: u32,
    /// Sum of the reduced costs of the steps.
    reduced_cost: i32,
    /// An exchange that reduces the number of strands; ends the search.
    joining: Option<Vec<(Node, Dir)>>,
    /// One of the exchanges that keep the number of strands, drawn at random.
    neutral: Vec<(Node, Dir)>,
    /// Number of these exchanges so far.
    neutral_count: u64,
    rng: &'s mut Xoshiro256PlusPlus,
}

impl Search<'_, '_> {
    /// Searches from all links that lead from the cells of a strand to other strands, starting at a
    /// random cell.
    fn search_around(&mut self, cells: &[Node]) {
        let board = self.matching.board;
        let offset = (self.rng.next_u64() >> 32) as usize % cells.len();
        for index in 0..cells.len() {
            let cell = cells[(index + offset) % cells.len()];
            for dir in dirs(board.neighbours[cell as usize]) {
                let other = board.neighbour(cell, dir);
                if self.strands.strand_of[other as usize] == self.strands.strand_of[cell as usize] {
                    continue;
                }
                for (first, dir) in [(cell, dir), (other, opposite(dir))] {
                    self.search_from(first, dir);
                    if self.is_over() {
                        return;
                    }
                }
            }
        }
    }

    /// Searches for exchanges whose first step inserts the link from a cell in a direction.
    fn search_from(&mut self, first: Node, dir: Dir) {
        self.first = first;
        self.first_has_room = self.matching.has_room(first);
        self.steps.clear();
        self.reduced_cost = 0;
        self.insert(first, dir);
    }

    fn is_over(&self) -> bool {
        self.joining.is_some() || self.judgements_left == 0
    }

    /// Inserts a link and goes on by removing one at its other cell.
    fn insert(&mut self, node: Node, dir: Dir) {
        let reduced = self.matching.reduced_cost(node, dir);
        if self.reduced_cost + reduced > 0 || self.is_used(node, dir) {
            return;
        }
        self.reduced_cost += reduced;
        self.steps.push((node, dir));
        let other = self.matching.board.neighbour(node, dir);
        for dir in dirs(self.matching.links[other as usize]) {
            self.remove(other, dir);
            if self.is_over() {
                break;
            }
        }
        self.steps.pop();
        self.reduced_cost -= reduced;
    }

    /// Removes a link, evaluates the exchange if it is complete, and otherwise goes on by inserting
    /// a link at its other cell.
    fn remove(&mut self, node: Node, dir: Dir) {
        let reduced = -self.matching.reduced_cost(node, dir);
        if self.reduced_cost + reduced > 0 || self.is_used(node, dir) {
            return;
        }
        let board = self.matching.board;
        let lacking = board.neighbour(node, dir);
        self.reduced_cost += reduced;
        self.steps.push((node, dir));
        if lacking == self.first {
            // A cycle: its reduced cost is its cost.
            self.judge();
        } else {
            // A path that moves room from its first cell to its last.
            // Its reduced cost differs from its cost by the potentials of these two.
            if self.first_has_room && self.cost() <= 0 {
                self.judge();
            }
            if self.steps.len() < self.max_length && self.can_return(lacking) {
                let unlinked =
                    board.neighbours[lacking as usize] & !self.matching.links[lacking as usize];
                for dir in dirs(unlinked) {
                    if self.is_over() {
                        break;
                    }
                    self.insert(lacking, dir);
                }
            }
        }
        self.steps.pop();
        self.reduced_cost -= reduced;
    }

    /// Whether the exchange already contains a link.
    fn is_used(&self, node: Node, dir: Dir) -> bool {
        let other = self.matching.board.neighbour(node, dir);
        self.steps.iter().any(|&step| step == (node, dir) || step == (other, opposite(dir)))
    }

    /// Whether enough steps are left to return to the first cell.
    /// Always true if the first cell has room, because the exchange may then be a path.
    fn can_return(&self, node: Node) -> bool {
        let board = self.matching.board;
        let ((ax, ay), (bx, by)) = (board.xy(node), board.xy(self.first));
        self.first_has_room
            || (ax.abs_diff(bx) + ay.abs_diff(by)) as usize <= self.max_length - self.steps.len()
    }

    /// Change of the cost by the exchange.
    fn cost(&self) -> i32 {
        let signed = |(index, &(node, dir)): (usize, &(Node, Dir))| {
            let cost = self.matching.board.link_cost(node, dir);
            if index % 2 == 0 { cost } else { -cost }
        };
        self.steps.iter().enumerate().map(signed).sum()
    }

    /// Evaluates a complete exchange: keeps it if it joins strands.
    /// Of the neutral ones it keeps one, drawn with equal probabilities by reservoir sampling.
    fn judge(&mut self) {
        self.judgements_left -= 1;
        let change = self.strands.change(self.matching, &self.steps);
        if change < 0 {
            self.joining = Some(self.steps.clone());
        } else if change == 0 {
            self.neutral_count += 1;
            if self.rng.next_u64().is_multiple_of(self.neutral_count) {
                self.neutral.clone_from(&self.steps);
            }
        }
    }
}
