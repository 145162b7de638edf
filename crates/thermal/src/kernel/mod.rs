//! The sweeps over a patch: where all the time goes.
//!
//! Written on lanes of whatever width the processor has, chosen when the program runs.
//! Products are fused into sums wherever the source says so and nowhere else, so that every
//! processor computes the same bits.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined into a sweep is compiled for the processor's lanes"
)]

mod euler;
mod flat;
mod pair;
mod stages;

use pulp::{Arch, Simd, WithSimd};

use crate::aligned::LINE;
use crate::law::{Law, Voxel};
use crate::patch::{Activity, Line};

pub(crate) use self::euler::Euler;
pub(crate) use self::pair::{Kept, Pair};
pub(crate) use self::stages::{Quadratic, TwoSteps};

/// A range of a plane of temperatures, or of their rates, with the same of the planes behind and
/// before it.
#[derive(Clone, Copy)]
struct Planes<'a> {
    back: &'a [f32],
    /// With the row below and the row above.
    here: &'a [f32],
    front: &'a [f32],
    /// Numbers in a row.
    row: usize,
}

impl<'a> Planes<'a> {
    /// From the second row of three planes on.
    #[inline(always)]
    fn of([back, here, front]: [&'a [f32]; 3], len: usize, row: usize) -> Self {
        Self {
            back: &back[row..][..len],
            here: &here[..len + 2 * row],
            front: &front[row..][..len],
            row,
        }
    }
}

/// One range of a plane and its six neighbours, in lanes.
struct Stencil<'a, S: Simd> {
    simd: S,
    lateral: S::f32s,
    vertical: S::f32s,
    here: &'a [S::f32s],
    left: &'a [S::f32s],
    right: &'a [S::f32s],
    back: &'a [S::f32s],
    front: &'a [S::f32s],
    below: &'a [S::f32s],
    above: &'a [S::f32s],
}

#[inline(always)]
fn lanes<S: Simd>(numbers: &[f32], start: usize, len: usize) -> &[S::f32s] {
    S::as_simd_f32s(&numbers[start..start + len]).0
}

impl<'a, S: Simd> Stencil<'a, S> {
    /// `here` of the planes begins one row before the range, `back` and `front` with it.
    #[inline(always)]
    fn new(simd: S, law: &Law, planes: Planes<'a>) -> Self {
        let Planes { back, here, front, row } = planes;
        let len = back.len();
        Self {
            simd,
            lateral: simd.splat_f32s(law.lateral),
            vertical: simd.splat_f32s(law.vertical),
            here: lanes::<S>(here, row, len),
            left: lanes::<S>(here, row - 1, len),
            right: lanes::<S>(here, row + 1, len),
            below: lanes::<S>(here, 0, len),
            above: lanes::<S>(here, 2 * row, len),
            back: lanes::<S>(back, 0, len),
            front: lanes::<S>(front, 0, len),
        }
    }

    /// So many lanes: known to the compiler, it need not check the loops over them.
    #[inline(always)]
    fn len(&self) -> usize {
        let n = self.here.len();
        let all = [self.left, self.right, self.back, self.front, self.below, self.above];
        assert!(
            all.iter().all(|numbers| numbers.len() == n),
            "all neighbours have the range's length"
        );
        n
    }

    /// What flows in from the neighbours.
    #[inline(always)]
    fn inflow(&self, i: usize) -> S::f32s {
        let s = self.simd;
        let x = s.add_f32s(self.left[i], self.right[i]);
        let y = s.add_f32s(self.back[i], self.front[i]);
        let z = s.add_f32s(self.below[i], self.above[i]);
        s.mul_add_f32s(self.lateral, s.add_f32s(x, y), s.mul_f32s(self.vertical, z))
    }
}

/// What a surface loses, in lanes; with a resistance of its own or, as the compiler is to know,
/// without.
struct Surface<'a, S: Simd, const RESISTANCE: bool> {
    simd: S,
    radiation: [S::f32s; 4],
    damping: &'a [S::f32s],
    exposure: &'a [S::f32s],
    caps: &'a [S::f32s],
    resistance: [S::f32s; 3],
}

impl<'a, S: Simd, const RESISTANCE: bool> Surface<'a, S, RESISTANCE> {
    #[inline(always)]
    fn new(
        simd: S,
        law: &Law,
        activity: &'a Activity,
        start: usize,
        n: usize,
        derived: bool,
    ) -> Self {
        let len = n * S::F32_LANES;
        // The derivative of θ · radiation(θ) is a cubic polynomial too.
        let power = |i: usize| if derived { (i + 1) as f32 } else { 1.0 };
        Self {
            simd,
            radiation: std::array::from_fn(|i| simd.splat_f32s(power(i) * law.radiation[i])),
            damping: &lanes::<S>(&activity.damping, start, len)[..n],
            exposure: &lanes::<S>(&activity.exposure, start, len)[..n],
            caps: if activity.caps.is_empty() {
                &[]
            } else {
                &lanes::<S>(&activity.caps, start, len)[..n]
            },
            resistance: law.resistance.unwrap_or_default().map(|number| simd.splat_f32s(number)),
        }
    }

