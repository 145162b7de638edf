//! Bodies whose cooling has an analytic solution.
//!
//! Other tests compare one numerical method with another; these measure the discretization error of
//! the voxels.
//!
//! The maximum errors over the centres of all voxels, in K, for ABS that starts at 230 °C in air of
//! 25 °C, with one step of [`Method::Reference`] per deposition:
//!
//! | body | layers of 1 mm | 0.5 mm | 0.25 mm | 0.125 mm | 0.0625 mm |
//! |---|---|---|---|---|---|
//! | slab on the plate | 4.99 | 1.30 | 0.322 | 0.081 | 0.022 |
//! | deep column on the plate | 5.31 | 1.30 | 0.323 | 0.080 | 0.018 |
//! | cube | 6.29 | 3.24 | 1.65 | | |
//! | cube, with surface resistance | 0.282 | 0.075 | 0.016 | | |
//! | corner | 3.18 | 1.38 | 0.861 | | |
//! | corner, with surface resistance | 1.57 | 0.617 | 0.177 | | |
//!
//! The errors fall with the square of the voxel size, except in the bodies that lose heat to the
//! air without surface resistance: there, the temperature at a voxel's centre stands for that of
//! its surface, a first-order error.
//!
//! Formulas: Carslaw and Jaeger, *Conduction of Heat in Solids*, 2nd edition 1959, sections 2.4,
//! 2.7, 3.4 and 3.11.

use std::f64::consts::PI;
use std::sync::Arc;

use beadwork_base::Control;
use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use ndarray::Array3;

use crate::event::DepositionEvent;
use crate::material::ThermalMaterial;
use crate::process::ProcessParameters;
use crate::simulation::{Method, SetupError, Simulation};

/// A body that cools from a uniform temperature, without radiation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// A slab of 2 mm on a plate of 80 °C, infinite in x and y and without loss to the air, after 4
    /// s.
    Slab,
    /// A column on a plate of 80 °C, so tall that its upper end does not matter, after 4 s.
    Deep,
    /// The upper half of a cube of 10 mm in moving air (36 W/(m² K)), after 60 s.
    /// No heat crosses the horizontal plane of symmetry, so an insulating plate stands for the
    /// lower half.
    Cube {
        /// [`ProcessParameters::surface_resistance`].
        surface_resistance: bool,
    },
    /// A corner of a large block in moving air, after 4 s.
    Corner {
        /// [`ProcessParameters::surface_resistance`].
        surface_resistance: bool,
    },
}

/// Differences between simulated temperatures and the formula, K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Root mean square.
    pub rms: f64,
    /// Maximum of the absolute values.
    pub max: f64,
}

const START_C: f64 = 230.0;
const AIR_C: f64 = 25.0;
const PLATE_C: f64 = 80.0;
const CONVECTION_W_M2K: f64 = 36.0;

/// Edges of the cube and of the block that has the corner, and height of the slab, m.
/// The column is as tall as the block.
const CUBE_M: f64 = 10e-3;
const BLOCK_M: f64 = 8e-3;
const SLAB_M: f64 = 2e-3;

impl Body {
    /// All bodies.
    pub const ALL: [Self; 6] = [
        Self::Slab,
        Self::Deep,
        Self::Cube { surface_resistance: false },
        Self::Cube { surface_resistance: true },
        Self::Corner { surface_resistance: false },
        Self::Corner { surface_resistance: true },
    ];

    /// Simulates the body in voxels of a height in mm and twice that width, and compares it with
    /// the formula.
    ///
    /// The height should divide 2 mm, and twice the height 8 mm and 10 mm.
    pub fn deviation(self, layer_mm: f64, method: Method) -> Result<Deviation, SetupError> {
        let material = ThermalMaterial { emissivity: 0.0, ..ThermalMaterial::abs() };
        let part = self.part(layer_mm);
        let frame = part.frame;
        // A twentieth of the time in which heat diffuses through a layer: stable, and so short that
        // the error of the time integration does not matter.
        let step_s = 0.05 * (layer_mm / 1e3).powi(2) / material.diffusivity_m2_s();
        let print_mm_s = frame.cell_mm / step_s;
        let process = ProcessParameters { print_mm_s, ..self.process() };
        let mut simulation = Simulation::new(part.clone(), &material, &process, method)?;
        let layer = |z: usize| {
            part.cells(z).map(move |cell| [cell % frame.width, cell / frame.width, z as u32])
        };
        let voxels: Vec<[u32; 3]> = (0..part.depth).flat_map(layer).collect();
        // Deposited so fast that practically no heat flows meanwhile.
        let birth = |&voxel: &[u32; 3]| DepositionEvent { voxel: Some(voxel), seconds: 1e-9 };
        let births: Vec<DepositionEvent> = voxels.iter().map(birth).collect();
        let control = Control::default();
        simulation.run(&births, &control).expect("each voxel follows the one below it");
        simulation.pause(self.seconds(), &control).expect("the default control never interrupts");

        let sizes_mm = [frame.cell_mm, frame.cell_mm, layer_mm];
        let counts = [frame.width as usize, frame.height as usize, part.depth];
        let factors: [Vec<Option<f64>>; 3] = std::array::from_fn(|axis| {
            let centre_m = |i: usize| (i as f64 + 0.5) * sizes_mm[axis] / 1e3;
            (0..counts[axis]).map(|i| self.factor(axis, centre_m(i), &material)).collect()
        });
        let cold_c = if process.plate_c.is_some() { PLATE_C } else { AIR_C };
        let (mut squares, mut max, mut count) = (0.0, 0.0f64, 0.0);
        for voxel in voxels {
            let along = [0, 1, 2].map(|axis| factors[axis][voxel[axis] as usize]);
            let [Some(x), Some(y), Some(z)] = along else { continue };
            let expected = cold_c + (START_C - cold_c) * x * y * z;
            let computed = simulation.temperature_c(voxel).expect("all voxels are deposited");
            squares += (computed - expected).powi(2);
            max = max.max((computed - expected).abs());
            count += 1.0;
        }
        Ok(Deviation { rms: (squares / count).sqrt(), max })
    }

