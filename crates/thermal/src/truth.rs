//! Bodies whose cooling has a formula, to measure how far the solver is from the heat equation
//! itself.
//!
//! Other checks compare one way of stepping with another; these show that voxels of a size stand
//! for a body at all.
//! The errors, at the centres of all voxels, of ABS that starts at 230 °C in air of 25 °C, by
//! [`Method::Reference`] with one step:
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
//! (largest errors, K).
//! They fall with the square of the size, except where a voxel's centre is taken for its surface.
//!
//! Formulas: Carslaw and Jaeger, *Conduction of Heat in Solids*, 2nd edition 1959, sections 2.4,
//! 2.7, 3.4 and 3.11.

use std::f64::consts::PI;
use std::sync::Arc;

use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use ndarray::Array3;

use crate::material::Material;
use crate::process::Process;
use crate::simulation::{Method, SetupError, Simulation};
use crate::timeline::Slot;

/// A body that cools down from one temperature, without radiation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// 2 mm of plastic on a plate of 80 °C, of no end in x and y and with no loss to the air, after
    /// 4 s.
    Slab,
    /// A column on a plate of 80 °C, so tall that its upper end does not matter, after 4 s.
    Deep,
    /// The upper half of a cube of 10 mm in moving air (36 W/(m² K)), after 60 s: as the plane
    /// through its middle lets no heat pass, it is a plate that takes up none.
    Cube {
        /// [`Process::surface_resistance`].
        surface_resistance: bool,
    },
    /// A corner of a large block in moving air, after 4 s.
    Corner {
        /// [`Process::surface_resistance`].
        surface_resistance: bool,
    },
}

/// How far computed temperatures are from the formula's, K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Root of the mean square.
    pub rms: f64,
    /// The largest.
    pub max: f64,
}

const START_C: f64 = 230.0;
const AIR_C: f64 = 25.0;
const PLATE_C: f64 = 80.0;
const CONVECTION_W_M2K: f64 = 36.0;

/// Edge of the cube and of the block that stands for a corner, and how tall slab and column are, m.
const CUBE_M: f64 = 10e-3;
const BLOCK_M: f64 = 8e-3;
const SLAB_M: f64 = 2e-3;

impl Body {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Slab,
        Self::Deep,
        Self::Cube { surface_resistance: false },
        Self::Cube { surface_resistance: true },
        Self::Corner { surface_resistance: false },
        Self::Corner { surface_resistance: true },
    ];

    /// Cools the body down, in voxels of a height in mm and of twice that width, and compares it
    /// with the formula.
    ///
    /// The height should go into 2 mm a whole number of times, and twice the height into 8 mm and
    /// into 10 mm.
    pub fn deviation(self, layer_mm: f64, method: Method) -> Result<Deviation, SetupError> {
        let material = Material { emissivity: 0.0, ..Material::abs() };
        let part = self.part(layer_mm);
        let frame = part.frame;
        // A twentieth of the time in which heat crosses a layer: stable, and exact enough not to
        // matter.
        let step_s = 0.05 * (layer_mm / 1e3).powi(2) / material.diffusivity_m2_s();
        let process = Process { print_mm_s: frame.cell_mm / step_s, ..self.process() };
        let mut simulation = Simulation::new(part.clone(), &material, &process, method)?;
        let layer = |z: usize| {
            part.cells(z).map(move |cell| [cell % frame.width, cell / frame.width, z as u32])
        };
        let voxels: Vec<[u32; 3]> = (0..part.depth).flat_map(layer).collect();
        // All at once, as far as heat can tell.
        let birth = |&voxel: &[u32; 3]| Slot { voxel: Some(voxel), seconds: 1e-9 };
        let births: Vec<Slot> = voxels.iter().map(birth).collect();
        simulation.run(&births).expect("each voxel of the part follows the one below it");
        simulation.pause(self.seconds());

        let sizes_mm = [frame.cell_mm, frame.cell_mm, layer_mm];
        let counts = [frame.width as usize, frame.height as usize, part.depth];
        let left: [Vec<Option<f64>>; 3] = std::array::from_fn(|axis| {
            let centre_m = |i: usize| (i as f64 + 0.5) * sizes_mm[axis] / 1e3;
            (0..counts[axis]).map(|i| self.left(axis, centre_m(i), &material)).collect()
        });
        let cold = if process.plate_c.is_some() { PLATE_C } else { AIR_C };
        let (mut squares, mut max, mut count) = (0.0, 0.0f64, 0.0);
        for voxel in voxels {
            let factors = [0, 1, 2].map(|axis| left[axis][voxel[axis] as usize]);
            let [Some(x), Some(y), Some(z)] = factors else { continue };
            let expected = cold + (START_C - cold) * x * y * z;
            let computed = simulation.temperature_c(voxel).expect("all voxels are deposited");
            squares += (computed - expected).powi(2);
            max = max.max((computed - expected).abs());
            count += 1.0;
        }
        Ok(Deviation { rms: (squares / count).sqrt(), max })
    }

    /// Of voxels twice as wide as high.
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

    fn process(self) -> Process {
        let process = Process { extrusion_c: START_C, ambient_c: AIR_C, ..Process::default() };
        match self {
            Self::Slab | Self::Deep => {
                Process { plate_c: Some(PLATE_C), convection_w_m2k: 0.0, ..process }
            }
            Self::Cube { surface_resistance } | Self::Corner { surface_resistance } => Process {
                plate_c: None,
                convection_w_m2k: CONVECTION_W_M2K,
                surface_resistance,
                ..process
            },
        }
    }

    fn seconds(self) -> f64 {
        if matches!(self, Self::Cube { .. }) { 60.0 } else { 4.0 }
    }

    /// What the flow along one axis has left of the difference from plate or air, at a place in m;
    /// `None` where the formula does not hold.
    /// All axes together leave the product.
    fn left(self, axis: usize, at: f64, material: &Material) -> Option<f64> {
        let spread = material.diffusivity_m2_s() * self.seconds();
        let loss = CONVECTION_W_M2K / material.conductivity_w_mk;
        let upright = axis == 2;
        match self {
            Self::Slab | Self::Deep if !upright => Some(1.0),
            Self::Slab => Some(slab(at / SLAB_M, spread / SLAB_M.powi(2))),
            Self::Deep => Some(libm::erf(at / (2.0 * spread.sqrt()))),
            Self::Cube { .. } => {
                let half = CUBE_M / 2.0;
                let from_middle = if upright { at } else { at - half };
                Some(wall(from_middle / half, loss * half, spread / half.powi(2)))
            }
            Self::Corner { .. } => {
                let depth = if upright { BLOCK_M - at } else { at };
                // The other half of the block is cooled by other sides.
                (depth < BLOCK_M / 2.0).then(|| under_air(depth, loss, spread))
            }
        }
    }
}

