//! How beads are printed: speeds, temperatures, retraction, and the cross-section of a bead.

use std::f64::consts::PI;

use beadwork_base::named_enum;
use beadwork_gcode::Feature;
use serde::Deserialize;

use crate::Frame;

/// Cross-section of a bead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CrossSection {
    /// The whole cell, width times height: adjacent beads fill the part.
    #[default]
    Rectangle,
    /// A rectangle with a semicircle at either side, as slicers model single beads.
    /// It leaves gaps between beads that are one bead width apart.
    Oval,
}

named_enum! {
    CrossSection, "cross-section":
    Rectangle = "rectangle",
    Oval = "oval",
}

/// Speeds, temperatures and retraction.
///
/// Features of beads may have speeds of their own; those without one are printed at
/// [`print_mm_s`](Self::print_mm_s), as cells and the prime tower always are.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Process {
    /// Printing speed in mm/s.
    pub print_mm_s: f64,
    /// Printing speed in the first layer, in mm/s; also the maximum of features with a speed of
    /// their own.
    pub first_layer_mm_s: f64,
    /// Speed of outer and thin walls in mm/s; `None` for `print_mm_s`.
    pub outer_wall_mm_s: Option<f64>,
    /// Speed of inner walls in mm/s; `None` for `print_mm_s`.
    pub inner_wall_mm_s: Option<f64>,
    /// Speed of sparse infill in mm/s; `None` for `print_mm_s`.
    pub infill_mm_s: Option<f64>,
    /// Speed of solid infill in mm/s; `None` for `print_mm_s`.
    pub solid_infill_mm_s: Option<f64>,
    /// Speed of gap fill in mm/s; `None` for `print_mm_s`.
    pub gap_fill_mm_s: Option<f64>,
    /// Maximum speed of small loops of walls in mm/s; `None` for the speed of the wall.
    pub small_perimeter_mm_s: Option<f64>,
    /// Loops of walls that are shorter than this are small, in mm.
    ///
    /// A loop is a sequence of moves of a bead with the same feature, as long as possible, whose
    /// ends are at most as far apart as its last move is wide.
    pub small_perimeter_below_mm: f64,
    /// Travel speed in mm/s.
    pub travel_mm_s: f64,
    /// Temperature of the bed, in °C.
    pub bed_c: f64,
    /// Length of filament to retract before travel and tool changes, in mm; 0 for no retraction.
    pub retract_mm: f64,
    /// Speed of retracting and unretracting, in mm/s.
    pub retract_mm_s: f64,
    /// Length in mm up to which travel needs no retraction.
    pub retract_beyond_mm: f64,
    /// Length in mm by which the nozzle moves back along the bead just printed while it retracts; 0
    /// to retract in place.
    ///
    /// The filament is retracted evenly along a wipe, at `retract_mm_s` unless the nozzle would be
    /// faster than `travel_mm_s`.
    /// The wipe of a shorter bead ends at its start.
    pub wipe_mm: f64,
    /// Height in mm by which the nozzle is raised for travel with retracted filament.
    pub z_hop_mm: f64,
    /// Speed of the fan, from 0 to 1.
    pub fan: f64,
    /// First layer that is printed with the fan on, numbered from 0.
    pub fan_from_layer: usize,
    /// Cross-section of a bead.
    pub cross_section: CrossSection,
}

impl Default for Process {
    /// As in *Kim et al. 2026*: printing at 30 mm/s, travel at 150 mm/s, the bed at 80 °C, no fan.
    /// Retraction is typical of a direct-drive extruder.
    /// All features have the same speed; small loops are those of circles with a radius below 6.5
    /// mm, as in PrusaSlicer.
    fn default() -> Self {
        Self {
            print_mm_s: 30.0,
            first_layer_mm_s: 20.0,
            outer_wall_mm_s: None,
            inner_wall_mm_s: None,
            infill_mm_s: None,
            solid_infill_mm_s: None,
            gap_fill_mm_s: None,
            small_perimeter_mm_s: None,
            small_perimeter_below_mm: 40.84,
            travel_mm_s: 150.0,
            bed_c: 80.0,
            retract_mm: 0.8,
            retract_mm_s: 35.0,
            retract_beyond_mm: 2.0,
            wipe_mm: 0.0,
            z_hop_mm: 0.0,
            fan: 0.0,
            fan_from_layer: 1,
            cross_section: CrossSection::Rectangle,
        }
    }
}

