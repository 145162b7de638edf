//! Time and errors of each method on the parts.

use std::fmt::Write;
use std::sync::Arc;

use beadwork_part::Pattern;
use beadwork_thermal::simulation::{Accuracy, Method};
use serde::Serialize;

use super::errors::{Errors, Fields};
use super::print;
use crate::bench::middle;
use crate::heat_parts::{HeatPart, orders};

/// One method on one part.
#[derive(Clone, Serialize)]
pub(super) struct Row {
    part: &'static str,
    voxels: usize,
    method: &'static str,
    seconds: f64,
    /// Time of the plain scheme over this one's, the median of the runs' own ratios.
    naive_ratio: f64,
    errors: Errors,
}

/// The methods, the plain scheme first.
const METHODS: [(&str, Method); 3] = [
    ("naive", Method::Naive),
    ("standard", Method::Fast(Accuracy::Standard)),
    ("high", Method::Fast(Accuracy::High)),
];

pub(super) fn measure(part: HeatPart, pattern: Pattern, repeats: u64) -> anyhow::Result<Vec<Row>> {
    let voxels = Arc::new(part.voxels());
    let orders = orders(&voxels, pattern)?;
    let fields = |method: Method| -> anyhow::Result<Fields> {
        let mut fields = Fields::default();
        print(&voxels, &orders, method, |layer, simulation| {
            fields.look(layer, simulation, &orders)
        })?;
        Ok(fields)
    };
    let reference = fields(Method::Reference { steps: 4 })?;
    let mut errors = Vec::new();
    for (_, method) in METHODS {
        errors.push(Errors::between(&fields(method)?, &reference));
    }
    drop(reference);
    // In turn, so that a machine that slows down slows all of them.
    let mut seconds = vec![Vec::new(); METHODS.len()];
    for _ in 0..repeats {
        for ((_, method), seconds) in METHODS.iter().zip(&mut seconds) {
            seconds.push(print(&voxels, &orders, *method, |_, _| {})?);
        }
    }
    let naive = seconds[0].clone();
    let rows =
        METHODS.iter().zip(seconds).zip(errors).map(|(((method, _), seconds), errors)| Row {
            part: part.name(),
            voxels: voxels.count(),
            method,
            naive_ratio: middle(
                naive.iter().zip(&seconds).map(|(naive, own)| naive / own).collect(),
            ),
            seconds: middle(seconds),
            errors,
        });
    Ok(rows.collect())
}

pub(super) fn table(rows: &[Row]) -> anyhow::Result<String> {
    let mut text = String::from(
        "| part | voxels | method | s | naive / own | RMS error, K | max error, K | the same without the last 120 births | worst error of a layer's std, K |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let Errors { rms_k, max_k, settled_max_k, std_k } = row.errors;
        writeln!(
            text,
            "| {} | {} | {} | {:.3} | {:.2} | {rms_k:.4} | {max_k:.2} | {settled_max_k:.2} | {std_k:.4} |",
            row.part, row.voxels, row.method, row.seconds, row.naive_ratio
        )?;
    }
    Ok(text)
}
