//! Materials of a body whose triangles have colours: colours propagate from the surface inwards.
//!
//! A colour is the number of a material.
//! Cells along the outline take the colour of the line that passes nearest to their centre.
//! A breadth-first search then carries the colours inwards: every other cell takes the colour of an
//! outline cell that is the fewest steps away.
//! Where a top or bottom face is nearer than the outline, and not deeper than the depth of colours,
//! cells take its colour instead.

use std::collections::VecDeque;

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
    let Some(rectangle) = Rectangle::around(outline.loops().flatten().copied(), frame) else {
        return;
    };
    let mut cells = Cells::new(rectangle);
    cells.fill(outline, rule, frame);
    let first_colour = cells.colour_outline(outline, frame);
    cells.propagate(frame.cell_mm);
    cells.colour_faces(faces);
    let unreached = first_colour.unwrap_or_default();
    for index in (0..cells.inside.len()).filter(|&index| cells.inside[index]) {
        let is_reached = cells.distance_mm[index].is_finite();
        let (column, row) = cells.rectangle.column_and_row(index);
        materials[row * frame.width as usize + column] =
            if is_reached { cells.colours[index] } else { unreached };
    }
}

/// The top and bottom faces of a body, as seen from the cells of a layer.
pub(super) struct Faces<'a> {
    pub(super) columns: &'a SurfaceColumns,
    /// Height of the cells' centres in mm.
    pub(super) z_mm: f64,
    /// Depth to which colours reach, in mm.
    pub(super) depth_mm: f64,
}

/// The cells of a rectangle, row by row.
struct Cells {
    rectangle: Rectangle,
    /// Whether each belongs to the body.
    inside: Vec<bool>,
    colours: Vec<u8>,
    /// Distance from the centre of each outline cell to the line it has its colour from, in mm; in
    /// other cells one cell more than in the neighbour that passed its colour on; infinite without
    /// a colour.
    distance_mm: Vec<f64>,
}

impl Cells {
    fn new(rectangle: Rectangle) -> Self {
        let count = rectangle.columns.len() * rectangle.rows.len();
        Self {
            rectangle,
            inside: vec![false; count],
            colours: vec![0; count],
            distance_mm: vec![f64::INFINITY; count],
        }
    }

    fn fill(&mut self, outline: &Outline, rule: FillRule, frame: &Frame) {
        for_each_run(outline, rule, frame, |row, first, end| {
            let begin = self.rectangle.index(first as usize, row as usize);
            self.inside[begin..begin + (end - first) as usize].fill(true);
        });
    }

    /// Gives the cells along the outline their colours; returns the first colour of the outline.
    fn colour_outline(&mut self, outline: &Outline, frame: &Frame) -> Option<u8> {
        let mut first_colour = None;
        for (from, to, colour) in outline.lines() {
            let Some(colour) = colour else { continue };
            first_colour = first_colour.or(Some(colour));
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            // Two samples per cell, so that the line crosses no cell unnoticed.
            let steps = (2.0 * length / frame.cell_mm).ceil().max(1.0);
            for step in 0..=steps as u32 {
                let part = f64::from(step) / steps;
                let sample = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
                self.colour_around(sample, colour, frame);
            }
        }
        first_colour
    }

    /// Offers a colour to the cell that holds a point of the outline and to its four neighbours:
    /// the centre of the cell itself may be outside the body, and that of a neighbour inside.
    fn colour_around(&mut self, point: [f64; 2], colour: u8, frame: &Frame) {
        let column = ((point[0] - frame.left_mm) / frame.cell_mm).floor();
        let row = ((frame.back_mm - point[1]) / frame.cell_mm).floor();
        for (right, down) in [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let (column, row) = (column + right, row + down);
            if !self.rectangle.contains(column, row) {
                continue;
            }
            let index = self.rectangle.index(column as usize, row as usize);
            let centre = frame.centre(column as u32, row as u32);
            let distance_mm = (centre[0] - point[0]).hypot(centre[1] - point[1]);
            if self.inside[index] && distance_mm < self.distance_mm[index] {
                self.distance_mm[index] = distance_mm;
                self.colours[index] = colour;
            }
        }
    }

    /// Passes colours on from cell to cell: a breadth-first search from all coloured cells at once.
    fn propagate(&mut self, cell_mm: f64) {
        let count = self.inside.len();
        let width = self.rectangle.columns.len();
        let mut queue: VecDeque<usize> =
            (0..count).filter(|&index| self.distance_mm[index].is_finite()).collect();
        while let Some(index) = queue.pop_front() {
            let column = index % width;
            let right = (column + 1 < width).then_some(index + 1);
            let left = (column > 0).then(|| index - 1);
            let below = (index + width < count).then_some(index + width);
            let above = index.checked_sub(width);
            for neighbour in [right, below, left, above].into_iter().flatten() {
                if self.inside[neighbour] && self.distance_mm[neighbour].is_infinite() {
                    self.distance_mm[neighbour] = self.distance_mm[index] + cell_mm;
                    self.colours[neighbour] = self.colours[index];
                    queue.push_back(neighbour);
                }
            }
        }
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
