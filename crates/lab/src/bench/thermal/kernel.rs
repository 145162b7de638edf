//! Speed of the sweep over a static block, compared with the memory traffic that it causes.
//!
//! The explicit scheme moves 12 bytes for every voxel that it updates, as many as the STREAM triad
//! `a = b + x c` moves for every element.
//! The rate of the triad in the same cache is therefore the rate of updates that only memory would
//! limit.

use std::fmt;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_console::{control, progress};
use beadwork_part::Pattern;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{Simulation, ThermalMaterial};
use pulp::{Simd, WithSimd};
use serde::Serialize;

use super::printing::process;
use crate::heat_parts::{HeatPart, orders};
use crate::statistics::median;

/// Elements of each of the triad's three arrays: together they occupy about as much memory as the
/// two arrays of the block.
const TRIAD: usize = 50_000;

/// Single-precision numbers in a cache line.
const LINE: usize = 16;

/// Steps of the simulation, and passes of the triad, in one timed run.
const STEPS: usize = 4_000;

/// Rates, in 10⁹ per second.
#[derive(Serialize)]
pub(super) struct Kernel {
    /// Elements per second of the triad, whose arrays fit in the second-level cache.
    triad_g_per_s: f64,
    /// Updates of voxels per second by the explicit scheme, on the rectangular part after its last
    /// deposition.
    updates_g_per_s: f64,
    /// Updates relative to the triad: median of the ratios of each run.
    share: f64,
}

/// Measures both rates alternately, at least five times.
pub(super) fn measure(repeats: u64) -> anyhow::Result<Kernel> {
    let control = control::cancellable(Threads::One)?;
    let mut simulation = printed_block(&control)?;
    let voxels = simulation.part().count();
    let step_s = simulation.part().frame.cell_mm / process().print_mm_s;
    let [mut a, mut b, mut c] = [0.0, 1.0, 2.0].map(|number| vec![number; TRIAD + LINE]);
    let [a, b, c] = [&mut a, &mut b, &mut c].map(|numbers| aligned(numbers));
    let (mut triads, mut updates, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    let repeats = repeats.max(5);
    let bar = progress::bar(repeats, "sweeps of a static block");
    for _ in 0..repeats {
        let begin = Instant::now();
        for _ in 0..STEPS {
            pulp::Arch::new().dispatch(Triad { a, b, c });
            black_box(&mut *a);
        }
        let triad = giga_per_second(TRIAD * STEPS, begin);
        let begin = Instant::now();
        simulation.pause(step_s * STEPS as f64, &control)?;
        let update = giga_per_second(voxels * STEPS, begin);
        triads.push(triad);
        updates.push(update);
        shares.push(update / triad);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Kernel {
        triad_g_per_s: median(triads),
        updates_g_per_s: median(updates),
        share: median(shares),
    })
}

/// The rectangular part with all its voxels deposited, by the explicit scheme.
fn printed_block(control: &Control<'_>) -> anyhow::Result<Simulation> {
    let part = Arc::new(HeatPart::Rectangular.voxels());
    let orders = orders(&part, Pattern::CONVENTIONAL)?;
    let mut simulation = Simulation::new(part, &ThermalMaterial::abs(), &process(), Method::Naive)?;
    for (layer, order) in orders.iter().enumerate() {
        simulation.deposit(layer as u32, order, control)?;
    }
    Ok(simulation)
}

/// The [`TRIAD`] numbers that begin at the first boundary of a cache line.
fn aligned(numbers: &mut [f32]) -> &mut [f32] {
    let start = numbers.as_ptr().align_offset(4 * LINE).min(LINE);
    &mut numbers[start..start + TRIAD]
}

/// One pass over the arrays: `a = b + 0.5 c`.
///
/// It is a type because pulp compiles only implementations of [`WithSimd`] for the widest lanes of
/// the processor, not closures.
struct Triad<'a> {
    a: &'a mut [f32],
    b: &'a [f32],
    c: &'a [f32],
}

impl WithSimd for Triad<'_> {
    type Output = ();

    #[expect(
        clippy::inline_always,
        reason = "only inlined code is compiled for the processor's lanes"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let half = simd.splat_f32s(0.5);
        let a = S::as_mut_simd_f32s(self.a).0;
        let [b, c] = [self.b, self.c].map(|numbers| S::as_simd_f32s(numbers).0);
        for ((a, &b), &c) in a.iter_mut().zip(b).zip(c) {
            *a = simd.mul_add_f32s(half, c, b);
        }
    }
}

/// 10⁹ items per second, where `items` were processed since `begin`.
fn giga_per_second(items: usize, begin: Instant) -> f64 {
    items as f64 / begin.elapsed().as_secs_f64() / 1e9
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| triad, 10⁹/s | updates of a static block, 10⁹/s | share |\n|---|---|---|")?;
        let Self { triad_g_per_s, updates_g_per_s, share } = self;
        writeln!(f, "| {triad_g_per_s:.2} | {updates_g_per_s:.2} | {:.0} % |", 100.0 * share)
    }
}
