//! The parts that `eval parts` plans: built-in examples, and files of a public collection.

use std::path::Path;

use beadwork_console::part::{Numbers, Part, PartArgs, Rule};
use beadwork_console::printer::Profile;
use beadwork_console::progress;
use beadwork_mesh::Example;
use rayon::ThreadPool;

/// A part of the tables.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) part: Part,
    /// Whether the table of surfaces includes it; false if another case has the same shape.
    pub(super) is_new_shape: bool,
}

/// File, name in the tables, rotation about x in degrees, and rule for the materials.
const FILES: [(&str, &str, f64, Rule); 7] = [
    ("yin_yang.3mf", "yin_yang", 90.0, Rule::Stated),
    ("8_extruders.3mf", "8_extruders", 0.0, Rule::Stated),
    ("Bearing.3mf", "Bearing", 0.0, Rule::Stated),
    ("Bearing.3mf", "Bearing, 8 tools", 0.0, Rule::Bodies),
    ("torus.3mf", "torus", 0.0, Rule::Stated),
    ("heartgears.3mf", "heartgears", 0.0, Rule::Stated),
    ("dodeca_chain_loop_color.3mf", "dodeca_chain", 0.0, Rule::Stated),
];

/// Reads and slices all examples and the files in a folder.
/// Returns them with the names of the files that do not exist.
pub(super) fn load(
    folder: Option<&Path>,
    pool: &ThreadPool,
) -> anyhow::Result<(Vec<Case>, Vec<&'static str>)> {
    let bed_mm = Profile::for_tables().bed_mm();
    let bar = progress::bar((Example::ALL.len() + FILES.len()) as u64, "parts loaded");
    let mut cases = Vec::new();
    for example in Example::ALL {
        let part = PartArgs::usual(format!("example:{example}").into()).load(bed_mm, pool)?;
        cases.push(Case { name: example.name(), part, is_new_shape: true });
        bar.inc(1);
    }
    let mut missing = Vec::new();
    for (file, name, turn, materials) in FILES {
        bar.inc(1);
        let path = folder.map(|folder| folder.join(file)).filter(|path| path.exists());
        let Some(path) = path else {
            missing.push(file);
            continue;
        };
        let mut flags = PartArgs::usual(path);
        (flags.rotate, flags.materials) = (Numbers([turn, 0.0, 0.0]), materials);
        let is_new_shape = matches!(materials, Rule::Stated);
        cases.push(Case { name, part: flags.load(bed_mm, pool)?, is_new_shape });
    }
    missing.dedup();
    bar.finish_and_clear();
    Ok((cases, missing))
}
