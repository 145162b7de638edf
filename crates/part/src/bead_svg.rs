//! Drawings of layers of beads as SVG: strips as wide as they are printed.

use std::fmt::{self, Write};

use beadwork_gcode::Feature;

use crate::bead::{Bead, BeadLayer};
use crate::svg::{FONT, PATH_COLOUR, escape};

/// Corners of beads are round.
const JOINT: &str = r#"stroke-linejoin="round""#;

/// A layer to draw.
#[derive(Clone, Copy, Debug)]
pub struct BeadPanel<'a> {
    /// Text above the layer.
    pub title: &'a str,
    /// The beads in printing order.
    pub layer: &'a BeadLayer,
}

/// Panels in a row.
const PANELS_PER_ROW: usize = 2;
/// Approximate length of the longer side of the largest layer, in pixels.
const PANEL_SIDE: f64 = 720.0;
const MARGIN: f64 = 16.0;
const TITLE_HEIGHT: f64 = 28.0;
/// Drawn share of the width of a strip, so that neighbours can be distinguished.
const DRAWN_WIDTH: f64 = 0.86;
/// Colours all of whose parts are above this value are light.
const LIGHT: u8 = 180;
/// Diameter of the mark where a bead begins, in mm.
const MARK_MM: f64 = 0.5;

