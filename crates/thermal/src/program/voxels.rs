//! The part that a G-code program prints.

use beadwork_base::{Control, Interrupted};
use beadwork_gcode::{Event, Motion, Program, TraceError};
use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use ndarray::Array3;
use thiserror::Error;

use super::poll::Poll;
use super::rows::Rows;
use super::visit::{Visit, Visits};

/// Maximum number of voxels in the bounding box; as in slicing.
const MAX_VOXELS: f64 = (1 << 30) as f64;

/// Maximum width and height of the grid, in cells.
const MAX_SIDE: f64 = 65_535.0;

/// Share of beads that may lie below the first layer, such as a prime line.
const LOW_SHARE: f64 = 0.25;

/// Why the part of a program cannot be found.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum VoxelsError {
    /// A line of the program is invalid.
    #[error(transparent)]
    Trace(TraceError),
    /// The voxels' width or height is not a positive number.
    #[error("voxels are {cell_mm} mm wide and {layer_mm} mm high: both must be more than 0")]
    Size {
        /// Width, mm.
        cell_mm: f64,
        /// Height, mm.
        layer_mm: f64,
    },
    /// The program has no bead that belongs to a part.
    #[error("the program extrudes no bead of a part")]
    Nothing,
    /// A bead lies below the first layer.
    #[error("line {line}: a bead at a height of {z_mm} mm lies below the first layer")]
    Low {
        /// Number of the line, from 1.
        line: usize,
        /// Height of the nozzle, mm.
        z_mm: f64,
    },
    /// The bounding box has too many voxels.
    #[error(
        "the program's beads fill a box of {width:.0} x {height:.0} x {depth:.0} voxels, which is \
         too large"
    )]
    TooLarge {
        /// Columns.
        width: f64,
        /// Rows.
        height: f64,
        /// Layers.
        depth: f64,
    },
    /// The call was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<TraceError> for VoxelsError {
    fn from(error: TraceError) -> Self {
        match error {
            TraceError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Trace(error),
        }
    }
}

/// Finds the voxels that a program prints with beads of a width in layers of a height, both in mm,
/// for programs whose part is not available.
///
/// The grid is the smallest one around all beads except those of skirts, supports, prime towers and
/// custom G-code.
/// A program that was planned on cells, as by [`print::Print`](beadwork_part::print::Print), gives
/// the voxels of its part; any other gives those that [`program_events`](super::program_events)
/// would deposit.
/// The material of a voxel is the number of the tool that fills it first.
/// Layers are counted from the bed.
/// A program whose layers have other heights is mapped to voxels of the given height;
/// [`program_fit`](super::program_fit) measures the error.
///
/// Progress counts lines of the program, each twice.
/// Linear in the length of the program's path in cells and in the part's bounding box.
pub fn program_voxels(
    program: &Program,
    cell_mm: f64,
    layer_mm: f64,
    control: &Control<'_>,
) -> Result<Voxels, VoxelsError> {
    control.check()?;
    let is_valid = |length: f64| length > 0.0 && length.is_finite();
    if !is_valid(cell_mm) || !is_valid(layer_mm) {
        return Err(VoxelsError::Size { cell_mm, layer_mm });
    }
    let rows = Rows::of_program(program, cell_mm, layer_mm, control)?;
    let (frame, depth) = bounds(program, &rows, cell_mm, layer_mm, control)?;
    let (width, height) = (frame.width as usize, frame.height as usize);
    let mut materials = Array3::from_elem((depth, height, width), Voxels::EMPTY);
    let mut visits = Visits::new(frame);
    let mut tool = 0;
    let mut fill = |tool: u8, visit: &Visit| {
        for voxel in visit.voxels().take(depth) {
            let [x, y, z] = voxel.map(|i| i as usize);
            if x < width && y < height && z < depth {
                let material = &mut materials[[z, y, x]];
                if *material == Voxels::EMPTY {
                    *material = tool.min(Voxels::EMPTY - 1);
                }
            }
        }
    };
    let lines = program.lines.len();
    let mut poll = Poll::new(control, lines, 2 * lines);
    for event in program.trace() {
        let event = event?;
        poll.count(&event)?;
        match event {
            Event::Motion(motion) if rows.is_part(&motion) => {
                tool = motion.tool;
                visits.add_bead(&motion, rows.of(&motion), |_| 0.0, &mut |visit| fill(tool, visit));
            }
            Event::Motion(_) | Event::ToolChange { .. } => {
                visits.end_bead(&mut |visit| fill(tool, visit));
            }
            _ => {}
        }
    }
    visits.end_bead(&mut |visit| fill(tool, visit));
    control.report(2 * lines, 2 * lines);
    Ok(Voxels::new(frame, materials))
}

/// The grid around all beads, and the number of layers.
fn bounds(
    program: &Program,
    rows: &Rows,
    cell_mm: f64,
    layer_mm: f64,
    control: &Control<'_>,
) -> Result<(Frame, usize), VoxelsError> {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut end_row = 0;
    let mut low = None;
    let (mut low_mm, mut total_mm) = (0.0, 0.0);
    let mut poll = Poll::new(control, 0, 2 * program.lines.len());
    for event in program.trace() {
        let event = event?;
        poll.count(&event)?;
        let Event::Motion(motion) = event else { continue };
        if !rows.is_part(&motion) {
            continue;
        }
        total_mm += motion.length_mm();
        let z_mm = f64::midpoint(motion.from_mm[2], motion.to_mm[2]);
        let [_, end] = rows.of(&motion);
        if z_mm <= 0.0 || end < 1 {
            low.get_or_insert(VoxelsError::Low { line: motion.line, z_mm });
            low_mm += motion.length_mm();
            continue;
        }
        end_row = end_row.max(end);
        let half = half_width(&motion, cell_mm);
        for axis in 0..2 {
            for end in [motion.from_mm[axis], motion.to_mm[axis]] {
                min[axis] = min[axis].min(end - half[axis]);
                max[axis] = max[axis].max(end + half[axis]);
            }
        }
    }
    if let Some(error) = low
        && low_mm > LOW_SHARE * total_mm
    {
        return Err(error);
    }
    if end_row < 1 {
        return Err(VoxelsError::Nothing);
    }
    // Coordinates are rounded to three decimals, so an excess of up to a hundredth of a cell does
    // not add a cell.
    let cells = |axis: usize| ((max[axis] - min[axis]) / cell_mm - 0.01).ceil().max(1.0);
    let (width, height, depth) = (cells(0), cells(1), end_row as f64);
    let fits = width.max(height) <= MAX_SIDE && width * height * depth <= MAX_VOXELS;
    if !fits {
        return Err(VoxelsError::TooLarge { width, height, depth });
    }
    let frame = Frame {
        left_mm: min[0],
        back_mm: max[1],
        cell_mm,
        layer_mm,
        width: width as u32,
        height: height as u32,
    };
    Ok((frame, depth as usize))
}

/// How far a bead extends beyond the line of its motion along x and y: half its width across the
/// motion, and not at all beyond its ends.
fn half_width(motion: &Motion, cell_mm: f64) -> [f64; 2] {
    let [dx, dy] = [0, 1].map(|axis| motion.to_mm[axis] - motion.from_mm[axis]);
    let length = libm::hypot(dx, dy);
    // A vertical motion has no direction across.
    if length > 0.0 { [dy, dx].map(|side| side.abs() / length * cell_mm / 2.0) } else { [0.0; 2] }
}
