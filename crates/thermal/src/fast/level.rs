//! How long steps are, and how far from the nozzle.

use crate::law::Law;

use super::chebyshev::Polynomial;

/// How exact the fast stepper is.
///
/// Both are checked against a second-order stepper with four steps a birth, on the paper's three kinds of parts and a
/// block; `docs/results/thermal.md` has the errors. They were tuned on the first of the parts alone.
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
    pub(super) step: Step,
    /// The longest step, s.
    pub(super) seconds: f64,
    /// Shorter steps are taken wherever a voxel was born within this time before the step, s, or will be in it, ...
    pub(super) age_s: f64,
    /// ... and so many voxels around, in x and y, and in z.
    pub(super) margins: [usize; 2],
}

impl Level {
    /// The age up to which births count in a pause: at least two of the longest steps.
    ///
    /// In a print, new births keep a window around those before them. In a pause nothing does, and a long step would leave
    /// up to the whole of the sharpest differences standing.
    pub(super) fn pause_age_s(&self) -> f64 {
        self.age_s.max(2.0 * self.seconds)
    }
}

/// How a step is taken.
#[derive(Clone, Debug)]
pub(super) enum Step {
    /// On the voxels, in stages.
    Voxels(Polynomial),
    /// On blocks of voxels, but for the last so many seconds.
    Blocks {
        /// The short step that follows on the voxels.
        after: Polynomial,
        /// Its length, s.
        after_s: f64,
    },
}

/// What a step on blocks costs: in sweeps of the voxels.
const BLOCK_STAGES: f64 = 8.0;

impl Level {
    /// What a step costs: sweeps of the voxels.
    pub(super) fn stages(&self) -> f64 {
        match &self.step {
            Step::Voxels(polynomial) => polynomial.stages() as f64,
            Step::Blocks { after, .. } => after.stages() as f64 + BLOCK_STAGES,
        }
    }

    /// The same for each second of the longest steps.
    pub(super) fn stages_per_second(&self) -> f64 {
        self.stages() / self.seconds
    }
}

/// A level in units of what it stands on.
#[derive(Clone, Copy)]
struct Spec {
    /// Longest step, times the fastest rate of the voxels.
    length: f64,
    /// Whether it is taken on blocks.
    blocks: bool,
    /// Age, in longest steps.
    age: f64,
    /// Margins, in lengths by which heat spreads within a longest step.
    spreads: f64,
}

const fn voxels(length: f64, age: f64, spreads: f64) -> Spec {
    Spec { length, blocks: false, age, spreads }
}

const fn blocks(length: f64, age: f64, spreads: f64) -> Spec {
    Spec { length, blocks: true, age, spreads }
}

/// The shortest steps first. A birth of the paper's ABS lasts 0.38 in these units: so these are steps of one, 4, 22, 124 and
/// 1,000 births.
const STANDARD: [Spec; 5] = [
    voxels(0.4, 0.0, 0.0),
    voxels(1.93, 1.5, 2.0),
    voxels(8.5, 1.0, 1.5),
    voxels(47.8, 0.25, 2.5),
    blocks(381.0, 1.0, 4.0),
];
const HIGH: [Spec; 5] = [
    voxels(0.4, 0.0, 0.0),
    voxels(1.54, 3.0, 2.5),
    voxels(8.5, 2.0, 2.5),
    voxels(47.8, 1.5, 3.0),
    blocks(381.0, 1.0, 4.0),
];

/// The levels of an accuracy, the shortest steps first.
pub(super) fn levels(accuracy: Accuracy, law: &Law) -> Vec<Level> {
    let specs = match accuracy {
        Accuracy::Standard => STANDARD,
        Accuracy::High => HIGH,
    };
    let after = specs[2].length;
    specs.into_iter().map(|spec| spec.level(after, law)).collect()
}

impl Spec {
    fn level(self, after: f64, law: &Law) -> Level {
        let seconds = self.length / law.fastest;
        let step = if self.blocks {
            Step::Blocks { after: Polynomial::reaching(after), after_s: after / law.fastest }
        } else {
            Step::Voxels(Polynomial::reaching(self.length))
        };
        let margin = |rate: f32| (self.spreads * (2.0 * f64::from(rate) * seconds).sqrt()).ceil() as usize;
        let margins = [margin(law.lateral), margin(law.vertical)];
        Level { step, seconds, age_s: self.age * seconds, margins }
    }
}
