//! The motions that a layer of beads should consist of.

use beadwork_gcode::Feature;

use crate::print::settings::Settings;
use crate::{Bead, BeadLayer, Frame};

/// Positions have this many units per mm.
const UNITS_PER_MM: f64 = 1000.0;

/// Moves with less filament are merged with their neighbours, in mm.
const MIN_FILAMENT_MM: f64 = 2e-5;

/// Slack in mm where a loop is almost too long or too open to be small: rounding of sums.
const SLACK_MM: f64 = 1e-6;

/// A motion of a bead, after moves that are too short were merged with their neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlannedMotion {
    /// Index of the bead in its layer.
    pub(super) bead: usize,
    pub(super) tool: u8,
    /// Both ends in mm, as rounded for a file.
    pub(super) from_mm: [f64; 2],
    pub(super) to_mm: [f64; 2],
    pub(super) filament_mm: f64,
    /// The widest of the merged moves.
    pub(super) width_mm: f64,
    /// Sum of length times width of the merged moves.
    pub(super) area_mm2: f64,
    pub(super) feature: Feature,
    pub(super) max_mm_s: f64,
}

/// The motions of a layer, in order, and the number of beads that are too short to be printed.
pub(super) fn planned_motions(
    layer: &BeadLayer,
    frame: &Frame,
    settings: &Settings,
) -> (Vec<PlannedMotion>, usize) {
    let mut motions = Vec::new();
    let mut dropped = 0;
    for (index, bead) in layer.beads.iter().enumerate() {
        let count = motions.len();
        add_bead(&mut motions, bead, index, layer.number, frame, settings);
        dropped += usize::from(motions.len() == count);
    }
    (motions, dropped)
}

/// Appends the motions of a bead.
fn add_bead(
    motions: &mut Vec<PlannedMotion>,
    bead: &Bead,
    index: usize,
    layer: usize,
    frame: &Frame,
    settings: &Settings,
) {
    let first = motions.len();
    let tool = &settings.tools[usize::from(bead.tool)];
    let mut start_mm = bead.start_mm;
    // The moves since the last motion, as one motion.
    let mut open: Option<PlannedMotion> = None;
    for moves in bead.moves.chunk_by(|a, b| a.feature == b.feature) {
        let ends: Vec<_> =
            std::iter::once(start_mm).chain(moves.iter().map(|step| step.to_mm)).collect();
        let (feature, last) = (moves[0].feature, &moves[moves.len() - 1]);
        let length_mm: f64 = ends.windows(2).map(|pair| distance_mm(pair[0], pair[1])).sum();
        let is_small = matches!(feature, Feature::OuterWall | Feature::InnerWall)
            && distance_mm(start_mm, last.to_mm) <= last.width_mm - SLACK_MM
            && length_mm < settings.process.small_perimeter_below_mm - SLACK_MM;
        for (step, pair) in moves.iter().zip(ends.windows(2)) {
            let length_mm = distance_mm(pair[0], pair[1]);
            let section_mm2 = settings.process.section_mm2(step.width_mm, frame.layer_mm);
            let mut motion = PlannedMotion {
                bead: index,
                tool: bead.tool,
                from_mm: rounded(pair[0]),
                to_mm: rounded(pair[1]),
                filament_mm: length_mm * section_mm2 / tool.filament_mm2(),
                width_mm: step.width_mm,
                area_mm2: length_mm * step.width_mm,
                feature,
                max_mm_s: settings.process.speed_mm_s(feature, is_small, layer),
            };
            if let Some(before) = open.take() {
                motion = joined(&before, &motion, &motion);
            }
            if is_long(&motion) { motions.push(motion) } else { open = Some(motion) }
        }
        start_mm = last.to_mm;
    }
    while let Some(rest) = open.take() {
        if motions.len() == first {
            return;
        }
        let Some(before) = motions.pop() else { return };
        let motion = joined(&before, &rest, &before);
        if is_long(&motion) { motions.push(motion) } else { open = Some(motion) }
    }
}

/// Whether a motion can be written.
fn is_long(motion: &PlannedMotion) -> bool {
    distance_mm(motion.from_mm, motion.to_mm) > 0.5 / UNITS_PER_MM
        && motion.filament_mm >= MIN_FILAMENT_MM
}

/// Two consecutive motions as one, with feature and speed of `like`.
fn joined(before: &PlannedMotion, after: &PlannedMotion, like: &PlannedMotion) -> PlannedMotion {
    PlannedMotion {
        from_mm: before.from_mm,
        to_mm: after.to_mm,
        filament_mm: before.filament_mm + after.filament_mm,
        width_mm: before.width_mm.max(after.width_mm),
        area_mm2: before.area_mm2 + after.area_mm2,
        ..*like
    }
}

fn rounded(position_mm: [f64; 2]) -> [f64; 2] {
    position_mm.map(|mm| (mm * UNITS_PER_MM).round() / UNITS_PER_MM)
}

pub(super) fn distance_mm(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    (x * x + y * y).sqrt()
}
