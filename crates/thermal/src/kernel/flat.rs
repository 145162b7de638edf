//! Two stages of small patches, one after the other.

#![expect(clippy::inline_always, reason = "see the module above")]

use pulp::{Simd, WithSimd};

use super::pair::Sweep;
use super::stages::Stages;
use super::{HeatEquation, PlaneNeighbours};
use crate::aligned::AlignedBuffer;
use crate::patch::Shape;

/// Numbers that are swept like this: with what is kept of them they fit into the fastest memory.
pub(super) const MAX_FLAT_LEN: usize = 1 << 12;

/// What [`super::TwoStageSweep`] does, for patches so small that to begin with a plane or a run of
/// lines takes as long as to go through with it: the numbers of all planes are kept, and all lines
/// are taken as mixed.
pub(super) struct Flat<'a, T> {
    pub(super) all: Sweep<'a, T>,
    pub(super) theta: &'a mut [f32],
    pub(super) kept: &'a mut [f32],
}

/// Memory for [`Flat`].
#[derive(Debug, Default)]
pub(super) struct SweepBuffers {
    kept: AlignedBuffer,
    /// The shape, the top and the below_plate of the last sweep.
    last: (Shape, usize, f32),
}

impl SweepBuffers {
    /// A number for each voxel of a patch: wherever no sweep of it has written, that of the
    /// below_plate in the first row of each plane, and else 0.
    pub(super) fn of(&mut self, shape: Shape, top: usize, below_plate: f32) -> &mut [f32] {
        if self.last != (shape, top, below_plate) {
            self.kept.reset(shape.len());
            self.kept
                .chunks_exact_mut(shape.plane())
                .for_each(|plane| plane[..shape.row].fill(below_plate));
            self.last = (shape, top, below_plate);
        }
        &mut self.kept
    }
}

impl<T: Stages> WithSimd for Flat<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        if self.all.coefficients.resistance.is_some() {
            self.sweep::<S, true>(s)
        } else {
            self.sweep::<S, false>(s)
        }
    }
}

impl<T: Stages> Flat<'_, T> {
    #[inline(always)]
    fn sweep<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { all: Sweep { coefficients, shape, arrays, stages, held, top }, theta, kept } =
            self;
        let (row, plane) = (shape.row, shape.plane());
        // From the first voxel to the last, over what halo lies between.
        let (start, len) = (plane + row, shape.len() - 2 * (plane + row));
        let behind = [0, plane, 2 * plane];
        let [step, swept] = [plane, (top - 1) * row].map(|numbers| numbers / S::F32_LANES);
        let around = PlaneNeighbours::of(behind.map(|i| &theta[i..]), len, row);
        let equation =
            HeatEquation::<S, RESISTANCE>::new(s, coefficients, arrays, around, start, false);
        let n = equation.len();
        let lanes = &mut S::as_mut_simd_f32s(&mut kept[start..start + len]).0[..n];
        for plane in (0..n).step_by(step) {
            let run = plane..(plane + swept).min(n);
            for i in run {
                let here = equation.here(i);
                lanes[i] = stages.first(s, here, equation.mixed(i, here));
            }
        }
        if let Some(held) = held {
            kept[held] = T::held(coefficients);
        }
        let around = PlaneNeighbours::of(behind.map(|i| &kept[i..]), len, row);
        let equation = HeatEquation::<S, RESISTANCE>::new(
            s,
            coefficients,
            arrays,
            around,
            start,
            T::LINEARIZED,
        );
        let theta = &mut S::as_mut_simd_f32s(&mut theta[start..start + len]).0[..n];
        for plane in (0..n).step_by(step) {
            let run = plane..(plane + swept).min(n);
            for i in run {
                let kept = equation.here(i);
                let rate = equation.mixed(i, T::surface::<S>(theta[i], kept));
                theta[i] = stages.second(s, theta[i], kept, rate);
            }
        }
    }
}
