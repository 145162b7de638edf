//! Makes the trajectories of a configuration, each from its number alone.

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use beadwork_base::{Control, Interrupted};
use beadwork_grid::{Crossings, LayoutError, LayoutSpec, Path, Region, Start, StartError, Zones};
use beadwork_part::{Picture, PictureError};
use beadwork_search::{Move, anneal, bound, chains, genetic};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::config::{Config, ConfigError, Size, StartChoice};
use crate::manifest::fingerprint;
use crate::shard::hex;
use crate::source::Search;
use crate::trajectory::{DrawError, Instance, Moves, Trajectory};

/// A configuration with its pictures, ready to make trajectories.
///
/// Trajectory i depends on the configuration, the pictures and i alone: it has a random stream of
/// its own.
#[derive(Debug)]
pub struct Factory {
    config: Config,
    echo: serde_json::Value,
    strata: Vec<Stratum>,
    fingerprint: u64,
}

/// Times that an instance without room for its islands is drawn anew.
const MAX_REDRAWS: u32 = 100;

/// One combination of instance, preset and start.
#[derive(Debug)]
struct Stratum {
    drawn: Drawn,
    search: Search,
    start: StartChoice,
    name: String,
}

/// What instances are drawn from.
#[derive(Clone, Debug)]
enum Drawn {
    Layout(LayoutSpec, Size),
    Picture(Arc<PictureSource>),
}

/// What a search found.
struct Found {
    /// Crossings of the start.
    initial: u32,
    /// Crossings of the best path.
    best: u32,
    /// The moves to it.
    moves: Vec<Move>,
}

/// A picture with what all its trajectories share.
#[derive(Debug)]
struct PictureSource {
    name: String,
    region: Region,
    zones: Zones,
    cover: Path,
}

