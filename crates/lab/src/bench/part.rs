//! Rates of reading, repairing and slicing meshes, and of G-code.

use std::fmt::Write;
use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context;
use beadwork_base::{Control, Threads};
use beadwork_console::plan::printed_layers;
use beadwork_console::{control, machine, output};
use beadwork_gcode::Program;
use beadwork_grid::cover;
use beadwork_mesh::{Body, Format, MaterialRule, Mesh, Model, Placement, ReadLimits, Solid};
use beadwork_part::print::{self, Print, Title};
use beadwork_part::slice::{Layers, Settings, cut, slice};
use serde_json::{Value, json};

/// Measure how fast meshes are read, repaired and sliced, how much memory that takes, and how fast
/// G-code is written, read and checked.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork bench part
  beadwork bench part --mesh heartgears.3mf --layer 0.2 --json")]
pub(super) struct PartArgs {
    /// A mesh to read and to slice beside the ones made here; it must fit the usual bed.
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// Height of its layers in mm.
    #[arg(long, value_name = "MM", default_value_t = 0.2)]
    layer: f64,
    /// Runs of each measurement, of which the median counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    repeats: u64,
    /// Threads; 0 for one a core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// Steps of a sphere of about a million triangles: 4 n (n - 1).
const MILLION_STEPS: u32 = 501;

pub(super) fn run(args: &PartArgs) -> anyhow::Result<()> {
    let pool = control::pool(args.threads)?;
    // First of all, while little memory was used and given back.
    let million = stl_of(&Solid::Sphere { radius_mm: 50.0, steps: MILLION_STEPS }.mesh());
    let memory = memory(&million, &pool)?;
    let mut meshes =
        vec![pipeline("sphere, 1 M triangles", Format::Stl, &million, 0.2, args.repeats, &pool)?];
    if let Some(path) = &args.mesh {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let format = Format::from_file_name(&name)
            .with_context(|| format!("'{name}' is no .stl, .3mf or .obj file"))?;
        let bytes =
            std::fs::read(path).with_context(|| format!("cannot read '{}'", path.display()))?;
        meshes.push(pipeline(&name, format, &bytes, args.layer, args.repeats, &pool)?);
    }
    let heights = heights(args.repeats)?;
    let gcode = gcode(args.repeats)?;
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(), "memory": memory, "meshes": meshes, "heights": heights, "gcode": gcode,
        }));
    }
    let mut text = format!("{}\n\n", machine::line());
    writeln!(
        text,
        "| mesh | triangles | layers | cells | read s | repair s | outlines s | all to regions s | on one thread s |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|---|---|")?;
    for mesh in &meshes {
        let seconds =
            |key: &str| format!("{:.3}", mesh["seconds"][key].as_f64().unwrap_or(f64::NAN));
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            mesh["name"].as_str().unwrap_or_default(),
            mesh["triangles"],
            mesh["layers"],
            mesh["cells"],
            seconds("read"),
            seconds("repair"),
            seconds("outlines"),
            seconds("all"),
            seconds("all_one_thread")
        )?;
    }
    let ratio = |key: &str| {
        memory[key].as_f64().map_or_else(|| "unknown".to_owned(), |ratio| format!("{ratio:.2}"))
    };
    writeln!(
        text,
        "\nMemory beside the file, in sizes of the mesh ({:.1} MB for {} triangles), at the peak of: reading {}, repairing {}, outlines {}\n",
        memory["mesh_bytes"].as_f64().unwrap_or_default() / 1e6,
        memory["triangles"],
        ratio("read"),
        ratio("repair"),
        ratio("outlines")
    )?;
    writeln!(text, "| towers of equal cylinders: height mm | triangles | layers | µs a layer |")?;
    writeln!(text, "|---|---|---|---|")?;
    for row in &heights {
        let micros = row["micros_a_layer"].as_f64().unwrap_or_default();
        writeln!(
            text,
            "| {} | {} | {} | {micros:.1} |",
            row["height_mm"], row["triangles"], row["layers"]
        )?;
    }
    let rate = |key: &str| gcode[key].as_f64().unwrap_or_default() / 1e6;
    writeln!(
        text,
        "\nG-code, million lines a second ({} lines): made {:.1}, written {:.1}, read {:.1}, checked {:.1}, timed {:.1}",
        gcode["lines"],
        rate("made"),
        rate("written"),
        rate("read"),
        rate("checked"),
        rate("timed")
    )?;
    output::text(&text)
}

