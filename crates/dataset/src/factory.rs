//! Makes the trajectories of a configuration, each from its number alone.

use std::collections::HashSet;
use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::{Crossings, LayoutError, LayoutSpec};
use beadwork_search::bound;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use sha2::{Digest, Sha256};

use crate::config::{Config, ConfigError};
use crate::manifest::fingerprint;
use crate::shard::hex;
use crate::stratum::{FactoryError, InstanceSource, PictureSource, SearchResult, Stratum};
use crate::trajectory::{DrawError, Moves, Trajectory};

/// A configuration with its pictures, ready to make trajectories.
///
/// Trajectory i depends on the configuration, the pictures and i alone: it has its own random
/// stream.
#[derive(Debug)]
pub struct Factory {
    config: Config,
    resolved: serde_json::Value,
    strata: Vec<Stratum>,
    fingerprint: u64,
}

/// Maximum number of further attempts to draw an instance, if its islands did not fit.
const MAX_REDRAWS: u32 = 100;

impl Factory {
    /// Takes a configuration, and the pictures of its folder if it names one: names of the files
    /// without extension, and their bytes.
    ///
    /// Draws one instance of every combination, so that an impossible combination is reported now
    /// rather than after hours of work.
    /// No progress is reported.
    pub fn new(
        config: Config,
        mut pictures: Vec<(String, Vec<u8>)>,
        control: &Control<'_>,
    ) -> Result<Self, FactoryError> {
        config.check()?;
        pictures.sort();
        let control = control.without_progress();
        let mut resolved = serde_json::to_value(&config).expect("a configuration is plain data");
        let sources: Vec<InstanceSource> = if config.pictures.is_some() {
            if pictures.is_empty() {
                return Err(FactoryError::NoPictures);
            }
            // The fingerprint covers the pictures instead of their folder: the same pictures in
            // another folder give the same dataset.
            let listed = pictures.iter().map(
                |(name, bytes)| json!({ "name": name, "sha256": hex(&Sha256::digest(bytes)) }),
            );
            resolved["pictures"] = listed.collect();
            let read = |(name, bytes): &(String, Vec<u8>)| {
                let picture = PictureSource::new(name, bytes, &control)?;
                Ok(InstanceSource::Picture(Arc::new(picture)))
            };
            pictures.iter().map(read).collect::<Result<_, FactoryError>>()?
        } else {
            let in_all_sizes = |layout: LayoutSpec| {
                config.sizes.iter().map(move |&size| InstanceSource::Layout(layout, size))
            };
            config.layouts.iter().flat_map(|layout| in_all_sizes(layout.spec())).collect()
        };

        let searches = config.searches().map_err(ConfigError::from)?;
        let name_the_start = config.starts.len() > 1;
        let mut strata = Vec::new();
        for source in sources {
            for &search in &searches {
                for start in &config.starts {
                    strata.push(Stratum::new(source.clone(), search, start.0, name_the_start));
                }
            }
        }
        let mut names = HashSet::new();
        if let Some(duplicate) = strata.iter().find(|stratum| !names.insert(&stratum.name)) {
            return Err(ConfigError::Duplicate(duplicate.name.clone()).into());
        }
        for stratum in &strata {
            let (_, region, _) = stratum.draw(0)?;
            stratum.start(&region, &control)?;
        }
        let fingerprint = fingerprint(env!("CARGO_PKG_VERSION"), &resolved);
        Ok(Self { config, resolved, strata, fingerprint })
    }

    /// The configuration it was made from.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The resolved configuration: all defaults filled in, and the pictures' checksums in place of
    /// their folder.
    pub fn resolved_config(&self) -> &serde_json::Value {
        &self.resolved
    }

    /// Hash of the resolved configuration and this crate's version: it distinguishes shards of
    /// different datasets.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// The names of the combinations, with the number of trajectories of each.
    pub fn strata(&self) -> impl Iterator<Item = (&str, u64)> {
        let (count, strata) = (self.config.count, self.strata.len() as u64);
        (0..).zip(&self.strata).map(move |(index, stratum)| {
            (stratum.name.as_str(), count / strata + u64::from(index < count % strata))
        })
    }

    /// The name of the combination that a trajectory belongs to.
    pub fn stratum(&self, index: u64) -> &str {
        &self.stratum_of(index).name
    }

    fn stratum_of(&self, index: u64) -> &Stratum {
        &self.strata[(index % self.strata.len() as u64) as usize]
    }

