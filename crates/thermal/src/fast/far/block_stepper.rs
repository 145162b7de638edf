//! Time steps of the blocks.
//!
//! A step of any length is one stability polynomial of a sufficient degree (`fast/chebyshev.rs`),
//! in quadratic factors of two stages each.
//!
//! Running the stages one after the other would load all blocks from beyond the second-level cache
//! in every stage.
//! So all stages pass through the planes together (wavefront blocking in time; Wellein et al.,
//! COMPSAC 2009).
//! The second stage of a factor needs the rates of the next plane, so it is one plane behind the
//! first; the next factor needs temperatures of the next plane after both stages, so it is another
//! plane behind:
//!
//! ```text
//! front (plane of the first stage of factor 0)     y
//! factor 0:  first stage at y,      second stage at y - 1
//! factor 1:  first stage at y - 2,  second stage at y - 3
//! factor i:  first stage at y - 2i, second stage at y - 2i - 1
//! ```
//!
//! Rates exist for three planes per factor, in ring buffers; temperatures are updated in place.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the vector width of the sweep"
)]

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::aligned::AlignedBuffer;
use crate::block_grid::BlockGrid;
use crate::kernel::dispatch;

use super::super::chebyshev::{Factor, Polynomial};
use super::conductances::BlockConductances;

/// Heat that crosses from one block to a neighbouring one.
#[derive(Clone, Copy, Debug)]
pub(super) struct BorderFlow {
    pub(super) from: usize,
    pub(super) to: usize,
    /// Conductance, voxels/s.
    pub(super) link: f32,
    /// Heat that has crossed so far, K voxels.
    pub(super) sum: f32,
}

/// Memory for steps of the blocks, reused from step to step.
#[derive(Debug, Default)]
pub(super) struct BlockStepper {
    /// Rates of change, K/s: a ring buffer of three planes for each factor.
    rates: AlignedBuffer,
    /// Indices of the flows, sorted by the lower plane of the two that each touches.
    order: Vec<usize>,
    /// For each plane, the position in `order` of its first flow.
    starts: Vec<usize>,
}

impl BlockStepper {
    /// Steps the temperatures of all blocks in the lowest `layers` layers through a time, and adds
    /// up the heat that crosses between some pairs of blocks.
    ///
    /// `sources` are constant rates of change, K/s.
    /// Flows must be between neighbouring blocks.
    #[expect(clippy::too_many_arguments, reason = "the equation, the step, and its outputs")]
    pub(super) fn advance(
        &mut self,
        conductances: &BlockConductances,
        theta: &mut [f32],
        sources: &[f32],
        seconds: f64,
        block_grid: &BlockGrid,
        layers: usize,
        flows: &mut [BorderFlow],
    ) {
        let polynomial = Polynomial::for_stability(seconds * f64::from(conductances.max_rate));
        let scaled = |factor: &Factor| {
            [factor.a * seconds, factor.b * seconds * seconds].map(|number| number as f32)
        };
        let factors: Vec<_> = polynomial.factors.iter().map(scaled).collect();
        let shape = block_grid.shape;
        let (row_len, plane_len, planes) = (shape.row_len, shape.plane_len(), shape.planes - 2);
        self.sort(flows, block_grid);
        let Self { rates, order, starts } = self;
        // Old values in the ring buffers do no harm: a stage reads a plane that was not written in
        // this step only where that plane is halo, and the conductance to a halo block is 0.
        rates.resize(3 * plane_len * factors.len());
        let blocks = row_len..(layers + 1) * row_len;
        let delay = 2 * (factors.len() - 1);
        for front in 1..=planes + 1 + delay {
            // In the order of the factors: a factor reads what the one before has just written.
            for (i, (&[a, b], rates)) in
                factors.iter().zip(rates.chunks_exact_mut(3 * plane_len)).enumerate()
            {
                let y = front.checked_sub(2 * i).filter(|y| (1..=planes + 1).contains(y));
                let Some(y) = y else { continue };
                let rates = thirds(rates);
                if y <= planes {
                    // First stage: rate = J θ + s.
                    let start = y * plane_len;
                    let field = [start - plane_len, start, start + plane_len]
                        .map(|start| &theta[start..][..plane_len]);
                    let added = &sources[start..][..plane_len];
                    let (blocks, weights) = (blocks.clone(), [0.0, 1.0, 1.0]);
                    let out = &mut *rates[y % 3];
                    dispatch(PlaneSweep {
                        conductances,
                        field,
                        added,
                        start,
                        row_len,
                        blocks,
                        weights,
                        out,
                    });
                }
                if y > 1 {
                    // Second stage, one plane behind: θ = θ + b J rate + a rate.
                    let start = (y - 1) * plane_len;
                    // In this factor, a link carries its conductance times the difference of a θ +
                    // b rate between its blocks: exactly what the link contributes to the change of
                    // θ below.
                    // Both blocks lie in this plane or the next, whose temperatures this factor has
                    // not changed yet.
                    let rate = |i: usize| match i - start {
                        own if own < plane_len => rates[(y - 1) % 3][own],
                        next => rates[y % 3][next - plane_len],
                    };
                    for &i in &order[starts[y - 1]..starts[y]] {
                        let BorderFlow { from, to, link, sum } = &mut flows[i];
                        *sum += *link
                            * (a * (theta[*from] - theta[*to]) + b * (rate(*from) - rate(*to)));
                    }
                    let field = [y - 2, y - 1, y].map(|y| &*rates[y % 3]);
                    let (added, out) = (field[1], &mut theta[start..][..plane_len]);
                    let (blocks, weights) = (blocks.clone(), [1.0, b, a]);
                    dispatch(PlaneSweep {
                        conductances,
                        field,
                        added,
                        start,
                        row_len,
                        blocks,
                        weights,
                        out,
                    });
                }
            }
        }
    }

