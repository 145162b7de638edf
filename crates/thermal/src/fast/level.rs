//! How long steps are, and how far from the nozzle.

use crate::coefficients::Coefficients;

use super::chebyshev::Polynomial;

/// How exact the fast stepper is.
///
/// Both are checked against a second-order stepper with four steps a birth, on the paper's three
/// kinds of parts and a block; `docs/results/thermal.md` has the errors.
/// They were tuned on the rectangular part and the block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accuracy {
    /// More exact than the plain scheme, in a fraction of its time.
    #[default]
    Standard,
    /// Errors several times smaller.
    High,
}

/// A length of steps, and where the next shorter steps take over.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) step: StepMethod,
    /// The longest step, s.
    pub(super) seconds: f64,
    /// Shorter steps are taken wherever a voxel was born within this time before the step, s, or
    /// will be in it, ...
    pub(super) age_s: f64,
    /// ... and so many voxels around, in x and y, and in z: at least two around steps on blocks, so
    /// that births change no voxel at the border.
    pub(super) margins: [usize; 2],
}

impl Level {
    /// The age up to which births count in a pause: at least two of the longest steps.
    ///
    /// In a print, new births keep a window around those before them.
    /// In a pause nothing does, and a long step would leave up to the whole of the sharpest
    /// differences standing.
    pub(super) fn pause_age_s(&self) -> f64 {
        self.age_s.max(2.0 * self.seconds)
    }
}

/// How a step is taken.
#[derive(Clone, Debug)]
pub(super) enum StepMethod {
    /// On the voxels, in stages.
    Voxels(Polynomial),
    /// On blocks of voxels.
    Blocks,
}

/// What a step on blocks costs: in sweeps of the voxels.
const BLOCK_STAGES: f64 = 1.0;

impl Level {
    /// What a step costs: sweeps of the voxels.
    pub(super) fn stages(&self) -> f64 {
        match &self.step {
            StepMethod::Voxels(polynomial) => polynomial.stages() as f64,
            StepMethod::Blocks => BLOCK_STAGES,
        }
    }

    /// The same for each second of the longest steps.
    pub(super) fn stages_per_second(&self) -> f64 {
        self.stages() / self.seconds
    }
}

/// A level in units of what it stands on.
#[derive(Clone, Copy)]
struct LevelSpec {
    /// Longest step, times the fastest rate of the voxels.
    length: f64,
    /// What it is taken as.
    kind: StepKind,
    /// Age, in longest steps.
    age: f64,
    /// Margins, in lengths by which heat spreads within a longest step.
    spreads: f64,
}

/// What steps are taken as.
#[derive(Clone, Copy)]
enum StepKind {
    /// A polynomial of as few stages as make the length stable.
    Voxels,
    /// The fitted polynomial.
    Fitted,
    /// A step on blocks.
    Blocks,
}

const fn level(kind: StepKind, length: f64, age: f64, spreads: f64) -> LevelSpec {
    LevelSpec { length, kind, age, spreads }
}

/// The shortest steps first.
/// A birth of the paper's ABS lasts 0.38 in these units: so these are steps of one, 5, 22, 188 and
/// 564 births.
const STANDARD: [LevelSpec; 5] = [
    level(StepKind::Voxels, 0.4, 0.0, 0.0),
    level(StepKind::Voxels, 1.93, 1.5, 2.0),
    level(StepKind::Voxels, 8.5, 1.0, 1.5),
    level(StepKind::Fitted, 71.4, 0.25, 2.5),
    level(StepKind::Blocks, 214.4, 2.0, 2.0),
];
/// One, 4, 22, 125 and 1,000 births.
const HIGH: [LevelSpec; 5] = [
    level(StepKind::Voxels, 0.4, 0.0, 0.0),
    level(StepKind::Voxels, 1.54, 3.0, 2.5),
    level(StepKind::Voxels, 8.5, 2.0, 2.5),
    level(StepKind::Voxels, 47.8, 1.5, 3.0),
    level(StepKind::Blocks, 381.0, 1.5, 3.0),
];

/// The levels of an accuracy, the shortest steps first.
pub(super) fn levels(accuracy: Accuracy, coefficients: &Coefficients) -> Vec<Level> {
    let specs = match accuracy {
        Accuracy::Standard => STANDARD,
        Accuracy::High => HIGH,
    };
    specs.into_iter().map(|spec| spec.level(coefficients)).collect()
}

impl LevelSpec {
    fn level(self, coefficients: &Coefficients) -> Level {
        let seconds = self.length / coefficients.max_rate;
        let step = match self.kind {
            StepKind::Voxels => StepMethod::Voxels(Polynomial::reaching(self.length)),
            StepKind::Fitted => StepMethod::Voxels(Polynomial::fitted()),
            StepKind::Blocks => StepMethod::Blocks,
        };
        let least = if matches!(self.kind, StepKind::Blocks) { 2 } else { 0 };
        let margin = |rate: f32| {
            let spread = (2.0 * f64::from(rate) * seconds).sqrt();
            ((self.spreads * spread).ceil() as usize).max(least)
        };
        let margins = [margin(coefficients.lateral), margin(coefficients.vertical)];
        Level { step, seconds, age_s: self.age * seconds, margins }
    }
}
