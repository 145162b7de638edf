//! Two stages at once, in place.

#![expect(clippy::inline_always, reason = "see the module above")]

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::flat::{self, Flat};
use super::stages::Stages;
use super::{HeatEquation, LineRuns, PlaneNeighbours, dispatch};
use crate::aligned::AlignedBuffer;
use crate::coefficients::{Coefficients, face};
use crate::patch::{CoefficientArrays, LineKind, Patch, Shape};

/// Numbers that are worth a thread of their own.
const MIN_THREAD_LEN: usize = 1 << 15;

/// Two stages in place.
/// Numbers are kept of three planes only, so that each temperature is read and written once for
/// both.
pub(crate) struct TwoStageSweep<'a, T> {
    pub(crate) coefficients: &'a Coefficients,
    pub(crate) patch: &'a mut Patch,
    pub(crate) stages: T,
    /// A voxel that keeps the temperature of its birth.
    pub(crate) held: Option<usize>,
    /// Rows of each plane from here on are empty, and left alone.
    pub(crate) top: usize,
}

/// Memory for [`TwoStageSweep`].
#[derive(Debug)]
pub(crate) struct SweepBuffers {
    flat: flat::SweepBuffers,
    /// For each thread, three planes of numbers kept, and one of zeros that stands for the halo's.
    slabs: Vec<AlignedBuffer>,
    /// Planes beside the ranges of threads, as they were.
    halo: AlignedBuffer,
    /// How many threads of the current pool may share a sweep.
    pub(crate) threads: usize,
}

impl Default for SweepBuffers {
    fn default() -> Self {
        Self {
            flat: flat::SweepBuffers::default(),
            slabs: Vec::new(),
            halo: AlignedBuffer::default(),
            threads: 1,
        }
    }
}

impl<T: Stages> TwoStageSweep<'_, T> {
    /// Takes both stages.
    /// The result does not depend on the number of threads.
    pub(crate) fn sweep(self, memory: &mut SweepBuffers) {
        let Self { coefficients, patch, stages, held, top } = self;
        let Patch { shape, arrays, theta, .. } = patch;
        let all = Sweep { coefficients, shape: *shape, arrays, stages, held, top };
        if all.size() <= flat::MAX_FLAT_LEN {
            all.flat(theta, memory);
        } else {
            all.slabs(theta, memory);
        }
        if let Some(held) = held {
            theta[held] = coefficients.birth_theta;
        }
    }
}

/// What all parts of a sweep know.
#[derive(Clone, Copy)]
pub(super) struct Sweep<'a, T> {
    pub(super) coefficients: &'a Coefficients,
    pub(super) shape: Shape,
    pub(super) arrays: &'a CoefficientArrays,
    pub(super) stages: T,
    pub(super) held: Option<usize>,
    pub(super) top: usize,
}

