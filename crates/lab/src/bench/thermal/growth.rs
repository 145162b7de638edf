//! Run time of the solver against the size of the part.

use std::fmt::Write;
use std::sync::Arc;

use beadwork_console::chart::{Axis, BLUE, Chart, LineStyle, ORANGE, Series, charts};
use beadwork_console::progress;
use beadwork_part::Pattern;
use serde::Serialize;

use super::printing::{FAST, print};
use crate::heat_parts::{cuboid, orders};

/// Side of the square base of the towers, in voxels.
pub(super) const BASE: u32 = 64;

/// The run time of one cuboid.
#[derive(Serialize)]
pub(super) struct Row {
    /// Voxels along x, y and z.
    size: [u32; 3],
    voxels: usize,
    seconds: f64,
    #[serde(rename = "us_per_birth")]
    us_per_voxel: f64,
}

/// Measures cuboids of these sizes in voxels, with a progress bar named `what`.
pub(super) fn measure(sizes: &[[u32; 3]], what: &'static str) -> anyhow::Result<Vec<Row>> {
    let voxels = |size: &[u32; 3]| size.iter().map(|&side| u64::from(side)).product::<u64>();
    let bar = progress::bar(sizes.iter().map(voxels).sum(), what);
    let row = |&size: &[u32; 3]| -> anyhow::Result<Row> {
        let part = Arc::new(cuboid(size));
        let orders = orders(&part, Pattern::ALL[0])?;
        let seconds = print(&part, &orders, FAST, |layer, _| bar.inc(orders[layer].len() as u64))?;
        let voxels = part.count();
        Ok(Row { size, voxels, seconds, us_per_voxel: 1e6 * seconds / voxels as f64 })
    };
    let rows = sizes.iter().map(row).collect();
    bar.finish_and_clear();
    rows
}

pub(super) fn table(rows: &[Row]) -> anyhow::Result<String> {
    let mut text = String::from("| cuboid | voxels | s | µs per voxel |\n|---|---|---|---|\n");
    for Row { size: [x, y, z], voxels, seconds, us_per_voxel } in rows {
        writeln!(text, "| {x} x {y} x {z} | {voxels} | {seconds:.2} | {us_per_voxel:.2} |")?;
    }
    Ok(text)
}

/// Chart of the microseconds per voxel against the number of voxels.
pub(super) fn svg(cubes: &[Row], towers: &[Row]) -> anyhow::Result<String> {
    let series = |name: String, colour, rows: &[Row]| {
        let points = rows.iter().map(|row| (row.voxels as f64, row.us_per_voxel)).collect();
        Series { name, colour, style: LineStyle::Dotted, points }
    };
    let chart = Chart {
        title: "Run time per voxel".to_owned(),
        x: Axis { label: "voxels", logarithmic: true, shown: &[] },
        y: Axis { label: "µs per voxel", logarithmic: false, shown: &[0.0] },
        series: vec![
            series("cubes".to_owned(), BLUE, cubes),
            series(format!("towers of {BASE} x {BASE} voxels"), ORANGE, towers),
        ],
    };
    charts(&[chart], 1, (520, 340))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cuboid_is_a_dot() {
        let row = |size: [u32; 3], us_per_voxel| Row {
            size,
            voxels: size.iter().product::<u32>() as usize,
            seconds: 1.0,
            us_per_voxel,
        };
        let cubes = [row([24; 3], 3.0), row([48; 3], 5.0), row([96; 3], 11.0)];
        let drawing = svg(&cubes, &[row([64, 64, 16], 4.0), row([64, 64, 32], 4.1)]).unwrap();
        assert_eq!(drawing.matches("<circle").count(), 5);
        for text in ["voxels", "µs per voxel", "100,000", "towers"] {
            assert!(drawing.contains(text), "{text}");
        }
    }
}
