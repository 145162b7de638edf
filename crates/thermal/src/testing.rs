//! Small parts in the middle of their print, for the tests of measures.

use std::sync::Arc;

use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Pattern};
use ndarray::Array3;

use crate::{Material, Method, Process, Simulation};

/// Stairs that rise along x, with a hole through all layers if they are large enough.
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
    Simulation::new(part, &Material::abs(), &Process::default(), Method::default()).unwrap()
}

/// All layers but the last two, and half of the last but one.
pub(crate) fn half_printed(part: &Arc<Voxels>) -> Simulation {
    let mut simulation = unprinted(part.clone());
    let order = |layer: usize| Pattern::CONVENTIONAL.order(&part.region(layer).unwrap());
    for layer in 0..part.depth - 2 {
        simulation.deposit(layer as u32, &order(layer)).unwrap();
    }
    let layer = part.depth - 2;
    let cells = order(layer);
    let slots = simulation.slots(layer as u32, &cells[..cells.len() / 2]);
    simulation.run(&slots).unwrap();
    simulation
}