/// Why a [`Factory`] can't work.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FactoryError {
    /// The configuration contradicts itself.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A picture can't be read.
    #[error("picture '{name}.png'")]
    Picture {
        /// Its file's name, without extension.
        name: String,
        /// What is wrong with it.
        source: PictureError,
    },
    /// There are no pictures.
    #[error("there are no PNG pictures to search")]
    NoPictures,
    /// A layout can't be drawn in a size.
    #[error("{stratum}: {cause}")]
    Draw {
        /// The combination, as in the manifest.
        stratum: String,
        /// What is wrong with it.
        cause: DrawError,
    },
    /// A start does not exist on an instance.
    #[error("{stratum}: {cause}")]
    Start {
        /// The combination, as in the manifest.
        stratum: String,
        /// Where it breaks.
        cause: StartError,
    },
    /// The control ended the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl Factory {
    /// Takes a configuration, and the pictures of its folder if it names one: their names and their
    /// files' bytes.
    ///
    /// Every combination is tried once, so that an impossible one is found before hours of work.
    pub fn new(config: Config, mut pictures: Vec<(String, Vec<u8>)>) -> Result<Self, FactoryError> {
        config.check()?;
        pictures.sort();
        let mut echo = serde_json::to_value(&config).expect("a configuration is plain data");
        let sources: Vec<Drawn> = if config.pictures.is_some() {
            if pictures.is_empty() {
                return Err(FactoryError::NoPictures);
            }
            // The pictures count, not the folder they came from: two machines may keep them in two
            // places.
            let listed = pictures.iter().map(
                |(name, bytes)| json!({ "name": name, "sha256": hex(&Sha256::digest(bytes)) }),
            );
            echo["pictures"] = listed.collect();
            let read = |(name, bytes): &(String, Vec<u8>)| {
                picture(name, bytes).map(|it| Drawn::Picture(Arc::new(it)))
            };
            pictures.iter().map(read).collect::<Result<_, _>>()?
        } else {
            let sizes = |layout: LayoutSpec| {
                config.sizes.iter().map(move |&size| Drawn::Layout(layout, size))
            };
            config.layouts.iter().flat_map(|layout| sizes(layout.spec())).collect()
        };

        let searches = config.searches().map_err(ConfigError::from)?;
        let mut strata = Vec::new();
        for source in sources {
            for &search in &searches {
                for start in &config.starts {
                    strata.push(Stratum::new(
                        source.clone(),
                        search,
                        start.0,
                        config.starts.len() > 1,
                    ));
                }
            }
        }
        let mut names = HashSet::new();
        if let Some(twice) = strata.iter().find(|stratum| !names.insert(&stratum.name)) {
            return Err(ConfigError::Twice(twice.name.clone()).into());
        }
        for stratum in &strata {
            let (_, region, _) = stratum.draw(0)?;
            stratum.start(&region)?;
        }
        let fingerprint = fingerprint(env!("CARGO_PKG_VERSION"), &echo);
        Ok(Self { config, echo, strata, fingerprint })
    }

    /// The configuration it was made from.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The configuration with all defaults, and with the pictures' checksums in place of their
    /// folder.
    pub fn echo(&self) -> &serde_json::Value {
        &self.echo
    }

    /// A number that tells configurations and versions of this crate apart.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// The combinations with the number of trajectories of each.
    pub fn strata(&self) -> impl Iterator<Item = (&str, u64)> {
        let (count, strata) = (self.config.count, self.strata.len() as u64);
        (0..).zip(&self.strata).map(move |(place, stratum)| {
            (stratum.name.as_str(), count / strata + u64::from(place < count % strata))
        })
    }

    /// The name of the combination that a trajectory belongs to.
    pub fn stratum(&self, index: u64) -> &str {
        &self.stratum_of(index).name
    }

    fn stratum_of(&self, index: u64) -> &Stratum {
        &self.strata[(index % self.strata.len() as u64) as usize]
    }

    /// Runs the search of one number; `None` if it was cancelled.
    ///
    /// Costs what the search does: 1 to 20 ms with the paper's annealers and sizes, seconds with
    /// the genetic algorithm.
    pub fn trajectory(
        &self,
        index: u64,
        cancel: &AtomicBool,
    ) -> Result<Option<Trajectory>, FactoryError> {
        let stratum = self.stratum_of(index);
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        rng.set_stream(index);
        let (mut instance_seed, seed) = (rng.next_u64(), rng.next_u64());
        let mut redraws = 0;
        let (instance, region, zones) = loop {
            match stratum.draw(instance_seed) {
                // A crowded layout finds room for its islands with some seeds only.
                Err(FactoryError::Draw {
                    cause: DrawError::Layout(LayoutError::NoRoom { .. }),
                    ..
                }) if redraws < MAX_REDRAWS => {
                    redraws += 1;
                    instance_seed = rng.next_u64();
                }
                drawn => break drawn?,
            }
        };
        let (start, path) = stratum.start(&region)?;
        let crossings = Crossings::new(&region, &zones);
        let pieces = path.pieces();
        let bound = bound::components(&region, &zones, pieces);
        let found = stratum.run(path, &crossings, bound, seed, cancel);
        let Some(Found { initial, best, moves }) = found else { return Ok(None) };
        Ok(Some(Trajectory {
            index,
            instance,
            width: region.width() as u16,
            height: region.height() as u16,
            zones: zones.count() as u8,
            search: stratum.search,
            seed,
            start,
            pieces,
            initial,
            best,
            bound: Some(bound),
            moves: Moves::record(&moves, &crossings, region.width()),
        }))
    }
}

impl Stratum {
    fn new(drawn: Drawn, search: Search, start: StartChoice, name_the_start: bool) -> Self {
        let instance = match &drawn {
            Drawn::Layout(spec, size) if *spec == LayoutSpec::new(spec.layout) => {
                format!("{}/{size}", spec.layout)
            }
            Drawn::Layout(spec, size) => {
                format!("{}-{}-{}/{size}", spec.layout, spec.zones, spec.side)
            }
            Drawn::Picture(picture) => picture.name.clone(),
        };
        let start_name = if name_the_start { format!("/{start}") } else { String::new() };
        Self { drawn, search, start, name: format!("{instance}/{search}{start_name}") }
    }

