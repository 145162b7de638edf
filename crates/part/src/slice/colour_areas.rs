//! The areas that the colours of a painted body have in a layer.

use super::outline::Outline;
use super::settings::Settings;
use super::surface_colours::{Faces, colours_around};
use crate::area::{Area, Ring};
use crate::frame::Frame;

/// The area of each colour, in the order of the colours; together they are `area`, the inside of
/// the outline.
///
/// The outer border is the outline itself; borders between colours follow the cells of the grid.
pub(super) fn colour_areas(
    outline: &Outline,
    area: Area,
    faces: &Faces<'_>,
    settings: &Settings,
    frame: &Frame,
) -> Vec<(u8, Area)> {
    let first = outline.lines().find_map(|(_, _, colour)| colour).unwrap_or(0);
    let Some((rectangle, colours)) = colours_around(outline, faces, settings.fill_rule, frame)
    else {
        return vec![(first, area)];
    };
    let mut found = colours.clone();
    found.sort_unstable();
    found.dedup();
    if let [colour] = found[..] {
        return vec![(colour, area)];
    }
    // Squares at the border of the rectangle extend beyond the outline, which may be larger than
    // the grid by a tolerance.
    let (columns, rows) = (rectangle.columns.len(), rectangle.rows.len());
    let border = |at: usize, count: usize, first: usize| {
        let beyond = if at == 0 { -1.0 } else { f64::from(u8::from(at == count)) };
        (first + at) as f64 + beyond
    };
    let x =
        |column| frame.left_mm + border(column, columns, rectangle.columns.start) * frame.cell_mm;
    let y = |row| frame.back_mm - border(row, rows, rectangle.rows.start) * frame.cell_mm;
    let squares = |colour: u8| {
        let mut runs: Vec<Ring> = Vec::new();
        for (row, cells) in colours.chunks(columns).enumerate() {
            let mut column = 0;
            for run in cells.chunk_by(|a, b| a == b) {
                let (from, to) = (x(column), x(column + run.len()));
                column += run.len();
                if run[0] == colour {
                    let (back, front) = (y(row), y(row + 1));
                    runs.push(vec![[from, front], [to, front], [to, back], [from, back]]);
                }
            }
        }
        Area::from_rings(&runs, super::FillRule::NonZero)
    };
    found.into_iter().map(|colour| (colour, squares(colour).intersection(&area))).collect()
}
