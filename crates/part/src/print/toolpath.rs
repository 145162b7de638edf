//! Toolpaths: the common form in which cells and beads reach the writer.

use beadwork_gcode::{Feature, Number};

use super::layer::Run;
use super::process::Process;
use super::settings::Settings;
use super::text::{DECIMALS, number};
use crate::{Bead, ExtrusionMove, Frame};

/// Minimum length of filament of a move, in mm.
/// Less could be rounded to 0 together with what rounding has withheld before.
const MIN_FILAMENT_MM: f64 = 2e-5;

/// A bead with everything that the writer needs to know.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Toolpath {
    pub(super) tool: u8,
    /// Where it begins: x and y in mm.
    pub(super) start_mm: [f64; 2],
    /// At least one move.
    pub(super) moves: Vec<ToolpathMove>,
}

/// A move that extrudes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ToolpathMove {
    /// Where it ends: x and y in mm.
    pub(super) to_mm: [f64; 2],
    pub(super) filament_mm: f64,
    pub(super) width_mm: f64,
    pub(super) feature: Feature,
    pub(super) speed_mm_s: f64,
}

impl Toolpath {
    /// The toolpath along corners of cells, which are given in units of half a cell; `None` without
    /// corners.
    /// `position_mm` maps corners to the bed.
    pub(super) fn along_cells(
        corners: &[[i32; 2]],
        position_mm: impl Fn([i32; 2]) -> [f64; 2],
        (tool, feature): (u8, Feature),
        layer: usize,
        frame: &Frame,
        settings: &Settings,
    ) -> Option<Self> {
        let process = &settings.process;
        let filament_mm2 = settings.tools[usize::from(tool)].filament_mm2();
        let mm_per_half = 0.5 * frame.cell_mm * process.bead_mm2(frame) / filament_mm2;
        let speed_mm_s = if layer == 0 { process.first_layer_mm_s } else { process.print_mm_s };
        let start_mm = position_mm(*corners.first()?);
        let moves = corners.windows(2).map(|pair| {
            let halves = pair[0][0].abs_diff(pair[1][0]) + pair[0][1].abs_diff(pair[1][1]);
            ToolpathMove {
                to_mm: position_mm(pair[1]),
                filament_mm: f64::from(halves) * mm_per_half,
                width_mm: frame.cell_mm,
                feature,
                speed_mm_s,
            }
        });
        Some(Self { tool, start_mm, moves: moves.collect() })
    }

    /// The toolpath of a run of cells of the part.
    pub(super) fn of_run(
        run: &Run<'_>,
        column_and_row: impl Fn(u32) -> [i32; 2],
        layer: usize,
        frame: &Frame,
        settings: &Settings,
    ) -> Option<Self> {
        let Frame { left_mm, back_mm, cell_mm, .. } = *frame;
        let along = |halves: i32| f64::from(halves) / 2.0 * cell_mm;
        let position_mm = |[x, y]: [i32; 2]| [left_mm + along(x), back_mm - along(y)];
        let corners = run.toolpath(column_and_row);
        let kind = (run.zone, Feature::SolidInfill);
        Self::along_cells(&corners, position_mm, kind, layer, frame, settings)
    }

    /// The toolpath of a bead; `None` if the bead vanishes.
    ///
    /// Moves that are too short for the decimals of a file are merged with the next one: those that
    /// end where they begin, and those with less than [`MIN_FILAMENT_MM`].
    /// If the last move of the bead is too short, it is merged with the one before.
    /// A bead vanishes if no move is left.
    pub(super) fn of_bead(
        bead: &Bead,
        layer: usize,
        frame: &Frame,
        settings: &Settings,
    ) -> Option<Self> {
        let filament_mm2 = settings.tools[usize::from(bead.tool)].filament_mm2();
        let speeds = speeds_mm_s(bead, layer, &settings.process);
        let mut moves: Vec<ToolpathMove> = Vec::with_capacity(bead.moves.len());
        let start = rounded(bead.start_mm);
        let is_short = |from: [Number; 2], step: &ToolpathMove| {
            rounded(step.to_mm) == from || step.filament_mm < MIN_FILAMENT_MM
        };
        let mut at = start;
        let mut withheld_mm = 0.0;
        for ((step, (from, to, _)), speed_mm_s) in bead.moves.iter().zip(bead.lines()).zip(speeds) {
            let section_mm2 = settings.process.section_mm2(step.width_mm, frame.layer_mm);
            let step = ToolpathMove {
                to_mm: to,
                filament_mm: withheld_mm + distance_mm(from, to) * section_mm2 / filament_mm2,
                width_mm: step.width_mm,
                feature: step.feature,
                speed_mm_s,
            };
            if is_short(at, &step) {
                withheld_mm = step.filament_mm;
            } else {
                withheld_mm = 0.0;
                at = rounded(to);
                moves.push(step);
            }
        }
        let end_mm = bead.end_mm();
        while withheld_mm > 0.0 || at != rounded(end_mm) {
            let last = moves.pop()?;
            let step =
                ToolpathMove { to_mm: end_mm, filament_mm: last.filament_mm + withheld_mm, ..last };
            at = moves.last().map_or(start, |before| rounded(before.to_mm));
            withheld_mm = step.filament_mm;
            if !is_short(at, &step) {
                withheld_mm = 0.0;
                at = rounded(end_mm);
                moves.push(step);
            }
        }
        let is_printed = !moves.is_empty();
        is_printed.then_some(Self { tool: bead.tool, start_mm: bead.start_mm, moves })
    }

