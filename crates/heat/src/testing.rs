//! Parts and models of the tests.

use std::sync::Arc;

use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use ndarray::Array3;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::model::{LayerCost, Solver};

/// The voxels of a box for which `inside` holds.
pub(crate) fn part(
    [width, height, depth]: [u32; 3],
    inside: impl Fn([u32; 3]) -> bool,
) -> Arc<Voxels> {
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height };
    let material = |(z, y, x): (usize, usize, usize)| {
        if inside([x as u32, y as u32, z as u32]) { 0 } else { Voxels::EMPTY }
    };
    let shape = (depth as usize, height as usize, width as usize);
    Arc::new(Voxels::new(frame, Array3::from_shape_fn(shape, material)))
}

/// Steps of 3 columns, each one layer lower than the one before.
pub(crate) fn stairs() -> Arc<Voxels> {
    part([12, 8, 4], |[x, _, z]| z < 4 - x / 3)
}

/// Nothing printed yet.
pub(crate) fn solver(part: &Arc<Voxels>, objective: Objective) -> Solver {
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let cost = LayerCost::of(objective).unwrap();
    Solver::new(part.clone(), &material, &process, Method::default(), cost).unwrap()
}

/// A number in 0..1.
pub(crate) fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
