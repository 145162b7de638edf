//! The part and its deposition order, from a pattern or a program.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow, bail};
use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_console::progress::ProgressBar;
use beadwork_console::text::count;
use beadwork_gcode::{MotionLimits, Program, UnknownCommand};
use beadwork_part::print;
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Order as LayerOrder};
use beadwork_thermal::Simulation;
use beadwork_thermal::program::{
    self, LayerFit, ProgramEvents, ProgramFit, program_events, program_fit, program_voxels,
};

use super::args::{Args, Temperatures};
use super::heat::temperatures;
use super::sampling::Samplers;
use super::stated::{stated_mm, voxel_mm};

/// A part and its deposition order.
pub(super) struct Source {
    /// Name of the part or of the program.
    pub(super) name: String,
    pub(super) part: Arc<Voxels>,
    pub(super) order: Order,
    /// Temperatures that the program sets.
    pub(super) temperatures: Temperatures,
    /// How the program's layers fit the voxels, if their heights differ.
    pub(super) fit: Option<LayerFit>,
}

/// The deposition order of all voxels.
pub(super) enum Order {
    Pattern(LayerOrder),
    Program(ProgramEvents),
}

impl Source {
    pub(super) fn load(args: &Args) -> anyhow::Result<Self> {
        let settings = args.printer.load()?;
        let Some(path) = &args.gcode else {
            let (name, part) = load_part(args, &settings)?;
            let order = Order::Pattern(args.pattern);
            return Ok(Self {
                name,
                part: Arc::new(part),
                order,
                temperatures: Temperatures::default(),
                fit: None,
            });
        };
        let in_file = || format!("cannot use '{}'", path.display());
        let bytes = fs::read(path).with_context(|| format!("cannot read '{}'", path.display()))?;
        let program = control::quiet(Threads::One, |control| Program::from_bytes(&bytes, control))?
            .with_context(in_file)?;
        drop(bytes);
        if program.lines.iter().all(|line| line.command().is_none()) {
            bail!("'{}' contains no G-code command", path.display());
        }
        report_unknown(&program, settings.printer.limits());
        let (name, part) = if args.part.is_given() {
            load_part(args, &settings)?
        } else {
            (stem(path), part_of(&program).with_context(in_file)?)
        };
        let settings = program::Settings {
            limits: settings.printer.limits(),
            tolerated_share: args.left_out.unwrap_or(0.0),
        };
        let events = control::quiet(Threads::One, |control| {
            program_events(&program, &part, &settings, control)
        })?
        .map_err(|error| explain(error.into(), &program, &part));
        let events = events.with_context(in_file)?;
        let mut part = part;
        if !events.missed.is_empty() {
            let voxels = count(events.missed.len() as u64, "voxel");
            eprintln!("beadwork: the program leaves out {voxels} of {}", part.count());
            part = events.printed(&part);
            if part.count() == 0 {
                bail!("'{}' prints no voxel of the part", path.display());
            }
        }
        let fit = report_fit(&program, &part.frame)?;
        let temperatures = temperatures(&program, args.ambient_c)?;
        Ok(Self { name, part: Arc::new(part), order: Order::Program(events), temperatures, fit })
    }

    /// Prints all layers and samples them; calls `complete` at the end of each layer with its
    /// number and its printing time in s.
    pub(super) fn print(
        &self,
        simulation: &mut Simulation,
        samplers: &mut Samplers,
        bar: &ProgressBar,
        control: &Control<'_>,
        mut complete: impl FnMut(usize, f64, &Simulation),
    ) -> anyhow::Result<()> {
        let mut done = |layer: usize, seconds: f64, simulation: &Simulation| {
            bar.inc(self.part.cells(layer).count() as u64);
            complete(layer, seconds, simulation);
        };
        match &self.order {
            Order::Pattern(pattern) => {
                for layer in 0..self.part.depth {
                    let cells = pattern.order(&self.part.region(layer)?);
                    let before = simulation.seconds();
                    let events = simulation.layer_events(layer as u32, &cells);
                    samplers.run(simulation, &events, control)?;
                    done(layer, simulation.seconds() - before, simulation);
                }
            }
            Order::Program(program) => {
                // Objects that are printed one after the other do not complete layers from the bed
                // up.
                let mut ends: Vec<(usize, usize)> = program
                    .layer_ends
                    .iter()
                    .enumerate()
                    .map(|(layer, &end)| (end, layer))
                    .collect();
                ends.sort_unstable();
                let mut begin = 0;
                for (end, layer) in ends.into_iter().filter(|&(end, _)| end > 0) {
                    let before = simulation.seconds();
                    samplers.run(simulation, &program.events[begin..end], control)?;
                    begin = end;
                    done(layer, simulation.seconds() - before, simulation);
                }
                samplers.run(simulation, &program.events[begin..], control)?;
            }
        }
        Ok(())
    }
}

