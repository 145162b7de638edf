//! The sweep of a static block, beside the memory that it moves.

use std::fmt;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use beadwork_part::Pattern;
use beadwork_thermal::{Material, Method, Simulation};
use serde::Serialize;

use super::process;
use crate::bench::middle;
use crate::heat_parts::{HeatPart, orders};

/// Numbers in each of the triad's three arrays: together they fill about as much memory as the block's two.
const TRIAD: usize = 50_000;

/// Rates in 10⁹ a second.
#[derive(Serialize)]
pub(super) struct Kernel {
    /// The sum of one array and a multiple of another into a third, within the second-level cache: 12 bytes each, as many as an update moves.
    triad_g_per_s: f64,
    /// Voxels of the rectangular part, all of them deposited, in explicit steps.
    updates_g_per_s: f64,
    /// The second over the first, the median of the runs' own ratios.
    share: f64,
}

pub(super) fn measure(repeats: u64) -> anyhow::Result<Kernel> {
    let part = Arc::new(HeatPart::Rectangular.voxels());
    let process = process();
    let mut simulation = Simulation::new(part.clone(), &Material::abs(), &process, Method::Naive)?;
    for (layer, order) in orders(&part, Pattern::CONVENTIONAL)?.iter().enumerate() {
        simulation.deposit(layer as u32, order)?;
    }
    let step_s = part.frame.cell_mm / process.print_mm_s;
    let steps = 4_000;
    let (b, c) = (vec![1.0_f32; TRIAD], vec![2.0_f32; TRIAD]);
    let mut a = vec![0.0_f32; TRIAD];
    let (mut triads, mut updates, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..repeats.max(5) {
        let triad = rate(TRIAD * steps, || {
            for _ in 0..steps {
                pulp::Arch::new().dispatch(|| {
                    for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
                        *a = b + 0.5 * c;
                    }
                });
                black_box(&mut a);
            }
        });
        let update = rate(part.count() * steps, || simulation.pause(step_s * steps as f64));
        triads.push(triad);
        updates.push(update);
        shares.push(update / triad);
    }
    Ok(Kernel { triad_g_per_s: middle(triads), updates_g_per_s: middle(updates), share: middle(shares) })
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
