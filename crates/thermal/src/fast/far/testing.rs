//! Random parts and regions for the tests of the far field.

use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::region::Region;
use crate::coefficients::Coefficients;
use crate::material::ThermalMaterial;
use crate::patch::Patch;
use crate::process::ProcessParameters;
use crate::shape::Shape;
use crate::state::{State, StateMut};

/// Positions of all voxels, or blocks, of a box, with the halo counted.
pub(super) fn positions(size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [x, y, z] = size;
    (1..=z).flat_map(move |z| (1..=y).flat_map(move |y| (1..=x).map(move |x| [x, y, z])))
}

/// A part with the given temperatures above the air; `None` where there is no voxel.
pub(super) fn printed(
    size: [usize; 3],
    coefficients: &Coefficients,
    mut theta: impl FnMut([usize; 3]) -> Option<f64>,
) -> State {
    let mut state = State::unprinted(Shape::with_halo(size[0], size[1], size[2]), coefficients);
    let mut changes = Vec::new();
    let StateMut { patch, mut occupancy } = state.make_mut();
    for position in positions(size) {
        if let Some(theta) = theta(position) {
            occupancy.birth(position, patch, coefficients, &mut changes);
            patch.apply(&changes, coefficients);
            changes.clear();
            let index = patch.shape.index(position);
            patch.theta[index] = theta as f32;
        }
    }
    state
}

/// Coefficients of a part that exchanges no heat with plate and air.
pub(super) fn insulated() -> Coefficients {
    let material = ThermalMaterial { emissivity: 0.0, ..ThermalMaterial::abs() };
    let process =
        ProcessParameters { plate_c: None, convection_w_m2k: 0.0, ..ProcessParameters::default() };
    Coefficients::new(&material, &process, 0.5e-3, 0.25e-3)
}

/// Heat of all voxels, K voxels.
pub(super) fn heat(state: &State) -> f64 {
    state.patch.theta[..].iter().map(|&theta| f64::from(theta)).sum()
}

/// A random part, with or without a plate and surface resistance.
pub(super) fn random_state(random: &mut Xoshiro256PlusPlus) -> (State, Coefficients) {
    let process = ProcessParameters {
        plate_c: random.random_bool(0.7).then_some(80.0),
        surface_resistance: random.random_bool(0.5),
        ..ProcessParameters::default()
    };
    let coefficients = Coefficients::new(&ThermalMaterial::abs(), &process, 0.5e-3, 0.25e-3);
    let size = [0, 1, 2].map(|axis: usize| random.random_range(2..[50, 12, 14][axis]));
    let filled = random.random_range(0.5..1.0);
    let state = printed(size, &coefficients, |_| {
        random.random_bool(filled).then(|| random.random_range(10.0..200.0))
    });
    (state, coefficients)
}

/// A random region of a part, and a window with its voxels.
pub(super) fn random_region(random: &mut Xoshiro256PlusPlus, state: &State) -> (Region, Patch) {
    let block_grid = state.occupancy.block_grid();
    let whole = Region::whole(block_grid, state.top);
    let mut region = whole;
    for axis in 1..3 {
        region.low[axis] = random.random_range(whole.low[axis]..whole.high[axis]);
        region.high[axis] = random.random_range(region.low[axis] + 1..=whole.high[axis]);
    }
    let mut patch = Patch::default();
    patch.copy_window(region.window(block_grid, state.patch.shape), &state.patch);
    (region, patch)
}
