//! Beads: sequences of lines that links join.

use thiserror::Error;

use super::end::{End, Point};
use super::links::Links;

/// A line and the direction in which a bead runs along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DirectedLine {
    /// Number of the line.
    pub line: u32,
    /// Whether the bead runs from the last point of the line to its first.
    pub is_reversed: bool,
}

impl DirectedLine {
    /// The line that begins at an end.
    pub fn from(end: End) -> Self {
        Self { line: end.line, is_reversed: end.is_last }
    }

    /// The end at which the bead enters the line.
    pub fn entry(self) -> End {
        End { line: self.line, is_last: self.is_reversed }
    }

    /// The end at which the bead leaves the line.
    pub fn exit(self) -> End {
        self.entry().other()
    }
}

/// A continuous extrusion along lines and the links between them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bead {
    /// The lines in order; at least one.
    pub lines: Vec<DirectedLine>,
    /// Numbers of the links between consecutive lines: one fewer than lines.
    pub links: Vec<u32>,
}

impl Bead {
    /// Position of the first point of the bead, in mm.
    pub fn first(&self, links: &Links) -> Point {
        links.point(self.lines[0].entry())
    }

    /// Position of the last point of the bead, in mm.
    pub fn last(&self, links: &Links) -> Point {
        links.point(self.lines[self.lines.len() - 1].exit())
    }

    /// Turns the bead round.
    pub fn reverse(&mut self) {
        self.lines.reverse();
        self.lines.iter_mut().for_each(|line| line.is_reversed = !line.is_reversed);
        self.links.reverse();
    }

    /// The points of the bead in order, in mm, including those of its links.
    ///
    /// `lines` must be those that `links` was built from.
    /// A point that coincides with the point before it is left out.
    pub fn points<L: AsRef<[Point]>>(&self, lines: &[L], links: &Links) -> Vec<Point> {
        let mut points: Vec<Point> = Vec::new();
        for (index, directed) in self.lines.iter().enumerate() {
            if let Some(&number) = index.checked_sub(1).and_then(|before| self.links.get(before)) {
                let link = links.link(number);
                extend(&mut points, &link.via, link.ends[1] != directed.entry());
            }
            extend(&mut points, lines[directed.line as usize].as_ref(), directed.is_reversed);
        }
        points.dedup();
        points
    }
}

fn extend(points: &mut Vec<Point>, more: &[Point], is_reversed: bool) {
    if is_reversed {
        points.extend(more.iter().rev());
    } else {
        points.extend(more);
    }
}

/// Faults of beads that do not contain each line once, joined by permitted links.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum BeadsError {
    /// A line does not exist.
    #[error("line {line}: does not exist")]
    NoLine {
        /// Number of the line.
        line: u32,
    },
    /// A line occurs more than once.
    #[error("line {line}: occurs more than once")]
    Repeated {
        /// Number of the line.
        line: u32,
    },
    /// A line does not occur.
    #[error("line {line}: does not occur")]
    Missing {
        /// Number of the line.
        line: u32,
    },
    /// A bead has no lines, or not one link between each two.
    #[error("bead {bead}: expected at least one line, and one link fewer than lines")]
    Length {
        /// Number of the bead.
        bead: usize,
    },
    /// A link does not exist or does not join the two lines.
    #[error("bead {bead}: link {link} does not join lines {} and {}", lines[0], lines[1])]
    Link {
        /// Number of the bead.
        bead: usize,
        /// Number of the link.
        link: u32,
        /// Numbers of the lines before and after the link.
        lines: [u32; 2],
    },
    /// Two links are in use that exclude each other.
    #[error("links {} and {} cross", .0[0], .0[1])]
    Conflict([u32; 2]),
}

/// Checks that beads contain each line once and use permitted links only, no two of which exclude
/// each other.
pub fn verify(links: &Links, beads: &[Bead]) -> Result<(), BeadsError> {
    let mut seen = vec![false; links.line_count()];
    let mut used = vec![false; links.all().len()];
    for (number, bead) in beads.iter().enumerate() {
        if bead.lines.len() != bead.links.len() + 1 {
            return Err(BeadsError::Length { bead: number });
        }
        for &DirectedLine { line, .. } in &bead.lines {
            let seen = seen.get_mut(line as usize).ok_or(BeadsError::NoLine { line })?;
            if std::mem::replace(seen, true) {
                return Err(BeadsError::Repeated { line });
            }
        }
        for (pair, &link) in bead.lines.windows(2).zip(&bead.links) {
            let mut ends = [pair[0].exit(), pair[1].entry()];
            ends.sort_unstable();
            if links.all().get(link as usize).is_none_or(|link| link.ends != ends) {
                let lines = [pair[0].line, pair[1].line];
                return Err(BeadsError::Link { bead: number, link, lines });
            }
            used[link as usize] = true;
        }
    }
    if let Some(line) = seen.iter().position(|&seen| !seen) {
        return Err(BeadsError::Missing { line: line as u32 });
    }
    let is_used = |link: u32| used[link as usize];
    match links.conflicts().iter().find(|[a, b]| is_used(*a) && is_used(*b)) {
        Some(&conflict) => Err(BeadsError::Conflict(conflict)),
        None => Ok(()),
    }
}

/// The beads that a set of links makes of lines.
///
/// The links must leave at most one at each end and close no cycle.
/// Each bead begins at its end with the lower index; beads are sorted by that end.
pub(super) fn beads_of(links: &Links, chosen: impl Iterator<Item = u32>) -> Vec<Bead> {
    let mut link_at = vec![None; links.points().len()];
    for link in chosen {
        for end in links.link(link).ends {
            link_at[end.index()] = Some(link);
        }
    }
    let mut seen = vec![false; links.line_count()];
    let mut beads = Vec::new();
    for index in 0..link_at.len() {
        let mut entry = End::from_index(index);
        if link_at[index].is_some() || seen[entry.line as usize] {
            continue;
        }
        let mut bead = Bead::default();
        loop {
            seen[entry.line as usize] = true;
            bead.lines.push(DirectedLine::from(entry));
            let exit = entry.other();
            let Some(link) = link_at[exit.index()] else { break };
            bead.links.push(link);
            entry = links.link(link).other(exit);
        }
        beads.push(bead);
    }
    beads
}
