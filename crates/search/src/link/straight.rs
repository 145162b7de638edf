//! Straight steps between ends, and what they cross.

use super::end::{End, Link, Point};
use super::kd_tree::KdTree;
use super::links::{Links, LinksError, is_valid};
use crate::segment::{Segment, SegmentGrid, are_near, cross_beyond, length, shorten};

/// Maximum number of nearest ends that an end is linked to by straight steps.
/// Ends have fewer near them, unless hundreds of lines coincide.
const MAX_NEAR: usize = 32;

/// Length in tolerances at both ends of a step in which it may touch anything.
const MARGIN: f64 = 10.0;

/// Maximum number of pairs of steps that are examined for crossings.
const MAX_PAIRS: usize = 100_000_000;

/// Maximum number of conflicts.
const MAX_CONFLICTS: usize = 1 << 22;

/// Lines, and a grid of their segments.
pub(super) struct Lines {
    /// The first and the last point of each line.
    pub(super) ends: Vec<[Point; 2]>,
    segments: SegmentGrid,
    tolerance: f64,
}

impl Lines {
    /// `cell` is the size of the cells of the grid in mm; `tolerance` is in mm.
    pub(super) fn new<L: AsRef<[Point]>>(
        lines: &[L],
        cell: f64,
        tolerance: f64,
    ) -> Result<Self, LinksError> {
        if lines.len() > Links::MAX_LINES {
            return Err(LinksError::TooManyLines { count: lines.len() });
        }
        let mut ends = Vec::with_capacity(lines.len());
        let mut segments: Vec<Segment> = Vec::new();
        for (number, line) in lines.iter().enumerate() {
            let line = line.as_ref();
            let [first, .., last] = line else {
                match line {
                    [point] if is_valid(*point) => {
                        ends.push([*point; 2]);
                        segments.push([*point; 2]);
                        continue;
                    }
                    [_] => return Err(LinksError::LinePoint { line: number }),
                    _ => return Err(LinksError::EmptyLine { line: number }),
                }
            };
            if !line.iter().all(|&point| is_valid(point)) {
                return Err(LinksError::LinePoint { line: number });
            }
            ends.push([*first, *last]);
            segments.extend(line.windows(2).map(|pair| [pair[0], pair[1]]));
        }
        Ok(Self { ends, segments: SegmentGrid::new(segments, cell), tolerance })
    }

    /// Pairs of ends of different lines at a distance of at most `distance` mm, lower end first,
    /// sorted.
    pub(super) fn pairs(&self, distance: f64) -> Vec<[End; 2]> {
        let points = self.ends.as_flattened();
        let tree = KdTree::new(points);
        let mut pairs: Vec<[End; 2]> = (0..points.len())
            .flat_map(|index| {
                let end = End::from_index(index);
                let near = tree.within(points[index], distance, MAX_NEAR + 2);
                near.into_iter()
                    .map(|(_, other)| End::from_index(other as usize))
                    .filter(move |other| other.line != end.line)
                    .map(move |other| [end.min(other), end.max(other)])
            })
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// The straight step between two ends.
    pub(super) fn step(&self, ends: [End; 2]) -> Segment {
        ends.map(|end| self.ends[end.line as usize][usize::from(end.is_last)])
    }

    /// Whether a straight step crosses or touches a line other than at its own ends.
    pub(super) fn blocks_step(&self, step: Segment) -> bool {
        let Some(inner) = shorten(step, MARGIN * self.tolerance) else { return false };
        self.segments.any_near(inner, self.tolerance, |number| {
            are_near(inner, self.segments.segments()[number as usize], self.tolerance)
        })
    }

    /// Whether a segment properly crosses a line.
    pub(super) fn crosses(&self, segment: Segment) -> bool {
        self.segments.any_near(segment, 0.0, |number| {
            cross_beyond(segment, self.segments.segments()[number as usize], self.tolerance)
        })
    }

    /// Links with the conflicts between the straight steps, which come first, and those given.
    pub(super) fn links(
        &self,
        links: Vec<Link>,
        straight_count: usize,
        mut conflicts: Vec<[u32; 2]>,
    ) -> Result<Links, LinksError> {
        let (numbers, steps): (Vec<u32>, Vec<Segment>) = links[..straight_count]
            .iter()
            .enumerate()
            .filter_map(|(number, link)| {
                let inner = shorten(self.step(link.ends), MARGIN * self.tolerance)?;
                Some((number as u32, inner))
            })
            .unzip();
        let mean = steps.iter().map(|&step| length(step)).sum::<f64>() / steps.len().max(1) as f64;
        let grid = SegmentGrid::new(steps, mean.max(self.tolerance));
        let mut examined = 0;
        for (index, &step) in grid.segments().iter().enumerate() {
            let ends = links[numbers[index] as usize].ends;
            let is_too_many = grid.any_near(step, self.tolerance, |other| {
                let other = other as usize;
                examined += 1;
                let shares_end = || {
                    let others = links[numbers[other] as usize].ends;
                    ends.iter().any(|end| others.contains(end))
                };
                if other > index
                    && are_near(step, grid.segments()[other], self.tolerance)
                    && !shares_end()
                {
                    conflicts.push([numbers[index], numbers[other]]);
                }
                examined > MAX_PAIRS || conflicts.len() > MAX_CONFLICTS
            });
            if is_too_many {
                return Err(LinksError::TooManyConflicts { limit: MAX_CONFLICTS });
            }
        }
        Links::new(&self.ends, links, &conflicts)
    }
}

/// A straight link.
pub(super) fn straight_link(ends: [End; 2], step: Segment) -> Link {
    Link { ends, via: Vec::new(), length_mm: length(step) }
}

impl Links {
    /// Straight links between ends of different lines at a distance of at most `max_mm` where
    /// `is_permitted` returns true.
    ///
    /// The predicate is called once for each pair, in ascending order, the lower end first.
    /// Steps that cross or touch a line within `tolerance_mm` are left out, and steps that cross or
    /// overlap are conflicts, as in [`Rule::links`](super::Rule::links).
    /// Takes O(n log n) time for n lines, if the number of ends near each other is bounded; of ends
    /// that have more than 32 others near them, at least the 32 nearest are considered.
    pub fn by_predicate<L: AsRef<[Point]>>(
        lines: &[L],
        max_mm: f64,
        tolerance_mm: f64,
        mut is_permitted: impl FnMut(End, End) -> bool,
    ) -> Result<Self, LinksError> {
        check_length("maximum distance", max_mm)?;
        check_length("tolerance", tolerance_mm)?;
        let lines = Lines::new(lines, max_mm, tolerance_mm.min(max_mm / 200.0))?;
        let links = lines.pairs(max_mm).into_iter().filter(|&[a, b]| is_permitted(a, b));
        let links: Vec<Link> = links
            .map(|ends| straight_link(ends, lines.step(ends)))
            .filter(|link| !lines.blocks_step(lines.step(link.ends)))
            .collect();
        let count = links.len();
        lines.links(links, count, Vec::new())
    }
}

/// An error unless a value is a positive number of at most 1e9.
pub(super) fn check_length(name: &'static str, value: f64) -> Result<(), LinksError> {
    if value > 0.0 && value <= 1e9 { Ok(()) } else { Err(LinksError::Length { name, value }) }
}
