//! Flags of `simulate`, and the settings that they result in.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::bail;
use beadwork_console::accuracy::AccuracyName;
use beadwork_console::output;
use beadwork_console::part::PartArgs;
use beadwork_console::printer::PrinterArgs;
use beadwork_part::Order;
use beadwork_thermal::simulation::{Accuracy, Method};
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use clap::ValueEnum;

use super::probe::Probe;
use super::section::{Section, Target};

/// Temperatures that a program sets.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Temperatures {
    /// Of the nozzle, in °C.
    pub(super) nozzle_c: Option<f64>,
    /// Of the build plate, in °C.
    pub(super) plate_c: Option<f64>,
}

/// Simulate the temperatures of a part while it is printed.
///
/// Voxels are deposited in the order of a pattern or of a G-code program, and heat flows between
/// them, into the build plate and into the air.
/// Reports the temperatures of all deposited voxels at the end of each layer, the hot spots of the
/// layer, and the temperature of the substrate on which its beads were deposited.
#[derive(clap::Args)]
#[command(
    // A program alone may define the part.
    mut_arg("parts", |parts| parts.required(false).required_unless_present("gcode")),
    after_help = "\
Examples:
  beadwork simulate example:u-shape
  beadwork simulate example:pyramid --pattern spiral-in-0 --csv pyramid.csv --svg pyramid.svg
  beadwork simulate example:pyramid --pattern lines-x-scattered-7-0
  beadwork simulate part.stl --material petg --nozzle-c 240 --plate-c 85 --json
  beadwork simulate example:u-shape --end-seconds 60 --section x=22 --section-out cut.png
  beadwork simulate example:u-shape --probe 5,5,0 --probe 40,5,1 --probe-out probes.csv
  beadwork simulate example:u-shape --time-above=120 --warpage
  beadwork plan example:logo-plate --objective tools --out logo.gcode
  beadwork simulate example:logo-plate --gcode logo.gcode
  beadwork simulate --gcode logo.gcode"
)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(super) part: PartArgs,
    #[command(flatten)]
    pub(super) printer: PrinterArgs,
    /// Deposition order of each layer: one of the 38 patterns, such as zigzag-y-1, raster-x-0,
    /// spiral-in-2, spiral-out-3, contour-raster-y-3 and diagonal-1, or whole lines in another
    /// order: lines, axis, sequence (sequential, interleaved-K, scattered-K, golden, bit-reversed)
    /// and corner, such as lines-x-scattered-7-0 and lines-y-golden-3.
    #[arg(
        long,
        value_name = "NAME",
        default_value = "contour-zigzag-x-0",
        conflicts_with = "gcode"
    )]
    pub(super) pattern: Order,
    /// G-code program that prints the part, in place of a pattern.
    /// Without PART, the part consists of the voxels that its beads fill.
    #[arg(long, value_name = "FILE")]
    pub(super) gcode: Option<PathBuf>,
    /// Share of the part's voxels that the program may leave unprinted, 0 to 1; 0 by default.
    #[arg(
        long,
        value_name = "SHARE",
        value_parser = share,
        requires = "gcode",
        allow_hyphen_values = true
    )]
    pub(super) left_out: Option<f64>,
    /// Material of the part.
    #[arg(long, value_name = "NAME", default_value = "abs")]
    pub(super) material: MaterialName,
    /// Time stepping of the heat equation: the explicit scheme of Kim et al. 2026 (naive), a
    /// second-order scheme with four steps per voxel (reference), or local time stepping (fast).
    #[arg(long, value_name = "NAME", default_value = "fast")]
    pub(super) method: MethodName,
    /// Accuracy of the fast method; standard by default.
    #[arg(long, value_name = "NAME")]
    pub(super) accuracy: Option<AccuracyName>,
    /// Temperature of a voxel when it is deposited, in °C; by default that of the program, or 230
    /// for ABS, 210 for PLA, 240 for PETG.
    #[arg(long, value_name = "C", allow_hyphen_values = true)]
    pub(super) nozzle_c: Option<f64>,
    /// Temperature of the build plate in °C, or none for an insulating plate; by default that of
    /// the program, or 80 for ABS and PETG, 60 for PLA.
    #[arg(long, value_name = "C", allow_hyphen_values = true)]
    pub(super) plate_c: Option<OrNone>,
    /// Temperature of the air, in °C.
    #[arg(long, value_name = "C", default_value_t = 25.0, allow_hyphen_values = true)]
    pub(super) ambient_c: f64,
    /// Heat transfer coefficient to the air, in W/(m² K).
    #[arg(long, value_name = "H", default_value_t = 10.0, allow_hyphen_values = true)]
    pub(super) convection: f64,
    /// Printing speed of a pattern, in mm/s; 30 by default.
    #[arg(long, value_name = "MM_S", conflicts_with = "gcode", allow_hyphen_values = true)]
    pub(super) print_mm_s: Option<f64>,
    /// Travel speed of a pattern, in mm/s, or none for travel that takes no time; 150 by default.
    #[arg(long, value_name = "MM_S", conflicts_with = "gcode", allow_hyphen_values = true)]
    pub(super) travel_mm_s: Option<OrNone>,
    /// Include the thermal resistance of half a voxel at surfaces, which Kim et al. 2026 neglect.
    #[arg(long)]
    pub(super) surface_resistance: bool,
    /// Continue this many seconds after the print, while it cools.
    #[arg(long, value_name = "S", value_parser = seconds, allow_hyphen_values = true)]
    pub(super) end_seconds: Option<f64>,
    /// Write the temperatures and other figures of all layers as CSV.
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Draw charts over the layers, and temperature maps of up to six layers at their ends, as SVG.
    #[arg(long, value_name = "FILE")]
    pub(super) svg: Option<PathBuf>,
    /// Draw the temperatures on a plane at the end: x=30 is 30 mm from the left side of the part, y
    /// is measured from its front, z from its bottom.
    /// Can be repeated.
    #[arg(long, value_name = "AXIS=MM", requires = "section_out")]
    pub(super) section: Vec<Section>,
    /// Output of --section: a .png or .svg file for one plane, or a folder for both files of each.
    #[arg(long, value_name = "FILE|DIR", requires = "section")]
    pub(super) section_out: Option<PathBuf>,
    /// Record the temperature at a position, in mm from the left, front and bottom of the part.
    /// Can be repeated.
    #[arg(long, value_name = "X,Y,Z", requires = "probe_out", allow_hyphen_values = true)]
    pub(super) probe: Vec<Probe>,
    /// Write the histories of all probes as CSV: seconds, then one column per probe, empty until
    /// its voxel is deposited.
    #[arg(long, value_name = "FILE", requires = "probe")]
    pub(super) probe_out: Option<PathBuf>,
    /// Seconds between samples of the probes; 1 by default.
    /// A sample that is due during the deposition of a voxel is taken at its end.
    #[arg(
        long,
        value_name = "S",
        value_parser = interval,
        requires = "probe",
        allow_hyphen_values = true
    )]
    pub(super) probe_seconds: Option<f64>,
    /// Report how long voxels stay above this temperature in °C; the glass transition of the
    /// material by default.
    /// Samples twice per printed second, which makes the simulation up to three times as slow.
    #[arg(
        long,
        value_name = "C",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = Threshold::TRANSITION
    )]
    pub(super) time_above: Option<Threshold>,
    /// Estimate how far corners lift: a number for ranking plans, not a prediction.
    /// Samples twice per printed second, which makes the simulation up to twice as slow.
    #[arg(long)]
    pub(super) warpage: bool,
    /// Threads, which share the long steps of a large part; 0 for one per core.
    /// The result does not depend on them.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) threads: usize,
    /// Print one JSON document.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum MaterialName {
    Abs,
    Pla,
    Petg,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodName {
    Naive,
    Reference,
    Fast,
}