    /// The factor of a voxel's own temperature, or of its rate, given that of its numbers.
    #[inline(always)]
    fn damping(&self, [damping, exposure, caps]: [S::f32s; 3], theta: S::f32s) -> S::f32s {
        let s = self.simd;
        let [r0, r1, r2, r3] = self.radiation;
        let radiated =
            s.mul_add_f32s(s.mul_add_f32s(s.mul_add_f32s(r3, theta, r2), theta, r1), theta, r0);
        if !RESISTANCE {
            return s.negate_mul_add_f32s(radiated, exposure, damping);
        }
        let [convection, side, cap] = self.resistance;
        let h = s.add_f32s(radiated, convection);
        let one = s.splat_f32s(1.0);
        let passed = |exposure, distance| {
            s.div_f32s(s.mul_f32s(h, exposure), s.mul_add_f32s(h, distance, one))
        };
        let lost = s.add_f32s(passed(exposure, side), passed(caps, cap));
        s.sub_f32s(damping, lost)
    }

    /// The numbers of voxels: damping, exposure and caps.
    #[inline(always)]
    fn voxels(&self, i: usize) -> [S::f32s; 3] {
        let caps = if RESISTANCE { self.caps[i] } else { self.simd.splat_f32s(0.0) };
        [self.damping[i], self.exposure[i], caps]
    }

    /// Numbers of active voxels; 0 for all others.
    #[inline(always)]
    fn active(&self, i: usize, number: S::f32s) -> S::f32s {
        let zero = self.simd.splat_f32s(0.0);
        self.simd.select_f32s(self.simd.less_than_f32s(self.damping[i], zero), number, zero)
    }
}

/// The heat equation on a range of a plane of temperatures, or its derivative there on a range of
/// rates, in lanes.
struct Equation<'a, S: Simd, const RESISTANCE: bool> {
    law: &'a Law,
    stencil: Stencil<'a, S>,
    surface: Surface<'a, S, RESISTANCE>,
}

impl<'a, S: Simd, const RESISTANCE: bool> Equation<'a, S, RESISTANCE> {
    /// Of a range that begins at the flat index `start`; its derivative, if `derived`.
    #[inline(always)]
    fn new(
        simd: S,
        law: &'a Law,
        activity: &'a Activity,
        around: Planes<'a>,
        start: usize,
        derived: bool,
    ) -> Self {
        let stencil = Stencil::new(simd, law, around);
        let surface = Surface::new(simd, law, activity, start, stencil.len(), derived);
        Self { law, stencil, surface }
    }

    /// So many lanes.
    #[inline(always)]
    fn len(&self) -> usize {
        self.stencil.len()
    }

    #[inline(always)]
    fn here(&self, i: usize) -> S::f32s {
        self.stencil.here[i]
    }

    /// 0, but not so that the compiler could see it: to fill a few lines, it would call a function
    /// that takes longer.
    #[inline(always)]
    fn nothing(&self) -> S::f32s {
        self.stencil.simd.sub_f32s(self.stencil.lateral, self.stencil.lateral)
    }

    /// The numbers of voxels with the given faces: damping, exposure and caps.
    #[inline(always)]
    fn uniform_voxels(&self, faces: u8) -> [S::f32s; 3] {
        let Voxel { damping, exposure, caps } = self.law.voxels[usize::from(faces)];
        [damping, exposure, caps].map(|number| self.stencil.simd.splat_f32s(number))
    }

    /// The rate of change of voxels that lose nothing to the air, given their damping.
    #[inline(always)]
    fn closed(&self, i: usize, damping: S::f32s) -> S::f32s {
        self.stencil.simd.mul_add_f32s(damping, self.stencil.here[i], self.stencil.inflow(i))
    }

    /// The rate of change of active voxels, given their numbers and their temperatures.
    #[inline(always)]
    fn open(&self, i: usize, voxels: [S::f32s; 3], theta: S::f32s) -> S::f32s {
        self.closed(i, self.surface.damping(voxels, theta))
    }

    /// The rate of change of any voxels, given their temperatures.
    #[inline(always)]
    fn mixed(&self, i: usize, theta: S::f32s) -> S::f32s {
        self.surface.active(i, self.open(i, self.surface.voxels(i), theta))
    }
}

/// The runs of equal lines in a range of a patch: what they are, and where each begins and ends, in
/// lanes of a width.
///
/// An iterator and not a function that takes a closure: closures that are not inlined lose the
/// lanes.
struct Runs<'a> {
    lines: &'a [Line],
    begin: usize,
    /// Lanes in a line.
    lanes: usize,
}

impl<'a> Runs<'a> {
    #[inline(always)]
    fn new<S: Simd>(activity: &'a Activity, start: usize, len: usize) -> Self {
        let lines = &activity.lines[start / LINE..(start + len) / LINE];
        Self { lines, begin: 0, lanes: LINE / S::F32_LANES }
    }
}

impl Iterator for Runs<'_> {
    type Item = (Line, usize, usize);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let begin = self.begin;
        let line = *self.lines.get(begin)?;
        self.begin += line.run(&self.lines[begin..]);
        Some((line, begin * self.lanes, self.begin * self.lanes))
    }
}

/// Runs a sweep on the widest lanes that the processor has.
pub(crate) fn dispatch<W: WithSimd>(sweep: W) -> W::Output {
    Arch::new().dispatch(sweep)
}
