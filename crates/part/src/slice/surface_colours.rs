//! Materials of a body whose triangles have colours: colours propagate from the surface inwards.
//!
//! A colour is the number of a material.
//! A cell takes the colour of the line of the outline that is nearest to its centre.
//! Lines are compared in cells along the outline; every other cell compares those of the nearest
//! outline cells.
//! Where a top or bottom face is nearer than the outline, and not deeper than the depth of colours,
//! cells take its colour instead.

use super::nearest_seed::nearest_seeds;
use super::outline::{FillRule, Outline};
use super::raster::for_each_run;
use super::rectangle::Rectangle;
use super::surface_columns::SurfaceColumns;
use crate::frame::Frame;

/// Writes the colours of a body's cells into the materials of a layer; other cells stay unchanged.
///
/// Cells that no colour reaches take the first colour of the outline.
/// Linear in the length of the outline and in the cells of its bounding rectangle, not of the whole
/// layer: there may be many small bodies on a large grid.
pub(super) fn propagate(
    outline: &Outline,
    faces: &Faces<'_>,
    rule: FillRule,
    frame: &Frame,
    materials: &mut [u8],
) {
    let Some(cells) = Cells::coloured(outline, faces, rule, frame) else { return };
    for index in (0..cells.inside.len()).filter(|&index| cells.inside[index]) {
        let (column, row) = cells.rectangle.column_and_row(index);
        materials[row * frame.width as usize + column] = cells.colour(index);
    }
}

/// The colours of all cells of the rectangle around a body, also of those outside the body.
///
/// Cells inside have the colours that [`propagate`] writes; those outside the colour of the nearest
/// line of the outline.
/// `None` if the grid has no cell near the outline.
pub(super) fn colours_around(
    outline: &Outline,
    faces: &Faces<'_>,
    rule: FillRule,
    frame: &Frame,
) -> Option<(Rectangle, Vec<u8>)> {
    let mut cells = Cells::coloured(outline, faces, rule, frame)?;
    let inside = std::mem::take(&mut cells.inside);
    let colours: Vec<u8> = (0..inside.len()).map(|index| cells.colour(index)).collect();
    // Lines of cells outside are not compared before, so that they cannot affect those inside.
    cells.inside = vec![true; inside.len()];
    cells.propagate(frame);
    let colour = |index: usize| if inside[index] { colours[index] } else { cells.colour(index) };
    let colours = (0..inside.len()).map(colour).collect();
    Some((cells.rectangle, colours))
}

/// The top and bottom faces of a body, as seen from the cells of a layer.
pub(super) struct Faces<'a> {
    pub(super) columns: &'a SurfaceColumns,
    /// Height of the cells' centres in mm.
    pub(super) z_mm: f64,
    /// Depth to which colours reach, in mm.
    pub(super) depth_mm: f64,
}

/// A line of an outline, and its colour.
#[derive(Clone, Copy)]
struct Line {
    from: [f64; 2],
    to: [f64; 2],
    colour: u8,
}

