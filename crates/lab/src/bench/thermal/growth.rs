//! Time of cubes and of towers against their size.

use std::fmt::Write;
use std::sync::Arc;

use beadwork_console::chart::{Axis, BLUE, Chart, LineStyle, ORANGE, Series, charts};
use beadwork_part::Pattern;
use serde::Serialize;

use super::{FAST, print};
use crate::heat_parts::{cuboid, orders};

/// Sides of a tower's foot, in voxels.
pub(super) const FOOT: u32 = 64;

/// One cuboid.
#[derive(Serialize)]
pub(super) struct Row {
    size: [u32; 3],
    voxels: usize,
    seconds: f64,
    us_per_birth: f64,
}

pub(super) fn measure(size: [u32; 3]) -> anyhow::Result<Row> {
    let part = Arc::new(cuboid(size));
    let seconds = print(&part, &orders(&part, Pattern::ALL[0])?, FAST, |_, _| {})?;
    let voxels = part.count();
    Ok(Row { size, voxels, seconds, us_per_birth: 1e6 * seconds / voxels as f64 })
}

pub(super) fn table(rows: &[Row]) -> anyhow::Result<String> {
    let mut text = String::from("| cuboid | voxels | s | us a birth |\n|---|---|---|---|\n");
    for Row { size: [x, y, z], voxels, seconds, us_per_birth } in rows {
        writeln!(text, "| {x} x {y} x {z} | {voxels} | {seconds:.2} | {us_per_birth:.2} |")?;
    }
    Ok(text)
}

/// Microseconds a birth over the voxels, these with equal factors at equal distances.
pub(super) fn svg(cubes: &[Row], towers: &[Row]) -> anyhow::Result<String> {
    let series = |name: String, colour, rows: &[Row]| {
        let points = rows.iter().map(|row| (row.voxels as f64, row.us_per_birth)).collect();
        Series { name, colour, style: LineStyle::Dotted, points }
    };
    let chart = Chart {
        title: "Time for each birth".to_owned(),
        x: Axis { label: "voxels", logarithmic: true, shown: &[] },
        y: Axis { label: "µs a birth", logarithmic: false, shown: &[0.0] },
        series: vec![
            series("cubes".to_owned(), BLUE, cubes),
            series(format!("towers of {FOOT} x {FOOT} voxels"), ORANGE, towers),
        ],
    };
    charts(&[chart], 1, (520, 340))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cuboid_is_a_dot() {
        let row = |size: [u32; 3], us_per_birth| Row {
            size,
            voxels: size.iter().product::<u32>() as usize,
            seconds: 1.0,
            us_per_birth,
        };
        let cubes = [row([24; 3], 3.0), row([48; 3], 5.0), row([96; 3], 11.0)];
        let drawing = svg(&cubes, &[row([64, 64, 16], 4.0), row([64, 64, 32], 4.1)]).unwrap();
        assert_eq!(drawing.matches("<circle").count(), 5);
        for text in ["voxels", "µs a birth", "100,000", "towers"] {
            assert!(drawing.contains(text), "{text}");
        }
    }
}
