//! Pictures of the temperatures of plans, side by side.

use beadwork_console::temperature_map::{Map, Row, Scale, svg};
use beadwork_part::Frame;

use super::fields::Fields;

/// Maximum number of pictures in a row.
const COLUMNS: usize = 4;

/// Share of the voxels, the hottest ones, that exceed the colour scale: those around the last
/// lines, beside which all others would look alike.
const BEYOND: f64 = 0.03;

/// Draws a part at the ends of some layers, as SVG: for each layer all plans, with their names and
/// the deviation of all deposited voxels, and one colour scale for all.
pub(super) fn draw(frame: &Frame, plans: &[(&str, &Fields)]) -> String {
    let layers = plans.first().map_or(&[][..], |(_, fields)| &fields.layers);
    let columns = plans.len().div_ceil(plans.len().div_ceil(COLUMNS).max(1)).max(1);
    let map = |number: usize, (name, fields): &(&str, &Fields)| {
        let drawn = &fields.layers[number];
        Map::of(&drawn.section, frame, format!("{name}: {:.2} K", drawn.std_k))
    };
    let maps: Vec<(String, Vec<Map>)> = layers
        .iter()
        .enumerate()
        .map(|(number, drawn)| {
            let heading = format!("End of layer {}", drawn.layer + 1);
            (heading, plans.iter().map(|plan| map(number, plan)).collect())
        })
        .collect();
    let rows: Vec<Row<'_>> =
        maps.iter().flat_map(|(heading, maps)| Row::under(Some(heading), maps, columns)).collect();
    svg(&rows, scale(maps.iter().flat_map(|(_, maps)| maps).flat_map(Map::celsius)))
}

/// A scale for all but the hottest voxels.
fn scale(celsius: impl Iterator<Item = f32>) -> Scale {
    let mut all: Vec<f32> = celsius.collect();
    all.sort_unstable_by(f32::total_cmp);
    let count = (all.len() as f64 * (1.0 - BEYOND)).ceil() as usize;
    let is_exceeded = count < all.len();
    Scale { is_exceeded, ..Scale::of(all.into_iter().take(count)) }
}

#[cfg(test)]
mod tests {
    use beadwork_thermal::section::{Plane, Section};
    use ndarray::Array2;

    use super::super::fields::DrawnLayer;
    use super::*;

    #[test]
    fn plans_of_a_layer_are_side_by_side() {
        let section = |celsius: f64| Section {
            plane: Plane::Layer(0),
            temperatures_c: Array2::from_shape_fn((10, 20), |(y, x)| {
                if x == 3 { 230.0 } else { celsius + y as f64 }
            }),
        };
        let fields = |celsius: f64| Fields {
            layers: vec![DrawnLayer { layer: 6, section: section(celsius), std_k: 2.345 }],
            planes: Vec::new(),
        };
        let (cold, warm) = (fields(80.0), fields(90.0));
        let (left_mm, back_mm, cell_mm, layer_mm) = (0.0, 0.0, 0.5, 0.25);
        let frame = Frame { left_mm, back_mm, cell_mm, layer_mm, width: 20, height: 10 };
        let text = draw(&frame, &[("conventional", &cold), ("lines", &warm)]);
        assert!(text.contains("End of layer 7") && text.contains("lines: 2.35 K"), "{text}");
        assert_eq!(text.matches("<image").count(), 2);
        assert!(draw(&frame, &[]).ends_with("</svg>\n"));
        let scale = scale((0..100).map(|at| at as f32));
        assert!(scale.is_exceeded);
        assert!((scale.high_c - 96.0).abs() < 1e-9, "{}", scale.high_c);
    }
}
