//! Very long steps of the whole part, taken on blocks of voxels.
//!
//! Far from the nozzle temperatures are smooth, and so is their change: it is computed on a grid of blocks of about a
//! cube's shape, as the sum of two parts. What changes at the start of the step is known exactly, from the voxels; how
//! the change slows down as the differences even out is followed on the blocks. For W the mean change of a block since
//! the start, F the mean of its voxels' rates then, and J the conduction between blocks and their losses,
//! dW/dt = F + J W. This W is put back by linear interpolation, and a short step of the voxels evens out what the
//! interpolation leaves. So a step costs a few sweeps, however long it is; multigrid methods call this a correction
//! on the coarse grid (Brandt 1977).
//!
//! Blocks at the part's border may be filled in part: each has the heat capacity of its voxels, and is linked to the next
//! by as many faces as their voxels share (`tally.rs` counts them).

use crate::kernel::{PlaneRates, dispatch};
use crate::law::Law;
use crate::patch::Patch;
use crate::tally::{Block, Tally};

use super::chebyshev::Polynomial;

/// Memory and methods of steps on blocks.
#[derive(Debug, Default)]
pub(super) struct Coarse {
    /// Rates of one plane of voxels.
    plane: Vec<f32>,
    /// Mean rates of the blocks' voxels at the start, K/s.
    rates: Vec<f32>,
    /// Their mean temperatures above the air, K.
    theta: Vec<f32>,
    /// Conductances to the next blocks along x, y and z, and to plate and air, 1/s in voxels.
    links: [Vec<f32>; 3],
    losses: Vec<f32>,
    /// 1 over the number of voxels; 0 for blocks without any.
    share: Vec<f32>,
    /// Change since the start, K.
    change: Vec<f32>,
    /// Its rate.
    slope: Vec<f32>,
}

impl Coarse {
    /// Takes the smooth part of a patch through a time; `top` is where its empty rows begin.
    pub(super) fn step(&mut self, patch: &mut Patch, tally: &Tally, law: &Law, seconds: f64, top: usize) {
        self.restrict(patch, tally, law, top);
        let fastest = self.weigh(tally, law);
        self.evolve(tally, seconds, fastest);
        self.extend(tally, law);
        self.interpolate(patch, tally, top);
    }

    /// Means of the voxels' temperatures and of their rates.
    fn restrict(&mut self, patch: &Patch, tally: &Tally, law: &Law, top: usize) {
        let Self { plane, rates, theta, .. } = self;
        let (fine, coarse) = (patch.shape, tally.shape);
        for numbers in [&mut *rates, theta] {
            numbers.clear();
            numbers.resize(coarse.len(), 0.0);
        }
        plane.resize((top - 1) * fine.row, 0.0);
        let [fold, deep, high] = tally.fold;
        for y in 1..fine.planes - 1 {
            dispatch(PlaneRates { law, patch, y, rates: plane });
            for z in 1..top {
                let own = &plane[(z - 1) * fine.row..][..fine.row];
                let warm = &patch.theta[fine.index([0, y, z])..][..fine.row];
                let block = coarse.index([1, (y - 1) / deep + 1, (z - 1) / high + 1]);
                let sums = rates[block..].iter_mut().zip(&mut theta[block..]);
                let inner = fine.row - 1;
                for ((rate, theta), (own, warm)) in
                    sums.zip(own[1..inner].chunks(fold).zip(warm[1..inner].chunks(fold)))
                {
                    *rate += own.iter().sum::<f32>();
                    *theta += warm.iter().sum::<f32>();
                }
            }
        }
        for ((block, rate), theta) in tally.blocks.iter().zip(rates).zip(theta) {
            if block.voxels > 0 {
                let share = 1.0 / f32::from(block.voxels);
                *rate *= share;
                *theta *= share;
            }
        }
    }

