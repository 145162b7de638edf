//! The state of a print: how it is set up, and the temperatures of single voxels.

use std::sync::Arc;

use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use thiserror::Error;

use crate::coefficients::Coefficients;
use crate::explicit::{ExplicitStepper, Scheme};
use crate::fast::FastStepper;
use crate::material::ThermalMaterial;
use crate::method::Method;
use crate::patch::Patch;
use crate::process::ProcessParameters;
use crate::property::PropertyError;
use crate::shape::Shape;
use crate::state::State;

/// Why a simulation cannot be set up.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SetupError {
    /// A property of the material or the process is out of its range.
    #[error(transparent)]
    Property(#[from] PropertyError),
    /// The voxels' width or height is not a positive number.
    #[error("voxels are {cell_mm} mm wide and {layer_mm} mm high: both must be more than 0")]
    Size {
        /// Width, mm.
        cell_mm: f64,
        /// Height, mm.
        layer_mm: f64,
    },
    /// [`Method::Naive`] takes one step per voxel, and at this speed that step is not stable.
    #[error(
        "depositing a voxel takes {seconds} s, longer than the maximum stable step of {limit} s: \
         print faster or choose another method"
    )]
    Unstable {
        /// Duration of a deposition, s.
        seconds: f64,
        /// The maximum stable step, s.
        limit: f64,
    },
    /// [`Method::Reference`] with 0 steps.
    #[error("the reference method takes 0 steps per voxel: it needs at least 1")]
    NoSteps,
}

/// What advances the temperatures.
#[derive(Clone, Debug)]
pub(super) enum Stepper {
    Explicit(Box<ExplicitStepper>),
    Fast(Box<FastStepper>),
}

/// A part during its print: which voxels are deposited, and their temperatures.
///
/// A clone shares all temperatures with the original until one of the two goes on, so it is cheap
/// to try many orders of a layer from one state.
/// The crate's page has an example.
#[derive(Clone, Debug)]
pub struct Simulation {
    pub(super) part: Arc<Voxels>,
    pub(super) process: Arc<ProcessParameters>,
    pub(super) coefficients: Arc<Coefficients>,
    pub(super) state: State,
    pub(super) stepper: Stepper,
    /// Time since the start, s.
    pub(super) seconds: f64,
    pub(super) max_stable_step_s: f64,
    /// Heat that raises the temperature of a voxel by one kelvin, J/K.
    voxel_j_k: f64,
    /// The last voxel that was deposited.
    pub(super) last: Option<[u32; 3]>,
}

impl Simulation {
    /// A simulation of a part of which nothing is deposited yet.
    ///
    /// All voxels have the properties of the one material, whatever their material number.
    /// The memory is about 20 bytes per voxel of the part's bounding box.
    pub fn new(
        part: Arc<Voxels>,
        material: &ThermalMaterial,
        process: &ProcessParameters,
        method: Method,
    ) -> Result<Self, SetupError> {
        material.check()?;
        process.check()?;
        let frame = &part.frame;
        let (cell_mm, layer_mm) = (frame.cell_mm, frame.layer_mm);
        if !(cell_mm > 0.0 && layer_mm > 0.0 && cell_mm.is_finite() && layer_mm.is_finite()) {
            return Err(SetupError::Size { cell_mm, layer_mm });
        }
        let coefficients = Coefficients::new(material, process, cell_mm / 1e3, layer_mm / 1e3);
        let birth_s = cell_mm / process.print_mm_s;
        let max_stable_step_s = 2.0 / coefficients.max_rate;
        let stepper = match method {
            Method::Naive if birth_s > max_stable_step_s => {
                return Err(SetupError::Unstable { seconds: birth_s, limit: max_stable_step_s });
            }
            Method::Naive => {
                Stepper::Explicit(Box::new(ExplicitStepper::new(Scheme::Euler, birth_s)))
            }
            Method::Reference { steps: 0 } => return Err(SetupError::NoSteps),
            Method::Reference { steps } => {
                let max_s = birth_s.min(max_stable_step_s);
                let scheme = Scheme::Heun { steps };
                Stepper::Explicit(Box::new(ExplicitStepper::new(scheme, max_s)))
            }
            Method::Fast(accuracy) => {
                Stepper::Fast(Box::new(FastStepper::new(accuracy, &coefficients)))
            }
        };
        let shape = Shape::with_halo(frame.width as usize, frame.height as usize, part.depth);
        let state = State::unprinted(shape, &coefficients);
        let voxel_j_k = material.heat_capacity_j_m3k() * frame.cell_mm3() / 1e9;
        let (process, coefficients) = (Arc::new(process.clone()), Arc::new(coefficients));
        Ok(Self {
            part,
            process,
            coefficients,
            state,
            stepper,
            seconds: 0.0,
            max_stable_step_s,
            voxel_j_k,
            last: None,
        })
    }

