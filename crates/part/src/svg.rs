//! Layers drawn as SVG, for people: zones in colours, paths on top, crossings in red.

use std::fmt::{self, Write};

use beadwork_grid::{Cell, Path, Region, Zones};

/// A layer to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Panel<'a> {
    /// Text above it.
    pub title: &'a str,
    /// Its cells.
    pub region: &'a Region,
    /// Their zones.
    pub zones: &'a Zones,
    /// Its path, if it has one.
    pub path: Option<&'a Path>,
}

/// Light colours that people with any colour vision tell apart, after Okabe and Ito; the dark path stands out on all.
const PALETTE: [[u8; 3]; 8] = [
    [253, 226, 160],
    [173, 216, 240],
    [170, 222, 200],
    [246, 240, 165],
    [165, 195, 225],
    [240, 190, 160],
    [232, 195, 216],
    [215, 215, 215],
];

const PATH_COLOUR: &str = "#33373d";
const OUTSIDE_COLOUR: &str = "#e9ecef";
const CROSSING_COLOUR: &str = "#e0001b";

/// Width of a panel in pixels that cells are scaled to, and the smallest cell.
const PANEL_WIDTH: f64 = 480.0;
const SMALLEST_CELL: f64 = 4.0;
const MARGIN: f64 = 16.0;
const TITLE_HEIGHT: f64 = 28.0;

