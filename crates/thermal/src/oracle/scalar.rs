//! The heat equation in double precision, one face of one voxel at a time: the definition that all
//! other methods are compared with.
//!
//! Slow, and written to be read.
//! It shares no code with the fast methods, so that no mistake can be in both.
//! It keeps account of all heat flows, so that the energy balance shows whether one is missing.

use std::sync::Arc;

use beadwork_part::slice::Voxels;

use crate::event::DepositionEvent;
use crate::material::ThermalMaterial;
use crate::process::ProcessParameters;
use crate::property::PropertyError;

/// The Stefan-Boltzmann constant, W/(m² K⁴).
const SIGMA: f64 = 5.67e-8;

/// The time integration of a [`ScalarSolver`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Forward Euler: one step per deposited voxel, and pauses in equal steps no longer than a
    /// deposition at the process's speed.
    /// [`Method::Naive`](crate::simulation::Method::Naive) computes the same.
    Euler,
    /// Heun's method.
    /// Pauses and slow depositions are split into equal intervals no longer than a deposition at
    /// the process's speed.
    /// [`Method::Reference`](crate::simulation::Method::Reference) computes the same.
    Heun {
        /// Steps per deposition or interval, at least 1.
        steps: u32,
    },
}

/// Heat that has entered and left a part since its start, J, relative to the ambient temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Heat of voxels at the moment of their deposition.
    pub births_j: f64,
    /// Heat from the nozzle that holds each voxel at the extrusion temperature.
    pub hold_j: f64,
    /// Heat from the build plate; negative if the plate took more than it gave.
    pub plate_j: f64,
    /// Heat lost to the air by convection and radiation; negative if the air gave more than it
    /// took.
    pub air_j: f64,
    /// Sum of the absolute values of all these flows.
    pub moved_j: f64,
}

/// Heat flows at one moment, W.
struct Flow {
    /// Into each voxel.
    voxels: Vec<f64>,
    /// From the plate.
    plate: f64,
    /// To the air.
    air: f64,
    /// From the nozzle into the voxel it holds.
    hold: f64,
}

/// A part during its print, stepped voxel by voxel.
///
/// A voxel is active from the start of its event, and held at [`ProcessParameters::extrusion_c`]
/// until its end.
/// It conducts heat to active neighbours.
/// The lower face of a voxel in layer 0 lies on the build plate, half a voxel below its centre.
/// Every other face without an active neighbour loses heat to the air.
#[derive(Clone, Debug)]
pub struct ScalarSolver {
    part: Arc<Voxels>,
    material: ThermalMaterial,
    process: ProcessParameters,
    scheme: Scheme,
    /// Temperature of each voxel, `[z, y, x]`; `None` until it is deposited.
    celsius: Vec<Option<f64>>,
    energy: Energy,
    seconds: f64,
}

impl ScalarSolver {
    /// A part of which nothing is deposited yet.
    ///
    /// # Panics
    /// If the scheme has 0 steps.
    pub fn new(
        part: Arc<Voxels>,
        material: &ThermalMaterial,
        process: &ProcessParameters,
        scheme: Scheme,
    ) -> Result<Self, PropertyError> {
        material.check()?;
        process.check()?;
        assert_ne!(scheme, Scheme::Heun { steps: 0 }, "a deposition takes at least 1 step");
        let celsius = vec![None; part.materials().len()];
        let (material, process) = (material.clone(), process.clone());
        Ok(Self {
            part,
            material,
            process,
            scheme,
            celsius,
            energy: Energy::default(),
            seconds: 0.0,
        })
    }

    /// Runs through deposition events.
    /// Each step costs the part's bounding box.
    ///
    /// # Panics
    /// If a voxel is not part of the print or is deposited already.
    pub fn run(&mut self, events: &[DepositionEvent]) {
        for event in events {
            let held = event.voxel.map(|voxel| self.birth(voxel));
            let (intervals, steps) = match self.scheme {
                Scheme::Euler if held.is_some() => (1, 1),
                Scheme::Euler => (self.intervals(event.seconds), 1),
                Scheme::Heun { steps } => (self.intervals(event.seconds), steps),
            };
            let count = intervals * steps;
            for _ in 0..count {
                self.step(event.seconds / f64::from(count), held);
            }
            self.seconds += event.seconds;
        }
    }

    /// Temperature of the voxel at x, y and z, °C; `None` if it is not deposited.
    pub fn temperature_c(&self, voxel: [u32; 3]) -> Option<f64> {
        let [x, y, z] = voxel;
        self.part.material(x, y, z as usize)?;
        self.celsius[self.index(voxel)]
    }

