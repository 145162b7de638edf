//! The levels of time steps: how long steps are, and where shorter ones take over.
//!
//! All lengths are relative to the material and the voxels.
//! Times are in units of 1 / λ, where λ is the fastest decay rate ([`Coefficients::max_rate`]): a
//! forward Euler step is stable up to 2 of these units.
//! Distances are in units of √(2 D t), the standard deviation by which heat spreads in a time t (D
//! is the diffusivity).
//! So one table of numbers serves all materials, voxel sizes and speeds.

use crate::coefficients::Coefficients;

use super::chebyshev::Polynomial;

/// Accuracy of the fast method.
///
/// [`Accuracy::Standard`] and [`Accuracy::High`] are checked against a second-order method with
/// four steps per voxel, on the paper's three kinds of parts and a block; `docs/results/thermal.md`
/// lists the errors.
/// They were tuned on the rectangular part and the block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accuracy {
    /// To compare many orders, in a third to a half of the time of [`Accuracy::Standard`].
    ///
    /// Accurate only at the end of each call, such as
    /// [`Simulation::deposit`](crate::Simulation::deposit).
    /// The last 10 s of the call (with the paper's ABS and voxels) are simulated with standard
    /// accuracy, and the time before in steps of about 100 births.
    /// The errors of these steps have spread and decayed by the end, except for a small error of
    /// the total heat: where a part loses hardly any heat, all temperatures may be off by several
    /// K. Substrate temperatures ([`crate::interlayer`]) are rough before these last seconds.
    /// Sampling divides a print into many calls, so it is accurate but takes as long as with
    /// standard accuracy.
    Draft,
    /// More accurate than the naive method, in a fraction of its time.
    #[default]
    Standard,
    /// Errors several times smaller, for about 1.3 times the time.
    High,
}

/// A level: the length of its steps, and where steps of the next lower level are needed.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) method: StepMethod,
    /// Length of the longest step, s.
    pub(super) seconds: f64,
    /// Age up to which births count as recent, s: shorter steps are needed around all voxels that
    /// were born within this time before the step, or are born in it.
    pub(super) age_s: f64,
    /// Margins of the box around these voxels in which shorter steps are taken, in voxels: in x and
    /// y, and in z.
    /// At least two for steps on blocks, so that births do not change the voxels at the border.
    pub(super) margins: [usize; 2],
    /// At the lowest level: maximum length of a birth that shares its step with others, s; 0 if
    /// each birth has steps of its own.
    pub(super) shared_birth_s: f64,
}

/// How a step is computed.
#[derive(Clone, Debug)]
pub(super) enum StepMethod {
    /// On voxels, by a stability polynomial.
    Voxels(Polynomial),
    /// On blocks of voxels.
    Blocks,
}

/// Cost of a step on blocks, in sweeps over the voxels.
const BLOCK_STAGES: f64 = 1.0;

impl Level {
    /// Age up to which births count as recent in a pause, s: at least two of the longest steps.
    ///
    /// While voxels are deposited, the window of each new birth also covers those shortly before
    /// it, so a short age suffices.
    /// In a pause there are no new births, and the first long step would meet steep temperature
    /// differences, which it hardly damps.
    pub(super) fn pause_age_s(&self) -> f64 {
        self.age_s.max(2.0 * self.seconds)
    }

    /// Cost of a step, in sweeps over the voxels.
    pub(super) fn stages(&self) -> f64 {
        match &self.method {
            StepMethod::Voxels(polynomial) => polynomial.stages() as f64,
            StepMethod::Blocks => BLOCK_STAGES,
        }
    }

    /// Cost of simulating one second in steps of full length, in sweeps over the voxels.
    pub(super) fn stages_per_second(&self) -> f64 {
        self.stages() / self.seconds
    }
}

/// A level in relative units.
#[derive(Clone, Copy)]
struct LevelSpec {
    kind: StepKind,
    /// Length of the longest step times the fastest decay rate.
    length: f64,
    /// [`Level::age_s`] in longest steps.
    age: f64,
    /// [`Level::margins`] in standard deviations of the spread of heat within a longest step.
    spreads: f64,
}

/// How the steps of a [`LevelSpec`] are computed.
#[derive(Clone, Copy)]
enum StepKind {
    /// The shifted Chebyshev polynomial of the lowest degree that is stable.
    Chebyshev,
    /// The fitted polynomial.
    Fitted,
    /// On blocks.
    Blocks,
}

