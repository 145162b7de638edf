//! Flags of `plan`, and the files it writes.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::bail;
use beadwork_base::UnknownName;
use beadwork_console::bead_args::BeadArgs;
use beadwork_console::grid_choice::GridArgs;
use beadwork_console::output;
use beadwork_console::part::PartArgs;
use beadwork_console::printer::ProfileArgs;
use beadwork_heat::planner::Planner;
use beadwork_search::plan::Constraints;
use beadwork_search::plan::tools::{Mode, Settings, Stacking};
use beadwork_thermal::ThermalMaterial;
use beadwork_thermal::material::Preset as MaterialPreset;
use beadwork_thermal::objective::Weighted;
use clap::ValueEnum;

/// Plan a part and write its G-code.
///
/// Meshes are sliced into outlines, which are printed with insets, infill and solid layers: infill
/// lines are linked to the fewest beads, beads are ordered for short travel, and tools for the
/// fewest changes, each with a proven bound.
/// A lift is a break between two beads, followed by travel.
/// The text of the G-code is checked: it prints every bead once, within the outlines.
/// Supports are not generated.
///
/// --fill cells covers every layer with square cells one bead wide, each printed once: solid parts
/// whose beads may pass from one material to the next.
/// It is the default with --objective.
/// With --objective heat, the cells of each layer are printed in an order that keeps temperatures
/// even, within a limit on the printing time; with --fill beads, too, it is the lines of the infill
/// that are reordered, after the walls.
/// Its proofs of optimality hold for one grid of cells; --phases and --bead-range try other grids.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork plan part.stl --out part.gcode
  beadwork plan gears.3mf --density 15 --perimeters 3 --join --out gears.gcode --svg layers.svg
  beadwork plan example:logo-plate --objective tools --out logo.gcode
  beadwork plan yin_yang.3mf --rotate 90,0,0 --objective tools --out yin_yang.gcode --svg layers.svg
  beadwork plan body.stl inlay.stl --objective tools --mode free --flavour klipper --out badge.gcode
  beadwork plan plate.3mf --objective tools --lift-cost 50 --purge 90 --before 1:0 --json
  beadwork plan torus.3mf --objective tools --phases 4 --bead-range 10 --out torus.gcode
  beadwork plan example:u-shape --objective heat --max-time 1.05 --out u.gcode
  beadwork plan example:u-shape --objective heat --planner ppo --out u.gcode
  beadwork plan part.stl --objective heat --fill beads --density 100 --out part.gcode
  beadwork plan part.obj --unit in --bead 0.45 --layer 0.2 --profile printer.toml \\
    --objective tools --out part.gcode")]
pub(crate) struct Args {
    #[command(flatten)]
    pub(super) part: PartArgs,
    #[command(flatten)]
    pub(super) grid: GridArgs,
    /// What layers are filled with: beads (insets and infill), or cells.
    /// Beads, unless --objective is given.
    #[arg(long, value_name = "NAME")]
    fill: Option<FillName>,
    #[command(flatten)]
    pub(super) beads: BeadArgs,
    /// Objective to minimise: tools (purge volume of tool changes, plus --lift-cost for each lift),
    /// or heat (uneven temperature, which warps parts; for parts of one material).
    #[arg(long, value_name = "NAME")]
    objective: Option<Objective>,
    #[command(flatten)]
    pub(super) heat: HeatArgs,
    /// How layers are printed: in the fewest beads (continuous), tool by tool (free), or each layer
    /// in whichever of these two ways makes the part cheaper (cheapest).
    #[arg(long, value_name = "MODE", default_value = "cheapest")]
    mode: ModeName,
    /// Cost of a lift, in mm³ of purged material.
    #[arg(long, value_name = "MM3", default_value_t = 2)]
    pub(super) lift_cost: u32,
    /// Print with tool A before tool B in every layer that uses both; tools are numbered from 0, as
    /// in the G-code.
    /// Can be repeated.
    #[arg(long, value_name = "A:B")]
    before: Vec<Pair>,
    /// The tool that prints first, numbered from 0 as in the G-code.
    #[arg(long, value_name = "TOOL")]
    first_tool: Option<u8>,
    /// Use the tools in the same order in every layer.
    #[arg(long)]
    same_order: bool,
    /// Also start the search of each layer from the path of the layer below; of equally good paths,
    /// take the one that repeats more of that path (keep), or less of it (break).
    #[arg(long, value_name = "RULE")]
    stacking: Option<StackingName>,
    #[command(flatten)]
    pub(super) profile: ProfileArgs,
    /// G-code file to write; its totals are written to a JSON file of the same name with .json
    /// appended.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Draw up to six layers with their paths, as SVG.
    #[arg(long, value_name = "FILE")]
    pub(super) svg: Option<PathBuf>,
    /// Seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) seed: u64,
    /// Maximum number of attempts at each connected component of a layer.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 50,
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    attempts: u32,
    /// Threads; 0 for one per core.
    /// The result does not depend on them.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) threads: usize,
    /// Print one JSON document.
    #[arg(long)]
    pub(super) json: bool,
}