/// Draws layers side by side, all to one scale.
///
/// Zones are filled with their `colours`, lightened, or with a palette where there are none. Pieces of a path begin with a ring and
/// end with a dot; steps between zones are red. The text is the same on every machine; its length grows with the
/// bends of the paths and the outlines of the zones.
pub fn svg(panels: &[Panel<'_>], colours: Option<&[[u8; 3]]>) -> String {
    let mut text = String::new();
    write_svg(&mut text, panels, colours).expect("a string takes all text");
    text
}

fn write_svg(out: &mut String, panels: &[Panel<'_>], colours: Option<&[[u8; 3]]>) -> fmt::Result {
    let widest = panels.iter().map(|panel| panel.region.width()).max().unwrap_or(1);
    let tallest = panels.iter().map(|panel| panel.region.height()).max().unwrap_or(1);
    let cell = (PANEL_WIDTH / f64::from(widest)).max(SMALLEST_CELL);
    let width =
        MARGIN + panels.iter().map(|panel| cell * f64::from(panel.region.width()) + MARGIN).sum::<f64>();
    let height = TITLE_HEIGHT + cell * f64::from(tallest) + MARGIN;
    writeln!(
        out,
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0}" height="{height:.0}" viewBox="0 0 {width:.2} {height:.2}">"#
    )?;
    writeln!(out, r#"<rect width="100%" height="100%" fill="white"/>"#)?;
    let mut left = MARGIN;
    for panel in panels {
        let title = escape(panel.title);
        let font = r#"font-family="Helvetica, Arial, sans-serif" font-size="15" fill="black""#;
        writeln!(out, r#"<text x="{left:.2}" y="{:.2}" {font}>{title}</text>"#, TITLE_HEIGHT - 10.0)?;
        // One unit is a cell: the panel's own coordinates stay whole and short.
        writeln!(out, r#"<g transform="translate({left:.2} {TITLE_HEIGHT:.2}) scale({cell:.2})">"#)?;
        write_zones(out, panel, colours)?;
        if let Some(path) = panel.path {
            write_path(out, panel, path)?;
        }
        writeln!(out, "</g>")?;
        left += cell * f64::from(panel.region.width()) + MARGIN;
    }
    writeln!(out, "</svg>")
}

/// One shape for each zone, made of runs of cells along the rows.
fn write_zones(out: &mut String, panel: &Panel<'_>, colours: Option<&[[u8; 3]]>) -> fmt::Result {
    let Panel { region, zones, .. } = panel;
    let width = region.width() as usize;
    if !region.is_rectangle() {
        // A white zone must be told from what lies outside.
        writeln!(out, r#"<rect width="{width}" height="{}" fill="{OUTSIDE_COLOUR}"/>"#, region.height())?;
    }
    let mut shapes = vec![String::new(); zones.count() as usize];
    for (y, row) in zones.ids().chunks(width).enumerate() {
        let mut x = 0;
        for run in row.chunk_by(|a, b| a == b) {
            if run[0] != Zones::OUTSIDE {
                write!(shapes[usize::from(run[0])], "M{x} {y}h{length}v1h-{length}z", length = run.len())?;
            }
            x += run.len();
        }
    }
    for (zone, shape) in shapes.iter().enumerate().filter(|(_, shape)| !shape.is_empty()) {
        let [red, green, blue] = colour(zone, colours);
        // Without the hairline, viewers let the white shine through between the rows.
        let style = format!("#{red:02x}{green:02x}{blue:02x}");
        writeln!(out, r#"<path fill="{style}" stroke="{style}" stroke-width=".04" d="{shape}"/>"#)?;
    }
    Ok(())
}

fn write_path(out: &mut String, panel: &Panel<'_>, path: &Path) -> fmt::Result {
    let (region, zones) = (panel.region, panel.zones);
    let mut line = String::new();
    let mut crossings = String::new();
    let mut starts = String::new();
    let mut ends = String::new();
    for piece in path.iter_pieces() {
        let (&first, &last) = (&piece[0], &piece[piece.len() - 1]);
        write_line(&mut line, region, piece)?;
        for step in piece.windows(2).filter(|step| zones.id(step[0]) != zones.id(step[1])) {
            write_line(&mut crossings, region, step)?;
        }
        for (cell, marks) in [(first, &mut starts), (last, &mut ends)] {
            let (x, y) = centre(region, cell);
            // A line of no length with round ends is a disc.
            write!(marks, "M{x} {y}h0")?;
        }
    }
    let stroke = r#"fill="none" stroke-linecap="round" stroke-linejoin="round""#;
    writeln!(out, r#"<path {stroke} stroke="{PATH_COLOUR}" stroke-width=".16" d="{line}"/>"#)?;
    if !crossings.is_empty() {
        writeln!(out, r#"<path {stroke} stroke="{CROSSING_COLOUR}" stroke-width=".34" d="{crossings}"/>"#)?;
    }
    writeln!(out, r#"<path {stroke} stroke="{PATH_COLOUR}" stroke-width=".6" d="{ends}{starts}"/>"#)?;
    writeln!(out, r#"<path {stroke} stroke="white" stroke-width=".36" d="{starts}"/>"#)
}

/// Moves to the first cell and on along the others, straight stretches as one stroke.
fn write_line(out: &mut String, region: &Region, cells: &[Cell]) -> fmt::Result {
    let (x, y) = centre(region, cells[0]);
    write!(out, "M{x} {y}")?;
    // Cells are numbered row by row, so a straight stretch is one of equal steps.
    let step = |pair: &[Cell]| i64::from(pair[1]) - i64::from(pair[0]);
    let steps: Vec<i64> = cells.windows(2).map(step).collect();
    for stretch in steps.chunk_by(|a, b| a == b) {
        let length = stretch.len() as i64 * stretch[0].signum();
        let along = if region.width() > 1 && stretch[0].abs() == 1 { 'h' } else { 'v' };
        write!(out, "{along}{length}")?;
    }
    Ok(())
}

fn centre(region: &Region, cell: Cell) -> (f64, f64) {
    let (x, y) = region.xy(cell);
    (f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// The fill of a zone: light enough for the path to stand out.
fn colour(zone: usize, colours: Option<&[[u8; 3]]>) -> [u8; 3] {
    if let Some(own) = colours.and_then(|colours| colours.get(zone)) {
        return own.map(|channel| 255 - (255 - channel) / 2);
    }
    let round = (zone / PALETTE.len()) as u8;
    // From the ninth zone on the palette comes again, each time darker.
    PALETTE[zone % PALETTE.len()].map(|channel| channel - (channel / 8).saturating_mul(round.min(4)))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use beadwork_grid::{Crossings, Layout, LayoutSpec, Start};

    #[test]
    fn a_small_layer() {
        let region = Region::rectangle(2, 2).unwrap();
        let zones = Zones::new(&region, vec![0, 1, 0, 1]).unwrap();
        let path = Start::RowZigzag.path(&region).unwrap();
        let panel = Panel { title: "a < b", region: &region, zones: &zones, path: Some(&path) };
        let expected = r##"<svg xmlns="http://www.w3.org/2000/svg" width="512" height="524" viewBox="0 0 512.00 524.00">
<rect width="100%" height="100%" fill="white"/>
<text x="16.00" y="18.00" font-family="Helvetica, Arial, sans-serif" font-size="15" fill="black">a &lt; b</text>
<g transform="translate(16.00 28.00) scale(240.00)">
<path fill="#fde2a0" stroke="#fde2a0" stroke-width=".04" d="M0 0h1v1h-1zM0 1h1v1h-1z"/>
<path fill="#add8f0" stroke="#add8f0" stroke-width=".04" d="M1 0h1v1h-1zM1 1h1v1h-1z"/>
<path fill="none" stroke-linecap="round" stroke-linejoin="round" stroke="#33373d" stroke-width=".16" d="M0.5 0.5h1v1h-1"/>
<path fill="none" stroke-linecap="round" stroke-linejoin="round" stroke="#e0001b" stroke-width=".34" d="M0.5 0.5h1M1.5 1.5h-1"/>
<path fill="none" stroke-linecap="round" stroke-linejoin="round" stroke="#33373d" stroke-width=".6" d="M0.5 1.5h0M0.5 0.5h0"/>
<path fill="none" stroke-linecap="round" stroke-linejoin="round" stroke="white" stroke-width=".36" d="M0.5 0.5h0"/>
</g>
</svg>
"##;
        assert_eq!(svg(&[panel], None), expected);
    }

    #[test]
    fn every_crossing_is_red() {
        for seed in 0..20 {
            let region = Region::rectangle(17, 12).unwrap();
            let zones =
                LayoutSpec { zones: 20, ..LayoutSpec::new(Layout::Voronoi) }.zones(&region, seed).unwrap();
            let path = Start::Spiral.path(&region).unwrap();
            let panel = Panel { title: "", region: &region, zones: &zones, path: Some(&path) };
            let drawing = svg(&[panel, Panel { path: None, ..panel }], None);
            let red = drawing.lines().find(|line| line.contains(CROSSING_COLOUR)).unwrap();
            let strokes = red.split(" d=\"").nth(1).unwrap().matches('M').count();
            assert_eq!(strokes, Crossings::new(&region, &zones).count(&path) as usize);
            assert_eq!(drawing.matches("<g ").count(), drawing.matches("</g>").count());
        }
    }

    #[test]
    fn thin_layers_and_many_pieces() {
        let column = Region::rectangle(1, 5).unwrap();
        let zones = LayoutSpec::new(Layout::TopBottom).zones(&column, 0).unwrap();
        let path = Start::RowZigzag.path(&column).unwrap();
        let drawing = svg(&[Panel { title: "", region: &column, zones: &zones, path: Some(&path) }], None);
        assert!(drawing.contains(r#"d="M0.5 0.5v4""#), "{drawing}");
        let apart = Region::from_mask(2, 2, vec![true, false, false, true]).unwrap();
        let zones = Zones::new(&apart, vec![0; 4]).unwrap();
        let path = Start::Cover.path(&apart).unwrap();
        let drawing =
            svg(&[Panel { title: "", region: &apart, zones: &zones, path: Some(&path) }], Some(&[[0; 3]]));
        assert!(drawing.contains(r#"d="M0.5 0.5M1.5 1.5""#) && drawing.contains("#808080"), "{drawing}");
    }
}