    /// Where it ends: x and y in mm.
    pub(super) fn end_mm(&self) -> [f64; 2] {
        self.moves.last().map_or(self.start_mm, |last| last.to_mm)
    }
}

/// The speed of each move of a bead.
fn speeds_mm_s(bead: &Bead, layer: usize, process: &Process) -> Vec<f64> {
    let mut speeds = Vec::with_capacity(bead.moves.len());
    let mut start_mm = bead.start_mm;
    for section in bead.moves.chunk_by(|a, b| a.feature == b.feature) {
        let is_small = is_small_loop(start_mm, section, process);
        let speed = process.speed_mm_s(section[0].feature, is_small, layer);
        speeds.extend(section.iter().map(|_| speed));
        start_mm = section[section.len() - 1].to_mm;
    }
    speeds
}

/// Whether moves with the same feature are a loop that counts as small.
fn is_small_loop(start_mm: [f64; 2], moves: &[ExtrusionMove], process: &Process) -> bool {
    let (Some(first), Some(last)) = (moves.first(), moves.last()) else { return false };
    if !matches!(first.feature, Feature::OuterWall | Feature::InnerWall)
        || distance_mm(start_mm, last.to_mm) > last.width_mm
    {
        return false;
    }
    let mut from_mm = start_mm;
    let length_mm: f64 = moves
        .iter()
        .map(|step| distance_mm(std::mem::replace(&mut from_mm, step.to_mm), step.to_mm))
        .sum();
    length_mm < process.small_perimeter_below_mm
}

/// A position as it is written.
pub(super) fn rounded(position_mm: [f64; 2]) -> [Number; 2] {
    position_mm.map(|value| number(value, DECIMALS))
}

fn distance_mm(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::print::Tool;

    const FRAME: Frame =
        Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.2, width: 1, height: 1 };

    fn toolpath(start_mm: [f64; 2], ends: &[[f64; 2]]) -> Option<Toolpath> {
        let step = |&to_mm| ExtrusionMove { to_mm, width_mm: 0.5, feature: Feature::Infill };
        let bead = Bead { tool: 0, start_mm, moves: ends.iter().map(step).collect() };
        let settings = Settings { tools: vec![Tool::default()], ..Settings::default() };
        let toolpath = Toolpath::of_bead(&bead, 1, &FRAME, &settings);
        if let Some(toolpath) = &toolpath {
            let filament: f64 = toolpath.moves.iter().map(|step| step.filament_mm).sum();
            let expected = bead.area_mm2() * 0.2 / Tool::default().filament_mm2();
            assert!((filament - expected).abs() < 1e-12, "{filament} {expected}");
            assert_eq!(rounded(toolpath.end_mm()), rounded(bead.end_mm()));
        }
        toolpath
    }

    fn ends(toolpath: &Toolpath) -> Vec<[f64; 2]> {
        toolpath.moves.iter().map(|step| step.to_mm).collect()
    }

    #[test]
    fn short_moves_are_merged() {
        let [a, b] = [[1.0, 1.0], [2.0, 1.0]];
        let [near_a, near_b] = [[1.0002, 1.0], [2.0, 1.0003]];
        // With the next move, and at the end with the one before.
        assert_eq!(ends(&toolpath(a, &[near_a, b]).unwrap()), [b]);
        assert_eq!(ends(&toolpath(a, &[b, near_b, b, a]).unwrap()), [b, a]);
        assert_eq!(ends(&toolpath(a, &[b, near_b]).unwrap()), [near_b]);
        assert_eq!(ends(&toolpath(a, &[near_a, b, near_b, near_b]).unwrap()), [near_b]);
        // This end is rounded to another position, but needs too little filament.
        assert_eq!(ends(&toolpath(a, &[b, [2.0005, 1.0], [2.00051, 1.0]]).unwrap()).len(), 2);
        assert_eq!(
            ends(&toolpath(a, &[[2.00049, 1.0], [2.00051, 1.0]]).unwrap()),
            [[2.00051, 1.0]]
        );
    }

    #[test]
    fn beads_without_length_vanish() {
        let a = [1.0, 1.0];
        assert_eq!(toolpath(a, &[]), None);
        assert_eq!(toolpath(a, &[a]), None);
        assert_eq!(toolpath(a, &[[1.0001, 1.0], [1.0004, 1.0004], a]), None);
        // A step away and back again, which are rounded to different positions.
        assert_eq!(toolpath([1.0014, 1.0], &[[1.001_51, 1.0], [1.001_49, 1.0]]), None);
    }
}
