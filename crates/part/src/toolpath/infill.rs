//! Fills regions with patterns.

use super::honeycomb::honeycomb;
use super::island::Infill;
use super::scan_lines::Family;
use super::settings::{InfillPattern, Settings};
use crate::area::Area;

/// Length in mm of pieces of sparse infill that are dropped.
const SHORT_MM: f64 = 0.2;

/// Share of the length that dropped pieces may have.
const MAX_DROPPED: f64 = 0.01;

/// Maximum deviation in mm of closed lines from the exact offset of the border.
const TOLERANCE_MM: f64 = 0.003;

/// Fills a region with lines one bead apart; `layer` is the number of the layer.
pub(super) fn solid(region: Area, settings: &Settings, layer: usize) -> Infill {
    let spacing_mm = settings.bead_mm;
    let mut infill =
        Infill { is_solid: true, region, spacing_mm, lines: Vec::new(), loops: Vec::new() };
    if settings.density >= 1.0 && settings.pattern == InfillPattern::Concentric {
        concentric(&mut infill);
    } else {
        lines(&mut infill, turned(settings.angle_degrees, layer));
    }
    infill
}

/// Fills a region with the pattern of the settings, whose density is below 1.
///
/// Without lines if the density is 0.
pub(super) fn sparse(region: Area, settings: &Settings, layer: usize) -> Infill {
    let spacing_mm = settings.spacing_mm().unwrap_or(f64::INFINITY);
    let mut infill =
        Infill { is_solid: false, region, spacing_mm, lines: Vec::new(), loops: Vec::new() };
    if !spacing_mm.is_finite() {
        return infill;
    }
    let angle = settings.angle_degrees;
    match settings.pattern {
        InfillPattern::Lines => lines(&mut infill, turned(angle, layer)),
        InfillPattern::Grid => directions(&mut infill, angle, 2, 0.0),
        InfillPattern::Triangles => directions(&mut infill, angle, 3, 0.0),
        InfillPattern::Hybrid => directions(&mut infill, angle, 3, 0.5),
        InfillPattern::Hexagons => {
            let along = unit_vector(angle);
            infill.lines = honeycomb(&infill.region, along, settings.bead_mm, settings.density);
        }
        InfillPattern::Concentric => concentric(&mut infill),
    }
    drop_short(&mut infill.lines);
    infill
}

/// The direction of lines in a layer: they cross those of the layer below.
fn turned(angle_degrees: f64, layer: usize) -> f64 {
    angle_degrees + if layer.is_multiple_of(2) { 0.0 } else { 90.0 }
}

fn unit_vector(degrees: f64) -> [f64; 2] {
    let radians = degrees.to_radians();
    [libm::cos(radians), libm::sin(radians)]
}

fn lines(infill: &mut Infill, angle_degrees: f64) {
    let along = unit_vector(angle_degrees);
    let family = Family { along, spacing_mm: infill.spacing_mm, shift_mm: 0.0 };
    infill.lines.extend(family.clip(infill.region.rings()).iter().map(|line| line.to_vec()));
}

/// Lines in several directions, of which the last is shifted by a fraction of the spacing.
fn directions(infill: &mut Infill, angle_degrees: f64, count: u32, shift: f64) {
    let spacing_mm = infill.spacing_mm * f64::from(count);
    for number in 0..count {
        let along = unit_vector(angle_degrees + f64::from(number) * 180.0 / f64::from(count));
        let shift_mm = if number + 1 == count { shift * spacing_mm } else { 0.0 };
        let family = Family { along, spacing_mm, shift_mm };
        infill.lines.extend(family.clip(infill.region.rings()).iter().map(|line| line.to_vec()));
    }
}

/// Closed lines, the first along the border of the region.
fn concentric(infill: &mut Infill) {
    let mut depth_mm = 0.0;
    let mut area = infill.region.clone();
    while !area.is_empty() {
        infill.loops.extend(area.simplified(TOLERANCE_MM).rings().cloned());
        depth_mm += infill.spacing_mm;
        area = infill.region.offset(-depth_mm);
    }
}

/// Drops short lines, unless they are more than a hundredth of the length.
fn drop_short(lines: &mut Vec<Vec<[f64; 2]>>) {
    let length = |line: &[[f64; 2]]| -> f64 {
        line.windows(2).map(|ends| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1])).sum()
    };
    let (mut total_mm, mut short_mm) = (0.0, 0.0);
    for line in lines.iter() {
        let length_mm = length(line);
        total_mm += length_mm;
        short_mm += if length_mm < SHORT_MM { length_mm } else { 0.0 };
    }
    if short_mm < MAX_DROPPED * total_mm {
        lines.retain(|line| length(line) >= SHORT_MM);
    }
}
