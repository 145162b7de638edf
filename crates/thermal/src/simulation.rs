//! A print as it goes on: what is deposited, and how warm it is.

use std::sync::Arc;

use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use rayon::ThreadPool;
use thiserror::Error;

use crate::coefficients::Coefficients;
use crate::explicit::{ExplicitStepper, Scheme};
use crate::fast::{Accuracy, FastStepper};
use crate::interval::Interval;
use crate::material::Material;
use crate::patch::{Patch, Shape};
use crate::process::Process;
use crate::property::PropertyError;
use crate::state::State;
use crate::timeline::{Slot, layer_slots};

/// How the heat equation is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// One explicit step of the whole part for each birth: the scheme of the paper, and the
    /// definition that the others are faster or better ways to follow.
    /// A slot must not be longer than [`Simulation::stable_seconds`].
    ///
    /// Each birth costs a sweep of all that is printed, so a part costs its square.
    Naive,
    /// Heun's method with so many steps of the whole part for each birth: second order, to measure
    /// errors by.
    /// Twice as many sweeps as steps.
    Reference {
        /// Steps for each birth, at least 1. Slots that are longer than a birth at the process's
        /// speed, or than [`Simulation::stable_seconds`], are cut into equal stretches that are
        /// not, of so many steps each.
        steps: u32,
    },
    /// Long steps far from the nozzle, short ones near it.
    Fast(Accuracy),
}

impl Default for Method {
    fn default() -> Self {
        Self::Fast(Accuracy::Standard)
    }
}

/// Why a part can't be simulated.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SetupError {
    /// A property makes no sense.
    #[error(transparent)]
    Property(#[from] PropertyError),
    /// Cells or layers have no size.
    #[error("voxels are {cell_mm} mm wide and {layer_mm} mm high: both must be more than 0")]
    Size {
        /// Width, mm.
        cell_mm: f64,
        /// Height, mm.
        layer_mm: f64,
    },
    /// A birth takes too long for one explicit step.
    #[error(
        "a birth of {seconds} s is longer than the longest stable step of {limit} s: choose another method or speed"
    )]
    Unstable {
        /// How long it takes, s.
        seconds: f64,
        /// The longest stable step, s.
        limit: f64,
    },
    /// No steps.
    #[error("the reference method needs at least 1 step for a birth")]
    NoSteps,
}

/// Why something can't be deposited.
/// Nothing is changed by what is refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum DepositError {
    /// The part has no such voxel.
    #[error("voxel {voxel:?} is not part of the print")]
    Outside {
        /// x, y and z.
        voxel: [u32; 3],
    },
    /// The voxel is there already.
    #[error("voxel {voxel:?} is deposited twice")]
    Repeated {
        /// x, y and z.
        voxel: [u32; 3],
    },
    /// An order of a layer leaves a voxel out.
    #[error("voxel {voxel:?} is missing from the order of its layer")]
    Missing {
        /// x, y and z.
        voxel: [u32; 3],
    },
    /// What lies below the voxel, as part of the print, is not there yet.
    #[error("voxel {voxel:?} has nothing to lie on: the one below is not deposited yet")]
    Unsupported {
        /// x, y and z.
        voxel: [u32; 3],
    },
    /// A slot has no length that time can have.
    #[error("slot {slot} lasts {seconds} s: it must be at least 0, and more with a voxel")]
    Duration {
        /// Which, from 0.
        slot: usize,
        /// How long it lasts, s.
        seconds: f64,
    },
    /// A birth takes too long for one explicit step.
    #[error(
        "the birth of voxel {voxel:?} takes {seconds} s, longer than the longest stable step of {limit} s"
    )]
    Unstable {
        /// x, y and z.
        voxel: [u32; 3],
        /// How long it takes, s.
        seconds: f64,
        /// The longest stable step, s.
        limit: f64,
    },
}

#[derive(Clone, Debug)]
enum Stepper {
    Explicit(Box<ExplicitStepper>),
    Fast(Box<FastStepper>),
}

/// A part in the middle of its print.
///
/// Clones are cheap: they share all temperatures until one of them goes on, so that many orders of
/// a layer can be tried from one state.
/// See the crate's page for an example.
#[derive(Clone, Debug)]
pub struct Simulation {
    part: Arc<Voxels>,
    process: Arc<Process>,
    coefficients: Arc<Coefficients>,
    state: State,
    stepper: Stepper,
    seconds: f64,
    stable_s: f64,
    /// Heat that warms a voxel by one kelvin, J/K.
    voxel_j_k: f64,
    /// The last voxel deposited.
    last: Option<[u32; 3]>,
    /// Threads that share long steps.
    pool: Option<Arc<ThreadPool>>,
}

