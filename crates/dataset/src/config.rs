//! Configurations of datasets: TOML files and built-in presets.

use std::fmt;
use std::str::FromStr;

use beadwork_base::UnknownName;
use beadwork_grid::{Layout, LayoutSpec};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::by_name;
use crate::size::Size;
use crate::source::{PresetName, Search, Source};
use crate::start_choice::StartChoice;

/// Configuration of a dataset: searches over every combination of instances, presets and starts.
///
/// The instances are either layouts in several sizes, or pictures.
/// Trajectory i belongs to combination i modulo the number of combinations, so that every
/// contiguous part of the dataset has equal shares of all of them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Seed of the dataset.
    #[serde(default)]
    pub seed: u64,
    /// Number of trajectories, at least 1.
    pub count: u64,
    /// Trajectories in a shard, at least 1. An interrupted run loses at most the shard it was
    /// working on.
    #[serde(default = "default_per_shard")]
    pub per_shard: u32,
    /// Layouts to draw.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layouts: Vec<LayoutConfig>,
    /// Sizes of the layouts, such as "30x100", in cells.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sizes: Vec<Size>,
    /// Folder of PNG pictures, instead of layouts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pictures: Option<String>,
    /// The searches to record: "anneal", "genetic" or "chains".
    #[serde(default, skip_serializing_if = "is_default")]
    pub source: Named<Source>,
    /// Names of the source's presets.
    pub presets: Vec<Named<PresetName>>,
    /// Names of starts, or "auto".
    #[serde(default = "default_starts")]
    pub starts: Vec<Named<StartChoice>>,
}

/// A layout in a configuration; [`LayoutSpec::new`] gives the defaults.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayoutConfig {
    /// The family of layouts.
    #[serde(with = "by_name")]
    pub name: Layout,
    /// Number of zones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zones: Option<u8>,
    /// Side of an island or of a block in cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<u16>,
}

impl LayoutConfig {
    /// The layout with all its parameters.
    pub fn spec(&self) -> LayoutSpec {
        let default = LayoutSpec::new(self.name);
        LayoutSpec {
            zones: self.zones.unwrap_or(default.zones),
            side: self.side.unwrap_or(default.side),
            ..default
        }
    }
}

/// A value that is serialised as its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
#[serde(bound(serialize = "T: fmt::Display", deserialize = "T: FromStr<Err: fmt::Display>"))]
pub struct Named<T>(#[serde(with = "by_name")] pub T);

/// Why a configuration is invalid.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The text is not valid TOML, or has an unknown key or a wrong value.
    #[error("line {line}: {message}")]
    Toml {
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        message: String,
    },
    /// The dataset would have too many shards.
    #[error(
        "dataset would have {shards} shards, at most {max} are allowed: \
         raise 'per_shard' or lower 'count'",
        max = Config::MAX_SHARDS
    )]
    Shards {
        /// Number of shards.
        shards: u64,
    },
    /// A combination is listed twice.
    #[error("'{0}' is listed twice")]
    Duplicate(String),
    /// A number is 0.
    #[error("'{0}' must be at least 1")]
    Zero(&'static str),
    /// There are no instances.
    #[error("no instances: expected 'layouts' and 'sizes', or 'pictures'")]
    NoInstances,
    /// There are both layouts and pictures.
    #[error("both layouts and pictures are given: make two datasets")]
    LayoutsAndPictures,
    /// A preset does not belong to the source.
    #[error(transparent)]
    Preset(#[from] UnknownName),
    /// A list is empty.
    #[error("'{0}' is empty")]
    Empty(&'static str),
}

impl Config {
    /// The built-in configurations: name, and TOML text as in `configs/gen-data`.
    pub const PRESETS: [(&'static str, &'static str); 5] = [
        ("smoke", include_str!("../../../configs/gen-data/smoke.toml")),
        ("paper", include_str!("../../../configs/gen-data/paper.toml")),
        ("genetic", include_str!("../../../configs/gen-data/genetic.toml")),
        ("chains", include_str!("../../../configs/gen-data/chains.toml")),
        ("pictures", include_str!("../../../configs/gen-data/pictures.toml")),
    ];

    /// Maximum number of shards: the file names have five digits.
    pub const MAX_SHARDS: u64 = 100_000;

    /// Reads and checks a configuration.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let config: Self = toml::from_str(text).map_err(|error| ConfigError::Toml {
            line: 1 + text[..error.span().map_or(0, |span| span.start)].matches('\n').count(),
            message: error.message().replace('\n', " "),
        })?;
        config.check()?;
        Ok(config)
    }

    /// The built-in configuration of this name, if there is one.
    pub fn preset(name: &str) -> Option<Self> {
        let (_, text) = Self::PRESETS.iter().find(|(preset, _)| *preset == name)?;
        Some(Self::from_toml(text).expect("the built-in configurations are tested"))
    }

    /// The searches to record, in the order of the presets.
    pub fn searches(&self) -> Result<Vec<Search>, UnknownName> {
        self.presets.iter().map(|preset| self.source.0.search(&preset.0)).collect()
    }

    /// Checks that the fields are consistent.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        if self.count == 0 {
            return Err(ConfigError::Zero("count"));
        }
        if self.per_shard == 0 {
            return Err(ConfigError::Zero("per_shard"));
        }
        let shards = self.count.div_ceil(u64::from(self.per_shard));
        if shards > Self::MAX_SHARDS {
            return Err(ConfigError::Shards { shards });
        }
        if self.presets.is_empty() {
            return Err(ConfigError::Empty("presets"));
        }
        self.searches()?;
        if self.starts.is_empty() {
            return Err(ConfigError::Empty("starts"));
        }
        match (self.layouts.is_empty(), self.sizes.is_empty(), self.pictures.is_some()) {
            (false, false, false) | (true, true, true) => Ok(()),
            (_, _, true) => Err(ConfigError::LayoutsAndPictures),
            (_, _, false) => Err(ConfigError::NoInstances),
        }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_default(source: &Named<Source>) -> bool {
    source.0 == Source::default()
}

