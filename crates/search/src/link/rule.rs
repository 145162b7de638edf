//! The rule of which ends may be linked.

use std::ops::Range;

use super::end::{End, Link, Point};
use super::links::{Links, LinksError, is_valid};
use super::region::{Region, edges};
use super::straight::{Lines, check_length, straight_link};
use crate::segment::{length, project};

/// Maximum number of ends at one point of a boundary that are linked to those at the next.
const MAX_AT_POINT: usize = 8;

/// Which ends may be linked: by how long a straight step within the infill region, and by how long
/// a step along its boundary.
///
/// Construct it with `..Rule::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Maximum length of a straight step, as a multiple of the spacing of the lines.
    pub straight: f64,
    /// Maximum length of a step along the boundary, as a multiple of the spacing.
    pub boundary: f64,
    /// Distance in mm up to which points count as touching: ends and the boundary, steps and lines.
    /// At most a hundredth of the spacing is used.
    pub tolerance_mm: f64,
}

impl Default for Rule {
    /// 2 times the spacing straight, 8 times along the boundary, a tolerance of 0.002 mm.
    fn default() -> Self {
        Self { straight: 2.0, boundary: 8.0, tolerance_mm: 0.002 }
    }
}

impl Rule {
    /// The permitted links between lines in a region.
    ///
    /// `lines` are polylines that end at the boundary of the region or within it, `rings` the
    /// boundary: closed polygonal lines, whose last corner is joined to the first, in any
    /// direction.
    /// A point belongs to the region if an odd number of rings enclose it.
    /// Lengths are in mm.
    ///
    /// Two ends of different lines may be linked by
    /// - a straight step that stays within the region, boundary included, and neither crosses nor
    ///   touches a line except at its own ends;
    /// - a step along a ring, if no other line ends between them and it crosses no line.
    ///
    /// The straight step is preferred: it is the shorter one.
    /// Straight steps that cross or overlap each other are conflicts, and so are steps along the
    /// same piece of a ring.
    ///
    /// Takes O(n log n) time for n lines and corners, if the number of ends near each other is
    /// bounded: of ends that have more than 32 others near them, at minimum the 32 nearest are
    /// considered, and of those at one point of a ring 8.
    pub fn links<L: AsRef<[Point]>>(
        &self,
        lines: &[L],
        rings: &[Vec<Point>],
        spacing_mm: f64,
    ) -> Result<Links, LinksError> {
        check_length("spacing", spacing_mm)?;
        check_length("tolerance", self.tolerance_mm)?;
        check_length("straight limit", self.straight)?;
        check_length("boundary limit", self.boundary)?;
        if let Some(ring) =
            rings.iter().position(|ring| !ring.iter().all(|&corner| is_valid(corner)))
        {
            return Err(LinksError::RingPoint { ring });
        }
        let tolerance = self.tolerance_mm.min(spacing_mm / 100.0);
        // Lengths that are a multiple of the spacing but for rounding are within the limits.
        let limit = |multiple: f64| multiple * spacing_mm * (1.0 + 1e-6);
        let lines = Lines::new(lines, 2.0 * spacing_mm, tolerance)?;
        let region = Region::new(rings, 2.0 * spacing_mm);

        let mut links: Vec<Link> = lines
            .pairs(limit(self.straight))
            .into_iter()
            .filter(|&ends| {
                let step = lines.step(ends);
                region.contains_segment(step, tolerance) && !lines.blocks_step(step)
            })
            .map(|ends| straight_link(ends, lines.step(ends)))
            .collect();
        let straight_count = links.len();

        let arcs = boundary_links(&lines, rings, &region, limit(self.boundary), tolerance);
        let mut conflicts = Vec::new();
        let mut by_ends: Vec<(usize, Link)> = arcs
            .into_iter()
            .enumerate()
            .flat_map(|(gap, arcs)| arcs.into_iter().map(move |arc| (gap, arc)))
            .collect();
        let is_longer = |a: &Link, b: &Link| a.length_mm.total_cmp(&b.length_mm);
        by_ends.sort_by(|a, b| a.1.ends.cmp(&b.1.ends).then(is_longer(&a.1, &b.1)));
        by_ends.dedup_by(|later, first| later.1.ends == first.1.ends);
        let is_straight = |link: &Link| {
            links[..straight_count].binary_search_by_key(&link.ends, |link| link.ends).is_ok()
        };
        by_ends.retain(|(_, link)| !is_straight(link));
        by_ends.sort_by_key(|&(gap, _)| gap);
        for group in by_ends.chunk_by(|a, b| a.0 == b.0) {
            let numbers = links.len() as u32..(links.len() + group.len()) as u32;
            conflicts
                .extend(numbers.clone().flat_map(|a| (a + 1..numbers.end).map(move |b| [a, b])));
            links.extend(group.iter().map(|(_, link)| link.clone()));
        }
        lines.links(links, straight_count, conflicts)
    }
}

/// An end at a position along a ring in mm.
type Mark = (f64, End);

