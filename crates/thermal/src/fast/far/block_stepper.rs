//! Blocks through a time.
//!
//! Stages of many blocks one after the other would each read them from beyond the second-level
//! cache.
//! So all stages go through the planes together, each as far behind the one before as it needs: the
//! second of a pair by a plane, the next pair by another one.
//! This is wavefront blocking in time (Wellein et al. 2009).

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the processor's lanes"
)]

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::aligned::AlignedBuffer;
use crate::block_grid::BlockGrid;
use crate::kernel::dispatch;

use super::super::chebyshev::Polynomial;
use super::conductances::BlockConductances;

/// What has crossed from a block to another one.
#[derive(Clone, Copy, Debug)]
pub(super) struct BorderFlow {
    pub(super) from: usize,
    pub(super) to: usize,
    /// Conductance, 1/s in voxels.
    pub(super) link: f32,
    /// K in voxels.
    pub(super) sum: f32,
}

/// Memory for the stages.
#[derive(Debug, Default)]
pub(super) struct BlockStepper {
    /// Rates of change, K/s: of the last three planes that each pair of stages has come to.
    slopes: AlignedBuffer,
    /// The crossings in the order of the first plane that they touch, and where those of each plane
    /// begin.
    crossings: Vec<usize>,
    starts: Vec<usize>,
}

impl BlockStepper {
    /// Takes the temperatures of all blocks below some layers through a time, in which they also
    /// change by rates of their own, K/s, and adds what crosses between some of them.
    #[expect(clippy::too_many_arguments, reason = "what is stepped, how, and what is asked of it")]
    pub(super) fn advance(
        &mut self,
        conduction: &BlockConductances,
        w: &mut [f32],
        rates: &[f32],
        seconds: f64,
        block_grid: &BlockGrid,
        layers: usize,
        crossings: &mut [BorderFlow],
    ) {
        let factors = Polynomial::reaching(seconds * f64::from(conduction.max_rate)).factors;
        let factors =
            factors.iter().map(|factor| [factor.a * seconds, factor.b * seconds * seconds]);
        let factors: Vec<_> = factors.map(|factor| factor.map(|number| number as f32)).collect();
        let (row, plane, inner) =
            (block_grid.shape.row, block_grid.shape.plane(), block_grid.shape.planes - 2);
        self.sort(crossings, block_grid);
        let Self { slopes, crossings: order, starts } = self;
        slopes.resize(3 * plane * factors.len());
        let blocks = row..(layers + 1) * row;
        let behind = 2 * (factors.len() - 1);
        for front in 1..=inner + 1 + behind {
            for (i, (&[a, b], slopes)) in
                factors.iter().zip(slopes.chunks_exact_mut(3 * plane)).enumerate()
            {
                let Some(y) = front.checked_sub(2 * i).filter(|y| (1..=inner + 1).contains(y))
                else {
                    continue;
                };
                let slopes = thirds(slopes);
                if y <= inner {
                    let start = y * plane;
                    let field =
                        [start - plane, start, start + plane].map(|start| &w[start..][..plane]);
                    let (added, out) = (&rates[start..][..plane], &mut *slopes[y % 3]);
                    let (blocks, times) = (blocks.clone(), [0.0, 1.0, 1.0]);
                    dispatch(Flow { conduction, field, added, start, row, blocks, times, out });
                }
                if y > 1 {
                    let start = (y - 1) * plane;
                    // In this plane or the next.
                    let slope = |i: usize| match i - start {
                        own if own < plane => slopes[(y - 1) % 3][own],
                        next => slopes[y % 3][next - plane],
                    };
                    for &i in &order[starts[y - 1]..starts[y]] {
                        let BorderFlow { from, to, link, sum } = &mut crossings[i];
                        *sum += *link * (a * (w[*from] - w[*to]) + b * (slope(*from) - slope(*to)));
                    }
                    let field = [y - 2, y - 1, y].map(|y| &*slopes[y % 3]);
                    let (added, out) = (field[1], &mut w[start..][..plane]);
                    let (blocks, times) = (blocks.clone(), [1.0, b, a]);
                    dispatch(Flow { conduction, field, added, start, row, blocks, times, out });
                }
            }
        }
    }

    /// Sorts crossings by their planes.
    fn sort(&mut self, crossings: &[BorderFlow], block_grid: &BlockGrid) {
        let Self { crossings: order, starts, .. } = self;
        let plane =
            |crossing: &BorderFlow| crossing.from.min(crossing.to) / block_grid.shape.plane();
        // First how many there are, then where they end; and once all are in their places, where
        // they start.
        starts.clear();
        starts.resize(block_grid.shape.planes + 1, 0);
        crossings.iter().for_each(|crossing| starts[plane(crossing)] += 1);
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        order.clear();
        order.resize(crossings.len(), 0);
        for (i, crossing) in crossings.iter().enumerate().rev() {
            let start = &mut starts[plane(crossing)];
            *start -= 1;
            order[*start] = i;
        }
    }
}

/// Three planes, one after the other.
fn thirds(planes: &mut [f32]) -> [&mut [f32]; 3] {
    let (first, rest) = planes.split_at_mut(planes.len() / 3);
    let (second, third) = rest.split_at_mut(first.len());
    [first, second, third]
}

/// For some blocks of a plane: so many times what it is, what flows in, and what is added.
struct Flow<'a> {
    conduction: &'a BlockConductances,
    /// Temperatures of the plane behind, of its own and of the one before it.
    field: [&'a [f32]; 3],
    added: &'a [f32],
    /// The index of the plane's first block in the part.
    start: usize,
    /// Blocks of a row.
    row: usize,
    blocks: Range<usize>,
    times: [f32; 3],
    out: &'a mut [f32],
}

impl WithSimd for Flow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { conduction, field: [back, own, front], added, start, row, blocks, times, out } =
            self;
        let (plane, first, n) = (own.len(), blocks.start, blocks.len());
        let (left, here, right) =
            (&own[first - 1..][..n], &own[first..][..n], &own[first + 1..][..n]);
        let (below, above) = (&own[first - row..][..n], &own[first + row..][..n]);
        let (back, front) = (&back[first..][..n], &front[first..][..n]);
        let (added, out) = (&added[first..][..n], &mut out[first..][..n]);
        let start = start + first;
        let [x, y, z] = &conduction.links;
        let (to_left, to_right) = (&x[start - 1..][..n], &x[start..][..n]);
        let (to_back, to_front) = (&y[start - plane..][..n], &y[start..][..n]);
        let (to_below, to_above) = (&z[start - row..][..n], &z[start..][..n]);
        let (losses, share) = (&conduction.losses[start..][..n], &conduction.share[start..][..n]);
        for i in 0..n {
            let own = here[i];
            let in_x = to_left[i] * (left[i] - own) + to_right[i] * (right[i] - own);
            let in_y = to_back[i] * (back[i] - own) + to_front[i] * (front[i] - own);
            let in_z = to_below[i] * (below[i] - own) + to_above[i] * (above[i] - own);
            let flow = (in_x + in_y + in_z - losses[i] * own) * share[i];
            out[i] = times[0] * out[i] + times[1] * flow + times[2] * added[i];
        }
    }
}
