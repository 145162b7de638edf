//! Which searches a dataset records, by name.

use std::fmt;
use std::str::FromStr;

use beadwork_search::{Preset, UnknownPreset, genetic};
use thiserror::Error;

/// A family of searches that trajectories come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// Simulated annealing.
    #[default]
    Anneal,
    /// The genetic algorithm; its best individual is recorded.
    Genetic,
}

/// A name that is no [`Source`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is no source: choose anneal or genetic")]
pub struct UnknownSource(pub String);

impl Source {
    /// The search of this source and preset.
    pub fn search(self, preset: &PresetName) -> Result<Search, ForeignPreset> {
        Ok(match self {
            Self::Anneal => Search::Anneal(preset.0.parse()?),
            Self::Genetic => Search::Genetic(preset.0.parse()?),
        })
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Anneal => "anneal",
            Self::Genetic => "genetic",
        })
    }
}

impl FromStr for Source {
    type Err = UnknownSource;

    fn from_str(name: &str) -> Result<Self, UnknownSource> {
        let found = [Self::Anneal, Self::Genetic].into_iter().find(|source| source.to_string() == name);
        found.ok_or_else(|| UnknownSource(name.to_owned()))
    }
}

/// The name of a preset of some source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PresetName(String);

/// A name that is a preset of no source.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{0}; {1}")]
pub struct UnknownPresetName(UnknownPreset, genetic::UnknownPreset);

/// A name that is no preset of the source in question.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ForeignPreset {
    /// Of annealing.
    #[error(transparent)]
    Anneal(#[from] UnknownPreset),
    /// Of the genetic algorithm.
    #[error(transparent)]
    Genetic(#[from] genetic::UnknownPreset),
}

impl fmt::Display for PresetName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for PresetName {
    type Err = UnknownPresetName;

    fn from_str(name: &str) -> Result<Self, UnknownPresetName> {
        match (name.parse::<Preset>(), name.parse::<genetic::Preset>()) {
            (Err(anneal), Err(genetic)) => Err(UnknownPresetName(anneal, genetic)),
            _ => Ok(Self(name.to_owned())),
        }
    }
}

/// A search as a record names it: an annealer by its preset, `paper`, the genetic algorithm with a prefix, `genetic_paper`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Search {
    /// Simulated annealing.
    Anneal(Preset),
    /// The genetic algorithm.
    Genetic(genetic::Preset),
}

const PREFIX: &str = "genetic_";

impl fmt::Display for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Anneal(preset) => preset.fmt(f),
            Self::Genetic(preset) => write!(f, "{PREFIX}{preset}"),
        }
    }
}

impl FromStr for Search {
    type Err = ForeignPreset;

    fn from_str(name: &str) -> Result<Self, ForeignPreset> {
        Ok(match name.strip_prefix(PREFIX) {
            Some(preset) => Self::Genetic(preset.parse()?),
            None => Self::Anneal(name.parse()?),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use super::*;

    #[test]
    fn names_round_trip() {
        let searches = Preset::ALL.map(Search::Anneal).into_iter();
        for search in searches.chain(genetic::Preset::ALL.map(Search::Genetic)) {
            assert_eq!(search.to_string().parse(), Ok(search));
        }
        let error = "genetic_long".parse::<Search>().unwrap_err().to_string();
        assert!(error.contains("'long' is no preset of the genetic algorithm"), "{error}");
        let name = |name: &str| name.parse::<PresetName>().unwrap();
        assert_eq!(Source::Anneal.search(&name("paper")), Ok(Search::Anneal(Preset::Paper)));
        assert_eq!(Source::Genetic.search(&name("window")), Ok(Search::Genetic(genetic::Preset::Window)));
        let error = Source::Genetic.search(&name("long")).unwrap_err();
        assert!(error.to_string().contains("'long' is no preset of the genetic algorithm"), "{error}");
        let error = "none".parse::<PresetName>().unwrap_err().to_string();
        assert!(error.contains("annealing") && error.contains("genetic"), "{error}");
        assert!("exact".parse::<Source>().is_err());
    }
}
