//! Time of cubes against their size.

use std::fmt::Write;
use std::sync::Arc;

use beadwork_part::Pattern;
use serde::Serialize;

use super::{FAST, print};
use crate::heat_parts::{cuboid, orders};

/// One cube.
#[derive(Serialize)]
pub(super) struct Row {
    side: u32,
    voxels: usize,
    seconds: f64,
    us_per_birth: f64,
}

pub(super) fn measure(side: u32) -> anyhow::Result<Row> {
    let part = Arc::new(cuboid([side; 3]));
    let seconds = print(&part, &orders(&part, Pattern::ALL[0])?, FAST, |_, _| {})?;
    let voxels = part.count();
    Ok(Row { side, voxels, seconds, us_per_birth: 1e6 * seconds / voxels as f64 })
}

pub(super) fn table(rows: &[Row]) -> anyhow::Result<String> {
    let mut text = String::from("| cube | voxels | s | us a birth |\n|---|---|---|---|\n");
    for Row { side, voxels, seconds, us_per_birth } in rows {
        writeln!(text, "| {side}³ | {voxels} | {seconds:.2} | {us_per_birth:.2} |")?;
    }
    Ok(text)
}
