//! The order and the directions in which the pieces of a continuous layer are printed.
//!
//! A piece that crosses zones uses several tools.
//! The tool changes inside it cost the same whenever it is printed, but may cost a different amount
//! backwards.
//! Between two pieces, the tool changes from the last tool of the first piece to the first tool of
//! the second.
//! Finding the cheapest order is a travelling-salesman problem for a path in which each "city" can
//! be passed in two directions.
//!
//! Two things keep it small.
//! All pieces that use the same single tool form one **block**, as their order and direction change
//! no tool cost; this is optimal unless a detour over another tool is cheaper than a direct change.
//! Each piece of several tools is a block of its own.
//! And for the rest of the plan only the first and the last tool of a layer matter, so one cheapest
//! **sequence** of blocks is needed for each pair of them.
//! Up to ten blocks are solved exactly by dynamic programming, more by a greedy rule.

use std::collections::BTreeMap;

use beadwork_grid::{Cell, Zones};

use super::order::within::NEVER;
use crate::CostMatrix;

/// Pieces that are printed together: all those of one tool, or a single piece of several tools.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// Numbers of the pieces.
    pub(super) pieces: Vec<usize>,
    /// The tools at the first and at the last cell.
    ends: [u8; 2],
    /// Scaled cost of the tool changes inside, forwards and backwards.
    inside: [u64; 2],
    is_plain: bool,
}

/// An order of the blocks of a layer, with the direction of each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sequence {
    /// The tool it begins with.
    pub(super) first: u8,
    /// The tool it ends with.
    pub(super) last: u8,
    /// Scaled cost of all tool changes.
    pub(super) cost: u64,
    /// Numbers of the blocks, and whether each is reversed.
    pub(super) blocks: Vec<(usize, bool)>,
}

/// Maximum number of blocks that are solved exactly; each additional block doubles the time.
const MAX_EXACT: usize = 10;

/// Groups pieces into blocks: those of one tool together, the others one by one.
pub(super) fn blocks(pieces: &[&[Cell]], zones: &Zones, costs: &CostMatrix) -> Vec<Block> {
    let mut plain: BTreeMap<u8, Vec<usize>> = BTreeMap::new();
    let mut blocks = Vec::new();
    for (number, piece) in pieces.iter().enumerate() {
        let mut inside = [0; 2];
        for step in piece.windows(2) {
            let [a, b] = [zones.id(step[0]), zones.id(step[1])];
            inside[0] += costs.step(a, b);
            inside[1] += costs.step(b, a);
        }
        let ends = [zones.id(piece[0]), zones.id(piece[piece.len() - 1])];
        if piece.iter().all(|&cell| zones.id(cell) == ends[0]) {
            plain.entry(ends[0]).or_default().push(number);
        } else {
            blocks.push(Block { pieces: vec![number], ends, inside, is_plain: false });
        }
    }
    blocks.extend(plain.into_iter().map(|(tool, pieces)| Block {
        pieces,
        ends: [tool; 2],
        inside: [0; 2],
        is_plain: true,
    }));
    blocks
}

/// The cheapest sequence of all blocks for each pair of a first and a last tool for which there is
/// one.
///
/// Up to 10 blocks are solved exactly, in O(2^n n² t) steps for n blocks and t first tools.
/// Beyond that, there is one sequence for each first tool, found by a greedy rule.
/// No change may be forbidden.
pub(super) fn sequences(blocks: &[Block], costs: &CostMatrix) -> Vec<Sequence> {
    let mut firsts: Vec<u8> = blocks.iter().flat_map(|block| block.ends).collect();
    firsts.sort_unstable();
    firsts.dedup();
    let from = |first: u8| {
        if blocks.len() <= MAX_EXACT {
            exact(blocks, costs, first)
        } else {
            vec![greedy(blocks, costs, first)]
        }
    };
    firsts.into_iter().flat_map(from).collect()
}

impl Block {
    /// Whether it holds pieces of a single tool, which may be printed in any order and direction.
    pub(super) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// Scaled cost of the tool changes inside, in the given direction.
    pub(super) fn inside(&self, is_reversed: bool) -> u64 {
        self.inside[usize::from(is_reversed)]
    }

