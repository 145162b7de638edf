//! Coefficients of a voxel.

use beadwork_part::Frame;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};

/// Stefan-Boltzmann constant, W/(m² K⁴), rounded as in the paper (Kim et al. 2026).
const STEFAN_BOLTZMANN: f64 = 5.67e-8;

/// Offset of the Celsius scale, K.
const ZERO_CELSIUS_K: f64 = 273.15;

/// Coefficients of the heat equation of one voxel; θ is a temperature above the air, in K.
#[derive(Clone, Debug)]
pub(super) struct Coefficients {
    /// Conduction to a neighbour at the side and above or below, 1/s.
    pub(super) lateral: f64,
    pub(super) vertical: f64,
    /// Area of a side and of the top, divided by the heat capacity, m² K/J.
    pub(super) side_area: f64,
    pub(super) top_area: f64,
    /// Heat transfer coefficient of the surface as a cubic polynomial in θ, W/(m² K): convection
    /// and radiation.
    pub(super) loss: [f32; 4],
    /// θ of the build plate; `None` if it does not conduct.
    pub(super) plate_k: Option<f64>,
    /// θ at which a voxel is deposited.
    pub(super) birth_k: f64,
    /// Heat that the nozzle adds while it holds a voxel at its temperature, relative to that which
    /// raises the voxel to it from the temperature below.
    pub(super) hold: f64,
}

impl Coefficients {
    pub(super) fn new(
        frame: &Frame,
        material: &ThermalMaterial,
        process: &ProcessParameters,
    ) -> Self {
        let (cell_m, layer_m) = (frame.cell_mm / 1e3, frame.layer_mm / 1e3);
        let diffusivity = material.diffusivity_m2_s();
        let capacity = material.heat_capacity_j_m3k();
        let (lateral, vertical) =
            (diffusivity / (cell_m * cell_m), diffusivity / (layer_m * layer_m));
        let air_k = process.ambient_c + ZERO_CELSIUS_K;
        let emission = material.emissivity * STEFAN_BOLTZMANN;
        let constant = process.convection_w_m2k + 4.0 * emission * air_k.powi(3);
        let loss = [constant, 6.0 * emission * air_k * air_k, 4.0 * emission * air_k, emission];
        // A voxel in a line loses heat to the voxel below it and to the one printed before it,
        // which is hot, too.
        let hold_s = frame.cell_mm / process.print_mm_s;
        Self {
            lateral,
            vertical,
            side_area: 1.0 / (capacity * cell_m),
            top_area: 1.0 / (capacity * layer_m),
            loss: loss.map(|coefficient| coefficient as f32),
            plate_k: process.plate_c.map(|celsius| celsius - process.ambient_c),
            birth_k: process.extrusion_c - process.ambient_c,
            hold: hold_s * (vertical + 1.5 * lateral),
        }
    }

    /// The same, with the heat transfer coefficient of surfaces at θ everywhere.
    pub(super) fn linear(&self, theta: f64) -> Self {
        Self { loss: [self.loss_at(theta) as f32, 0.0, 0.0, 0.0], ..self.clone() }
    }

    /// Heat transfer coefficient of a surface at θ, W/(m² K).
    pub(super) fn loss_at(&self, theta: f64) -> f64 {
        let [a, b, c, d] = self.loss.map(f64::from);
        a + theta * (b + theta * (c + theta * d))
    }
}
