//! Small parts during their print, for the unit tests of measures.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Pattern};
use ndarray::Array3;

use crate::simulation::Method;
use crate::{ProcessParameters, Simulation, ThermalMaterial};

/// Stairs that rise along x; wider than 8 voxels, they have a hole through all layers.
pub(crate) fn stairs(width: u32, height: u32, depth: usize) -> Arc<Voxels> {
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height };
    let filled = |x: u32, y: u32, z: usize| {
        let hole = width > 8 && (3..5).contains(&x) && (2..4).contains(&y);
        !hole && x as usize * depth >= z * width as usize / 2
    };
    let material = |(z, y, x)| if filled(x as u32, y as u32, z) { 0 } else { Voxels::EMPTY };
    let shape = (depth, height as usize, width as usize);
    Arc::new(Voxels::new(frame, Array3::from_shape_fn(shape, material)))
}

pub(crate) fn unprinted(part: Arc<Voxels>) -> Simulation {
    let process = ProcessParameters::default();
    Simulation::new(part, &ThermalMaterial::abs(), &process, Method::default()).unwrap()
}

/// All but the two topmost layers are printed, and half of the lower one of these.
pub(crate) fn half_printed(part: &Arc<Voxels>) -> Simulation {
    let mut simulation = unprinted(part.clone());
    let order = |layer: usize| Pattern::CONVENTIONAL.order(&part.region(layer).unwrap());
    let control = Control::default();
    for layer in 0..part.depth - 2 {
        simulation.deposit(layer as u32, &order(layer), &control).unwrap();
    }
    let layer = part.depth - 2;
    let cells = order(layer);
    let events = simulation.layer_events(layer as u32, &cells[..cells.len() / 2]);
    simulation.run(&events, &control).unwrap();
    simulation
}
