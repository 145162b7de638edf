//! The right-hand side of the heat equation in vector lanes.
//!
//! [`HeatEquation`] evaluates the rate of change dθ/dt of one vector of voxels at a time: a
//! [`Stencil`] for conduction, plus [`SurfaceLoss`] where the voxels touch the air.
//! [`crate::coefficients::Coefficients`] has the formula.
//!
//! The same code evaluates the *linearised* equation J f, the Jacobian J at some temperatures
//! applied to a vector of rates f, which second-order methods need (`stages.rs`).
//! Conduction and convection are linear, so there J is the equation itself; only the radiation
//! polynomial is replaced by its derivative.

use pulp::Simd;

use super::lanes::lanes;
use crate::coefficients::{Coefficients, SurfaceResistance, VoxelCoefficients};
use crate::patch::CoefficientArrays;

/// A contiguous range of one plane, together with what the stencil reads around it.
///
/// The values are temperatures, or rates for the linearised equation.
#[derive(Clone, Copy)]
pub(super) struct PlaneNeighbours<'a> {
    /// The same range of the plane at y - 1.
    back: &'a [f32],
    /// The range itself, extended by the row below and the row above.
    here: &'a [f32],
    /// The same range of the plane at y + 1.
    front: &'a [f32],
    row_len: usize,
}

impl<'a> PlaneNeighbours<'a> {
    /// The range of `len` elements that starts at row 1 of the second of three planes.
    #[inline(always)]
    pub(super) fn from_planes(
        [back, here, front]: [&'a [f32]; 3],
        len: usize,
        row_len: usize,
    ) -> Self {
        Self {
            back: &back[row_len..][..len],
            here: &here[..len + 2 * row_len],
            front: &front[row_len..][..len],
            row_len,
        }
    }
}

/// The seven-point stencil over a range of a plane: the voxels and their six neighbours.
///
/// Each neighbour is the same range shifted in memory: by one element in x, by a row in z, and by a
/// plane in y.
/// At the ends of rows the shift by one element reads a value of another row.
/// That is harmless: the first and last element of a row are halo, whose rates are masked.
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

impl<'a, S: Simd> Stencil<'a, S> {
    #[inline(always)]
    fn new(simd: S, coefficients: &Coefficients, planes: PlaneNeighbours<'a>) -> Self {
        let PlaneNeighbours { back, here, front, row_len } = planes;
        let len = back.len();
        // `here` begins one row before the range.
        Self {
            simd,
            lateral: simd.splat_f32s(coefficients.lateral),
            vertical: simd.splat_f32s(coefficients.vertical),
            here: lanes::<S>(here, row_len, len),
            left: lanes::<S>(here, row_len - 1, len),
            right: lanes::<S>(here, row_len + 1, len),
            below: lanes::<S>(here, 0, len),
            above: lanes::<S>(here, 2 * row_len, len),
            back: lanes::<S>(back, 0, len),
            front: lanes::<S>(front, 0, len),
        }
    }

    /// Number of vectors in the range.
    ///
    /// The assertion lets the compiler conclude that all seven slices are equally long, so that it
    /// can drop the bounds checks from loops up to this length.
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

    /// Heat conducted from the six neighbours, K/s; the heat conducted to them is part of the
    /// diagonal.
    ///
    /// Opposite neighbours are added first, then x and y.
    /// Addition commutes but does not associate in floating point: with this order, mirroring the
    /// part or exchanging x and y does not change a bit of the result.
    #[inline(always)]
    fn inflow(&self, i: usize) -> S::f32s {
        let s = self.simd;
        let x = s.add_f32s(self.left[i], self.right[i]);
        let y = s.add_f32s(self.back[i], self.front[i]);
        let z = s.add_f32s(self.below[i], self.above[i]);
        s.mul_add_f32s(self.lateral, s.add_f32s(x, y), s.mul_f32s(self.vertical, z))
    }
}

/// Loss to the air by convection and radiation.
///
/// Whether surfaces have a resistance is a const generic parameter, so that the common case pays
/// neither for the branch nor for the two divisions.
struct SurfaceLoss<'a, S: Simd, const RESISTANCE: bool> {
    simd: S,
    radiation: [S::f32s; 4],
    convection: S::f32s,
    /// Resistance behind a side, and behind top and bottom.
    resistance: [S::f32s; 2],
    diagonal: &'a [S::f32s],
    exposed_area: &'a [S::f32s],
    top_bottom_area: &'a [S::f32s],
}

