//! What a simulation found, for people and for programs.

use std::fmt::Write;

use beadwork_console::text::{count, duration};
use beadwork_thermal::warpage::WarpageEstimate;
use beadwork_thermal::{ProcessParameters, TemperatureStatistics, ThermalMaterial};
use serde_json::{Value, json};

use super::layers::Measure;
use super::source::{Course, Source};
use super::watch::{Excess, Seen};

/// Rows of a table for people, at most.
const ROWS: usize = 16;

pub(super) struct Report<'a> {
    pub(super) source: &'a Source,
    pub(super) material: &'a ThermalMaterial,
    pub(super) process: &'a ProcessParameters,
    pub(super) method: &'a str,
    /// Of each layer when it is complete.
    pub(super) layers: &'a [Measure],
    /// Seconds for which it went on after the print, if that was asked for, and the temperatures
    /// then.
    pub(super) end: Option<(f64, TemperatureStatistics)>,
    /// What was looked at on the way.
    pub(super) seen: &'a Seen,
    /// From the beginning of the print to its end, without that time, s.
    pub(super) print_seconds: f64,
    /// What the simulation took, s.
    pub(super) seconds: f64,
}

impl Report<'_> {
    /// The sum of the layers' standard deviations, made negative: the reward of the paper (Kim et
    /// al. 2026).
    fn reward(&self) -> f64 {
        -self.layers.iter().map(|layer| layer.std_c).sum::<f64>()
    }

    pub(super) fn title(&self) -> String {
        let order = match &self.source.course {
            Course::Pattern(pattern) => pattern.name(),
            Course::Program(_) => "as in the G-code",
        };
        format!("{}, {order}, {}", self.source.name, self.material.name)
    }

    /// Everything, and nothing that differs between two runs but the seconds.
    pub(super) fn json(&self) -> Value {
        let Self { source, material, process, .. } = self;
        let frame = &source.part.frame;
        let (pattern, missed) = match &source.course {
            Course::Pattern(pattern) => (Some(pattern.name()), 0),
            Course::Program(program) => (None, program.missed.len()),
        };
        json!({
            "part": source.name,
            "width": frame.width,
            "height": frame.height,
            "depth": source.part.depth,
            "bead_mm": frame.cell_mm,
            "layer_mm": frame.layer_mm,
            "voxels": source.part.count(),
            "voxels_left_out": missed,
            "pattern": pattern,
            "material": material.name,
            "glass_transition_c": material.glass_transition_c,
            "method": self.method,
            "process": {
                "nozzle_c": process.extrusion_c,
                "plate_c": process.plate_c,
                "ambient_c": process.ambient_c,
                "convection_w_m2k": process.convection_w_m2k,
                "print_mm_s": pattern.map(|_| process.print_mm_s),
                "travel_mm_s": pattern.and(process.travel_mm_s),
                "surface_resistance": process.surface_resistance,
            },
            "layers": self.layers,
            "end": self.end.map(|(seconds, end)| json!({
                "seconds": seconds,
                "mean_c": end.mean_c,
                "std_c": end.std_c,
                "min_c": end.min_c,
                "max_c": end.max_c,
            })),
            "time_above": self.seen.above,
            "warpage": self.seen.warpage.as_ref().map(|warpage| json!({
                "corner_lift_mm": warpage.corner_lift_mm,
                "curvature_1_m": warpage.curvature_1_m,
            })),
            "reward": self.reward(),
            "print_seconds": self.print_seconds,
            "seconds": self.seconds,
        })
    }

    /// A row for each layer; the ground's temperatures are empty on the plate.
    pub(super) fn csv(&self) -> String {
        let mut text =
            "layer,voxels,mean_c,std_c,min_c,max_c,print_seconds,hot_spots,ground_mean_c,ground_min_c\n"
                .to_owned();
        let told =
            |celsius: Option<f64>| celsius.map_or_else(String::new, |celsius| celsius.to_string());
        for measure in self.layers {
            let Measure {
                layer,
                voxels,
                mean_c,
                std_c,
                min_c,
                max_c,
                print_seconds,
                hot_spots,
                ..
            } = measure;
            let [mean, min] = [measure.ground_mean_c, measure.ground_min_c].map(told);
            writeln!(
                text,
                "{layer},{voxels},{mean_c},{std_c},{min_c},{max_c},{print_seconds},{hot_spots},{mean},{min}"
            )
            .expect("a string takes all text");
        }
        text
    }

    /// A table and a few lines.
    pub(super) fn summary(&self) -> String {
        let mut text = String::new();
        self.write(&mut text).expect("a string takes all text");
        text
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        let Self { source, layers, .. } = self;
        let frame = &source.part.frame;
        writeln!(
            text,
            "{}: {} in {} of up to {} x {}, each {} x {} x {} mm\n",
            self.title(),
            count(source.part.count() as u64, "voxel"),
            count(source.part.depth as u64, "layer"),
            frame.width,
            frame.height,
            frame.cell_mm,
            frame.cell_mm,
            frame.layer_mm,
        )?;
        writeln!(text, "All that is printed, in °C, when a layer is complete:\n")?;
        writeln!(
            text,
            "  layer     mean   std dev    least  greatest    print s  hot spots   ground  coldest"
        )?;
        let told = |celsius: Option<f64>| {
            celsius.map_or_else(|| "-".to_owned(), |celsius| format!("{celsius:.2}"))
        };
        let shown = ROWS.min(layers.len());
        for row in 0..shown {
            let at = if shown > 1 { row * (layers.len() - 1) / (shown - 1) } else { row };
            let Measure { layer, mean_c, std_c, min_c, max_c, print_seconds, hot_spots, .. } =
                layers[at];
            let [mean, min] = [layers[at].ground_mean_c, layers[at].ground_min_c].map(told);
            write!(
                text,
                "{layer:>7} {mean_c:>8.2} {std_c:>9.2} {min_c:>8.2} {max_c:>9.2} {print_seconds:>10.1}"
            )?;
            writeln!(text, " {hot_spots:>10} {mean:>8} {min:>8}")?;
        }
        if shown < layers.len() {
            writeln!(text, "  ({shown} of {} layers; --csv or --json has them all)", layers.len())?;
        }
        let above_c = self.material.glass_transition_c;
        writeln!(
            text,
            "\nhot spots: groups of the layer's voxels above {above_c} °C; ground: what its beads landed on, mean and coldest"
        )?;
        writeln!(
            text,
            "reward {:.2}: minus the sum of all layers' standard deviations",
            self.reward()
        )?;
        if let Some((seconds, TemperatureStatistics { mean_c, std_c, min_c, max_c, .. })) = self.end
        {
            writeln!(
                text,
                "{seconds} s after the print: {mean_c:.2} °C, standard deviation {std_c:.2}, from {min_c:.2} to {max_c:.2}"
            )?;
        }
        if let Some(Excess { above_c, longest_s, mean_s }) = self.seen.above {
            writeln!(
                text,
                "above {above_c} °C: a voxel for {mean_s:.1} s in the mean, {longest_s:.1} s at most"
            )?;
        }
        if let Some(WarpageEstimate { corner_lift_mm, curvature_1_m, .. }) = self.seen.warpage {
            writeln!(
                text,
                "warpage: corners lift by {corner_lift_mm:.3} mm, curvature {curvature_1_m:.3} 1/m; it ranks plans, does not predict"
            )?;
        }
        writeln!(
            text,
            "{} to print, simulated in {:.2} s",
            duration(self.print_seconds),
            self.seconds
        )
    }
}
