//! What `gen-data` makes, as people write it: TOML files and named presets.

use std::fmt;
use std::str::FromStr;

use beadwork_base::{Control, Interrupted};
use beadwork_grid::{Layout, LayoutSpec, Path, Region, Start, StartError};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::by_name;
use crate::source::{ForeignPreset, PresetName, Search, Source};

/// A configuration of the trajectory factory: searches over every combination of instances, presets
/// and starts.
///
/// The instances are either layouts in sizes or pictures.
/// Trajectory i belongs to combination i modulo their number, so that every part of the dataset,
/// and every dataset cut short, has all of them in equal shares.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Seed of the whole dataset.
    #[serde(default)]
    pub seed: u64,
    /// Number of trajectories, at least 1.
    pub count: u64,
    /// Trajectories in one file: what an interrupted run can lose for each thread.
    /// At least 1.
    #[serde(default = "default_per_shard")]
    pub per_shard: u32,
    /// Drawn layouts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layouts: Vec<LayoutConfig>,
    /// Sizes of the layouts, such as "30x100", in cells.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sizes: Vec<Size>,
    /// Folder of PNG pictures, instead of layouts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pictures: Option<String>,
    /// The searches that are recorded: "anneal", "genetic" or "chains".
    #[serde(default, skip_serializing_if = "is_usual")]
    pub source: Named<Source>,
    /// Presets of the source, by name.
    pub presets: Vec<Named<PresetName>>,
    /// Starts by name, or "auto".
    #[serde(default = "default_starts")]
    pub starts: Vec<Named<StartChoice>>,
}

/// A layout in a configuration; what is not given is as in [`LayoutSpec::new`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayoutConfig {
    /// Its family.
    #[serde(with = "by_name")]
    pub name: Layout,
    /// Number of zones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zones: Option<u8>,
    /// Side of an island or a block in cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<u16>,
}

impl LayoutConfig {
    /// The layout with all its parameters.
    pub fn spec(&self) -> LayoutSpec {
        let usual = LayoutSpec::new(self.name);
        LayoutSpec {
            zones: self.zones.unwrap_or(usual.zones),
            side: self.side.unwrap_or(usual.side),
            ..usual
        }
    }
}

/// A value that is written as its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
#[serde(bound(serialize = "T: fmt::Display", deserialize = "T: FromStr<Err: fmt::Display>"))]
pub struct Named<T>(#[serde(with = "by_name")] pub T);

/// Width and height of a plane in cells, written "30x100".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Size {
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

/// A text that is no [`Size`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("'{0}' is no size: write WIDTHxHEIGHT in cells, each from 1 to {max}, such as 30x100", max = Region::MAX_SIDE)]
pub struct SizeError(pub String);

impl FromStr for Size {
    type Err = SizeError;

    fn from_str(text: &str) -> Result<Self, SizeError> {
        let side =
            |text: &str| text.parse().ok().filter(|side| (1..=Region::MAX_SIDE).contains(side));
        let size = text
            .split_once('x')
            .and_then(|(width, height)| Some(Self { width: side(width)?, height: side(height)? }));
        size.ok_or_else(|| SizeError(text.to_owned()))
    }
}

impl TryFrom<String> for Size {
    type Error = SizeError;

    fn try_from(text: String) -> Result<Self, SizeError> {
        text.parse()
    }
}

impl From<Size> for String {
    fn from(size: Size) -> Self {
        size.to_string()
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// Which path a search starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartChoice {
    /// The row zigzag where it exists, else the cover.
    Auto,
    /// This one, or an error where it does not exist.
    Given(Start),
}

impl StartChoice {
    /// The start that it comes to on a region, and its path.
    /// `cover` gives the region's cover where that is needed, for it is worth keeping.
    pub fn path(
        self,
        region: &Region,
        cover: impl FnOnce() -> Result<Path, Interrupted>,
    ) -> Result<(Start, Path), StartError> {
        match self {
            Self::Given(Start::Cover) => Ok((Start::Cover, cover()?)),
            Self::Given(start) => Ok((start, start.path(region, &Control::default())?)),
            Self::Auto => Ok(match Start::RowZigzag.path(region, &Control::default()) {
                Ok(path) => (Start::RowZigzag, path),
                Err(_) => (Start::Cover, cover()?),
            }),
        }
    }
}

impl fmt::Display for StartChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Given(start) => start.fmt(f),
        }
    }
}

