//! Temperatures of a print, on its layers and on vertical planes.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_heat::plan::HeatPlan;
use beadwork_part::slice::Voxels;
use beadwork_thermal::section::{Plane, Section};
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use serde::Serialize;

use crate::statistics::mean;

/// Moments after the end of a print at which deviations on planes are measured, s.
///
/// At the end itself, they would mostly measure how close the last voxel is to the plane; one
/// second later, how close the last lines are; half a minute later, the temperatures of the whole
/// part.
pub(super) const MOMENTS_S: [f64; 2] = [1.0, 30.0];

/// Temperatures of a print.
pub(super) struct Fields {
    /// The drawn layers, at their ends.
    pub(super) layers: Vec<DrawnLayer>,
    /// Deviations at each of the [`MOMENTS_S`].
    pub(super) planes: Vec<PlaneDeviations>,
}

/// One layer at its end.
pub(super) struct DrawnLayer {
    pub(super) layer: usize,
    pub(super) section: Section,
    /// Standard deviation of all deposited voxels, K.
    pub(super) std_k: f64,
}

/// Maximum thermal deviations on planes after the end of a print, K: the difference between a
/// voxel's temperature and the mean of the plane (Kim et al. 2026, figure 10).
#[derive(Clone, Copy, Serialize)]
pub(super) struct PlaneDeviations {
    /// Time since the end of the print, s.
    pub(super) after_s: f64,
    /// On vertical planes along x.
    pub(super) along_x: Deviations,
    /// On vertical planes along y.
    pub(super) along_y: Deviations,
    /// On layers.
    pub(super) layers: Deviations,
}

/// Maximum deviations on parallel planes, K.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Deviations {
    /// On the plane through the centre.
    pub(super) central_k: f64,
    /// Mean over all planes.
    pub(super) mean_k: f64,
}

impl Deviations {
    fn of(simulation: &Simulation, count: u32, plane: fn(u32) -> Plane) -> Self {
        let deviation = |at: u32| simulation.section(plane(at)).max_deviation_k();
        let all: Vec<f64> = (0..count).filter_map(deviation).collect();
        Self { central_k: deviation(count / 2).unwrap_or(f64::NAN), mean_k: mean(all.into_iter()) }
    }
}

impl PlaneDeviations {
    fn of(simulation: &Simulation, after_s: f64) -> Self {
        let (frame, depth) = (simulation.part().frame, simulation.part().depth as u32);
        Self {
            after_s,
            along_x: Deviations::of(simulation, frame.height, Plane::Y),
            along_y: Deviations::of(simulation, frame.width, Plane::X),
            layers: Deviations::of(simulation, depth, Plane::Layer),
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
            simulation.deposit(layer as u32, &planned.path, &own)?;
            if drawn.contains(&layer) {
                layers.push(DrawnLayer {
                    layer,
                    section: simulation.section(Plane::Layer(layer as u32)),
                    std_k: simulation.statistics().map_or(0.0, |all| all.std_c),
                });
            }
            control.report(layer + 1, plan.layers.len());
        }
        let mut planes = Vec::new();
        let mut now_s = 0.0;
        for after_s in MOMENTS_S {
            simulation.pause(after_s - now_s, &own)?;
            now_s = after_s;
            planes.push(PlaneDeviations::of(&simulation, after_s));
        }
        Ok(Self { layers, planes })
    }
}

/// The layers to draw: the middle one, and the last that has a tenth of the cells of the largest
/// layer or more, so that tips are left out.
pub(super) fn drawn(part: &Voxels) -> Vec<usize> {
    let cells: Vec<usize> = (0..part.depth).map(|layer| part.cells(layer).count()).collect();
    let max = cells.iter().copied().max().unwrap_or(0);
    let last = cells.iter().rposition(|&cells| 10 * cells >= max).unwrap_or(0);
    let middle = part.depth.saturating_sub(1) / 2;
    let mut layers = vec![middle.min(last), last];
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
    use crate::heat_parts::{HeatPart, cuboid};

    #[test]
    fn fields_are_those_of_the_plan() {
        let part = Arc::new(cuboid([12, 8, 3]));
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let method = Method::Fast(Accuracy::High);
        let cost = LayerCost::of(Objective::Reward).unwrap();
        let model = Solver::new(part.clone(), &material, &process, method, cost).unwrap();
        let control = Control::default();
        let plan = same_order(&model, Order::CONVENTIONAL, &control).unwrap();
        let fields = Fields::of(&part, &plan, &drawn(&part), &control).unwrap();
        assert_eq!(fields.layers.iter().map(|drawn| drawn.layer).collect::<Vec<_>>(), [1, 2]);
        for drawn in &fields.layers {
            assert!((drawn.std_k - plan.layers[drawn.layer].cost).abs() < 1e-9);
            assert!(drawn.section.temperatures_c.iter().all(|celsius| celsius.is_finite()));
        }
        let of = |planes: &PlaneDeviations| [planes.along_x, planes.along_y, planes.layers];
        let [early, late] = [0, 1].map(|moment| of(&fields.planes[moment]));
        for (early, late) in early.into_iter().zip(late) {
            for (early, late) in [(early.central_k, late.central_k), (early.mean_k, late.mean_k)] {
                assert!(0.0 < late && late < early && early < 205.0, "{early} {late}");
            }
        }
    }

    #[test]
    fn tips_are_not_drawn() {
        assert_eq!(drawn(&cuboid([4, 4, 1])), [0]);
        assert_eq!(drawn(&cuboid([4, 4, 2])), [0, 1]);
        // Layers of the pyramid have 60 cells along a side and fewer, 19 or more up to layer 56.
        assert_eq!(drawn(&HeatPart::Pyramid.voxels()), [38, 56]);
    }
}
