//! The heights at which a program prints.

use std::collections::BTreeMap;

use beadwork_base::Control;
use beadwork_gcode::{Event, Feature, Motion, Program, TraceError};

use super::bead::is_bead;
use super::poll::Poll;

/// Maximum number of heights that are kept apart; a program with more has no layers.
const MAX_HEIGHTS: usize = 1 << 16;

/// Heights closer than this are one, in mm: well below any layer.
const SAME_MM: f64 = 0.02;

/// Beads before the first layer comment are a prime line if they are not higher, in mm.
const PRIME_HEIGHT_MM: f64 = 1.0;

/// Length of beads before the first layer comment relative to that of all others, above which they
/// are a first layer without a comment if their height fits.
const PRIME_SHARE: f64 = 0.5;

/// Tolerance of the height of a first layer without a comment, in layers.
const FIRST_LAYER: f64 = 0.1;

/// Share of all beads below which a height is a prime line, if all lower ones are printed later.
const STRAY_SHARE: f64 = 0.25;

/// Maximum number of heights of prime lines; more belong to an object that is printed before
/// another.
const MAX_STRAYS: usize = 2;

/// A height at which beads are printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Height {
    /// z of the nozzle, mm.
    pub(super) z_mm: f64,
    /// Length of all beads at this height, mm.
    pub(super) length_mm: f64,
    /// Numbers of the lines with the first and the last of them.
    lines: [usize; 2],
}

impl Height {
    /// Adds beads at the same height.
    fn add(&mut self, other: &Self) {
        self.length_mm += other.length_mm;
        let ([first, last], [other_first, other_last]) = (self.lines, other.lines);
        self.lines = [first.min(other_first), last.max(other_last)];
    }
}

/// The heights of the beads of a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Heights {
    /// Heights of level beads, from the bed up.
    pub(super) level: Vec<Height>,
    /// Length of beads that rise or fall, as in a spiral vase, mm.
    pub(super) sloped_mm: f64,
    /// Length of the beads of prime lines, mm.
    pub(super) prime_mm: f64,
    /// Height of the highest bead, mm.
    pub(super) top_mm: f64,
    /// Height of the lowest bead of a support or a raft, mm; infinite without one.
    pub(super) support_mm: f64,
    /// Whether beads before the first layer comment are prime lines.
    needs_layer: bool,
    /// Number of the last line of prime lines that have no comments.
    prime_end_line: usize,
    /// Length of the beads at the bed's height or below, mm.
    pub(super) below_bed_mm: f64,
}

/// An extrusion move whose height changes less counts as level, in mm.
const LEVEL_MM: f64 = 1e-4;

impl Heights {
    /// Collects the heights of all beads.
    /// Linear in the program's length; reports no progress.
    pub(super) fn of(program: &Program, control: &Control<'_>) -> Result<Self, TraceError> {
        let control = Control { progress: None, ..*control };
        // Beads before the first layer comment, and all others.
        let mut groups = [Group::default(), Group::default()];
        let mut poll = Poll::new(&control, 0, program.lines.len());
        let mut support_mm = f64::INFINITY;
        for event in program.trace() {
            let event = event?;
            poll.count(&event)?;
            let Event::Motion(motion) = event else { continue };
            if is_bead(&motion) {
                groups[usize::from(motion.layer.is_some())].add(&motion);
            } else if motion.is_extrusion() && motion.feature == Feature::Support {
                support_mm = support_mm.min(motion.to_mm[2]);
            }
        }
        let [before, mut layers] = groups;
        let is_short = before.length_mm < PRIME_SHARE * layers.length_mm;
        let is_prime = before.length_mm > 0.0
            && layers.length_mm > 0.0
            && before.top_mm <= PRIME_HEIGHT_MM
            && (is_short || !before.is_layer_below(&layers));
        if !is_prime {
            layers.merge(before.clone());
        }
        let (level, strays) = layers.level();
        Ok(Self {
            sloped_mm: layers.sloped_mm,
            below_bed_mm: layers.below_bed_mm(),
            top_mm: layers.top_mm,
            support_mm,
            needs_layer: is_prime,
            prime_mm: if is_prime { before.length_mm } else { 0.0 }
                + strays.iter().map(|stray| stray.length_mm).sum::<f64>(),
            prime_end_line: strays.iter().map(|stray| stray.lines[1]).max().unwrap_or(0),
            level,
        })
    }

