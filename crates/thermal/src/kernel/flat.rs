//! Two-stage sweeps of small patches, as one flat range.

#![expect(clippy::inline_always, reason = "see kernel/lanes.rs")]

use pulp::{Simd, WithSimd};

use super::equation::{HeatEquation, PlaneNeighbours};
use super::stages::{SweepParameters, TwoStageScheme};
use crate::aligned::AlignedBuffer;
use crate::shape::Shape;

/// Maximum number of elements of a patch that is swept as one flat range: together with their
/// intermediate values they fit into the first-level cache.
pub(super) const MAX_FLAT_LEN: usize = 1 << 12;

/// A two-stage sweep that runs each stage over the whole patch.
///
/// Windows near the nozzle have a few dozen cache lines.
/// There, starting a plane or a run of lines takes longer than computing its voxels, so this sweep
/// has neither: the intermediate values of all planes are stored, and all lines are treated as
/// mixed.
/// The result has the same bits as that of [`super::slab::Slab`], for three reasons: the
/// coefficients in memory equal those that a uniform line shares, an exposed area of 0 subtracts
/// exactly 0 from the diagonal, and masks do not change active voxels.
pub(super) struct FlatSweep<'a, T> {
    pub(super) parameters: SweepParameters<'a, T>,
    pub(super) theta: &'a mut [f32],
    /// From [`FlatBuffer::prepare`].
    pub(super) intermediate: &'a mut [f32],
}

/// Intermediate values of a [`FlatSweep`], kept from one to the next.
#[derive(Debug, Default)]
pub(super) struct FlatBuffer {
    intermediate: AlignedBuffer,
    /// Shape, first empty row and ghost value for which the halo is set up.
    prepared_for: (Shape, usize, f32),
}

impl FlatBuffer {
    /// Intermediate values for a patch, with a valid halo: the ghost value in row 0 of each plane,
    /// 0 elsewhere.
    ///
    /// Sweeps never write the halo, so it stays valid until one of the arguments changes.
    /// Old values of voxels do no harm: the first stage overwrites them before the second reads
    /// them.
    pub(super) fn prepare(&mut self, shape: Shape, top: usize, ghost: f32) -> &mut [f32] {
        if self.prepared_for != (shape, top, ghost) {
            self.intermediate.reset(shape.len());
            self.intermediate
                .chunks_exact_mut(shape.plane_len())
                .for_each(|plane| plane[..shape.row_len].fill(ghost));
            self.prepared_for = (shape, top, ghost);
        }
        &mut self.intermediate
    }
}

impl<T: TwoStageScheme> WithSimd for FlatSweep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        if self.parameters.coefficients.resistance.is_some() {
            self.sweep::<S, true>(s);
        } else {
            self.sweep::<S, false>(s);
        }
    }
}

impl<T: TwoStageScheme> FlatSweep<'_, T> {
    #[inline(always)]
    fn sweep<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { parameters, theta, intermediate } = self;
        let SweepParameters { coefficients, shape, arrays, scheme, held, top } = parameters;
        let (row_len, plane_len) = (shape.row_len, shape.plane_len());
        // One range from row 1 of plane 1 to the last row but one of the last plane but one.
        // It runs through the halo rows between planes; the loops below skip these.
        let (start, len) = (plane_len + row_len, shape.len() - 2 * (plane_len + row_len));
        let offsets = [0, plane_len, 2 * plane_len];
        // In vectors: from one plane to the next, and the printed rows of each plane.
        let [stride, swept] =
            [plane_len, (top - 1) * row_len].map(|numbers| numbers / S::F32_LANES);
        // First stage: intermediate values from temperatures.
        let planes = offsets.map(|offset| &theta[offset..]);
        let planes = PlaneNeighbours::from_planes(planes, len, row_len);
        let equation =
            HeatEquation::<S, RESISTANCE>::new(s, coefficients, arrays, planes, start, false);
        let n = equation.len();
        let inside = &mut intermediate[start..start + len];
        let inside = &mut S::as_mut_simd_f32s(inside).0[..n];
        for plane in (0..n).step_by(stride) {
            let run = plane..(plane + swept).min(n);
            for i in run {
                let theta = equation.here(i);
                inside[i] = scheme.first(s, theta, equation.rate_masked(i, theta));
            }
        }
        if let Some(held) = held {
            intermediate[held] = T::held_intermediate(coefficients);
        }
        // Second stage: temperatures from intermediate values.
        let planes = offsets.map(|offset| &intermediate[offset..]);
        let planes = PlaneNeighbours::from_planes(planes, len, row_len);
        let equation = HeatEquation::<S, RESISTANCE>::new(
            s,
            coefficients,
            arrays,
            planes,
            start,
            T::LINEARIZED,
        );
        let theta = &mut S::as_mut_simd_f32s(&mut theta[start..start + len]).0[..n];
        for plane in (0..n).step_by(stride) {
            let run = plane..(plane + swept).min(n);
            for i in run {
                let intermediate = equation.here(i);
                let surface = T::surface_theta::<S>(theta[i], intermediate);
                let rate = equation.rate_masked(i, surface);
                theta[i] = scheme.second(s, theta[i], intermediate, rate);
            }
        }
    }
}