/// For each piece of a ring between neighbouring ends, the links along it.
fn boundary_links(
    lines: &Lines,
    rings: &[Vec<Point>],
    region: &Region,
    limit: f64,
    tolerance: f64,
) -> Vec<Vec<Link>> {
    let rulers: Vec<Ruler<'_>> = rings.iter().map(|ring| Ruler::new(ring)).collect();
    let mut ring_of = Vec::new();
    for (number, ring) in rings.iter().enumerate() {
        ring_of.extend((0..ring.len()).map(|edge| (number, edge)));
    }
    let mut marks: Vec<Vec<Mark>> = vec![Vec::new(); rings.len()];
    for (index, &point) in lines.ends.as_flattened().iter().enumerate() {
        let mut found: Vec<(usize, f64, f64)> = Vec::new();
        region.edges().any_near([point; 2], tolerance, |number| {
            let (share, distance) = project(point, region.edges().segments()[number as usize]);
            if distance <= tolerance {
                let (ring, edge) = ring_of[number as usize];
                found.push((ring, rulers[ring].position(edge, share), distance));
            }
            false
        });
        found.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for group in found.chunk_by(|a, b| a.0 == b.0) {
            let ring = group[0].0;
            for position in rulers[ring].distinct(group, 4.0 * tolerance) {
                marks[ring].push((position, End::from_index(index)));
            }
        }
    }
    let mut links = Vec::new();
    for (ruler, mut marks) in rulers.iter().zip(marks) {
        marks.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let groups = ruler.groups(&mut marks, tolerance);
        if groups.len() < 2 {
            continue;
        }
        for (number, group) in groups.iter().enumerate() {
            let next = &groups[(number + 1) % groups.len()];
            let from = &marks[group.end.saturating_sub(MAX_AT_POINT).max(group.start)..group.end];
            let to = &marks[next.start..next.end.min(next.start + MAX_AT_POINT)];
            let pairs = from.iter().flat_map(|&from| to.iter().map(move |&to| (from, to)));
            links.push(
                pairs
                    .filter(|(from, to)| from.1.line != to.1.line)
                    .filter_map(|(from, to)| ruler.arc(lines, from, to, limit, tolerance))
                    .collect(),
            );
        }
    }
    links
}

/// A ring with the positions of its corners along it.
struct Ruler<'a> {
    ring: &'a [Point],
    /// Position of each corner, and the length of the ring.
    corners: Vec<f64>,
}

impl<'a> Ruler<'a> {
    fn new(ring: &'a [Point]) -> Self {
        let mut corners = vec![0.0];
        let mut position = 0.0;
        for edge in edges(ring) {
            position += length(edge);
            corners.push(position);
        }
        Self { ring, corners }
    }

    fn length(&self) -> f64 {
        self.corners[self.ring.len()]
    }

    /// Position of a point of an edge.
    fn position(&self, edge: usize, share: f64) -> f64 {
        self.corners[edge] + share * (self.corners[edge + 1] - self.corners[edge])
    }

    /// Of positions in ascending order, with the distances of an end from them, one for each group
    /// of positions that are not more than `gap` apart: the one with the minimum distance.
    fn distinct(&self, found: &[(usize, f64, f64)], gap: f64) -> Vec<f64> {
        let mut kept: Vec<(f64, f64, f64)> = Vec::new();
        for &(_, position, distance) in found {
            match kept.last_mut() {
                Some((last, best, minimum)) if position - *last <= gap => {
                    *last = position;
                    if distance < *minimum {
                        (*best, *minimum) = (position, distance);
                    }
                }
                _ => kept.push((position, position, distance)),
            }
        }
        if let [first, .., last] = kept[..]
            && found[0].1 + self.length() - last.0 <= gap
        {
            if first.2 <= last.2 {
                kept.pop();
            } else {
                kept.swap_remove(0);
            }
        }
        kept.into_iter().map(|(_, best, _)| best).collect()
    }

    /// Ranges of marks that are at most `gap` apart.
    /// Marks are rotated so that no range passes their end.
    fn groups(&self, marks: &mut [Mark], gap: f64) -> Vec<Range<usize>> {
        let count = marks.len();
        let is_start = |marks: &[Mark], index: usize| {
            let before =
                if index == 0 { marks[count - 1].0 - self.length() } else { marks[index - 1].0 };
            marks[index].0 - before > gap
        };
        let Some(first) = (0..count).find(|&index| is_start(marks, index)) else {
            return Vec::new();
        };
        let starts: Vec<usize> = (first..count).filter(|&index| is_start(marks, index)).collect();
        marks.rotate_left(first);
        let ends = starts[1..].iter().copied().chain([count + first]);
        starts.iter().zip(ends).map(|(start, end)| start - first..end - first).collect()
    }

    /// The link along the ring from one mark on to another, if it is not too long and crosses no
    /// line.
    fn arc(&self, lines: &Lines, from: Mark, to: Mark, limit: f64, tolerance: f64) -> Option<Link> {
        let end = if to.0 > from.0 { to.0 } else { to.0 + self.length() };
        // Corners are left out that coincide with an end, and corners at the end of a ring whose
        // last point repeats its first.
        if end - from.0 > limit + 2.0 * tolerance {
            return None;
        }
        let first = self.corners.partition_point(|&corner| corner <= from.0 + tolerance);
        let count = self.ring.len();
        let mut points = vec![lines.step([from.1; 2])[0]];
        for index in first.. {
            let corner = self.corners[index % count] + (index / count) as f64 * self.length();
            if corner >= end - tolerance {
                break;
            }
            points.push(self.ring[index % count]);
        }
        points.push(lines.step([to.1; 2])[0]);
        points.dedup();
        let segments = || points.windows(2).map(|pair| [pair[0], pair[1]]);
        let length_mm: f64 = segments().map(length).sum();
        if length_mm > limit || segments().any(|segment| lines.crosses(segment)) {
            return None;
        }
        let mut ends = [from.1, to.1];
        let mut via = points;
        via.remove(0);
        via.pop();
        if ends[0] > ends[1] {
            ends.reverse();
            via.reverse();
        }
        Some(Link { ends, via, length_mm })
    }
}
