//! Drawings of layers as SVG: zones in colours, paths on top, crossings in red.

use std::fmt::{self, Write};

use beadwork_grid::{Cell, Path, Region, Zones};

/// A layer to draw.
#[derive(Clone, Copy, Debug)]
pub struct Panel<'a> {
    /// Text above the layer.
    pub title: &'a str,
    /// The cells.
    pub region: &'a Region,
    /// The zone of each cell.
    pub zones: &'a Zones,
    /// The path, if there is one.
    pub path: Option<&'a Path>,
    /// Further links to draw, each between two adjacent cells; they show an incomplete path.
    pub links: &'a [[Cell; 2]],
}

/// Colours of the first zones: the palette of Okabe and Ito, which people with any colour vision
/// can distinguish, lightened so that the dark path stands out.
const PALETTE: [[u8; 3]; 8] = [
    [250, 208, 128],
    [173, 216, 240],
    [160, 218, 194],
    [246, 240, 165],
    [150, 184, 222],
    [240, 180, 148],
    [232, 190, 214],
    [212, 212, 212],
];

/// Attributes of all text.
pub(crate) const FONT: &str = r#"font-family="Helvetica, Arial, sans-serif""#;

pub(crate) const PATH_COLOUR: &str = "#1d2126";
const OUTSIDE_COLOUR: &str = "#e9ecef";
const CROSSING_COLOUR: &str = "#e0001b";

/// Panels in a row; more of them would be too small on a screen.
const PANELS_PER_ROW: usize = 3;

// All lengths are in pixels.
/// Approximate length of the longer side of the largest layer.
/// A cell is a whole number of pixels wide, so that the edges of zones are sharp.
const PANEL_SIDE: f64 = 480.0;
const MIN_CELL: f64 = 4.0;
/// Keeps layers of a few cells from filling the screen.
const MAX_CELL: f64 = 48.0;
const MARGIN: f64 = 16.0;
const TITLE_HEIGHT: f64 = 28.0;
/// Width of a wide letter in a title.
const LETTER: f64 = 9.0;

// Widths of lines and diameters of marks: in cells, and the minimum in pixels.
const PATH_WIDTH: (f64, f64) = (0.14, 1.3);
const CROSSING_WIDTH: (f64, f64) = (0.3, 2.4);
const MARK_WIDTH: (f64, f64) = (0.6, 6.0);