    fn draw(&self, seed: u64) -> Result<(Instance, Region, Zones), FactoryError> {
        match &self.drawn {
            &Drawn::Layout(LayoutSpec { layout, zones, side }, size) => {
                let seed = if layout.is_random() { seed } else { 0 };
                let instance = Instance::Layout { layout, side, zones, seed };
                let drawn = instance.draw(size.width, size.height);
                let (region, zones) = drawn
                    .map_err(|cause| FactoryError::Draw { stratum: self.name.clone(), cause })?;
                Ok((instance, region, zones))
            }
            Drawn::Picture(picture) => {
                let ids = picture.zones.ids().to_vec();
                let instance = Instance::Picture { name: picture.name.clone(), ids };
                Ok((instance, picture.region.clone(), picture.zones.clone()))
            }
        }
    }

    /// Searches from a path; `None` if it was cancelled.
    fn run(
        &self,
        path: Path,
        crossings: &Crossings,
        bound: u32,
        seed: u64,
        cancel: &AtomicBool,
    ) -> Option<Found> {
        let proven_bound = Some(i64::from(bound));
        let is_cancelled = || cancel.load(Ordering::Relaxed);
        let control = &Control { time_is_up: Some(&is_cancelled), ..Control::default() };
        let (stop, initial, best, moves) = match self.search {
            Search::Anneal(preset) => {
                let settings =
                    anneal::Settings { proven_bound, ..anneal::Settings::preset(preset, seed) };
                let outcome = anneal::solve(&path, crossings, &settings, control);
                (outcome.stop, outcome.initial, outcome.cost, outcome.moves)
            }
            Search::Genetic(preset) => {
                let settings =
                    genetic::Settings { proven_bound, ..genetic::Settings::preset(preset, seed) };
                let outcome = genetic::solve(&path, crossings, &settings, control);
                (outcome.stop, outcome.initial, outcome.cost, outcome.moves)
            }
            Search::Chains(preset) => {
                let settings =
                    chains::Settings { proven_bound, ..chains::Settings::preset(preset, seed) };
                let outcome = chains::solve(&path, crossings, &settings, control);
                (outcome.stop, outcome.initial, outcome.cost, outcome.moves)
            }
        };
        (!stop.is_interrupted()).then_some(Found {
            initial: initial as u32,
            best: best as u32,
            moves,
        })
    }

    fn start(&self, region: &Region) -> Result<(Start, Path), FactoryError> {
        let cover = || match &self.drawn {
            Drawn::Picture(picture) => Ok(picture.cover.clone()),
            Drawn::Layout(..) => beadwork_grid::cover(region, &Control::default()),
        };
        let start = self.start.path(region, cover);
        start.map_err(|cause| FactoryError::Start { stratum: self.name.clone(), cause })
    }
}

fn picture(name: &str, bytes: &[u8]) -> Result<PictureSource, FactoryError> {
    let Picture { region, zones, .. } = Picture::from_png(bytes)
        .map_err(|source| FactoryError::Picture { name: name.to_owned(), source })?;
    let cover = beadwork_grid::cover(&region, &Control::default())?;
    Ok(PictureSource { name: name.to_owned(), region, zones, cover })
}

#[cfg(test)]
mod tests {
    use super::*;

    static NEVER: AtomicBool = AtomicBool::new(false);

    fn factory(toml: &str) -> Factory {
        Factory::new(Config::from_toml(toml).unwrap(), Vec::new()).unwrap()
    }

    #[test]
    fn strata_share_the_trajectories() {
        let factory = Factory::new(Config::preset("paper").unwrap(), Vec::new()).unwrap();
        let strata: Vec<_> = factory.strata().collect();
        assert_eq!(strata.len(), 4 * 6 * 5);
        assert_eq!(strata.iter().map(|(_, count)| count).sum::<u64>(), 22_111);
        assert!(strata.iter().all(|(_, count)| (184..=185).contains(count)));
        assert_eq!(strata[0].0, "left_right/30x30/paper");
        assert_eq!(factory.stratum(120), "left_right/30x30/paper");
    }