    /// Whether a motion is a bead of the part, and not of a prime line.
    pub(super) fn is_part(&self, motion: &Motion) -> bool {
        is_bead(motion)
            && motion.line > self.prime_end_line
            && (!self.needs_layer || motion.layer.is_some())
    }
}

/// Beads of some kind.
#[derive(Clone, Debug, Default)]
struct Group {
    /// By height in µm.
    heights: BTreeMap<i64, Height>,
    sloped_mm: f64,
    length_mm: f64,
    top_mm: f64,
}

impl Group {
    fn add(&mut self, motion: &Motion) {
        let ([.., from], [.., to]) = (motion.from_mm, motion.to_mm);
        let length_mm = motion.length_mm();
        self.length_mm += length_mm;
        self.top_mm = self.top_mm.max(from).max(to);
        if (from - to).abs() > LEVEL_MM {
            self.sloped_mm += length_mm;
            return;
        }
        let height = Height { z_mm: to, length_mm, lines: [motion.line; 2] };
        if let Some(same) = self.heights.get_mut(&micrometres(to)) {
            same.add(&height);
        } else if self.heights.len() < MAX_HEIGHTS {
            self.heights.insert(micrometres(to), height);
        } else {
            self.sloped_mm += length_mm;
        }
    }

    fn merge(&mut self, other: Self) {
        self.sloped_mm += other.sloped_mm;
        self.length_mm += other.length_mm;
        self.top_mm = self.top_mm.max(other.top_mm);
        for (key, height) in other.heights {
            self.heights.entry(key).and_modify(|same| same.add(&height)).or_insert(height);
        }
    }

    fn below_bed_mm(&self) -> f64 {
        self.heights.values().filter(|height| height.z_mm <= 0.0).map(|low| low.length_mm).sum()
    }

    /// Whether these beads lie where the layer below the first one of `layers` would.
    fn is_layer_below(&self, layers: &Self) -> bool {
        let mut tops = layers.heights.values().map(|height| height.z_mm);
        let Some(first) = tops.next() else { return true };
        // With a single layer above, there is nothing to compare.
        let Some(second) = tops.next() else { return true };
        let thickness = second - first;
        let longest = self.heights.values().max_by(|a, b| a.length_mm.total_cmp(&b.length_mm));
        longest
            .is_none_or(|height| (first - thickness - height.z_mm).abs() <= FIRST_LAYER * thickness)
    }

    /// The heights from the bed up, and those of prime lines that have no comments.
    fn level(&self) -> (Vec<Height>, Vec<Height>) {
        let mut merged: Vec<Height> = Vec::new();
        for height in self.heights.values().filter(|height| height.z_mm > 0.0) {
            match merged.last_mut() {
                Some(last) if height.z_mm - last.z_mm < SAME_MM => {
                    if height.length_mm > last.length_mm {
                        last.z_mm = height.z_mm;
                    }
                    last.add(height);
                }
                _ => merged.push(*height),
            }
        }
        // A prime line is printed before the first layer, often higher.
        let mut first_line_below = None;
        let is_stray = |height: &Height| {
            let [first, last] = height.lines;
            let is_before = first_line_below.is_some_and(|line| last < line);
            first_line_below = Some(first_line_below.map_or(first, |line: usize| line.min(first)));
            is_before
                && height.z_mm <= PRIME_HEIGHT_MM
                && height.length_mm < STRAY_SHARE * self.length_mm
        };
        let (strays, level): (Vec<_>, Vec<_>) = merged.iter().copied().partition(is_stray);
        let end = strays.iter().map(|stray| stray.lines[1]).max();
        // The lowest layer follows; otherwise the heights are those of an object.
        let begin = level.iter().map(|height| height.lines[0]).min();
        let is_lowest_first = level.first().map(|height| height.lines[0]) == begin;
        let is_prime = strays.len() <= MAX_STRAYS && is_lowest_first && end < begin;
        if is_prime { (level, strays) } else { (merged, Vec::new()) }
    }
}

fn micrometres(z_mm: f64) -> i64 {
    (z_mm * 1e3).round() as i64
}