/// Draws layers side by side, three in a row, all on the same scale.
///
/// Zones are filled with a lightened form of their `colours`, or with colours of a palette if they
/// have none.
/// Each piece of a path begins with a ring and ends with a dot; steps between zones are red.
/// The output is the same on every machine.
/// Its length is linear in the number of bends of the paths and of cells on the borders of zones.
///
/// # Panics
/// If a path visits cells outside the grid of its panel's zones.
pub fn svg(panels: &[Panel<'_>], colours: Option<&[[u8; 3]]>) -> String {
    let mut text = String::new();
    write_svg(&mut text, panels, colours).expect("writing to a string cannot fail");
    text
}

fn write_svg(out: &mut String, panels: &[Panel<'_>], colours: Option<&[[u8; 3]]>) -> fmt::Result {
    let widest = panels.iter().map(|panel| panel.region.width()).max().unwrap_or(1);
    let tallest = panels.iter().map(|panel| panel.region.height()).max().unwrap_or(1);
    let cell = (PANEL_SIDE / f64::from(widest.max(tallest))).round().clamp(MIN_CELL, MAX_CELL);
    // A title may be wider than its layer.
    let panel_width = |panel: &Panel<'_>| {
        let title = LETTER * panel.title.chars().count() as f64;
        title.max(cell * f64::from(panel.region.width())) + MARGIN
    };
    let rows = panels.chunks(PANELS_PER_ROW);
    let row_width = |row: &[Panel<'_>]| MARGIN + row.iter().map(panel_width).sum::<f64>();
    let width = rows.clone().map(row_width).fold(MARGIN, f64::max);
    let row_height = TITLE_HEIGHT + cell * f64::from(tallest) + MARGIN;
    let height = row_height * rows.len().max(1) as f64;
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">"
    )?;
    writeln!(out, r#"<rect width="100%" height="100%" fill="white"/>"#)?;
    for (row, panels) in rows.enumerate() {
        let top = row as f64 * row_height + TITLE_HEIGHT;
        let mut left = MARGIN;
        for panel in panels {
            let title = escape(panel.title);
            let style = r#"font-size="15" fill="black""#;
            writeln!(out, r#"<text x="{left}" y="{}" {FONT} {style}>{title}</text>"#, top - 10.0)?;
            // Within a panel the unit is a cell, so coordinates are short.
            writeln!(out, r#"<g transform="translate({left} {top}) scale({cell})">"#)?;
            write_zones(out, panel, colours)?;
            write_links(out, panel, cell)?;
            if let Some(path) = panel.path {
                write_path(out, panel, path, cell)?;
            }
            writeln!(out, "</g>")?;
            left += panel_width(panel);
        }
    }
    writeln!(out, "</svg>")
}

/// Writes one shape for each zone, made of runs of cells along the rows.
fn write_zones(out: &mut String, panel: &Panel<'_>, colours: Option<&[[u8; 3]]>) -> fmt::Result {
    let Panel { region, zones, .. } = panel;
    let width = region.width() as usize;
    if !region.is_rectangle() {
        // Cells outside are grey, because a zone may be white.
        writeln!(
            out,
            r#"<rect width="{width}" height="{}" fill="{OUTSIDE_COLOUR}"/>"#,
            region.height()
        )?;
    }
    let mut shapes = vec![String::new(); zones.count() as usize];
    for (y, row) in zones.ids().chunks(width).enumerate() {
        let mut x = 0;
        for run in row.chunk_by(|a, b| a == b) {
            if run[0] != Zones::OUTSIDE {
                write!(
                    shapes[usize::from(run[0])],
                    "M{x} {y}h{length}v1h-{length}z",
                    length = run.len()
                )?;
            }
            x += run.len();
        }
    }
    for (zone, shape) in shapes.iter().enumerate().filter(|(_, shape)| !shape.is_empty()) {
        let [red, green, blue] = colour(zone, colours);
        // Without this thin outline, viewers show white lines between the rows.
        let style = format!("#{red:02x}{green:02x}{blue:02x}");
        writeln!(out, r#"<path fill="{style}" stroke="{style}" stroke-width=".04" d="{shape}"/>"#)?;
    }
    Ok(())
}

/// Attributes of all lines.
pub(crate) const STROKE: &str = r#"fill="none" stroke-linecap="round" stroke-linejoin="round""#;

/// The width of a line in cells: the first width, which is in cells, but at least the second, which
/// is in pixels.
///
/// A cell is `cell` pixels wide.
fn line_width((cells, pixels): (f64, f64), cell: f64) -> f64 {
    let hundredths = (100.0 * cells.max(pixels / cell)).round();
    hundredths / 100.0
}

/// Writes links one by one, those between zones on top.
fn write_links(out: &mut String, panel: &Panel<'_>, cell: f64) -> fmt::Result {
    type Links<'a> = Vec<&'a [Cell; 2]>;
    let is_crossing = |link: &&[Cell; 2]| panel.zones.id(link[0]) != panel.zones.id(link[1]);
    let (across, inside): (Links<'_>, Links<'_>) = panel.links.iter().partition(is_crossing);
    for (links, colour, width) in
        [(inside, PATH_COLOUR, PATH_WIDTH), (across, CROSSING_COLOUR, CROSSING_WIDTH)]
    {
        let mut line = String::new();
        for link in &links {
            write_line(&mut line, panel.region, &link[..])?;
        }
        if !line.is_empty() {
            let width = line_width(width, cell);
            writeln!(
                out,
                r#"<path {STROKE} stroke="{colour}" stroke-width="{width}" d="{line}"/>"#
            )?;
        }
    }
    Ok(())
}

/// Writes a path with its crossings and the ends of its pieces; a cell is `cell` pixels wide.
fn write_path(out: &mut String, panel: &Panel<'_>, path: &Path, cell: f64) -> fmt::Result {
    let (region, zones) = (panel.region, panel.zones);
    let line_width = |width: (f64, f64)| line_width(width, cell);
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
            // A line of length 0 with round caps is a disc.
            write!(marks, "M{x} {y}h0")?;
        }
    }
    let width = line_width(PATH_WIDTH);
    writeln!(out, r#"<path {STROKE} stroke="{PATH_COLOUR}" stroke-width="{width}" d="{line}"/>"#)?;
    if !crossings.is_empty() {
        let width = line_width(CROSSING_WIDTH);
        writeln!(
            out,
            r#"<path {STROKE} stroke="{CROSSING_COLOUR}" stroke-width="{width}" d="{crossings}"/>"#
        )?;
    }
    let (mark, hole) =
        (line_width(MARK_WIDTH), line_width((MARK_WIDTH.0 * 0.6, MARK_WIDTH.1 * 0.6)));
    writeln!(
        out,
        r#"<path {STROKE} stroke="{PATH_COLOUR}" stroke-width="{mark}" d="{ends}{starts}"/>"#
    )?;
    writeln!(out, r#"<path {STROKE} stroke="white" stroke-width="{hole}" d="{starts}"/>"#)
}

/// Appends path commands through the centres of the cells, one for each straight stretch.
fn write_line(out: &mut String, region: &Region, cells: &[Cell]) -> fmt::Result {
    let (x, y) = centre(region, cells[0]);
    write!(out, "M{x} {y}")?;
    // Cells are numbered row by row, so the cell numbers along a straight stretch differ by the
    // same amount.
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

/// The fill colour of a zone, light enough for the path to stand out.
fn colour(zone: usize, colours: Option<&[[u8; 3]]>) -> [u8; 3] {
    if let Some(given) = colours.and_then(|colours| colours.get(zone)) {
        return given.map(|channel| 255 - (u16::from(255 - channel) * 2 / 5) as u8);
    }
    PALETTE.get(zone).copied().unwrap_or_else(|| generated_colour(zone - PALETTE.len()))
}

/// A light colour for a zone beyond the palette.
///
/// Successive hues are about a golden angle apart, so neighbouring numbers look different, and hues
/// repeat only after 3600 numbers; three levels of lightness separate colours whose hues are close.
fn generated_colour(number: usize) -> [u8; 3] {
    let hue = (number * 1_379 % 3_600) as f64 / 600.0;
    let (low, high) = [(165.0, 250.0), (130.0, 215.0), (185.0, 235.0)][number % 3];
    let channel = |peak: f64| {
        let away = (hue - peak).abs().min(6.0 - (hue - peak).abs());
        (low + (high - low) * (2.0 - away).clamp(0.0, 1.0)).round() as u8
    };
    [channel(0.0), channel(2.0), channel(4.0)]
}

/// Escapes text for XML; control characters, which XML cannot represent, are replaced.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '\u{fffe}' | '\u{ffff}' => escaped.push(char::REPLACEMENT_CHARACTER),
            _ if character.is_control() => escaped.push(char::REPLACEMENT_CHARACTER),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use beadwork_base::Control;
    use beadwork_grid::{Crossings, Layout, LayoutSpec, Start};

    #[test]
    fn a_small_layer() {
        let region = Region::rectangle(2, 2).unwrap();
        let zones = Zones::new(&region, vec![0, 1, 0, 1]).unwrap();
        let path = Start::RowZigzag.path(&region, &Control::default()).unwrap();
        let panel =
            Panel { title: "a < b", region: &region, zones: &zones, path: Some(&path), links: &[] };
        // With single quotes, so that they need not be escaped.
        let expected = "\
            <svg xmlns='http://www.w3.org/2000/svg' width='128' height='140' \
             viewBox='0 0 128 140'>\n\
            <rect width='100%' height='100%' fill='white'/>\n\
            <text x='16' y='18' font-family='Helvetica, Arial, sans-serif' font-size='15' \
             fill='black'>a &lt; b</text>\n\
            <g transform='translate(16 28) scale(48)'>\n\
            <path fill='#fad080' stroke='#fad080' stroke-width='.04' \
             d='M0 0h1v1h-1zM0 1h1v1h-1z'/>\n\
            <path fill='#add8f0' stroke='#add8f0' stroke-width='.04' \
             d='M1 0h1v1h-1zM1 1h1v1h-1z'/>\n\
            <path fill='none' stroke-linecap='round' stroke-linejoin='round' stroke='#1d2126' \
             stroke-width='0.14' d='M0.5 0.5h1v1h-1'/>\n\
            <path fill='none' stroke-linecap='round' stroke-linejoin='round' stroke='#e0001b' \
             stroke-width='0.3' d='M0.5 0.5h1M1.5 1.5h-1'/>\n\
            <path fill='none' stroke-linecap='round' stroke-linejoin='round' stroke='#1d2126' \
             stroke-width='0.6' d='M0.5 1.5h0M0.5 0.5h0'/>\n\
            <path fill='none' stroke-linecap='round' stroke-linejoin='round' stroke='white' \
             stroke-width='0.36' d='M0.5 0.5h0'/>\n\
            </g>\n\
            </svg>\n"
            .replace('\'', "\"");
        assert_eq!(svg(&[panel], None), expected);
    }

    #[test]
    fn every_crossing_is_red() {
        for seed in 0..20 {
            let region = Region::rectangle(17, 12).unwrap();
            let zones = LayoutSpec { zones: 20, ..LayoutSpec::new(Layout::Voronoi) }
                .zones(&region, seed)
                .unwrap();
            let path = Start::Spiral.path(&region, &Control::default()).unwrap();
            let panel =
                Panel { title: "", region: &region, zones: &zones, path: Some(&path), links: &[] };
            let drawing = svg(&[panel, Panel { path: None, ..panel }], None);
            let red = drawing.lines().find(|line| line.contains(CROSSING_COLOUR)).unwrap();
            let crossings = red.split(" d=\"").nth(1).unwrap().matches('M').count();
            assert_eq!(crossings, Crossings::new(&region, &zones).count(&path) as usize);
        }
    }

    #[test]
    fn thin_layers_and_paths_of_several_pieces() {
        let column = Region::rectangle(1, 5).unwrap();
        let zones = LayoutSpec::new(Layout::TopBottom).zones(&column, 0).unwrap();
        let path = Start::RowZigzag.path(&column, &Control::default()).unwrap();
        let drawing = svg(
            &[Panel { title: "", region: &column, zones: &zones, path: Some(&path), links: &[] }],
            None,
        );
        assert!(drawing.contains(r#"d="M0.5 0.5v4""#), "{drawing}");
        let apart = Region::from_mask(2, 2, vec![true, false, false, true]).unwrap();
        let zones = Zones::new(&apart, vec![0; 4]).unwrap();
        let path = Start::Cover.path(&apart, &Control::default()).unwrap();
        let drawing = svg(
            &[Panel { title: "", region: &apart, zones: &zones, path: Some(&path), links: &[] }],
            Some(&[[0; 3]]),
        );
        assert!(
            drawing.contains(r#"d="M0.5 0.5M1.5 1.5""#) && drawing.contains("#999999"),
            "{drawing}"
        );
    }

    /// Whether all tags are closed in the right order and the text between them has no markup.
    fn is_balanced(drawing: &str) -> bool {
        let mut open = Vec::new();
        for tag in drawing.split('<').skip(1) {
            let Some((tag, text)) = tag.split_once('>') else { return false };
            if text.contains('>') || tag.matches('"').count() % 2 == 1 {
                return false;
            }
            if let Some(name) = tag.strip_prefix('/') {
                if open.pop() != Some(name) {
                    return false;
                }
            } else if !tag.ends_with('/') {
                open.push(tag.split(' ').next().unwrap());
            }
        }
        open.is_empty()
    }

    #[test]
    fn any_title_is_well_formed() {
        let region = Region::rectangle(3, 2).unwrap();
        let zones = LayoutSpec::new(Layout::Stripes).zones(&region, 0).unwrap();
        let path = Start::Spiral.path(&region, &Control::default()).unwrap();
        for title in
            ["", "</text><g>", "a > b & c", "\"quoted\" 'twice'", "bell\u{7}, \0 and \u{ffff}"]
        {
            let panel =
                Panel { title, region: &region, zones: &zones, path: Some(&path), links: &[] };
            let drawing = svg(&[panel, panel], None);
            assert!(is_balanced(&drawing), "{drawing}");
            assert!(!drawing.contains(|c: char| (c.is_control() && c != '\n') || c == '\u{ffff}'));
        }
        assert!(is_balanced(&svg(&[], None)));
        assert_eq!(escape("&lt; <\u{1b}>"), "&amp;lt; &lt;\u{fffd}&gt;");
    }

    #[test]
    fn panels_have_expected_positions_and_sizes() {
        let size = |width: u32, height: u32, title: &str| {
            let region = Region::rectangle(width, height).unwrap();
            let zones = Zones::new(&region, vec![0; region.grid_len()]).unwrap();
            let panel = Panel { title, region: &region, zones: &zones, path: None, links: &[] };
            let drawing = svg(&[panel, panel], None);
            let view = drawing.split("viewBox=\"0 0 ").nth(1).unwrap().split('"').next().unwrap();
            let (width, height) = view.split_once(' ').unwrap();
            (width.parse::<u32>().unwrap(), height.parse::<u32>().unwrap())
        };
        assert_eq!(size(30, 30, ""), (16 + 2 * 496, 28 + 480 + 16));
        assert_eq!(size(130, 130, ""), (16 + 2 * 536, 28 + 520 + 16));
        assert_eq!(
            size(1, 96, ""),
            (16 + 2 * 21, 28 + 480 + 16),
            "cells of a tall layer are small"
        );
        assert_eq!(
            size(1, 1, "a title of 21 letters"),
            (16 + 2 * 205, 28 + 48 + 16),
            "titles do not overlap"
        );
    }

    #[test]
    fn all_zones_have_different_light_colours() {
        let mut fills: Vec<[u8; 3]> =
            (0..Zones::MAX as usize).map(|zone| colour(zone, None)).collect();
        assert!(fills.iter().flatten().all(|&channel| channel >= 120));
        fills.sort_unstable();
        fills.dedup();
        assert_eq!(fills.len(), Zones::MAX as usize);
        assert_eq!(colour(1, Some(&[[0; 3]])), PALETTE[1], "a zone without a given colour");
    }
}
