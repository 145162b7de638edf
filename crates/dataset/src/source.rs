//! The searches that a dataset records, by name.

use std::fmt;
use std::str::FromStr;

use beadwork_base::{UnknownName, named_enum};
use beadwork_search::{anneal, chains, genetic};

/// A family of searches that trajectories are recorded from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// Simulated annealing.
    #[default]
    Anneal,
    /// The genetic algorithm; its best individual is recorded.
    Genetic,
    /// The search for chains of variants, which needs few moves.
    Chains,
}

named_enum! {
    Source, "source":
    Anneal = "anneal",
    Genetic = "genetic",
    Chains = "chains",
}

impl Source {
    /// The search with a preset of this source.
    pub fn search(self, preset: &PresetName) -> Result<Search, UnknownName> {
        Ok(match self {
            Self::Anneal => Search::Anneal(preset.0.parse()?),
            Self::Genetic => Search::Genetic(preset.0.parse()?),
            Self::Chains => Search::Chains(preset.0.parse()?),
        })
    }
}

/// The name of a preset of at least one source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PresetName(String);

impl fmt::Display for PresetName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for PresetName {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let anneal = anneal::Preset::ALL.map(anneal::Preset::name);
        let genetic = genetic::Preset::ALL.map(genetic::Preset::name);
        let chains = chains::Preset::ALL.map(chains::Preset::name);
        let mut expected = Vec::new();
        for name in anneal.into_iter().chain(genetic).chain(chains) {
            if !expected.contains(&name) {
                expected.push(name);
            }
        }
        if !expected.contains(&name) {
            return Err(UnknownName::new("preset", name, expected));
        }
        Ok(Self(name.to_owned()))
    }
}

/// A search with its preset, as named in records: an annealer by its preset's name (`paper`), any
/// other search by a prefix and its preset's name (`genetic_paper`, `chains_plain`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Search {
    /// Simulated annealing.
    Anneal(anneal::Preset),
    /// The genetic algorithm.
    Genetic(genetic::Preset),
    /// The search for chains of variants.
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
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
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
        assert!(error.contains("genetic") && error.contains("'long'"), "{error}");
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
        let error = Source::Genetic.search(&name("long")).unwrap_err().to_string();
        assert!(error.contains("genetic") && error.contains("'long'"), "{error}");
        let error = "none".parse::<PresetName>().unwrap_err().to_string();
        assert!(error.starts_with("unknown preset 'none': expected paper, short, "), "{error}");
        assert!(error.ends_with("plain or noisy"), "{error}");
        assert!("exact".parse::<Source>().is_err());
    }
}
