//! Parts from files: read, repaired, placed on the bed and sliced into layers.

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, bail};
use beadwork_base::Threads;
use beadwork_grid::Zones;
use beadwork_mesh::{
    Bounds, Example, Format, MaterialRule, Model, Placement, ReadLimits, RepairSettings, Transform,
};
use beadwork_part::slice::{Cut, FillRule, Layers, Settings, Voxels};
use clap::ValueEnum;
use rayon::ThreadPool;

use crate::control;
use crate::remarks;
use crate::text::count;

/// Prefix of a part that is built in rather than a file.
const EXAMPLE: &str = "example:";

/// Maximum number of materials, each of which needs a tool.
const MAX_TOOLS: usize = Zones::MAX as usize;

/// Flags that name a part and set how it is placed and sliced.
#[derive(Clone, clap::Args)]
pub struct PartArgs {
    /// Mesh files (STL, 3MF or OBJ) in one coordinate system, or built-in examples:
    /// example:rectangular, example:u-shape, example:pyramid, example:logo-plate, example:palette.
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
    /// Unit of STL and OBJ files, which do not state one.
    #[arg(long, value_name = "UNIT", default_value = "mm")]
    unit: Unit,
    /// Scale factor of the part.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, allow_hyphen_values = true)]
    scale: f64,
    /// Rotation of the part about x, then y, then z, in degrees.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true)]
    pub rotate: Numbers<3>,
    /// Position of the part's centre on the bed, in mm; the centre of the bed by default.
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    centre: Option<Numbers<2>>,
    /// Bead width in mm, which is also the side of a cell.
    #[arg(long, value_name = "MM", default_value_t = 0.5, allow_hyphen_values = true)]
    bead: f64,
    /// Maximum distance in mm of vertices that are merged where a surface is open.
    #[arg(long, value_name = "MM", default_value_t = 0.004, value_parser = distance)]
    merge: f64,
    /// Layer height in mm.
    #[arg(long, value_name = "MM", default_value_t = 0.25, allow_hyphen_values = true)]
    layer: f64,
    /// Fill rule for bodies whose surface intersects itself.
    #[arg(long, value_name = "RULE", default_value = "nonzero")]
    fill_rule: Fill,
    /// Which bodies share a material, and so a tool: as the files state (a body without a stated
    /// material gets its own), one per body, or one for all.
    #[arg(long, value_name = "RULE", default_value = "stated")]
    pub materials: Rule,
}

fn distance(text: &str) -> Result<f64, String> {
    let distance = text.parse().ok().filter(|distance| (0.0..=1.0).contains(distance));
    distance.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}

#[derive(Clone, Copy, ValueEnum)]
enum Unit {
    Um,
    Mm,
    Cm,
    M,
    In,
    Ft,
}

