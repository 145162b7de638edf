//! Honeycombs made of zigzag lines.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::clip::FloatClip;
use i_overlay::string::clip::ClipRule;

use crate::area::Area;

/// Zigzag lines that make a honeycomb within an area.
///
/// Each line consists of sides along its direction and sides at 60 degrees to either side of it.
/// Where two lines run along a wall of the honeycomb, they lie side by side, a bead apart.
/// `along` is the unit vector in the direction of the lines, `density` more than 0 and below 1.
pub(super) fn honeycomb(
    area: &Area,
    along: [f64; 2],
    bead_mm: f64,
    density: f64,
) -> Vec<Vec<[f64; 2]>> {
    // A period of a line has two straight sides and two slanted ones, each of length a; it takes 3
    // a along the line, and a sqrt(3) / 2 and a bead across it.
    // So the density is 4 a bead / (3 a (a sqrt(3) / 2 + bead)).
    let rise_mm = bead_mm * (4.0 / (3.0 * density) - 1.0);
    let side_mm = rise_mm / 0.75_f64.sqrt();
    let pitch_mm = rise_mm + bead_mm;
    let to_frame = |[x, y]: [f64; 2]| [along[0] * x + along[1] * y, along[0] * y - along[1] * x];
    let from_frame = |[u, v]: [f64; 2]| [along[0] * u - along[1] * v, along[1] * u + along[0] * v];
    let mut min = [f64::INFINITY; 2];
    let mut max = [f64::NEG_INFINITY; 2];
    for point in area.rings().flatten().map(|&point| to_frame(point)) {
        min = [0, 1].map(|k| point[k].min(min[k]));
        max = [0, 1].map(|k| point[k].max(max[k]));
    }
    if area.is_empty() {
        return Vec::new();
    }
    let periods = |u: f64| u / (3.0 * side_mm);
    let (first, last) = (periods(min[0]).floor() as i64 - 1, periods(max[0]).ceil() as i64 + 1);
    let zigzag = |number: i64| -> Vec<[f64; 2]> {
        let middle_mm = number as f64 * pitch_mm;
        let high_mm = if number % 2 == 0 { rise_mm / 2.0 } else { -rise_mm / 2.0 };
        let corners = [(0.0, high_mm), (1.0, high_mm), (1.5, -high_mm), (2.5, -high_mm)];
        let period = |period: i64| {
            corners.map(|(sides, v)| {
                from_frame([(3.0 * period as f64 + sides) * side_mm, middle_mm + v])
            })
        };
        (first..=last).flat_map(period).collect()
    };
    let numbers = (min[1] / pitch_mm).floor() as i64 - 1..=(max[1] / pitch_mm).ceil() as i64 + 1;
    let lines: Vec<Vec<[f64; 2]>> = numbers.map(zigzag).collect();
    let rule = ClipRule { invert: false, boundary_included: false };
    lines.clip_by(&area.components().to_vec(), FillRule::NonZero, rule)
}
