//! The paths and cycles of a 2-matching, numbered so that an exchange of links can be evaluated
//! without walking along them.
//!
//! Each cell knows its strand and its position on it.
//! To evaluate an exchange means to count the strands that it would leave.
//! Cut the strands at the links to be removed: this leaves segments of which only the ends matter.
//! Then join segments at the links to be inserted, each of which leads from one segment end to
//! another.
//! Each group of joined segments is one strand after the exchange:
//!
//! ```text
//!   before:     A=====B-C=====F       a path from A to F
//!               G=====H-(G)           a cycle, closed by the link from H to G
//!   removed:    B-C and H-G           leaves the segments AB, CF and GH
//!   inserted:   B-G and H-C           joins all three: A=====B-G=====H-C=====F
//! ```
//!
//! Sorting the cuts by position gives the segments, and disjoint sets count those joined.
//! So evaluating k links takes O(k^2) time, whatever the lengths of the strands.
//! Only an exchange that is applied renumbers the strands that it touches.

use crate::disjoint_sets::DisjointSets;
use crate::matching::{Board, Dir, Node, TwoMatching, dirs, opposite};

/// A path or cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strand {
    /// The cells at its first and its last position.
    pub(super) ends: [Node; 2],
    /// Number of cells; 0 for a number that is not in use.
    pub(super) length: u32,
    pub(super) is_cycle: bool,
}

/// All strands of a 2-matching.
pub(super) struct Strands {
    /// For each node the number of its strand.
    pub(super) strand_of: Vec<u32>,
    /// For each node its position on the strand, from 0.
    position: Vec<u32>,
    /// The strands by their numbers.
    pub(super) list: Vec<Strand>,
    /// Number of cycles.
    pub(super) cycles: u32,
    /// Two cells that must not be the ends of one path, if there are any.
    separate_ends: Option<[Node; 2]>,
    judgement: Judgement,
}

/// Buffers for evaluating exchanges, kept to avoid allocations.
#[derive(Default)]
struct Judgement {
    cuts: Vec<Cut>,
    /// The numbers of the strands that the exchange touches.
    strands: Vec<u32>,
    segments: Vec<Segment>,
    sets: DisjointSets,
}

/// A link to be removed, in the order of positions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cut {
    strand: u32,
    /// The position of the cell before the cut.
    position: u32,
    /// The cells before and after the cut.
    cells: [Node; 2],
}

/// A stretch of a strand between two cuts, or between a cut and the strand's end.
#[derive(Clone, Copy)]
struct Segment {
    /// Its first and last cell, which may be the same.
    ends: [Node; 2],
    /// For each end, whether it is already linked to another end: by an inserted link, or by the
    /// link that closes a cycle.
    is_tied: [bool; 2],
}

impl Segment {
    fn loose(ends: [Node; 2]) -> Self {
        Self { ends, is_tied: [false; 2] }
    }
}

impl Strands {
    /// Marks cells whose strand is not known yet.
    const NONE: u32 = u32::MAX;

    /// Numbers all cells.
    /// Linear.
    pub(super) fn new(matching: &TwoMatching<'_>, separate_ends: Option<[Node; 2]>) -> Self {
        let nodes = matching.board.node_count();
        let mut strands = Self {
            strand_of: vec![Self::NONE; nodes],
            position: vec![0; nodes],
            list: Vec::new(),
            cycles: 0,
            separate_ends,
            judgement: Judgement::default(),
        };
        // Paths have to be walked from an end, so ends come first; cells without a number after
        // that lie on cycles.
        let is_end = |&&node: &&Node| matching.links[node as usize].count_ones() < 2;
        for &first in matching.board.cells.iter().filter(is_end).chain(&matching.board.cells) {
            if strands.strand_of[first as usize] == Self::NONE {
                let number = strands.list.len() as u32;
                let strand = strands.walk(matching, first, number);
                strands.cycles += u32::from(strand.is_cycle);
                strands.list.push(strand);
            }
        }
        strands
    }

