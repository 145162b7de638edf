//! The results of a simulation as JSON, CSV and a table.

use std::fmt::Write;

use beadwork_console::text::{count, duration};
use beadwork_thermal::warpage::WarpageEstimate;
use beadwork_thermal::{ProcessParameters, TemperatureStatistics, ThermalMaterial};
use serde_json::{Value, json};

use super::measures::LayerMeasures;
use super::sampling::{Sampled, TimeAboveSummary};
use super::source::{Order, Source};

/// Maximum number of rows of the table.
const ROWS: usize = 16;

pub(super) struct Report<'a> {
    pub(super) source: &'a Source,
    pub(super) material: &'a ThermalMaterial,
    pub(super) process: &'a ProcessParameters,
    pub(super) method: &'a str,
    /// Measures at the end of each layer.
    pub(super) layers: &'a [LayerMeasures],
    /// Seconds that the simulation continued after the print, and the temperatures then.
    pub(super) end: Option<(f64, TemperatureStatistics)>,
    /// Results of measures sampled during the print.
    pub(super) sampled: &'a Sampled,
    /// Printing time in s.
    pub(super) print_seconds: f64,
    /// Wall-clock time of the simulation in s.
    pub(super) seconds: f64,
}

impl Report<'_> {
    /// Minus the sum of the layers' standard deviations: the reward of Kim et al. 2026.
    fn reward(&self) -> f64 {
        -self.layers.iter().map(|layer| layer.std_c).sum::<f64>()
    }

    pub(super) fn title(&self) -> String {
        let order = match &self.source.order {
            Order::Pattern(pattern) => pattern.to_string(),
            Order::Program(_) => "as in the G-code".to_owned(),
        };
        format!("{}, {order}, {}", self.source.name, self.material.name)
    }

    /// All results; only the seconds differ between two runs.
    pub(super) fn json(&self) -> Value {
        let Self { source, material, process, .. } = self;
        let frame = &source.part.frame;
        let (pattern, missed) = match &source.order {
            Order::Pattern(pattern) => (Some(pattern.to_string()), 0),
            Order::Program(program) => (None, program.missed.len()),
        };
        let mut json = json!({
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
                "print_mm_s": pattern.as_ref().map(|_| process.print_mm_s),
                "travel_mm_s": pattern.as_ref().and(process.travel_mm_s),
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
            "time_above": self.sampled.above,
            "warpage": self.sampled.warpage.as_ref().map(|warpage| json!({
                "corner_lift_mm": warpage.corner_lift_mm,
                "curvature_1_m": warpage.curvature_1_m,
            })),
            "reward": self.reward(),
            "print_seconds": self.print_seconds,
            "seconds": self.seconds,
        });
        if let Some(fit) = source.fit {
            json["layer_fit"] = json!({
                "layers": fit.layers,
                "rows": fit.rows,
                "height_mm": fit.height_mm,
                "rows_mm": fit.rows_mm,
                "max_deviation_mm": fit.max_deviation_mm,
                "volume_error": fit.volume_error,
                "layers_without_row": fit.layers_without_row,
            });
        }
        json
    }

    /// CSV with a row for each layer.
    ///
    /// The columns `ground_..` contain the substrate temperatures; they are empty for layers on the
    /// plate.
    pub(super) fn csv(&self) -> String {
        let mut text =
            "layer,voxels,mean_c,std_c,min_c,max_c,print_seconds,hot_spots,ground_mean_c,\
             ground_min_c\n"
                .to_owned();
        let optional =
            |celsius: Option<f64>| celsius.map_or_else(String::new, |celsius| celsius.to_string());
        for measure in self.layers {
            let LayerMeasures {
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
            let [mean, min] = [measure.substrate_mean_c, measure.substrate_min_c].map(optional);
            writeln!(
                text,
                "{layer},{voxels},{mean_c},{std_c},{min_c},{max_c},{print_seconds},{hot_spots},\
                 {mean},{min}"
            )
            .expect("writing to a string succeeds");
        }
        text
    }

    /// A table of layers, and a few lines about the whole print.
    pub(super) fn summary(&self) -> String {
        let mut text = String::new();
        self.write(&mut text).expect("writing to a string succeeds");
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
        writeln!(text, "Temperatures of all deposited voxels in °C, at the end of each layer:\n")?;
        writeln!(
            text,
            "  layer     mean   std dev      min       max    print s  hot spots  substr.  sub. min"
        )?;
        let optional = |celsius: Option<f64>| {
            celsius.map_or_else(|| "-".to_owned(), |celsius| format!("{celsius:.2}"))
        };
        let shown = ROWS.min(layers.len());
        for row in 0..shown {
            let at = if shown > 1 { row * (layers.len() - 1) / (shown - 1) } else { row };
            let LayerMeasures {
                layer, mean_c, std_c, min_c, max_c, print_seconds, hot_spots, ..
            } = layers[at];
            let [mean, min] =
                [layers[at].substrate_mean_c, layers[at].substrate_min_c].map(optional);
            write!(
                text,
                "{layer:>7} {mean_c:>8.2} {std_c:>9.2} {min_c:>8.2} {max_c:>9.2} \
                 {print_seconds:>10.1}"
            )?;
            writeln!(text, " {hot_spots:>10} {mean:>8} {min:>9}")?;
        }
        if shown < layers.len() {
            writeln!(text, "  ({shown} of {} layers; use --csv or --json for all)", layers.len())?;
        }
        let above_c = self.material.glass_transition_c;
        writeln!(
            text,
            "\nhot spots: groups of the layer's voxels above {above_c} °C; substr.: substrate on \
             which its \
             beads were deposited, mean and minimum"
        )?;
        writeln!(
            text,
            "reward {:.2}: minus the sum of the standard deviations of all layers",
            self.reward()
        )?;
        if let Some((seconds, TemperatureStatistics { mean_c, std_c, min_c, max_c, .. })) = self.end
        {
            writeln!(
                text,
                "{seconds} s after the print: mean {mean_c:.2} °C, standard deviation {std_c:.2}, \
                 from {min_c:.2} to {max_c:.2}"
            )?;
        }
        if let Some(TimeAboveSummary { above_c, longest_s, mean_s }) = self.sampled.above {
            writeln!(
                text,
                "above {above_c} °C: {mean_s:.1} s per voxel on average, {longest_s:.1} s at most"
            )?;
        }
        if let Some(WarpageEstimate { corner_lift_mm, curvature_1_m, .. }) = self.sampled.warpage {
            writeln!(
                text,
                "warpage: corners lift by {corner_lift_mm:.3} mm, curvature {curvature_1_m:.3} \
                 1/m; \
                 for \
                 ranking plans, not a prediction"
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
