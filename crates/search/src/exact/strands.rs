//! The paths and cycles of a 2-matching, numbered so that an exchange of links can be judged
//! without walking them.

use crate::matching::{Board, Dir, Matching, Node, dirs};
use crate::union::Union;

/// A path or cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strand {
    /// Its cells at place 0 and at the last place.
    pub(crate) ends: [Node; 2],
    /// Number of cells; 0 for a number that is not in use.
    pub(crate) length: u32,
    pub(crate) is_cycle: bool,
}

/// All strands of a 2-matching.
pub(crate) struct Strands {
    /// For each node its strand.
    pub(crate) strand: Vec<u32>,
    /// For each node its place on the strand, from 0.
    place: Vec<u32>,
    pub(crate) list: Vec<Strand>,
    /// Number of cycles.
    pub(crate) cycles: u32,
    /// Two cells that should not be the ends of one path, if there are any.
    apart: Option<[Node; 2]>,
    scratch: Scratch,
}

/// What one judgement needs; kept to spare allocations.
#[derive(Default)]
struct Scratch {
    /// Strand and place after which it is cut, with the cells before and after the cut.
    cuts: Vec<(u32, u32, [Node; 2])>,
    strands: Vec<u32>,
    /// The first and the last cell of each segment between cuts, and whether a new link is tied
    /// there.
    segments: Vec<([Node; 2], [bool; 2])>,
    union: Union,
}

impl Strands {
    const NONE: u32 = u32::MAX;

    /// Numbers all cells.
    /// Linear.
    pub(crate) fn new(matching: &Matching<'_>, apart: Option<[Node; 2]>) -> Self {
        let nodes = matching.board.nodes();
        let mut strands = Self {
            strand: vec![Self::NONE; nodes],
            place: vec![0; nodes],
            list: Vec::new(),
            cycles: 0,
            apart,
            scratch: Scratch::default(),
        };
        let is_end = |&&node: &&Node| matching.links[node as usize].count_ones() < 2;
        for &first in matching.board.cells.iter().filter(is_end).chain(&matching.board.cells) {
            if strands.strand[first as usize] == Self::NONE {
                let number = strands.list.len() as u32;
                let strand = strands.walk(matching, first, number);
                strands.cycles += u32::from(strand.is_cycle);
                strands.list.push(strand);
            }
        }
        strands
    }

    /// Numbers the cells of the strand that begins with this cell: an end, or any cell of a cycle.
    fn walk(&mut self, matching: &Matching<'_>, first: Node, number: u32) -> Strand {
        let mut node = first;
        let mut from: Option<Dir> = None;
        let mut place = 0;
        loop {
            self.strand[node as usize] = number;
            self.place[node as usize] = place;
            place += 1;
            let mut bits = matching.links[node as usize];
            if let Some(dir) = from {
                bits &= !(1 << (dir ^ 2));
            }
            if bits == 0 {
                return Strand { ends: [first, node], length: place, is_cycle: false };
            }
            let dir = bits.trailing_zeros() as Dir;
            let next = matching.board.step(node, dir);
            if next == first {
                return Strand { ends: [first, node], length: place, is_cycle: true };
            }
            (node, from) = (next, Some(dir));
        }
    }

    /// Whether no cycle is left, and no two ends on one path that should not be.
    pub(crate) fn is_settled(&self) -> bool {
        self.cycles == 0 && self.joined_ends().is_none()
    }

    /// The path that has both of the cells that should be apart.
    pub(crate) fn joined_ends(&self) -> Option<u32> {
        let [a, b] = self.apart?.map(|node| self.strand[node as usize]);
        (a == b).then_some(a)
    }