impl Line {
    /// Distance from a point to the nearest point of the line, in mm.
    fn distance_mm(&self, point: [f64; 2]) -> f64 {
        let [dx, dy] = [0, 1].map(|axis| self.to[axis] - self.from[axis]);
        let [x, y] = [0, 1].map(|axis| point[axis] - self.from[axis]);
        let squared = dx * dx + dy * dy;
        let along = if squared > 0.0 { ((x * dx + y * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
        (x - along * dx).hypot(y - along * dy)
    }
}

/// The cells of a rectangle, row by row.
struct Cells {
    rectangle: Rectangle,
    /// Whether each belongs to the body.
    inside: Vec<bool>,
    /// The lines of the outline that have a colour.
    lines: Vec<Line>,
    /// The nearest line of each cell, as far as it is known; [`Cells::NO_LINE`] otherwise.
    line: Vec<u32>,
    /// Distance from the centre of each cell to that line, in mm; infinite without one.
    distance_mm: Vec<f64>,
    colours: Vec<u8>,
}

impl Cells {
    const NO_LINE: u32 = u32::MAX;

    fn new(rectangle: Rectangle) -> Self {
        let count = rectangle.len();
        Self {
            rectangle,
            inside: vec![false; count],
            lines: Vec::new(),
            line: vec![Self::NO_LINE; count],
            distance_mm: vec![f64::INFINITY; count],
            colours: vec![0; count],
        }
    }

    /// The cells around an outline, with the colours of those inside.
    fn coloured(
        outline: &Outline,
        faces: &Faces<'_>,
        rule: FillRule,
        frame: &Frame,
    ) -> Option<Self> {
        let rectangle = Rectangle::around(outline.loops().flatten().copied(), frame)?;
        let mut cells = Self::new(rectangle);
        cells.fill(outline, rule, frame);
        cells.colour_outline(outline, frame);
        cells.propagate(frame);
        cells.colour_faces(faces);
        Some(cells)
    }

    /// The colour of a cell; the first one of the outline if no line reached the cell.
    fn colour(&self, index: usize) -> u8 {
        if self.distance_mm[index].is_finite() {
            self.colours[index]
        } else {
            self.lines.first().map_or(0, |line| line.colour)
        }
    }

    fn fill(&mut self, outline: &Outline, rule: FillRule, frame: &Frame) {
        for_each_run(outline, rule, frame, |row, first, end| {
            let begin = self.rectangle.index(first as usize, row as usize);
            self.inside[begin..begin + (end - first) as usize].fill(true);
        });
    }

    /// Finds the nearest lines of the cells along the outline, inside and outside the body.
    fn colour_outline(&mut self, outline: &Outline, frame: &Frame) {
        for (from, to, colour) in outline.lines() {
            let Some(colour) = colour else { continue };
            let number = self.lines.len() as u32;
            self.lines.push(Line { from, to, colour });
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            // Two samples per cell, so that the line crosses no cell unnoticed.
            let steps = (2.0 * length / frame.cell_mm).ceil().max(1.0);
            for step in 0..=steps as u32 {
                let part = f64::from(step) / steps;
                let sample = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
                self.colour_around(sample, number, frame);
            }
        }
    }

    /// Offers a line to the cell that holds one of its points, and to the four neighbours.
    fn colour_around(&mut self, point: [f64; 2], line: u32, frame: &Frame) {
        let [column, row] = frame.column_and_row(point);
        for (right, down) in [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let (column, row) = (column + right, row + down);
            if self.rectangle.contains(column, row) {
                self.offer(self.rectangle.index(column as usize, row as usize), line, frame);
            }
        }
    }

    /// Gives a cell a line, if it is nearer than the one it has.
    fn offer(&mut self, cell: usize, line: u32, frame: &Frame) {
        let (column, row) = self.rectangle.column_and_row(cell);
        let centre = frame.centre(column as u32, row as u32);
        let Line { colour, .. } = self.lines[line as usize];
        let distance_mm = self.lines[line as usize].distance_mm(centre);
        if distance_mm < self.distance_mm[cell] {
            (self.line[cell], self.distance_mm[cell]) = (line, distance_mm);
            self.colours[cell] = colour;
        }
    }

    /// Finds the nearest line of each cell inside.
    ///
    /// The first guess is the line of the nearest outline cell.
    /// Distances between the centres of cells rank outline cells only roughly, so each cell then
    /// also compares the lines of its neighbours, once forwards and once backwards over all cells.
    fn propagate(&mut self, frame: &Frame) {
        let width = self.rectangle.columns.len();
        let is_seed: Vec<bool> = self.line.iter().map(|&line| line != Self::NO_LINE).collect();
        let Some(nearest) = nearest_seeds(width, &is_seed) else { return };
        for cell in 0..is_seed.len() {
            if self.inside[cell] && !is_seed[cell] {
                // Outline cells keep their lines while this loop runs.
                self.offer(cell, self.line[nearest[cell] as usize], frame);
            }
        }
        let count = is_seed.len();
        let mut compare = |cell: usize| {
            if !self.inside[cell] {
                return;
            }
            let (column, row) = (cell % width, cell / width);
            for row in row.saturating_sub(1)..(row + 2).min(count / width) {
                for column in column.saturating_sub(1)..(column + 2).min(width) {
                    let line = self.line[row * width + column];
                    if line != Self::NO_LINE {
                        self.offer(cell, line, frame);
                    }
                }
            }
        };
        (0..count).for_each(&mut compare);
        (0..count).rev().for_each(&mut compare);
    }

    /// Gives cells the colour of a face above or below them that is nearer than the outline.
    fn colour_faces(&mut self, faces: &Faces<'_>) {
        for index in (0..self.inside.len()).filter(|&index| self.inside[index]) {
            let (column, row) = self.rectangle.column_and_row(index);
            let nearest = faces.columns.nearest(column, row, faces.z_mm);
            if let Some((distance_mm, colour)) = nearest
                && distance_mm <= faces.depth_mm
                && distance_mm < self.distance_mm[index]
            {
                self.distance_mm[index] = distance_mm;
                self.colours[index] = colour;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 1_000,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        /// Compared with the distances to all lines: the line that a cell has its colour from is
        /// farther than the nearest one by at most a fifth of a cell.
        #[test]
        fn cells_have_the_nearest_line(radii in prop::collection::vec(2.0..10.0_f64, 3..30)) {
            let mut outline = Outline::default();
            for (number, radius) in radii.iter().enumerate() {
                let angle = std::f64::consts::TAU * number as f64 / radii.len() as f64;
                outline.push([radius * angle.cos(), radius * angle.sin()], Some(number as u8));
            }
            outline.close();
            let frame = Frame {
                left_mm: -10.0,
                back_mm: 10.0,
                cell_mm: 0.5,
                layer_mm: 0.2,
                width: 40,
                height: 40,
            };
            let corners = outline.loops().flatten().copied();
            let mut cells = Cells::new(Rectangle::around(corners, &frame).unwrap());
            cells.fill(&outline, FillRule::NonZero, &frame);
            cells.colour_outline(&outline, &frame);
            cells.propagate(&frame);
            for cell in (0..cells.inside.len()).filter(|&cell| cells.inside[cell]) {
                let (column, row) = cells.rectangle.column_and_row(cell);
                let centre = frame.centre(column as u32, row as u32);
                let distances = cells.lines.iter().map(|line| line.distance_mm(centre));
                let min_mm = distances.fold(f64::INFINITY, f64::min);
                let excess_mm = cells.distance_mm[cell] - min_mm;
                prop_assert!((0.0..0.1).contains(&excess_mm), "{} mm at {:?}", excess_mm, centre);
            }
        }
    }
}
