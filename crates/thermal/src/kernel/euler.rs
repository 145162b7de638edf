//! The plain scheme.

#![expect(clippy::inline_always, reason = "see the module above")]

use pulp::{Simd, WithSimd};

use super::{Equation, Planes, Runs};
use crate::law::{Law, face};
use crate::patch::{Activity, Kind, Shape};

/// One explicit step of a whole patch, from one array into another: the plain scheme.
pub(crate) struct Euler<'a> {
    pub(crate) law: &'a Law,
    pub(crate) shape: Shape,
    pub(crate) activity: &'a Activity,
    pub(crate) from: &'a [f32],
    pub(crate) to: &'a mut [f32],
    /// Rows of each plane from here on are left alone.
    pub(crate) top: usize,
    pub(crate) seconds: f32,
}

impl WithSimd for Euler<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        if self.law.resistance.is_some() { self.step::<S, true>(s) } else { self.step::<S, false>(s) }
    }
}

impl Euler<'_> {
    #[inline(always)]
    fn step<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { law, shape, activity, from, to, top, seconds } = self;
        let (row, plane) = (shape.row, shape.plane());
        let dt = s.splat_f32s(seconds);
        let swept = (top - 1) * row;
        for y in 1..shape.planes - 1 {
            let start = y * plane + row;
            let around = Planes::of([y - 1, y, y + 1].map(|y| &from[y * plane..]), swept, row);
            let equation = Equation::<S, RESISTANCE>::new(s, law, activity, around, start, false);
            let n = equation.len();
            let to = &mut S::as_mut_simd_f32s(&mut to[start..start + swept]).0[..n];
            for (line, begin, end) in Runs::new::<S>(activity, start, swept) {
                let run = begin..end.min(n);
                match line.kind() {
                    Kind::Empty => {}
                    Kind::Uniform(face::INTERIOR) => {
                        let [damping, ..] = equation.uniform_voxels(face::INTERIOR);
                        for i in run {
                            to[i] = s.mul_add_f32s(dt, equation.closed(i, damping), equation.here(i));
                        }
                    }
                    Kind::Uniform(faces) => {
                        let voxels = equation.uniform_voxels(faces);
                        for i in run {
                            let here = equation.here(i);
                            to[i] = s.mul_add_f32s(dt, equation.open(i, voxels, here), here);
                        }
                    }
                    Kind::Mixed => {
                        for i in run {
                            let here = equation.here(i);
                            to[i] = s.mul_add_f32s(dt, equation.mixed(i, here), here);
                        }
                    }
                }
            }
        }
    }
}