impl Process {
    /// Cross-sectional area of a bead through cells, in mm².
    pub fn bead_mm2(&self, frame: &Frame) -> f64 {
        self.section_mm2(frame.cell_mm, frame.layer_mm)
    }

    /// Cross-sectional area in mm² of a bead with a width and a height in mm.
    ///
    /// An oval that is higher than wide has its semicircles above and below.
    pub fn section_mm2(&self, width_mm: f64, height_mm: f64) -> f64 {
        match self.cross_section {
            CrossSection::Rectangle => width_mm * height_mm,
            CrossSection::Oval => {
                let (long, short) = (width_mm.max(height_mm), width_mm.min(height_mm));
                (long - short) * short + PI * short * short / 4.0
            }
        }
    }

    /// Speed in mm/s of a feature of the part in a layer, numbered from 0; `is_small` for the moves
    /// of a small loop.
    pub fn speed_mm_s(&self, feature: Feature, is_small: bool, layer: usize) -> f64 {
        let own = match feature {
            Feature::OuterWall | Feature::ThinWall => self.outer_wall_mm_s,
            Feature::InnerWall => self.inner_wall_mm_s,
            Feature::Infill => self.infill_mm_s,
            Feature::SolidInfill => self.solid_infill_mm_s,
            Feature::GapFill => self.gap_fill_mm_s,
            _ => None,
        };
        let small = self.small_perimeter_mm_s.filter(|_| is_small);
        let own = small.map(|small| small.min(own.unwrap_or(self.print_mm_s))).or(own);
        match (own, layer) {
            (None, 0) => self.first_layer_mm_s,
            (None, _) => self.print_mm_s,
            (Some(own), 0) => own.min(self.first_layer_mm_s),
            (Some(own), _) => own,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_feature_has_its_speed() {
        let process = Process {
            outer_wall_mm_s: Some(15.0),
            inner_wall_mm_s: Some(25.0),
            infill_mm_s: Some(60.0),
            gap_fill_mm_s: Some(10.0),
            small_perimeter_mm_s: Some(20.0),
            ..Process::default()
        };
        for (feature, is_small, layer, expected) in [
            (Feature::OuterWall, false, 1, 15.0),
            (Feature::OuterWall, true, 1, 15.0),
            (Feature::ThinWall, false, 2, 15.0),
            (Feature::InnerWall, false, 1, 25.0),
            (Feature::InnerWall, true, 1, 20.0),
            (Feature::InnerWall, false, 0, 20.0),
            (Feature::Infill, false, 1, 60.0),
            (Feature::Infill, false, 0, 20.0),
            (Feature::SolidInfill, false, 1, 30.0),
            (Feature::SolidInfill, false, 0, 20.0),
            (Feature::GapFill, false, 0, 10.0),
            (Feature::PrimeTower, false, 3, 30.0),
        ] {
            assert_eq!(process.speed_mm_s(feature, is_small, layer), expected, "{feature:?}");
        }
        let fast = Process { first_layer_mm_s: 50.0, ..Process::default() };
        assert_eq!(fast.speed_mm_s(Feature::OuterWall, true, 0), 50.0);
        let small = Process { small_perimeter_mm_s: Some(99.0), ..Process::default() };
        assert_eq!(small.speed_mm_s(Feature::OuterWall, true, 1), 30.0);
    }

    #[test]
    fn sections_of_both_shapes() {
        let oval = Process { cross_section: CrossSection::Oval, ..Process::default() };
        assert!((oval.section_mm2(0.5, 0.2) - (0.06 + PI * 0.01)).abs() < 1e-12);
        assert!((oval.section_mm2(0.1, 0.2) - (0.01 + PI * 0.0025)).abs() < 1e-12);
        assert!((Process::default().section_mm2(0.5, 0.2) - 0.1).abs() < 1e-12);
    }
}
