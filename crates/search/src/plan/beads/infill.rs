//! Links the infill lines of a region to chains.

use beadwork_base::Control;
use beadwork_part::toolpath::Infill;

use crate::Stop;
use crate::join::{self, Attachment};
use crate::link::{self, DirectedLine, End, Link, Links, LinksError, Rule};

/// Number of line ends that a loop may be offered; more of them make the search for the fewest
/// beads slow, because the loop then touches all of the region.
const MAX_OFFERED: usize = 8;

/// A polyline in mm.
type Polyline = Vec<[f64; 2]>;

/// The lines of an infill region, and how they may be linked.
pub(super) struct Region<'a> {
    infill: &'a Infill,
    links: Links,
    /// Both ends of each line.
    ends: Vec<[[f64; 2]; 2]>,
    /// The line ends within reach of loops, sorted by line; empty if nothing is joined.
    attachments: Vec<Attachment>,
}

/// Which line ends may be left free, so that they can be joined to a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Offer {
    /// None: the fewest beads of infill alone.
    Nothing,
    /// The first few that are near each loop, in the order of the lines.
    First,
    /// The last few.
    Last,
}

impl Offer {
    pub(super) const ALL: [Self; 3] = [Self::Nothing, Self::First, Self::Last];
}

/// Chains, and what is proven about their number.
pub(super) struct Linked {
    pub(super) chains: Vec<Polyline>,
    /// Proven lower bound on the number of chains, if only they are counted.
    pub(super) bound: usize,
    pub(super) stop: Stop,
}

impl<'a> Region<'a> {
    pub(super) fn new(infill: &'a Infill, rule: &Rule) -> Result<Self, LinksError> {
        let rings: Vec<Polyline> = infill.region.rings().cloned().collect();
        // Without lines there is no spacing.
        let links = if infill.lines.is_empty() {
            Links::default()
        } else {
            rule.links(&infill.lines, &rings, infill.spacing_mm)?
        };
        let ends = links.points().chunks_exact(2).map(|ends| [ends[0], ends[1]]).collect();
        Ok(Self { infill, links, ends, attachments: Vec::new() })
    }

    /// Finds out which line ends are within reach of which loops.
    pub(super) fn find_loops(&mut self, loops: &join::Loops<'_>) {
        self.attachments = loops.attachments(&self.ends);
    }

    /// Links the lines to few beads.
    ///
    /// A line end that is left free saves a lift just as a link does if it is joined to a loop that
    /// no other end is joined to.
    /// So each loop is added as a line with a single end, which may be linked to the line ends
    /// offered; the fewest beads of all lines are found; and the lines of the loops are taken off
    /// again.
    pub(super) fn linked(
        &self,
        offer: Offer,
        settings: &link::Settings,
        control: &Control<'_>,
    ) -> Result<Linked, LinksError> {
        let lines = &self.infill.lines;
        if offer == Offer::Nothing || self.attachments.is_empty() {
            let link::Outcome { beads, bound, stop, .. } =
                link::solve(&self.links, settings, control);
            let chains = beads.iter().map(|bead| bead.points(lines, &self.links)).collect();
            return Ok(Linked { chains, bound, stop });
        }
        let joint = self.with_loops(offer)?;
        let linked = link::solve(&joint, settings, control);
        let is_loop = |line: Option<&DirectedLine>| {
            line.is_some_and(|line| line.line as usize >= lines.len())
        };
        let mut chains = Vec::new();
        for mut bead in linked.beads {
            // The lines of loops have one end only, so they are the first or the last of a bead.
            if is_loop(bead.lines.last()) {
                bead.lines.pop();
                bead.links.pop();
            }
            if is_loop(bead.lines.first()) {
                bead.lines.remove(0);
                bead.links.drain(..bead.links.len().min(1));
            }
            if !bead.lines.is_empty() {
                chains.push(bead.points(lines, &joint));
            }
        }
        Ok(Linked { chains, bound: 0, stop: linked.stop })
    }

    /// The links, with additional lines for loops.
    fn with_loops(&self, offer: Offer) -> Result<Links, LinksError> {
        let mut ends = self.ends.clone();
        let mut links = self.links.all().to_vec();
        let loops = self.attachments.iter().map(|attachment| attachment.ring + 1).max();
        for number in 0..loops.unwrap_or(0) {
            let near: Vec<&Attachment> =
                self.attachments.iter().filter(|attachment| attachment.ring == number).collect();
            let offered = match offer {
                Offer::Last => &near[near.len().saturating_sub(MAX_OFFERED)..],
                _ => &near[..near.len().min(MAX_OFFERED)],
            };
            let Some(first) = offered.first() else { continue };
            let of_loop = End { line: ends.len() as u32, is_last: false };
            ends.push([self.ends[first.chain][0]; 2]);
            links.extend(offered.iter().map(|attachment| Link {
                ends: [End { line: attachment.chain as u32, is_last: attachment.is_last }, of_loop],
                via: Vec::new(),
                length_mm: attachment.length_mm,
            }));
        }
        Links::new(&ends, links, self.links.conflicts())
    }
}
