//! Windows into a patch: boxes in which steps are shorter.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the processor's lanes"
)]

use pulp::{Simd, WithSimd};

use crate::aligned::LINE;
use crate::kernel::dispatch;
use crate::patch::{Line, Patch, Shape};

/// A box of the part's patch, rim included.
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
        // Above everything printed, one row of rim suffices.
        let above = top.max(high[2] + 1) + 1;
        let ends =
            [patch.origin[0] + row, patch.origin[1] + planes, (patch.origin[2] + rows).min(above)];
        let (mut origin, mut size) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            let margin = margins[axis / 2] + 1;
            let (mut from, mut to) = (low[axis].saturating_sub(margin), high[axis] + margin + 1);
            if axis == 0 {
                (from, to) = (from / LINE * LINE, to.next_multiple_of(LINE));
            }
            origin[axis] = from.max(patch.origin[axis]);
            size[axis] = to.min(ends[axis]) - origin[axis];
        }
        let [row, planes, rows] = size;
        Some(Self { origin, shape: Shape { row, rows, planes } })
    }
}

/// Calls `each` for rows of a window, so many of each plane: where the row lies in the box around
/// it, where in the window's own, and whether it belongs to the rim.
#[inline(always)]
fn rows(window: Window, outer: Window, count: usize, mut each: impl FnMut(usize, usize, bool)) {
    let [x, y, z] = [0, 1, 2].map(|axis: usize| window.origin[axis] - outer.origin[axis]);
    let Shape { row, rows, planes } = window.shape;
    for plane in 0..planes {
        let rim = plane == 0 || plane == planes - 1;
        let mut from = outer.shape.index([x, y + plane, z]);
        let mut to = plane * window.shape.plane();
        for i in 0..count {
            each(from, to, rim || i == 0 || i == rows - 1);
            from += outer.shape.row;
            to += row;
        }
    }
}

impl Patch {
    fn window(&self) -> Window {
        Window { origin: self.origin, shape: self.shape }
    }

    /// Becomes a copy of a window of another patch; its rim will not change by itself.
    pub(super) fn copy_window(&mut self, window: Window, outer: &Self) {
        let Window { origin, shape } = window;
        let (row, len) = (shape.row, shape.len());
        (self.shape, self.origin) = (shape, origin);
        self.theta.resize(len);
        let own = &mut self.activity;
        own.damping.resize(len);
        own.exposure.resize(len);
        own.caps.resize(if outer.activity.caps.is_empty() { 0 } else { len });
        own.lines.resize(len / LINE, Line::EMPTY);
        rows(window, outer.window(), shape.rows, |from, to, rim| {
            self.theta[to..to + row].copy_from_slice(&outer.theta[from..from + row]);
            if rim {
                return;
            }
            let (own, other) = (&mut self.activity, &outer.activity);
            own.exposure[to..to + row].copy_from_slice(&other.exposure[from..from + row]);
            if !own.caps.is_empty() {
                own.caps[to..to + row].copy_from_slice(&other.caps[from..from + row]);
            }
            // With a damping of 0, the ends of rows count as inactive.
            let damping = &mut own.damping[to..to + row];
            damping.copy_from_slice(&other.damping[from..from + row]);
            (damping[0], damping[row - 1]) = (0.0, 0.0);
            let lines = &mut own.lines[to / LINE..(to + row) / LINE];
            lines.copy_from_slice(&other.lines[from / LINE..(from + row) / LINE]);
            for end in [0, row / LINE - 1] {
                lines[end] = lines[end].cut();
            }
        });
    }

    /// Puts the temperatures inside the rim back into the patch they were copied from.
    pub(super) fn put_back(&self, outer: &mut Self) {
        let row = self.shape.row;
        rows(self.window(), outer.window(), self.shape.rows, |to, from, rim| {
            if !rim {
                outer.theta[to + 1..to + row - 1]
                    .copy_from_slice(&self.theta[from + 1..from + row - 1]);
            }
        });
    }

    /// Moves the temperatures of the rim towards those of the patch around it, by a part of the
    /// difference; rows of the part from `top` on are empty.
    pub(super) fn move_rim(&mut self, outer: &Self, part: f32, top: usize) {
        let window = self.window();
        let filled = self.shape.rows.min(top.saturating_sub(self.origin[2]));
        dispatch(MoveRim {
            window,
            around: outer.window(),
            filled,
            own: &mut self.theta,
            outer: &outer.theta,
            part,
        });
    }
}

/// What [`Patch::move_rim`] does: on wide lanes, as the rim of a small window is most of it.
struct MoveRim<'a> {
    window: Window,
    around: Window,
    /// Rows of each plane in which there is anything.
    filled: usize,
    own: &'a mut [f32],
    outer: &'a [f32],
    part: f32,
}

impl WithSimd for MoveRim<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { window, around, filled, own, outer, part } = self;
        let row = window.shape.row;
        let parts = s.splat_f32s(part);
        rows(window, around, filled, |from, to, rim| {
            let (own, outer) = (&mut own[to..to + row], &outer[from..from + row]);
            if rim {
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
