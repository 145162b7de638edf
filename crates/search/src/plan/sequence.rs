//! In which order, and from which end, the pieces of a layer are printed, as far as tools go.

use std::collections::BTreeMap;

use beadwork_grid::{Cell, Zones};

use super::ToolCosts;
use super::order::within::NEVER;

/// Pieces of one tool, which cost the same in any order; or one piece of several tools.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// Numbers of the pieces.
    pub(super) pieces: Vec<usize>,
    /// The tools at the two ends.
    ends: [u8; 2],
    /// What the changes inside cost, forwards and backwards.
    inside: [u64; 2],
    is_plain: bool,
}

/// The blocks of a layer in an order, each forwards or backwards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sequence {
    /// The tool it begins with.
    pub(super) first: u8,
    /// The tool it ends with.
    pub(super) last: u8,
    /// Cost of all changes.
    pub(super) cost: u64,
    /// Numbers of blocks, and whether they are turned round.
    pub(super) blocks: Vec<(usize, bool)>,
}

/// More blocks than these are put in order step by step: the work doubles with each.
const MOST_EXACT: usize = 10;

/// The blocks of pieces: those of one tool each together, the others one by one.
pub(super) fn blocks(pieces: &[&[Cell]], zones: &Zones, costs: &ToolCosts) -> Vec<Block> {
    let mut plain: BTreeMap<u8, Vec<usize>> = BTreeMap::new();
    let mut blocks = Vec::new();
    for (number, piece) in pieces.iter().enumerate() {
        let mut inside = [0; 2];
        for step in piece.windows(2) {
            let [a, b] = [zones.id(step[0]), zones.id(step[1])];
            inside[0] += u64::from(costs.cost(a, b));
            inside[1] += u64::from(costs.cost(b, a));
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

/// For each tool to begin and each to end with, the cheapest sequence of all blocks.
///
/// The pieces of one tool stay together.
/// Exact but for that for up to 10 blocks, in O(2^n n² t) steps for t tools; beyond, one sequence
/// for each tool to begin with, of steps to the cheapest block left.
pub(super) fn sequences(blocks: &[Block], costs: &ToolCosts) -> Vec<Sequence> {
    let mut firsts: Vec<u8> = blocks.iter().flat_map(|block| block.ends).collect();
    firsts.sort_unstable();
    firsts.dedup();
    let from = |first: u8| {
        if blocks.len() <= MOST_EXACT {
            exact(blocks, costs, first)
        } else {
            vec![greedy(blocks, costs, first)]
        }
    };
    firsts.into_iter().flat_map(from).collect()
}

impl Block {
    /// Whether it is of one tool, and its pieces may be printed in any order.
    pub(super) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// What the changes inside cost, in a direction.
    pub(super) fn inside(&self, turned: bool) -> u64 {
        self.inside[usize::from(turned)]
    }

    /// The tools it begins and ends with, and its cost, in a direction: 0 forwards, 1 backwards.
    fn way(&self, turned: usize) -> (u8, u8, u64) {
        (self.ends[turned], self.ends[1 - turned], self.inside[turned])
    }
}

/// By the dynamic programme of Held and Karp over sets of blocks and the way in which the last of
/// them is printed.
fn exact(blocks: &[Block], costs: &ToolCosts, first: u8) -> Vec<Sequence> {
    let count = blocks.len();
    let all = (1_usize << count) - 1;
    // At `set * 2 count + 2 block + turned`: the least cost of the set's blocks with this one last,
    // and what came before it.
    let mut least = vec![(NEVER, usize::MAX); (all + 1) * 2 * count];
    let place = |set: usize, way: usize| set * 2 * count + way;
    for way in 0..2 * count {
        let (begin, _, inside) = blocks[way / 2].way(way % 2);
        if begin == first {
            least[place(1 << (way / 2), way)] = (inside, usize::MAX);
        }
    }
    for set in 1..=all {
        for way in (0..2 * count).filter(|way| set & 1 << (way / 2) != 0) {
            let (cost, _) = least[place(set, way)];
            if cost == NEVER {
                continue;
            }
            let (_, end, _) = blocks[way / 2].way(way % 2);
            for next in (0..2 * count).filter(|next| set & 1 << (next / 2) == 0) {
                let (begin, _, inside) = blocks[next / 2].way(next % 2);
                let cost = cost + u64::from(costs.cost(end, begin)) + inside;
                let entry = &mut least[place(set | 1 << (next / 2), next)];
                if cost < entry.0 {
                    *entry = (cost, way);
                }
            }
        }
    }
    let mut best: BTreeMap<u8, (u64, usize)> = BTreeMap::new();
    for way in 0..2 * count {
        let (cost, _) = least[place(all, way)];
        let (_, last, _) = blocks[way / 2].way(way % 2);
        let entry = best.entry(last).or_insert((NEVER, 0));
        *entry = (*entry).min((cost, way));
    }
    let reached = best.into_iter().filter(|&(_, (cost, _))| cost != NEVER);
    let trace = |(last, (cost, mut way)): (u8, (u64, usize))| {
        let mut sequence = Vec::with_capacity(count);
        let mut set = all;
        while way != usize::MAX {
            sequence.push((way / 2, way % 2 == 1));
            let before = least[place(set, way)].1;
            set &= !(1 << (way / 2));
            way = before;
        }
        sequence.reverse();
        Sequence { first, last, cost, blocks: sequence }
    };
    reached.map(trace).collect()
}

/// Always on to the block that costs least from here, of equal ones the first.
fn greedy(blocks: &[Block], costs: &ToolCosts, first: u8) -> Sequence {
    let mut left: Vec<usize> = (0..blocks.len()).collect();
    let mut sequence =
        Sequence { first, last: first, cost: 0, blocks: Vec::with_capacity(blocks.len()) };
    while !left.is_empty() {
        let is_begin = sequence.blocks.is_empty();
        let ways = left.iter().flat_map(|&block| [(block, 0), (block, 1)]);
        let cost = |&(block, turned): &(usize, usize)| {
            let (begin, _, inside) = blocks[block].way(turned);
            // The first one has to begin as asked.
            let step = if is_begin && begin != first {
                NEVER / 2
            } else {
                u64::from(costs.cost(sequence.last, begin))
            };
            (step, inside)
        };
        let (block, turned) = ways.min_by_key(cost).expect("there are blocks left");
        let (begin, end, inside) = blocks[block].way(turned);
        sequence.cost += u64::from(costs.cost(sequence.last, begin)) + inside;
        sequence.last = end;
        sequence.blocks.push((block, turned == 1));
        left.retain(|&other| other != block);
    }
    sequence
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    fn draw(rng: &mut Xoshiro256PlusPlus, most: usize) -> (Vec<Block>, ToolCosts) {
        let tools = rng.random_range(1..=4_u8);
        let row = |from: u8, rng: &mut Xoshiro256PlusPlus| {
            (0..tools)
                .map(|to| if to == from { 0 } else { rng.random_range(0..6) })
                .collect::<Vec<u32>>()
        };
        let costs =
            ToolCosts::new(&(0..tools).map(|from| row(from, rng)).collect::<Vec<_>>()).unwrap();
        let block = |number: usize| {
            let ends = [rng.random_range(0..tools), rng.random_range(0..tools)];
            Block {
                pieces: vec![number],
                ends,
                inside: [rng.random_range(0..5), rng.random_range(0..5)],
                is_plain: false,
            }
        };
        let count = most.min(1 + most / 2 + usize::from(tools) / 2);
        ((0..count).map(block).collect(), costs)
    }

    /// What a sequence costs, counted from its blocks.
    fn judge(sequence: &Sequence, blocks: &[Block], costs: &ToolCosts) {
        let mut seen: Vec<usize> = sequence.blocks.iter().map(|&(block, _)| block).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..blocks.len()).collect::<Vec<_>>());
        let mut tool = sequence.first;
        let mut cost = 0;
        for &(block, turned) in &sequence.blocks {
            let (begin, end, inside) = blocks[block].way(usize::from(turned));
            cost += u64::from(costs.cost(tool, begin)) + inside;
            tool = end;
        }
        let (block, turned) = sequence.blocks[0];
        assert_eq!(blocks[block].way(usize::from(turned)).0, sequence.first);
        assert_eq!((cost, tool), (sequence.cost, sequence.last));
    }

    /// The cheapest of all sequences for each pair of ends.
    fn all(blocks: &[Block], costs: &ToolCosts) -> BTreeMap<(u8, u8), u64> {
        fn go(
            left: &[usize],
            blocks: &[Block],
            costs: &ToolCosts,
            way: (u8, u8, u64),
            best: &mut BTreeMap<(u8, u8), u64>,
        ) {
            let (first, tool, cost) = way;
            if left.is_empty() {
                let entry = best.entry((first, tool)).or_insert(NEVER);
                *entry = cost.min(*entry);
            }
            for &block in left {
                for turned in 0..2 {
                    let (begin, end, inside) = blocks[block].way(turned);
                    let rest: Vec<usize> =
                        left.iter().copied().filter(|&other| other != block).collect();
                    go(
                        &rest,
                        blocks,
                        costs,
                        (first, end, cost + u64::from(costs.cost(tool, begin)) + inside),
                        best,
                    );
                }
            }
        }
        let mut best = BTreeMap::new();
        for block in 0..blocks.len() {
            for turned in 0..2 {
                let (begin, end, inside) = blocks[block].way(turned);
                let rest: Vec<usize> = (0..blocks.len()).filter(|&other| other != block).collect();
                go(&rest, blocks, costs, (begin, end, inside), &mut best);
            }
        }
        best
    }

    #[test]
    fn few_blocks_are_put_in_the_cheapest_order() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..1500 {
            let (blocks, costs) = draw(&mut rng, 4);
            let found = sequences(&blocks, &costs);
            found.iter().for_each(|sequence| judge(sequence, &blocks, &costs));
            let found: BTreeMap<(u8, u8), u64> = found
                .into_iter()
                .map(|sequence| ((sequence.first, sequence.last), sequence.cost))
                .collect();
            assert_eq!(found, all(&blocks, &costs));
        }
    }

    #[test]
    fn many_blocks_are_put_in_some_order() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        for _ in 0..200 {
            let (blocks, costs) = draw(&mut rng, 40);
            assert!(blocks.len() > MOST_EXACT);
            sequences(&blocks, &costs).iter().for_each(|sequence| judge(sequence, &blocks, &costs));
        }
    }
}
