//! Flags that name a printer profile, and the profile completed for the materials of a part.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, bail};
use beadwork_base::Control;
use beadwork_mesh::{Material, Model};
use beadwork_part::print::{
    self, Flavour, Layer, PrimeTower, Print, PrintError, Process, Purge, SettingsError, Title, Tool,
};
use beadwork_part::{BeadLayer, Frame};
use beadwork_search::CostMatrix;
use beadwork_search::travel::Retraction;
use clap::ValueEnum;
use ndarray::Array2;

use crate::cancel;
use crate::output::usage_error;
use crate::part::Numbers;

/// Flags of the printer.
#[derive(clap::Args)]
pub struct PrinterArgs {
    /// Profile with the printer, its tools and its speeds; see configs/plan/example.toml.
    #[arg(long, value_name = "FILE")]
    profile: Option<PathBuf>,
    /// Printable width, depth and height in mm; overrides the profile.
    #[arg(long, value_name = "X,Y,Z")]
    bed: Option<Numbers<3>>,
}

/// Flags of the printer and of the G-code.
#[derive(clap::Args)]
pub struct ProfileArgs {
    #[command(flatten)]
    printer: PrinterArgs,
    /// G-code dialect; overrides the profile.
    #[arg(long, value_name = "NAME")]
    flavour: Option<FlavourName>,
    /// Purge volume of every tool change in mm³; overrides the profile's purge matrix, which
    /// overrides the purge volumes of a 3MF project.
    /// 140 if none is given.
    #[arg(long, value_name = "MM3")]
    purge: Option<f64>,
    /// Prime tower: auto (that of the profile, or else one beside the part), none, or position and
    /// size LEFT,FRONT,WIDTH,DEPTH in mm.
    #[arg(long, value_name = "TOWER", default_value = "auto")]
    tower: TowerChoice,
}

#[derive(Clone, Copy, ValueEnum)]
enum FlavourName {
    Marlin,
    Klipper,
}

#[derive(Clone, Copy)]
enum TowerChoice {
    Auto,
    None,
    At(PrimeTower),
}

impl std::str::FromStr for TowerChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "none" => Ok(Self::None),
            _ => {
                let Numbers([left_mm, front_mm, width_mm, depth_mm]) = text
                    .parse()
                    .map_err(|_| "expected auto, none, or LEFT,FRONT,WIDTH,DEPTH".to_owned())?;
                Ok(Self::At(PrimeTower { left_mm, front_mm, width_mm, depth_mm }))
            }
        }
    }
}

/// Default purge volume of a tool change, in mm³: typical of a 0.4 mm nozzle between two colours.
const DEFAULT_PURGE_MM3: f64 = 140.0;

/// Distance between the part and the prime tower, in mm.
const TOWER_GAP_MM: f64 = 5.0;

/// The printer profile that the flags describe.
pub struct Profile {
    settings: print::Settings,
    purge: Option<f64>,
    tower: TowerChoice,
}

impl PrinterArgs {
    /// Reads the profile, or takes the default one, and applies the flags.
    pub fn load(&self) -> anyhow::Result<print::Settings> {
        let mut settings = print::Settings::default();
        if let Some(path) = &self.profile {
            let in_file = || format!("cannot read '{}'", path.display());
            let text = fs::read_to_string(path).with_context(in_file)?;
            settings = toml::from_str(&text).with_context(in_file)?;
        }
        if let Some(Numbers(bed_mm)) = self.bed {
            settings.printer.bed_mm = bed_mm;
        }
        Ok(settings)
    }
}

impl ProfileArgs {
    /// Reads the profile, or takes the default one, and applies the flags.
    pub fn load(&self) -> anyhow::Result<Profile> {
        let mut settings = self.printer.load()?;
        match self.flavour {
            Some(FlavourName::Marlin) => settings.printer.flavour = Flavour::Marlin,
            Some(FlavourName::Klipper) => settings.printer.flavour = Flavour::Klipper,
            None => {}
        }
        if self.purge.is_some_and(|purge| !(0.0..=1e6).contains(&purge)) {
            usage_error("--purge must be a volume from 0 to 1,000,000 mm³");
        }
        Ok(Profile { settings, purge: self.purge, tower: self.tower })
    }
}

impl Profile {
    /// The default profile with a bed of 400 x 400 mm, for tables of parts of all sizes.
    pub fn for_tables() -> Self {
        let mut settings = print::Settings::default();
        settings.printer.bed_mm = [400.0, 400.0, 210.0];
        Self { settings, purge: None, tower: TowerChoice::Auto }
    }

    /// Printable width, depth and height in mm.
    pub fn bed_mm(&self) -> [f64; 3] {
        self.settings.printer.bed_mm
    }