impl Simulation {
    /// A part before anything is deposited.
    ///
    /// All voxels have the properties of the one material, whatever their own number says.
    /// Memory is some 20 bytes for each voxel of the box around the part.
    pub fn new(
        part: Arc<Voxels>,
        material: &Material,
        process: &Process,
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
        let stable_s = 2.0 / coefficients.max_rate;
        let stepper = match method {
            Method::Naive if birth_s > stable_s => {
                return Err(SetupError::Unstable { seconds: birth_s, limit: stable_s });
            }
            Method::Naive => {
                Stepper::Explicit(Box::new(ExplicitStepper::new(Scheme::Euler, birth_s)))
            }
            Method::Reference { steps: 0 } => return Err(SetupError::NoSteps),
            Method::Reference { steps } => {
                let scheme = Scheme::Heun { steps };
                Stepper::Explicit(Box::new(ExplicitStepper::new(scheme, birth_s.min(stable_s))))
            }
            Method::Fast(accuracy) => {
                Stepper::Fast(Box::new(FastStepper::new(accuracy, &coefficients)))
            }
        };
        let shape = Shape::around(frame.width as usize, frame.height as usize, part.depth);
        let state = State::empty(shape, &coefficients);
        let voxel_j_k = material.heat_capacity_j_m3k() * frame.cell_mm3() / 1e9;
        let (process, coefficients) = (Arc::new(process.clone()), Arc::new(coefficients));
        Ok(Self {
            part,
            process,
            coefficients,
            state,
            stepper,
            seconds: 0.0,
            stable_s,
            voxel_j_k,
            last: None,
            pool: None,
        })
    }

    /// The same, with its long steps shared out among some threads where the part is large.
    /// The results are the same bit for bit.
    ///
    /// The reference gains where a layer has some hundred thousand voxels.
    /// The fast stepper gains little: it leaves few sweeps that are worth a second thread.
    /// To try many orders, or to simulate many parts, one thread for each pays more.
    pub fn with_pool(self, pool: Option<Arc<ThreadPool>>) -> Self {
        Self { pool, ..self }
    }

    /// The part.
    pub fn part(&self) -> &Voxels {
        &self.part
    }

    /// How it is printed.
    pub fn process(&self) -> &Process {
        &self.process
    }

    /// Time since the start, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The longest step for which the explicit scheme is stable, s: two over the fastest rate at
    /// which any difference of temperatures can die out (Gershgorin's bound).
    pub fn stable_seconds(&self) -> f64 {
        self.stable_s
    }

    /// Deposits all cells of a layer in the given order, at the process's speed, with travel
    /// between cells that are not neighbours; tells how long that took, s.
    pub fn deposit(&mut self, layer: u32, order: &[Cell]) -> Result<f64, DepositError> {
        let width = self.part.frame.width;
        let slots = self.slots(layer, order);
        let before = self.seconds;
        let intervals = self.check(&slots)?;
        let mut ordered = vec![false; (width * self.part.frame.height) as usize];
        order.iter().for_each(|&cell| ordered[cell as usize] = true);
        if let Some(cell) = self.cells(layer).find(|&cell| !ordered[cell as usize]) {
            return Err(DepositError::Missing { voxel: [cell % width, cell / width, layer] });
        }
        self.step(&slots, &intervals);
        Ok(self.seconds - before)
    }

    /// The slots that [`Simulation::deposit`] would run through now: travel starts where the last
    /// voxel was laid.
    pub fn slots(&self, layer: u32, order: &[Cell]) -> Vec<Slot> {
        let from = self.last.map(|[x, y, _]| y * self.part.frame.width + x);
        layer_slots(order, layer, from, &self.part.frame, &self.process)
    }

    /// Runs through slots: births of any voxels at any times, and pauses.
    pub fn run(&mut self, slots: &[Slot]) -> Result<(), DepositError> {
        let intervals = self.check(slots)?;
        self.step(slots, &intervals);
        Ok(())
    }

    /// Lets time pass, s.
    ///
    /// # Panics
    /// If the time is negative or no number.
    pub fn pause(&mut self, seconds: f64) {
        self.run(&[Slot::pause(seconds)]).expect("a pause takes no less than no time");
    }

    /// Temperature of a voxel, °C; `None` if it is not deposited.
    pub fn temperature_c(&self, voxel: [u32; 3]) -> Option<f64> {
        let [x, y, z] = voxel;
        self.part.material(x, y, z as usize)?;
        let index = self.state.patch.shape.index(with_halo(voxel));
        let active = self.state.occupancy.is_active(index);
        active.then(|| f64::from(self.state.patch.theta[index]) + self.coefficients.ambient_c)
    }

