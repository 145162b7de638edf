//! The plain scheme.

#![expect(clippy::inline_always, reason = "see the module above")]

use pulp::{Simd, WithSimd};

use super::pair::first_stage;
use super::stages::TwoSteps;
use super::{HeatEquation, LineRuns, PlaneNeighbours};
use crate::coefficients::Coefficients;
use crate::patch::{CoefficientArrays, Shape};

/// One explicit step of a whole patch, from one array into another: the plain scheme.
pub(crate) struct EulerSweep<'a> {
    pub(crate) coefficients: &'a Coefficients,
    pub(crate) shape: Shape,
    pub(crate) arrays: &'a CoefficientArrays,
    pub(crate) from: &'a [f32],
    pub(crate) to: &'a mut [f32],
    /// Rows of each plane from here on are left alone.
    pub(crate) top: usize,
    pub(crate) seconds: f32,
}

impl WithSimd for EulerSweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        if self.coefficients.resistance.is_some() {
            self.step::<S, true>(s)
        } else {
            self.step::<S, false>(s)
        }
    }
}

impl EulerSweep<'_> {
    #[inline(always)]
    fn step<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { coefficients, shape, arrays, from, to, top, seconds } = self;
        let (row, plane) = (shape.row, shape.plane());
        let swept = (top - 1) * row;
        for y in 1..shape.planes - 1 {
            let start = y * plane + row;
            let around =
                PlaneNeighbours::of([y - 1, y, y + 1].map(|y| &from[y * plane..]), swept, row);
            let equation =
                HeatEquation::<S, RESISTANCE>::new(s, coefficients, arrays, around, start, false);
            let runs = LineRuns::new::<S>(arrays, start, swept);
            let to = &mut to[start..start + swept];
            first_stage(s, &equation, runs, TwoSteps { seconds }, to, false);
        }
    }
}