const fn spec(kind: StepKind, length: f64, age: f64, spreads: f64) -> LevelSpec {
    LevelSpec { kind, length, age, spreads }
}

/// Levels of [`Accuracy::Standard`], shortest steps first.
///
/// The birth of a voxel of the paper's ABS lasts 0.38 units, so these are steps of 1, 5, 22, 188
/// and 564 births.
const STANDARD: [LevelSpec; 5] = [
    spec(StepKind::Chebyshev, 0.4, 0.0, 0.0),
    spec(StepKind::Chebyshev, 1.93, 1.5, 2.0),
    spec(StepKind::Chebyshev, 8.5, 1.0, 1.5),
    spec(StepKind::Fitted, 71.4, 0.25, 2.5),
    spec(StepKind::Blocks, 214.4, 2.0, 2.0),
];

/// Levels of [`Accuracy::High`]: steps of 1, 4, 22, 125 and 1,000 births, and larger windows.
const HIGH: [LevelSpec; 5] = [
    spec(StepKind::Chebyshev, 0.4, 0.0, 0.0),
    spec(StepKind::Chebyshev, 1.54, 3.0, 2.5),
    spec(StepKind::Chebyshev, 8.5, 2.0, 2.5),
    spec(StepKind::Chebyshev, 47.8, 1.5, 3.0),
    spec(StepKind::Blocks, 381.0, 1.5, 3.0),
];

/// Levels of the early part of a call with [`Accuracy::Draft`]: steps of 105, 188 and 564 births.
/// In the shortest ones, births happen together.
const EARLY: [LevelSpec; 3] = [
    spec(StepKind::Chebyshev, 40.0, 0.0, 0.0),
    spec(StepKind::Fitted, 71.4, 0.25, 1.5),
    spec(StepKind::Blocks, 214.4, 2.0, 2.0),
];

/// Length of the late part of a call with [`Accuracy::Draft`], times the fastest decay rate.
///
/// With half as much, the order of orders by their standard deviation changes; with twice as much,
/// it is hardly nearer to that of [`Accuracy::High`].
const LATE: f64 = 228.0;

/// Maximum length of a birth that shares its step, times the fastest decay rate.
const SHARED_BIRTH: f64 = 1.0;

/// The levels of an accuracy, shortest steps first.
pub(super) fn levels(accuracy: Accuracy, coefficients: &Coefficients) -> Vec<Level> {
    let specs = match accuracy {
        Accuracy::Standard | Accuracy::Draft => STANDARD,
        Accuracy::High => HIGH,
    };
    specs.into_iter().map(|spec| spec.level(coefficients)).collect()
}

/// Coarser levels for the early part of a call, and the length of its late part, s; `None` if all
/// parts have the same levels.
pub(super) fn early_levels(
    accuracy: Accuracy,
    coefficients: &Coefficients,
) -> Option<(Vec<Level>, f64)> {
    if accuracy != Accuracy::Draft {
        return None;
    }
    let mut levels: Vec<_> = EARLY.into_iter().map(|spec| spec.level(coefficients)).collect();
    levels[0].shared_birth_s = SHARED_BIRTH / coefficients.max_rate;
    Some((levels, LATE / coefficients.max_rate))
}

impl LevelSpec {
    fn level(self, coefficients: &Coefficients) -> Level {
        let seconds = self.length / coefficients.max_rate;
        let method = match self.kind {
            StepKind::Chebyshev => StepMethod::Voxels(Polynomial::for_stability(self.length)),
            StepKind::Fitted => StepMethod::Voxels(Polynomial::fitted()),
            StepKind::Blocks => StepMethod::Blocks,
        };
        let min_margin = if matches!(self.kind, StepKind::Blocks) { 2 } else { 0 };
        // The conductance is D / length², so this is √(2 D t) in voxels.
        let margin = |conductance: f32| {
            let spread = (2.0 * f64::from(conductance) * seconds).sqrt();
            ((self.spreads * spread).ceil() as usize).max(min_margin)
        };
        let margins = [margin(coefficients.lateral), margin(coefficients.vertical)];
        Level { method, seconds, age_s: self.age * seconds, margins, shared_birth_s: 0.0 }
    }
}