    /// The first tool, the last tool and the cost inside, in a direction: 0 is forwards, 1 is
    /// backwards.
    fn directed(&self, direction: usize) -> (u8, u8, u64) {
        (self.ends[direction], self.ends[1 - direction], self.inside[direction])
    }
}

/// The cheapest sequences that begin with the tool `first`, by the dynamic programme of Held and
/// Karp.
///
/// A *state* is the set of the blocks printed so far, the last of them, and its direction.
/// How the others were ordered does not matter to what follows, so each state keeps only its
/// minimum cost and the block before the last.
/// Sets are bit masks and are visited in ascending order; adding a block always leads to a larger
/// one.
fn exact(blocks: &[Block], costs: &CostMatrix, first: u8) -> Vec<Sequence> {
    /// Marks the first block of a sequence.
    const NONE: usize = usize::MAX;

    let count = blocks.len();
    let all = (1_usize << count) - 1;
    // A block and its direction are one number: 2 * block + direction.
    let mut best = vec![(NEVER, NONE); (all + 1) * 2 * count];
    let state = |set: usize, directed: usize| set * 2 * count + directed;
    for directed in 0..2 * count {
        let (begin, _, inside) = blocks[directed / 2].directed(directed % 2);
        if begin == first {
            best[state(1 << (directed / 2), directed)] = (inside, NONE);
        }
    }
    for set in 1..=all {
        for directed in (0..2 * count).filter(|directed| set & 1 << (directed / 2) != 0) {
            let (cost, _) = best[state(set, directed)];
            if cost == NEVER {
                continue;
            }
            let (_, end, _) = blocks[directed / 2].directed(directed % 2);
            for next in (0..2 * count).filter(|next| set & 1 << (next / 2) == 0) {
                let (begin, _, inside) = blocks[next / 2].directed(next % 2);
                let cost = cost + costs.step(end, begin) + inside;
                let entry = &mut best[state(set | 1 << (next / 2), next)];
                if cost < entry.0 {
                    *entry = (cost, directed);
                }
            }
        }
    }
    // The best complete sequence for each last tool.
    let mut ends: BTreeMap<u8, (u64, usize)> = BTreeMap::new();
    for directed in 0..2 * count {
        let (cost, _) = best[state(all, directed)];
        let (_, last, _) = blocks[directed / 2].directed(directed % 2);
        let entry = ends.entry(last).or_insert((NEVER, 0));
        *entry = (*entry).min((cost, directed));
    }
    let reached = ends.into_iter().filter(|&(_, (cost, _))| cost != NEVER);
    // Walks back from the last block to the first.
    let trace = |(last, (cost, mut directed)): (u8, (u64, usize))| {
        let mut sequence = Vec::with_capacity(count);
        let mut set = all;
        while directed != NONE {
            sequence.push((directed / 2, directed % 2 == 1));
            let before = best[state(set, directed)].1;
            set &= !(1 << (directed / 2));
            directed = before;
        }
        sequence.reverse();
        Sequence { first, last, cost, blocks: sequence }
    };
    reached.map(trace).collect()
}