impl<T: Stages> Sweep<'_, T> {
    /// Numbers that change.
    fn size(self) -> usize {
        (self.top - 1) * self.shape.row * (self.shape.planes - 2)
    }

    /// As one, with memory for the numbers of all.
    fn flat(self, theta: &mut [f32], memory: &mut SweepBuffers) {
        let kept = memory.flat.of(self.shape, self.top, T::below_plate(self.coefficients));
        dispatch(Flat { all: self, theta, kept });
    }

    /// In as many slabs as there are threads that have enough to do.
    fn slabs(self, theta: &mut [f32], memory: &mut SweepBuffers) {
        let (plane, planes) = (self.shape.plane(), self.shape.planes - 2);
        let threads = memory.threads.min((self.size() / MIN_THREAD_LEN).min(planes / 2)).max(1);
        memory.slabs.resize_with(memory.slabs.len().max(threads), AlignedBuffer::default);
        let (before, rest) = theta.split_at_mut(plane);
        let (own, after) = rest.split_at_mut(planes * plane);
        if threads == 1 {
            let kept = self.fill_halos(&mut memory.slabs[0]);
            dispatch(Slab { all: self, before, own, after, first: 1, kept });
        } else {
            self.split_among_threads(
                before,
                own,
                after,
                &mut memory.slabs[..threads],
                &mut memory.halo,
            );
        }
    }

    /// Shares the inside of a patch out among as many threads as there is memory for.
    fn split_among_threads(
        self,
        before: &[f32],
        mut inside: &mut [f32],
        after: &[f32],
        kept: &mut [AlignedBuffer],
        halo: &mut AlignedBuffer,
    ) {
        let (count, plane) = (kept.len(), self.shape.plane());
        let planes = inside.len() / plane;
        let ends: Vec<usize> = (0..=count).map(|i| planes * i / count).collect();
        // Two planes on each side of every end but the outer ones, as they are now.
        halo.resize(4 * (count - 1) * plane);
        for (halo, end) in halo.chunks_exact_mut(4 * plane).zip(&ends[1..]) {
            halo.copy_from_slice(&inside[(end - 2) * plane..(end + 2) * plane]);
        }
        let mut slabs = Vec::with_capacity(count);
        for (i, kept) in kept.iter_mut().enumerate() {
            let (own, others) = inside.split_at_mut((ends[i + 1] - ends[i]) * plane);
            inside = others;
            let halo = |i: usize| halo[4 * i * plane..][..4 * plane].split_at(2 * plane);
            let before = if i == 0 { before } else { halo(i - 1).0 };
            let after = if i + 1 == count { after } else { halo(i).1 };
            let kept = self.fill_halos(kept);
            slabs.push(Slab { all: self, before, own, after, first: 1 + ends[i], kept });
        }
        slabs.into_par_iter().for_each(dispatch);
    }

    /// Memory for the numbers of a slab, with the rows that are read but never written.
    fn fill_halos(self, kept: &mut AlignedBuffer) -> &mut [f32] {
        let (row, plane) = (self.shape.row, self.shape.plane());
        kept.resize(4 * plane);
        for kept in kept[..3 * plane].chunks_exact_mut(plane) {
            kept[..row].fill(T::below_plate(self.coefficients));
            kept[self.top * row..(self.top + 1) * row].fill(0.0);
        }
        kept[3 * plane..].fill(0.0);
        kept
    }
}

/// A range of planes that is swept by one thread.
struct Slab<'a, T> {
    all: Sweep<'a, T>,
    /// The planes before and after it, as they were: one of halo, or two of another slab's.
    before: &'a [f32],
    own: &'a mut [f32],
    after: &'a [f32],
    /// Its first plane.
    first: usize,
    kept: &'a mut [f32],
}

impl<T: Stages> WithSimd for Slab<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        if self.all.coefficients.resistance.is_some() {
            self.sweep::<S, true>(s)
        } else {
            self.sweep::<S, false>(s)
        }
    }
}

impl<T: Stages> Slab<'_, T> {
    #[inline(always)]
    fn sweep<S: Simd, const RESISTANCE: bool>(self, s: S) {
        let Self { all, before, own, after, first, kept } = self;
        let Sweep { coefficients, shape, arrays, stages, held, top } = all;
        let (row, plane) = (shape.row, shape.plane());
        let (kept, zeros) = kept.split_at_mut(3 * plane);
        let swept = (top - 1) * row;
        let end = first + own.len() / plane;
        let (begin, last) = (first + 1 - before.len() / plane, end + after.len() / plane - 1);
        for y in begin..=end {
            if y < last {
                let theta = |y: usize| {
                    if y < first {
                        &before[before.len() - (first - y) * plane..][..plane]
                    } else if y < end {
                        &own[(y - first) * plane..][..plane]
                    } else {
                        &after[(y - end) * plane..][..plane]
                    }
                };
                let around = PlaneNeighbours::of([y - 1, y, y + 1].map(theta), swept, row);
                let start = y * plane + row;
                let equation = HeatEquation::<S, RESISTANCE>::new(
                    s,
                    coefficients,
                    arrays,
                    around,
                    start,
                    false,
                );
                let here = y % 3 * plane;
                let runs = LineRuns::new::<S>(arrays, start, swept);
                let rows = &mut kept[here + row..][..swept];
                first_stage(s, &equation, runs, stages, rows, true);
                if let Some(held) = held.filter(|held| held / plane == y) {
                    kept[here + held % plane] = T::held(coefficients);
                }
            }
            if y > first {
                let y = y - 1;
                let kept = |y: usize| {
                    let halo = y == 0 || y == shape.planes - 1;
                    if halo { &*zeros } else { &kept[y % 3 * plane..][..plane] }
                };
                let around = PlaneNeighbours::of([y - 1, y, y + 1].map(kept), swept, row);
                let start = y * plane + row;
                let equation = HeatEquation::<S, RESISTANCE>::new(
                    s,
                    coefficients,
                    arrays,
                    around,
                    start,
                    T::LINEARIZED,
                );
                let runs = LineRuns::new::<S>(arrays, start, swept);
                second_stage(
                    s,
                    &equation,
                    runs,
                    stages,
                    &mut own[(y - first) * plane + row..][..swept],
                );
            }
        }
    }
}