    /// By how much the number of strands, and of paths with two ends that should be apart, changes
    /// if the links along an alternating path or cycle are toggled.
    ///
    /// Each step names a link, in or out, by one of its cells.
    /// O(k^2) for k steps, whatever the lengths of the strands: cutting k links leaves at most k +
    /// 1 segments, and the new links tie their ends together.
    pub(crate) fn change(&mut self, matching: &Matching<'_>, steps: &[(Node, Dir)]) -> i32 {
        let Self { strand, place, list, scratch, apart, .. } = self;
        let Scratch { cuts, strands, segments, union } = scratch;
        cuts.clear();
        strands.clear();
        segments.clear();
        let is_link = |&(node, dir): &(Node, Dir)| matching.links[node as usize] & (1 << dir) != 0;
        for &(node, dir) in steps {
            let other = matching.board.step(node, dir);
            for cell in [node, other] {
                let number = strand[cell as usize];
                if !strands.contains(&number) {
                    strands.push(number);
                }
            }
            if is_link(&(node, dir)) {
                let (mut before, mut after) = (node, other);
                if place[before as usize] > place[after as usize] {
                    std::mem::swap(&mut before, &mut after);
                }
                // The link that closes a cycle lies after its last place.
                if place[after as usize] - place[before as usize] > 1 {
                    std::mem::swap(&mut before, &mut after);
                }
                cuts.push((strand[node as usize], place[before as usize], [before, after]));
            }
        }
        cuts.sort_unstable();
        for &number in &*strands {
            let begin = cuts.partition_point(|cut| cut.0 < number);
            let end = cuts.partition_point(|cut| cut.0 <= number);
            let here = &cuts[begin..end];
            let Strand { ends: [first, last], is_cycle, .. } = list[number as usize];
            match here {
                [] => segments.push(([first, last], [is_cycle; 2])),
                [one, .., other] | [one @ other] => {
                    let inner = here.windows(2).map(|pair| [pair[0].2[1], pair[1].2[0]]);
                    segments.extend(inner.map(|cells| (cells, [false; 2])));
                    if is_cycle {
                        segments.push(([other.2[1], one.2[0]], [false; 2]));
                    } else {
                        segments.push(([first, one.2[0]], [false; 2]));
                        segments.push(([other.2[1], last], [false; 2]));
                    }
                }
            }
        }
        union.reset(segments.len());
        let mut after = segments.len() as i32;
        for &(node, dir) in steps.iter().filter(|step| !is_link(step)) {
            let [a, b] = [node, matching.board.step(node, dir)].map(|cell| {
                let (segment, end) = free_end(segments, cell);
                segments[segment].1[end] = true;
                segment as u32
            });
            after -= i32::from(union.unite(a, b));
        }
        let mut before = strands.len() as i32;
        if let Some(ends) = *apart
            && strands.iter().any(|&number| ends.iter().any(|&end| strand[end as usize] == number))
        {
            before += i32::from(strand[ends[0] as usize] == strand[ends[1] as usize]);
            let place = |end: Node| segments.iter().position(|(cells, _)| cells.contains(&end));
            let joined = match ends.map(place) {
                // Each is the end of some segment, for it is the end of a path; the last link of
                // its path keeps it so.
                [Some(a), Some(b)] => union.root(a as u32) == union.root(b as u32),
                _ => false,
            };
            after += i32::from(joined);
        }
        after - before
    }