/// Draws layers side by side, two in a row, all on the same scale, y up.
///
/// Strips have the colour of their feature, or a shade of their tool's among `colours`.
/// A dark dot marks where a bead begins, and a thin line the travel to it.
/// The output is the same on every machine; its length is linear in the moves.
pub fn bead_svg(panels: &[BeadPanel<'_>], colours: Option<&[[u8; 3]]>) -> String {
    let mut text = String::new();
    write_svg(&mut text, panels, colours).expect("writing to a string cannot fail");
    text
}

fn write_svg(
    out: &mut String,
    panels: &[BeadPanel<'_>],
    colours: Option<&[[u8; 3]]>,
) -> fmt::Result {
    let [min, max] = bounds(panels);
    let [width_mm, height_mm] = [max[0] - min[0], max[1] - min[1]];
    let scale = PANEL_SIDE / width_mm.max(height_mm).max(1.0);
    let panel_width = scale * width_mm + MARGIN;
    let row_height = TITLE_HEIGHT + scale * height_mm + MARGIN;
    let rows = panels.len().div_ceil(PANELS_PER_ROW).max(1) as f64;
    let columns = panels.len().clamp(1, PANELS_PER_ROW) as f64;
    let (width, height) = (MARGIN + columns * panel_width, rows * row_height);
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"0 0 {width:.0} {height:.0}\">"
    )?;
    writeln!(out, r#"<rect width="100%" height="100%" fill="white"/>"#)?;
    for (number, panel) in panels.iter().enumerate() {
        let left = MARGIN + (number % PANELS_PER_ROW) as f64 * panel_width;
        let top = (number / PANELS_PER_ROW) as f64 * row_height + TITLE_HEIGHT;
        let title = escape(panel.title);
        let style = r#"font-size="15" fill="black""#;
        writeln!(
            out,
            r#"<text x="{left:.1}" y="{:.1}" {FONT} {style}>{title}</text>"#,
            top - 10.0
        )?;
        // Within a panel the unit is 1 mm, from the back left corner.
        writeln!(
            out,
            r#"<g transform="translate({left:.1} {top:.1}) scale({scale:.4})" fill="none">"#
        )?;
        let position = |[x, y]: [f64; 2]| [x - min[0], max[1] - y];
        write_beads(out, panel.layer, colours, position)?;
        writeln!(out, "</g>")?;
    }
    writeln!(out, "</svg>")
}

fn write_beads(
    out: &mut String,
    layer: &BeadLayer,
    colours: Option<&[[u8; 3]]>,
    position: impl Fn([f64; 2]) -> [f64; 2],
) -> fmt::Result {
    for bead in &layer.beads {
        let mut from = bead.start_mm;
        // Moves of equal width and feature are one line.
        let alike = bead.moves.chunk_by(|a, b| {
            a.feature == b.feature && a.width_mm.to_bits() == b.width_mm.to_bits()
        });
        for moves in alike {
            let [x, y] = position(from);
            write!(out, r#"<path d="M{x:.3} {y:.3}"#)?;
            for step in moves {
                let [x, y] = position(step.to_mm);
                write!(out, " {x:.3} {y:.3}")?;
                from = step.to_mm;
            }
            let [red, green, blue] = colour(bead, moves[0].feature, colours);
            writeln!(
                out,
                r##"" stroke="#{red:02x}{green:02x}{blue:02x}" stroke-width="{:.3}" {JOINT}/>"##,
                DRAWN_WIDTH * moves[0].width_mm
            )?;
        }
    }
    for pair in layer.beads.windows(2) {
        let ([x, y], [to_x, to_y]) = (position(pair[0].end_mm()), position(pair[1].start_mm));
        let style = format!(r#"stroke="{PATH_COLOUR}" stroke-width="0.06""#);
        writeln!(out, r#"<path d="M{x:.3} {y:.3} {to_x:.3} {to_y:.3}" {style}/>"#)?;
    }
    for bead in &layer.beads {
        let [x, y] = position(bead.start_mm);
        let radius = MARK_MM / 2.0;
        writeln!(out, r#"<circle cx="{x:.3}" cy="{y:.3}" r="{radius}" fill="{PATH_COLOUR}"/>"#)?;
    }
    Ok(())
}

/// Colour of a strip.
fn colour(bead: &Bead, feature: Feature, colours: Option<&[[u8; 3]]>) -> [u8; 3] {
    let shade = match feature {
        Feature::OuterWall | Feature::ThinWall => 0.75,
        Feature::InnerWall | Feature::GapFill => 0.55,
        _ => 0.4,
    };
    let own = colours.and_then(|colours| colours.get(usize::from(bead.tool)));
    if let Some(own) = own {
        // Light colours are darkened instead: white strips would vanish on white paper.
        let is_light = own.iter().all(|&value| value > LIGHT);
        return own.map(|value| {
            let value = f64::from(value);
            let drawn = if is_light {
                value * (1.0 - 0.4 * shade)
            } else {
                255.0 - shade * (255.0 - value)
            };
            drawn.round() as u8
        });
    }
    match feature {
        Feature::OuterWall => [230, 140, 70],
        Feature::ThinWall => [205, 90, 60],
        Feature::InnerWall => [245, 195, 110],
        Feature::GapFill => [190, 130, 200],
        Feature::SolidInfill => [140, 180, 225],
        _ => [150, 205, 175],
    }
}

/// Minimum and maximum x and y of all points, with room for the strips.
fn bounds(panels: &[BeadPanel<'_>]) -> [[f64; 2]; 2] {
    let beads = panels.iter().flat_map(|panel| &panel.layer.beads);
    let points = beads.flat_map(|bead| {
        let ends = bead.moves.iter().map(|step| step.to_mm);
        std::iter::once(bead.start_mm).chain(ends)
    });
    let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let [min, max] = points.fold(start, |[min, max], point| {
        [[0, 1].map(|k| min[k].min(point[k])), [0, 1].map(|k| max[k].max(point[k]))]
    });
    if min[0] > max[0] {
        return [[0.0; 2], [1.0; 2]];
    }
    [min.map(|value| value - 0.5), max.map(|value| value + 0.5)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bead::ExtrusionMove;

    #[test]
    fn drawings_hold_every_bead() {
        let step = |x, y, feature| ExtrusionMove { to_mm: [x, y], width_mm: 0.5, feature };
        let bead = |tool, feature| Bead {
            tool,
            start_mm: [0.0, 0.0],
            moves: vec![step(3.0, 0.0, feature), step(3.0, 4.0, feature)],
        };
        let beads = vec![bead(0, Feature::OuterWall), bead(1, Feature::Infill)];
        let layer = BeadLayer { number: 0, beads };
        let panel = BeadPanel { title: "a < b", layer: &layer };
        let text = bead_svg(&[panel, panel, panel], Some(&[[255, 0, 0], [0, 0, 255]]));
        assert!(text.contains("a &lt; b"));
        assert_eq!(text.matches("stroke-width=\"0.430\"").count(), 6);
        assert_eq!(text.matches("<circle").count(), 6);
        assert!(bead_svg(&[], None).ends_with("</svg>\n"));
        let empty = BeadLayer::default();
        assert!(bead_svg(&[BeadPanel { title: "", layer: &empty }], None).contains("<svg"));
    }
}
