//! The warpage estimate against three-dimensional elasticity.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Order};
use beadwork_thermal::oracle::elastic::{ElasticPrint, ElasticShape, Support};
use beadwork_thermal::simulation::Method;
use beadwork_thermal::warpage::{WarpageEstimate, WarpageEstimator};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use ndarray::Array3;

/// Prints a block of 16 x 8 x 3 voxels slowly, so that layers cool.
fn print(order: &str) -> (WarpageEstimate, ElasticShape) {
    let [cell_mm, layer_mm, width, height] = [0.5, 0.25, 16.0, 8.0];
    let (width, height) = (width as u32, height as u32);
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm, layer_mm, width, height };
    let part = Arc::new(Voxels::new(frame, Array3::zeros((3, 8, 16))));
    let abs = ThermalMaterial::abs();
    let process = ProcessParameters {
        print_mm_s: 4.0,
        travel_mm_s: Some(20.0),
        ..ProcessParameters::default()
    };
    let mut simulation = Simulation::new(part.clone(), &abs, &process, Method::default()).unwrap();
    let mut estimate = WarpageEstimator::new(&part, &abs);
    let mut elastic = ElasticPrint::new(&part, &abs, Support::Sliding);
    let order: Order = order.parse().unwrap();
    let control = Control::default();
    for layer in 0..3 {
        let cells = order.order(&part.region(layer as usize).unwrap());
        let events = simulation.layer_events(layer, &cells);
        let sample = |print: &Simulation| {
            estimate.sample(print);
            elastic.sample(print);
        };
        simulation.run_sampled(&events, 1.0, sample, &control).unwrap();
    }
    (estimate.finish(&simulation, &control).unwrap(), elastic.finish(&simulation))
}

#[test]
fn curvatures_along_lines_are_those_of_elasticity() {
    let prints = ["zigzag-x-0", "zigzag-y-0", "lines-y-interleaved-2-0"].map(print);
    for (number, (estimate, elastic)) in prints.iter().enumerate() {
        let along = number.min(1);
        let (fast, slow) = (estimate.axis_curvatures_1_m, elastic.curvatures_1_m);
        assert!((fast[along] / slow[along] - 1.0).abs() < 0.2, "{number}: {fast:?} {slow:?}");
        assert!((fast[1 - along] - slow[1 - along]).abs() < 0.4 * slow[along], "{fast:?} {slow:?}");
    }
    // Lines along the longer side lift corners more, in both.
    let [along, across, _] = prints;
    assert!(along.0.corner_lift_mm > 1.5 * across.0.corner_lift_mm);
    assert!(along.1.lift_mm > 1.5 * across.1.lift_mm);
}