/// Builds a sequence greedily: the next block is the one that is cheapest to change to; of equal
/// ones, the one with the cheapest changes inside, then the first.
fn greedy(blocks: &[Block], costs: &CostMatrix, first: u8) -> Sequence {
    let mut remaining: Vec<usize> = (0..blocks.len()).collect();
    let mut sequence =
        Sequence { first, last: first, cost: 0, blocks: Vec::with_capacity(blocks.len()) };
    while !remaining.is_empty() {
        let is_begin = sequence.blocks.is_empty();
        let ways = remaining.iter().flat_map(|&block| [(block, 0), (block, 1)]);
        let cost = |&(block, direction): &(usize, usize)| {
            let (begin, _, inside) = blocks[block].directed(direction);
            // The sequence must begin with the tool `first`.
            let step = if is_begin && begin != first {
                NEVER / 2
            } else {
                costs.step(sequence.last, begin)
            };
            (step, inside)
        };
        let (block, direction) = ways.min_by_key(cost).expect("some blocks remain");
        let (begin, end, inside) = blocks[block].directed(direction);
        sequence.cost += costs.step(sequence.last, begin) + inside;
        sequence.last = end;
        sequence.blocks.push((block, direction == 1));
        remaining.retain(|&other| other != block);
    }
    sequence
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    fn draw(rng: &mut Xoshiro256PlusPlus, max: usize) -> (Vec<Block>, CostMatrix) {
        let tools = rng.random_range(1..=4_u8);
        let entries: Vec<u32> = (0..16).map(|_| rng.random_range(0..6)).collect();
        let costs = CostMatrix::from_fn(tools.into(), |from, to| entries[4 * from + to].into());
        let costs = costs.unwrap();
        let block = |number: usize| {
            let ends = [rng.random_range(0..tools), rng.random_range(0..tools)];
            Block {
                pieces: vec![number],
                ends,
                inside: [rng.random_range(0..5), rng.random_range(0..5)],
                is_plain: false,
            }
        };
        let count = max.min(1 + max / 2 + usize::from(tools) / 2);
        ((0..count).map(block).collect(), costs)
    }

    /// Checks a sequence against its blocks.
    fn check(sequence: &Sequence, blocks: &[Block], costs: &CostMatrix) {
        let mut seen: Vec<usize> = sequence.blocks.iter().map(|&(block, _)| block).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..blocks.len()).collect::<Vec<_>>());
        let mut tool = sequence.first;
        let mut cost = 0;
        for &(block, is_reversed) in &sequence.blocks {
            let (begin, end, inside) = blocks[block].directed(usize::from(is_reversed));
            cost += costs.step(tool, begin) + inside;
            tool = end;
        }
        let (block, is_reversed) = sequence.blocks[0];
        assert_eq!(blocks[block].directed(usize::from(is_reversed)).0, sequence.first);
        assert_eq!((cost, tool), (sequence.cost, sequence.last));
    }

    /// The cheapest of all sequences for each pair of ends.
    fn all(blocks: &[Block], costs: &CostMatrix) -> BTreeMap<(u8, u8), u64> {
        fn extend(
            remaining: &[usize],
            blocks: &[Block],
            costs: &CostMatrix,
            way: (u8, u8, u64),
            best: &mut BTreeMap<(u8, u8), u64>,
        ) {
            let (first, tool, cost) = way;
            if remaining.is_empty() {
                let entry = best.entry((first, tool)).or_insert(NEVER);
                *entry = cost.min(*entry);
            }
            for &block in remaining {
                for direction in 0..2 {
                    let (begin, end, inside) = blocks[block].directed(direction);
                    let rest: Vec<usize> =
                        remaining.iter().copied().filter(|&other| other != block).collect();
                    extend(
                        &rest,
                        blocks,
                        costs,
                        (first, end, cost + costs.step(tool, begin) + inside),
                        best,
                    );
                }
            }
        }
        let mut best = BTreeMap::new();
        for block in 0..blocks.len() {
            for direction in 0..2 {
                let (begin, end, inside) = blocks[block].directed(direction);
                let rest: Vec<usize> = (0..blocks.len()).filter(|&other| other != block).collect();
                extend(&rest, blocks, costs, (begin, end, inside), &mut best);
            }
        }
        best
    }

    #[test]
    fn few_blocks_get_the_cheapest_order() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..1500 {
            let (blocks, costs) = draw(&mut rng, 4);
            let found = sequences(&blocks, &costs);
            found.iter().for_each(|sequence| check(sequence, &blocks, &costs));
            let found: BTreeMap<(u8, u8), u64> = found
                .into_iter()
                .map(|sequence| ((sequence.first, sequence.last), sequence.cost))
                .collect();
            assert_eq!(found, all(&blocks, &costs));
        }
    }

    #[test]
    fn many_blocks_get_some_order() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        for _ in 0..200 {
            let (blocks, costs) = draw(&mut rng, 40);
            assert!(blocks.len() > MAX_EXACT);
            sequences(&blocks, &costs).iter().for_each(|sequence| check(sequence, &blocks, &costs));
        }
    }
}
