//! Windows: boxes of a patch that are stepped separately, in shorter steps.
//!
//! A window is a rectangular box, aligned to cache lines in x, so that copies and sweeps work on
//! whole lines.
//! Its outermost voxels are its halo: they hold temperatures of the surrounding patch, interpolated
//! in time ([`Patch::advance_halo`]).

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the vector width of the sweep"
)]

use pulp::{Simd, WithSimd};

use crate::aligned::LINE_LEN;
use crate::kernel::dispatch;
use crate::line_code::LineCode;
use crate::patch::Patch;
use crate::shape::Shape;

/// A box of the part's patch, halo included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    /// x, y and z of its first element in the part's patch; x is a multiple of [`LINE_LEN`].
    pub(super) origin: [usize; 3],
    pub(super) shape: Shape,
}

impl Window {
    /// The smallest window around a box of voxels with margins in x and y, and in z, cut off at the
    /// borders of a patch.
    ///
    /// The box is given by its lowest and its highest voxel, as positions in the part's patch,
    /// whose rows from `top` on are empty.
    pub(super) fn around(
        low: [usize; 3],
        high: [usize; 3],
        margins: [usize; 2],
        patch: &Patch,
        top: usize,
    ) -> Self {
        // Above everything that is printed, or will be in this step, one row of halo suffices.
        let above = top.max(high[2] + 1) + 1;
        let [row_len, planes, rows] = patch.shape.sizes();
        let ends = [
            patch.origin[0] + row_len,
            patch.origin[1] + planes,
            (patch.origin[2] + rows).min(above),
        ];
        let (mut origin, mut size) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            // One more for the halo.
            let margin = margins[axis / 2] + 1;
            let (mut from, mut to) = (low[axis].saturating_sub(margin), high[axis] + margin + 1);
            if axis == 0 {
                (from, to) = (from / LINE_LEN * LINE_LEN, to.next_multiple_of(LINE_LEN));
            }
            origin[axis] = from.max(patch.origin[axis]);
            size[axis] = to.min(ends[axis]) - origin[axis];
        }
        let [row_len, planes, rows] = size;
        Self { origin, shape: Shape { row_len, rows, planes } }
    }

    /// Whether some voxel, halo included, belongs to both windows.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        let (sizes, others) = (self.shape.sizes(), other.shape.sizes());
        (0..3).all(|axis| {
            self.origin[axis] < other.origin[axis] + others[axis]
                && other.origin[axis] < self.origin[axis] + sizes[axis]
        })
    }
}

/// Calls `each` for the first `count` rows of every plane of a window: with the flat index of the
/// row's start in the box around the window, the one in the window itself, and whether the whole
/// row is halo.
#[inline(always)]
fn for_each_row(
    window: Window,
    outer: Window,
    count: usize,
    mut each: impl FnMut(usize, usize, bool),
) {
    let [x, y, z] = [0, 1, 2].map(|axis: usize| window.origin[axis] - outer.origin[axis]);
    let Shape { row_len, rows, planes } = window.shape;
    for plane in 0..planes {
        let halo_plane = plane == 0 || plane == planes - 1;
        let mut in_outer = outer.shape.index([x, y + plane, z]);
        let mut in_window = plane * window.shape.plane_len();
        for row in 0..count {
            each(in_outer, in_window, halo_plane || row == 0 || row == rows - 1);
            in_outer += outer.shape.row_len;
            in_window += row_len;
        }
    }
}

impl Patch {
    fn window(&self) -> Window {
        Window { origin: self.origin, shape: self.shape }
    }

