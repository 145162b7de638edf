//! Parts and shapes, laid out as insets, skeletons and infill.

use std::path::{Path, PathBuf};

use anyhow::Context;
use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_console::part::{Numbers, PartArgs};
use beadwork_console::printer::Profile;
use beadwork_mesh::Model;
use beadwork_part::slice::{Cut, LayerAreas, Settings as CutSettings};
use beadwork_part::toolpath::{Island, Settings, islands};
use beadwork_search::CostMatrix;
use rayon::ThreadPool;

use super::shapes::{LAYER_MM, Shape};

/// A shape or a part.
pub(super) struct Source {
    pub(super) name: String,
    /// Areas of the layers, from the bed up.
    pub(super) areas: Vec<LayerAreas>,
}

/// A shape or a part at one density of infill.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) toolpath: Settings,
    /// The islands of each layer.
    pub(super) layers: Vec<Vec<Island>>,
}

impl Source {
    /// A shape of the paper, in layers of [`LAYER_MM`].
    pub(super) fn shape(shape: Shape, control: &Control<'_>) -> anyhow::Result<Self> {
        Self::model(shape.name(), &shape.model(), control)
    }

    /// A generated model, in layers of [`LAYER_MM`].
    pub(super) fn model(name: &str, model: &Model, control: &Control<'_>) -> anyhow::Result<Self> {
        let settings = CutSettings { layer_mm: LAYER_MM, ..CutSettings::default() };
        let areas = Cut::new(model, &settings, control)?.areas(&settings, control)?;
        Ok(Self { name: name.to_owned(), areas })
    }

    /// A part from a file, see [`split_turn`].
    pub(super) fn part(argument: &Path, pool: &ThreadPool) -> anyhow::Result<Self> {
        let (path, turn) = split_turn(argument)?;
        let mut flags = PartArgs::usual(path);
        flags.rotate = Numbers([turn, 0.0, 0.0]);
        let part = flags.cut(Profile::for_tables().bed_mm(), pool)?;
        let areas = control::quiet(Threads::Pool(pool), |control| {
            part.cut.areas(&part.settings, control)
        })??;
        Ok(Self { name: part.name, areas })
    }
}

/// The path of an argument PART or PART@DEGREES, and the rotation about x in degrees.
fn split_turn(argument: &Path) -> anyhow::Result<(PathBuf, f64)> {
    let split =
        argument.to_str().filter(|_| !argument.exists()).and_then(|text| text.split_once('@'));
    let Some((path, turn)) = split else { return Ok((argument.to_owned(), 0.0)) };
    let turn = turn.parse().ok().filter(|turn: &f64| turn.is_finite());
    let turn = turn.with_context(|| format!("'{}': no rotation after @", argument.display()))?;
    Ok((path.into(), turn))
}

impl Case {
    /// Lays out a source with this density in per cent; without solid layers.
    pub(super) fn new(
        source: &Source,
        density: f64,
        control: &Control<'_>,
    ) -> anyhow::Result<Self> {
        let toolpath = Settings {
            density: density / 100.0,
            top_layers: 0,
            bottom_layers: 0,
            ..Settings::default()
        };
        let layers = islands(&source.areas, &toolpath, control)?;
        Ok(Self { name: source.name.clone(), toolpath, layers })
    }

    /// Equal costs between all tools.
    pub(super) fn costs(&self) -> CostMatrix {
        let tools = self.layers.iter().flatten().map(|island| usize::from(island.material) + 1);
        CostMatrix::uniform(tools.max().unwrap_or(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_may_name_a_rotation() {
        let split = |text: &str| split_turn(Path::new(text));
        assert_eq!(split("a/b.3mf").unwrap(), ("a/b.3mf".into(), 0.0));
        assert_eq!(split("a/b.3mf@-90").unwrap(), ("a/b.3mf".into(), -90.0));
        assert!(split("b.3mf@x").is_err());
    }
}