    /// Simulated time since the start of the print, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The heat that has entered and left the part.
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// Heat in all deposited voxels, J, relative to the ambient temperature.
    pub fn stored_heat_j(&self) -> f64 {
        let above_air = |celsius: &f64| (celsius - self.process.ambient_c) * self.voxel_j_k();
        self.celsius.iter().flatten().map(above_air).sum()
    }

    /// Error of the energy balance: the difference between the stored heat and the heat that
    /// entered minus the heat that left, as a fraction of [`Energy::moved_j`].
    pub fn imbalance(&self) -> f64 {
        let Energy { births_j, hold_j, plate_j, air_j, moved_j } = self.energy;
        let missing = self.stored_heat_j() - (births_j + hold_j + plate_j - air_j);
        if moved_j == 0.0 { missing.abs() } else { missing.abs() / moved_j }
    }

    fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        let (width, height) = (self.part.frame.width as usize, self.part.frame.height as usize);
        (z as usize * height + y as usize) * width + x as usize
    }

    /// Sizes of a voxel along x, y and z, m.
    fn size_m(&self) -> [f64; 3] {
        let (width, height) = (self.part.frame.cell_mm / 1e3, self.part.frame.layer_mm / 1e3);
        [width, width, height]
    }

    /// Heat that raises the temperature of a voxel by one kelvin, J/K.
    fn voxel_j_k(&self) -> f64 {
        let [x, y, z] = self.size_m();
        self.material.heat_capacity_j_m3k() * x * y * z
    }

    /// The number of equal intervals, no longer than a deposition, that a time is split into.
    fn intervals(&self, seconds: f64) -> u32 {
        let birth_s = self.part.frame.cell_mm / self.process.print_mm_s;
        // The tolerance keeps rounding errors from adding an interval.
        (seconds / birth_s - 1e-6).ceil().max(1.0) as u32
    }

    /// Deposits a voxel and returns its index.
    fn birth(&mut self, voxel: [u32; 3]) -> usize {
        let [x, y, z] = voxel;
        assert!(
            self.part.material(x, y, z as usize).is_some(),
            "voxel {voxel:?} is not part of the print"
        );
        let index = self.index(voxel);
        assert!(self.celsius[index].is_none(), "voxel {voxel:?} is deposited already");
        self.celsius[index] = Some(self.process.extrusion_c);
        let heat = self.voxel_j_k() * (self.process.extrusion_c - self.process.ambient_c);
        self.energy.births_j += heat;
        self.energy.moved_j += heat.abs();
        index
    }

    fn step(&mut self, seconds: f64, held: Option<usize>) {
        let warming = seconds / self.voxel_j_k();
        let moved = |from: &[Option<f64>], flow: &Flow| -> Vec<Option<f64>> {
            from.iter()
                .zip(&flow.voxels)
                .map(|(celsius, watts)| celsius.map(|c| c + warming * watts))
                .collect()
        };
        let first = self.flow(&self.celsius, held);
        match self.scheme {
            Scheme::Euler => {
                self.celsius = moved(&self.celsius, &first);
                self.record(&first, seconds);
            }
            Scheme::Heun { .. } => {
                let second = self.flow(&moved(&self.celsius, &first), held);
                let mean = Flow {
                    voxels: first
                        .voxels
                        .iter()
                        .zip(&second.voxels)
                        .map(|(a, b)| (a + b) / 2.0)
                        .collect(),
                    plate: f64::midpoint(first.plate, second.plate),
                    air: f64::midpoint(first.air, second.air),
                    hold: f64::midpoint(first.hold, second.hold),
                };
                self.celsius = moved(&self.celsius, &mean);
                self.record(&mean, seconds);
            }
        }
    }

    /// Adds flows over some time to the energy account.
    fn record(&mut self, flow: &Flow, seconds: f64) {
        self.energy.plate_j += flow.plate * seconds;
        self.energy.air_j += flow.air * seconds;
        self.energy.hold_j += flow.hold * seconds;
        self.energy.moved_j += (flow.plate.abs() + flow.air.abs() + flow.hold.abs()) * seconds;
    }

    /// All heat flows at the given temperatures, by the heat equation.
    fn flow(&self, celsius: &[Option<f64>], held: Option<usize>) -> Flow {
        let mut flow = Flow { voxels: vec![0.0; celsius.len()], plate: 0.0, air: 0.0, hold: 0.0 };
        let (width, height) = (self.part.frame.width, self.part.frame.height);
        let [dx, dy, dz] = self.size_m();
        let k = self.material.conductivity_w_mk;
        for z in 0..self.part.depth as u32 {
            for y in 0..height {
                for x in 0..width {
                    let index = self.index([x, y, z]);
                    let Some(own) = celsius[index] else { continue };
                    let neighbour = |[x, y, z]: [u32; 3]| celsius[self.index([x, y, z])];
                    let mut watts = 0.0;

                    let faces = [
                        (if x > 0 { neighbour([x - 1, y, z]) } else { None }, dy * dz, dx, false),
                        (
                            if x + 1 < width { neighbour([x + 1, y, z]) } else { None },
                            dy * dz,
                            dx,
                            false,
                        ),
                        (if y > 0 { neighbour([x, y - 1, z]) } else { None }, dx * dz, dy, false),
                        (
                            if y + 1 < height { neighbour([x, y + 1, z]) } else { None },
                            dx * dz,
                            dy,
                            false,
                        ),
                        (if z > 0 { neighbour([x, y, z - 1]) } else { None }, dx * dy, dz, z == 0),
                        (
                            if z as usize + 1 < self.part.depth {
                                neighbour([x, y, z + 1])
                            } else {
                                None
                            },
                            dx * dy,
                            dz,
                            false,
                        ),
                    ];
                    for (other, area, distance, on_plate) in faces {
                        if let Some(other) = other {
                            watts += k * area / distance * (other - own);
                        } else if on_plate {
                            if let Some(plate) = self.process.plate_c {
                                let taken = 2.0 * k * area / distance * (plate - own);
                                watts += taken;
                                flow.plate += taken;
                            }
                        } else {
                            let lost = self.lost_w_m2(own, distance) * area;
                            watts -= lost;
                            flow.air += lost;
                        }
                    }

                    if held == Some(index) {
                        flow.hold -= watts;
                        watts = 0.0;
                    }
                    flow.voxels[index] = watts;
                }
            }
        }
        flow
    }

    /// Heat flux from a surface to the air, W/m², given the temperature at the centre of its voxel
    /// and the voxel's size across the surface, m.
    fn lost_w_m2(&self, celsius: f64, size_m: f64) -> f64 {
        let grey = self.material.emissivity * SIGMA;
        let h = self.process.convection_w_m2k;
        let (t, air) = (celsius + 273.15, self.process.ambient_c + 273.15);
        if self.process.surface_resistance {
            let total = h + grey * (t + air) * (t * t + air * air);
            total / (1.0 + total * size_m / (2.0 * self.material.conductivity_w_mk)) * (t - air)
        } else {
            h * (t - air) + grey * (t.powi(4) - air.powi(4))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use beadwork_part::Frame;
    use ndarray::Array3;

    #[test]
    fn a_single_voxel_cools_as_computed_by_hand() {
        let frame =
            Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 1, height: 1 };
        let part = Arc::new(Voxels::new(frame, Array3::zeros((1, 1, 1))));
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let mut solver = ScalarSolver::new(part, &material, &process, Scheme::Euler).unwrap();
        let birth = DepositionEvent { voxel: Some([0, 0, 0]), seconds: 0.01 };
        solver.run(&[birth, DepositionEvent::pause(0.01)]);
        // Four sides of 0.5 x 0.25 mm and a top of 0.5 x 0.5 mm in the air, the bottom on the
        // plate.
        let open = 4.0 * 0.5e-3 * 0.25e-3 + 0.5e-3 * 0.5e-3;
        let lost = (10.0 * 205.0 + 0.92 * 5.67e-8 * (503.15f64.powi(4) - 298.15f64.powi(4))) * open;
        let plate = 0.33 * 0.25e-6 / 0.125e-3 * 150.0;
        let capacity = 945.0 * 1470.0 * 0.0625e-9;
        let expected = 230.0 - 0.01 * (lost + plate) / capacity;
        assert!((solver.temperature_c([0, 0, 0]).unwrap() - expected).abs() < 1e-9);
        let Energy { births_j, hold_j, plate_j, air_j, .. } = solver.energy();
        assert!((births_j / (capacity * 205.0) - 1.0).abs() < 1e-12);
        assert!((hold_j / (0.01 * (lost + plate)) - 1.0).abs() < 1e-12);
        assert!((plate_j / (-0.02 * plate) - 1.0).abs() < 1e-12);
        assert!((air_j / (0.02 * lost) - 1.0).abs() < 1e-12);
        assert!((solver.seconds() - 0.02).abs() < 1e-15);
    }
}
