//! The heights at which a program prints.

use std::collections::BTreeMap;

use beadwork_base::Control;
use beadwork_gcode::{Event, Motion, Program, TraceError};

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

/// Share of all beads below which a height is a prime line, if a lower one is printed after it.
const STRAY_SHARE: f64 = 0.01;

/// A height at which beads are printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Height {
    /// z of the nozzle, mm.
    pub(super) z_mm: f64,
    /// Length of all beads at this height, mm.
    pub(super) length_mm: f64,
    /// Number of the line with the first of them.
    first_line: usize,
}

/// The heights of the beads of a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Heights {
    /// Heights of level beads, from the bed up.
    pub(super) level: Vec<Height>,
    /// Length of beads that rise or fall, as in a spiral vase, mm.
    pub(super) sloped_mm: f64,
    /// Length of the beads of a prime line before the first layer comment, mm.
    pub(super) prime_mm: f64,
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
        for event in program.trace() {
            let event = event?;
            poll.count(&event)?;
            if let Event::Motion(motion) = event
                && is_bead(&motion)
            {
                groups[usize::from(motion.layer.is_some())].add(&motion);
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
        Ok(Self {
            sloped_mm: layers.sloped_mm,
            below_bed_mm: layers.below_bed_mm(),
            level: layers.level(),
            prime_mm: if is_prime { before.length_mm } else { 0.0 },
        })
    }

    /// Whether a motion is a bead of the part, or a prime line.
    pub(super) fn is_part(&self, motion: &Motion) -> bool {
        is_bead(motion) && (self.prime_mm == 0.0 || motion.layer.is_some())
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
        let height = Height { z_mm: to, length_mm, first_line: motion.line };
        if let Some(same) = self.heights.get_mut(&micrometres(to)) {
            same.length_mm += length_mm;
        } else if self.heights.len() < MAX_HEIGHTS {
            self.heights.insert(micrometres(to), height);
        } else {
            self.sloped_mm += length_mm;
        }
    }

    fn merge(&mut self, other: Self) {
        self.sloped_mm += other.sloped_mm;
        self.length_mm += other.length_mm;
        for (key, height) in other.heights {
            self.heights
                .entry(key)
                .and_modify(|same| {
                    same.length_mm += height.length_mm;
                    same.first_line = same.first_line.min(height.first_line);
                })
                .or_insert(height);
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

    /// The heights from the bed up, without those of stray beads.
    fn level(self) -> Vec<Height> {
        let mut merged: Vec<Height> = Vec::new();
        for height in self.heights.into_values().filter(|height| height.z_mm > 0.0) {
            match merged.last_mut() {
                Some(last) if height.z_mm - last.z_mm < SAME_MM => {
                    let z_mm =
                        if height.length_mm > last.length_mm { height.z_mm } else { last.z_mm };
                    *last = Height {
                        z_mm,
                        length_mm: last.length_mm + height.length_mm,
                        first_line: last.first_line.min(height.first_line),
                    };
                }
                _ => merged.push(height),
            }
        }
        // A prime line is printed first, often higher than the first layer.
        let mut last_line = 0;
        let mut stray = vec![false; merged.len()];
        for (index, height) in merged.iter().enumerate() {
            let comes_before_lower = height.first_line < last_line;
            stray[index] = comes_before_lower && height.length_mm < STRAY_SHARE * self.length_mm;
            last_line = last_line.max(height.first_line);
        }
        let mut stray = stray.into_iter();
        merged.retain(|_| !stray.next().unwrap_or(false));
        merged
    }
}

fn micrometres(z_mm: f64) -> i64 {
    (z_mm * 1e3).round() as i64
}