/// Value of `--time-above`.
#[derive(Clone, Copy)]
pub(super) enum Threshold {
    /// The glass transition of the material.
    GlassTransition,
    /// A temperature in °C.
    Celsius(f64),
}

impl Threshold {
    const TRANSITION: &str = "glass-transition";

    pub(super) fn celsius(self, material: &ThermalMaterial) -> f64 {
        match self {
            Self::GlassTransition => material.glass_transition_c,
            Self::Celsius(celsius) => celsius,
        }
    }
}

impl FromStr for Threshold {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == Self::TRANSITION {
            return Ok(Self::GlassTransition);
        }
        let celsius = text.parse().ok().filter(|celsius: &f64| celsius.is_finite());
        celsius
            .map(Self::Celsius)
            .ok_or_else(|| format!("expected a temperature in °C or {}", Self::TRANSITION))
    }
}

/// A number, or none.
#[derive(Clone, Copy)]
pub(super) struct OrNone(pub(super) Option<f64>);

impl FromStr for OrNone {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "none" {
            return Ok(Self(None));
        }
        text.parse()
            .map(|number| Self(Some(number)))
            .map_err(|_| "expected a number or none".to_owned())
    }
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=1e6).contains(seconds));
    seconds.ok_or_else(|| "expected 0 to 1,000,000 seconds".to_owned())
}

