//! The sweep of a static block, beside the memory that it moves.

use std::fmt;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use beadwork_base::Control;
use beadwork_part::Pattern;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{Simulation, ThermalMaterial};
use pulp::{Simd, WithSimd};
use serde::Serialize;

use super::process;
use crate::bench::middle;
use crate::heat_parts::{HeatPart, orders};

/// Numbers in each of the triad's three arrays: together they fill about as much memory as the
/// block's two.
const TRIAD: usize = 50_000;

/// Numbers in a cache line.
const LINE: usize = 16;

/// Rates in 10⁹ a second.
#[derive(Serialize)]
pub(super) struct Kernel {
    /// The sum of one array and a multiple of another into a third, within the second-level cache:
    /// 12 bytes each, as many as an update moves.
    triad_g_per_s: f64,
    /// Voxels of the rectangular part, all of them deposited, in explicit steps.
    updates_g_per_s: f64,
    /// The second over the first, the median of the runs' own ratios.
    share: f64,
}

pub(super) fn measure(repeats: u64) -> anyhow::Result<Kernel> {
    let part = Arc::new(HeatPart::Rectangular.voxels());
    let process = process();
    let mut simulation =
        Simulation::new(part.clone(), &ThermalMaterial::abs(), &process, Method::Naive)?;
    let control = Control::default();
    for (layer, order) in orders(&part, Pattern::CONVENTIONAL)?.iter().enumerate() {
        simulation.deposit(layer as u32, order, &control)?;
    }
    let step_s = part.frame.cell_mm / process.print_mm_s;
    let steps = 4_000;
    let [mut a, mut b, mut c] = [0.0, 1.0, 2.0].map(|number| vec![number; TRIAD + LINE]);
    let [a, b, c] = [&mut a, &mut b, &mut c].map(|numbers| aligned(numbers));
    let (mut triads, mut updates, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..repeats.max(5) {
        let triad = rate(TRIAD * steps, || {
            for _ in 0..steps {
                pulp::Arch::new().dispatch(Triad { a, b, c });
                black_box(&mut *a);
            }
        });
        let pause_s = step_s * steps as f64;
        let update = rate(part.count() * steps, || {
            simulation.pause(pause_s, &control).expect("the default control never interrupts");
        });
        triads.push(triad);
        updates.push(update);
        shares.push(update / triad);
    }
    Ok(Kernel {
        triad_g_per_s: middle(triads),
        updates_g_per_s: middle(updates),
        share: middle(shares),
    })
}

/// The numbers from the first on that begins a cache line.
fn aligned(numbers: &mut [f32]) -> &mut [f32] {
    let start = numbers.as_ptr().align_offset(4 * LINE).min(LINE);
    &mut numbers[start..start + TRIAD]
}

/// Once through the arrays.
/// A type of its own, as closures are not compiled for the widest lanes.
struct Triad<'a> {
    a: &'a mut [f32],
    b: &'a [f32],
    c: &'a [f32],
}

impl WithSimd for Triad<'_> {
    type Output = ();

    #[expect(
        clippy::inline_always,
        reason = "only what is inlined is compiled for the processor's lanes"
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

/// 10⁹ things a second.
fn rate(things: usize, run: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    run();
    things as f64 / begin.elapsed().as_secs_f64() / 1e9
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| triad, 10⁹/s | updates of a static block, 10⁹/s | share |\n|---|---|---|")?;
        let Self { triad_g_per_s, updates_g_per_s, share } = self;
        writeln!(f, "| {triad_g_per_s:.2} | {updates_g_per_s:.2} | {:.0} % |", 100.0 * share)
    }
}