impl<'a, S: Simd, const RESISTANCE: bool> SurfaceLoss<'a, S, RESISTANCE> {
    /// For `n` vectors from the flat index `start` on.
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
        // The loss is θ · radiation(θ); its derivative with respect to θ is a cubic polynomial too,
        // with the coefficients 1 r0, 2 r1, 3 r2 and 4 r3.
        let factor = |power: usize| if linearized { (power + 1) as f32 } else { 1.0 };
        Self {
            simd,
            radiation: std::array::from_fn(|power| {
                simd.splat_f32s(factor(power) * coefficients.radiation[power])
            }),
            convection: simd.splat_f32s(coefficients.convection),
            resistance: [side, top_bottom].map(|number| simd.splat_f32s(number)),
            diagonal: &lanes::<S>(&arrays.diagonal, start, len)[..n],
            exposed_area: &lanes::<S>(&arrays.exposed_area, start, len)[..n],
            top_bottom_area: if arrays.top_bottom_area.is_empty() {
                &[]
            } else {
                &lanes::<S>(&arrays.top_bottom_area, start, len)[..n]
            },
        }
    }

    /// The diagonal including surface losses: the factor of the voxel's own θ in its rate, or of
    /// its rate in the linearised equation, where θ is the temperature at which J is taken.
    #[inline(always)]
    fn effective_diagonal(
        &self,
        [diagonal, exposed_area, top_bottom_area]: [S::f32s; 3],
        theta: S::f32s,
    ) -> S::f32s {
        let s = self.simd;
        let [r0, r1, r2, r3] = self.radiation;
        // Horner's scheme.
        let radiated =
            s.mul_add_f32s(s.mul_add_f32s(s.mul_add_f32s(r3, theta, r2), theta, r1), theta, r0);
        if !RESISTANCE {
            // Convection is part of the diagonal.
            return s.negate_mul_add_f32s(radiated, exposed_area, diagonal);
        }
        // h / (1 + h d / k) for sides, and for top and bottom.
        // In the linearised equation, `h` is the derivative of h(θ) θ instead of h.
        // That is not the exact derivative of the fraction, but the difference is small, because h
        // d / k is a few per cent.
        let [side, top_bottom] = self.resistance;
        let h = s.add_f32s(radiated, self.convection);
        let one = s.splat_f32s(1.0);
        let passed =
            |area, resistance| s.div_f32s(s.mul_f32s(h, area), s.mul_add_f32s(h, resistance, one));
        let lost = s.add_f32s(passed(exposed_area, side), passed(top_bottom_area, top_bottom));
        s.sub_f32s(diagonal, lost)
    }

    /// Loads the coefficients of one vector of voxels: diagonal, exposed area, and area of top and
    /// bottom.
    #[inline(always)]
    fn load(&self, i: usize) -> [S::f32s; 3] {
        let top_bottom_area =
            if RESISTANCE { self.top_bottom_area[i] } else { self.simd.splat_f32s(0.0) };
        [self.diagonal[i], self.exposed_area[i], top_bottom_area]
    }

    /// Replaces the values of inactive voxels, whose diagonal is 0, by 0.
    #[inline(always)]
    fn mask_inactive(&self, i: usize, number: S::f32s) -> S::f32s {
        let zero = self.simd.splat_f32s(0.0);
        self.simd.select_f32s(self.simd.less_than_f32s(self.diagonal[i], zero), number, zero)
    }
}

/// The heat equation, or its linearisation, over a range of a plane in vector lanes.
///
/// There are three ways to evaluate it, from the cheapest to the most general: for interior voxels,
/// for voxels that share given coefficients, and for any voxels.
pub(super) struct HeatEquation<'a, S: Simd, const RESISTANCE: bool> {
    coefficients: &'a Coefficients,
    stencil: Stencil<'a, S>,
    surface: SurfaceLoss<'a, S, RESISTANCE>,
}

impl<'a, S: Simd, const RESISTANCE: bool> HeatEquation<'a, S, RESISTANCE> {
    /// The equation over a range that begins at the flat index `start` of the patch; `linearized`
    /// selects J f.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        coefficients: &'a Coefficients,
        arrays: &'a CoefficientArrays,
        planes: PlaneNeighbours<'a>,
        start: usize,
        linearized: bool,
    ) -> Self {
        let stencil = Stencil::new(simd, coefficients, planes);
        let surface =
            SurfaceLoss::new(simd, coefficients, arrays, start, stencil.len(), linearized);
        Self { coefficients, stencil, surface }
    }

    /// Number of vectors in the range.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.stencil.len()
    }

    /// The values to which the equation is applied.
    #[inline(always)]
    pub(super) fn here(&self, i: usize) -> S::f32s {
        self.stencil.here[i]
    }

    /// 0, in a form that the compiler does not recognise as constant: it would turn a loop that
    /// fills a few lines with it into a call of `memset`, which takes longer.
    #[inline(always)]
    pub(super) fn opaque_zero(&self) -> S::f32s {
        self.stencil.simd.sub_f32s(self.stencil.lateral, self.stencil.lateral)
    }

    /// The coefficients of voxels with the given [`crate::coefficients::face`] bits, in all lanes.
    #[inline(always)]
    pub(super) fn uniform_coefficients(&self, faces: u8) -> [S::f32s; 3] {
        let VoxelCoefficients { diagonal, exposed_area, top_bottom_area } =
            self.coefficients.by_faces[usize::from(faces)];
        [diagonal, exposed_area, top_bottom_area].map(|number| self.stencil.simd.splat_f32s(number))
    }

    /// Rate of change of voxels with the given diagonal and no other losses.
    #[inline(always)]
    pub(super) fn rate_inside(&self, i: usize, diagonal: S::f32s) -> S::f32s {
        self.stencil.simd.mul_add_f32s(diagonal, self.stencil.here[i], self.stencil.inflow(i))
    }

    /// Rate of change of active voxels with the given coefficients, whose surfaces have the
    /// temperatures `theta`.
    #[inline(always)]
    pub(super) fn rate_at_surface(
        &self,
        i: usize,
        voxels: [S::f32s; 3],
        theta: S::f32s,
    ) -> S::f32s {
        self.rate_inside(i, self.surface.effective_diagonal(voxels, theta))
    }

    /// Rate of change of any voxels, with the coefficients in memory; 0 for inactive ones.
    #[inline(always)]
    pub(super) fn rate_masked(&self, i: usize, theta: S::f32s) -> S::f32s {
        let rate = self.rate_at_surface(i, self.surface.load(i), theta);
        self.surface.mask_inactive(i, rate)
    }
}
