//! Run time and errors of each stepping method on the parts.

use std::fmt::Write;
use std::sync::Arc;

use beadwork_console::progress;
use beadwork_part::Pattern;
use beadwork_thermal::simulation::{Accuracy, Method};
use serde::Serialize;

use super::errors::{Errors, Temperatures};
use super::printing::print;
use crate::heat_parts::{HeatPart, orders};
use crate::statistics::median;

/// One method on one part.
#[derive(Clone, Serialize)]
pub(super) struct Row {
    part: &'static str,
    voxels: usize,
    method: &'static str,
    seconds: f64,
    /// Run time of the explicit scheme divided by that of this method: median of the ratios of each
    /// run.
    naive_ratio: f64,
    errors: Errors,
}

/// The methods with their names; the explicit scheme comes first, because ratios refer to it.
const METHODS: [(&str, Method); 3] = [
    ("naive", Method::Naive),
    ("standard", Method::Fast(Accuracy::Standard)),
    ("high", Method::Fast(Accuracy::High)),
];

/// Measures each method on one part: its errors once, its run time `repeats` times.
pub(super) fn measure(part: HeatPart, pattern: Pattern, repeats: u64) -> anyhow::Result<Vec<Row>> {
    let voxels = Arc::new(part.voxels());
    let orders = orders(&voxels, pattern)?;
    let prints = 1 + METHODS.len() as u64 * (1 + repeats);
    let bar = progress::bar(prints, part.name());
    let temperatures = |method: Method| -> anyhow::Result<Temperatures> {
        let mut temperatures = Temperatures::default();
        print(&voxels, &orders, method, |layer, simulation| {
            temperatures.record(layer, simulation, &orders);
        })?;
        bar.inc(1);
        Ok(temperatures)
    };
    let reference = temperatures(Method::Reference { steps: 4 })?;
    let mut errors = Vec::new();
    for (_, method) in METHODS {
        errors.push(Errors::between(&temperatures(method)?, &reference));
    }
    drop(reference);
    // The methods alternate, so that a machine that slows down slows all of them.
    let mut seconds = vec![Vec::new(); METHODS.len()];
    for _ in 0..repeats {
        for ((_, method), seconds) in METHODS.iter().zip(&mut seconds) {
            seconds.push(print(&voxels, &orders, *method, |_, _| {})?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let naive = seconds[0].clone();
    let row = |(((method, _), seconds), errors): (((&'static str, _), Vec<f64>), Errors)| {
        let ratios = naive.iter().zip(&seconds).map(|(naive, own)| naive / own);
        Row {
            part: part.name(),
            voxels: voxels.count(),
            method,
            naive_ratio: median(ratios.collect()),
            seconds: median(seconds),
            errors,
        }
    };
    Ok(METHODS.into_iter().zip(seconds).zip(errors).map(row).collect())
}

pub(super) fn table(rows: &[Row]) -> anyhow::Result<String> {
    let mut text = String::from(
        "| part | voxels | method | s | speed relative to naive | RMS error, K | max error, K \
         | max error without the last 120 voxels, K | max error of a layer's standard deviation, K |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let Row { part, voxels, method, seconds, naive_ratio, errors } = row;
        let Errors { rms_k, max_k, settled_max_k, std_k } = errors;
        writeln!(
            text,
            "| {part} | {voxels} | {method} | {seconds:.3} | {naive_ratio:.2} | {rms_k:.4} \
             | {max_k:.2} | {settled_max_k:.2} | {std_k:.4} |"
        )?;
    }
    Ok(text)
}
