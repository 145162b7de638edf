//! The definition, in f64, one voxel at a time: what everything else is compared with.
//!
//! Slow, and written to be read: each face of each voxel is looked at by itself, and its heat flow
//! is a line.
//! Nothing is shared with the fast code, so that no mistake can be made in both at once.
//! All flows are booked, so that the balance of energy shows that none was forgotten.

use std::sync::Arc;

use beadwork_part::slice::Voxels;

use crate::material::Material;
use crate::process::Process;
use crate::property::PropertyError;
use crate::timeline::Slot;

/// Stefan and Boltzmann's constant, W/(m² K⁴).
const SIGMA: f64 = 5.67e-8;

/// How a step is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Forward Euler: one step for each birth, and pauses in equal steps no longer than a birth at
    /// the process's speed.
    /// This is what [`crate::Method::Naive`] computes.
    Euler,
    /// Heun's method: so many steps for each birth.
    /// Pauses and slower births are cut into equal stretches no longer than a birth at the
    /// process's speed, of so many steps each.
    /// This is what [`crate::Method::Reference`] computes.
    Heun {
        /// At least 1.
        steps: u32,
    },
}

/// Where the heat of a part came from and went to since its start, J, relative to a part as warm as
/// the air.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Brought in by voxels at their birth.
    pub births_j: f64,
    /// Brought in by the nozzle, to hold each voxel at the temperature of its birth.
    pub hold_j: f64,
    /// Taken up from the build plate; negative if more was given to it.
    pub plate_j: f64,
    /// Lost to the air by convection and radiation; negative if more was taken up.
    pub air_j: f64,
    /// All amounts that crossed the part's surface or came with a birth, whichever way they went.
    pub moved_j: f64,
}

/// What flows at one moment, W.
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

/// A part in the middle of its print, in the plainest way.
///
/// A voxel is active from the start of its slot, and held at [`Process::extrusion_c`] until its
/// end.
/// It conducts heat to active neighbours; the lower face of layer 0 lies on the build plate, half a
/// voxel below its centre; every other face without an active neighbour loses heat to the air.
#[derive(Clone, Debug)]
pub struct Plain {
    part: Arc<Voxels>,
    material: Material,
    process: Process,
    scheme: Scheme,
    /// Of every voxel, `[z, y, x]`; `None` until it is deposited.
    celsius: Vec<Option<f64>>,
    energy: Energy,
    seconds: f64,
}

impl Plain {
    /// A part before anything is deposited.
    ///
    /// # Panics
    /// If the scheme has no steps.
    pub fn new(
        part: Arc<Voxels>,
        material: &Material,
        process: &Process,
        scheme: Scheme,
    ) -> Result<Self, PropertyError> {
        material.check()?;
        process.check()?;
        assert_ne!(scheme, Scheme::Heun { steps: 0 }, "a birth takes at least 1 step");
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

    /// Runs through births and pauses.
    /// Each step costs a visit to every voxel.
    ///
    /// # Panics
    /// If a voxel is not part of the print or is deposited already.
    pub fn run(&mut self, slots: &[Slot]) {
        for slot in slots {
            let held = slot.voxel.map(|voxel| self.birth(voxel));
            let (stretches, steps) = match self.scheme {
                Scheme::Euler if held.is_some() => (1, 1),
                Scheme::Euler => (self.stretches(slot.seconds), 1),
                Scheme::Heun { steps } => (self.stretches(slot.seconds), steps),
            };
            let count = stretches * steps;
            for _ in 0..count {
                self.step(slot.seconds / f64::from(count), held);
            }
            self.seconds += slot.seconds;
        }
    }

    /// Temperature of a voxel, °C; `None` if it is not deposited.
    pub fn temperature_c(&self, voxel: [u32; 3]) -> Option<f64> {
        let [x, y, z] = voxel;
        self.part.material(x, y, z as usize)?;
        self.celsius[self.index(voxel)]
    }

    /// Time since the start, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Where the heat came from and went to.
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// Heat in all deposited voxels, J, relative to the air's temperature.
    pub fn stored_j(&self) -> f64 {
        let above_air = |celsius: &f64| (celsius - self.process.ambient_c) * self.voxel_j_k();
        self.celsius.iter().flatten().map(above_air).sum()
    }

    /// How far the energy stored is from what came in less what went out, as a part of
    /// [`Energy::moved_j`].
    pub fn imbalance(&self) -> f64 {
        let Energy { births_j, hold_j, plate_j, air_j, moved_j } = self.energy;
        let missing = self.stored_j() - (births_j + hold_j + plate_j - air_j);
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

    /// Heat that warms a voxel by one kelvin, J/K.
    fn voxel_j_k(&self) -> f64 {
        let [x, y, z] = self.size_m();
        self.material.heat_capacity_j_m3k() * x * y * z
    }

    fn stretches(&self, seconds: f64) -> u32 {
        let birth_s = self.part.frame.cell_mm / self.process.print_mm_s;
        // A whole number of births must not become one more by rounding.
        (seconds / birth_s - 1e-6).ceil().max(1.0) as u32
    }

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
                self.book(&first, seconds);
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
                self.book(&mean, seconds);
            }
        }
    }

    fn book(&mut self, flow: &Flow, seconds: f64) {
        self.energy.plate_j += flow.plate * seconds;
        self.energy.air_j += flow.air * seconds;
        self.energy.hold_j += flow.hold * seconds;
        self.energy.moved_j += (flow.plate.abs() + flow.air.abs() + flow.hold.abs()) * seconds;
    }

    /// The heat equation.
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

    /// What a surface loses to the air, W/m², given the temperature at the centre of a voxel of a
    /// size in metres.
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

    /// One voxel in the air, by hand.
    #[test]
    fn a_single_voxel_is_what_one_computes_by_hand() {
        let frame =
            Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 1, height: 1 };
        let part = Arc::new(Voxels::new(frame, Array3::zeros((1, 1, 1))));
        let mut plain =
            Plain::new(part, &Material::abs(), &Process::default(), Scheme::Euler).unwrap();
        let birth = Slot { voxel: Some([0, 0, 0]), seconds: 0.01 };
        plain.run(&[birth, Slot::pause(0.01)]);
        // Four sides of 0.5 x 0.25 mm and a top of 0.5 x 0.5 mm in the air, the bottom on the
        // plate.
        let open = 4.0 * 0.5e-3 * 0.25e-3 + 0.5e-3 * 0.5e-3;
        let lost = (10.0 * 205.0 + 0.92 * 5.67e-8 * (503.15f64.powi(4) - 298.15f64.powi(4))) * open;
        let plate = 0.33 * 0.25e-6 / 0.125e-3 * 150.0;
        let warmth = 945.0 * 1470.0 * 0.0625e-9;
        let expected = 230.0 - 0.01 * (lost + plate) / warmth;
        assert!((plain.temperature_c([0, 0, 0]).unwrap() - expected).abs() < 1e-9);
        let Energy { births_j, hold_j, plate_j, air_j, .. } = plain.energy();
        assert!((births_j / (warmth * 205.0) - 1.0).abs() < 1e-12);
        assert!((hold_j / (0.01 * (lost + plate)) - 1.0).abs() < 1e-12);
        assert!((plate_j / (-0.02 * plate) - 1.0).abs() < 1e-12);
        assert!((air_j / (0.02 * lost) - 1.0).abs() < 1e-12);
        assert!((plain.seconds() - 0.02).abs() < 1e-15);
    }
}
