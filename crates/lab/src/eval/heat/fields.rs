//! Temperatures of a print, on its layers and on vertical planes.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_heat::plan::HeatPlan;
use beadwork_part::slice::Voxels;
use beadwork_thermal::section::{Plane, Section};
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use serde::Serialize;

/// Seconds between the end of a print and the measurement of its vertical planes.
///
/// At the moment of the last deposition, deviations would mostly measure how close the last voxel
/// is to the plane.
const REST_S: f64 = 1.0;

/// Temperatures of a print.
pub(super) struct Fields {
    /// The drawn layers, at their ends.
    pub(super) layers: Vec<DrawnLayer>,
    pub(super) planes: PlaneDeviations,
}

/// One layer at its end.
pub(super) struct DrawnLayer {
    pub(super) layer: usize,
    pub(super) section: Section,
    /// Standard deviation of all deposited voxels, K.
    pub(super) std_k: f64,
}

/// Maximum thermal deviations on vertical planes one second after the end of a print, K: the
/// difference between a voxel's temperature and the mean of the plane (Kim et al. 2026, figure 10).
#[derive(Clone, Copy, Serialize)]
#[expect(clippy::struct_field_names, reason = "keys of JSON end with their unit")]
pub(super) struct PlaneDeviations {
    /// On the plane through the centre with the normal y: x to the right, z upwards.
    pub(super) central_y_k: f64,
    /// Mean over all planes with the normal y.
    pub(super) mean_y_k: f64,
    /// On the plane through the centre with the normal x.
    pub(super) central_x_k: f64,
    /// Mean over all planes with the normal x.
    pub(super) mean_x_k: f64,
}

impl PlaneDeviations {
    fn of(simulation: &Simulation) -> Self {
        let frame = simulation.part().frame;
        let deviation = |plane: Plane| simulation.section(plane).max_deviation_k();
        let mean = |planes: &mut dyn Iterator<Item = Plane>| {
            let deviations: Vec<f64> = planes.filter_map(deviation).collect();
            deviations.iter().sum::<f64>() / deviations.len() as f64
        };
        let central = |plane: Plane| deviation(plane).unwrap_or(f64::NAN);
        Self {
            central_y_k: central(Plane::Y(frame.height / 2)),
            mean_y_k: mean(&mut (0..frame.height).map(Plane::Y)),
            central_x_k: central(Plane::X(frame.width / 2)),
            mean_x_k: mean(&mut (0..frame.width).map(Plane::X)),
        }
    }
}

impl Fields {
    /// Prints a plan by a simulation of high accuracy, in ABS with the paper's settings; `drawn`
    /// are the numbers of layers.
    pub(super) fn of(
        part: &Arc<Voxels>,
        plan: &HeatPlan,
        drawn: &[usize],
        control: &Control<'_>,
    ) -> anyhow::Result<Self> {
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let method = Method::Fast(Accuracy::High);
        let mut simulation = Simulation::new(part.clone(), &material, &process, method)?;
        let mut layers = Vec::new();
        let own = control.without_progress();
        for (layer, planned) in plan.layers.iter().enumerate() {
            simulation.deposit(layer as u32, &planned.cells, &own)?;
            if drawn.contains(&layer) {
                layers.push(DrawnLayer {
                    layer,
                    section: simulation.section(Plane::Layer(layer as u32)),
                    std_k: simulation.statistics().map_or(0.0, |all| all.std_c),
                });
            }
            control.report(layer + 1, plan.layers.len());
        }
        simulation.pause(REST_S, &own)?;
        Ok(Self { layers, planes: PlaneDeviations::of(&simulation) })
    }
}

/// The layers to draw: the middle one and the last.
pub(super) fn drawn(depth: usize) -> Vec<usize> {
    let mut layers = vec![depth.saturating_sub(1) / 2, depth.saturating_sub(1)];
    layers.dedup();
    layers
}

#[cfg(test)]
mod tests {
    use beadwork_heat::model::{LayerCost, Solver};
    use beadwork_heat::plan::same_order;
    use beadwork_part::Order;
    use beadwork_thermal::objective::Objective;

    use super::*;
    use crate::heat_parts::cuboid;

    #[test]
    fn fields_are_those_of_the_plan() {
        let part = Arc::new(cuboid([12, 8, 3]));
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let method = Method::Fast(Accuracy::High);
        let cost = LayerCost::of(Objective::Reward).unwrap();
        let model = Solver::new(part.clone(), &material, &process, method, cost).unwrap();
        let control = Control::default();
        let plan = same_order(&model, Order::CONVENTIONAL, &control).unwrap();
        let fields = Fields::of(&part, &plan, &drawn(part.depth), &control).unwrap();
        assert_eq!(fields.layers.iter().map(|drawn| drawn.layer).collect::<Vec<_>>(), [1, 2]);
        for drawn in &fields.layers {
            assert!((drawn.std_k - plan.layers[drawn.layer].cost).abs() < 1e-9);
            assert!(drawn.section.temperatures_c.iter().all(|celsius| celsius.is_finite()));
        }
        let PlaneDeviations { central_y_k, mean_y_k, central_x_k, mean_x_k } = fields.planes;
        for deviation in [central_y_k, mean_y_k, central_x_k, mean_x_k] {
            assert!(deviation > 0.0 && deviation < 205.0, "{deviation}");
        }
        assert_eq!((drawn(0), drawn(1), drawn(2)), (vec![0], vec![0], vec![0, 1]));
    }
}
