//! What is done in two stages at once.

#![expect(clippy::inline_always, reason = "see the module above")]

use pulp::Simd;

use crate::coefficients::Coefficients;

/// Two stages that a sweep takes together: what each makes of the rates of change that it finds.
/// Between them, each voxel keeps a number.
pub(crate) trait Stages: Copy + Send + Sync {
    /// Whether the second stage takes the derivative of the heat equation, of the numbers kept, or
    /// the equation itself.
    const LINEARIZED: bool;

    /// The number kept where a voxel is held at the temperature of its birth.
    fn held(coefficients: &Coefficients) -> f32;

    /// The number kept below the part, by the ghosts of the build plate.
    fn below_plate(coefficients: &Coefficients) -> f32;

    /// The numbers kept, given temperatures and their rates.
    fn first<S: Simd>(self, s: S, theta: S::f32s, rate: S::f32s) -> S::f32s;

    /// The temperatures at which surfaces lose heat in the second stage.
    fn surface<S: Simd>(theta: S::f32s, kept: S::f32s) -> S::f32s;

    /// The temperatures after both stages, given those before them, the numbers kept and the rates
    /// that follow from these.
    fn second<S: Simd>(self, s: S, theta: S::f32s, kept: S::f32s, rate: S::f32s) -> S::f32s;
}

/// θ + a f(θ) + b J f(θ), where f is the rate of change and J its derivative; f(θ) is kept.
///
/// With a = dt and b = dt² / 2 that is Heun's method; steps of more stages are products of such
/// pairs.
#[derive(Clone, Copy)]
pub(crate) struct Quadratic {
    pub(crate) a: f32,
    pub(crate) b: f32,
}

impl Stages for Quadratic {
    const LINEARIZED: bool = true;

    fn held(_: &Coefficients) -> f32 {
        0.0
    }

    fn below_plate(_: &Coefficients) -> f32 {
        0.0
    }

    #[inline(always)]
    fn first<S: Simd>(self, _: S, _: S::f32s, rate: S::f32s) -> S::f32s {
        rate
    }

    #[inline(always)]
    fn surface<S: Simd>(theta: S::f32s, _: S::f32s) -> S::f32s {
        theta
    }

    #[inline(always)]
    fn second<S: Simd>(self, s: S, theta: S::f32s, kept: S::f32s, rate: S::f32s) -> S::f32s {
        let [a, b] = [self.a, self.b].map(|number| s.splat_f32s(number));
        s.mul_add_f32s(b, rate, s.mul_add_f32s(a, kept, theta))
    }
}

/// Two explicit steps of so many seconds; the temperatures after the first are kept.
#[derive(Clone, Copy)]
pub(crate) struct TwoSteps {
    pub(crate) seconds: f32,
}

impl Stages for TwoSteps {
    const LINEARIZED: bool = false;

    fn held(coefficients: &Coefficients) -> f32 {
        coefficients.birth_theta
    }

    fn below_plate(coefficients: &Coefficients) -> f32 {
        coefficients.plate_ghost
    }

    #[inline(always)]
    fn first<S: Simd>(self, s: S, theta: S::f32s, rate: S::f32s) -> S::f32s {
        s.mul_add_f32s(s.splat_f32s(self.seconds), rate, theta)
    }

    #[inline(always)]
    fn surface<S: Simd>(_: S::f32s, kept: S::f32s) -> S::f32s {
        kept
    }

    #[inline(always)]
    fn second<S: Simd>(self, s: S, _: S::f32s, kept: S::f32s, rate: S::f32s) -> S::f32s {
        self.first(s, kept, rate)
    }
}