impl FromStr for StartChoice {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if name == "auto" {
            return Ok(Self::Auto);
        }
        name.parse().map(Self::Given).map_err(|error| format!("{error}, or auto"))
    }
}

/// Why a configuration is refused.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// It is no TOML, or has an unknown key or a wrong value.
    #[error("line {line}: {message}")]
    Toml {
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        message: String,
    },
    /// It would make too many files.
    #[error("{shards} shards are more than {max}: raise 'per_shard' or lower 'count'", max = Config::MAX_SHARDS)]
    Shards {
        /// Files it would make.
        shards: u64,
    },
    /// Something is listed twice.
    #[error("'{0}' is listed twice")]
    Twice(String),
    /// A number is 0.
    #[error("'{0}' must be at least 1")]
    Zero(&'static str),
    /// There is nothing to search.
    #[error("it needs 'layouts' and 'sizes', or 'pictures'")]
    NoInstances,
    /// There are both layouts and pictures.
    #[error("it has both layouts and pictures: make two datasets")]
    TwoSources,
    /// A preset is one of another source.
    #[error(transparent)]
    Preset(#[from] ForeignPreset),
    /// A list is empty.
    #[error("'{0}' is empty")]
    Empty(&'static str),
}

impl Config {
    /// The presets by name, with their TOML text as in `configs/gen-data`.
    pub const PRESETS: [(&'static str, &'static str); 5] = [
        ("smoke", include_str!("../../../configs/gen-data/smoke.toml")),
        ("paper", include_str!("../../../configs/gen-data/paper.toml")),
        ("genetic", include_str!("../../../configs/gen-data/genetic.toml")),
        ("chains", include_str!("../../../configs/gen-data/chains.toml")),
        ("pictures", include_str!("../../../configs/gen-data/pictures.toml")),
    ];

    /// The largest number of shards, for their names have five digits.
    pub const MAX_SHARDS: u64 = 100_000;

    /// Reads a configuration.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let config: Self = toml::from_str(text).map_err(|error| ConfigError::Toml {
            line: 1 + text[..error.span().map_or(0, |span| span.start)].matches('\n').count(),
            message: error.message().replace('\n', " "),
        })?;
        config.check()?;
        Ok(config)
    }

    /// The preset of this name.
    pub fn preset(name: &str) -> Option<Self> {
        let (_, text) = Self::PRESETS.iter().find(|(preset, _)| *preset == name)?;
        Some(Self::from_toml(text).expect("the presets are tested"))
    }

    /// The searches that take turns.
    pub fn searches(&self) -> Result<Vec<Search>, ForeignPreset> {
        self.presets.iter().map(|preset| self.source.0.search(&preset.0)).collect()
    }

    /// Whether the parts go together.
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
            (_, _, true) => Err(ConfigError::TwoSources),
            (_, _, false) => Err(ConfigError::NoInstances),
        }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_usual(source: &Named<Source>) -> bool {
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

    const SMALL: &str = "count = 3\nlayouts = [{ name = 'voronoi', zones = 8 }]\nsizes = ['30x100']\npresets = ['short']\n";

    #[test]
    fn presets_are_sound() {
        for (name, _) in Config::PRESETS {
            assert!(Config::preset(name).is_some(), "{name}");
        }
        assert_eq!(Config::preset("paper").unwrap().count, 22_111);
        assert_eq!(Config::preset("none"), None);
    }

    #[test]
    fn what_is_not_given_has_a_default() {
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
    fn the_echo_reads_back() {
        let config = Config::from_toml(SMALL).unwrap();
        let echo = serde_json::to_value(&config).unwrap();
        assert_eq!(serde_json::from_value::<Config>(echo).unwrap(), config);
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
        assert!(
            error(&|text| text.replace("'short'", "'shor'"))
                .contains("unknown annealing preset 'shor'")
        );
        assert!(error(&|text| text.replace("30x100", "30x")).contains("'30x' is no size"));
        assert!(error(&|text| text.replace("30x100", "0x9")).contains("'0x9' is no size"));
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
                .contains("choose anneal, genetic or chains")
        );
        let foreign =
            error(&|text| format!("source = 'genetic'\n{}", text.replace("'short'", "'long'")));
        assert!(foreign.contains("unknown genetic preset 'long'"), "{foreign}");
        assert_eq!(
            error(&|text| format!("pictures = 'x'\n{text}")),
            "it has both layouts and pictures: make two datasets"
        );
        assert_eq!(
            error(&|text| text.replace("'30x100'", "")),
            "it needs 'layouts' and 'sizes', or 'pictures'"
        );
    }
}