    /// The body in voxels twice as wide as high.
    fn part(self, layer_mm: f64) -> Arc<Voxels> {
        let (width_m, height_m) = match self {
            Self::Slab => (0.0, SLAB_M),
            Self::Deep => (0.0, BLOCK_M),
            Self::Cube { .. } => (CUBE_M, CUBE_M / 2.0),
            Self::Corner { .. } => (BLOCK_M, BLOCK_M),
        };
        let cell_mm = 2.0 * layer_mm;
        let width = ((width_m * 1e3 / cell_mm).round() as u32).max(1);
        let depth = (height_m * 1e3 / layer_mm).round() as usize;
        let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm, layer_mm, width, height: width };
        Arc::new(Voxels::new(frame, Array3::zeros((depth, width as usize, width as usize))))
    }

    fn process(self) -> ProcessParameters {
        let process = ProcessParameters {
            extrusion_c: START_C,
            ambient_c: AIR_C,
            ..ProcessParameters::default()
        };
        match self {
            Self::Slab | Self::Deep => {
                ProcessParameters { plate_c: Some(PLATE_C), convection_w_m2k: 0.0, ..process }
            }
            Self::Cube { surface_resistance } | Self::Corner { surface_resistance } => {
                ProcessParameters {
                    plate_c: None,
                    convection_w_m2k: CONVECTION_W_M2K,
                    surface_resistance,
                    ..process
                }
            }
        }
    }

    /// How long the body cools.
    fn seconds(self) -> f64 {
        if matches!(self, Self::Cube { .. }) { 60.0 } else { 4.0 }
    }

    /// The factor by which conduction along one axis reduces the initial difference from plate or
    /// air, at a position in m; `None` where the formula does not hold.
    /// The temperature of a body is the product of the factors of all axes.
    fn factor(self, axis: usize, at: f64, material: &ThermalMaterial) -> Option<f64> {
        let spread = material.diffusivity_m2_s() * self.seconds();
        let loss = CONVECTION_W_M2K / material.conductivity_w_mk;
        let vertical = axis == 2;
        match self {
            Self::Slab | Self::Deep if !vertical => Some(1.0),
            Self::Slab => Some(slab(at / SLAB_M, spread / SLAB_M.powi(2))),
            Self::Deep => Some(libm::erf(at / (2.0 * spread.sqrt()))),
            Self::Cube { .. } => {
                let half = CUBE_M / 2.0;
                let from_centre = if vertical { at } else { at - half };
                Some(wall(from_centre / half, loss * half, spread / half.powi(2)))
            }
            Self::Corner { .. } => {
                let depth = if vertical { BLOCK_M - at } else { at };
                // The far half of the block is cooled by its other sides.
                (depth < BLOCK_M / 2.0).then(|| half_space(depth, loss, spread))
            }
        }
    }
}

/// The remaining fraction of the initial difference between a slab and its plate, with an insulated
/// top.
///
/// `height` is from 0 to 1, `time` in units of thickness² / diffusivity.
fn slab(height: f64, time: f64) -> f64 {
    let term = |n: f64| {
        let root = (n + 0.5) * PI;
        2.0 / root * libm::sin(root * height) * libm::exp(-root * root * time)
    };
    (0..100).map(f64::from).map(term).sum()
}

/// The remaining fraction of the initial difference between a wall and the air on both sides.
///
/// With L half the wall's thickness: `position` is from -1 to 1, in units of L from the centre, the
/// Biot number is h L / k, and `time` is in units of L² / diffusivity.
fn wall(position: f64, biot: f64, time: f64) -> f64 {
    let term = |n: f64| {
        let (mut low, mut high) = (n * PI, (n + 0.5) * PI);
        for _ in 0..60 {
            let root = f64::midpoint(low, high);
            // root · tan(root) = biot, multiplied by cos(root) to remove the poles.
            let side = root * libm::sin(root) - biot * libm::cos(root);
            *(if (side < 0.0) == (libm::cos(n * PI) > 0.0) { &mut low } else { &mut high }) = root;
        }
        let weight = 4.0 * libm::sin(low) / (2.0 * low + libm::sin(2.0 * low));
        weight * libm::cos(low * position) * libm::exp(-low * low * time)
    };
    (0..100).map(f64::from).map(term).sum()
}

/// The remaining fraction of the initial difference between a half-space and the air, at a depth in
/// m, with `loss` = h / k in 1/m and `spread` = diffusivity times time in m².
fn half_space(depth: f64, loss: f64, spread: f64) -> f64 {
    let near = depth / (2.0 * spread.sqrt());
    let beyond =
        libm::exp(loss * depth + loss * loss * spread) * libm::erfc(near + loss * spread.sqrt());
    libm::erf(near) + beyond
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formulas_agree_where_they_must() {
        // Early on, and away from the far side, walls and slabs cool like half-spaces.
        for x in [0.1, 0.4, 0.9] {
            assert!((slab(x, 1e-3) - libm::erf(x / (2.0 * 1e-3f64.sqrt()))).abs() < 1e-9);
            assert!((wall(x, 0.7, 1e-3) - half_space(1.0 - x, 0.7, 1e-3)).abs() < 1e-6, "{x}");
        }
        // A wall with a small Biot number cools as a lumped mass.
        assert!((wall(0.3, 1e-4, 1e4) - libm::exp(-1.0)).abs() < 1e-3);
    }
}