    /// The blocks' conductances; gives the fastest rate at which a difference between them can die out, 1/s.
    fn weigh(&mut self, tally: &Tally, law: &Law) -> f64 {
        let shape = tally.shape;
        let strides = [1, shape.plane(), shape.row];
        // How far a block's voxels reach from a face that it shares with so many of them.
        let reach = |block: &Block, faces: u16, axis: usize| {
            (f32::from(block.voxels) / f32::from(faces)).clamp(1.0, tally.fold[axis] as f32)
        };
        for (axis, stride) in strides.into_iter().enumerate() {
            let conductance = if axis == 2 { law.vertical } else { law.lateral };
            let links = tally.blocks.iter().enumerate().map(|(i, block)| {
                let faces = block.links[axis];
                if faces == 0 {
                    return 0.0;
                }
                let distance = reach(block, faces, axis) + reach(&tally.blocks[i + stride], faces, axis);
                f32::from(faces) * conductance / (0.5 * distance)
            });
            self.links[axis].clear();
            self.links[axis].extend(links);
        }
        self.share.clear();
        let share = |block: &Block| if block.voxels > 0 { 1.0 / f32::from(block.voxels) } else { 0.0 };
        self.share.extend(tally.blocks.iter().map(share));
        self.losses.clear();
        let losses = tally.blocks.iter().zip(&self.theta).map(|(block, &theta)| {
            let plate = if law.plate && block.plate > 0 {
                2.0 * law.vertical * f32::from(block.plate) / reach(block, block.plate, 2)
            } else {
                0.0
            };
            plate + law.air_loss(theta, f32::from(block.sides), f32::from(block.caps))
        });
        self.losses.extend(losses);
        let mut fastest: f32 = 0.0;
        for i in shape.plane()..shape.len() - shape.plane() {
            let out: f32 = (0..3).map(|axis| self.links[axis][i] + self.links[axis][i - strides[axis]]).sum();
            fastest = fastest.max((2.0 * out + self.losses[i]) * self.share[i]);
        }
        f64::from(fastest)
    }

    /// Follows the change of the blocks.
    fn evolve(&mut self, tally: &Tally, seconds: f64, fastest: f64) {
        let len = tally.shape.len();
        for numbers in [&mut self.change, &mut self.slope] {
            numbers.clear();
            numbers.resize(len, 0.0);
        }
        let polynomial = Polynomial::reaching(seconds * fastest);
        let Self { rates, links, losses, share, change, slope, .. } = self;
        let even = Evening { links, losses, share, tally };
        for factor in &polynomial.factors {
            let (a, b) = ((factor.a * seconds) as f32, (factor.b * seconds * seconds) as f32);
            dispatch(|| even.flow(change, slope, |flow, rate| *rate = flow));
            slope.iter_mut().zip(&*rates).for_each(|(slope, rate)| *slope += rate);
            dispatch(|| even.flow(slope, change, |flow, change| *change += b * flow));
            change.iter_mut().zip(&*slope).for_each(|(change, slope)| *change += a * slope);
        }
    }

    /// Gives blocks without voxels the mean change of their neighbours, so that there is something to interpolate towards
    /// beside every block; across the plate, which keeps its temperature, that is the opposite change.
    fn extend(&mut self, tally: &Tally, law: &Law) {
        let shape = tally.shape;
        let (row, plane) = (shape.row, shape.plane());
        let mut known: Vec<bool> = self.share.iter().map(|&share| share > 0.0).collect();
        // Three times: across faces, edges and corners.
        for _ in 0..3 {
            let mut filled = Vec::new();
            for i in (0..shape.len()).filter(|&i| !known[i]) {
                let [x, y, z] = [1, plane, row].map(|stride: usize| [i.wrapping_sub(stride), i + stride]);
                let around = [x, y, z].into_iter().flatten();
                let near = around.filter(|&j| known.get(j) == Some(&true));
                let (sum, count) =
                    near.fold((0.0, 0.0), |(sum, count), j| (sum + self.change[j], count + 1.0));
                if count > 0.0 {
                    filled.push((i, sum / count));
                }
            }
            for (i, change) in filled {
                self.change[i] = change;
                known[i] = true;
            }
        }
        if law.plate {
            for plane in self.change.chunks_exact_mut(plane) {
                let (below, above) = plane.split_at_mut(row);
                below.iter_mut().zip(above).for_each(|(below, above)| *below = -*above);
            }
        }
    }

