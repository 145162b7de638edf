//! The plain scheme.

#![expect(clippy::inline_always, reason = "see the module above")]

use pulp::{Simd, WithSimd};

use super::pair::first_stage;
use super::stages::TwoSteps;
use super::{Equation, Planes, Runs};
use crate::law::Law;
use crate::patch::{Activity, Shape};

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
        if self.law.resistance.is_some() {
            self.step::<S, true>(s)
        } else {
            self.step::<S, false>(s)
        }
    }
}

impl Euler<'_> {
    #[inline(always)]
    fn step<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { law, shape, activity, from, to, top, seconds } = self;
        let (row, plane) = (shape.row, shape.plane());
        let swept = (top - 1) * row;
        for y in 1..shape.planes - 1 {
            let start = y * plane + row;
            let around = Planes::of([y - 1, y, y + 1].map(|y| &from[y * plane..]), swept, row);
            let equation = Equation::<S, RESISTANCE>::new(s, law, activity, around, start, false);
            let runs = Runs::new::<S>(activity, start, swept);
            let to = &mut to[start..start + swept];
            first_stage(s, &equation, runs, TwoSteps { seconds }, to, false);
        }
    }
}
