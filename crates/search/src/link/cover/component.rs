//! Connected components of lines and links.

use crate::disjoint_sets::DisjointSets;
use crate::link::end::{End, Point};
use crate::link::links::Links;
use crate::lists::Lists;

/// A component: lines that links connect, directly or through others.
///
/// Its ends are numbered from 0: line k has the ends 2 k and 2 k + 1.
pub(super) struct Component {
    /// Position of each end.
    pub(super) points: Vec<Point>,
    /// The ends and the global number of each link, lower end first.
    pub(super) links: Vec<([u32; 2], u32)>,
    /// For each end the indices of its links.
    pub(super) links_at: Lists,
    /// For each link the indices of those that exclude it.
    pub(super) conflicts_of: Lists,
}

impl Component {
    /// All components in the order of their first lines.
    ///
    /// Lines whose links exclude each other are in the same component.
    pub(super) fn all(links: &Links) -> Vec<Self> {
        let mut sets = DisjointSets::new(links.line_count());
        for link in links.all() {
            sets.union(link.ends[0].line, link.ends[1].line);
        }
        for pair in links.conflicts() {
            let [a, b] = pair.map(|link| links.link(link).ends[0].line);
            sets.union(a, b);
        }
        let mut number_of_root = vec![u32::MAX; links.line_count()];
        // For each line the number of its component, and its index there.
        let mut places = Vec::with_capacity(links.line_count());
        let mut lines: Vec<Vec<u32>> = Vec::new();
        for line in 0..links.line_count() as u32 {
            let number = &mut number_of_root[sets.find(line) as usize];
            if *number == u32::MAX {
                *number = lines.len() as u32;
                lines.push(Vec::new());
            }
            let members = &mut lines[*number as usize];
            places.push((*number, members.len() as u32));
            members.push(line);
        }
        let place = |end: End| 2 * places[end.line as usize].1 + u32::from(end.is_last);
        let mut own: Vec<Vec<([u32; 2], u32)>> = vec![Vec::new(); lines.len()];
        let mut index_of = Vec::with_capacity(links.all().len());
        for (number, link) in links.all().iter().enumerate() {
            let own = &mut own[places[link.ends[0].line as usize].0 as usize];
            index_of.push(own.len() as u32);
            own.push((link.ends.map(place), number as u32));
        }
        lines
            .into_iter()
            .zip(own)
            .map(|(lines, own)| {
                let ends = lines.iter().flat_map(|&line| {
                    [false, true].map(|is_last| links.point(End { line, is_last }))
                });
                let points: Vec<Point> = ends.collect();
                let at = own
                    .iter()
                    .enumerate()
                    .flat_map(|(index, (ends, _))| ends.map(|end| (end as usize, index as u32)));
                let links_at = Lists::new(points.len(), at);
                let of = own.iter().enumerate().flat_map(|(index, &(_, number))| {
                    let others = links.conflicts_of(number).iter();
                    others.map(move |&other| (index, other))
                });
                let of = of.map(|(index, other)| (index, index_of[other as usize]));
                let conflicts_of = Lists::new(own.len(), of);
                Self { points, links: own, links_at, conflicts_of }
            })
            .collect()
    }

    /// Number of ends.
    pub(super) fn end_count(&self) -> usize {
        self.points.len()
    }

    /// The links at an end: their index, and the end at the other side.
    pub(super) fn links_at(&self, end: u32) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.links_at.list(end as usize).iter().map(move |&link| {
            let [a, b] = self.links[link as usize].0;
            (link, a ^ b ^ end)
        })
    }

    /// A lower bound on the number of beads: one, or more if many ends have no links.
    pub(super) fn degree_bound(&self) -> usize {
        let is_unlinked = |&end: &usize| self.links_at.list(end).is_empty();
        (0..self.end_count()).filter(is_unlinked).count().div_ceil(2).max(1)
    }
}