    /// The purge volumes that the file of a part states, unless the flags or the profile do.
    fn purge_of<'a>(&self, model: &'a Model) -> Option<&'a Array2<f64>> {
        let is_stated = self.purge.is_some() || self.settings.purge.is_some();
        model
            .purge_mm3
            .as_ref()
            .filter(|purge| !is_stated && purge.nrows() == model.materials.len())
    }

    /// Reports on stderr if the purge volumes are those of the part's file.
    pub fn report_purge(&self, model: &Model) {
        if model.materials.len() > 1 && self.purge_of(model).is_some() {
            eprintln!("beadwork: purge volumes are those of the project; --purge overrides them");
        }
    }

    /// Settings with one tool for each material of a part.
    ///
    /// An automatic prime tower has no position yet; [`Profile::print`] finds it.
    pub fn complete(&self, model: &Model) -> anyhow::Result<print::Settings> {
        let materials = &model.materials;
        let mut settings = self.settings.clone();
        let given = settings.tools.clone();
        let tool = |(number, material): (usize, &Material)| {
            let base = given.get(number).or(given.last()).cloned().unwrap_or_default();
            let is_own = number < given.len();
            let named = Tool { name: material.name.clone(), ..base.clone() };
            let colour = material.colour.filter(|_| !is_own).unwrap_or(base.colour);
            Tool { colour, ..if is_own && !base.name.is_empty() { base } else { named } }
        };
        settings.tools = materials.iter().enumerate().map(tool).collect();
        let count = materials.len();
        let tower = match self.tower {
            TowerChoice::At(tower) => Some(tower),
            TowerChoice::Auto | TowerChoice::None => None,
        };
        settings.purge = match (settings.purge.take(), self.purge) {
            (Some(purge), None) => {
                if purge.volume_mm3.len() < count {
                    bail!(
                        "profile: purge matrix covers {} tools, the part has {count} materials",
                        purge.volume_mm3.len()
                    );
                }
                // A printer may have more tools than the part has materials.
                let cut = |row: Vec<f64>| row.into_iter().take(count).collect();
                let volume_mm3 = purge.volume_mm3.into_iter().take(count).map(cut).collect();
                Some(Purge { volume_mm3, tower: tower.or(purge.tower) })
            }
            (given, purge) => {
                let tower = tower.or(given.and_then(|given| given.tower));
                Some(match self.purge_of(model) {
                    Some(stated) => {
                        let rows = stated.rows().into_iter();
                        Purge { volume_mm3: rows.map(|row| row.to_vec()).collect(), tower }
                    }
                    None => Purge::uniform(count, purge.unwrap_or(DEFAULT_PURGE_MM3), tower),
                })
            }
        };
        if matches!(self.tower, TowerChoice::None) {
            settings.purge.iter_mut().for_each(|purge| purge.tower = None);
        }
        Ok(settings)
    }

    /// Writes planned layers of cells as G-code.
    ///
    /// Returns the print and the settings, in which an automatic prime tower has its position.
    pub fn print(
        &self,
        name: &str,
        layers: &[Layer<'_>],
        frame: &Frame,
        settings: print::Settings,
    ) -> anyhow::Result<(Print, print::Settings)> {
        self.print_with(frame, settings, |settings, control| {
            Print::new(title(name), layers, frame, settings, control)
        })
    }

    /// Writes planned layers of beads as G-code.
    ///
    /// Returns the print and the settings, in which an automatic prime tower has its position.
    pub fn print_beads(
        &self,
        name: &str,
        layers: &[BeadLayer],
        frame: &Frame,
        settings: print::Settings,
    ) -> anyhow::Result<(Print, print::Settings)> {
        self.print_with(frame, settings, |settings, control| {
            Print::of_beads(title(name), layers, frame, settings, control)
        })
    }

    /// What a retraction costs, with its undoing and the z-hop; `None` without retraction.
    pub fn retraction(&self) -> Option<Retraction> {
        let process = &self.settings.process;
        let Process { retract_mm, retract_mm_s, retract_beyond_mm, z_hop_mm, travel_mm_s, .. } =
            *process;
        let cost_mm = 2.0 * (retract_mm / retract_mm_s * travel_mm_s + z_hop_mm);
        let is_usual = retract_mm > 0.0 && cost_mm.is_finite() && retract_beyond_mm.is_finite();
        is_usual.then_some(Retraction { beyond_mm: retract_beyond_mm.max(0.0), cost_mm })
    }

    /// Middle of the prime tower, x and y in mm; of an automatic one, if it fits where it is tried
    /// first.
    pub fn tower_mm(&self, frame: &Frame, settings: &print::Settings) -> Option<[f64; 2]> {
        let given = settings.purge.as_ref().and_then(|purge| purge.tower);
        let is_auto = matches!(self.tower, TowerChoice::Auto) && settings.tools.len() > 1;
        let first = || tower_candidates(frame, settings.printer.bed_mm).into_iter().next();
        let tower = given.or_else(|| if is_auto { first() } else { None })?;
        Some([tower.left_mm + tower.width_mm / 2.0, tower.front_mm + tower.depth_mm / 2.0])
    }

    /// Writes a print, with each position of an automatic prime tower until one has room for it.
    fn print_with(
        &self,
        frame: &Frame,
        mut settings: print::Settings,
        write: impl Fn(&print::Settings, &Control<'_>) -> Result<Print, PrintError>,
    ) -> anyhow::Result<(Print, print::Settings)> {
        let control = Control { cancel: Some(cancel::token()?), ..Control::default() };
        let has_position = settings.purge.as_ref().is_none_or(|purge| purge.tower.is_some());
        if has_position || settings.tools.len() < 2 || !matches!(self.tower, TowerChoice::Auto) {
            return Ok((write(&settings, &control)?, settings));
        }
        let mut refusal = None;
        for tower in tower_candidates(frame, settings.printer.bed_mm) {
            settings.purge.iter_mut().for_each(|purge| purge.tower = Some(tower));
            match write(&settings, &control) {
                Ok(print) => return Ok((print, settings)),
                Err(
                    error @ PrintError::Settings(
                        SettingsError::PrimeTowerDepth { .. }
                        | SettingsError::PrimeTowerWidth { .. },
                    ),
                ) => {
                    refusal = Some(error);
                }
                Err(error) => return Err(error.into()),
            }
        }
        match refusal {
            Some(error) => Err(error)
                .context("prime tower: no room beside the part; --tower none prints without one"),
            None => {
                bail!("prime tower: no room beside the part; --tower none prints without one")
            }
        }
    }
}

/// Title of the program of a part.
fn title(part: &str) -> Title<'_> {
    Title { part, version: env!("CARGO_PKG_VERSION") }
}

