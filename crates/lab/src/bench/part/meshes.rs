//! Run time and memory of the steps from the bytes of a mesh file to the regions of its layers.

use std::fmt;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_console::{control, machine, progress};
use beadwork_mesh::{
    Body, Format, MaterialRule, Mesh, Model, Placement, ReadLimits, RepairSettings,
};
use beadwork_part::slice::{Settings, cut, slice};
use rayon::ThreadPool;
use serde::Serialize;

use crate::statistics::median;

/// A mesh file in memory.
pub(super) struct MeshFile {
    pub(super) name: String,
    pub(super) format: Format,
    pub(super) bytes: Vec<u8>,
    /// Height of the layers into which it is sliced.
    pub(super) layer_mm: f64,
}

/// The run time of one mesh.
#[derive(Serialize)]
pub(super) struct MeshRow {
    name: String,
    triangles: usize,
    layers: usize,
    cells: u64,
    seconds: StepSeconds,
}

/// Median run time of each step, in seconds.
#[derive(Serialize)]
struct StepSeconds {
    read: f64,
    repair: f64,
    /// Cutting the surface into outlines, on several threads.
    outlines: f64,
    /// All steps from the bytes to the regions, on several threads.
    all: f64,
    /// All steps on one thread.
    all_one_thread: f64,
}

/// Peak memory of each step for one mesh, without the bytes of the file, relative to the memory of
/// the mesh; `None` where the system does not report it.
#[derive(Serialize)]
pub(super) struct Memory {
    triangles: usize,
    mesh_bytes: usize,
    file_bytes: usize,
    read: Option<f64>,
    repair: Option<f64>,
    outlines: Option<f64>,
}

/// Measures the run time of all steps, after one run that is not measured.
pub(super) fn measure(file: &MeshFile, repeats: u64, pool: &ThreadPool) -> anyhow::Result<MeshRow> {
    let bar = progress::bar(1 + repeats, "runs of a mesh");
    let first = Run::measure(file, pool)?;
    bar.inc(1);
    let mut steps: [Vec<f64>; 5] = Default::default();
    for _ in 0..repeats {
        let run = Run::measure(file, pool)?;
        steps.iter_mut().zip(run.seconds).for_each(|(step, seconds)| step.push(seconds));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let [read, repair, outlines, all, all_one_thread] = steps.map(median);
    Ok(MeshRow {
        name: file.name.clone(),
        triangles: first.triangles,
        layers: first.layers,
        cells: first.cells,
        seconds: StepSeconds { read, repair, outlines, all, all_one_thread },
    })
}

/// One run of all steps.
struct Run {
    triangles: usize,
    layers: usize,
    cells: u64,
    /// In the order of [`StepSeconds`].
    seconds: [f64; 5],
}

impl Run {
    fn measure(file: &MeshFile, pool: &ThreadPool) -> anyhow::Result<Self> {
        let one_thread = control::cancellable(Threads::One)?;
        let on_pool = control::cancellable(Threads::Pool(pool))?;
        let settings = Settings { layer_mm: file.layer_mm, ..Settings::default() };
        let begin = Instant::now();
        let mut model = file.read(&one_thread)?;
        let read = begin.elapsed().as_secs_f64();
        repair(&mut model, &one_thread)?;
        let repaired = begin.elapsed().as_secs_f64();
        let layers = slice(&model, &settings, &on_pool)?;
        let all = begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        outlines(&model, file.layer_mm, &on_pool)?;
        let outlined = begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        slice(&model, &settings, &one_thread)?;
        let sliced_alone = begin.elapsed().as_secs_f64();
        Ok(Self {
            triangles: model.triangle_count(),
            layers: layers.layers.len(),
            cells: layers.cell_count(),
            seconds: [read, repaired - read, outlined, all, repaired + sliced_alone],
        })
    }
}

/// Measures the peak memory of reading, repairing and cutting a mesh.
pub(super) fn memory(file: &MeshFile, pool: &ThreadPool) -> anyhow::Result<Memory> {
    let one_thread = control::cancellable(Threads::One)?;
    let before = machine::memory_bytes();
    let peak = |mesh_bytes: usize| {
        let peak = machine::peak_memory_bytes()?.saturating_sub(before?);
        Some(peak as f64 / mesh_bytes as f64)
    };
    machine::reset_peak_memory();
    let mut model = file.read(&one_thread)?;
    let mesh_bytes = model.bodies.iter().map(|body| body.mesh.memory_bytes()).sum();
    let read = peak(mesh_bytes);
    machine::reset_peak_memory();
    repair(&mut model, &one_thread)?;
    let repaired = peak(mesh_bytes);
    machine::reset_peak_memory();
    outlines(&model, file.layer_mm, &control::cancellable(Threads::Pool(pool))?)?;
    let outlined = peak(mesh_bytes);
    Ok(Memory {
        triangles: model.triangle_count(),
        mesh_bytes,
        file_bytes: file.bytes.len(),
        read,
        repair: repaired,
        outlines: outlined,
    })
}

impl MeshFile {
    fn read(&self, control: &Control<'_>) -> anyhow::Result<Model> {
        Ok(Model::read(self.format, &self.bytes, &ReadLimits::default(), control)?)
    }
}

/// Repairs all bodies, and places the model on the default bed.
fn repair(model: &mut Model, control: &Control<'_>) -> anyhow::Result<()> {
    for body in &mut model.bodies {
        body.repair(&RepairSettings::default(), control)?;
    }
    model.assign_materials(MaterialRule::Stated);
    Placement::default().apply(model)?;
    Ok(())
}

/// Cuts all bodies into outlines, and returns the number of outlines.
fn outlines(model: &Model, layer_mm: f64, control: &Control<'_>) -> anyhow::Result<usize> {
    let layers = (model.bounds().max[2] / layer_mm) as usize;
    let of_body = |body: &Body| Ok(cut(&body.mesh, &body.paint, layer_mm, layers, control)?.len());
    model.bodies.iter().map(of_body).sum()
}

/// A mesh as a binary STL file.
pub(super) fn stl(mesh: &Mesh) -> Vec<u8> {
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

/// A row of the table of meshes.
impl fmt::Display for MeshRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, triangles, layers, cells, seconds } = self;
        let StepSeconds { read, repair, outlines, all, all_one_thread } = seconds;
        write!(
            f,
            "| {name} | {triangles} | {layers} | {cells} | {read:.3} | {repair:.3} \
             | {outlines:.3} | {all:.3} | {all_one_thread:.3} |"
        )
    }
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ratio = |ratio: Option<f64>| {
            ratio.map_or_else(|| "unknown".to_owned(), |ratio| format!("{ratio:.2}"))
        };
        write!(
            f,
            "Peak memory in addition to the file, relative to the mesh \
             ({:.1} MB for {} triangles): reading {}, repairing {}, outlines {}",
            self.mesh_bytes as f64 / 1e6,
            self.triangles,
            ratio(self.read),
            ratio(self.repair),
            ratio(self.outlines)
        )
    }
}