/// The numbers kept of one plane; where it has no voxels, they are cleared if another plane's may
/// stand there.
#[inline(always)]
pub(super) fn first_stage<S: Simd, const RESISTANCE: bool>(
    s: S,
    equation: &HeatEquation<'_, S, RESISTANCE>,
    runs: LineRuns<'_>,
    stages: impl Stages,
    kept: &mut [f32],
    clear: bool,
) {
    let n = equation.len();
    let kept = &mut S::as_mut_simd_f32s(kept).0[..n];
    for (line, begin, end) in runs {
        let run = begin..end.min(n);
        match line.kind() {
            LineKind::Empty if !clear => {}
            LineKind::Empty => {
                for i in run {
                    kept[i] = equation.nothing();
                }
            }
            LineKind::Uniform(face::INTERIOR) => {
                let [diagonal, ..] = equation.uniform_voxels(face::INTERIOR);
                for i in run {
                    kept[i] = stages.first(s, equation.here(i), equation.closed(i, diagonal));
                }
            }
            LineKind::Uniform(faces) => {
                let voxels = equation.uniform_voxels(faces);
                for i in run {
                    let here = equation.here(i);
                    kept[i] = stages.first(s, here, equation.open(i, voxels, here));
                }
            }
            LineKind::Mixed => {
                for i in run {
                    let here = equation.here(i);
                    kept[i] = stages.first(s, here, equation.mixed(i, here));
                }
            }
        }
    }
}

