//! The ends near each end, and the groups near each group.

use super::kd_tree::KdTree;
use super::nearest::samples;
use super::problem::{Problem, across, item_of};

/// Number of items near each end, and of groups near each group.
const NEAR: usize = 8;
/// Number of entries of a loop from which neighbours are searched.
const PROBES: usize = 8;

/// Lists of near ends and groups.
pub(super) struct Neighbours {
    /// Near ends of each end that may be next to it for more than the order of groups.
    ends: Lists,
    /// Near groups of each group; empty if each group is an item.
    groups: Lists,
}

#[derive(Default)]
struct Lists {
    offsets: Vec<u32>,
    values: Vec<u32>,
}

impl Lists {
    fn get(&self, key: usize) -> &[u32] {
        match self.offsets.get(key..key + 2) {
            Some(&[from, to]) => &self.values[from as usize..to as usize],
            _ => &[],
        }
    }

    /// Closes the list of the next key.
    fn close(&mut self) {
        self.offsets.push(self.values.len() as u32);
    }

    fn new() -> Self {
        Self { offsets: vec![0], values: Vec::new() }
    }
}

impl Neighbours {
    /// Finds the lists in O(n log n) expected steps for n items.
    pub(super) fn new(problem: &Problem<'_>) -> Self {
        let points =
            |items: &[u32]| items.iter().flat_map(|&item| samples(problem, item)).collect();
        let trees: Vec<KdTree<u32>> = if problem.has_blocks {
            let members = problem.members.iter().enumerate();
            // The anchor, in leaf 0, has no point.
            members
                .map(|(leaf, items)| {
                    KdTree::new(if leaf == 0 { Vec::new() } else { points(items) })
                })
                .collect()
        } else {
            let all: Vec<u32> = (1..problem.count() as u32).collect();
            vec![KdTree::new(points(&all))]
        };
        let mut ends = Lists::new();
        // The anchor.
        let from = if problem.has_blocks { None } else { problem.from };
        ends.close();
        if let Some(from) = from {
            add_near(&trees[0], problem, 0, &[from], &mut ends.values);
        }
        ends.close();
        for item in 1..problem.count() {
            let tree = &trees[if problem.has_blocks { problem.leaf[item] as usize } else { 0 }];
            match problem.entries(item) {
                None => {
                    for point in problem.ends(item) {
                        add_near(tree, problem, item, &[point], &mut ends.values);
                        ends.close();
                    }
                }
                Some(entries) => {
                    let count = entries.len().min(PROBES);
                    let probe = |probe: usize| entries[probe * entries.len() / count];
                    let probes: Vec<_> = (0..count).map(probe).collect();
                    let from = ends.values.len();
                    add_near(tree, problem, item, &probes, &mut ends.values);
                    ends.close();
                    ends.values.extend_from_within(from..);
                    ends.close();
                }
            }
        }
        let groups = if problem.has_blocks { near_groups(problem) } else { Lists::default() };
        Self { ends, groups }
    }

    /// Near ends of an end: any in free order, those of the same leaf otherwise.
    #[inline]
    pub(super) fn of_end(&self, end: u32) -> &[u32] {
        self.ends.get(end as usize)
    }

    /// Near groups of a group.
    #[inline]
    pub(super) fn of_group(&self, group: u32) -> &[u32] {
        self.groups.get(group as usize)
    }
}

/// Adds the ends nearest to any of the points, nearest first, except those of the item itself.
fn add_near(
    tree: &KdTree<u32>,
    problem: &Problem<'_>,
    item: usize,
    points: &[[f64; 2]],
    values: &mut Vec<u32>,
) {
    let mut near = [(f64::INFINITY, u32::MAX); NEAR];
    for &point in points {
        tree.search(point, &mut |distance, _, end| {
            if item_of(end) != item {
                // Points of a loop that is in the list already replace it if they are nearer.
                let known = near.iter().position(|&(_, other)| other == end);
                let slot = known.unwrap_or(NEAR - 1);
                if distance < near[slot].0 {
                    let to = near.partition_point(|&(other, _)| other <= distance);
                    near[to..=slot].rotate_right(1);
                    near[to] = (distance, end);
                }
            }
            near[NEAR - 1].0
        });
    }
    for &(_, end) in near.iter().filter(|&&(_, end)| end != u32::MAX) {
        values.push(end);
        if problem.entries(item_of(end)).is_some() {
            values.push(across(end));
        }
    }
}

/// The groups whose centres are nearest to that of each group.
fn near_groups(problem: &Problem<'_>) -> Lists {
    let groups = problem.first_leaf.len() - 1;
    let centre = |group: usize| {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for leaf in problem.first_leaf[group]..problem.first_leaf[group + 1] {
            let items = problem.members[leaf as usize].iter();
            for (point, _) in items.flat_map(|&item| samples(problem, item)) {
                for axis in 0..2 {
                    low[axis] = low[axis].min(point[axis]);
                    high[axis] = high[axis].max(point[axis]);
                }
            }
        }
        [f64::midpoint(low[0], high[0]), f64::midpoint(low[1], high[1])]
    };
    let centres: Vec<([f64; 2], u32)> =
        (1..groups).map(|group| (centre(group), group as u32)).collect();
    let tree = KdTree::new(centres.clone());
    let mut lists = Lists::new();
    let add = |own: Option<u32>, point: [f64; 2], lists: &mut Lists| {
        let mut near = [(f64::INFINITY, u32::MAX); NEAR];
        tree.search(point, &mut |distance, _, group| {
            if Some(group) != own {
                let to = near.partition_point(|&(other, _)| other <= distance);
                if to < NEAR {
                    near[to..].rotate_right(1);
                    near[to] = (distance, group);
                }
            }
            near[NEAR - 1].0
        });
        let known = near.iter().filter(|&&(_, group)| group != u32::MAX);
        lists.values.extend(known.map(|&(_, group)| group));
        lists.close();
    };
    match problem.from {
        Some(from) => add(None, from, &mut lists),
        None => lists.close(),
    }
    centres.iter().for_each(|&(point, group)| add(Some(group), point, &mut lists));
    lists
}
