//! Windows into a patch: boxes in which steps are shorter.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the processor's lanes"
)]

use pulp::{Simd, WithSimd};

use crate::aligned::LINE_LEN;
use crate::kernel::dispatch;
use crate::patch::{LineCode, Patch, Shape};

/// A box of the part's patch, halo included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    /// x, y and z of its first number; x is a multiple of a cache line.
    pub(super) origin: [usize; 3],
    pub(super) shape: Shape,
}

impl Window {
    /// Around voxels of the part's patch, with a margin in x and y and one in z, as far as it lies
    /// inside a patch whose rows from `top` on are empty; `None` if there are no voxels.
    pub(super) fn around(
        voxels: impl Iterator<Item = [usize; 3]>,
        margins: [usize; 2],
        patch: &Patch,
        top: usize,
    ) -> Option<Self> {
        let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
        for at in voxels {
            for axis in 0..3 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        }
        if low[0] == usize::MAX {
            return None;
        }
        let Shape { row, rows, planes } = patch.shape;
        // Above everything printed, one row of halo suffices.
        let above = top.max(high[2] + 1) + 1;
        let ends =
            [patch.origin[0] + row, patch.origin[1] + planes, (patch.origin[2] + rows).min(above)];
        let (mut origin, mut size) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            let margin = margins[axis / 2] + 1;
            let (mut from, mut to) = (low[axis].saturating_sub(margin), high[axis] + margin + 1);
            if axis == 0 {
                (from, to) = (from / LINE_LEN * LINE_LEN, to.next_multiple_of(LINE_LEN));
            }
            origin[axis] = from.max(patch.origin[axis]);
            size[axis] = to.min(ends[axis]) - origin[axis];
        }
        let [row, planes, rows] = size;
        Some(Self { origin, shape: Shape { row, rows, planes } })
    }
}

/// Calls `each` for rows of a window, so many of each plane: where the row lies in the box around
/// it, where in the window's own, and whether it belongs to the halo.
#[inline(always)]
fn rows(window: Window, outer: Window, count: usize, mut each: impl FnMut(usize, usize, bool)) {
    let [x, y, z] = [0, 1, 2].map(|axis: usize| window.origin[axis] - outer.origin[axis]);
    let Shape { row, rows, planes } = window.shape;
    for plane in 0..planes {
        let halo = plane == 0 || plane == planes - 1;
        let mut from = outer.shape.index([x, y + plane, z]);
        let mut to = plane * window.shape.plane();
        for i in 0..count {
            each(from, to, halo || i == 0 || i == rows - 1);
            from += outer.shape.row;
            to += row;
        }
    }
}

impl Patch {
    fn window(&self) -> Window {
        Window { origin: self.origin, shape: self.shape }
    }

    /// Becomes a copy of a window of another patch; its halo will not change by itself.
    pub(super) fn copy_window(&mut self, window: Window, outer: &Self) {
        let Window { origin, shape } = window;
        let (row, len) = (shape.row, shape.len());
        (self.shape, self.origin) = (shape, origin);
        self.theta.resize(len);
        let own = &mut self.arrays;
        own.diagonal.resize(len);
        own.exposed_area.resize(len);
        own.top_bottom_area.resize(if outer.arrays.top_bottom_area.is_empty() { 0 } else { len });
        own.lines.resize(len / LINE_LEN, LineCode::EMPTY);
        rows(window, outer.window(), shape.rows, |from, to, halo| {
            self.theta[to..to + row].copy_from_slice(&outer.theta[from..from + row]);
            if halo {
                return;
            }
            let (own, other) = (&mut self.arrays, &outer.arrays);
            own.exposed_area[to..to + row].copy_from_slice(&other.exposed_area[from..from + row]);
            if !own.top_bottom_area.is_empty() {
                own.top_bottom_area[to..to + row]
                    .copy_from_slice(&other.top_bottom_area[from..from + row]);
            }
            // With a diagonal of 0, the ends of rows count as inactive.
            let diagonal = &mut own.diagonal[to..to + row];
            diagonal.copy_from_slice(&other.diagonal[from..from + row]);
            (diagonal[0], diagonal[row - 1]) = (0.0, 0.0);
            let lines = &mut own.lines[to / LINE_LEN..(to + row) / LINE_LEN];
            lines.copy_from_slice(&other.lines[from / LINE_LEN..(from + row) / LINE_LEN]);
            for end in [0, row / LINE_LEN - 1] {
                lines[end] = lines[end].cut();
            }
        });
    }

    /// Puts the temperatures inside the halo back into the patch they were copied from.
    pub(super) fn put_back(&self, outer: &mut Self) {
        let row = self.shape.row;
        rows(self.window(), outer.window(), self.shape.rows, |to, from, halo| {
            if !halo {
                outer.theta[to + 1..to + row - 1]
                    .copy_from_slice(&self.theta[from + 1..from + row - 1]);
            }
        });
    }

    /// Moves the temperatures of the halo towards those of the patch around it, by a part of the
    /// difference; rows of the part from `top` on are empty.
    pub(super) fn advance_halo(&mut self, outer: &Self, part: f32, top: usize) {
        let window = self.window();
        let filled = self.shape.rows.min(top.saturating_sub(self.origin[2]));
        dispatch(AdvanceHalo {
            window,
            around: outer.window(),
            filled,
            own: &mut self.theta,
            outer: &outer.theta,
            part,
        });
    }
}

/// What [`Patch::advance_halo`] does: on wide lanes, as the halo of a small window is most of it.
struct AdvanceHalo<'a> {
    window: Window,
    around: Window,
    /// Rows of each plane in which there is anything.
    filled: usize,
    own: &'a mut [f32],
    outer: &'a [f32],
    part: f32,
}

impl WithSimd for AdvanceHalo<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { window, around, filled, own, outer, part } = self;
        let row = window.shape.row;
        let parts = s.splat_f32s(part);
        rows(window, around, filled, |from, to, halo| {
            let (own, outer) = (&mut own[to..to + row], &outer[from..from + row]);
            if halo {
                let outer = S::as_simd_f32s(outer).0;
                for (own, &outer) in S::as_mut_simd_f32s(own).0.iter_mut().zip(outer) {
                    *own = s.mul_add_f32s(parts, s.sub_f32s(outer, *own), *own);
                }
            } else {
                for i in [0, row - 1] {
                    own[i] = part.mul_add(outer[i] - own[i], own[i]);
                }
            }
        });
    }
}
