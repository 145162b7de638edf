//! Checks which cells are printed, and in which order.
//!
//! The bead through a cell has two halves: from the side where the path enters to the centre, and
//! from the centre to the side where it leaves.
//! That holds for straight stretches, corners and ends of beads, so every motion along a row or a
//! column consists of whole halves.
//! The check cuts every motion into halves and compares them one by one with those of the path:
//! half number `n` of a layer belongs to cell `n / 2` of the path's order.

use beadwork_base::Control;
use beadwork_gcode::{Motion, Program};
use beadwork_grid::Cell;

use super::checker::{Part, check_program};
use super::error::{CellPosition, CheckError};
use super::{rates, tolerance};
use crate::Frame;
use crate::print::layer::Layer;
use crate::print::settings::Settings;
use crate::print::validate::validate_layers;

/// Totals of a checked print of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Number of layers of the part.
    pub layers: usize,
    /// Number of cells in all layers; each is printed once, with the tool of its zone.
    pub cells: u64,
    /// Volume of the part, in mm³.
    pub part_mm3: f64,
    /// Volume of the prime tower, in mm³.
    pub prime_tower_mm3: f64,
    /// Number of changes from one tool to another.
    pub tool_changes: usize,
}

/// Checks that a program prints these layers, and nothing else besides the prime tower.
///
/// The layers must be numbered from 0 without a gap.
///
/// - Each cell is printed once, in the order of the path, with the tool of its zone and the volume
///   of the settings.
///   Motions run from edge to edge through the centres of the cells, no faster than the settings
///   allow.
///   Layers are printed upwards.
/// - The prime tower is printed within its position, with the bead cross-section of the part, and
///   in every layer up to the last one that has it.
///   After a tool change, the part continues only after the purge volume was extruded into the
///   tower.
/// - The nozzle never moves below the top of the highest layer begun, and never leaves the build
///   volume.
/// - Filament is retracted before a tool change, and unretracted before a bead.
///   Marlin and Klipper interpret every extrusion alike.
/// - Before anything is printed, the program sets the temperatures of nozzle and bed and waits for
///   them; the motors stay on until the last bead.
///
/// The travel speed, the fan, the shape of the prime tower, and travel across the layer that is
/// being printed are not checked.
/// Commands that the trace does not follow, such as macros, `G10`, `G11` and `M221`, do not count
/// ([`Program::unknown_commands`]).
///
/// Progress counts layers.
/// Takes time linear in the motions and cells.
pub fn check(
    program: &Program,
    layers: &[Layer<'_>],
    frame: &Frame,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Report, CheckError> {
    validate_layers(layers, frame, settings)?;
    let mut cells = CellTracker::new(layers, frame, settings, control);
    let totals = check_program(program, &mut cells, frame, settings, control)?;
    Ok(Report {
        layers: layers.len(),
        cells: cells.cells,
        part_mm3: totals.part_mm3,
        prime_tower_mm3: totals.prime_tower_mm3,
        tool_changes: totals.tool_changes,
    })
}

/// Sides of a cell as numbers; those opposite each other differ in the last bit.
mod side {
    pub(super) const LEFT: u8 = 0;
    pub(super) const RIGHT: u8 = 1;
    pub(super) const BACK: u8 = 2;
    pub(super) const FRONT: u8 = 3;

    pub(super) fn opposite(side: u8) -> u8 {
        side ^ 1
    }
}

/// Tracks which cells of the part were printed.
struct CellTracker<'a> {
    layers: &'a [Layer<'a>],
    frame: &'a Frame,
    settings: &'a Settings,
    control: &'a Control<'a>,
    /// Index of the layer that is being printed.
    current: usize,
    /// For each cell of the grid, a bit mask of the sides whose halves were printed in this layer.
    halves: Vec<u8>,
    /// Number of halves printed in this layer.
    printed: usize,
    /// Cells of the completed layers.
    cells: u64,
}

