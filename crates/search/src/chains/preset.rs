//! Named settings of the search for chains.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// Named settings of the search for chains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Preset {
    /// Chains only.
    Plain,
    /// One move in twenty at random.
    Noisy,
}

/// A name that is no [`Preset`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is no preset of the search for chains: choose plain or noisy")]
pub struct UnknownPreset(pub String);

impl Preset {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Plain, Self::Noisy];

    /// Its name in configurations.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Noisy => "noisy",
        }
    }

    /// The probability of a random move.
    pub(super) fn noise(self) -> f64 {
        match self {
            Self::Plain => 0.0,
            Self::Noisy => 0.05,
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Preset {
    type Err = UnknownPreset;

    fn from_str(name: &str) -> Result<Self, UnknownPreset> {
        Self::ALL
            .into_iter()
            .find(|preset| preset.name() == name)
            .ok_or_else(|| UnknownPreset(name.to_owned()))
    }
}
