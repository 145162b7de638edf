//! Small patches: both stages of a step, one after the other.

#![expect(clippy::inline_always, reason = "see the module above")]

use pulp::{Simd, WithSimd};

use super::pair::Sweep;
use super::{Equation, Planes};
use crate::aligned::Aligned;
use crate::patch::Shape;

/// Numbers that are swept like this: with their rates they fit into the fastest memory.
pub(super) const MOST: usize = 1 << 12;

/// What [`super::Pair`] does, for patches so small that to begin with a plane or a run of lines takes as long as to go
/// through with it: all rates are kept, and all lines are taken as mixed.
pub(super) struct Flat<'a> {
    pub(super) all: Sweep<'a>,
    pub(super) theta: &'a mut [f32],
    /// One of each voxel, 0 outside what is swept.
    pub(super) rates: &'a mut [f32],
}

/// Memory for the rates of [`Flat`].
#[derive(Debug, Default)]
pub(super) struct Rates {
    rates: Aligned,
    /// The shape and the top of the last sweep.
    last: (Shape, usize),
}

impl Rates {
    /// The rates of a patch: 0 wherever no sweep of it has written.
    pub(super) fn of(&mut self, shape: Shape, top: usize) -> &mut [f32] {
        if self.last != (shape, top) {
            self.rates.reset(shape.len());
            self.last = (shape, top);
        }
        &mut self.rates
    }
}

impl WithSimd for Flat<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        if self.all.law.resistance.is_some() { self.sweep::<S, true>(s) } else { self.sweep::<S, false>(s) }
    }
}

impl Flat<'_> {
    #[inline(always)]
    fn sweep<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { all: Sweep { law, shape, activity, a, b, held, top }, theta, rates } = self;
        let (row, plane) = (shape.row, shape.plane());
        // From the first voxel to the last, over what rim lies between.
        let (start, len) = (plane + row, shape.len() - 2 * (plane + row));
        let behind = [0, plane, 2 * plane];
        let [step, swept] = [plane, (top - 1) * row].map(|numbers| numbers / S::F32_LANES);
        let around = Planes::of(behind.map(|i| &theta[i..]), len, row);
        let equation = Equation::<S, RESISTANCE>::new(s, law, activity, around, start);
        let n = equation.len();
        let lanes = &mut S::as_mut_simd_f32s(&mut rates[start..start + len]).0[..n];
        for plane in (0..n).step_by(step) {
            let run = plane..(plane + swept).min(n);
            for i in run {
                lanes[i] = equation.mixed(i, equation.here(i));
            }
        }
        if let Some(held) = held {
            rates[held] = 0.0;
        }
        let (a, b) = (s.splat_f32s(a), s.splat_f32s(b));
        let around = Planes::of(behind.map(|i| &rates[i..]), len, row);
        let equation = Equation::<S, RESISTANCE>::derivative(s, law, activity, around, start);
        let theta = &mut S::as_mut_simd_f32s(&mut theta[start..start + len]).0[..n];
        for plane in (0..n).step_by(step) {
            let run = plane..(plane + swept).min(n);
            for i in run {
                let half = s.mul_add_f32s(a, equation.here(i), theta[i]);
                theta[i] = s.mul_add_f32s(b, equation.mixed(i, theta[i]), half);
            }
        }
    }
}
