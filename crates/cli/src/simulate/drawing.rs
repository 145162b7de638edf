//! Charts of temperatures by layer, and maps of some layers.

use beadwork_console::chart::{Axis, BLUE, Chart, GREEN, GREY, LineStyle, ORANGE, Series, charts};
use beadwork_console::temperature_map::{self, Map, Row, Scale};
use beadwork_thermal::Simulation;
use beadwork_thermal::section::Plane;

use super::measures::LayerMeasures;

/// Maximum number of layers drawn: two rows.
const MAPS: usize = 6;

/// Numbers of the layers to draw, evenly spread over `depth` layers.
pub(super) fn chosen(depth: usize) -> Vec<usize> {
    let count = depth.min(MAPS);
    (0..count).map(|map| if count > 1 { map * (depth - 1) / (count - 1) } else { 0 }).collect()
}

/// Map of a layer at the current time.
pub(super) fn layer_map(layer: usize, simulation: &Simulation) -> Map {
    let section = simulation.section(Plane::Layer(layer as u32));
    Map::of(&section, &simulation.part().frame, format!("layer {}, complete", layer + 1))
}

/// Charts over all layers, and below them maps of some.
pub(super) fn draw(title: &str, layers: &[LayerMeasures], maps: &[Map]) -> anyhow::Result<String> {
    const HEADER: u32 = 34;
    const HEIGHT: u32 = 250;
    const COLUMNS: usize = 3;

    let series = |name: &str, colour, style, value: fn(&LayerMeasures) -> f64| Series {
        name: name.to_owned(),
        colour,
        style,
        points: layers.iter().map(|layer| (layer.layer as f64, value(layer))).collect(),
    };
    let plain =
        |label: &'static str, shown: &'static [f64]| Axis { label, logarithmic: false, shown };
    let chart = |title: &str, y, series| Chart {
        title: title.to_owned(),
        x: plain("layer", &[]),
        y,
        series,
    };
    let above = charts(
        &[
            chart(
                "All deposited voxels",
                plain("°C", &[]),
                vec![
                    series("mean", BLUE, LineStyle::Plain, |layer| layer.mean_c),
                    series("minimum", GREY, LineStyle::Thin, |layer| layer.min_c),
                ],
            ),
            chart(
                "Standard deviation",
                plain("°C", &[0.0]),
                vec![series("standard deviation", ORANGE, LineStyle::Plain, |layer| layer.std_c)],
            ),
            chart(
                "Printing time of a layer",
                plain("s", &[0.0]),
                vec![series("seconds", GREEN, LineStyle::Plain, |layer| layer.print_seconds)],
            ),
        ],
        COLUMNS,
        (temperature_map::WIDTH / COLUMNS as u32, HEIGHT),
    )?;
    let rows: Vec<Row<'_>> = Row::under(None, maps, COLUMNS).collect();
    let below = temperature_map::svg(&rows, Scale::of(maps.iter().flat_map(Map::celsius)));
    let begin = HEADER + height(&above);
    let (width, whole) = (temperature_map::WIDTH, begin + height(&below));
    let title = temperature_map::escaped(title);
    Ok(format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{whole}"
viewBox="0 0 {width} {whole}">
<rect width="{width}" height="{whole}" fill="white"/>
<text x="14" y="23" font-family="sans-serif" font-size="16" font-weight="bold">{title}</text>
<g transform="translate(0,{HEADER})">
{above}</g>
<g transform="translate(0,{begin})">
{below}</g>
</svg>
"#
    ))
}

/// The height that the root element of an SVG states.
fn height(svg: &str) -> u32 {
    let stated = svg.split_once(" height=\"").and_then(|(_, rest)| rest.split_once('"'));
    stated.and_then(|(height, _)| height.parse().ok()).expect("every SVG states its height")
}

#[cfg(test)]
mod tests {
    use beadwork_part::Frame;
    use beadwork_thermal::Section;

    use super::*;

    #[test]
    fn the_first_and_the_last_layer_are_drawn() {
        assert_eq!(chosen(0), [0; 0]);
        assert_eq!(chosen(1), [0]);
        assert_eq!(chosen(4), [0, 1, 2, 3]);
        assert_eq!(chosen(77), [0, 15, 30, 45, 60, 76]);
    }

    #[test]
    fn charts_and_maps_make_one_drawing() {
        let measure = |layer| LayerMeasures {
            layer,
            voxels: 4,
            mean_c: 90.0,
            std_c: 3.0,
            min_c: 80.0,
            max_c: 230.0,
            print_seconds: 2.0,
            hot_spots: 1,
            substrate_mean_c: Some(85.0),
            substrate_min_c: Some(80.0),
        };
        let section =
            Section { plane: Plane::Layer(0), temperatures_c: ndarray::array![[80.0, 90.0]] };
        let frame =
            Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 2, height: 1 };
        let map = Map::of(&section, &frame, "layer 1".to_owned());
        let text = draw("a & b", &[measure(1), measure(2)], &[map]).unwrap();
        assert!(text.contains("a &amp; b") && text.matches("<svg").count() == 3);
        assert_eq!(text.matches("</svg>").count(), 3);
    }
}
