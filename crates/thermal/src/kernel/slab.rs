//! Two-stage sweeps of a range of planes, with wavefront blocking.
//!
//! Running one stage over the whole patch and then the other would load every temperature twice,
//! and need a second array as large as the first for the intermediate values.
//! Here both stages pass through the planes together (temporal blocking): the second stage is one
//! plane behind the first, and intermediate values exist for three planes only.
//!
//! ```text
//! plane           y-3    y-2    y-1     y     y+1
//! temperatures    new    new    old    old    old
//! intermediate    (-)    ready  ready  ready
//!                               ^      ^
//!                               |      first stage: reads old temperatures of y-1, y, y+1
//!                               second stage: reads intermediate values of y-2, y-1, y,
//!                                             overwrites temperatures of y-1
//! ```
//!
//! The update is in place: when the second stage overwrites plane y-1, no later first stage reads
//! the old temperatures of that plane any more.
//! The intermediate values of plane y are in a ring buffer, in slot y mod 3.

#![expect(clippy::inline_always, reason = "see kernel/lanes.rs")]

use pulp::{Simd, WithSimd};

use super::equation::{HeatEquation, PlaneNeighbours};
use super::runs::{LineRuns, first_stage, second_stage};
use super::stages::{SweepParameters, TwoStageScheme};
use crate::aligned::AlignedBuffer;

/// A range of planes that one thread sweeps.
///
/// At a border with another slab, the second stage needs the intermediate values of the plane next
/// to the slab, and these need the old temperatures of two planes.
/// The other thread overwrites them meanwhile, so both come as copies, and both threads compute the
/// intermediate values next to the border (redundant computation in place of synchronisation).
pub(super) struct Slab<'a, T> {
    pub(super) parameters: SweepParameters<'a, T>,
    /// Old temperatures of the planes before the slab: the halo plane of the patch, or copies of
    /// the last two planes of another slab.
    pub(super) before: &'a [f32],
    /// Temperatures of the slab, updated in place.
    pub(super) own: &'a mut [f32],
    /// Old temperatures of the planes after the slab, likewise one or two planes.
    pub(super) after: &'a [f32],
    /// y of the slab's first plane in the patch.
    pub(super) first: usize,
    /// From [`prepare_ring`].
    pub(super) ring: &'a mut [f32],
}

/// Prepares the memory of a slab: a ring buffer of three planes of intermediate values, and a
/// fourth plane of zeros, which stands in for the halo planes of the patch.
///
/// Sets the rows that the stencil reads but the first stage does not write: the ghosts of the build
/// plate in row 0, and zeros in the first empty row.
pub(super) fn prepare_ring<'a, T: TwoStageScheme>(
    parameters: &SweepParameters<'_, T>,
    ring: &'a mut AlignedBuffer,
) -> &'a mut [f32] {
    let (row_len, plane_len) = (parameters.shape.row_len, parameters.shape.plane_len());
    let top = parameters.top;
    ring.resize(4 * plane_len);
    for plane in ring[..3 * plane_len].chunks_exact_mut(plane_len) {
        plane[..row_len].fill(T::ghost_intermediate(parameters.coefficients));
        plane[top * row_len..(top + 1) * row_len].fill(0.0);
    }
    ring[3 * plane_len..].fill(0.0);
    ring
}

impl<T: TwoStageScheme> WithSimd for Slab<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        if self.parameters.coefficients.resistance.is_some() {
            self.sweep::<S, true>(s);
        } else {
            self.sweep::<S, false>(s);
        }
    }
}

impl<T: TwoStageScheme> Slab<'_, T> {
    #[inline(always)]
    fn sweep<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { parameters, before, own, after, first, ring } = self;
        let SweepParameters { coefficients, shape, arrays, scheme, held, top } = parameters;
        let (row_len, plane_len) = (shape.row_len, shape.plane_len());
        let (ring, zeros) = ring.split_at_mut(3 * plane_len);
        // Row 0 is halo; the printed rows follow it.
        let swept = (top - 1) * row_len;
        // The slab is `first..end`; intermediate values are computed for `begin..last`, which is
        // one plane more on each side that borders on another slab.
        let end = first + own.len() / plane_len;
        let begin = first + 1 - before.len() / plane_len;
        let last = end + after.len() / plane_len - 1;
        for y in begin..=end {
            if y < last {
                let theta = |y: usize| {
                    if y < first {
                        &before[before.len() - (first - y) * plane_len..][..plane_len]
                    } else if y < end {
                        &own[(y - first) * plane_len..][..plane_len]
                    } else {
                        &after[(y - end) * plane_len..][..plane_len]
                    }
                };
                let planes = [y - 1, y, y + 1].map(theta);
                let planes = PlaneNeighbours::from_planes(planes, swept, row_len);
                let start = y * plane_len + row_len;
                let equation = HeatEquation::<S, RESISTANCE>::new(
                    s,
                    coefficients,
                    arrays,
                    planes,
                    start,
                    false,
                );
                let slot = y % 3 * plane_len;
                let runs = LineRuns::new::<S>(arrays, start, swept);
                let rows = &mut ring[slot + row_len..][..swept];
                // Empty lines must be cleared: the slot held another plane, with other voxels.
                first_stage(s, &equation, runs, scheme, rows, true);
                if let Some(held) = held.filter(|held| held / plane_len == y) {
                    ring[slot + held % plane_len] = T::held_intermediate(coefficients);
                }
            }
            if y > first {
                let y = y - 1;
                let intermediate = |y: usize| {
                    let halo = y == 0 || y == shape.planes - 1;
                    if halo { &*zeros } else { &ring[y % 3 * plane_len..][..plane_len] }
                };
                let planes = [y - 1, y, y + 1].map(intermediate);
                let planes = PlaneNeighbours::from_planes(planes, swept, row_len);
                let start = y * plane_len + row_len;
                let equation = HeatEquation::<S, RESISTANCE>::new(
                    s,
                    coefficients,
                    arrays,
                    planes,
                    start,
                    T::LINEARIZED,
                );
                let runs = LineRuns::new::<S>(arrays, start, swept);
                let rows = &mut own[(y - first) * plane_len + row_len..][..swept];
                second_stage(s, &equation, runs, scheme, rows);
            }
        }
    }
}
