//! Which searches a dataset records, by name.

use std::fmt;
use std::str::FromStr;

use beadwork_base::UnknownName;
use beadwork_search::{anneal, chains, genetic};
use thiserror::Error;

/// A family of searches that trajectories come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// Simulated annealing.
    #[default]
    Anneal,
    /// The genetic algorithm; its best individual is recorded.
    Genetic,
    /// Chains of variants, which need few moves.
    Chains,
}

/// A name that is no [`Source`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is no source: choose anneal, genetic or chains")]
pub struct UnknownSource(pub String);

impl Source {
    const ALL: [Self; 3] = [Self::Anneal, Self::Genetic, Self::Chains];

    /// The search of this source and preset.
    pub fn search(self, preset: &PresetName) -> Result<Search, ForeignPreset> {
        Ok(match self {
            Self::Anneal => Search::Anneal(preset.0.parse()?),
            Self::Genetic => Search::Genetic(preset.0.parse()?),
            Self::Chains => Search::Chains(preset.0.parse()?),
        })
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Anneal => "anneal",
            Self::Genetic => "genetic",
            Self::Chains => "chains",
        })
    }
}

impl FromStr for Source {
    type Err = UnknownSource;

    fn from_str(name: &str) -> Result<Self, UnknownSource> {
        let found = Self::ALL.into_iter().find(|source| source.to_string() == name);
        found.ok_or_else(|| UnknownSource(name.to_owned()))
    }
}

/// The name of a preset of some source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PresetName(String);

/// A name that is a preset of no source.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{0}; {1}; {2}")]
pub struct UnknownPresetName(UnknownName, UnknownName, UnknownName);

/// A name that is no preset of the source in question.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(transparent)]
pub struct ForeignPreset(#[from] UnknownName);

impl fmt::Display for PresetName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for PresetName {
    type Err = UnknownPresetName;

    fn from_str(name: &str) -> Result<Self, UnknownPresetName> {
        match (
            name.parse::<anneal::Preset>(),
            name.parse::<genetic::Preset>(),
            name.parse::<chains::Preset>(),
        ) {
            (Err(anneal), Err(genetic), Err(chains)) => {
                Err(UnknownPresetName(anneal, genetic, chains))
            }
            _ => Ok(Self(name.to_owned())),
        }
    }
}

/// A search as a record names it: an annealer by its preset, `paper`, others with a prefix,
/// `genetic_paper`, `chains_plain`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Search {
    /// Simulated annealing.
    Anneal(anneal::Preset),
    /// The genetic algorithm.
    Genetic(genetic::Preset),
    /// Chains of variants.
    Chains(chains::Preset),
}

const GENETIC: &str = "genetic_";
const CHAINS: &str = "chains_";

impl fmt::Display for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Anneal(preset) => preset.fmt(f),
            Self::Genetic(preset) => write!(f, "{GENETIC}{preset}"),
            Self::Chains(preset) => write!(f, "{CHAINS}{preset}"),
        }
    }
}

impl FromStr for Search {
    type Err = ForeignPreset;

    fn from_str(name: &str) -> Result<Self, ForeignPreset> {
        if let Some(preset) = name.strip_prefix(GENETIC) {
            return Ok(Self::Genetic(preset.parse()?));
        }
        if let Some(preset) = name.strip_prefix(CHAINS) {
            return Ok(Self::Chains(preset.parse()?));
        }
        Ok(Self::Anneal(name.parse()?))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use super::*;

    #[test]
    fn names_round_trip() {
        let searches = anneal::Preset::ALL.map(Search::Anneal).into_iter();
        let searches = searches.chain(genetic::Preset::ALL.map(Search::Genetic));
        for search in searches.chain(chains::Preset::ALL.map(Search::Chains)) {
            assert_eq!(search.to_string().parse(), Ok(search));
        }
        let error = "genetic_long".parse::<Search>().unwrap_err().to_string();
        assert!(error.contains("unknown genetic preset 'long'"), "{error}");
        let name = |name: &str| name.parse::<PresetName>().unwrap();
        assert_eq!(
            Source::Anneal.search(&name("paper")),
            Ok(Search::Anneal(anneal::Preset::Paper))
        );
        assert_eq!(
            Source::Genetic.search(&name("window")),
            Ok(Search::Genetic(genetic::Preset::Window))
        );
        assert_eq!(
            Source::Chains.search(&name("noisy")),
            Ok(Search::Chains(chains::Preset::Noisy))
        );
        let error = Source::Genetic.search(&name("long")).unwrap_err();
        assert!(error.to_string().contains("unknown genetic preset 'long'"), "{error}");
        let error = "none".parse::<PresetName>().unwrap_err().to_string();
        assert!(
            ["annealing", "genetic", "chains"].iter().all(|source| error.contains(source)),
            "{error}"
        );
        assert!("exact".parse::<Source>().is_err());
    }
}
