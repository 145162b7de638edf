//! Warpage against textbook formulas, and of whole prints.

use std::cmp::Ordering;
use std::sync::Arc;

use beadwork_base::CancelToken;
use beadwork_part::{Frame, Pattern};
use ndarray::Array3;

use super::super::locking::Temperatures;
use super::*;
use crate::testing::{stairs, unprinted};

const CELL_MM: f64 = 0.5;
const LAYER_MM: f64 = 0.25;

fn block(width: u32, height: u32, depth: usize) -> Voxels {
    let frame =
        Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: CELL_MM, layer_mm: LAYER_MM, width, height };
    Voxels::new(frame, Array3::zeros((depth, height as usize, width as usize)))
}

/// Temperatures of the layers up to the highest one, which is at the glass transition; `below` are
/// those of the others.
struct Stack<'a, F> {
    part: &'a Voxels,
    top: u32,
    below: F,
}

impl<F: Fn([u32; 3], u32) -> f64> Temperatures for Stack<'_, F> {
    fn layer(&self, z: usize) -> impl Iterator<Item = ([u32; 3], f64)> {
        let width = self.part.frame.width;
        let voxels = self.part.cells(z).map(move |cell| [cell % width, cell / width, z as u32]);
        voxels.filter_map(|voxel| Some((voxel, self.celsius(voxel)?)))
    }

    fn celsius(&self, voxel @ [x, y, z]: [u32; 3]) -> Option<f64> {
        self.part.material(x, y, z as usize)?;
        match z.cmp(&self.top) {
            Ordering::Less => Some((self.below)(voxel, self.top)),
            Ordering::Equal => Some(ThermalMaterial::abs().glass_transition_c),
            Ordering::Greater => None,
        }
    }
}

/// Locks all of a block, layer by layer; `celsius` gives the temperatures of the voxels below while
/// a layer locks.
fn locked(
    part: &Voxels,
    material: &ThermalMaterial,
    celsius: impl Fn([u32; 3], u32) -> f64,
) -> WarpageEstimate {
    estimated(&lock_all(part, material, celsius))
}

fn lock_all(
    part: &Voxels,
    material: &ThermalMaterial,
    celsius: impl Fn([u32; 3], u32) -> f64,
) -> WarpageEstimator {
    let mut warpage = WarpageEstimator::new(part, material);
    for top in 0..part.depth as u32 {
        warpage.locking.sample(&Stack { part, top, below: &celsius });
    }
    warpage
}

fn estimated(warpage: &WarpageEstimator) -> WarpageEstimate {
    let WarpageEstimator { cell_m, layer_m, locking } = warpage;
    estimate(locking, *cell_m, *layer_m, &Control::default()).unwrap()
}

fn assert_near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-4 * a.abs().max(b.abs()) + 1e-9, "{a} is not {b}");
}

#[test]
fn two_layers_are_timoshenkos_bimetal() {
    let material = ThermalMaterial::abs();
    let (part, below_c) = (block(40, 30, 2), 65.0);
    let estimate = locked(&part, &material, |_, _| below_c);
    let mismatch = material.expansion_per_k * (material.glass_transition_c - below_c);
    let kappa = 3.0 * mismatch / (4.0 * LAYER_MM / 1e3);
    assert_near(estimate.curvature_1_m, kappa);
    // From the centre, between four columns, to the centre of the column at a corner; the lowest
    // columns lie half a diagonal of a column off the centre.
    let square_mm = (39.0 * 39.0 + 29.0 * 29.0 - 2.0) * CELL_MM * CELL_MM;
    assert_near(estimate.corner_lift_mm, kappa / 1e3 * square_mm / 8.0);
    assert_near(estimate.flatness_mm, estimate.corner_lift_mm);
}

