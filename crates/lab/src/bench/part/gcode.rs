//! Speed of writing, parsing, checking and timing G-code.

use std::fmt;
use std::hint::black_box;

use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_console::plan::printed_layers;
use beadwork_gcode::Program;
use beadwork_grid::cover;
use beadwork_mesh::{Body, Model, Placement, Solid};
use beadwork_part::print::{self, Print, Title};
use beadwork_part::slice::{Layers, Settings, slice};
use serde::Serialize;

use crate::bench::timing::median_seconds;

/// Lines per second on one thread, for the G-code of a sphere.
#[derive(Serialize)]
pub(super) struct Gcode {
    /// Lines of the program.
    lines: usize,
    /// From planned layers to a program.
    made: f64,
    /// From a program to text.
    written: f64,
    /// From text to a program.
    read: f64,
    /// Check that a program prints its layers.
    checked: f64,
    /// Printing time of a program.
    timed: f64,
}

/// Measures all steps on the G-code of a sphere of 60 mm.
pub(super) fn measure(repeats: u64) -> anyhow::Result<Gcode> {
    let control = &control::cancellable(Threads::One)?;
    let sliced = sphere(control)?;
    let covers = sliced.layers.iter().flatten().map(|layer| cover(&layer.region, control));
    let covers: Vec<_> = covers.collect::<Result<_, _>>()?;
    let layers = printed_layers(&sliced, covers.iter());
    let settings =
        print::Settings { tools: vec![print::Tool::default()], ..print::Settings::default() };
    let title = Title { part: "sphere", version: env!("CARGO_PKG_VERSION") };
    let make = || Print::new(title, &layers, &sliced.frame, &settings, control);
    let program = make()?.program;
    let text = program.emit();
    let lines = program.lines.len();
    let limits = settings.printer.limits();
    Ok(Gcode {
        lines,
        made: rate(lines, repeats, || Ok(make()?))?,
        written: rate(lines, repeats, || Ok(program.emit()))?,
        read: rate(lines, repeats, || Ok(Program::parse(&text, control)?))?,
        checked: rate(lines, repeats, || {
            Ok(print::check(&program, &layers, &sliced.frame, &settings, control)?)
        })?,
        timed: rate(lines, repeats, || Ok(program.print_seconds(limits, control)?))?,
    })
}

/// Lines per second of a step that processes all lines.
fn rate<T>(
    lines: usize,
    repeats: u64,
    step: impl Fn() -> anyhow::Result<T>,
) -> anyhow::Result<f64> {
    let seconds = median_seconds(repeats, |_| {
        black_box(step()?);
        Ok(())
    })?;
    Ok(lines as f64 / seconds)
}

/// A sphere of 60 mm as layers of one material.
fn sphere(control: &Control<'_>) -> anyhow::Result<Layers> {
    let mut model = Model {
        bodies: vec![Body {
            mesh: Solid::Sphere { radius_mm: 30.0, steps: 60 }.mesh(),
            material: Some(0),
            ..Body::default()
        }],
        ..Model::default()
    };
    Placement::default().apply(&mut model)?;
    Ok(slice(&model, &Settings::default(), control)?)
}

impl fmt::Display for Gcode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [made, written, read, checked, timed] =
            [self.made, self.written, self.read, self.checked, self.timed].map(|rate| rate / 1e6);
        write!(
            f,
            "G-code, million lines per second ({} lines): made {made:.1}, written {written:.1}, \
             read {read:.1}, checked {checked:.1}, timed {timed:.1}",
            self.lines
        )
    }
}
