//! What is printed, and in which order: a part by a pattern, or a program.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow, bail};
use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_console::progress::ProgressBar;
use beadwork_console::text::count;
use beadwork_gcode::{Event, Heater, Program};
use beadwork_part::print;
use beadwork_part::slice::{Layers, Voxels};
use beadwork_part::{Frame, Pattern};
use beadwork_thermal::Simulation;
use beadwork_thermal::program::{self, ProgramEvents, program_events, program_voxels};

use super::Args;
use super::watch::Watch;

/// A part and how it comes about.
pub(super) struct Source {
    pub(super) name: String,
    pub(super) part: Arc<Voxels>,
    pub(super) course: Course,
    /// Temperatures of nozzle and plate that a program sets, °C.
    pub(super) nozzle_c: Option<f64>,
    pub(super) plate_c: Option<f64>,
}

/// The order of all voxels.
pub(super) enum Course {
    Pattern(Pattern),
    Program(ProgramEvents),
}

impl Source {
    pub(super) fn load(args: &Args) -> anyhow::Result<Self> {
        let settings = args.printer.load()?;
        let Some(path) = &args.gcode else {
            let (name, part) = load_part(args, &settings)?;
            let course = Course::Pattern(args.pattern);
            return Ok(Self { name, part: Arc::new(part), course, nozzle_c: None, plate_c: None });
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
        let how = program::Settings {
            limits: settings.printer.limits(),
            tolerated_share: args.left_out.unwrap_or(0.0),
        };
        let slots =
            control::quiet(Threads::One, |control| program_events(&program, &part, &how, control))?
                .map_err(|error| explain(error.into(), &program, &part));
        let slots = slots.with_context(in_file)?;
        let mut part = part;
        if !slots.missed.is_empty() {
            let voxels = count(slots.missed.len() as u64, "voxel");
            eprintln!("beadwork: the program leaves out {voxels} of {}", part.count());
            part = slots.printed(&part);
            if part.count() == 0 {
                bail!("'{}' prints no voxel of the part", path.display());
            }
        }
        let [nozzle_c, plate_c] = temperatures(&program);
        Ok(Self { name, part: Arc::new(part), course: Course::Program(slots), nozzle_c, plate_c })
    }

    /// Prints all layers under watch, and tells after each that is complete how long it took, s.
    pub(super) fn print(
        &self,
        simulation: &mut Simulation,
        watch: &mut Watch,
        bar: &ProgressBar,
        control: &Control<'_>,
        mut complete: impl FnMut(usize, f64, &Simulation),
    ) -> anyhow::Result<()> {
        let mut done = |layer: usize, seconds: f64, simulation: &Simulation| {
            bar.inc(self.part.cells(layer).count() as u64);
            complete(layer, seconds, simulation);
        };
        match &self.course {
            Course::Pattern(pattern) => {
                for layer in 0..self.part.depth {
                    let order = pattern.order(&self.part.region(layer)?);
                    let before = simulation.seconds();
                    let slots = simulation.layer_events(layer as u32, &order);
                    watch.run(simulation, &slots, control)?;
                    done(layer, simulation.seconds() - before, simulation);
                }
            }
            Course::Program(program) => {
                // Parts that are printed one after the other don't complete their layers from the
                // bed up.
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
                    watch.run(simulation, &program.events[begin..end], control)?;
                    begin = end;
                    done(layer, simulation.seconds() - before, simulation);
                }
                watch.run(simulation, &program.events[begin..], control)?;
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
    for (body, repaired) in &part.repaired {
        eprintln!("beadwork: repaired {body}: {}", beadwork_console::part::describe(repaired));
    }
    if let Some(layer) = part.layers.gap() {
        bail!("layer {} has no cells: what lies above it would be printed in the air", layer + 1);
    }
    let below = part.layers.empty_below();
    if below > 0 {
        let layers = count(below as u64, "layer");
        eprintln!(
            "beadwork: the part is lowered by {layers} without cells: its tip is thinner than a bead"
        );
    }
    let last = part.layers.layers.iter().rposition(Option::is_some).unwrap_or(0);
    let layers = part.layers.layers[below..=last].to_vec();
    Ok((part.name, Layers { frame: part.layers.frame, layers }.voxels()))
}

/// Width of beads and height of layers as the comments of a program say, in mm.
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
        bail!("it does not say how wide its beads and how high its layers are: give the part, too");
    };
    let part = control::quiet(Threads::One, |control| {
        program_voxels(program, cell_mm, layer_mm, control)
    })??;
    match (0..part.depth).find(|&layer| part.cells(layer).next().is_none()) {
        Some(layer) => Err(anyhow!("it prints nothing in layer {}: give the part, too", layer + 1)),
        None => Ok(part),
    }
}

/// Says more of an error if the program was made for other cells.
fn explain(error: anyhow::Error, program: &Program, part: &Voxels) -> anyhow::Error {
    let Frame { cell_mm, layer_mm, .. } = part.frame;
    let differs = |stated: Option<f64>, given: f64| stated.filter(|mm| (mm - given).abs() > 1e-6);
    let [bead, layer] = stated_mm(program);
    if let Some(mm) = differs(bead, cell_mm) {
        return anyhow!(
            "its beads are {mm} mm wide, the part's cells {cell_mm} mm: give --bead {mm}"
        );
    }
    if let Some(mm) = differs(layer, layer_mm) {
        return anyhow!("its layers are {mm} mm high, the part's {layer_mm} mm: give --layer {mm}");
    }
    error
}

/// The last temperatures of nozzle and bed before the first bead, °C.
fn temperatures(program: &Program) -> [Option<f64>; 2] {
    let mut found = [None; 2];
    for event in program.trace().map_while(Result::ok) {
        match event {
            Event::Heat { heater, celsius, .. } if celsius > 0.0 => {
                found[usize::from(heater == Heater::Bed)] = Some(celsius);
            }
            Event::Motion(motion) if motion.is_extrusion() => break,
            _ => {}
        }
    }
    found
}
