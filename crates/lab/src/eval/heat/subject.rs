//! The parts that are planned: generated ones, and files.

use beadwork_console::part::PartArgs;
use beadwork_console::printer::Profile;
use beadwork_grid::region_components;
use beadwork_part::slice::Voxels;
use rayon::ThreadPool;

use crate::heat_parts::HeatPart;

/// A part with its name in the tables.
pub(super) struct Subject {
    pub(super) name: String,
    pub(super) voxels: Voxels,
}

impl Subject {
    /// A generated part.
    pub(super) fn generated(part: HeatPart) -> Self {
        Self { name: part.name().to_owned(), voxels: part.voxels() }
    }

    /// The part of each file, sliced as `plan` does; all of its bodies are one part.
    pub(super) fn from_files(files: &PartArgs, pool: &ThreadPool) -> anyhow::Result<Vec<Self>> {
        let bed_mm = Profile::for_tables().bed_mm();
        let load = |file: PartArgs| {
            let (name, voxels) = file.load(bed_mm, pool)?.printed_voxels()?;
            Ok(Self { name, voxels })
        };
        files.of_each_file().into_iter().map(load).collect()
    }

    /// Maximum number of connected components of a layer.
    pub(super) fn max_components(&self) -> anyhow::Result<u32> {
        let components = |layer| Ok(region_components(&self.voxels.region(layer)?).count());
        (0..self.voxels.depth)
            .map(components)
            .try_fold(0, |max, count: anyhow::Result<u32>| Ok(max.max(count?)))
    }
}