/// A binary STL file.
fn stl_of(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles().len() as u32).to_le_bytes());
    for &triangle in mesh.triangles() {
        bytes.extend([0; 12]);
        mesh.corners(triangle)
            .iter()
            .flatten()
            .for_each(|&value| bytes.extend((value as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn read(format: Format, bytes: &[u8]) -> anyhow::Result<Model> {
    Ok(Model::read(format, bytes, &ReadLimits::default(), &Control::default())?)
}

fn repair(model: &mut Model) -> anyhow::Result<()> {
    for body in &mut model.bodies {
        body.repair(&Control::default())?;
    }
    model.assign_materials(MaterialRule::Stated);
    Placement::default().apply(model)?;
    Ok(())
}

fn outlines(model: &Model, layer_mm: f64, pool: Option<&rayon::ThreadPool>) -> usize {
    let layers = (model.bounds().max[2] / layer_mm) as usize;
    let control = Control::on(Threads::of(pool));
    let of_body = |body: &Body| {
        cut(&body.mesh, &body.paint, layer_mm, layers, &control).map_or(0, |all| all.len())
    };
    model.bodies.iter().map(of_body).sum()
}

/// All steps from a file's bytes to regions.
fn pipeline(
    name: &str,
    format: Format,
    bytes: &[u8],
    layer_mm: f64,
    repeats: u64,
    pool: &rayon::ThreadPool,
) -> anyhow::Result<Value> {
    let mut steps: [Vec<f64>; 5] = Default::default();
    let mut facts = Value::Null;
    for repeat in 0..=repeats {
        let begin = Instant::now();
        let mut model = read(format, bytes)?;
        let read = begin.elapsed().as_secs_f64();
        repair(&mut model)?;
        let repaired = begin.elapsed().as_secs_f64();
        let settings = Settings { layer_mm, ..Settings::default() };
        let layers: Layers = slice(&model, &settings, &Control::on(Threads::Pool(pool)))?;
        let all = begin.elapsed().as_secs_f64();
        let again = Instant::now();
        outlines(&model, layer_mm, Some(pool));
        let outlined = again.elapsed().as_secs_f64();
        let again = Instant::now();
        slice(&model, &settings, &Control::default())?;
        let alone = again.elapsed().as_secs_f64();
        // The first run does not count.
        if repeat > 0 {
            let seconds = [read, repaired - read, outlined, all, repaired + alone];
            steps.iter_mut().zip(seconds).for_each(|(step, seconds)| step.push(seconds));
        }
        facts = json!({
            "name": name, "triangles": model.triangle_count(), "layers": layers.layers.len(), "cells": layers.cell_count(),
        });
    }
    let [read, repair, outlines, all, alone] = steps.map(super::middle);
    facts["seconds"] = json!({ "read": read, "repair": repair, "outlines": outlines, "all": all, "all_one_thread": alone });
    Ok(facts)
}

/// Peaks of memory in sizes of the mesh, the file's bytes not counted.
fn memory(bytes: &[u8], pool: &rayon::ThreadPool) -> anyhow::Result<Value> {
    let before = machine::memory_bytes();
    let mesh_bytes =
        |model: &Model| model.bodies.iter().map(|body| body.mesh.memory_bytes()).sum::<usize>();
    let peak = |size: usize| {
        let peak = machine::peak_memory_bytes()?.saturating_sub(before?);
        Some(peak as f64 / size as f64)
    };
    machine::reset_peak_memory();
    let mut model = read(Format::Stl, bytes)?;
    let size = mesh_bytes(&model);
    let read = peak(size);
    machine::reset_peak_memory();
    repair(&mut model)?;
    let repaired = peak(size);
    machine::reset_peak_memory();
    outlines(&model, 0.2, Some(pool));
    let outlined = peak(size);
    Ok(json!({
        "triangles": model.triangle_count(), "mesh_bytes": size, "file_bytes": bytes.len(),
        "read": read, "repair": repaired, "outlines": outlined,
    }))
}

/// Towers of the same cylinders one on the other: each layer holds as much, whatever the height.
fn heights(repeats: u64) -> anyhow::Result<Vec<Value>> {
    let mut rows = Vec::new();
    for storeys in [1_u32, 4, 16, 64] {
        let mut vertices: Vec<[f64; 3]> = Vec::new();
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for storey in 0..storeys {
            let ball = Solid::Sphere { radius_mm: 2.0, steps: 60 }.mesh();
            let base = vertices.len() as u32;
            let rise = 2.0 + 4.0 * f64::from(storey);
            vertices.extend(ball.vertices().iter().map(|&[x, y, z]| [x, y, z + rise]));
            triangles
                .extend(ball.triangles().iter().map(|corners| corners.map(|vertex| vertex + base)));
        }
        let mesh = Mesh::new(vertices, triangles)?;
        let layers = storeys as usize * 40;
        let seconds =
            super::median(repeats, |_| drop(cut(&mesh, &[], 0.1, layers, &Control::default())));
        rows.push(json!({
            "height_mm": 4 * storeys, "triangles": mesh.triangles().len(), "layers": layers,
            "micros_a_layer": 1e6 * seconds / layers as f64,
        }));
    }
    Ok(rows)
}

/// Lines a second of G-code, on one thread.
fn gcode(repeats: u64) -> anyhow::Result<Value> {
    let mut model = Model {
        bodies: vec![Body {
            name: String::new(),
            mesh: Solid::Sphere { radius_mm: 30.0, steps: 60 }.mesh(),
            material: Some(0),
            paint: Vec::new(),
        }],
        materials: Vec::new(),
    };
    Placement::default().apply(&mut model)?;
    let sliced = slice(&model, &Settings::default(), &Control::default())?;
    let covers = sliced.layers.iter().flatten();
    let covers = covers.map(|layer| cover(&layer.region, &Control::default()));
    let covers: Vec<_> = covers.collect::<Result<_, _>>()?;
    let layers = printed_layers(&sliced, covers.iter());
    let settings =
        print::Settings { tools: vec![print::Tool::default()], ..print::Settings::default() };
    let title = Title { part: "sphere", version: env!("CARGO_PKG_VERSION") };
    let print = Print::new(title, &layers, &sliced.frame, &settings, &Control::default())?;
    let text = print.program.emit();
    let lines = print.program.lines.len();
    let rate = |seconds: f64| lines as f64 / seconds;
    let limits = settings.printer.limits();
    // What could fail has not failed above.
    let made = super::median(repeats, |_| {
        drop(Print::new(title, &layers, &sliced.frame, &settings, &Control::default()))
    });
    let written = super::median(repeats, |_| drop(print.program.emit()));
    let read = super::median(repeats, |_| drop(text.parse::<Program>()));
    let checked = super::median(repeats, |_| {
        drop(print::check(&print.program, &layers, &sliced.frame, &settings, &Control::default()))
    });
    let timed = super::median(repeats, |_| {
        black_box(print.program.print_seconds(limits, &Control::default())).ok();
    });
    Ok(json!({
        "lines": lines, "made": rate(made), "written": rate(written), "read": rate(read), "checked": rate(checked),
        "timed": rate(timed),
    }))
}
