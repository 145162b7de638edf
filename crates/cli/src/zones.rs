//! `zones`: a path of few crossings for one layer.

use std::fs;
use std::io::Write;
use std::path::{Path as FilePath, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};
use beadwork_dataset::{StartChoice, write_whole};
use beadwork_grid::{Crossings, Path, Region, Start, Zones, cover, piece_bound};
use beadwork_part::{Panel, svg};
use beadwork_search::{Preset, Settings, Stop, anneal, bound};
use serde::Serialize;
use serde_json::json;

use crate::instance::{Instance, InstanceArgs};
use crate::{cancel, output};

/// Find a path of few zone crossings for one layer.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork zones --layout voronoi --size 50x50 --seed 3 --method anneal
  beadwork zones --layout islands --size 100x100 --preset fast --svg islands.svg
  beadwork zones --image logo.png --preset fast --svg logo.svg --json")]
pub(crate) struct Args {
    #[command(flatten)]
    instance: InstanceArgs,
    /// Seed of the layout and of the search.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// How to choose the path.
    #[arg(long, value_name = "METHOD", default_value = "anneal")]
    method: MethodName,
    /// Annealing preset: paper, short, medium, long, extra_long or fast.
    #[arg(long, value_name = "NAME", default_value = "paper")]
    preset: Preset,
    /// Path to start from: row_zigzag, column_zigzag, spiral, cover, or auto (the row zigzag where there is one, else the cover).
    #[arg(long, value_name = "START", default_value = "auto")]
    start: StartChoice,
    /// Draw the layer before and after.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// The methods of this build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum MethodName {
    /// The start itself.
    Zigzag,
    /// Simulated annealing from the start.
    Anneal,
}

impl MethodName {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Zigzag => "zigzag",
            Self::Anneal => "anneal",
        }
    }
}

/// What `--json` prints for one layer.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) layout: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) zones: u32,
    pub(crate) seed: u64,
    pub(crate) method: String,
    pub(crate) preset: Option<String>,
    pub(crate) start: String,
    pub(crate) initial: u32,
    pub(crate) crossings: u32,
    pub(crate) bound: Option<u32>,
    pub(crate) pieces: u32,
    pub(crate) piece_bound: u32,
    pub(crate) moves: u64,
    pub(crate) seconds: f64,
}

/// What a search is asked to do with a layer.
pub(crate) struct Search<'a> {
    pub(crate) region: &'a Region,
    pub(crate) zones: &'a Zones,
    /// The annealing preset; `None` for the start itself.
    pub(crate) preset: Option<Preset>,
    pub(crate) seed: u64,
    pub(crate) start: Start,
}

impl Search<'_> {
    /// Runs it from the path of its start; gives the best path and the row that tells of it.
    pub(crate) fn run(&self, layout: &str, start: &Path) -> anyhow::Result<(Path, Row)> {
        let &Self { region, zones, preset, seed, .. } = self;
        let cancel = cancel::token()?;
        let begin = Instant::now();
        let crossings = Crossings::new(region, zones);
        let lower = bound::components(region, zones, start.pieces());
        let (best, moves) = match preset {
            None => (start.clone(), 0),
            Some(preset) => {
                let bound = Some(i64::from(lower));
                let settings = Settings { bound, cancel: Some(cancel), ..Settings::preset(preset, seed) };
                let outcome = anneal(start.clone(), &crossings, &settings);
                if outcome.stop == Stop::Cancelled {
                    bail!("stopped");
                }
                (outcome.path, outcome.moves.len() as u64)
            }
        };
        let seconds = begin.elapsed().as_secs_f64();
        let pieces = best.pieces();
        let row = Row {
            layout: layout.to_owned(),
            width: region.width(),
            height: region.height(),
            zones: zones.count(),
            seed,
            method: preset.map_or(MethodName::Zigzag, |_| MethodName::Anneal).name().to_owned(),
            preset: preset.map(|preset| preset.name().to_owned()),
            start: self.start.name().to_owned(),
            initial: crossings.count(start),
            crossings: crossings.count(&best),
            bound: Some(lower),
            pieces,
            // Fewer than one is impossible, and need not be proven by a matching.
            piece_bound: if pieces == 1 { 1 } else { piece_bound(region) },
            moves,
            seconds,
        };
        Ok((best, row))
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let instance = args.instance.load(args.seed)?;
    let Instance { region, zones, .. } = &instance;
    let (chosen, start) = args.start.path(region, || cover(region))?;
    let preset = (args.method == MethodName::Anneal).then_some(args.preset);
    let search = Search { region, zones, preset, seed: args.seed, start: chosen };
    let (best, row) = search.run(&instance.name, &start)?;
    if let Some(file) = &args.svg {
        let drawing = draw(&instance, &row, &start, &best);
        write_drawing(file, &drawing)?;
    }
    if args.json {
        return output::json(&json!(row));
    }
    let pieces = match row.pieces {
        1 => String::new(),
        pieces => format!(" in {pieces} pieces (at least {})", row.piece_bound),
    };
    output::text(&format!(
        "{} {}x{}, {} zones: {} -> {} crossings{pieces}, at least {}; {} moves in {:.3} s\n",
        row.layout,
        row.width,
        row.height,
        row.zones,
        row.initial,
        row.crossings,
        row.bound.unwrap_or_default(),
        row.moves,
        row.seconds
    ))
}

fn write_drawing(file: &FilePath, drawing: &str) -> anyhow::Result<()> {
    // A terminal or a pipe must be written to, not replaced.
    if fs::metadata(file).is_ok_and(|metadata| !metadata.is_file()) {
        return fs::write(file, drawing).with_context(|| format!("cannot write '{}'", file.display()));
    }
    Ok(write_whole(file, |out| out.write_all(drawing.as_bytes()))?)
}

fn draw(instance: &Instance, row: &Row, start: &Path, best: &Path) -> String {
    let Instance { region, zones, colours, .. } = instance;
    let titles = [
        format!("{}: {} crossings", row.start, row.initial),
        format!("{}: {} crossings", row.preset.as_ref().unwrap_or(&row.method), row.crossings),
    ];
    let paths = [start, best];
    let panels = [0, 1].map(|i| Panel { title: &titles[i], region, zones, path: Some(paths[i]) });
    let shown = if row.method == MethodName::Zigzag.name() { &panels[..1] } else { &panels[..] };
    svg(shown, colours.as_deref())
}