#[test]
fn a_thin_layer_on_a_thick_stack_is_stoneys() {
    let material = ThermalMaterial::abs();
    // The stack locks at the glass transition, and only the last layer on a cold stack, whose
    // deeper layers are not read at every sample.
    let depth = 200;
    let part = block(3, 3, depth);
    let mut warpage = WarpageEstimator::new(&part, &material);
    let last = depth as u32 - 1;
    (0..last)
        .for_each(|top| warpage.locking.sample(&Stack { part: &part, top, below: |_, _| 105.0 }));
    (0..32).for_each(|_| {
        warpage.locking.sample(&Stack { part: &part, top: last - 1, below: |_, _| 65.0 });
    });
    warpage.locking.sample(&Stack { part: &part, top: last, below: |_, _| 65.0 });
    let estimate = estimated(&warpage);
    let mismatch = material.expansion_per_k * 40.0;
    let (film, stack) = (LAYER_MM / 1e3, LAYER_MM / 1e3 * (depth - 1) as f64);
    let stoney = 6.0 * mismatch * film / (stack * stack);
    assert!(
        (estimate.curvature_1_m / stoney - 1.0).abs() < 0.02,
        "{} {stoney}",
        estimate.curvature_1_m
    );
}

#[test]
fn a_stack_on_a_cold_one_follows_the_harmonic_series() {
    let material = ThermalMaterial::abs();
    let depth = 12;
    let estimate = locked(&block(5, 4, depth), &material, |_, _| 65.0);
    // Layer k shrinks by the mismatch times 1 + 1/2 + ... + 1/k more than layer 0.
    let mismatch = material.expansion_per_k * 40.0;
    let (h, height) = (LAYER_MM / 1e3, LAYER_MM / 1e3 * depth as f64);
    let (mut harmonic, mut sum) = (0.0, 0.0);
    for k in 0..depth {
        let z = (k as f64 + 0.5) * h;
        sum += mismatch * harmonic * (z - height / 2.0) * h;
        harmonic += 1.0 / (k + 1) as f64;
    }
    assert_near(estimate.curvature_1_m, 12.0 / height.powi(3) * sum);
}

#[test]
fn nothing_warps_without_expansion_or_at_the_glass_transition() {
    let rigid = ThermalMaterial { expansion_per_k: 0.0, ..ThermalMaterial::abs() };
    let warm = |[x, y, z]: [u32; 3], _: u32| f64::from(40 + (x * 7 + y * 5 + z * 3) % 50);
    for estimate in [
        locked(&block(9, 7, 4), &rigid, warm),
        locked(&block(9, 7, 4), &ThermalMaterial::abs(), |_, _| 105.0),
        locked(&block(9, 7, 4), &ThermalMaterial::abs(), |_, _| 180.0),
        locked(&block(9, 7, 1), &ThermalMaterial::abs(), warm),
        estimated(&WarpageEstimator::new(&block(9, 7, 4), &ThermalMaterial::abs())),
    ] {
        assert!(estimate.curvature_1_m.abs() < 1e-9 && estimate.flatness_mm < 1e-6, "{estimate:?}");
        assert!(estimate.corner_lift_mm >= 0.0);
    }
}

#[test]
fn corners_go_up_with_the_square_of_the_length() {
    let cold = |_: [u32; 3], _: u32| 65.0;
    let [short, long] =
        [21, 41].map(|side| locked(&block(side, side, 3), &ThermalMaterial::abs(), cold));
    assert!(short.curvature_1_m > 0.0);
    assert_near(short.curvature_1_m, long.curvature_1_m);
    assert_near(4.0 * short.corner_lift_mm, long.corner_lift_mm);
    let height = |x: usize, y: usize| long.heights_mm[[y, x]];
    assert!(height(0, 0) > height(20, 0) && height(20, 0) > height(20, 20));
    assert_near(height(0, 0) - height(20, 20), long.corner_lift_mm);
}

#[test]
fn wide_parts_are_coarsened() {
    let cold = |_: [u32; 3], _: u32| 65.0;
    let estimate = locked(&block(200, 20, 2), &ThermalMaterial::abs(), cold);
    assert_eq!((estimate.block, estimate.heights_mm.dim()), (3, (7, 67)));
    let square_mm = (66.0 * 66.0 + 6.0 * 6.0) * 9.0 * CELL_MM * CELL_MM;
    assert_near(estimate.corner_lift_mm, estimate.curvature_1_m / 1e3 * square_mm / 8.0);
}

