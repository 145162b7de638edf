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

use crate::aligned::LINE_LEN;
use crate::coefficients::{Coefficients, SurfaceResistance, VoxelCoefficients};
use crate::patch::{CoefficientArrays, LineCode};

pub(crate) use self::euler::EulerSweep;
pub(crate) use self::pair::{SweepBuffers, TwoStageSweep};
pub(crate) use self::stages::{Quadratic, TwoSteps};

/// A range of a plane of temperatures, or of their rates, with the same of the planes behind and
/// before it.
#[derive(Clone, Copy)]
struct PlaneNeighbours<'a> {
    back: &'a [f32],
    /// With the row below and the row above.
    here: &'a [f32],
    front: &'a [f32],
    /// Numbers in a row.
    row: usize,
}

impl<'a> PlaneNeighbours<'a> {
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
    fn new(simd: S, coefficients: &Coefficients, planes: PlaneNeighbours<'a>) -> Self {
        let PlaneNeighbours { back, here, front, row } = planes;
        let len = back.len();
        Self {
            simd,
            lateral: simd.splat_f32s(coefficients.lateral),
            vertical: simd.splat_f32s(coefficients.vertical),
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
struct SurfaceLoss<'a, S: Simd, const RESISTANCE: bool> {
    simd: S,
    radiation: [S::f32s; 4],
    diagonal: &'a [S::f32s],
    exposed_area: &'a [S::f32s],
    top_bottom_area: &'a [S::f32s],
    convection: S::f32s,
    resistance: [S::f32s; 2],
}

impl<'a, S: Simd, const RESISTANCE: bool> SurfaceLoss<'a, S, RESISTANCE> {
    #[inline(always)]
    fn new(
        simd: S,
        coefficients: &Coefficients,
        arrays: &'a CoefficientArrays,
        start: usize,
        n: usize,
        linearized: bool,
    ) -> Self {
        let len = n * S::F32_LANES;
        let SurfaceResistance { side, top_bottom } = coefficients.resistance.unwrap_or_default();
        // The derivative of θ · radiation(θ) is a cubic polynomial too.
        let power = |i: usize| if linearized { (i + 1) as f32 } else { 1.0 };
        Self {
            simd,
            radiation: std::array::from_fn(|i| {
                simd.splat_f32s(power(i) * coefficients.radiation[i])
            }),
            diagonal: &lanes::<S>(&arrays.diagonal, start, len)[..n],
            exposed_area: &lanes::<S>(&arrays.exposed_area, start, len)[..n],
            top_bottom_area: if arrays.top_bottom_area.is_empty() {
                &[]
            } else {
                &lanes::<S>(&arrays.top_bottom_area, start, len)[..n]
            },
            convection: simd.splat_f32s(coefficients.convection),
            resistance: [side, top_bottom].map(|number| simd.splat_f32s(number)),
        }
    }

    /// The factor of a voxel's own temperature, or of its rate, given that of its numbers.
    #[inline(always)]
    fn diagonal(
        &self,
        [diagonal, exposed_area, top_bottom_area]: [S::f32s; 3],
        theta: S::f32s,
    ) -> S::f32s {
        let s = self.simd;
        let [r0, r1, r2, r3] = self.radiation;
        let radiated =
            s.mul_add_f32s(s.mul_add_f32s(s.mul_add_f32s(r3, theta, r2), theta, r1), theta, r0);
        if !RESISTANCE {
            return s.negate_mul_add_f32s(radiated, exposed_area, diagonal);
        }
        let [side, cap] = self.resistance;
        let h = s.add_f32s(radiated, self.convection);
        let one = s.splat_f32s(1.0);
        let passed = |exposed_area, distance| {
            s.div_f32s(s.mul_f32s(h, exposed_area), s.mul_add_f32s(h, distance, one))
        };
        let lost = s.add_f32s(passed(exposed_area, side), passed(top_bottom_area, cap));
        s.sub_f32s(diagonal, lost)
    }

    /// The numbers of voxels: diagonal, exposed_area and top_bottom_area.
    #[inline(always)]
    fn voxels(&self, i: usize) -> [S::f32s; 3] {
        let top_bottom_area =
            if RESISTANCE { self.top_bottom_area[i] } else { self.simd.splat_f32s(0.0) };
        [self.diagonal[i], self.exposed_area[i], top_bottom_area]
    }

    /// Numbers of active voxels; 0 for all others.
    #[inline(always)]
    fn active(&self, i: usize, number: S::f32s) -> S::f32s {
        let zero = self.simd.splat_f32s(0.0);
        self.simd.select_f32s(self.simd.less_than_f32s(self.diagonal[i], zero), number, zero)
    }
}

/// The heat equation on a range of a plane of temperatures, or its derivative there on a range of
/// rates, in lanes.
struct HeatEquation<'a, S: Simd, const RESISTANCE: bool> {
    coefficients: &'a Coefficients,
    stencil: Stencil<'a, S>,
    surface: SurfaceLoss<'a, S, RESISTANCE>,
}

impl<'a, S: Simd, const RESISTANCE: bool> HeatEquation<'a, S, RESISTANCE> {
    /// Of a range that begins at the flat index `start`; its derivative, if `linearized`.
    #[inline(always)]
    fn new(
        simd: S,
        coefficients: &'a Coefficients,
        arrays: &'a CoefficientArrays,
        around: PlaneNeighbours<'a>,
        start: usize,
        linearized: bool,
    ) -> Self {
        let stencil = Stencil::new(simd, coefficients, around);
        let surface =
            SurfaceLoss::new(simd, coefficients, arrays, start, stencil.len(), linearized);
        Self { coefficients, stencil, surface }
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

    /// The numbers of voxels with the given faces: diagonal, exposed_area and top_bottom_area.
    #[inline(always)]
    fn uniform_voxels(&self, faces: u8) -> [S::f32s; 3] {
        let VoxelCoefficients { diagonal, exposed_area, top_bottom_area } =
            self.coefficients.by_faces[usize::from(faces)];
        [diagonal, exposed_area, top_bottom_area].map(|number| self.stencil.simd.splat_f32s(number))
    }

    /// The rate of change of voxels that lose nothing to the air, given their diagonal.
    #[inline(always)]
    fn closed(&self, i: usize, diagonal: S::f32s) -> S::f32s {
        self.stencil.simd.mul_add_f32s(diagonal, self.stencil.here[i], self.stencil.inflow(i))
    }

    /// The rate of change of active voxels, given their numbers and their temperatures.
    #[inline(always)]
    fn open(&self, i: usize, voxels: [S::f32s; 3], theta: S::f32s) -> S::f32s {
        self.closed(i, self.surface.diagonal(voxels, theta))
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
struct LineRuns<'a> {
    lines: &'a [LineCode],
    begin: usize,
    /// Lanes in a line.
    lanes: usize,
}

impl<'a> LineRuns<'a> {
    #[inline(always)]
    fn new<S: Simd>(arrays: &'a CoefficientArrays, start: usize, len: usize) -> Self {
        let lines = &arrays.lines[start / LINE_LEN..(start + len) / LINE_LEN];
        Self { lines, begin: 0, lanes: LINE_LEN / S::F32_LANES }
    }
}

impl Iterator for LineRuns<'_> {
    type Item = (LineCode, usize, usize);

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
