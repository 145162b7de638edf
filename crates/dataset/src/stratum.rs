//! Strata: the combinations of instance, preset and start that a dataset is made of.

use std::sync::Arc;

use beadwork_base::{Control, Interrupted};
use beadwork_grid::{Crossings, LayoutSpec, Path, Region, Start, StartError, Zones};
use beadwork_part::{Picture, PictureError};
use beadwork_search::{Move, Stop, anneal, chains, genetic};
use thiserror::Error;

use crate::config::ConfigError;
use crate::size::Size;
use crate::source::Search;
use crate::start_choice::StartChoice;
use crate::trajectory::{DrawError, Instance};

/// Why trajectories cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FactoryError {
    /// The configuration is invalid.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A picture cannot be read.
    #[error("picture '{name}.png'")]
    Picture {
        /// Name of its file, without extension.
        name: String,
        /// What is wrong with it.
        source: PictureError,
    },
    /// There are no pictures.
    #[error("no PNG pictures to search")]
    NoPictures,
    /// A layout cannot be drawn in a size.
    #[error("{stratum}: {cause}")]
    Draw {
        /// Name of the combination, as in the manifest.
        stratum: String,
        /// What is wrong with it.
        cause: DrawError,
    },
    /// A start does not exist on an instance.
    #[error("{stratum}: {cause}")]
    Start {
        /// Name of the combination, as in the manifest.
        stratum: String,
        /// Where the start would jump.
        cause: StartError,
    },
    /// The control ended the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// One combination of instance, preset and start.
#[derive(Debug)]
pub(crate) struct Stratum {
    /// Name in the manifest: `voronoi/30x30/paper`, for example.
    pub(crate) name: String,
    pub(crate) search: Search,
    source: InstanceSource,
    start: StartChoice,
}

/// What instances are drawn from.
#[derive(Clone, Debug)]
pub(crate) enum InstanceSource {
    /// A layout in a size; random layouts differ from instance to instance.
    Layout(LayoutSpec, Size),
    /// A picture, which is the same in all instances.
    Picture(Arc<PictureSource>),
}

/// A picture, with everything that its trajectories share.
#[derive(Debug)]
pub(crate) struct PictureSource {
    name: String,
    region: Region,
    zones: Zones,
    cover: Path,
}

/// The result of a search.
pub(crate) struct SearchResult {
    /// Crossings of the start path.
    pub(crate) initial: u32,
    /// Crossings of the best path.
    pub(crate) best: u32,
    /// The moves to the best path.
    pub(crate) moves: Vec<Move>,
}

impl PictureSource {
    /// Reads a PNG picture and computes its path cover.
    pub(crate) fn new(
        name: &str,
        bytes: &[u8],
        control: &Control<'_>,
    ) -> Result<Self, FactoryError> {
        let Picture { region, zones, .. } = Picture::from_png(bytes)
            .map_err(|source| FactoryError::Picture { name: name.to_owned(), source })?;
        let cover = beadwork_grid::cover(&region, control)?;
        Ok(Self { name: name.to_owned(), region, zones, cover })
    }
}

impl Stratum {
    /// `name_the_start` appends the start to the stratum's name.
    pub(crate) fn new(
        source: InstanceSource,
        search: Search,
        start: StartChoice,
        name_the_start: bool,
    ) -> Self {
        let instance = match &source {
            InstanceSource::Layout(spec, size) if *spec == LayoutSpec::new(spec.layout) => {
                format!("{}/{size}", spec.layout)
            }
            InstanceSource::Layout(spec, size) => {
                format!("{}-{}-{}/{size}", spec.layout, spec.zones, spec.side)
            }
            InstanceSource::Picture(picture) => picture.name.clone(),
        };
        let start_name = if name_the_start { format!("/{start}") } else { String::new() };
        Self { name: format!("{instance}/{search}{start_name}"), search, source, start }
    }

    /// Draws an instance; layouts that are not random ignore the seed.
    pub(crate) fn draw(&self, seed: u64) -> Result<(Instance, Region, Zones), FactoryError> {
        match &self.source {
            &InstanceSource::Layout(LayoutSpec { layout, zones, side }, size) => {
                let seed = if layout.is_random() { seed } else { 0 };
                let instance = Instance::Layout { layout, side, zones, seed };
                let drawn = instance.draw(size.width, size.height);
                let (region, zones) = drawn
                    .map_err(|cause| FactoryError::Draw { stratum: self.name.clone(), cause })?;
                Ok((instance, region, zones))
            }
            InstanceSource::Picture(picture) => {
                let ids = picture.zones.ids().to_vec();
                let instance = Instance::Picture { name: picture.name.clone(), ids };
                Ok((instance, picture.region.clone(), picture.zones.clone()))
            }
        }
    }

    /// The start and its path on an instance's region.
    pub(crate) fn start(
        &self,
        region: &Region,
        control: &Control<'_>,
    ) -> Result<(Start, Path), FactoryError> {
        let cover = || match &self.source {
            InstanceSource::Picture(picture) => Ok(picture.cover.clone()),
            InstanceSource::Layout(..) => beadwork_grid::cover(region, control),
        };
        self.start.path(region, cover).map_err(|error| match error {
            StartError::Interrupted(interrupted) => interrupted.into(),
            cause => FactoryError::Start { stratum: self.name.clone(), cause },
        })
    }

    /// Searches from a path until the crossings reach the proven lower bound or the search ends.
    pub(crate) fn run(
        &self,
        path: &Path,
        crossings: &Crossings,
        bound: u32,
        seed: u64,
        control: &Control<'_>,
    ) -> Result<SearchResult, Interrupted> {
        let proven_bound = Some(i64::from(bound));
        let (stop, initial, best, moves) = match self.search {
            Search::Anneal(preset) => {
                let settings =
                    anneal::Settings { proven_bound, ..anneal::Settings::preset(preset, seed) };
                let outcome = anneal::solve(path, crossings, &settings, control);
                (outcome.stop, outcome.initial, outcome.cost, outcome.moves)
            }
            Search::Genetic(preset) => {
                let settings =
                    genetic::Settings { proven_bound, ..genetic::Settings::preset(preset, seed) };
                let outcome = genetic::solve(path, crossings, &settings, control);
                (outcome.stop, outcome.initial, outcome.cost, outcome.moves)
            }
            Search::Chains(preset) => {
                let settings =
                    chains::Settings { proven_bound, ..chains::Settings::preset(preset, seed) };
                let outcome = chains::solve(path, crossings, &settings, control);
                (outcome.stop, outcome.initial, outcome.cost, outcome.moves)
            }
        };
        // The best path of an interrupted search depends on the time of the interruption, so it is
        // not recorded.
        match stop {
            Stop::Cancelled => Err(Interrupted::Cancelled),
            Stop::TimeUp => Err(Interrupted::TimeUp),
            _ => Ok(SearchResult { initial: initial as u32, best: best as u32, moves }),
        }
    }
}
