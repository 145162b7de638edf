//! The links that are permitted between the ends of lines.

use thiserror::Error;

use super::end::{End, Link, Point};
use crate::lists::Lists;

/// The ends of lines, the links permitted between them, and which links exclude each other.
///
/// - A link joins ends of two different lines, and there is at most one link between two ends.
/// - Links are sorted by their ends.
/// - A *conflict* is a pair of links of which only one may be used, because they cross.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Links {
    points: Vec<Point>,
    all: Vec<Link>,
    conflicts: Vec<[u32; 2]>,
    at: Lists,
    conflicts_of: Lists,
}

/// Invalid lines, rings, links or conflicts.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LinksError {
    /// A line has no points.
    #[error("line {line}: no points")]
    EmptyLine {
        /// Number of the line.
        line: usize,
    },
    /// A coordinate of a line is not finite, or too large.
    #[error("line {line}: coordinates must be numbers between -1e9 and 1e9 mm")]
    LinePoint {
        /// Number of the line.
        line: usize,
    },
    /// A coordinate of a ring is not finite, or too large.
    #[error("ring {ring}: coordinates must be numbers between -1e9 and 1e9 mm")]
    RingPoint {
        /// Number of the ring.
        ring: usize,
    },
    /// A length is not a positive number, or too large.
    #[error("{name} {value}: expected a positive number up to 1e9")]
    Length {
        /// What the length is.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// More lines than [`Links::MAX_LINES`].
    #[error("{count} lines: at most {} are supported", Links::MAX_LINES)]
    TooManyLines {
        /// Number of lines.
        count: usize,
    },
    /// More pairs of crossing steps than the limit.
    #[error(
        "lines end too close together: more than {limit} pairs of steps cross; remove duplicates"
    )]
    TooManyConflicts {
        /// Maximum number of conflicts.
        limit: usize,
    },
    /// A link joins a line to itself or to a line that does not exist, or its length or a point is
    /// not a number.
    #[error("link {link}: expected ends of two different lines, and finite points and length")]
    Link {
        /// Number of the link.
        link: usize,
    },
    /// Two links join the same ends.
    #[error("link {link}: its ends already have a link")]
    DuplicateLink {
        /// Number of the link.
        link: usize,
    },
    /// A conflict refers to a link that does not exist, or to one link twice.
    #[error("conflict {conflict}: expected the numbers of two different links")]
    Conflict {
        /// Number of the conflict.
        conflict: usize,
    },
}

impl Links {
    /// Maximum number of lines.
    pub const MAX_LINES: usize = 1 << 24;

    /// Links of a caller's own making.
    ///
    /// `ends` are the first and the last point of each line, in mm.
    /// `conflicts` are pairs of numbers of links; duplicates are allowed.
    /// The ends of each link are put in order, and links are sorted and renumbered.
    pub fn new(
        ends: &[[Point; 2]],
        mut links: Vec<Link>,
        conflicts: &[[u32; 2]],
    ) -> Result<Self, LinksError> {
        if ends.len() > Self::MAX_LINES {
            return Err(LinksError::TooManyLines { count: ends.len() });
        }
        if let Some(line) = ends.iter().position(|pair| !pair.iter().all(|&end| is_valid(end))) {
            return Err(LinksError::LinePoint { line });
        }
        for (index, link) in links.iter_mut().enumerate() {
            if link.ends[0] > link.ends[1] {
                link.ends.reverse();
                link.via.reverse();
            }
            let [a, b] = link.ends.map(|end| end.line as usize);
            let is_finite = link.length_mm >= 0.0
                && link.length_mm.is_finite()
                && link.via.iter().all(|&point| is_valid(point));
            if a == b || a.max(b) >= ends.len() || !is_finite {
                return Err(LinksError::Link { link: index });
            }
        }
        let is_wrong = |&[a, b]: &[u32; 2]| a == b || a.max(b) as usize >= links.len();
        if let Some(conflict) = conflicts.iter().position(is_wrong) {
            return Err(LinksError::Conflict { conflict });
        }
        let mut order: Vec<u32> = (0..links.len() as u32).collect();
        order.sort_by_key(|&link| links[link as usize].ends);
        let ends_of = |link: u32| links[link as usize].ends;
        if let Some(pair) = order.windows(2).find(|pair| ends_of(pair[0]) == ends_of(pair[1])) {
            return Err(LinksError::DuplicateLink { link: pair[1] as usize });
        }
        let mut numbers = vec![0; links.len()];
        for (number, &link) in order.iter().enumerate() {
            numbers[link as usize] = number as u32;
        }
        links.sort_by_key(|link| link.ends);
        let mut conflicts: Vec<[u32; 2]> = conflicts
            .iter()
            .map(|pair| {
                let [a, b] = pair.map(|link| numbers[link as usize]);
                [a.min(b), a.max(b)]
            })
            .collect();
        conflicts.sort_unstable();
        conflicts.dedup();
        Ok(Self::from_sorted(ends.as_flattened().to_vec(), links, conflicts))
    }

    /// Links that are valid, sorted and without duplicates; conflicts too.
    fn from_sorted(points: Vec<Point>, links: Vec<Link>, conflicts: Vec<[u32; 2]>) -> Self {
        let at_ends = links
            .iter()
            .enumerate()
            .flat_map(|(number, link)| link.ends.map(|end| (end.index(), number as u32)));
        let at = Lists::new(points.len(), at_ends);
        let of_links = conflicts.iter().flat_map(|&[a, b]| [(a as usize, b), (b as usize, a)]);
        let conflicts_of = Lists::new(links.len(), of_links);
        Self { points, all: links, conflicts, at, conflicts_of }
    }

    /// Number of lines.
    pub fn line_count(&self) -> usize {
        self.points.len() / 2
    }

    /// Position of an end in mm.
    #[inline]
    pub fn point(&self, end: End) -> Point {
        self.points[end.index()]
    }

    /// Positions of all ends in mm, by [`End::index`].
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// All links.
    pub fn all(&self) -> &[Link] {
        &self.all
    }

    /// The link with a number.
    #[inline]
    pub fn link(&self, number: u32) -> &Link {
        &self.all[number as usize]
    }

    /// Numbers of the links at an end, in ascending order.
    #[inline]
    pub fn at(&self, end: End) -> &[u32] {
        self.at.list(end.index())
    }

    /// Number of the link between two ends; `None` if they have none.
    pub fn between(&self, a: End, b: End) -> Option<u32> {
        self.at(a).iter().copied().find(|&link| self.link(link).other(a) == b)
    }

    /// Pairs of links of which only one may be used; lower number first, sorted.
    pub fn conflicts(&self) -> &[[u32; 2]] {
        &self.conflicts
    }

    /// Numbers of the links that must not be used along with a link.
    #[inline]
    pub fn conflicts_of(&self, link: u32) -> &[u32] {
        self.conflicts_of.list(link as usize)
    }
}

/// Whether the coordinates of a point are numbers in the supported range.
pub(super) fn is_valid(point: Point) -> bool {
    point.iter().all(|value| value.abs() <= 1e9)
}