    /// Toggles the links, and numbers anew what they touch: linear in the lengths of those strands.
    pub(crate) fn apply(&mut self, matching: &mut Matching<'_>, steps: &[(Node, Dir)]) {
        let mut numbers: Vec<u32> = Vec::new();
        let mut firsts = Vec::new();
        for &(node, dir) in steps {
            for cell in [node, matching.board.step(node, dir)] {
                let number = self.strand[cell as usize];
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
            let taken_out = matching.links[node as usize] & (1 << dir) != 0;
            matching.toggle(node, dir);
            for cell in [node, matching.board.step(node, dir)] {
                let room = &mut matching.room[cell as usize];
                *room = if taken_out { room.wrapping_add(1) } else { room.wrapping_sub(1) };
            }
        }
        // Every strand that was touched contains one of these cells, and ends of paths come first.
        for &cell in &firsts {
            self.strand[cell as usize] = Self::NONE;
        }
        let is_end = |node: &Node| matching.links[*node as usize].count_ones() < 2;
        firsts.sort_by_key(|node| !is_end(node));
        for first in firsts {
            if self.strand[first as usize] == Self::NONE {
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

    /// The links that could lead to another strand from a cycle, or from a path whose ends should
    /// be apart; from their black cells.
    pub(crate) fn links_to_settle(&self, matching: &Matching<'_>) -> Vec<(Node, Dir)> {
        let board = matching.board;
        let strand = |node: Node| self.strand[node as usize];
        let joined = self.joined_ends();
        let is_unsettled =
            |node: Node| self.list[strand(node) as usize].is_cycle || joined == Some(strand(node));
        let mut links = Vec::new();
        for &node in board.cells.iter().filter(|&&node| Board::is_black(node)) {
            for dir in dirs(board.neighbours[node as usize]) {
                let other = board.step(node, dir);
                if strand(node) != strand(other) && (is_unsettled(node) || is_unsettled(other)) {
                    links.push((node, dir));
                }
            }
        }
        links
    }

    /// The cells of each strand in order; a cycle is opened where its link costs most.
    pub(crate) fn pieces(&self, matching: &Matching<'_>) -> Vec<Vec<Node>> {
        let board = matching.board;
        let cost = |a: Node, b: Node| {
            (0..4).find(|&dir| board.step(a, dir) == b).map(|dir| board.cost(a, dir))
        };
        let numbers =
            (0..self.list.len() as u32).filter(|&number| self.list[number as usize].length > 0);
        let open = |number: u32| {
            let mut cells = self.cells(matching, number);
            if self.list[number as usize].is_cycle {
                let length = cells.len();
                let dearest =
                    (0..length).max_by_key(|&at| cost(cells[at], cells[(at + 1) % length]));
                cells.rotate_left(dearest.map_or(0, |at| (at + 1) % length));
            }
            cells
        };
        numbers.map(open).collect()
    }

    /// The cells of a strand in order.
    pub(crate) fn cells(&self, matching: &Matching<'_>, number: u32) -> Vec<Node> {
        let Strand { ends: [first, _], length, .. } = self.list[number as usize];
        let mut cells = Vec::with_capacity(length as usize);
        let mut before = first;
        let mut node = first;
        while cells.len() < length as usize {
            cells.push(node);
            // The numbering tells the way, also at the first cell of a cycle.
            let follows =
                |&other: &Node| self.place[other as usize] == cells.len() as u32 && other != before;
            let next = dirs(matching.links[node as usize])
                .map(|dir| matching.board.step(node, dir))
                .find(follows);
            let Some(next) = next else { break };
            (before, node) = (node, next);
        }
        cells
    }
}

/// A segment and its end at this cell to which nothing is tied yet.
fn free_end(segments: &[([Node; 2], [bool; 2])], cell: Node) -> (usize, usize) {
    let find = |(index, (cells, tied)): (usize, &([Node; 2], [bool; 2]))| {
        (0..2).find(|&end| cells[end] == cell && !tied[end]).map(|end| (index, end))
    };
    segments.iter().enumerate().find_map(find).expect("a new link begins where another one ended")
}

#[cfg(test)]
mod tests {
    use beadwork_grid::{Layout, LayoutSpec, Region};
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::ZoneCosts;
    use crate::matching::Grain;

    /// Strands counted by walking them all.
    fn count(matching: &Matching<'_>) -> i32 {
        Strands::new(matching, None).list.len() as i32
    }

    /// A random alternating walk of links put in and taken out, that ends where it began or begins
    /// at a cell with room.
    fn exchange(matching: &Matching<'_>, rng: &mut impl Rng) -> Option<Vec<(Node, Dir)>> {
        let board = matching.board;
        let mut pick = |bits: u8| {
            let all: Vec<Dir> = dirs(bits).collect();
            (!all.is_empty()).then(|| all[(rng.next_u64() % all.len() as u64) as usize])
        };
        let first = board.cells[pick(0b1111)? * board.cells.len() / 4];
        let has_room = matching.room[first as usize] > 0;
        let mut steps: Vec<(Node, Dir)> = Vec::new();
        let mut node = first;
        while steps.len() < 12 {
            for out in [false, true] {
                let links = matching.links[node as usize];
                let dir = pick(if out { links } else { board.neighbours[node as usize] & !links })?;
                let other = board.step(node, dir);
                if steps.contains(&(node, dir)) || steps.contains(&(other, dir ^ 2)) {
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
    fn exchanges_are_judged_as_by_walking() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut judged = 0;
        for seed in 0..60 {
            let region = Region::rectangle(4 + (seed % 5) as u32, 5 + (seed % 4) as u32).unwrap();
            let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
            let board = Board::of_components(&region, &zones, &ZoneCosts::uniform(3)).remove(0);
            let mut matching = Matching::inside_zones(&board, Grain::default());
            matching.drop_links_inside(4, |count| count / 2);
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