    /// The part.
    pub fn part(&self) -> &Voxels {
        &self.part
    }

    /// The parameters of its print.
    pub fn process(&self) -> &ProcessParameters {
        &self.process
    }

    /// Simulated time since the start of the print, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The longest step for which forward Euler is certainly stable, s: 2 divided by Gershgorin's
    /// bound on the decay rates of the heat equation.
    pub fn max_stable_step_s(&self) -> f64 {
        self.max_stable_step_s
    }

    /// Temperature of the voxel at x, y and z, °C; `None` if it is not deposited.
    pub fn temperature_c(&self, voxel: [u32; 3]) -> Option<f64> {
        let [x, y, z] = voxel;
        self.part.material(x, y, z as usize)?;
        let index = self.state.patch.shape.index(with_halo(voxel));
        let active = self.state.occupancy.is_active(index);
        active.then(|| f64::from(self.state.patch.theta[index]) + self.coefficients.ambient_c)
    }

    /// Temperature of the voxel below the one at x, y and z at the moment when that one was
    /// deposited on it, °C: the strength of the weld between the two depends on it.
    ///
    /// `None` if the voxel is not deposited, or lies on the plate or on air.
    pub fn substrate_temperature_c(&self, voxel: [u32; 3]) -> Option<f64> {
        self.temperature_c(voxel)?;
        let index = self.state.patch.shape.index(with_halo(voxel));
        let theta = self.state.occupancy.substrate_theta(index);
        (!theta.is_nan()).then(|| f64::from(theta) + self.coefficients.ambient_c)
    }

    /// The deposited cells of a layer in ascending order, each with its temperature, °C.
    pub fn cell_temperatures_c(&self, layer: u32) -> impl Iterator<Item = (Cell, f64)> {
        let width = self.part.frame.width;
        self.cells(layer).filter_map(move |cell| {
            Some((cell, self.temperature_c([cell % width, cell / width, layer])?))
        })
    }

    /// Heat in all deposited voxels, J, relative to the ambient temperature: the heat they would
    /// give off if they cooled down to it.
    ///
    /// Linear in the voxels of the part's bounding box.
    pub fn stored_heat_j(&self) -> f64 {
        let Patch { shape, theta, .. } = &*self.state.patch;
        let width = self.part.frame.width;
        // Voxels that are not deposited hold 0.
        let layer = |z: usize| -> f64 {
            let position = |cell| with_halo([cell % width, cell / width, z as u32]);
            self.part.cells(z).map(|cell| f64::from(theta[shape.index(position(cell))])).sum()
        };
        (0..self.part.depth).map(layer).sum::<f64>() * self.voxel_j_k
    }

    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// The cells of a layer; none if the part has no such layer.
    pub(super) fn cells(&self, layer: u32) -> impl Iterator<Item = Cell> {
        let layer = Some(layer as usize).filter(|&layer| layer < self.part.depth);
        layer.into_iter().flat_map(|layer| self.part.cells(layer))
    }
}

/// The position of a voxel in a patch, whose halo takes up the first index of each axis.
pub(super) fn with_halo(voxel: [u32; 3]) -> [usize; 3] {
    voxel.map(|i| i as usize + 1)
}