impl Unit {
    fn mm(self) -> f64 {
        match self {
            Self::Um => 1e-3,
            Self::Mm => 1.0,
            Self::Cm => 10.0,
            Self::M => 1e3,
            Self::In => 25.4,
            Self::Ft => 304.8,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum Fill {
    /// Nonzero winding number: overlapping shells are joined.
    Nonzero,
    /// Inside an odd number of outlines.
    Evenodd,
}

/// Value of `--materials`.
#[derive(Clone, Copy, ValueEnum)]
pub enum Rule {
    /// As the files state.
    Stated,
    /// One per body.
    Bodies,
    /// One for all bodies.
    One,
}

/// `N` numbers separated by commas.
#[derive(Clone, Copy)]
pub struct Numbers<const N: usize>(pub [f64; N]);

impl<const N: usize> FromStr for Numbers<N> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f64>> =
            text.split(',').map(|number| number.trim().parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        numbers.map(Self).ok_or_else(|| format!("expected {N} numbers separated by commas"))
    }
}

/// A part cut into outlines, which can be filled with the cells of any grid.
pub struct CutPart {
    /// Name of its first file.
    pub name: String,
    /// The mesh, repaired and placed on the bed.
    pub model: Model,
    /// The outlines of all layers.
    pub cut: Cut,
    /// Settings of the slicing, as the flags give them.
    pub settings: Settings,
    /// What was repaired, and what the files contain that is not used, each in one line.
    pub remarks: Vec<String>,
}

impl CutPart {
    /// Fills the outlines with the cells of a grid; `settings` must have the layer height of the
    /// cut.
    pub fn layers(&self, settings: &Settings, threads: Threads<'_>) -> anyhow::Result<Layers> {
        Ok(control::quiet(threads, |control| self.cut.layers(settings, control))??)
    }

    /// Combines the part with layers that [`CutPart::layers`] returned for these settings.
    ///
    /// Reports what the cells could not represent, each body on a line of stderr.
    pub fn with_layers(
        self,
        layers: Layers,
        settings: &Settings,
        threads: Threads<'_>,
    ) -> anyhow::Result<Part> {
        let coverage =
            control::quiet(threads, |control| self.cut.coverage(&layers, settings, control))??;
        let lost = remarks::of_coverage(&self.model, &coverage, settings);
        remarks::report(&lost);
        let bounds = self.model.bounds();
        let remarks = self.remarks.into_iter().chain(lost).collect();
        Ok(Part { name: self.name, model: self.model, layers, remarks, bounds })
    }
}

/// A part sliced into layers.
pub struct Part {
    /// Name of its first file.
    pub name: String,
    /// The mesh, repaired and placed on the bed.
    pub model: Model,
    /// The layers.
    pub layers: Layers,
    /// [`CutPart::remarks`], followed by what cells could not represent.
    pub remarks: Vec<String>,
    /// Bounding box of the placed mesh, in mm.
    pub bounds: Bounds,
}

impl Part {
    /// The part's name and its voxels, without empty layers below and above.
    ///
    /// Reports on stderr if the part is lowered to the plate.
    ///
    /// # Errors
    /// If a layer between others is empty.
    pub fn printed_voxels(self) -> anyhow::Result<(String, Voxels)> {
        check_layers(&self.layers)?;
        report_lowering(&self.layers);
        Ok((self.name, printed_voxels(&self.layers)))
    }
}

/// The voxels of all layers from the lowest to the highest one with cells.
pub fn printed_voxels(layers: &Layers) -> Voxels {
    let last = layers.layers.iter().rposition(Option::is_some).unwrap_or(0);
    let printed = layers.layers[layers.empty_below()..=last].to_vec();
    Layers { frame: layers.frame, layers: printed }.voxels()
}

impl PartArgs {
    /// The flags with their default values, for one part.
    pub fn usual(part: PathBuf) -> Self {
        Self {
            parts: vec![part],
            unit: Unit::Mm,
            scale: 1.0,
            rotate: Numbers([0.0; 3]),
            centre: None,
            merge: RepairSettings::default().max_merge_mm,
            bead: 0.5,
            layer: 0.25,
            fill_rule: Fill::Nonzero,
            materials: Rule::Stated,
        }
    }

    /// Whether any part is named; some commands also work without one.
    pub fn is_given(&self) -> bool {
        !self.parts.is_empty()
    }

    /// The part, if only one is named.
    pub fn only(&self) -> Option<&Path> {
        if let [part] = self.parts.as_slice() { Some(part) } else { None }
    }

    /// The same flags for each file on its own, all bodies of one material.
    pub fn of_each_file(&self) -> Vec<Self> {
        let one = |part: &PathBuf| Self {
            parts: vec![part.clone()],
            materials: Rule::One,
            ..self.clone()
        };
        self.parts.iter().map(one).collect()
    }

    /// Reads, repairs, places and slices the part.
    pub fn load(&self, bed_mm: [f64; 3], pool: &ThreadPool) -> anyhow::Result<Part> {
        let part = self.cut(bed_mm, pool)?;
        let layers = part.layers(&part.settings, Threads::Pool(pool))?;
        let settings = part.settings;
        part.with_layers(layers, &settings, Threads::Pool(pool))
    }

    /// Reads, repairs, places and cuts the part.
    /// Reports repairs and data that is not used, each on a line of stderr.
    pub fn cut(&self, bed_mm: [f64; 3], pool: &ThreadPool) -> anyhow::Result<CutPart> {
        let mut model = Model::default();
        let mut remarks = Vec::new();
        let repair = RepairSettings { max_merge_mm: self.merge };
        for path in &self.parts {
            let mut read = self.read(path)?;
            let warnings = read.warnings.drain(..);
            remarks.extend(warnings.map(|warning| format!("'{}': {warning}", path.display())));
            for (number, body) in read.bodies.iter_mut().enumerate() {
                if body.name.is_empty() {
                    body.name = match number {
                        0 => name_of(path),
                        _ => format!("{} {}", name_of(path), number + 1),
                    };
                }
                let done = control::quiet(Threads::One, |control| body.repair(&repair, control))?
                    .with_context(|| format!("'{}', body {}", path.display(), body.name))?;
                if !done.was_sound() {
                    remarks.push(remarks::of_repair(&body.name, &done));
                }
            }
            model.append(read).with_context(|| format!("cannot add '{}'", path.display()))?;
        }
        model.assign_materials(match self.materials {
            Rule::Stated => MaterialRule::Stated,
            Rule::Bodies => MaterialRule::PerBody,
            Rule::One => MaterialRule::Single,
        });
        if model.materials.len() > MAX_TOOLS {
            bail!(
                "part needs {} tools, one for each material, maximum is {MAX_TOOLS}: \
                 --materials one prints all bodies with one tool",
                model.materials.len()
            );
        }
        remarks.extend(model.warnings.iter().map(ToString::to_string));
        remarks::report(&remarks);
        let Numbers(rotation_degrees) = self.rotate;
        let centre_mm = self.centre.map(|Numbers(centre)| centre);
        Placement { scale: self.scale, rotation_degrees, centre_mm, bed_mm }.apply(&mut model)?;
        let settings = Settings {
            cell_mm: self.bead,
            layer_mm: self.layer,
            fill_rule: match self.fill_rule {
                Fill::Nonzero => FillRule::NonZero,
                Fill::Evenodd => FillRule::EvenOdd,
            },
            ..Settings::default()
        };
        let threads = Threads::Pool(pool);
        let cut =
            control::with_bar("slice", threads, |control| Cut::new(&model, &settings, control))??;
        Ok(CutPart { name: name_of(&self.parts[0]), model, cut, settings, remarks })
    }

    fn read(&self, path: &Path) -> anyhow::Result<Model> {
        if let Some(name) = path.to_str().and_then(|name| name.strip_prefix(EXAMPLE)) {
            return Ok(name.parse::<Example>()?.model());
        }
        let Some(format) = Format::from_file_name(&path.to_string_lossy()) else {
            bail!("{}: unknown extension; expected .stl, .3mf or .obj", path.display());
        };
        let in_file = || format!("cannot read '{}'", path.display());
        let bytes = fs::read(path).with_context(in_file)?;
        let mut model = control::with_bar("read", Threads::One, |control| {
            Model::read(format, &bytes, &ReadLimits::default(), control)
        })?
        .with_context(in_file)?;
        if format != Format::ThreeMf {
            let unit = Transform::scaling(self.unit.mm());
            model.bodies.iter_mut().for_each(|body| unit.apply(&mut body.mesh));
        }
        Ok(model)
    }
}

fn name_of(path: &Path) -> String {
    let text = path.to_string_lossy();
    if let Some(name) = text.strip_prefix(EXAMPLE) {
        return name.to_owned();
    }
    path.file_stem().map_or_else(|| text.to_string(), |stem| stem.to_string_lossy().into_owned())
}

/// Returns an error if a layer between two layers with cells is empty.
pub fn check_layers(layers: &Layers) -> anyhow::Result<()> {
    if let Some(layer) = layers.gap() {
        bail!("layer {} has no cells: the layers above it would be printed in the air", layer + 1);
    }
    Ok(())
}

/// Reports on stderr how many empty layers at the bottom are left out, if there are any.
pub fn report_lowering(layers: &Layers) {
    if layers.empty_below() > 0 {
        eprintln!(
            "beadwork: part lowered by {} without cells: its bottom is thinner than a bead",
            count(layers.empty_below() as u64, "layer")
        );
    }
}
