//! A drawing of all patterns.

use std::fmt::{self, Write};

use beadwork_grid::{Cell, Region};

use super::table::Pattern;
use crate::svg::{FONT, PATH_COLOUR, STROKE};

/// A small layer with features that orders treat differently: a slanted side, a notch, and a hole
/// of several cells.
const LAYER: [&str; 10] = [
    "..##########",
    ".###########",
    "############",
    "####...#####",
    "####...#####",
    "############",
    "############",
    "#######..###",
    "#######..###",
    "#######..###",
];

const FILL_COLOUR: &str = "#e4ebf2";
const JUMP_COLOUR: &str = "#949da8";
const START_COLOUR: &str = "#00915c";
const END_COLOUR: &str = "#e0001b";

/// Thumbnails in a row.
/// Families have eight patterns or four, so with eight each row starts with a new family.
const PER_ROW: usize = 8;

// In pixels.
const CELL: u32 = 13;
const GAP: u32 = 22;
const TITLE_HEIGHT: u32 = 24;
const LEGEND_HEIGHT: u32 = 30;

// In cells.
const LINE_WIDTH: f64 = 0.14;
const JUMP_WIDTH: f64 = 0.08;
const MARK_WIDTH: f64 = 0.62;

/// Draws all 38 patterns on a small layer, as SVG.
///
/// Each thumbnail shows number, name, and the path from the first cell (green) to the last (red).
///
/// Steps between cells that touch at a side or a corner are solid lines; longer jumps are thin,
/// grey and dashed.
/// The output is the same on every machine.
pub fn pattern_sheet() -> String {
    let mut text = String::new();
    write_sheet(&mut text).expect("writing to a string cannot fail");
    text
}