/// What is left of the difference between a slab and the plate it lies on, where no heat leaves at
/// the top; at a height of 0 to 1, after a time in units of height² / diffusivity.
fn slab(height: f64, time: f64) -> f64 {
    let term = |n: f64| {
        let root = (n + 0.5) * PI;
        2.0 / root * libm::sin(root * height) * libm::exp(-root * root * time)
    };
    (0..100).map(f64::from).map(term).sum()
}

/// What is left of the difference between a wall and the air on both of its sides; at -1 to 1 from
/// its middle, given h L / k, L being half the wall's thickness, and the time in units of L² /
/// diffusivity.
fn wall(place: f64, biot: f64, time: f64) -> f64 {
    let term = |n: f64| {
        let (mut low, mut high) = (n * PI, (n + 0.5) * PI);
        for _ in 0..60 {
            let root = f64::midpoint(low, high);
            // The equation root · tan(root) = biot without its poles.
            let side = root * libm::sin(root) - biot * libm::cos(root);
            *(if (side < 0.0) == (libm::cos(n * PI) > 0.0) { &mut low } else { &mut high }) = root;
        }
        let weight = 4.0 * libm::sin(low) / (2.0 * low + libm::sin(2.0 * low));
        weight * libm::cos(low * place) * libm::exp(-low * low * time)
    };
    (0..100).map(f64::from).map(term).sum()
}

/// What is left of the difference between a half-space and the air, at a depth in m, given h / k in
/// 1/m and diffusivity times time in m².
fn under_air(depth: f64, loss: f64, spread: f64) -> f64 {
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
        // At first nothing has changed; short of the middle, a wall and a slab are half-spaces.
        for place in [0.1, 0.4, 0.9] {
            assert!((slab(place, 1e-3) - libm::erf(place / (2.0 * 1e-3f64.sqrt()))).abs() < 1e-9);
            assert!(
                (wall(place, 0.7, 1e-3) - under_air(1.0 - place, 0.7, 1e-3)).abs() < 1e-6,
                "{place}"
            );
        }
        // A wall that conducts well cools down as one lump.
        assert!((wall(0.3, 1e-4, 1e4) - libm::exp(-1.0)).abs() < 1e-3);
    }
}