/// Flags of the objective heat.
#[derive(clap::Args)]
#[command(next_help_heading = "Even temperature (--objective heat)")]
pub(super) struct HeatArgs {
    /// How the order of each layer is chosen: conventional, constant (the same order in every
    /// layer), greedy, beam, smart-scan (a published method, for comparison), lines (orders of
    /// lines, annealed), or ppo (a trained policy); lines by default.
    #[arg(long, value_name = "NAME")]
    planner: Option<PlannerName>,
    /// Folder of the policy of --planner ppo; models/ppo-small by default.
    #[arg(long, value_name = "DIR")]
    policy: Option<PathBuf>,
    /// With --planner ppo: anneal the order of the lines of each layer after the policy, as lines
    /// does.
    #[arg(long)]
    refine: bool,
    /// Maximum printing time, as a multiple of that of the conventional order; 1.02 by default.
    #[arg(long, value_name = "FACTOR", value_parser = factor, allow_hyphen_values = true)]
    max_time: Option<f64>,
    /// What is even: weights of reward (deviation of temperatures at the layers' ends), no_travel
    /// (the same, if travel took no time), time_averaged and peak; reward=1,no_travel=2 by default.
    #[arg(long, value_name = "WEIGHTS")]
    even: Option<Weighted>,
    /// Material whose heat conduction is simulated: abs, pla or petg; abs by default.
    #[arg(long, value_name = "NAME")]
    thermal_material: Option<MaterialPreset>,
}

impl HeatArgs {
    /// A flag that is given.
    fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.planner.is_some(), "--planner"),
            (self.policy.is_some(), "--policy"),
            (self.refine, "--refine"),
            (self.max_time.is_some(), "--max-time"),
            (self.even.is_some(), "--even"),
            (self.thermal_material.is_some(), "--thermal-material"),
        ];
        flags.into_iter().find_map(|(is_given, flag)| is_given.then_some(flag))
    }

    /// How the part is planned.
    pub(super) fn planner(&self) -> PlannerName {
        self.planner.unwrap_or(PlannerName::Search(Planner::Lines))
    }

    /// Folder of the policy.
    pub(super) fn policy(&self) -> &Path {
        self.policy.as_deref().unwrap_or(Path::new("models/ppo-small"))
    }

    /// Whether the lines of a policy's plan are annealed.
    pub(super) fn refine(&self) -> bool {
        self.refine
    }

    /// A flag that does not go together with the planner, and why.
    fn misfit(&self) -> Option<&'static str> {
        if self.planner() != PlannerName::Ppo {
            if self.refine {
                return Some("--refine requires --planner ppo");
            }
            return self.policy.is_some().then_some("--policy requires --planner ppo");
        }
        let why = "--even does not go together with --planner ppo: a policy minimises what it was \
                   trained for";
        self.even.is_some().then_some(why)
    }

    pub(super) fn max_time(&self) -> f64 {
        self.max_time.unwrap_or(1.02)
    }

    /// What is planned for.
    pub(super) fn objective(&self) -> Weighted {
        self.even.clone().unwrap_or_else(Weighted::even)
    }

    pub(super) fn material(&self) -> ThermalMaterial {
        self.thermal_material.unwrap_or(MaterialPreset::Abs).material()
    }
}

/// Name of the planner that is a policy.
const PPO: &str = "ppo";

/// How the orders of the layers are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlannerName {
    /// By a planner that tries orders on the solver.
    Search(Planner),
    /// By a trained policy.
    Ppo,
}

impl FromStr for PlannerName {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        match text.parse().map(Self::Search) {
            Err(_) if text == PPO => Ok(Self::Ppo),
            Err(mut unknown) => {
                unknown.expected.push(PPO);
                Err(unknown)
            }
            planner => planner,
        }
    }
}

impl fmt::Display for PlannerName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Search(planner) => planner.fmt(f),
            Self::Ppo => f.write_str(PPO),
        }
    }
}

