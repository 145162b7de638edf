//! The explicit methods that a two-stage sweep can take.
//!
//! Every method here has two evaluations of the equation per sweep.
//! The first turns temperatures and their rates into one **intermediate value** per voxel; the
//! second evaluates the equation, or its linearisation, over the intermediate values and turns the
//! result into new temperatures.

use pulp::Simd;

use crate::coefficients::Coefficients;
use crate::patch::CoefficientArrays;
use crate::shape::Shape;

/// A method of two stages.
pub(crate) trait TwoStageScheme: Copy + Send + Sync {
    /// Whether the second stage evaluates the linearised equation J f over intermediate values that
    /// are rates; otherwise it evaluates the equation over intermediate temperatures.
    const LINEARIZED: bool;

    /// Intermediate value of a voxel that is held at its birth temperature.
    fn held_intermediate(coefficients: &Coefficients) -> f32;

    /// Intermediate value of the ghosts of the build plate below layer 0.
    fn ghost_intermediate(coefficients: &Coefficients) -> f32;

    /// The intermediate values, given temperatures and their rates.
    fn first<S: Simd>(self, s: S, theta: S::f32s, rate: S::f32s) -> S::f32s;

    /// The temperatures at which the second stage evaluates surface losses.
    fn surface_theta<S: Simd>(theta: S::f32s, intermediate: S::f32s) -> S::f32s;

    /// The temperatures after both stages, given those before them, the intermediate values, and
    /// the rates that the second stage computed from these.
    fn second<S: Simd>(self, s: S, theta: S::f32s, intermediate: S::f32s, rate: S::f32s)
    -> S::f32s;
}

/// θ + a f(θ) + b J f(θ), where f is the right-hand side of the heat equation and J its Jacobian at
/// θ; the intermediate values are the rates f(θ).
///
/// With a = dt and b = dt² / 2 this is the second-order Taylor method.
/// It equals Heun's method wherever the equation is linear; for radiation the two differ in third
/// order.
/// Steps of more stages are products of such factors with other a and b (`fast/chebyshev.rs`).
#[derive(Clone, Copy)]
pub(crate) struct Quadratic {
    pub(crate) a: f32,
    pub(crate) b: f32,
}

impl TwoStageScheme for Quadratic {
    const LINEARIZED: bool = true;

    // The voxel under the nozzle and the plate are held at constant temperatures, so their rates
    // are 0.

    fn held_intermediate(_: &Coefficients) -> f32 {
        0.0
    }

    fn ghost_intermediate(_: &Coefficients) -> f32 {
        0.0
    }

    #[inline(always)]
    fn first<S: Simd>(self, _: S, _: S::f32s, rate: S::f32s) -> S::f32s {
        rate
    }

    #[inline(always)]
    fn surface_theta<S: Simd>(theta: S::f32s, _: S::f32s) -> S::f32s {
        theta
    }

    #[inline(always)]
    fn second<S: Simd>(
        self,
        s: S,
        theta: S::f32s,
        intermediate: S::f32s,
        rate: S::f32s,
    ) -> S::f32s {
        let [a, b] = [self.a, self.b].map(|number| s.splat_f32s(number));
        s.mul_add_f32s(b, rate, s.mul_add_f32s(a, intermediate, theta))
    }
}

/// Two forward Euler steps of equal length; the intermediate values are the temperatures after the
/// first.
#[derive(Clone, Copy)]
pub(crate) struct TwoSteps {
    /// Length of each step, s.
    pub(crate) seconds: f32,
}

impl TwoStageScheme for TwoSteps {
    const LINEARIZED: bool = false;

    fn held_intermediate(coefficients: &Coefficients) -> f32 {
        coefficients.birth_theta
    }

    fn ghost_intermediate(coefficients: &Coefficients) -> f32 {
        coefficients.plate_ghost
    }

    #[inline(always)]
    fn first<S: Simd>(self, s: S, theta: S::f32s, rate: S::f32s) -> S::f32s {
        s.mul_add_f32s(s.splat_f32s(self.seconds), rate, theta)
    }

    #[inline(always)]
    fn surface_theta<S: Simd>(_: S::f32s, intermediate: S::f32s) -> S::f32s {
        intermediate
    }

    #[inline(always)]
    fn second<S: Simd>(self, s: S, _: S::f32s, intermediate: S::f32s, rate: S::f32s) -> S::f32s {
        self.first(s, intermediate, rate)
    }
}

/// Parameters of a two-stage sweep, apart from the temperatures: shared by all of its threads.
#[derive(Clone, Copy)]
pub(super) struct SweepParameters<'a, T> {
    pub(super) coefficients: &'a Coefficients,
    pub(super) shape: Shape,
    pub(super) arrays: &'a CoefficientArrays,
    pub(super) scheme: T,
    /// Flat index of a voxel that is held at its birth temperature.
    pub(super) held: Option<usize>,
    /// First row of each plane without a voxel: rows from here on are not changed.
    pub(super) top: usize,
}
