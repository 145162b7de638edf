//! `simulate`: the temperatures of a part while it is printed.

mod args;
mod drawing;
mod heat;
mod measures;
mod position;
mod probe;
mod report;
mod sampling;
mod section;
mod source;
mod stated;

use std::time::Instant;

use anyhow::bail;
use beadwork_base::{Control, Threads};
use beadwork_console::{cancel, control, output, progress};
use beadwork_thermal::{DepositionEvent, LayerReport, Simulation, ThermalMaterial};

pub(crate) use args::Args;

use args::MaterialName;
use measures::LayerMeasures;
use position::size_mm;
use report::Report;
use sampling::{Requested, Samplers};
use source::Source;

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let target = args.check()?;
    let source = Source::load(args)?;
    let part = &source.part;
    for section in &args.section {
        section.check(size_mm(part))?;
    }
    let probes =
        args.probe.iter().map(|probe| probe.voxel(part)).collect::<anyhow::Result<Vec<_>>>()?;
    let material = match args.material {
        MaterialName::Abs => ThermalMaterial::abs(),
        MaterialName::Pla => ThermalMaterial::pla(),
        MaterialName::Petg => ThermalMaterial::petg(),
    };
    let process = args.process(source.temperatures, &material);
    let pool = control::pool(args.threads)?;
    let mut simulation = Simulation::new(part.clone(), &material, &process, args.method())?;
    let cancel = Some(cancel::token()?);
    let control = Control { cancel, ..Control::on(Threads::Pool(&pool)) };

    let begin = Instant::now();
    let drawn = if args.svg.is_some() { drawing::chosen(part.depth) } else { Vec::new() };
    let mut samplers = Samplers::new(
        &simulation,
        Requested {
            probes,
            probe_seconds: args.probe_seconds.unwrap_or(1.0),
            above_c: args.time_above.map(|threshold| threshold.celsius(&material)),
            warpage: args.warpage.then_some(&material),
        },
    );
    let (mut reports, mut maps) = (Vec::new(), Vec::new());
    let bar = progress::bar(part.count() as u64, "simulate");
    source.print(
        &mut simulation,
        &mut samplers,
        &bar,
        &control,
        |layer, seconds, simulation| {
            let report = LayerReport::of(simulation, layer as u32, seconds, &material);
            reports.push(report.expect("a layer that is complete has voxels"));
            if drawn.contains(&layer) {
                maps.push(drawing::layer_map(layer, simulation));
            }
        },
    )?;
    let print_seconds = simulation.seconds();
    let mut end = None;
    if let Some(seconds) = args.end_seconds {
        samplers.run(&mut simulation, &[DepositionEvent::pause(seconds)], &control)?;
        end = simulation.statistics().map(|all| (seconds, all));
    }
    let sampled = samplers.finish(&simulation, &control)?;
    let interlayer = simulation.interlayer_temperatures(material.glass_transition_c);
    let layers: Vec<LayerMeasures> =
        reports.iter().map(|report| LayerMeasures::new(report, &interlayer)).collect();
    bar.finish_and_clear();
    if cancel::token()?.is_cancelled() {
        bail!("stopped; nothing was written");
    }
    let report = Report {
        source: &source,
        material: &material,
        process: &process,
        method: args.method_name(),
        layers: &layers,
        end,
        sampled: &sampled,
        print_seconds,
        seconds: begin.elapsed().as_secs_f64(),
    };
    if let Some(path) = &args.csv {
        output::file(path, report.csv())?;
    }
    if let (Some(path), Some(probes)) = (&args.probe_out, &sampled.probes) {
        output::file(path, probe::csv(&args.probe, probes))?;
    }
    if let Some(path) = &args.svg {
        output::file(path, drawing::draw(&report.title(), &layers, &maps)?)?;
    }
    if let Some(target) = target {
        let map = |&section: &section::Section| {
            (section, section.map(&simulation, format!("{}, {section} mm", source.name)))
        };
        target.write(&args.section.iter().map(map).collect::<Vec<_>>())?;
    }
    if args.json { output::json(&report.json()) } else { output::text(&report.summary()) }
}