/// Candidate prime towers beside, behind and in front of the part, small ones first.
fn tower_candidates(frame: &Frame, [bed_x, bed_y, _]: [f64; 3]) -> Vec<PrimeTower> {
    let [left, front, right, back] = frame.sides_mm();
    let (left, right) = (left - TOWER_GAP_MM, right + TOWER_GAP_MM);
    let (front, back) = (front - TOWER_GAP_MM, back + TOWER_GAP_MM);
    let mut towers = Vec::new();
    for size in [20.0, 40.0, 60.0, 90.0, 130.0, 180.0, 250.0, 400.0] {
        let beside =
            |left_mm: f64| PrimeTower { left_mm, front_mm: 0.0, width_mm: size, depth_mm: bed_y };
        let before = |front_mm: f64, depth_mm: f64| PrimeTower {
            left_mm: (bed_x - size) / 2.0,
            front_mm,
            width_mm: size,
            depth_mm,
        };
        // As close to the part as possible, and at most twice as deep as wide: thin towers fall
        // over.
        let shallow = |tower: PrimeTower| {
            let depth_mm = tower.depth_mm.min(2.0 * size);
            let free = tower.depth_mm - depth_mm;
            let front_mm = if free > 0.0 && tower.front_mm == 0.0 {
                (free / 2.0).max(0.0)
            } else {
                tower.front_mm
            };
            PrimeTower { depth_mm, front_mm, ..tower }
        };
        if right + size <= bed_x {
            towers.push(shallow(beside(right)));
        }
        if size <= left {
            towers.push(shallow(beside(left - size)));
        }
        if size <= bed_x && back < bed_y {
            towers.push(shallow(before(back, bed_y - back)));
        }
        if size <= bed_x && front > 0.0 {
            towers.push(PrimeTower {
                front_mm: (front - 2.0 * size).max(0.0),
                ..before(0.0, front.min(2.0 * size))
            });
        }
        if right + size <= bed_x {
            towers.push(beside(right));
        }
        if size <= left {
            towers.push(beside(left - size));
        }
    }
    towers
}

/// Cost of each tool change: its purge volume in whole mm³, and at least 1, since every change
/// takes time.
pub fn tool_costs(purge: &Purge) -> anyhow::Result<CostMatrix> {
    let volume = |from: usize, to: usize| purge.volume_mm3[from][to];
    let cost = |from, to| volume(from, to).round().max(1.0);
    Ok(CostMatrix::from_fn(purge.volume_mm3.len(), cost)?)
}