fn interval(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (1e-3..=1e6).contains(seconds));
    seconds.ok_or_else(|| "expected 0.001 to 1,000,000 seconds".to_owned())
}

impl Args {
    /// Refuses, before any work, flags that contradict each other and folders in place of files.
    pub(super) fn check(&self) -> anyhow::Result<Option<Target>> {
        if self.accuracy.is_some() && self.method != MethodName::Fast {
            output::usage_error("--accuracy requires --method fast");
        }
        let target = self.section_out.as_deref().map(|path| Target::new(path, self.section.len()));
        let section = target.as_ref().and_then(Target::file);
        let files: Vec<&Path> =
            [self.csv.as_deref(), self.svg.as_deref(), self.probe_out.as_deref(), section]
                .into_iter()
                .flatten()
                .collect();
        for (number, path) in files.iter().enumerate() {
            if path.is_dir() {
                bail!("'{}' is a folder", path.display());
            }
            if files[..number].contains(path) {
                output::usage_error(&format!("'{}' is named for two results", path.display()));
            }
        }
        Ok(target)
    }

    pub(super) fn method(&self) -> Method {
        match self.method {
            MethodName::Naive => Method::Naive,
            MethodName::Reference => Method::Reference { steps: 4 },
            MethodName::Fast => {
                Method::Fast(self.accuracy.map_or_else(Accuracy::default, Into::into))
            }
        }
    }

    pub(super) fn method_name(&self) -> &'static str {
        match (self.method, self.accuracy) {
            (MethodName::Naive, _) => "naive",
            (MethodName::Reference, _) => "reference",
            (MethodName::Fast, Some(AccuracyName::Draft)) => "fast, draft accuracy",
            (MethodName::Fast, Some(AccuracyName::High)) => "fast, high accuracy",
            (MethodName::Fast, _) => "fast",
        }
    }

    /// Process parameters: from the flags, otherwise from the program, otherwise the material's
    /// defaults.
    pub(super) fn process(
        &self,
        program: Temperatures,
        material: &ThermalMaterial,
    ) -> ProcessParameters {
        let defaults = ProcessParameters::suited_to(material);
        let plate_c = OrNone(program.plate_c.or(defaults.plate_c));
        ProcessParameters {
            extrusion_c: self.nozzle_c.or(program.nozzle_c).unwrap_or(defaults.extrusion_c),
            plate_c: self.plate_c.unwrap_or(plate_c).0,
            ambient_c: self.ambient_c,
            convection_w_m2k: self.convection,
            print_mm_s: self.print_mm_s.unwrap_or(defaults.print_mm_s),
            travel_mm_s: match self.travel_mm_s {
                Some(OrNone(speed)) => speed,
                None => defaults.travel_mm_s,
            },
            surface_resistance: self.surface_resistance,
        }
    }
}