/// The temperatures of one plane after both stages, given the numbers kept.
#[inline(always)]
fn second_stage<S: Simd, const RESISTANCE: bool, T: Stages>(
    s: S,
    equation: &HeatEquation<'_, S, RESISTANCE>,
    runs: LineRuns<'_>,
    stages: T,
    theta: &mut [f32],
) {
    let n = equation.len();
    let theta = &mut S::as_mut_simd_f32s(theta).0[..n];
    for (line, begin, end) in runs {
        let run = begin..end.min(n);
        match line.kind() {
            LineKind::Empty => {}
            LineKind::Uniform(face::INTERIOR) => {
                let [diagonal, ..] = equation.uniform_voxels(face::INTERIOR);
                for i in run {
                    let rate = equation.closed(i, diagonal);
                    theta[i] = stages.second(s, theta[i], equation.here(i), rate);
                }
            }
            LineKind::Uniform(faces) => {
                let voxels = equation.uniform_voxels(faces);
                for i in run {
                    let kept = equation.here(i);
                    let rate = equation.open(i, voxels, T::surface::<S>(theta[i], kept));
                    theta[i] = stages.second(s, theta[i], kept, rate);
                }
            }
            LineKind::Mixed => {
                for i in run {
                    let kept = equation.here(i);
                    let rate = equation.mixed(i, T::surface::<S>(theta[i], kept));
                    theta[i] = stages.second(s, theta[i], kept, rate);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::kernel::{EulerSweep, Quadratic, TwoSteps};
    use crate::material::ThermalMaterial;
    use crate::process::ProcessParameters;
    use crate::state::{State, StateMut};

    /// A patch of which a part of the voxels is active, at any temperatures, and perhaps one of
    /// them.
    fn patch(
        size: [usize; 3],
        coefficients: &Coefficients,
        random: &mut Xoshiro256PlusPlus,
    ) -> (Patch, Option<usize>) {
        let mut state = State::empty(Shape::around(size[0], size[1], size[2]), coefficients);
        let StateMut { patch, mut voxels } = state.make_mut();
        let (mut changes, mut active) = (Vec::new(), Vec::new());
        // Full boxes have lines of every kind.
        let filled = if random.random_bool(0.3) { 1.0 } else { random.random_range(0.5..1.0) };
        for z in 1..=size[2] {
            for y in 1..=size[1] {
                for x in (1..=size[0]).filter(|_| random.random_bool(filled)) {
                    voxels.birth([x, y, z], patch, coefficients, &mut changes);
                    patch.apply(&changes, coefficients);
                    changes.clear();
                    active.push(patch.shape.index([x, y, z]));
                }
            }
        }
        active.iter().for_each(|&i| patch.theta[i] = random.random_range(0.0..200.0));
        let held = active.get(active.len() / 2).filter(|_| random.random_bool(0.5));
        (patch.clone(), held.copied())
    }

    fn bits(patch: &Patch) -> Vec<u32> {
        patch.theta.iter().map(|theta| theta.to_bits()).collect()
    }

    fn coefficient_sets() -> [Coefficients; 2] {
        [false, true].map(|surface_resistance| {
            let process = ProcessParameters { surface_resistance, ..ProcessParameters::default() };
            Coefficients::new(&ThermalMaterial::abs(), &process, 0.5e-3, 0.25e-3)
        })
    }

    const HEUN: Quadratic = Quadratic { a: 0.02, b: 0.0002 };
    const TWO_STEPS: TwoSteps = TwoSteps { seconds: 0.02 };

    fn small_patches_agree(stages: impl Stages, random: &mut Xoshiro256PlusPlus) {
        let (coefficient_sets, mut memory) = (coefficient_sets(), SweepBuffers::default());
        for _ in 0..500 {
            let coefficients = &coefficient_sets[random.random_range(0..2)];
            let size = [40, 12, 9].map(|most| random.random_range(1..most));
            let (mut flat, held) = patch(size, coefficients, random);
            let (mut slabs, top) = (flat.clone(), size[2] + 1);
            for _ in 0..3 {
                let sweep =
                    |arrays| Sweep { coefficients, shape: slabs.shape, arrays, stages, held, top };
                sweep(&flat.arrays).flat(&mut flat.theta, &mut memory);
                sweep(&slabs.arrays).slabs(&mut slabs.theta, &mut memory);
            }
            assert_eq!(bits(&flat), bits(&slabs));
        }
    }

    #[test]
    fn small_patches_are_swept_to_the_same_bits() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        small_patches_agree(HEUN, &mut random);
        small_patches_agree(TWO_STEPS, &mut random);
    }

    #[test]
    fn two_steps_are_one_after_another() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        let (coefficient_sets, mut memory) = (coefficient_sets(), SweepBuffers::default());
        for _ in 0..300 {
            let coefficients = &coefficient_sets[random.random_range(0..2)];
            let size = [70, 20, 12].map(|most| random.random_range(1..most));
            let (mut both, held) = patch(size, coefficients, &mut random);
            if let Some(held) = held {
                both.theta[held] = coefficients.birth_theta;
            }
            let (mut single, top) = (both.clone(), size[2] + 1);
            let TwoSteps { seconds } = TWO_STEPS;
            for _ in 0..2 {
                let mut to = single.theta.clone();
                let Patch { shape, arrays, theta: from, .. } = &single;
                dispatch(EulerSweep {
                    coefficients,
                    shape: *shape,
                    arrays,
                    from,
                    to: &mut to,
                    top,
                    seconds,
                });
                if let Some(held) = held {
                    to[held] = coefficients.birth_theta;
                }
                single.theta = to;
            }
            TwoStageSweep { coefficients, patch: &mut both, stages: TWO_STEPS, held, top }
                .sweep(&mut memory);
            assert_eq!(bits(&both), bits(&single));
        }
    }

    fn threads_agree(stages: impl Stages, random: &mut Xoshiro256PlusPlus) {
        let [coefficients, _] = coefficient_sets();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        for size in [[100, 40, 70], [60, 150, 40], [30, 9, 900]] {
            let (patch, held) = patch(size, &coefficients, random);
            let sweep = |mut patch: Patch, threads: usize| {
                let mut memory = SweepBuffers { threads, ..SweepBuffers::default() };
                for _ in 0..3 {
                    let (patch, top) = (&mut patch, size[2] + 1);
                    TwoStageSweep { coefficients: &coefficients, patch, stages, held, top }
                        .sweep(&mut memory);
                }
                (bits(&patch), memory.slabs.len())
            };
            let (alone, one) = sweep(patch.clone(), 1);
            for threads in 2..=5 {
                let (shared, slabs) = pool.install(|| sweep(patch.clone(), threads));
                assert!(one == 1 && slabs > 1, "the part is large enough for two");
                assert_eq!(shared, alone);
            }
        }
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        threads_agree(HEUN, &mut random);
        threads_agree(TWO_STEPS, &mut random);
    }
}
