//! Deposition events: when which voxel is deposited.

use beadwork_grid::Cell;
use beadwork_part::Frame;

use crate::process::ProcessParameters;

/// A time interval in which the nozzle deposits one voxel, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepositionEvent {
    /// x, y and z of the voxel that is deposited at the start of the interval and held at the
    /// extrusion temperature until its end; `None` in a pause.
    pub voxel: Option<[u32; 3]>,
    /// Duration, s: at least 0, and more than 0 with a voxel.
    pub seconds: f64,
}

impl DepositionEvent {
    /// A time interval in which nothing is deposited, such as a travel move.
    pub fn pause(seconds: f64) -> Self {
        Self { voxel: None, seconds }
    }
}

/// The events of a layer that is printed in a given order: one for each cell, and a pause for each
/// travel move between cells that are not neighbours.
///
/// Depositing a cell takes its width divided by [`ProcessParameters::print_mm_s`].
/// Travel moves are straight lines between centres of cells, at [`ProcessParameters::travel_mm_s`].
/// The nozzle starts at `from`, the last cell that was deposited before; with `None`, it starts at
/// the first cell of the order.
/// Linear in the order's length.
pub fn layer_events(
    order: &[Cell],
    layer: u32,
    from: Option<Cell>,
    frame: &Frame,
    process: &ProcessParameters,
) -> Vec<DepositionEvent> {
    let xy = |cell: Cell| [cell % frame.width, cell / frame.width];
    let seconds = frame.cell_mm / process.print_mm_s;
    let mut events = Vec::with_capacity(order.len());
    let mut last = from;
    for &cell in order {
        let [x, y] = xy(cell);
        if let (Some(from), Some(speed)) = (last, process.travel_mm_s) {
            let [from_x, from_y] = xy(from);
            let cells = libm::hypot(f64::from(from_x.abs_diff(x)), f64::from(from_y.abs_diff(y)));
            // At most 1 between neighbours, and 0 from a layer to the same cell of the next, where
            // the nozzle only rises.
            if cells > 1.0 {
                events.push(DepositionEvent::pause(cells * frame.cell_mm / speed));
            }
        }
        events.push(DepositionEvent { voxel: Some([x, y, layer]), seconds });
        last = Some(cell);
    }
    events
}
