//! What happens when: births and pauses.

use beadwork_grid::Cell;
use beadwork_part::Frame;

use crate::process::Process;

/// A stretch of time in which the nozzle lays down one voxel, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// x, y and z of the voxel that is born at the start of the stretch and held until its end;
    /// `None` for a pause.
    pub voxel: Option<[u32; 3]>,
    /// How long it takes, s.
    /// At least 0; more than 0 with a voxel.
    pub seconds: f64,
}

impl Slot {
    /// A stretch of time in which nothing is laid down.
    pub fn pause(seconds: f64) -> Self {
        Self { voxel: None, seconds }
    }
}

/// A layer in a given order: a slot for each cell, and a pause for each travel between cells that
/// are not neighbours.
///
/// The nozzle comes from `from`, the last cell before, if there is one; travel goes straight from
/// centre to centre, at [`Process::travel_mm_s`].
/// Linear in the order's length.
pub fn layer_slots(
    order: &[Cell],
    layer: u32,
    from: Option<Cell>,
    frame: &Frame,
    process: &Process,
) -> Vec<Slot> {
    let column_row = |cell: Cell| [cell % frame.width, cell / frame.width];
    let seconds = frame.cell_mm / process.print_mm_s;
    let mut slots = Vec::with_capacity(order.len());
    let mut last = from;
    for &cell in order {
        let [x, y] = column_row(cell);
        if let (Some(from), Some(speed)) = (last, process.travel_mm_s) {
            let away = column_row(from);
            let steps = libm::hypot(f64::from(away[0].abs_diff(x)), f64::from(away[1].abs_diff(y)));
            // From one layer to the next on the same spot, the nozzle only rises.
            if steps > 1.0 {
                slots.push(Slot::pause(steps * frame.cell_mm / speed));
            }
        }
        slots.push(Slot { voxel: Some([x, y, layer]), seconds });
        last = Some(cell);
    }
    slots
}
