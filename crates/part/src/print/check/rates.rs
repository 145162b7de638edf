//! Checks speed and volume of motions.

use beadwork_gcode::Motion;

use super::error::CheckError;
use super::tolerance;
use crate::print::process::Process;

/// Checks that a motion is not faster than a maximum in mm/s.
pub(super) fn check_speed(motion: &Motion, max_mm_s: f64) -> Result<(), CheckError> {
    let got_mm_s = motion.feed_mm_s;
    if got_mm_s <= max_mm_s + tolerance::SPEED_MM_S {
        return Ok(());
    }
    Err(CheckError::Speed { line: motion.line, got_mm_s, max_mm_s })
}

/// Checks the speed of a motion through cells or in the prime tower.
pub(super) fn check_cell_speed(
    motion: &Motion,
    layer: usize,
    process: &Process,
) -> Result<(), CheckError> {
    check_speed(motion, if layer == 0 { process.first_layer_mm_s } else { process.print_mm_s })
}

/// Checks the volume of a motion, given the cross-sectional areas of filament and bead.
pub(super) fn check_volume(
    motion: &Motion,
    filament_mm2: f64,
    bead_mm2: f64,
) -> Result<(), CheckError> {
    let got_mm3 = motion.extruded_mm * filament_mm2;
    let expected_mm3 = motion.length_mm() * bead_mm2;
    // Both ends of the motion and the filament length were rounded.
    let rounding_mm3 =
        2.0 * tolerance::POSITION_MM * bead_mm2 + tolerance::FILAMENT_MM * filament_mm2;
    if (got_mm3 - expected_mm3).abs() > tolerance::VOLUME * expected_mm3 + rounding_mm3 {
        return Err(CheckError::Volume { line: motion.line, expected_mm3, got_mm3 });
    }
    Ok(())
}