fn write_sheet(out: &mut String) -> fmt::Result {
    let mask = LAYER.iter().flat_map(|row| row.bytes().map(|cell| cell == b'#')).collect();
    let region = Region::from_mask(LAYER[0].len() as u32, LAYER.len() as u32, mask)
        .expect("the rows are equally long and have cells");
    let (across, down) = (region.width() * CELL + GAP, region.height() * CELL + GAP + TITLE_HEIGHT);
    let width = GAP + PER_ROW as u32 * across;
    let height = Pattern::COUNT.div_ceil(PER_ROW) as u32 * down + LEGEND_HEIGHT;
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">"
    )?;
    writeln!(out, r#"<rect width="100%" height="100%" fill="white"/>"#)?;
    write_defs(out, &region)?;
    for pattern in Pattern::ALL {
        let (row, column) = (pattern.number() / PER_ROW, pattern.number() % PER_ROW);
        let (left, top) =
            (GAP + column as u32 * across, row as u32 * down + GAP / 2 + TITLE_HEIGHT);
        writeln!(
            out,
            "<text x=\"{left}\" y=\"{}\" {FONT} font-size=\"13\"><tspan fill=\"#6b7480\">{}\
             </tspan> {pattern}</text>",
            top - 8,
            pattern.number(),
        )?;
        writeln!(out, r#"<g transform="translate({left} {top}) scale({CELL})">"#)?;
        write_pattern(out, &region, &pattern.order(&region))?;
        writeln!(out, "</g>")?;
    }
    write_legend(out, height - LEGEND_HEIGHT / 2)?;
    writeln!(out, "</svg>")
}

/// The shape of the layer, defined once and used by each thumbnail.
fn write_defs(out: &mut String, region: &Region) -> fmt::Result {
    let mut shape = String::new();
    for y in 0..region.height() {
        let row: Vec<bool> =
            (0..region.width()).map(|x| region.contains(region.cell(x, y))).collect();
        let mut x = 0;
        for run in row.chunk_by(|a, b| a == b) {
            if run[0] {
                write!(shape, "M{x} {y}h{length}v1h-{length}z", length = run.len())?;
            }
            x += run.len();
        }
    }
    let style = format!(r#"fill="{FILL_COLOUR}" stroke="{FILL_COLOUR}" stroke-width=".04""#);
    writeln!(out, r#"<defs><path id="layer" {style} d="{shape}"/></defs>"#)
}

fn write_pattern(out: &mut String, region: &Region, order: &[Cell]) -> fmt::Result {
    let touch = |a: Cell, b: Cell| {
        let ((ax, ay), (bx, by)) = (region.xy(a), region.xy(b));
        ax.abs_diff(bx).max(ay.abs_diff(by)) == 1
    };
    let mut jumps = String::new();
    for jump in order.windows(2).filter(|step| !touch(step[0], step[1])) {
        write_line(&mut jumps, region, jump)?;
    }
    let mut line = String::new();
    for stretch in order.chunk_by(|&a, &b| touch(a, b)) {
        write_line(&mut line, region, stretch)?;
    }
    writeln!(out, r##"<use href="#layer"/>"##)?;
    if !jumps.is_empty() {
        let dashes = r#"stroke-dasharray="0.3 0.22" stroke-linecap="butt""#;
        writeln!(
            out,
            "<path fill=\"none\" {dashes} stroke=\"{JUMP_COLOUR}\" stroke-width=\"{JUMP_WIDTH}\" \
             d=\"{jumps}\"/>"
        )?;
    }
    writeln!(
        out,
        r#"<path {STROKE} stroke="{PATH_COLOUR}" stroke-width="{LINE_WIDTH}" d="{line}"/>"#
    )?;
    for (cell, colour) in [(order[0], START_COLOUR), (order[order.len() - 1], END_COLOUR)] {
        let mut mark = String::new();
        write_line(&mut mark, region, &[cell])?;
        writeln!(
            out,
            r#"<path {STROKE} stroke="{colour}" stroke-width="{MARK_WIDTH}" d="{mark}h0"/>"#
        )?;
    }
    Ok(())
}

/// Appends path commands through the centres of the cells, one for each straight stretch.
fn write_line(out: &mut String, region: &Region, cells: &[Cell]) -> fmt::Result {
    let position = |cell: Cell| {
        let (x, y) = region.xy(cell);
        (x as i32, y as i32)
    };
    let (x, y) = position(cells[0]);
    write!(out, "M{x}.5 {y}.5")?;
    let step = |pair: &[Cell]| {
        let ((ax, ay), (bx, by)) = (position(pair[0]), position(pair[1]));
        (bx - ax, by - ay)
    };
    let steps: Vec<(i32, i32)> = cells.windows(2).map(step).collect();
    for stretch in steps.chunk_by(|a, b| a == b) {
        let count = stretch.len() as i32;
        match stretch[0] {
            (along, 0) => write!(out, "h{}", along * count)?,
            (0, down) => write!(out, "v{}", down * count)?,
            (along, down) => write!(out, "l{} {}", along * count, down * count)?,
        }
    }
    Ok(())
}

/// The legend, centred on the height `y`.
fn write_legend(out: &mut String, y: u32) -> fmt::Result {
    let text = format!(r##"{FONT} font-size="13" fill="#6b7480""##);
    // Not all viewers support vertical centring of text.
    let baseline = y + 5;
    let dot = MARK_WIDTH * f64::from(CELL);
    let mut x = GAP;
    for (label, colour) in [("first cell", START_COLOUR), ("last cell", END_COLOUR)] {
        writeln!(
            out,
            r#"<path {STROKE} stroke="{colour}" stroke-width="{dot:.1}" d="M{} {y}h0"/>"#,
            x + 5
        )?;
        writeln!(out, r#"<text x="{}" y="{baseline}" {text}>{label}</text>"#, x + 16)?;
        x += 100;
    }
    let dashes = r#"stroke-dasharray="4 3""#;
    writeln!(out, r#"<path fill="none" {dashes} stroke="{JUMP_COLOUR}" d="M{x} {y}h32"/>"#)?;
    writeln!(out, r#"<text x="{}" y="{baseline}" {text}>jump</text>"#, x + 40)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the committed picture with the output.
    /// To update it: `BEADWORK_BLESS=1 cargo test -p beadwork-part sheet`.
    #[test]
    fn the_committed_sheet_is_up_to_date() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/pictures/patterns.svg");
        let sheet = pattern_sheet();
        if std::env::var_os("BEADWORK_BLESS").is_some() {
            std::fs::write(file, &sheet).unwrap();
        }
        let committed = std::fs::read_to_string(file).unwrap().replace("\r\n", "\n");
        assert!(
            committed == sheet,
            "docs/pictures/patterns.svg is out of date: see this test's comment"
        );
    }

    #[test]
    fn each_pattern_has_its_thumbnail() {
        let sheet = pattern_sheet();
        for pattern in Pattern::ALL {
            let title = format!("{}</tspan> {pattern}<", pattern.number());
            assert_eq!(sheet.matches(&title).count(), 1, "{pattern}");
        }
        assert_eq!(sheet.matches("<use ").count(), Pattern::COUNT);
    }
}
