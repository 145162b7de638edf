//! Two-stage sweeps: choice of the layout, and distribution over threads.

use rayon::prelude::*;

use super::flat::{FlatBuffer, FlatSweep, MAX_FLAT_LEN};
use super::lanes::dispatch;
use super::slab::{Slab, prepare_ring};
use super::stages::{SweepParameters, TwoStageScheme};
use crate::aligned::AlignedBuffer;
use crate::coefficients::Coefficients;
use crate::patch::Patch;

/// Minimum number of elements per thread: with fewer, starting a thread costs more than it saves.
const MIN_THREAD_LEN: usize = 1 << 15;

/// Two stages of an explicit method for all voxels of a patch, in place.
pub(crate) struct TwoStageSweep<'a, T> {
    pub(crate) coefficients: &'a Coefficients,
    pub(crate) patch: &'a mut Patch,
    pub(crate) scheme: T,
    /// Flat index of a voxel that is held at its birth temperature.
    pub(crate) held: Option<usize>,
    /// First row of each plane without a voxel: rows from here on are not changed.
    pub(crate) top: usize,
}

/// Memory of [`TwoStageSweep`], reused from sweep to sweep.
#[derive(Debug)]
pub(crate) struct SweepBuffers {
    pub(super) flat: FlatBuffer,
    /// One ring buffer of intermediate values for each thread.
    pub(super) rings: Vec<AlignedBuffer>,
    /// Copies of the temperatures on both sides of the borders between slabs.
    pub(super) borders: AlignedBuffer,
    /// Number of threads of the current pool that may share a sweep.
    pub(crate) threads: usize,
}

impl Default for SweepBuffers {
    fn default() -> Self {
        Self {
            flat: FlatBuffer::default(),
            rings: Vec::new(),
            borders: AlignedBuffer::default(),
            threads: 1,
        }
    }
}

impl<T: TwoStageScheme> TwoStageSweep<'_, T> {
    /// Takes both stages.
    /// The result does not depend on the number of threads.
    pub(crate) fn sweep(self, buffers: &mut SweepBuffers) {
        let Self { coefficients, patch, scheme, held, top } = self;
        let Patch { shape, arrays, theta, .. } = patch;
        let parameters = SweepParameters { coefficients, shape: *shape, arrays, scheme, held, top };
        if parameters.swept_len() <= MAX_FLAT_LEN {
            parameters.sweep_flat(theta, buffers);
        } else {
            parameters.sweep_slabs(theta, buffers);
        }
        // Sweeps treat the held voxel like any other; its temperature is put back afterwards.
        if let Some(held) = held {
            theta[held] = coefficients.birth_theta;
        }
    }
}

impl<T: TwoStageScheme> SweepParameters<'_, T> {
    /// Number of elements that the sweep changes.
    fn swept_len(self) -> usize {
        (self.top - 1) * self.shape.row_len * (self.shape.planes - 2)
    }

    /// Sweeps a small patch as one flat range.
    pub(super) fn sweep_flat(self, theta: &mut [f32], buffers: &mut SweepBuffers) {
        let ghost = T::ghost_intermediate(self.coefficients);
        let intermediate = buffers.flat.prepare(self.shape, self.top, ghost);
        dispatch(FlatSweep { parameters: self, theta, intermediate });
    }

    /// Sweeps a patch in slabs, one for each thread that has enough to do.
    pub(super) fn sweep_slabs(self, theta: &mut [f32], buffers: &mut SweepBuffers) {
        let (plane_len, planes) = (self.shape.plane_len(), self.shape.planes - 2);
        // Each slab has at least two planes, because its neighbours copy that many.
        let max_threads = (self.swept_len() / MIN_THREAD_LEN).min(planes / 2);
        let threads = buffers.threads.min(max_threads).max(1);
        let rings = &mut buffers.rings;
        rings.resize_with(rings.len().max(threads), AlignedBuffer::default);
        let (before, rest) = theta.split_at_mut(plane_len);
        let (own, after) = rest.split_at_mut(planes * plane_len);
        if threads == 1 {
            let ring = prepare_ring(&self, &mut rings[0]);
            dispatch(Slab { parameters: self, before, own, after, first: 1, ring });
        } else {
            self.sweep_parallel(before, own, after, &mut rings[..threads], &mut buffers.borders);
        }
    }

    /// Sweeps the inside of a patch in parallel, in as many slabs as there are ring buffers.
    fn sweep_parallel(
        self,
        before: &[f32],
        mut inside: &mut [f32],
        after: &[f32],
        rings: &mut [AlignedBuffer],
        borders: &mut AlignedBuffer,
    ) {
        let (count, plane_len) = (rings.len(), self.shape.plane_len());
        let planes = inside.len() / plane_len;
        let ends: Vec<usize> = (0..=count).map(|i| planes * i / count).collect();
        // Copy the two planes on each side of every border while they are still unchanged.
        borders.resize(4 * (count - 1) * plane_len);
        for (border, end) in borders.chunks_exact_mut(4 * plane_len).zip(&ends[1..]) {
            border.copy_from_slice(&inside[(end - 2) * plane_len..(end + 2) * plane_len]);
        }
        let mut slabs = Vec::with_capacity(count);
        for (i, ring) in rings.iter_mut().enumerate() {
            let (own, others) = inside.split_at_mut((ends[i + 1] - ends[i]) * plane_len);
            inside = others;
            // The two planes before and the two planes after border `i`.
            let border =
                |i: usize| borders[4 * i * plane_len..][..4 * plane_len].split_at(2 * plane_len);
            let before = if i == 0 { before } else { border(i - 1).0 };
            let after = if i + 1 == count { after } else { border(i).1 };
            let ring = prepare_ring(&self, ring);
            slabs.push(Slab { parameters: self, before, own, after, first: 1 + ends[i], ring });
        }
        slabs.into_par_iter().for_each(dispatch);
    }
}