    /// Adds the blocks' change to their voxels: linear between the blocks' middles, and in the mean of each block the
    /// block's own.
    fn interpolate(&mut self, patch: &mut Patch, tally: &Tally, top: usize) {
        let Patch { shape: fine, activity, theta, .. } = patch;
        let (fine, coarse) = (*fine, tally.shape);
        let [_, deep, high] = tally.fold;
        let (planes, layers) = ((fine.planes - 2).div_ceil(deep), (top - 1).div_ceil(high));
        let mut lines = vec![0.0; deep * high * fine.row];
        let (mut mixed, mut sums) = (vec![0.0; coarse.row], vec![0.0; coarse.row]);
        for (y, z) in (1..=planes).flat_map(|y| (1..=layers).map(move |z| (y, z))) {
            let start = coarse.index([0, y, z]);
            let at = |y: usize, z: usize| &self.change[coarse.index([0, y, z])..][..coarse.row];
            // The part of a line of voxels that a block's neighbour has, and whether that is the one after it.
            let weight = |within: usize, fold: usize| {
                let off = (within as f32 + 0.5) / fold as f32 - 0.5;
                (off.abs(), off > 0.0)
            };
            let next = |block: usize, after: bool| if after { block + 1 } else { block - 1 };
            sums.fill(0.0);
            let voxels = |i: usize| {
                let (within_y, within_z) = (i / high, i % high);
                let place = [0, (y - 1) * deep + within_y + 1, (z - 1) * high + within_z + 1];
                (place[1] < fine.planes - 1 && place[2] < top)
                    .then(|| (fine.index(place), within_y, within_z))
            };
            for (i, line) in lines.chunks_exact_mut(fine.row).enumerate() {
                let Some((first, within_y, within_z)) = voxels(i) else { continue };
                let ((by_y, after_y), (by_z, after_z)) = (weight(within_y, deep), weight(within_z, high));
                let (ny, nz) = (next(y, after_y), next(z, after_z));
                let corners = [at(y, z), at(ny, z), at(y, nz), at(ny, nz)];
                let damping = &activity.damping[first..first + fine.row];
                dispatch(|| {
                    mix(&mut mixed, corners, by_y, by_z);
                    refine(line, &mixed, damping, &mut sums);
                });
            }
            for ((sum, change), share) in sums.iter_mut().zip(at(y, z)).zip(&self.share[start..]) {
                *sum = change - *sum * share;
            }
            for (i, line) in lines.chunks_exact(fine.row).enumerate() {
                let Some((first, ..)) = voxels(i) else { continue };
                let (theta, damping) =
                    (&mut theta[first..][..fine.row], &activity.damping[first..][..fine.row]);
                dispatch(|| add(theta, line, damping, &sums));
            }
        }
    }
}

/// Interpolates between four lines of blocks, in two directions.
#[inline(always)]
#[expect(clippy::inline_always, reason = "to be compiled for the lanes of the processor")]
fn mix(mixed: &mut [f32], [own, beside, over, across]: [&[f32]; 4], by_y: f32, by_z: f32) {
    let n = mixed.len();
    let (own, beside, over, across) = (&own[..n], &beside[..n], &over[..n], &across[..n]);
    for i in 0..n {
        let near = own[i] + by_y * (beside[i] - own[i]);
        let far = over[i] + by_y * (across[i] - over[i]);
        mixed[i] = near + by_z * (far - near);
    }
}

/// Interpolates along a line: two voxels a block, 0 where one is not active. Adds them to the sums of their blocks.
#[inline(always)]
#[expect(clippy::inline_always, reason = "to be compiled for the lanes of the processor")]
fn refine(line: &mut [f32], blocks: &[f32], damping: &[f32], sums: &mut [f32]) {
    let inner = line.len() - 1;
    let voxels = line[1..inner].chunks_exact_mut(2).zip(damping[1..inner].chunks_exact(2));
    for (((line, damping), block), sum) in voxels.zip(blocks.windows(3)).zip(&mut sums[1..]) {
        let left = 0.75 * block[1] + 0.25 * block[0];
        let right = 0.75 * block[1] + 0.25 * block[2];
        line[0] = if damping[0] < 0.0 { left } else { 0.0 };
        line[1] = if damping[1] < 0.0 { right } else { 0.0 };
        *sum += line[0] + line[1];
    }
}

/// Adds a line's changes, and those that its blocks still lack.
#[inline(always)]
#[expect(clippy::inline_always, reason = "to be compiled for the lanes of the processor")]
fn add(theta: &mut [f32], line: &[f32], damping: &[f32], lacking: &[f32]) {
    let inner = line.len() - 1;
    let voxels = theta[1..inner].chunks_exact_mut(2).zip(line[1..inner].chunks_exact(2));
    for (((theta, line), damping), lacking) in
        voxels.zip(damping[1..inner].chunks_exact(2)).zip(&lacking[1..])
    {
        for side in 0..2 {
            theta[side] += line[side] + if damping[side] < 0.0 { *lacking } else { 0.0 };
        }
    }
}

/// How differences between blocks even out.
struct Evening<'a> {
    links: &'a [Vec<f32>; 3],
    losses: &'a [f32],
    share: &'a [f32],
    tally: &'a Tally,
}