    /// Numbers the cells of the strand that begins at this cell: an end of a path, or any cell of a
    /// cycle.
    fn walk(&mut self, matching: &TwoMatching<'_>, first: Node, number: u32) -> Strand {
        let mut node = first;
        let mut from: Option<Dir> = None;
        let mut position = 0;
        loop {
            self.strand_of[node as usize] = number;
            self.position[node as usize] = position;
            position += 1;
            let mut ahead = matching.links[node as usize];
            if let Some(dir) = from {
                ahead &= !(1 << opposite(dir));
            }
            if ahead == 0 {
                return Strand { ends: [first, node], length: position, is_cycle: false };
            }
            let dir = ahead.trailing_zeros() as Dir;
            let next = matching.board.neighbour(node, dir);
            if next == first {
                return Strand { ends: [first, node], length: position, is_cycle: true };
            }
            (node, from) = (next, Some(dir));
        }
    }

    /// Whether no cycle is left, and the ends that must be separate are on different paths.
    pub(super) fn is_settled(&self) -> bool {
        self.cycles == 0 && self.joined_ends().is_none()
    }

    /// The path that has both of the ends that must be separate, if there is one.
    pub(super) fn joined_ends(&self) -> Option<u32> {
        let [a, b] = self.separate_ends?.map(|node| self.strand_of[node as usize]);
        (a == b).then_some(a)
    }

    /// Change of the number of strands by an exchange, where a path that has both of the ends that
    /// must be separate counts as two strands.
    ///
    /// A negative result is progress: the exchange joins strands, or moves the two ends to
    /// different paths without increasing the number of strands.
    /// A search minimises this count, because each cycle is one strand more than a cover has.
    ///
    /// The steps name the links to toggle, each by one of its cells.
    /// They form an alternating cycle, or an alternating path that starts at a cell with room.
    /// O(k^2) for k steps.
    pub(super) fn change(&mut self, matching: &TwoMatching<'_>, steps: &[(Node, Dir)]) -> i32 {
        self.cut(matching, steps);
        let Self { strand_of, judgement, separate_ends, .. } = self;
        let Judgement { strands, segments, sets, .. } = judgement;
        sets.reset(segments.len());
        let mut after = segments.len() as i32;
        for &(node, dir) in steps.iter().filter(|&&(node, dir)| !matching.is_linked(node, dir)) {
            let [a, b] = [node, matching.board.neighbour(node, dir)].map(|cell| {
                let (segment, end) = loose_end(segments, cell);
                segments[segment].is_tied[end] = true;
                segment as u32
            });
            after -= i32::from(sets.union(a, b));
        }
        let mut before = strands.len() as i32;
        if let Some(ends) = *separate_ends
            && ends.iter().any(|&end| strands.contains(&strand_of[end as usize]))
        {
            before += i32::from(strand_of[ends[0] as usize] == strand_of[ends[1] as usize]);
            // A reserved cell has at most one link, so it is an end of its strand, and an end of a
            // segment if the exchange touches that strand.
            let segment_of =
                |end: Node| segments.iter().position(|segment| segment.ends.contains(&end));
            let is_joined = match ends.map(segment_of) {
                [Some(a), Some(b)] => sets.find(a as u32) == sets.find(b as u32),
                _ => false,
            };
            after += i32::from(is_joined);
        }
        after - before
    }

    /// Cuts the strands that an exchange touches at the links that it removes, into segments.
    fn cut(&mut self, matching: &TwoMatching<'_>, steps: &[(Node, Dir)]) {
        let Self { strand_of, position, list, judgement, .. } = self;
        let Judgement { cuts, strands, segments, .. } = judgement;
        cuts.clear();
        strands.clear();
        segments.clear();
        for &(node, dir) in steps {
            let other = matching.board.neighbour(node, dir);
            for cell in [node, other] {
                let number = strand_of[cell as usize];
                if !strands.contains(&number) {
                    strands.push(number);
                }
            }
            if matching.is_linked(node, dir) {
                let (mut before, mut after) = (node, other);
                if position[before as usize] > position[after as usize] {
                    std::mem::swap(&mut before, &mut after);
                }
                // The link that closes a cycle leads from the last position to the first.
                if position[after as usize] - position[before as usize] > 1 {
                    std::mem::swap(&mut before, &mut after);
                }
                let (strand, position) = (strand_of[node as usize], position[before as usize]);
                cuts.push(Cut { strand, position, cells: [before, after] });
            }
        }
        cuts.sort_unstable();
        for &number in &*strands {
            let begin = cuts.partition_point(|cut| cut.strand < number);
            let end = cuts.partition_point(|cut| cut.strand <= number);
            let Strand { ends: [first, last], is_cycle, .. } = list[number as usize];
            match &cuts[begin..end] {
                // No cut: the strand stays whole.
                [] => segments.push(Segment { ends: [first, last], is_tied: [is_cycle; 2] }),
                cuts @ ([first_cut, .., last_cut] | [first_cut @ last_cut]) => {
                    let inner = cuts.windows(2).map(|pair| [pair[0].cells[1], pair[1].cells[0]]);
                    segments.extend(inner.map(Segment::loose));
                    if is_cycle {
                        // The segment that contains position 0, where the numbering of the cycle
                        // begins.
                        segments.push(Segment::loose([last_cut.cells[1], first_cut.cells[0]]));
                    } else {
                        segments.push(Segment::loose([first, first_cut.cells[0]]));
                        segments.push(Segment::loose([last_cut.cells[1], last]));
                    }
                }
            }
        }
    }

