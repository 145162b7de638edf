//! `eval fusion`: moves and time that FusionNet and other methods need to reach the annealer's best
//! result, by the protocol of Aali et al., Table 2.

mod accuracy;
mod instance;
mod tables;

use std::path::PathBuf;

use beadwork_base::Threads;
use beadwork_console::learned::{check_size, device};
use beadwork_console::{control, machine, output, progress};
use beadwork_dataset::{Dataset, Size};
use beadwork_grid::Layout;
use beadwork_learn::Device;
use beadwork_learn::fusion::model::{Model, Origin};
use beadwork_learn::fusion::propose::{AllMoves, NetworkProposer};
use beadwork_learn::fusion::walk;
use serde_json::{Map, Value, json};

use self::instance::{Instance, Row, walk_all};
use crate::args::positive;
use crate::paper;

/// Compare the moves and the time that FusionNet and other methods need to reach the best result of
/// the paper's annealer.
///
/// The target of an instance is the best of some annealing runs with the preset `paper`; the moves
/// and the time of the annealer are those of the run that reached it with the fewest moves.
/// The other methods are annealing with the preset `fast`, a greedy walk (the same walk without a
/// network: it makes the move that saves the most crossings, or a random one if none saves any),
/// the search for chains of moves from which the network learned, and the exact search.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork eval fusion
  beadwork eval fusion --model runs/fusion --seeds 5 --sizes 30x30,50x50
  beadwork eval fusion --data datasets/chains --json > fusion.json")]
pub(super) struct FusionArgs {
    /// Folder of the model.
    #[arg(long, value_name = "DIR", default_value = "models/fusion-small")]
    model: PathBuf,
    /// Number of seeds for each layout and size of fewer than 80x80 cells.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = positive::<u64>())]
    seeds: u64,
    /// Number of seeds for each layout and size of 80x80 cells or more.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = positive::<u64>())]
    large_seeds: u64,
    /// Sizes, separated by commas; the paper's six by default.
    #[arg(long, value_name = "WxH", value_delimiter = ',')]
    sizes: Vec<Size>,
    /// First seed of the instances.
    #[arg(long, value_name = "N", default_value_t = 0)]
    first_seed: u64,
    /// Annealing runs on each instance.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = positive::<u64>())]
    runs: u64,
    /// Maximum number of moves of a walk.
    #[arg(long, value_name = "N", default_value_t = walk::Settings::default().budget)]
    budget: usize,
    /// Number of positions whose moves the network proposes.
    #[arg(long, alias = "places", value_name = "N", default_value_t = 32)]
    positions: usize,
    /// Number of moves without a new best path after which random moves follow.
    #[arg(long, value_name = "N", default_value_t = walk::Settings::default().patience)]
    patience: usize,
    /// Dataset on which the network was trained: also report the accuracy on its test split, whose
    /// instances the network has not seen.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Number of moves to evaluate of each trajectory of the test split.
    #[arg(long, value_name = "N", default_value_t = 20, requires = "data")]
    per_trajectory: usize,
    /// Device on which the network computes.
    #[arg(
        long,
        value_name = "DEVICE",
        default_value = "cpu",
        value_parser = ["cpu", "cuda"]
    )]
    device: String,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

/// Layouts of the paper's Table 2.
const LAYOUTS: [Layout; 2] = [Layout::Voronoi, Layout::Islands];

/// Grids of this number of cells or more get `--large-seeds` seeds.
const LARGE_CELLS: u32 = 80 * 80;

/// Runs all methods on all instances, and prints the tables.
pub(super) fn run(args: &FusionArgs) -> anyhow::Result<()> {
    let device = device(&args.device)?;
    let model = Model::open(&args.model, device)?;
    let sizes = if args.sizes.is_empty() { &paper::SIZES[..] } else { &args.sizes };
    for size in sizes {
        check_size(&model, (size.width, size.height))?;
    }
    let data = args.data.as_deref().map(Dataset::open).transpose()?;
    if let Some(data) = &data {
        warn_if_other_dataset(data, &model);
    }
    let bar = progress::bar((sizes.len() * LAYOUTS.len()) as u64, "layouts and sizes");
    let mut rows = Vec::new();
    for size in sizes {
        for layout in LAYOUTS {
            rows.extend(args.compare(layout, (size.width, size.height), &model, device)?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let accuracy = data
        .map(|data| accuracy::on_test_split(&data, args.per_trajectory, &model, device))
        .transpose()?;
    if args.json {
        let held_out = accuracy.as_ref().map_or(Value::Object(Map::new()), accuracy::json);
        return output::json(&json!({
            "held_out": held_out,
            "model": args.model,
            "runs": args.runs,
            "budget": args.budget,
            "places": args.positions,
            "patience": args.patience,
            "machine": machine::facts(),
            "rows": rows,
        }));
    }
    let mut text = tables::text(&rows)?;
    if let Some(accuracy) = accuracy {
        accuracy::table(&mut text, &accuracy)?;
    }
    output::text(&text)
}

/// Warns if the network was not trained on this dataset: its test split may then contain instances
/// on which the network was trained.
fn warn_if_other_dataset(data: &Dataset, model: &Model) {
    let origin = Origin::of(data);
    if origin != model.origin {
        eprintln!(
            "beadwork: dataset {} ({} trajectories) is not the one the network was trained on, so \
             the network may have seen instances of its test split",
            origin.dataset, origin.trajectories
        );
    }
}

impl FusionArgs {
    /// Runs all methods on the instances of one layout and size.
    fn compare(
        &self,
        layout: Layout,
        size: (u32, u32),
        model: &Model,
        device: Device,
    ) -> anyhow::Result<Vec<Row>> {
        let control = &control::cancellable(Threads::One)?;
        let count = if size.0 * size.1 >= LARGE_CELLS { self.large_seeds } else { self.seeds };
        let instances: Vec<Instance> = (self.first_seed..self.first_seed + count)
            .map(|seed| Instance::new(layout, size, seed, self.runs))
            .collect::<anyhow::Result<_>>()?;
        let settings = walk::Settings {
            budget: self.budget,
            patience: self.patience,
            ..walk::Settings::default()
        };
        let mut network = NetworkProposer {
            positions: self.positions,
            ..NetworkProposer::new(&model.network, device)
        };
        let fusion = walk_all(&instances, &mut network, &settings, control)?;
        // The greedy walk misses targets with less patience, and gains nothing by returning to its
        // best path.
        let for_greedy = walk::Settings { patience: 32, returns: false, ..settings };
        let greedy = walk_all(&instances, &mut AllMoves { seed: 0 }, &for_greedy, control)?;
        let walks = fusion.into_iter().zip(greedy);
        instances
            .iter()
            .zip(walks)
            .map(|(instance, (fusion, greedy))| instance.row(fusion, greedy))
            .collect()
    }
}
