//! A single forward Euler step.

#![expect(clippy::inline_always, reason = "see kernel/lanes.rs")]

use pulp::{Simd, WithSimd};

use super::equation::{HeatEquation, PlaneNeighbours};
use super::runs::{LineRuns, first_stage};
use super::stages::TwoSteps;
use crate::coefficients::Coefficients;
use crate::patch::CoefficientArrays;
use crate::shape::Shape;

/// One forward Euler step of a whole patch, from one array into another: the naive scheme.
///
/// Equals the first stage of [`TwoSteps`] without the second.
/// `to` must already hold the values of the halo and of empty rows, which are not written.
pub(crate) struct EulerSweep<'a> {
    pub(crate) coefficients: &'a Coefficients,
    pub(crate) shape: Shape,
    pub(crate) arrays: &'a CoefficientArrays,
    pub(crate) from: &'a [f32],
    pub(crate) to: &'a mut [f32],
    /// First row of each plane without a voxel: rows from here on are not changed.
    pub(crate) top: usize,
    /// Length of the step, s.
    pub(crate) seconds: f32,
}

impl WithSimd for EulerSweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        if self.coefficients.resistance.is_some() {
            self.sweep::<S, true>(s);
        } else {
            self.sweep::<S, false>(s);
        }
    }
}

impl EulerSweep<'_> {
    #[inline(always)]
    fn sweep<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { coefficients, shape, arrays, from, to, top, seconds } = self;
        let (row_len, plane_len) = (shape.row_len, shape.plane_len());
        // Row 0 is halo; the printed rows follow it.
        let swept = (top - 1) * row_len;
        for y in 1..shape.planes - 1 {
            let start = y * plane_len + row_len;
            let planes = [y - 1, y, y + 1].map(|y| &from[y * plane_len..]);
            let planes = PlaneNeighbours::from_planes(planes, swept, row_len);
            let equation =
                HeatEquation::<S, RESISTANCE>::new(s, coefficients, arrays, planes, start, false);
            let runs = LineRuns::new::<S>(arrays, start, swept);
            let to = &mut to[start..start + swept];
            first_stage(s, &equation, runs, TwoSteps { seconds }, to, false);
        }
    }
}
