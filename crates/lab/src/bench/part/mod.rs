//! `bench part`: speed and memory of reading, repairing and slicing meshes, and speed of G-code.

mod gcode;
mod meshes;
mod towers;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use beadwork_console::{control, machine, output};
use beadwork_mesh::{Format, Solid};
use serde_json::json;

use self::gcode::Gcode;
use self::meshes::{Memory, MeshFile, MeshRow};
use self::towers::TowerRow;
use crate::args::positive;

/// Measure speed and memory of reading, repairing and slicing meshes, and the speed of writing,
/// reading and checking G-code.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork bench part
  beadwork bench part --mesh heartgears.3mf --layer 0.2 --json")]
pub(super) struct PartArgs {
    /// Mesh file (STL, 3MF or OBJ) to measure in addition to a generated sphere; it must fit on the
    /// default bed.
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// Layer height for that file, in mm.
    #[arg(long, value_name = "MM", default_value_t = 0.2)]
    layer: f64,
    /// Runs of each measurement, of which the median is reported.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = positive::<u64>())]
    repeats: u64,
    /// Threads; 0 for one per core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

/// Steps of a sphere of about a million triangles: 4 n (n - 1).
const MILLION_STEPS: u32 = 501;

/// Runs all measurements, and prints their tables.
pub(super) fn run(args: &PartArgs) -> anyhow::Result<()> {
    let pool = control::pool(args.threads)?;
    let sphere = Solid::Sphere { radius_mm: 50.0, steps: MILLION_STEPS }.mesh();
    let sphere = MeshFile {
        name: "sphere, 1 M triangles".to_owned(),
        format: Format::Stl,
        bytes: meshes::stl(&sphere),
        layer_mm: 0.2,
    };
    // Memory comes first, while the allocator holds little freed memory that it could reuse.
    let memory = meshes::memory(&sphere, &pool)?;
    let mut rows = vec![meshes::measure(&sphere, args.repeats, &pool)?];
    if let Some(path) = &args.mesh {
        rows.push(meshes::measure(&read_file(path, args.layer)?, args.repeats, &pool)?);
    }
    let towers = towers::measure(args.repeats)?;
    let gcode = gcode::measure(args.repeats)?;
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(), "memory": memory, "meshes": rows, "heights": towers,
            "gcode": gcode,
        }));
    }
    output::text(&text(&rows, &memory, &towers, &gcode)?)
}

fn read_file(path: &Path, layer_mm: f64) -> anyhow::Result<MeshFile> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let format = Format::from_file_name(&name)
        .with_context(|| format!("'{name}': unknown format, expected .stl, .3mf or .obj"))?;
    let bytes = std::fs::read(path).with_context(|| format!("cannot read '{}'", path.display()))?;
    Ok(MeshFile { name, format, bytes, layer_mm })
}

fn text(
    meshes: &[MeshRow],
    memory: &Memory,
    towers: &[TowerRow],
    gcode: &Gcode,
) -> Result<String, std::fmt::Error> {
    let mut text = format!("{}\n\n", machine::line());
    writeln!(
        text,
        "| mesh | triangles | layers | cells | read s | repair s | outlines s \
         | all to regions s | on one thread s |\n\
         |---|---|---|---|---|---|---|---|---|"
    )?;
    for mesh in meshes {
        writeln!(text, "{mesh}")?;
    }
    writeln!(text, "\n{memory}\n")?;
    writeln!(
        text,
        "| towers of equal spheres: height mm | triangles | layers | µs per layer |\n\
         |---|---|---|---|"
    )?;
    for tower in towers {
        writeln!(text, "{tower}")?;
    }
    writeln!(text, "\n{gcode}")?;
    Ok(text)
}
