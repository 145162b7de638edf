//! The part that a program prints.

use beadwork_gcode::{Event, Motion, Program, TraceError};
use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use ndarray::Array3;
use thiserror::Error;

use super::is_bead;
use super::visit::Visits;

/// Cells of all layers' planes together, at most; as in slicing.
const MOST_VOXELS: f64 = (1 << 30) as f64;

/// Cells of a plane along one axis, at most.
const MOST_SIDE: f64 = 65_535.0;

/// Why a program shows no part.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum VoxelsError {
    /// The program makes no sense.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// Cells or layers have no size.
    #[error("voxels are {cell_mm} mm wide and {layer_mm} mm high: both must be more than 0")]
    Size {
        /// Width, mm.
        cell_mm: f64,
        /// Height, mm.
        layer_mm: f64,
    },
    /// No bead is laid down.
    #[error("the program lays down no bead of a part")]
    Nothing,
    /// A bead lies below the first layer.
    #[error("line {line}: a bead at a height of {z_mm} mm, below the first layer")]
    Low {
        /// Number of the line, from 1.
        line: usize,
        /// Height of the nozzle, mm.
        z_mm: f64,
    },
    /// There would be too many voxels.
    #[error(
        "the program's beads fill a box of {width:.0} x {height:.0} x {depth:.0} voxels, which is too large"
    )]
    TooLarge {
        /// Columns.
        width: f64,
        /// Rows.
        height: f64,
        /// Layers.
        depth: f64,
    },
}

/// The voxels that a program prints, of beads so wide in layers so high, both in mm: for programs
/// whose part is not at hand.
///
/// The plane is the smallest around all beads but those of skirts, supports, towers and what was
/// written by hand.
/// For programs made of cells, as [`print::Print`] makes them, these are the part's
/// voxels; of others, those that [`program_slots`](super::program_slots) would call born.
/// The material is the number of the tool that comes first.
/// Layers are counted from the bed.
/// Linear in the program's way and the part's box.
pub fn program_voxels(
    program: &Program,
    cell_mm: f64,
    layer_mm: f64,
) -> Result<Voxels, VoxelsError> {
    let sound = |length: f64| length > 0.0 && length.is_finite();
    if !sound(cell_mm) || !sound(layer_mm) {
        return Err(VoxelsError::Size { cell_mm, layer_mm });
    }
    let (frame, depth) = bounds(program, cell_mm, layer_mm)?;
    let (width, height) = (frame.width as usize, frame.height as usize);
    let mut materials = Array3::from_elem((depth, height, width), Voxels::EMPTY);
    let mut visits = Visits::new(frame);
    let mut tool = 0;
    let mut fill = |tool: u8, visit: &super::Visit| {
        let Some([x, y, z]) = visit.voxel().map(|voxel| voxel.map(|i| i as usize)) else { return };
        if x < width && y < height && z < depth {
            let material = &mut materials[[z, y, x]];
            if *material == Voxels::EMPTY {
                *material = tool.min(Voxels::EMPTY - 1);
            }
        }
    };
    for event in program.trace() {
        match event? {
            Event::Motion(motion) if is_bead(&motion) => {
                tool = motion.tool;
                visits.bead(&motion, |_| 0.0, &mut |visit| fill(tool, visit));
            }
            Event::Motion(_) | Event::ToolChange { .. } => {
                visits.end(&mut |visit| fill(tool, visit))
            }
            _ => {}
        }
    }
    visits.end(&mut |visit| fill(tool, visit));
    Ok(Voxels::new(frame, materials))
}

/// The plane around all beads, and the number of layers.
fn bounds(program: &Program, cell_mm: f64, layer_mm: f64) -> Result<(Frame, usize), VoxelsError> {
    let (mut least, mut greatest) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut top_mm = 0.0_f64;
    for event in program.trace() {
        let Event::Motion(motion) = event? else { continue };
        if !is_bead(&motion) {
            continue;
        }
        let z_mm = f64::midpoint(motion.from_mm[2], motion.to_mm[2]);
        if z_mm < layer_mm / 2.0 {
            return Err(VoxelsError::Low { line: motion.line, z_mm });
        }
        top_mm = top_mm.max(z_mm);
        let half = half_across(&motion, cell_mm);
        for axis in 0..2 {
            for end in [motion.from_mm[axis], motion.to_mm[axis]] {
                least[axis] = least[axis].min(end - half[axis]);
                greatest[axis] = greatest[axis].max(end + half[axis]);
            }
        }
    }
    if top_mm <= 0.0 {
        return Err(VoxelsError::Nothing);
    }
    // Places are rounded to three decimals.
    let cells = |axis: usize| ((greatest[axis] - least[axis]) / cell_mm - 0.01).ceil().max(1.0);
    let (width, height, depth) = (cells(0), cells(1), (top_mm / layer_mm).round().max(1.0));
    let fits = width.max(height) <= MOST_SIDE && width * height * depth <= MOST_VOXELS;
    if !fits {
        return Err(VoxelsError::TooLarge { width, height, depth });
    }
    let frame = Frame {
        left_mm: least[0],
        back_mm: greatest[1],
        cell_mm,
        layer_mm,
        width: width as u32,
        height: height as u32,
    };
    Ok((frame, depth as usize))
}

/// How far a bead reaches beyond the line of its motion along x and y: half its width across,
/// nothing at its ends.
fn half_across(motion: &Motion, cell_mm: f64) -> [f64; 2] {
    let [dx, dy] = [0, 1].map(|axis| motion.to_mm[axis] - motion.from_mm[axis]);
    let length = libm::hypot(dx, dy);
    // Straight up there is no across.
    if length > 0.0 { [dy, dx].map(|side| side.abs() / length * cell_mm / 2.0) } else { [0.0; 2] }
}