fn stem(path: &Path) -> String {
    path.file_stem()
        .map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}

fn load_part(args: &Args, settings: &print::Settings) -> anyhow::Result<(String, Voxels)> {
    let pool = control::pool(0)?;
    args.part.load(settings.printer.bed_mm, &pool)?.printed_voxels()
}

fn part_of(program: &Program) -> anyhow::Result<Voxels> {
    let [cell_mm, layer_mm] = voxel_mm(program)?;
    let part = control::quiet(Threads::One, |control| {
        program_voxels(program, cell_mm, layer_mm, control)
    })??;
    match (0..part.depth).find(|&layer| part.cells(layer).next().is_none()) {
        Some(layer) => Err(anyhow!("layer {} is empty: name the part, too", layer + 1)),
        None => Ok(part),
    }
}

/// Replaces an error by its cause if the program has another bead width or layer height than the
/// part.
fn explain(error: anyhow::Error, program: &Program, part: &Voxels) -> anyhow::Error {
    let Frame { cell_mm, layer_mm, .. } = part.frame;
    let differs = |stated: Option<f64>, given: f64| stated.filter(|mm| (mm - given).abs() > 1e-6);
    let [bead, layer] = stated_mm(program);
    if let Some(mm) = differs(bead, cell_mm) {
        return anyhow!(
            "beads are {mm} mm wide, the cells of the part {cell_mm} mm: try --bead {mm}"
        );
    }
    if let Some(mm) = differs(layer, layer_mm) {
        return anyhow!(
            "layers are {mm} mm high, those of the part {layer_mm} mm: try --layer {mm}"
        );
    }
    error
}

/// Reports how the layers of a program fit voxels of one height, and prime lines that are left out.
fn report_fit(program: &Program, frame: &Frame) -> anyhow::Result<Option<LayerFit>> {
    let fit = control::quiet(Threads::One, |control| {
        program_fit(program, frame.cell_mm, frame.layer_mm, control)
    })??;
    let ProgramFit { layers: fit, left_out_mm, raft_mm } = fit;
    if raft_mm > 0.0 {
        eprintln!(
            "beadwork: the part stands on a raft or supports {raft_mm:.2} mm high; simulated \
             directly on the build plate"
        );
    }
    if left_out_mm > 0.0 {
        eprintln!(
            "beadwork: {left_out_mm:.0} mm of beads before or below the first layer, such as a \
             prime line, are not part"
        );
    }
    if let Some(LayerFit {
        layers,
        rows,
        height_mm,
        rows_mm,
        max_deviation_mm,
        volume_error,
        layers_without_row,
    }) = fit
    {
        eprintln!(
            "beadwork: layers have several heights: {} of {height_mm:.3} mm together become {} of \
             voxels, {rows_mm:.3} mm high; tops of layers are off by up to {max_deviation_mm:.3} \
             mm, the volume by {:+.1} %",
            count(layers as u64, "layer"),
            count(rows as u64, "row"),
            100.0 * volume_error
        );
        if layers_without_row > 0 {
            eprintln!(
                "beadwork: {} too thin to fill a row of voxels",
                match layers_without_row {
                    1 => "1 layer is".to_owned(),
                    several => format!("{several} layers are"),
                }
            );
        }
    }
    Ok(fit)
}

/// Reports commands that could matter but have no effect.
fn report_unknown(program: &Program, limits: MotionLimits) {
    /// Commands that are named.
    const NAMED: usize = 8;
    /// Characters of a name that are shown.
    const NAME_CHARS: usize = 40;
    let unknown = program.unknown_commands(limits);
    if unknown.is_empty() {
        return;
    }
    let name = |command: &UnknownCommand| {
        command.name.chars().take(NAME_CHARS).flat_map(char::escape_debug).collect::<String>()
    };
    let mut names: Vec<String> = unknown.iter().take(NAMED).map(name).collect();
    if unknown.len() > NAMED {
        names.push(format!("and {} more", unknown.len() - NAMED));
    }
    let names = names.join(", ");
    let times: usize = unknown.iter().map(|command| command.count).sum();
    eprintln!(
        "beadwork: {} of the program {} no effect here: {names}",
        count(times as u64, "command"),
        if times == 1 { "has" } else { "have" }
    );
}