    /// Runs the search of one trajectory.
    ///
    /// Takes as long as the search: 1 to 20 ms with the paper's annealers and sizes, seconds with
    /// the genetic algorithm.
    /// Works on the calling thread and reports no progress; call it from several threads to make
    /// trajectories in parallel.
    pub fn trajectory(
        &self,
        index: u64,
        control: &Control<'_>,
    ) -> Result<Trajectory, FactoryError> {
        let control = control.on_one_thread().without_progress();
        let stratum = self.stratum_of(index);
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        rng.set_stream(index);
        let (mut instance_seed, seed) = (rng.next_u64(), rng.next_u64());
        let mut redraws = 0;
        let (instance, region, zones) = loop {
            match stratum.draw(instance_seed) {
                // On a crowded grid, whether all islands fit depends on the seed.
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
        let (start, path) = stratum.start(&region, &control)?;
        let crossings = Crossings::new(&region, &zones);
        let pieces = path.pieces();
        let bound = bound::components(&region, &zones, pieces);
        let SearchResult { initial, best, moves } =
            stratum.run(&path, &crossings, bound, seed, &control)?;
        Ok(Trajectory {
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
        })
    }
}

#[cfg(test)]
mod tests {
    use beadwork_base::{CancelToken, Interrupted};

    use super::*;

    fn new(config: Config, pictures: Vec<(String, Vec<u8>)>) -> Result<Factory, FactoryError> {
        Factory::new(config, pictures, &Control::default())
    }

    fn factory(toml: &str) -> Factory {
        new(Config::from_toml(toml).unwrap(), Vec::new()).unwrap()
    }

    fn make(factory: &Factory, index: u64) -> Trajectory {
        factory.trajectory(index, &Control::default()).unwrap()
    }

    fn assert_cancellable(factory: &Factory) {
        let cancel = CancelToken::new();
        cancel.cancel();
        let control = Control { cancel: Some(&cancel), ..Control::default() };
        let error = factory.trajectory(0, &control).unwrap_err();
        assert!(matches!(error, FactoryError::Interrupted(Interrupted::Cancelled)), "{error}");
    }

    #[test]
    fn strata_share_the_trajectories() {
        let factory = new(Config::preset("paper").unwrap(), Vec::new()).unwrap();
        let strata: Vec<_> = factory.strata().collect();
        assert_eq!(strata.len(), 4 * 6 * 5);
        assert_eq!(strata.iter().map(|(_, count)| count).sum::<u64>(), 22_111);
        assert!(strata.iter().all(|(_, count)| (184..=185).contains(count)));
        assert_eq!(strata[0].0, "left_right/30x30/paper");
        assert_eq!(factory.stratum(120), "left_right/30x30/paper");
    }

    #[test]
    fn each_number_gives_one_trajectory_that_replays() {
        let factory = factory(
            "count = 40
sizes = ['12x9', '8x20']
presets = ['short', 'fast']
starts = ['spiral', 'cover']
layouts = [
    { name = 'voronoi' },
    { name = 'islands', zones = 3, side = 3 },
    { name = 'checkerboard' },
]",
        );
        for index in [0, 1, 2, 3, 7, 12, 23] {
            let first = make(&factory, index);
            assert_eq!(make(&factory, index), first);
            first.replay(&Control::default()).unwrap();
        }
        let seeds = [0, 24].map(|index| make(&factory, index).seed);
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
            let trajectory = make(&factory, index);
            assert_eq!(trajectory.search.to_string(), "genetic_short");
            assert!(trajectory.best < trajectory.initial);
            trajectory.replay(&Control::default()).unwrap();
        }
        assert_cancellable(&factory);
    }

    #[test]
    fn trajectories_of_chains_replay_too() {
        let factory = factory(
            "count = 4\nsource = 'chains'\nsizes = ['16x14']\npresets = ['plain', 'noisy']\n\
             layouts = [{ name = 'voronoi' }, { name = 'stripes' }]",
        );
        assert_eq!(factory.stratum(1), "voronoi/16x14/chains_noisy");
        for index in 0..4 {
            let trajectory = make(&factory, index);
            assert!(trajectory.best < trajectory.initial);
            trajectory.replay(&Control::default()).unwrap();
        }
        assert_cancellable(&factory);
    }

    #[test]
    fn impossible_combinations_are_found_at_once() {
        let config = |toml: &str| Config::from_toml(toml).unwrap();
        let islands = config(
            "count = 1\nlayouts = [{ name = 'islands' }]\nsizes = ['9x9']\npresets = ['paper']",
        );
        let error = new(islands, Vec::new()).unwrap_err().to_string();
        assert!(
            error.starts_with("islands/9x9/paper: islands layout: found no room for 3 islands"),
            "{error}"
        );
        let pictures = config("count = 1\npictures = 'x'\npresets = ['paper']");
        assert!(matches!(new(pictures.clone(), Vec::new()), Err(FactoryError::NoPictures)));
        let error = new(pictures, vec![("a".to_owned(), b"text".to_vec())]).unwrap_err();
        assert_eq!(error.to_string(), "picture 'a.png'");
        let twice = config(
            "count = 1\nlayouts = [{ name = 'stripes' }]\n\
             sizes = ['9x9', '9x9']\npresets = ['paper']",
        );
        let error = new(twice, Vec::new()).unwrap_err();
        assert_eq!(error.to_string(), "'stripes/9x9/paper' is listed twice");
    }

    /// Fingerprints of existing datasets must not change: `models/fusion-small` names the one of
    /// `chains`, which it was trained on.
    #[test]
    fn fingerprints_of_version_0_1_0_are_unchanged() {
        let of_preset = |name: &str| {
            format!(
                "{:016x}",
                fingerprint(
                    "0.1.0",
                    new(Config::preset(name).unwrap(), Vec::new()).unwrap().resolved_config()
                )
            )
        };
        assert_eq!(of_preset("chains"), "f34550eae97522d5");
    }

    #[test]
    fn the_fingerprint_depends_on_the_configuration() {
        let text = "count = 3
layouts = [{ name = 'left_right' }]
sizes = ['5x5']
presets = ['short']
";
        assert_eq!(factory(text).fingerprint(), factory(text).fingerprint());
        assert_ne!(
            factory(text).fingerprint(),
            factory(&format!("seed = 1\n{text}")).fingerprint()
        );
    }

    #[test]
    fn a_cancelled_search_is_an_error() {
        let factory = factory(
            "count = 3\nlayouts = [{ name = 'voronoi' }]\nsizes = ['30x30']\npresets = ['paper']",
        );
        assert_cancellable(&factory);
    }
}
