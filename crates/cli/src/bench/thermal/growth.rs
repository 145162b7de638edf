//! Time of cubes against their size.

use std::fmt::Write;
use std::sync::Arc;

use beadwork_part::Pattern;
use serde::Serialize;

use super::{FAST, print};
use crate::chart::{Axis, BLUE, Chart, Series, Stroke, charts};
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

/// Microseconds a birth over the voxels, these with equal factors at equal distances.
pub(super) fn svg(rows: &[Row]) -> anyhow::Result<String> {
    let points = rows.iter().map(|row| (row.voxels as f64, row.us_per_birth)).collect();
    let chart = Chart {
        title: "Time for each birth in a cube".to_owned(),
        x: Axis { label: "voxels", logarithmic: true, shown: &[] },
        y: Axis { label: "µs a birth", logarithmic: false, shown: &[0.0] },
        series: vec![Series {
            name: "fast, standard".to_owned(),
            colour: BLUE,
            stroke: Stroke::Dotted,
            points,
        }],
    };
    charts(&[chart], 1, (520, 340))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cube_is_a_dot() {
        let row = |side: u32, us_per_birth| Row {
            side,
            voxels: (side * side * side) as usize,
            seconds: 1.0,
            us_per_birth,
        };
        let drawing = svg(&[row(24, 3.0), row(48, 5.0), row(96, 11.0)]).unwrap();
        assert_eq!(drawing.matches("<circle").count(), 3);
        for text in ["voxels", "µs a birth", "100,000"] {
            assert!(drawing.contains(text), "{text}");
        }
    }
}