    /// Turns this patch into a copy of a window of another one.
    ///
    /// The halo gets temperatures only.
    /// Rows that lie in the halo as a whole are skipped by sweeps, so their coefficients are
    /// unspecified.
    /// At the ends of all other rows, the coefficients mark the halo voxels as inactive.
    pub(super) fn copy_window(&mut self, window: Window, outer: &Self) {
        let Window { origin, shape } = window;
        let (row_len, len) = (shape.row_len, shape.len());
        (self.shape, self.origin) = (shape, origin);
        self.theta.resize(len);
        let own = &mut self.arrays;
        own.diagonal.resize(len);
        own.exposed_area.resize(len);
        own.top_bottom_area.resize(if outer.arrays.top_bottom_area.is_empty() { 0 } else { len });
        own.lines.resize(len / LINE_LEN, LineCode::EMPTY);
        for_each_row(window, outer.window(), shape.rows, |from, to, halo| {
            self.theta[to..to + row_len].copy_from_slice(&outer.theta[from..from + row_len]);
            if halo {
                return;
            }
            let (own, other) = (&mut self.arrays, &outer.arrays);
            own.exposed_area[to..to + row_len]
                .copy_from_slice(&other.exposed_area[from..from + row_len]);
            if !own.top_bottom_area.is_empty() {
                own.top_bottom_area[to..to + row_len]
                    .copy_from_slice(&other.top_bottom_area[from..from + row_len]);
            }
            let diagonal = &mut own.diagonal[to..to + row_len];
            diagonal.copy_from_slice(&other.diagonal[from..from + row_len]);
            (diagonal[0], diagonal[row_len - 1]) = (0.0, 0.0);
            let lines = &mut own.lines[to / LINE_LEN..(to + row_len) / LINE_LEN];
            lines.copy_from_slice(&other.lines[from / LINE_LEN..(from + row_len) / LINE_LEN]);
            for end in [0, row_len / LINE_LEN - 1] {
                lines[end] = lines[end].not_uniform();
            }
        });
    }

    /// Copies the temperatures inside the halo back into the patch around this window.
    pub(super) fn write_back(&self, outer: &mut Self) {
        let row_len = self.shape.row_len;
        for_each_row(self.window(), outer.window(), self.shape.rows, |to, from, halo| {
            if !halo {
                outer.theta[to + 1..to + row_len - 1]
                    .copy_from_slice(&self.theta[from + 1..from + row_len - 1]);
            }
        });
    }

    /// Moves the temperatures of the halo towards those of the patch around it, by a fraction of
    /// the difference; rows of the part from `top` on are empty.
    pub(super) fn advance_halo(&mut self, outer: &Self, fraction: f32, top: usize) {
        let window = self.window();
        let filled = self.shape.rows.min(top.saturating_sub(self.origin[2]));
        dispatch(AdvanceHalo {
            window,
            around: outer.window(),
            filled,
            own: &mut self.theta,
            outer: &outer.theta,
            fraction,
        });
    }
}

/// Arguments of [`Patch::advance_halo`].
///
/// The loop runs on vector lanes because most voxels of a small window are halo, so that moving
/// them costs about as much as a sweep.
struct AdvanceHalo<'a> {
    window: Window,
    around: Window,
    /// Rows of each plane that contain voxels.
    filled: usize,
    own: &'a mut [f32],
    outer: &'a [f32],
    fraction: f32,
}

impl WithSimd for AdvanceHalo<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { window, around, filled, own, outer, fraction } = self;
        let row_len = window.shape.row_len;
        let fractions = s.splat_f32s(fraction);
        for_each_row(window, around, filled, |from, to, halo| {
            let (own, outer) = (&mut own[to..to + row_len], &outer[from..from + row_len]);
            if halo {
                let outer = S::as_simd_f32s(outer).0;
                for (own, &outer) in S::as_mut_simd_f32s(own).0.iter_mut().zip(outer) {
                    *own = s.mul_add_f32s(fractions, s.sub_f32s(outer, *own), *own);
                }
            } else {
                // A fused multiply-add, as in the vectors above, so that both give the same bits.
                for i in [0, row_len - 1] {
                    own[i] = fraction.mul_add(outer[i] - own[i], own[i]);
                }
            }
        });
    }
}