    /// Toggles the links of an exchange, and renumbers the strands that it touches.
    /// Linear in the lengths of these strands.
    pub(super) fn apply(&mut self, matching: &mut TwoMatching<'_>, steps: &[(Node, Dir)]) {
        // Cells at which a strand may begin after the exchange.
        let mut firsts = Vec::new();
        // Numbers of the strands touched, which are free to be used again.
        let mut numbers: Vec<u32> = Vec::new();
        for &(node, dir) in steps {
            for cell in [node, matching.board.neighbour(node, dir)] {
                let number = self.strand_of[cell as usize];
                if !numbers.contains(&number) {
                    numbers.push(number);
                }
                firsts.push(cell);
            }
        }
        for &number in &numbers {
            let strand = &mut self.list[number as usize];
            firsts.extend(strand.ends);
            self.cycles -= u32::from(strand.is_cycle);
            strand.length = 0;
        }
        for &(node, dir) in steps {
            let is_removed = matching.is_linked(node, dir);
            matching.toggle(node, dir);
            for cell in [node, matching.board.neighbour(node, dir)] {
                // Wrapping, because along an alternating path a cell may get a link before it loses
                // one, so that its room is briefly -1.
                let room = &mut matching.room[cell as usize];
                *room = if is_removed { room.wrapping_add(1) } else { room.wrapping_sub(1) };
            }
        }
        // Every strand after the exchange contains one of these cells.
        // Ends of paths come first, as in `new`.
        for &cell in &firsts {
            self.strand_of[cell as usize] = Self::NONE;
        }
        let is_end = |node: &Node| matching.links[*node as usize].count_ones() < 2;
        firsts.sort_by_key(|node| !is_end(node));
        for first in firsts {
            if self.strand_of[first as usize] == Self::NONE {
                let number = numbers.pop().unwrap_or(self.list.len() as u32);
                let strand = self.walk(matching, first, number);
                self.cycles += u32::from(strand.is_cycle);
                match self.list.get_mut(number as usize) {
                    Some(entry) => *entry = strand,
                    None => self.list.push(strand),
                }
            }
        }
    }

    /// The possible links from a cycle to another strand, or to another strand from the path that
    /// has both of the ends that must be separate.
    /// Links are named by their black cells.
    pub(super) fn links_to_settle(&self, matching: &TwoMatching<'_>) -> Vec<(Node, Dir)> {
        let board = matching.board;
        let strand = |node: Node| self.strand_of[node as usize];
        let joined = self.joined_ends();
        let is_unsettled =
            |node: Node| self.list[strand(node) as usize].is_cycle || joined == Some(strand(node));
        let mut links = Vec::new();
        for &node in board.cells.iter().filter(|&&node| Board::is_black(node)) {
            for dir in dirs(board.neighbours[node as usize]) {
                let other = board.neighbour(node, dir);
                if strand(node) != strand(other) && (is_unsettled(node) || is_unsettled(other)) {
                    links.push((node, dir));
                }
            }
        }
        links
    }

    /// The cells of each strand in order; a cycle is cut open at its most expensive link.
    pub(super) fn pieces(&self, matching: &TwoMatching<'_>) -> Vec<Vec<Node>> {
        let board = matching.board;
        let cost = |a: Node, b: Node| {
            (0..4).find(|&dir| board.neighbour(a, dir) == b).map(|dir| board.link_cost(a, dir))
        };
        let numbers =
            (0..self.list.len() as u32).filter(|&number| self.list[number as usize].length > 0);
        let piece = |number: u32| {
            let mut cells = self.cells(matching, number);
            if self.list[number as usize].is_cycle {
                let length = cells.len();
                let most_expensive =
                    (0..length).max_by_key(|&at| cost(cells[at], cells[(at + 1) % length]));
                cells.rotate_left(most_expensive.map_or(0, |at| (at + 1) % length));
            }
            cells
        };
        numbers.map(piece).collect()
    }

