//! Temperatures of nozzle and build plate while a program prints the part.

use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_gcode::{Command, Program};
use beadwork_thermal::program::{TemperatureShare, program_temperatures};

use super::args::Temperatures;

/// Temperatures that differ less are one, in K.
const SAME_K: f64 = 1.0;

/// Temperatures that a report names.
const NAMED: usize = 4;

/// Names of parameters of start macros and of settings in comments, for each heater.
const NOZZLE_PARAMETERS: [&str; 10] = [
    "EXTRUDER_TEMP",
    "EXTRUDER",
    "EXTRUDER_TEMPERATURE",
    "HOTEND",
    "HOTEND_TEMP",
    "NOZZLE",
    "NOZZLE_TEMP",
    "TOOL_TEMP",
    "PRINT_TEMP",
    "TEMPERATURE",
];
const PLATE_PARAMETERS: [&str; 4] = ["BED_TEMP", "BED", "BED_TEMPERATURE", "BEDTEMP"];
const NOZZLE_COMMENTS: [&str; 2] = ["temperature", "nozzle_temperature"];
const PLATE_COMMENTS: [&str; 3] =
    ["bed_temperature", "hot_plate_temp", "first_layer_bed_temperature"];

/// Finds the temperatures at which a program prints most of the part.
/// Reports on stderr if they change, and where they come from if no command sets them.
pub(super) fn temperatures(program: &Program, ambient_c: f64) -> anyhow::Result<Temperatures> {
    let found = control::quiet(Threads::One, |control| program_temperatures(program, control))??;
    report_change("nozzle", &found.nozzle);
    report_change("build plate", &found.plate);
    let most = |shares: &[TemperatureShare]| shares.first().map(|most| most.celsius);
    let nozzle_c = most(&found.nozzle)
        .or_else(|| stated(program, "nozzle", &NOZZLE_PARAMETERS, &NOZZLE_COMMENTS));
    let plate_c = match most(&found.plate) {
        Some(celsius) if celsius > 0.0 => Some(celsius),
        Some(_) => {
            eprintln!("beadwork: the build plate is off; simulated at {ambient_c} °C");
            Some(ambient_c)
        }
        None => stated(program, "build plate", &PLATE_PARAMETERS, &PLATE_COMMENTS),
    };
    if nozzle_c.is_none() {
        eprintln!("beadwork: no command sets the nozzle temperature; --nozzle-c sets it");
    }
    Ok(Temperatures { nozzle_c, plate_c })
}

/// Reports temperatures that differ from the most common one.
fn report_change(heater: &str, shares: &[TemperatureShare]) {
    let Some(most) = shares.first() else { return };
    if shares.iter().all(|other| (other.celsius - most.celsius).abs() <= SAME_K) {
        return;
    }
    let of = |one: &TemperatureShare| format!("{} °C for {:.1} %", one.celsius, 100.0 * one.share);
    let mut all: Vec<String> = shares.iter().take(NAMED).map(of).collect();
    if shares.len() > NAMED {
        all.push(format!("{} others", shares.len() - NAMED));
    }
    eprintln!(
        "beadwork: {heater} temperature changes while the part is printed ({} of the beads); \
         simulated at {} °C",
        all.join(", "),
        most.celsius
    );
}

/// The temperature in a parameter of a macro, or else in a comment.
fn stated(program: &Program, heater: &str, parameters: &[&str], comments: &[&str]) -> Option<f64> {
    let positive = |text: &str| {
        let first = text.split([',', ';']).next()?.trim();
        first.parse().ok().filter(|&celsius: &f64| celsius > 0.0 && celsius < 1e3)
    };
    let is = |name: &str, names: &[&str]| {
        names.iter().any(|known| name.trim().eq_ignore_ascii_case(known))
    };
    let in_macro = program.lines.iter().find_map(|line| {
        let Some(Command::Other(text)) = line.command() else { return None };
        let mut words = text.as_str().split_ascii_whitespace();
        let name = words.next()?;
        let (key, celsius) = words.find_map(|word| {
            let (key, value) = word.split_once('=')?;
            if is(key, parameters) { Some((key, positive(value)?)) } else { None }
        })?;
        Some((celsius, format!("parameter {key} of {name}")))
    });
    let in_comment = || {
        program.lines.iter().find_map(|line| {
            let (key, value) = line.comment()?.split_once('=')?;
            let celsius = if is(key, comments) { positive(value) } else { None }?;
            Some((celsius, format!("the comment '{}'", key.trim())))
        })
    };
    let (celsius, source) = in_macro.or_else(in_comment)?;
    eprintln!(
        "beadwork: {heater} temperature {celsius} °C is that of {source}; no command sets it"
    );
    Some(celsius)
}
