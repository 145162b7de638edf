//! Time of an order of one layer: by the proxy, and by the solver.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_heat::model::{LayerCost, Screen, Solver, ThermalModel};
use beadwork_heat::proxy::LayerProxy;
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Order};
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use ndarray::Array3;

/// Number of the layer, so that the model of the proxy has all of its levels.
const LAYER: u32 = 9;

/// A cuboid of 120 voxels along x, printed up to [`LAYER`], and an order of that layer's lines.
fn layer(height: u32, accuracy: Accuracy) -> (Solver, Vec<Cell>) {
    let (left_mm, back_mm, cell_mm, layer_mm, width) = (0.0, 0.0, 0.5, 0.25, 120);
    let frame = Frame { left_mm, back_mm, cell_mm, layer_mm, width, height };
    let materials = Array3::zeros((12, height as usize, width as usize));
    let part = Arc::new(Voxels::new(frame, materials));
    let order: Order = "lines-x-scattered-7-0".parse().expect("the name is valid");
    let cells = order.order(&part.region(0).expect("all layers have cells"));
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let cost = LayerCost::of(Objective::Reward).expect("the reward is a sum over layers");
    let method = Method::Fast(accuracy);
    let mut model = Solver::new(part, &material, &process, method, cost).expect("valid parameters");
    for layer in 0..LAYER {
        model.deposit(layer, &cells, &Control::default()).expect("the order has all cells");
    }
    (model, cells)
}

fn proxy(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("proxy");
    for height in [20, 40, 80] {
        let (model, cells) = layer(height, Accuracy::Standard);
        group.throughput(Throughput::Elements(cells.len() as u64));
        group.bench_function(BenchmarkId::new("set-up", cells.len()), |bencher| {
            let (simulation, material) = (model.simulation(), ThermalMaterial::abs());
            bencher.iter_with_large_drop(|| LayerProxy::new(simulation, LAYER, &material));
        });
        let screen = model.screen(LAYER).expect("the reward has a proxy");
        group.bench_function(BenchmarkId::new("order", cells.len()), |bencher| {
            bencher.iter(|| screen.cost(&cells));
        });
    }
}

fn solver(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("solver");
    group.sample_size(20);
    for (name, accuracy) in [("draft", Accuracy::Draft), ("standard", Accuracy::Standard)] {
        let (model, cells) = layer(40, accuracy);
        group.throughput(Throughput::Elements(cells.len() as u64));
        group.bench_function(BenchmarkId::new(name, cells.len()), |bencher| {
            bencher.iter_with_large_drop(|| {
                let mut model = model.clone();
                model.deposit(LAYER, &cells, &Control::default()).expect("the order has all cells");
                model
            });
        });
    }
}

criterion_group!(benches, proxy, solver);
criterion_main!(benches);
