//! Which motions of a program deposit the part.

use beadwork_gcode::{Feature, Motion};

/// Whether a motion extrudes a bead that may belong to the part.
pub(super) fn is_bead(motion: &Motion) -> bool {
    let not_part = [Feature::PrimeTower, Feature::Skirt, Feature::Support, Feature::Custom];
    motion.is_extrusion() && !not_part.contains(&motion.feature)
}
