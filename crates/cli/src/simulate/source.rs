//! The part and its deposition order, from a pattern or a program.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow, bail};
use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_console::part::{check_layers, report_lowering, report_repairs};
use beadwork_console::progress::ProgressBar;
use beadwork_console::text::count;
use beadwork_gcode::{Event, Heater, Program};
use beadwork_part::print;
use beadwork_part::slice::{Layers, Voxels};
use beadwork_part::{Frame, Pattern};
use beadwork_thermal::Simulation;
use beadwork_thermal::program::{self, ProgramEvents, program_events, program_voxels};

use super::args::{Args, Temperatures};
use super::sampling::Samplers;

/// A part and its deposition order.
pub(super) struct Source {
    /// Name of the part or of the program.
    pub(super) name: String,
    pub(super) part: Arc<Voxels>,
    pub(super) order: Order,
    /// Temperatures that the program sets.
    pub(super) temperatures: Temperatures,
}

/// The deposition order of all voxels.
pub(super) enum Order {
    Pattern(Pattern),
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
            });
        };
        let in_file = || format!("cannot use '{}'", path.display());
        let bytes = fs::read(path).with_context(|| format!("cannot read '{}'", path.display()))?;
        let program = control::quiet(Threads::One, |control| Program::from_bytes(&bytes, control))?
            .with_context(in_file)?;
        drop(bytes);
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
        let temperatures = temperatures(&program);
        Ok(Self { name, part: Arc::new(part), order: Order::Program(events), temperatures })
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
    let part = args.part.load(settings.printer.bed_mm, &pool)?;
    report_repairs(&part.repaired);
    check_layers(&part.layers)?;
    report_lowering(&part.layers);
    let below = part.layers.empty_below();
    let last = part.layers.layers.iter().rposition(Option::is_some).unwrap_or(0);
    let layers = part.layers.layers[below..=last].to_vec();
    Ok((part.name, Layers { frame: part.layers.frame, layers }.voxels()))
}

/// Bead width and layer height that the comments of a program state, in mm.
fn stated_mm(program: &Program) -> [Option<f64>; 2] {
    let stated = |name: &str| {
        let value = |comment: &str| {
            let (key, value) = comment.split_once('=')?;
            (key.trim() == name).then(|| value.trim().parse().ok())?
        };
        program.lines.iter().filter_map(|line| value(line.comment()?)).find(|&mm: &f64| mm > 0.0)
    };
    [stated("extrusion_width"), stated("layer_height")]
}

fn part_of(program: &Program) -> anyhow::Result<Voxels> {
    let [Some(cell_mm), Some(layer_mm)] = stated_mm(program) else {
        bail!("no bead width and layer height in the comments: name the part, too");
    };
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

/// The last temperatures of nozzle and bed before the first bead, in °C.
fn temperatures(program: &Program) -> Temperatures {
    let mut found = Temperatures::default();
    for event in program.trace().map_while(Result::ok) {
        match event {
            Event::Heat { heater, celsius, .. } if celsius > 0.0 => {
                let kept =
                    if heater == Heater::Bed { &mut found.plate_c } else { &mut found.nozzle_c };
                *kept = Some(celsius);
            }
            Event::Motion(motion) if motion.is_extrusion() => break,
            _ => {}
        }
    }
    found
}