    /// Temperature of the voxel below just before this one was laid on it, °C: what the bond
    /// between them depends on.
    /// `None` if this one is not deposited, or was laid on the plate or on nothing.
    pub fn landing_c(&self, voxel: [u32; 3]) -> Option<f64> {
        self.temperature_c(voxel)?;
        let landing =
            self.state.occupancy.substrate_theta(self.state.patch.shape.index(with_halo(voxel)));
        (!landing.is_nan()).then(|| f64::from(landing) + self.coefficients.ambient_c)
    }

    /// The voxels of a layer that are deposited, in the order of their cells, and their
    /// temperatures, °C.
    pub fn layer_c(&self, layer: u32) -> impl Iterator<Item = (Cell, f64)> {
        let width = self.part.frame.width;
        self.cells(layer).filter_map(move |cell| {
            Some((cell, self.temperature_c([cell % width, cell / width, layer])?))
        })
    }

    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// Heat in all deposited voxels, J, relative to the air's temperature: what would be lost if
    /// all of them cooled down to it.
    /// Linear in the voxels of the box around the part.
    pub fn stored_j(&self) -> f64 {
        let Patch { shape, theta, .. } = &*self.state.patch;
        let width = self.part.frame.width;
        // What is not deposited is as warm as the air.
        let layer = |z: usize| -> f64 {
            let place = |cell| with_halo([cell % width, cell / width, z as u32]);
            self.part.cells(z).map(|cell| f64::from(theta[shape.index(place(cell))])).sum()
        };
        (0..self.part.depth).map(layer).sum::<f64>() * self.voxel_j_k
    }

    /// The cells of a layer: none if there is no such layer.
    fn cells(&self, layer: u32) -> impl Iterator<Item = Cell> {
        let layer = Some(layer as usize).filter(|&layer| layer < self.part.depth);
        layer.into_iter().flat_map(|layer| self.part.cells(layer))
    }

    /// Runs through slots that have been checked.
    pub(crate) fn step(&mut self, slots: &[Slot], intervals: &[Interval]) {
        let Self { state, stepper, coefficients, pool, .. } = self;
        let mut run = |threads| {
            let state = state.make_mut();
            match stepper {
                Stepper::Explicit(explicit) => {
                    explicit.run(state, coefficients, intervals, threads)
                }
                Stepper::Fast(fast) => fast.run(state, coefficients, intervals, threads),
            }
        };
        match pool {
            Some(pool) => pool.install(|| run(pool.current_num_threads())),
            None => run(1),
        }
        self.seconds += slots.iter().map(|slot| slot.seconds).sum::<f64>();
        self.last = slots.iter().rev().find_map(|slot| slot.voxel).or(self.last);
    }

    /// The slots as the steppers take them, without those of no length, if all is well with them.
    pub(crate) fn check(&self, slots: &[Slot]) -> Result<Vec<Interval>, DepositError> {
        let explicit = matches!(&self.stepper, Stepper::Explicit(explicit) if explicit.scheme == Scheme::Euler);
        let shape = self.state.patch.shape;
        let mut fresh = vec![false; shape.len()];
        let mut intervals = Vec::with_capacity(slots.len());
        for (number, &Slot { voxel, seconds }) in slots.iter().enumerate() {
            let held = voxel.is_some();
            if !(seconds.is_finite() && (seconds > 0.0 || (!held && seconds == 0.0))) {
                return Err(DepositError::Duration { slot: number, seconds });
            }
            if let Some(voxel) = voxel {
                let [x, y, z] = voxel;
                if self.part.material(x, y, z as usize).is_none() {
                    return Err(DepositError::Outside { voxel });
                }
                let index = shape.index(with_halo(voxel));
                if self.state.occupancy.is_active(index) || fresh[index] {
                    return Err(DepositError::Repeated { voxel });
                }
                if z > 0 && self.part.material(x, y, z as usize - 1).is_some() {
                    let below = shape.index(with_halo([x, y, z - 1]));
                    if !self.state.occupancy.is_active(below) && !fresh[below] {
                        return Err(DepositError::Unsupported { voxel });
                    }
                }
                if explicit && seconds > self.stable_s {
                    return Err(DepositError::Unstable { voxel, seconds, limit: self.stable_s });
                }
                fresh[index] = true;
            }
            if seconds > 0.0 {
                intervals.push(Interval { held: voxel.map(with_halo), born: held, seconds });
            }
        }
        Ok(intervals)
    }
}

/// The same place in a patch, where the first of each axis is halo.
fn with_halo(voxel: [u32; 3]) -> [usize; 3] {
    voxel.map(|i| i as usize + 1)
}