impl<'a> CellTracker<'a> {
    fn new(
        layers: &'a [Layer<'a>],
        frame: &'a Frame,
        settings: &'a Settings,
        control: &'a Control<'a>,
    ) -> Self {
        let halves = vec![0; frame.width as usize * frame.height as usize];
        Self { layers, frame, settings, control, current: 0, halves, printed: 0, cells: 0 }
    }

    /// A position in half cells from the back left corner of the grid, x to the right and y to the
    /// front; `None` if a coordinate is neither a centre nor an edge, or far away.
    fn half_cells(&self, position_mm: [f64; 3]) -> Option<[i32; 2]> {
        let half_mm = self.frame.cell_mm / 2.0;
        // A hundredth of a cell, plus rounding.
        // The limit of 0.4 halves matters for tiny cells: from 0.5 on, every position would fit.
        let tolerance_mm = (0.01 * self.frame.cell_mm + tolerance::POSITION_MM).min(0.4 * half_mm);
        let halves = [position_mm[0] - self.frame.left_mm, self.frame.back_mm - position_mm[1]]
            .map(|mm| mm / half_mm);
        let whole = halves.map(f64::round);
        let fits = (0..2).all(|axis| {
            (halves[axis] - whole[axis]).abs() * half_mm <= tolerance_mm
                && (-2.0..1e5).contains(&whole[axis])
        });
        fits.then(|| whole.map(|value| value as i32))
    }

    /// Marks half a cell as printed, if it is the next one of the path.
    fn half(
        &mut self,
        layer: Layer<'_>,
        [x, y]: [i32; 2],
        side: u8,
        motion: &Motion,
    ) -> Result<(), CheckError> {
        let line = motion.line;
        // A cell beyond the left or back side of the grid is reported as the one next to it.
        let position = CellPosition { layer: layer.number, x: x.max(0) as u32, y: y.max(0) as u32 };
        let is_inside =
            x >= 0 && y >= 0 && position.x < self.frame.width && position.y < self.frame.height;
        let cell = if is_inside { position.y * self.frame.width + position.x } else { u32::MAX };
        if !layer.region.contains(cell) {
            return Err(CheckError::OutsidePart { line, position });
        }
        let (expected, got) = (layer.zones.id(cell), motion.tool);
        if expected != got {
            return Err(CheckError::WrongTool { line, position, expected, got });
        }
        let halves = &mut self.halves[cell as usize];
        if *halves & 1 << side != 0 || halves.count_ones() == 2 {
            return Err(CheckError::PrintedTwice { line, position });
        }
        *halves |= 1 << side;
        // No half was printed twice, so fewer halves than the path has were printed, and the index
        // is valid.
        let next = layer.path.order()[self.printed / 2];
        if cell != next || side != sides(layer, cell)[self.printed % 2] {
            let expected = layer.region.xy(next).into();
            return Err(CheckError::OffPath { line, position, expected });
        }
        self.printed += 1;
        Ok(())
    }

    /// Ends the current layer; an error if a cell of it is not completely printed.
    fn complete_layer(&mut self) -> Result<(), CheckError> {
        let layer = self.layers[self.current];
        for cell in layer.region.cells() {
            let halves = std::mem::take(&mut self.halves[cell as usize]).count_ones();
            if halves < 2 {
                let (x, y) = layer.region.xy(cell);
                let position = CellPosition { layer: layer.number, x, y };
                return Err(CheckError::Missing { position, share: f64::from(halves) / 2.0 });
            }
        }
        self.printed = 0;
        self.cells += u64::from(layer.region.cell_count());
        self.current += 1;
        self.control.report(self.current, self.layers.len());
        Ok(())
    }
}

impl Part for CellTracker<'_> {
    fn layers(&self) -> usize {
        self.layers.len()
    }

    fn motion(&mut self, motion: &Motion, number: usize) -> Result<(), CheckError> {
        let line = motion.line;
        let filament_mm2 = self.settings.tools[usize::from(motion.tool)].filament_mm2();
        rates::check_cell_speed(motion, number, &self.settings.process)?;
        rates::check_volume(motion, filament_mm2, self.settings.process.bead_mm2(self.frame))?;
        while self.layers[self.current].number < number {
            self.complete_layer()?;
        }
        let layer = self.layers[self.current];
        let off_centre = || CheckError::OffCentre {
            line,
            layer: number,
            from_mm: [motion.from_mm[0], motion.from_mm[1]],
            to_mm: [motion.to_mm[0], motion.to_mm[1]],
        };
        let begin = self.half_cells(motion.from_mm).ok_or_else(off_centre)?;
        let end = self.half_cells(motion.to_mm).ok_or_else(off_centre)?;
        let axis = match (begin[0] == end[0], begin[1] == end[1]) {
            (false, true) => 0,
            (true, false) => 1,
            _ => return Err(off_centre()),
        };
        // Centres have odd coordinates, edges even ones: the motion must run through centres.
        if begin[1 - axis].rem_euclid(2) == 0 {
            return Err(off_centre());
        }
        let is_ascending = begin[axis] < end[axis];
        for step in 0..begin[axis].abs_diff(end[axis]) as i32 {
            // Halves are numbered by the lower of the two coordinates between which they lie.
            let half = if is_ascending { begin[axis] + step } else { begin[axis] - step - 1 };
            let mut cell = [begin[0].div_euclid(2), begin[1].div_euclid(2)];
            cell[axis] = half.div_euclid(2);
            // An even half lies to the left or back of the centre, an odd one to the right or
            // front.
            let side = [side::LEFT, side::BACK][axis] + half.rem_euclid(2) as u8;
            self.half(layer, cell, side, motion)?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), CheckError> {
        while self.current < self.layers.len() {
            self.complete_layer()?;
        }
        Ok(())
    }
}

/// The sides by which the path enters and leaves a cell.
/// A bead begins and ends straight, and a bead of a single cell runs to the right.
fn sides(layer: Layer<'_>, cell: Cell) -> [u8; 2] {
    let towards = |other: Cell| {
        let ([x, y], [other_x, other_y]) =
            (layer.column_and_row(cell), layer.column_and_row(other));
        match (other_x - x, other_y - y) {
            (-1, _) => side::LEFT,
            (1, _) => side::RIGHT,
            (_, -1) => side::BACK,
            _ => side::FRONT,
        }
    };
    let before = layer.path.previous(cell).map(towards);
    let after = layer.path.next(cell).map(towards);
    let enter = before.or(after.map(side::opposite)).unwrap_or(side::LEFT);
    [enter, after.unwrap_or(side::opposite(enter))]
}