#[test]
fn a_mirrored_print_warps_the_same() {
    let warm = |[x, y, z]: [u32; 3], k: u32| f64::from(40 + (x * x * 7 + y * 5 + z * 3 + k) % 50);
    let part = block(14, 9, 4);
    let one = locked(&part, &ThermalMaterial::abs(), warm);
    let mirrored = locked(&part, &ThermalMaterial::abs(), |[x, y, z], k| warm([13 - x, y, z], k));
    assert_near(one.curvature_1_m, mirrored.curvature_1_m);
    assert_near(one.corner_lift_mm, mirrored.corner_lift_mm);
    for ((y, x), a) in one.heights_mm.indexed_iter() {
        assert!((a - mirrored.heights_mm[[y, 13 - x]]).abs() < 1e-6);
    }
    // With swapped axes, too, where the plate's cells are numbered in another order.
    let swapped =
        locked(&block(9, 14, 4), &ThermalMaterial::abs(), |[x, y, z], k| warm([y, x, z], k));
    assert_near(one.corner_lift_mm, swapped.corner_lift_mm);
}

fn printed(part: &Arc<Voxels>, pattern: Pattern, interval_s: Option<f64>) -> WarpageEstimate {
    let control = Control::default();
    let mut simulation = unprinted(part.clone());
    let mut warpage = WarpageEstimator::new(part, &ThermalMaterial::abs());
    for layer in 0..part.depth {
        let order = pattern.order(&part.region(layer).unwrap());
        let events = simulation.layer_events(layer as u32, &order);
        match interval_s {
            Some(interval_s) => simulation
                .run_sampled(&events, interval_s, |print| warpage.sample(print), &control)
                .unwrap(),
            None => simulation.run(&events, &control).unwrap(),
        }
        warpage.sample(&simulation);
    }
    warpage.finish(&simulation, &control).unwrap()
}

#[test]
fn lines_along_the_longer_side_lift_corners_more() {
    let part = Arc::new(block(40, 16, 6));
    let print = |name: &str, interval_s| printed(&part, name.parse().unwrap(), interval_s);
    let [along, across] = ["zigzag-x-0", "zigzag-y-0"].map(|name| print(name, Some(0.25)));
    assert!(along.corner_lift_mm > 1.5 * across.corner_lift_mm, "{along:?} {across:?}");
    let [along_x, along_y] = along.axis_curvatures_1_m;
    assert!(along_x > 1.5 * along_y);
    assert_near(along.curvature_1_m, f64::midpoint(along_x, along_y));
    // More samples change the number a little.
    let often = print("zigzag-x-0", Some(0.05));
    let ratio = along.corner_lift_mm / often.corner_lift_mm;
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
    assert!(print("zigzag-x-0", None).corner_lift_mm > 0.0);
}

#[test]
fn the_shape_of_stairs_with_a_hole_covers_the_part() {
    let part = stairs(13, 7, 5);
    let estimate = printed(&part, Pattern::CONVENTIONAL, None);
    for ((y, x), height) in estimate.heights_mm.indexed_iter() {
        let is_inside = (0..5).any(|z| part.material(x as u32, y as u32, z).is_some());
        assert_eq!(!height.is_nan(), is_inside);
    }
    assert!(estimate.flatness_mm >= estimate.corner_lift_mm && estimate.corner_lift_mm > 0.0);
    assert!(estimate.curvature_1_m.is_finite());
}

#[test]
fn an_estimate_can_be_cancelled() {
    let part = stairs(13, 7, 5);
    let simulation = unprinted(part.clone());
    let cancel = CancelToken::new();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let warpage = lock_all(&part, &ThermalMaterial::abs(), |_, _| 65.0);
    assert!(warpage.clone().finish(&simulation, &control).is_ok());
    cancel.cancel();
    assert_eq!(warpage.finish(&simulation, &control).unwrap_err(), Interrupted::Cancelled);
}