impl Evening<'_> {
    /// Calls `each` for all blocks, with what flows into them where `w` is the change, and with their place in `out`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "to be compiled for the lanes of the processor")]
    fn flow(&self, w: &[f32], out: &mut [f32], each: impl Fn(f32, &mut f32)) {
        let shape = self.tally.shape;
        let (row, plane) = (shape.row, shape.plane());
        let (start, n) = (plane + row, shape.len() - 2 * (plane + row));
        let [x, y, z] = self.links;
        let here = &w[start..][..n];
        let (left, right) = (&w[start - 1..][..n], &w[start + 1..][..n]);
        let (back, front) = (&w[start - plane..][..n], &w[start + plane..][..n]);
        let (below, above) = (&w[start - row..][..n], &w[start + row..][..n]);
        let (to_left, to_right) = (&x[start - 1..][..n], &x[start..][..n]);
        let (to_back, to_front) = (&y[start - plane..][..n], &y[start..][..n]);
        let (to_below, to_above) = (&z[start - row..][..n], &z[start..][..n]);
        let (losses, share, out) =
            (&self.losses[start..][..n], &self.share[start..][..n], &mut out[start..][..n]);
        for i in 0..n {
            let own = here[i];
            let in_x = to_left[i] * (left[i] - own) + to_right[i] * (right[i] - own);
            let in_y = to_back[i] * (back[i] - own) + to_front[i] * (front[i] - own);
            let in_z = to_below[i] * (below[i] - own) + to_above[i] * (above[i] - own);
            each((in_x + in_y + in_z - losses[i] * own) * share[i], &mut out[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::kernel::{Pair, Rates};
    use crate::material::Material;
    use crate::patch::Shape;
    use crate::process::Process;
    use crate::state::State;

    /// A block of voxels at temperatures above the air; nothing is lost.
    fn insulated(size: [usize; 3], theta: impl Fn([usize; 3]) -> f64) -> (State, Law) {
        let material = Material { emissivity: 0.0, ..Material::abs() };
        let process = Process { plate_c: None, convection_w_m2k: 0.0, ..Process::default() };
        let law = Law::new(&material, &process, 0.5e-3, 0.25e-3);
        let mut state = State::empty(Shape::around(size[0], size[1], size[2]), &law);
        let mut changes = Vec::new();
        let state_mut = state.make_mut();
        let mut voxels = state_mut.voxels;
        for z in 1..=size[2] {
            for y in 1..=size[1] {
                for x in 1..=size[0] {
                    voxels.birth([x, y, z], state_mut.patch, &law, &mut changes);
                    let index = state_mut.patch.shape.index([x, y, z]);
                    state_mut.patch.take_up(&changes, &law);
                    changes.clear();
                    state_mut.patch.theta[index] = theta([x, y, z]) as f32;
                }
            }
        }
        (state, law)
    }

    fn heat(state: &State) -> f64 {
        state.patch.theta.iter().map(|&theta| f64::from(theta)).sum()
    }

    #[test]
    fn a_smooth_difference_evens_out_as_it_does_in_short_steps() {
        // The slowest mode of a bar along each axis in turn, blocks at whose ends are filled in part.
        let size = [31, 27, 30];
        for axis in 0..3 {
            let length = size[axis] as f64;
            let mode = |at: [usize; 3]| 100.0 + 20.0 * (PI * (at[axis] as f64 - 0.5) / length).cos();
            let (mut long, law) = insulated(size, mode);
            let mut short = long.clone();
            let (seconds, before) = (15.0, heat(&long));
            let top = long.top;
            let long_mut = long.make_mut();
            Coarse::default().step(long_mut.patch, long_mut.voxels.tally(), &law, seconds, top);
            let dt = 0.05;
            let mut memory = Rates::default();
            for _ in 0..(seconds / dt).round() as usize {
                let patch = short.make_mut().patch;
                let rates = memory.of(patch.shape, top);
                let (a, b) = (dt as f32, (dt * dt / 2.0) as f32);
                dispatch(Pair { law: &law, patch, rates, a, b, held: None, top });
            }
            let error = long.patch.theta.iter().zip(short.patch.theta.iter());
            let error = error.map(|(long, short)| (long - short).abs()).fold(0.0, f32::max);
            // Second order in the blocks' size: of the mode along z, whose bar is seven blocks long, this is the most.
            assert!(error < [0.02, 0.03, 0.45][axis], "axis {axis}: {error}");
            let lost = heat(&long) / before - 1.0;
            assert!(lost.abs() < 3e-6, "axis {axis}: {lost} of the heat is lost");
        }
    }
}
