//! Checks the prime tower, and the volumes that tool changes purge into it.

use beadwork_gcode::Motion;

use super::error::CheckError;
use super::tolerance;
use crate::Frame;
use crate::print::settings::{PrimeTower, Settings};

/// Tracks the prime tower and the volume purged since the last tool change.
pub(super) struct PurgeTracker<'a> {
    frame: &'a Frame,
    settings: &'a Settings,
    /// Number of the highest layer in which the tower was printed.
    top_layer: Option<usize>,
    /// The last tool change, until the part continues: the tools before and after.
    pending: Option<(u8, u8)>,
    /// Volume that went into the tower since the last tool change.
    purged_mm3: f64,
}

impl<'a> PurgeTracker<'a> {
    pub(super) fn new(frame: &'a Frame, settings: &'a Settings) -> Self {
        Self { frame, settings, top_layer: None, pending: None, purged_mm3: 0.0 }
    }

    pub(super) fn tool_change(&mut self, from: u8, to: u8) {
        self.pending = Some((from, to));
        self.purged_mm3 = 0.0;
    }

    /// Checks that a motion that extrudes into the tower stays within its position, and that the
    /// tower was also printed in the layer below.
    pub(super) fn tower_motion(
        &mut self,
        motion: &Motion,
        layer: usize,
        volume_mm3: f64,
    ) -> Result<(), CheckError> {
        self.purged_mm3 += volume_mm3;
        let line = motion.line;
        let tower = self.settings.purge.as_ref().and_then(|purge| purge.tower);
        let PrimeTower { left_mm, front_mm, width_mm, depth_mm } =
            tower.ok_or(CheckError::PrimeTowerOutside { line })?;
        // The bead reaches half a cell to either side of the motion.
        let margin_mm = self.frame.cell_mm / 2.0 - tolerance::POSITION_MM;
        let sides = [(left_mm, left_mm + width_mm), (front_mm, front_mm + depth_mm)];
        let is_within = |position: [f64; 3]| {
            let mut sides = sides.iter().zip(position);
            sides.all(|(&(low, high), at)| low + margin_mm <= at && at <= high - margin_mm)
        };
        if !is_within(motion.from_mm) || !is_within(motion.to_mm) {
            return Err(CheckError::PrimeTowerOutside { line });
        }
        if self.top_layer.map_or(0, |below| below + 1) < layer {
            return Err(CheckError::PrimeTowerInAir { line, layer });
        }
        self.top_layer = Some(layer);
        Ok(())
    }

    /// Checks, at a motion that extrudes into the part, that the last tool change was purged.
    pub(super) fn part_motion(&mut self, line: usize) -> Result<(), CheckError> {
        let Some((from, to)) = self.pending.take() else { return Ok(()) };
        let expected_mm3 =
            self.settings.purge.as_ref().map_or(0.0, |purge| purge.prime_tower_mm3(from, to));
        let got_mm3 = self.purged_mm3;
        if got_mm3 < expected_mm3 * (1.0 - tolerance::PURGE) {
            return Err(CheckError::Purge { line, from, to, expected_mm3, got_mm3 });
        }
        Ok(())
    }
}