    #[test]
    fn a_number_names_one_trajectory_that_replays() {
        let factory = factory(
            "count = 40\nsizes = ['12x9', '8x20']\npresets = ['short', 'fast']\nstarts = ['spiral', 'cover']\n\
             layouts = [{ name = 'voronoi' }, { name = 'islands', zones = 3, side = 3 }, { name = 'checkerboard' }]",
        );
        for index in [0, 1, 2, 3, 7, 12, 23] {
            let first = factory.trajectory(index, &NEVER).unwrap().unwrap();
            assert_eq!(factory.trajectory(index, &NEVER).unwrap().unwrap(), first);
            first.replay().unwrap();
        }
        let seeds = [0, 24].map(|index| factory.trajectory(index, &NEVER).unwrap().unwrap().seed);
        assert_ne!(seeds[0], seeds[1], "trajectories of one stratum differ");
    }

    #[test]
    fn solutions_of_the_genetic_algorithm_replay_too() {
        let factory = factory(
            "count = 2\nsource = 'genetic'\nsizes = ['12x9']\npresets = ['short']\n\
             layouts = [{ name = 'voronoi' }, { name = 'stripes' }]",
        );
        assert_eq!(factory.stratum(0), "voronoi/12x9/genetic_short");
        for index in 0..2 {
            let trajectory = factory.trajectory(index, &NEVER).unwrap().unwrap();
            assert_eq!(trajectory.search.to_string(), "genetic_short");
            assert!(trajectory.best < trajectory.initial);
            trajectory.replay().unwrap();
        }
        assert_eq!(factory.trajectory(0, &AtomicBool::new(true)).unwrap(), None);
    }

    #[test]
    fn chains_replay_too() {
        let factory = factory(
            "count = 4\nsource = 'chains'\nsizes = ['16x14']\npresets = ['plain', 'noisy']\n\
             layouts = [{ name = 'voronoi' }, { name = 'stripes' }]",
        );
        assert_eq!(factory.stratum(1), "voronoi/16x14/chains_noisy");
        for index in 0..4 {
            let trajectory = factory.trajectory(index, &NEVER).unwrap().unwrap();
            assert!(trajectory.best < trajectory.initial);
            trajectory.replay().unwrap();
        }
        assert_eq!(factory.trajectory(0, &AtomicBool::new(true)).unwrap(), None);
    }

    #[test]
    fn impossible_combinations_are_found_at_once() {
        let config = |toml: &str| Config::from_toml(toml).unwrap();
        let islands = config(
            "count = 1\nlayouts = [{ name = 'islands' }]\nsizes = ['9x9']\npresets = ['paper']",
        );
        let error = Factory::new(islands, Vec::new()).unwrap_err().to_string();
        assert!(
            error.starts_with("islands/9x9/paper: islands layout: found no room for 3 islands"),
            "{error}"
        );
        let pictures = config("count = 1\npictures = 'x'\npresets = ['paper']");
        assert!(matches!(
            Factory::new(pictures.clone(), Vec::new()),
            Err(FactoryError::NoPictures)
        ));
        let error = Factory::new(pictures, vec![("a".to_owned(), b"text".to_vec())]).unwrap_err();
        assert_eq!(error.to_string(), "picture 'a.png'");
        let twice = config(
            "count = 1\nlayouts = [{ name = 'stripes' }]\nsizes = ['9x9', '9x9']\npresets = ['paper']",
        );
        let error = Factory::new(twice, Vec::new()).unwrap_err();
        assert_eq!(error.to_string(), "'stripes/9x9/paper' is listed twice");
    }

    #[test]
    fn the_fingerprint_tells_configurations_apart() {
        let text = "count = 3\nlayouts = [{ name = 'left_right' }]\nsizes = ['5x5']\npresets = ['short']\n";
        assert_eq!(factory(text).fingerprint(), factory(text).fingerprint());
        assert_ne!(
            factory(text).fingerprint(),
            factory(&format!("seed = 1\n{text}")).fingerprint()
        );
    }

    #[test]
    fn a_cancelled_search_leaves_nothing() {
        let factory = factory(
            "count = 3\nlayouts = [{ name = 'voronoi' }]\nsizes = ['30x30']\npresets = ['paper']",
        );
        assert_eq!(factory.trajectory(0, &AtomicBool::new(true)).unwrap(), None);
    }
}
