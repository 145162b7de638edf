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
    pub(super) polynomial: Polynomial,
    /// The longest step, s.
    pub(super) seconds: f64,
    /// Shorter steps are taken wherever a voxel was born within this time before the step, s, or will be in it, ...
    pub(super) age_s: f64,
    /// ... and so many voxels around, in x and y, and in z.
    pub(super) margins: [usize; 2],
}

impl Level {
    /// Stages of a step.
    pub(super) fn stages(&self) -> f64 {
        2.0 * self.polynomial.factors.len() as f64
    }

    /// Stages for each second of the longest steps.
    pub(super) fn stages_per_second(&self) -> f64 {
        self.stages() / self.seconds
    }
}

/// A level in units of what it stands on.
struct Spec {
    /// Stages of a step.
    stages: usize,
    /// Longest step, as a part of the longest that is stable.
    fill: f64,
    /// Age, in longest steps.
    age: f64,
    /// Margins, in lengths by which heat spreads within a longest step.
    spreads: f64,
}

const fn spec(stages: usize, fill: f64, age: f64, spreads: f64) -> Spec {
    Spec { stages, fill, age, spreads }
}

/// The shortest steps first: a birth, then about 4, 22 and 124 births of the paper's ABS.
///
/// The longest steps must not begin before what was printed last has aged by one of them: they leave up to the whole of
/// the sharpest differences standing, which a pause right after a birth shows (6.8 K at a quarter of a step).
const STANDARD: [Spec; 4] =
    [spec(2, 0.3, 0.0, 0.0), spec(2, 0.78, 1.5, 2.0), spec(4, 0.87, 2.0, 2.0), spec(10, 0.74, 1.0, 3.0)];
const HIGH: [Spec; 4] =
    [spec(2, 0.3, 0.0, 0.0), spec(2, 0.78, 3.0, 2.5), spec(4, 0.87, 2.0, 2.5), spec(10, 0.74, 1.5, 3.0)];

/// The levels of an accuracy, the shortest steps first.
pub(super) fn levels(accuracy: Accuracy, law: &Law) -> Vec<Level> {
    let specs = match accuracy {
        Accuracy::Standard => STANDARD,
        Accuracy::High => HIGH,
    };
    specs.into_iter().map(|spec| spec.level(law)).collect()
}

impl Spec {
    fn level(self, law: &Law) -> Level {
        let polynomial = Polynomial::of_stages(self.stages);
        let seconds = self.fill * polynomial.reach / law.fastest;
        let margin = |rate: f32| (self.spreads * (2.0 * f64::from(rate) * seconds).sqrt()).ceil() as usize;
        let margins = [margin(law.lateral), margin(law.vertical)];
        Level { polynomial, seconds, age_s: self.age * seconds, margins }
    }
}
