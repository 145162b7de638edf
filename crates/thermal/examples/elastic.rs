//! Compares the warpage estimate with three-dimensional elasticity on a block of 40 x 16 x 6 voxels
//! in 21 orders: `cargo run --release -p beadwork-thermal --example elastic`.
//!
//! Takes a few minutes per order.
//! Prints a row of a Markdown table for each order: cost by the paper's reward, then lift and
//! curvatures along x and y of the estimate and of elasticity, with a part that slides on the
//! plate, and the lifts of a part that is bonded to it and of one that bends freely.

use std::io::{self, Write};
use std::sync::Arc;

use beadwork_base::Control;
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Order};
use beadwork_thermal::oracle::elastic::{ElasticPrint, Support};
use beadwork_thermal::simulation::Method;
use beadwork_thermal::warpage::WarpageEstimator;
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use ndarray::Array3;

const ORDERS: [&str; 21] = [
    "zigzag-x-0",
    "zigzag-y-0",
    "raster-x-0",
    "raster-y-0",
    "spiral-in-0",
    "spiral-out-0",
    "contour-zigzag-x-0",
    "contour-raster-x-0",
    "diagonal-0",
    "lines-x-interleaved-2-0",
    "lines-x-interleaved-4-0",
    "lines-x-scattered-5-0",
    "lines-x-scattered-7-0",
    "lines-x-golden-0",
    "lines-x-bit-reversed-0",
    "lines-y-interleaved-2-0",
    "lines-y-interleaved-4-0",
    "lines-y-scattered-5-0",
    "lines-y-scattered-7-0",
    "lines-y-golden-0",
    "lines-y-bit-reversed-0",
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (width, height) = (40, 16);
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height };
    let part = Arc::new(Voxels::new(frame, Array3::zeros((6, 16, 40))));
    let abs = ThermalMaterial::abs();
    // A third of the paper's speed, so that layers of this small part cool.
    let process = ProcessParameters {
        print_mm_s: 10.0,
        travel_mm_s: Some(50.0),
        ..ProcessParameters::default()
    };
    let control = Control::default();
    for name in ORDERS {
        let order: Order = name.parse()?;
        let mut print = Simulation::new(part.clone(), &abs, &process, Method::default())?;
        let mut estimate = WarpageEstimator::new(&part, &abs);
        let supports = [Support::Sliding, Support::Bonded, Support::None];
        let mut elastic = supports.map(|support| ElasticPrint::new(&part, &abs, support));
        let mut cost = 0.0;
        for layer in 0..6 {
            let events = print.layer_events(layer, &order.order(&part.region(layer as usize)?));
            let sample = |print: &Simulation| {
                estimate.sample(print);
                elastic.iter_mut().for_each(|elastic| elastic.sample(print));
            };
            print.run_sampled(&events, 2.0, sample, &control)?;
            cost += print.statistics().map_or(0.0, |all| all.std_c);
        }
        let estimate = estimate.finish(&print, &control)?;
        let [x, y] = estimate.axis_curvatures_1_m;
        let [sliding, bonded, free] = elastic.map(|elastic| elastic.finish(&print));
        let [elastic_x, elastic_y] = sliding.curvatures_1_m;
        writeln!(
            io::stdout(),
            "| {name} | {cost:.1} | {:.3} | {x:.2} | {y:.2} | {:.3} | {elastic_x:.2} \
             | {elastic_y:.2} | {:.3} | {:.3} |",
            estimate.corner_lift_mm,
            sliding.lift_mm,
            bonded.lift_mm,
            free.lift_mm
        )?;
    }
    Ok(())
}
