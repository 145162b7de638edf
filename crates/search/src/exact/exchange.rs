//! Joining the cycles that switches cannot join.

use beadwork_base::Control;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::strands::Strands;
use crate::matching::{Dir, Matching, Node, dirs};

/// Steps of the longest exchange tried: half of them links put in, half taken out.
const LONGEST: usize = 12;

/// Joins cycles to other strands by exchanges along short alternating cycles, and by ends that move
/// along alternating paths, none of which raises the cost.
///
/// While no exchange around a cycle takes a strand away, one that takes none away is made at
/// random: the cycle changes its shape and place, until it can be joined.
/// A path that has both of the ends that should be apart is treated like a cycle.
/// Ends when nothing is left to settle, or after so many exchanges.
pub(super) fn join_by_exchanges(
    matching: &mut Matching<'_>,
    strands: &mut Strands,
    rng: &mut Xoshiro256PlusPlus,
    exchanges: u64,
    control: &Control<'_>,
) {
    let mut made = 0;
    let mut in_vain = 0;
    while !strands.is_settled() && made < exchanges && control.interrupted().is_none() {
        let number = pick_cycle(strands, rng)
            .or(strands.joined_ends())
            .expect("something is left to settle");
        let cells = strands.cells(matching, number);
        // Short exchanges are found at once and mostly suffice; there are far more of the long
        // ones.
        let steps = match in_vain {
            0 => 6,
            1..6 => 8,
            _ => 10 + 2 * (in_vain % 2),
        };
        let mut search = Search {
            matching,
            strands,
            steps: Vec::with_capacity(LONGEST),
            first: 0,
            first_has_room: false,
            longest: steps,
            left: 4000,
            spent: 0,
            better: None,
            equal: Vec::new(),
            equals: 0,
            rng,
        };
        search.around(&cells);
        let (better, equal) = (search.better.take(), std::mem::take(&mut search.equal));
        made += 1;
        if let Some(steps) = better {
            strands.apply(matching, &steps);
            in_vain = 0;
        } else if equal.is_empty() {
            in_vain += 1;
        } else {
            strands.apply(matching, &equal);
            in_vain += 1;
        }
    }
}

/// One of the smallest cycles, mostly.
fn pick_cycle(strands: &Strands, rng: &mut Xoshiro256PlusPlus) -> Option<u32> {
    let cycles =
        strands.list.iter().enumerate().filter(|(_, strand)| strand.is_cycle && strand.length > 0);
    let key = |length: u32, random: u64| u64::from(length) + (random >> 61);
    let smallest =
        cycles.map(|(number, strand)| (key(strand.length, rng.next_u64()), number)).min();
    smallest.map(|(_, number)| number as u32)
}

/// Exchanges that begin with a link put in at a cell of a cycle.
struct Search<'s, 'a> {
    matching: &'s Matching<'a>,
    strands: &'s mut Strands,
    /// The exchange so far: links put in and taken out in turn.
    steps: Vec<(Node, Dir)>,
    first: Node,
    first_has_room: bool,
    longest: usize,
    /// Exchanges that may still be judged.
    left: u32,
    /// Reduced cost of the exchange so far.
    spent: i32,
    better: Option<Vec<(Node, Dir)>>,
    /// A random one of the exchanges that keep the number of strands, and how many there were.
    equal: Vec<(Node, Dir)>,
    equals: u64,
    rng: &'s mut Xoshiro256PlusPlus,
}

impl Search<'_, '_> {
    fn around(&mut self, cells: &[Node]) {
        let offset = (self.rng.next_u64() >> 32) as usize % cells.len();
        for index in 0..cells.len() {
            let cell = cells[(index + offset) % cells.len()];
            for dir in dirs(self.matching.board.neighbours[cell as usize]) {
                let other = self.matching.board.step(cell, dir);
                if self.strands.strand[other as usize] == self.strands.strand[cell as usize] {
                    continue;
                }
                for (first, dir) in [(cell, dir), (other, dir ^ 2)] {
                    self.begin(first, dir);
                    if self.better.is_some() || self.left == 0 {
                        return;
                    }
                }
            }
        }
    }

    fn begin(&mut self, first: Node, dir: Dir) {
        self.first = first;
        self.first_has_room = self.matching.room[first as usize] > 0;
        self.steps.clear();
        self.spent = 0;
        self.put_in(first, dir);
    }

    fn put_in(&mut self, node: Node, dir: Dir) {
        let reduced = self.matching.reduced(node, dir);
        if self.spent + reduced > 0 || self.is_used(node, dir) {
            return;
        }
        self.spent += reduced;
        self.steps.push((node, dir));
        let over = self.matching.board.step(node, dir);
        for dir in dirs(self.matching.links[over as usize]) {
            self.take_out(over, dir);
            if self.better.is_some() || self.left == 0 {
                break;
            }
        }
        self.steps.pop();
        self.spent -= reduced;
    }

    fn take_out(&mut self, node: Node, dir: Dir) {
        let reduced = -self.matching.reduced(node, dir);
        if self.spent + reduced > 0 || self.is_used(node, dir) {
            return;
        }
        let lacking = self.matching.board.step(node, dir);
        self.spent += reduced;
        self.steps.push((node, dir));
        if lacking == self.first {
            self.judge();
        } else {
            if self.first_has_room && self.cost() <= 0 {
                self.judge();
            }
            if self.steps.len() < self.longest && self.can_return(lacking) {
                let missing = self.matching.board.neighbours[lacking as usize]
                    & !self.matching.links[lacking as usize];
                for dir in dirs(missing) {
                    if self.better.is_some() || self.left == 0 {
                        break;
                    }
                    self.put_in(lacking, dir);
                }
            }
        }
        self.steps.pop();
        self.spent -= reduced;
    }

    fn is_used(&self, node: Node, dir: Dir) -> bool {
        let other = self.matching.board.step(node, dir);
        self.steps.iter().any(|&step| step == (node, dir) || step == (other, dir ^ 2))
    }

    /// Whether enough steps are left to come back to the first cell.
    fn can_return(&self, node: Node) -> bool {
        let ((ax, ay), (bx, by)) =
            (self.matching.board.xy(node), self.matching.board.xy(self.first));
        self.first_has_room
            || (ax.abs_diff(bx) + ay.abs_diff(by)) as usize <= self.longest - self.steps.len()
    }

    /// What the exchange adds to the cost.
    fn cost(&self) -> i32 {
        let signed = |(index, &(node, dir)): (usize, &(Node, Dir))| {
            let cost = self.matching.board.cost(node, dir);
            if index % 2 == 0 { cost } else { -cost }
        };
        self.steps.iter().enumerate().map(signed).sum()
    }

    fn judge(&mut self) {
        self.left -= 1;
        let change = self.strands.change(self.matching, &self.steps);
        if change < 0 {
            self.better = Some(self.steps.clone());
        } else if change == 0 {
            self.equals += 1;
            if self.rng.next_u64().is_multiple_of(self.equals) {
                self.equal.clone_from(&self.steps);
            }
        }
    }
}