fn factor(text: &str) -> Result<f64, String> {
    let factor = text.parse().ok().filter(|&factor: &f64| factor.is_finite() && factor > 0.0);
    factor.ok_or_else(|| "expected a number above 0, such as 1.05".to_owned())
}

#[derive(Clone, Copy, ValueEnum)]
enum Objective {
    Tools,
    Heat,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FillName {
    Beads,
    Cells,
}

#[derive(Clone, Copy, ValueEnum)]
enum ModeName {
    Cheapest,
    Continuous,
    Free,
}

#[derive(Clone, Copy, ValueEnum)]
enum StackingName {
    Keep,
    Break,
}

/// Two tools.
#[derive(Clone, Copy)]
struct Pair(u8, u8);

impl FromStr for Pair {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let tool = |text: &str| text.trim().parse().ok();
        let pair = text.split_once(':').and_then(|(a, b)| Some(Self(tool(a)?, tool(b)?)));
        pair.ok_or_else(|| "expected two tools, numbered from 0, as in 1:0".to_owned())
    }
}

/// The files to write.
pub(super) struct Files<'a> {
    pub(super) gcode: Option<&'a Path>,
    /// File for the totals, beside the G-code; `None` if the G-code goes to a terminal or a pipe.
    pub(super) totals: Option<PathBuf>,
}

impl Files<'_> {
    /// The file of the totals, to follow the name of the G-code file in a sentence.
    pub(super) fn beside(&self) -> String {
        self.totals.as_ref().map_or_else(String::new, |totals| format!(" and {}", totals.display()))
    }
}

impl Args {
    /// The files to write.
    ///
    /// Reports a folder in place of a file before any work.
    pub(super) fn files(&self) -> anyhow::Result<Files<'_>> {
        let gcode = self.out.as_deref();
        let is_file = |path: &&Path| fs::metadata(path).map_or(true, |metadata| metadata.is_file());
        for path in [gcode, self.svg.as_deref()].into_iter().flatten() {
            if path.is_dir() {
                bail!("'{}' is a folder", path.display());
            }
        }
        let totals = gcode.filter(is_file).map(|path| {
            let mut name = path.as_os_str().to_owned();
            name.push(".json");
            PathBuf::from(name)
        });
        if self.svg.is_some() && (self.svg.as_deref() == gcode || self.svg == totals) {
            output::usage_error("--svg and --out name the same file");
        }
        Ok(Files { gcode, totals })
    }

    /// Whether the part is planned for even temperature.
    ///
    /// Reports flags that go together with no other objective, and those that do not go together
    /// with this one.
    pub(super) fn is_for_heat(&self) -> bool {
        let is_for_heat = matches!(self.objective, Some(Objective::Heat));
        if !is_for_heat && let Some(flag) = self.heat.given() {
            output::usage_error(&format!("{flag} requires --objective heat"));
        }
        if is_for_heat && self.has_beads() {
            if self.heat.planner() == PlannerName::Ppo {
                output::usage_error("--planner ppo plans cells: use --fill cells");
            }
            if self.beads.has_joined() {
                output::usage_error(
                    "--join does not go together with --objective heat: infill that is joined to \
                     walls cannot be reordered",
                );
            }
        }
        if let Some(misfit) = self.heat.misfit() {
            output::usage_error(misfit);
        }
        is_for_heat
    }

    /// Whether layers are filled with insets and infill rather than with cells.
    pub(super) fn has_beads(&self) -> bool {
        match self.fill {
            Some(fill) => fill == FillName::Beads,
            None => self.objective.is_none(),
        }
    }

    /// What the order of the tools must obey.
    pub(super) fn constraints(&self) -> Constraints {
        Constraints {
            before: self.before.iter().map(|&Pair(a, b)| (a, b)).collect(),
            first: self.first_tool,
            same_order: self.same_order,
            ..Constraints::default()
        }
    }

    /// Settings of the planner of cells.
    pub(super) fn settings(&self) -> Settings {
        Settings {
            mode: match self.mode {
                ModeName::Cheapest => Mode::Cheapest,
                ModeName::Continuous => Mode::Continuous,
                ModeName::Free => Mode::Free,
            },
            lift_cost: self.lift_cost.into(),
            constraints: self.constraints(),
            stacking: self.stacking.map(|rule| match rule {
                StackingName::Keep => Stacking::Keep,
                StackingName::Break => Stacking::Break,
            }),
            seed: self.seed,
            attempts: self.attempts,
            ..Settings::default()
        }
    }
}