    /// Sorts flows by the lower plane of the two that each touches: a counting sort, which is
    /// stable and linear.
    fn sort(&mut self, flows: &[BorderFlow], block_grid: &BlockGrid) {
        let Self { order, starts, .. } = self;
        let plane = |flow: &BorderFlow| flow.from.min(flow.to) / block_grid.shape.plane_len();
        // `starts` first counts the flows of each plane; cumulative sums turn the counts into ends.
        // Filling in the flows from the back moves each end down to the start.
        starts.clear();
        starts.resize(block_grid.shape.planes + 1, 0);
        flows.iter().for_each(|flow| starts[plane(flow)] += 1);
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        order.clear();
        order.resize(flows.len(), 0);
        for (i, flow) in flows.iter().enumerate().rev() {
            let start = &mut starts[plane(flow)];
            *start -= 1;
            order[*start] = i;
        }
    }
}

/// Splits a ring buffer into its three planes.
fn thirds(planes: &mut [f32]) -> [&mut [f32]; 3] {
    let (first, rest) = planes.split_at_mut(planes.len() / 3);
    let (second, third) = rest.split_at_mut(first.len());
    [first, second, third]
}

/// One stage for some blocks of a plane: out = w0 out + w1 J field + w2 added, with weights w.
struct PlaneSweep<'a> {
    conductances: &'a BlockConductances,
    /// The planes at y - 1, y and y + 1 of the field to which conduction and losses, J, are
    /// applied.
    field: [&'a [f32]; 3],
    added: &'a [f32],
    /// Flat index of the plane's first block in the block grid.
    start: usize,
    row_len: usize,
    /// Range of blocks within the plane.
    blocks: Range<usize>,
    weights: [f32; 3],
    out: &'a mut [f32],
}