    /// The cells of a strand in order.
    pub(super) fn cells(&self, matching: &TwoMatching<'_>, number: u32) -> Vec<Node> {
        let Strand { ends: [first, _], length, .. } = self.list[number as usize];
        let mut cells = Vec::with_capacity(length as usize);
        let mut previous = first;
        let mut node = first;
        while cells.len() < length as usize {
            cells.push(node);
            // The first cell of a cycle is linked to both the second and the last cell: positions
            // decide which one is next.
            let is_next = |&other: &Node| {
                self.position[other as usize] == cells.len() as u32 && other != previous
            };
            let next = dirs(matching.links[node as usize])
                .map(|dir| matching.board.neighbour(node, dir))
                .find(is_next);
            let Some(next) = next else { break };
            (previous, node) = (node, next);
        }
        cells
    }
}

/// Finds the segment end at this cell that is not linked yet: the index of the segment, and which
/// of its two ends it is.
fn loose_end(segments: &[Segment], cell: Node) -> (usize, usize) {
    let find = |(index, segment): (usize, &Segment)| {
        let is_loose = |&end: &usize| segment.ends[end] == cell && !segment.is_tied[end];
        (0..2).find(is_loose).map(|end| (index, end))
    };
    segments
        .iter()
        .enumerate()
        .find_map(find)
        .expect("a link is inserted where another is removed or where there is room")
}

#[cfg(test)]
mod tests {
    use beadwork_grid::{Layout, LayoutSpec, Region};
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::CostMatrix;
    use crate::matching::LadderLayout;

    /// The number of strands, counted by walking along all of them.
    fn count(matching: &TwoMatching<'_>) -> i32 {
        Strands::new(matching, None).list.len() as i32
    }

    /// A random exchange: an alternating cycle, or an alternating path from a cell with room.
    fn exchange(matching: &TwoMatching<'_>, rng: &mut impl Rng) -> Option<Vec<(Node, Dir)>> {
        let board = matching.board;
        let mut pick = |set: u8| {
            let all: Vec<Dir> = dirs(set).collect();
            (!all.is_empty()).then(|| all[(rng.next_u64() % all.len() as u64) as usize])
        };
        let first = board.cells[pick(0b1111)? * board.cells.len() / 4];
        let has_room = matching.has_room(first);
        let mut steps: Vec<(Node, Dir)> = Vec::new();
        let mut node = first;
        while steps.len() < 12 {
            for is_removed in [false, true] {
                let links = matching.links[node as usize];
                let dir = pick(if is_removed {
                    links
                } else {
                    board.neighbours[node as usize] & !links
                })?;
                let other = board.neighbour(node, dir);
                if steps.contains(&(node, dir)) || steps.contains(&(other, opposite(dir))) {
                    return None;
                }
                steps.push((node, dir));
                node = other;
            }
            if node == first || has_room {
                return Some(steps);
            }
        }
        None
    }

    #[test]
    fn judgements_agree_with_counting() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut judged = 0;
        for seed in 0..60 {
            let region = Region::rectangle(4 + (seed % 5) as u32, 5 + (seed % 4) as u32).unwrap();
            let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
            let board = Board::of_components(&region, &zones, &CostMatrix::uniform(3)).remove(0);
            let mut matching = TwoMatching::inside_zones(&board, LadderLayout::default());
            matching.remove_links_inside(4, |count| count / 2);
            matching.grow(4);
            let mut strands = Strands::new(&matching, None);
            for _ in 0..4000 {
                let Some(steps) = exchange(&matching, &mut rng) else { continue };
                let before = count(&matching);
                let change = strands.change(&matching, &steps);
                strands.apply(&mut matching, &steps);
                assert_eq!(change, count(&matching) - before, "{steps:?}");
                let fresh = Strands::new(&matching, None);
                assert_eq!(strands.cycles, fresh.cycles);
                let mut cells: Vec<Node> = strands.pieces(&matching).concat();
                cells.sort_unstable();
                assert_eq!(cells, board.cells, "each cell once");
                judged += 1;
            }
        }
        assert!(judged > 5000, "{judged}");
    }
}
