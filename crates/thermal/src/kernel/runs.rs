//! Loops over runs of equal cache lines.
//!
//! Each cache line of 16 voxels has a code ([`LineCode`]) for the loop that can process it.
//! A sweep looks up how many lines with the same code follow each other and runs one tight loop
//! over them, instead of choosing a loop for each line.

use pulp::Simd;

use super::equation::HeatEquation;
use super::stages::TwoStageScheme;
use crate::aligned::LINE_LEN;
use crate::coefficients::face;
use crate::line_code::{LineCode, LineKind};
use crate::patch::CoefficientArrays;

/// Iterator over the runs of equal lines in a range of a patch: their kind, and where each begins
/// and ends, counted in vectors.
pub(super) struct LineRuns<'a> {
    lines: &'a [LineCode],
    /// First line of the next run.
    begin: usize,
    vectors_per_line: usize,
}

impl<'a> LineRuns<'a> {
    /// The runs of a range that begins at the flat index `start`; both numbers are multiples of a
    /// cache line.
    #[inline(always)]
    pub(super) fn new<S: Simd>(arrays: &'a CoefficientArrays, start: usize, len: usize) -> Self {
        let lines = &arrays.lines[start / LINE_LEN..(start + len) / LINE_LEN];
        Self { lines, begin: 0, vectors_per_line: LINE_LEN / S::F32_LANES }
    }
}

impl Iterator for LineRuns<'_> {
    type Item = (LineKind, usize, usize);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let begin = self.begin;
        let line = *self.lines.get(begin)?;
        self.begin += line.run_length(&self.lines[begin..]);
        Some((line.kind(), begin * self.vectors_per_line, self.begin * self.vectors_per_line))
    }
}

/// Computes the intermediate values of one range from its temperatures: the first stage.
///
/// Empty lines need no computation.
/// With `clear` they are set to 0, for buffers that may hold the values of another plane.
#[inline(always)]
pub(super) fn first_stage<S: Simd, const RESISTANCE: bool>(
    s: S,
    equation: &HeatEquation<'_, S, RESISTANCE>,
    runs: LineRuns<'_>,
    scheme: impl TwoStageScheme,
    intermediate: &mut [f32],
    clear: bool,
) {
    let n = equation.len();
    let intermediate = &mut S::as_mut_simd_f32s(intermediate).0[..n];
    for (kind, begin, end) in runs {
        let run = begin..end.min(n);
        match kind {
            LineKind::Empty if !clear => {}
            LineKind::Empty => {
                for i in run {
                    intermediate[i] = equation.opaque_zero();
                }
            }
            LineKind::Uniform(face::INTERIOR) => {
                let [diagonal, ..] = equation.uniform_coefficients(face::INTERIOR);
                for i in run {
                    let rate = equation.rate_inside(i, diagonal);
                    intermediate[i] = scheme.first(s, equation.here(i), rate);
                }
            }
            LineKind::Uniform(faces) => {
                let voxels = equation.uniform_coefficients(faces);
                for i in run {
                    let theta = equation.here(i);
                    let rate = equation.rate_at_surface(i, voxels, theta);
                    intermediate[i] = scheme.first(s, theta, rate);
                }
            }
            LineKind::Mixed => {
                for i in run {
                    let theta = equation.here(i);
                    intermediate[i] = scheme.first(s, theta, equation.rate_masked(i, theta));
                }
            }
        }
    }
}

/// Computes the final temperatures of one range from its intermediate values, in place: the second
/// stage.
///
/// `equation` is over the intermediate values, `theta` still holds the temperatures before the
/// first stage.
#[inline(always)]
pub(super) fn second_stage<S: Simd, const RESISTANCE: bool, T: TwoStageScheme>(
    s: S,
    equation: &HeatEquation<'_, S, RESISTANCE>,
    runs: LineRuns<'_>,
    scheme: T,
    theta: &mut [f32],
) {
    let n = equation.len();
    let theta = &mut S::as_mut_simd_f32s(theta).0[..n];
    for (kind, begin, end) in runs {
        let run = begin..end.min(n);
        match kind {
            LineKind::Empty => {}
            LineKind::Uniform(face::INTERIOR) => {
                let [diagonal, ..] = equation.uniform_coefficients(face::INTERIOR);
                for i in run {
                    let rate = equation.rate_inside(i, diagonal);
                    theta[i] = scheme.second(s, theta[i], equation.here(i), rate);
                }
            }
            LineKind::Uniform(faces) => {
                let voxels = equation.uniform_coefficients(faces);
                for i in run {
                    let intermediate = equation.here(i);
                    let surface = T::surface_theta::<S>(theta[i], intermediate);
                    let rate = equation.rate_at_surface(i, voxels, surface);
                    theta[i] = scheme.second(s, theta[i], intermediate, rate);
                }
            }
            LineKind::Mixed => {
                for i in run {
                    let intermediate = equation.here(i);
                    let surface = T::surface_theta::<S>(theta[i], intermediate);
                    let rate = equation.rate_masked(i, surface);
                    theta[i] = scheme.second(s, theta[i], intermediate, rate);
                }
            }
        }
    }
}