impl WithSimd for PlaneSweep<'_> {
    type Output = ();

    /// A plain loop over slices of one length, which the compiler vectorises for the instruction
    /// set that is enabled here.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { conductances, field, added, start, row_len, blocks, weights, out } = self;
        let [back, own, front] = field;
        let (plane_len, first, n) = (own.len(), blocks.start, blocks.len());
        let (left, here, right) =
            (&own[first - 1..][..n], &own[first..][..n], &own[first + 1..][..n]);
        let (below, above) = (&own[first - row_len..][..n], &own[first + row_len..][..n]);
        let (back, front) = (&back[first..][..n], &front[first..][..n]);
        let (added, out) = (&added[first..][..n], &mut out[first..][..n]);
        // A link is stored at the lower block of its pair, so those to the left, back and below are
        // shifted by one block.
        let start = start + first;
        let [x, y, z] = &conductances.links;
        let (to_left, to_right) = (&x[start - 1..][..n], &x[start..][..n]);
        let (to_back, to_front) = (&y[start - plane_len..][..n], &y[start..][..n]);
        let (to_below, to_above) = (&z[start - row_len..][..n], &z[start..][..n]);
        let losses = &conductances.losses[start..][..n];
        let inverse_voxels = &conductances.inverse_voxels[start..][..n];
        for i in 0..n {
            // Differences are multiplied by links, for two reasons: a link to an empty block is 0
            // and adds nothing, whatever value the block has; and both sides of a link see the same
            // flow.
            let own = here[i];
            let in_x = to_left[i] * (left[i] - own) + to_right[i] * (right[i] - own);
            let in_y = to_back[i] * (back[i] - own) + to_front[i] * (front[i] - own);
            let in_z = to_below[i] * (below[i] - own) + to_above[i] * (above[i] - own);
            let flow = (in_x + in_y + in_z - losses[i] * own) * inverse_voxels[i];
            out[i] = weights[0] * out[i] + weights[1] * flow + weights[2] * added[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::super::region::{BorderPair, Region};
    use super::super::testing::{positions, random_region, random_state};
    use super::*;

    /// A step without wavefront blocking: one stage after the other, each for all blocks.
    fn advance_stage_by_stage(
        conductances: &BlockConductances,
        theta: &mut [f32],
        sources: &[f32],
        seconds: f64,
        block_grid: &BlockGrid,
        layers: usize,
        flows: &mut [BorderFlow],
    ) {
        let [sx, sy, sz] = block_grid.strides();
        let [x, y, z] = &conductances.links;
        let rate_of = |field: &[f32], i: usize| {
            let to = |link: f32, next: usize| link * (field[next] - field[i]);
            let in_x = to(x[i - sx], i - sx) + to(x[i], i + sx);
            let in_y = to(y[i - sy], i - sy) + to(y[i], i + sy);
            let in_z = to(z[i - sz], i - sz) + to(z[i], i + sz);
            let lost = conductances.losses[i] * field[i];
            (in_x + in_y + in_z - lost) * conductances.inverse_voxels[i]
        };
        let shape = block_grid.shape;
        let all: Vec<_> = positions([shape.row_len - 2, shape.planes - 2, layers])
            .map(|position| shape.index(position))
            .collect();
        let polynomial = Polynomial::for_stability(seconds * f64::from(conductances.max_rate));
        for factor in &polynomial.factors {
            let [a, b] =
                [factor.a * seconds, factor.b * seconds * seconds].map(|number| number as f32);
            let mut rates = vec![0.0; theta.len()];
            all.iter().for_each(|&i| rates[i] = rate_of(theta, i) + sources[i]);
            for BorderFlow { from, to, link, sum } in &mut *flows {
                *sum += *link * (a * (theta[*from] - theta[*to]) + b * (rates[*from] - rates[*to]));
            }
            all.iter().for_each(|&i| theta[i] = theta[i] + b * rate_of(&rates, i) + a * rates[i]);
        }
    }

    #[test]
    fn wavefront_steps_equal_steps_stage_by_stage() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
        // Reused from case to case, as it is from step to step.
        let mut stepper = BlockStepper::default();
        for _ in 0..1000 {
            let (state, coefficients) = random_state(&mut random);
            let (block_grid, top) = (state.occupancy.block_grid(), state.top);
            let (len, layers) = (block_grid.shape.len(), block_grid.layers_below(top));
            let whole = Region::whole(block_grid, top);
            let mut theta: Vec<f32> = vec![0.0; len];
            let mut sources = theta.clone();
            for i in whole.blocks(block_grid).filter(|&i| block_grid.blocks[i].voxels > 0) {
                (theta[i], sources[i]) =
                    (random.random_range(0.0..200.0), random.random_range(-5.0..5.0));
            }
            let mut conductances = BlockConductances::default();
            conductances.reset(len);
            conductances.update(whole, block_grid, &coefficients, &theta);
            let (region, _) = random_region(&mut random, &state);
            let flow = |pair: BorderPair| {
                let link = conductances.links[pair.axis][pair.lower()];
                BorderFlow { from: pair.inside, to: pair.outside, link, sum: 0.0 }
            };
            let flows: Vec<_> = region.border(block_grid).map(flow).collect();
            let seconds = 10.0_f64.powf(random.random_range(-2.0..1.5));
            let mut both = [theta.clone(), theta].map(|theta| (theta, flows.clone()));
            let [(theta, flows), (slow_theta, slow_flows)] = &mut both;
            stepper.advance(&conductances, theta, &sources, seconds, block_grid, layers, flows);
            advance_stage_by_stage(
                &conductances,
                slow_theta,
                &sources,
                seconds,
                block_grid,
                layers,
                slow_flows,
            );
            assert_eq!(theta, slow_theta);
            let sums = |flows: &[BorderFlow]| flows.iter().map(|flow| flow.sum).collect::<Vec<_>>();
            assert_eq!(sums(flows), sums(slow_flows));
        }
    }
}