fn default_per_shard() -> u32 {
    256
}

fn default_starts() -> Vec<Named<StartChoice>> {
    vec![Named(StartChoice::Auto)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "count = 3
layouts = [{ name = 'voronoi', zones = 8 }]
sizes = ['30x100']
presets = ['short']
";

    #[test]
    fn presets_are_valid() {
        for (name, _) in Config::PRESETS {
            assert!(Config::preset(name).is_some(), "{name}");
        }
        assert_eq!(Config::preset("paper").unwrap().count, 22_111);
        assert_eq!(Config::preset("none"), None);
    }

    #[test]
    fn missing_keys_have_defaults() {
        let config = Config::from_toml(SMALL).unwrap();
        assert_eq!((config.seed, config.per_shard, config.source.0), (0, 256, Source::Anneal));
        assert_eq!(config.starts, [Named(StartChoice::Auto)]);
        assert_eq!(config.sizes, [Size { width: 30, height: 100 }]);
        assert_eq!(
            config.layouts[0].spec(),
            LayoutSpec { layout: Layout::Voronoi, zones: 8, side: 1 }
        );
    }

    #[test]
    fn a_resolved_configuration_reads_back() {
        let config = Config::from_toml(SMALL).unwrap();
        let resolved = serde_json::to_value(&config).unwrap();
        assert_eq!(serde_json::from_value::<Config>(resolved).unwrap(), config);
    }

    #[test]
    fn mistakes_are_named() {
        let error = |change: &dyn Fn(&str) -> String| {
            Config::from_toml(&change(SMALL)).unwrap_err().to_string()
        };
        assert!(error(&|text| format!("colour = 1\n{text}")).contains("unknown field `colour`"));
        assert!(error(&|text| text.replace("zones", "zone")).contains("unknown field `zone`"));
        assert!(
            error(&|text| text.replace("'voronoi'", "'vornoi'"))
                .contains("unknown layout 'vornoi'")
        );
        assert!(error(&|text| text.replace("'short'", "'shor'")).contains("unknown preset 'shor'"));
        assert!(error(&|text| text.replace("30x100", "30x")).contains("invalid size '30x'"));
        assert!(error(&|text| text.replace("30x100", "0x9")).contains("invalid size '0x9'"));
        assert!(error(&|text| format!("starts = ['up']\n{text}")).contains("unknown start 'up'"));
        assert_eq!(
            error(&|text| text.replace("count = 3", "count = 0")),
            "'count' must be at least 1"
        );
        assert_eq!(
            error(&|text| format!("per_shard = 0\n{text}")),
            "'per_shard' must be at least 1"
        );
        assert_eq!(error(&|text| text.replace("'short'", "")), "'presets' is empty");
        assert!(error(&|text| text.replace("'short'", "'shor'")).starts_with("line 4: "));
        assert!(error(&|text| text.replace("= 3", "= 99000000000")).contains("raise 'per_shard'"));
        assert!(
            error(&|text| format!("source = 'zigzag'\n{text}"))
                .contains("unknown source 'zigzag': expected anneal, genetic or chains")
        );
        let foreign =
            error(&|text| format!("source = 'genetic'\n{}", text.replace("'short'", "'long'")));
        assert!(foreign.contains("'long'") && foreign.contains("genetic"), "{foreign}");
        assert_eq!(
            error(&|text| format!("pictures = 'x'\n{text}")),
            "both layouts and pictures are given: make two datasets"
        );
        assert_eq!(
            error(&|text| text.replace("'30x100'", "")),
            "no instances: expected 'layouts' and 'sizes', or 'pictures'"
        );
    }
}
