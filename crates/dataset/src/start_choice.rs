//! The start path in a configuration.

use std::fmt;
use std::str::FromStr;

use beadwork_base::{Control, Interrupted, UnknownName};
use beadwork_grid::{Path, Region, Start, StartError};

/// The path that a search starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartChoice {
    /// The row zigzag if the region has one, otherwise the path cover.
    Auto,
    /// This start; an error on regions that do not have it.
    Given(Start),
}

const AUTO: &str = "auto";

impl StartChoice {
    /// The start that is used on a region, and its path.
    ///
    /// `cover` returns the region's path cover.
    /// It is called only if needed: computing a cover takes longer than the other starts, and the
    /// caller may have stored one.
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
            Self::Auto => f.write_str(AUTO),
            Self::Given(start) => start.fmt(f),
        }
    }
}

impl FromStr for StartChoice {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        if name == AUTO {
            return Ok(Self::Auto);
        }
        let with_auto = |mut error: UnknownName| {
            error.expected.push(AUTO);
            error
        };
        name.parse().map(Self::Given).map_err(with_auto)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_lists_all_choices() {
        let error = "up".parse::<StartChoice>().unwrap_err().to_string();
        let all = "row_zigzag, column_zigzag, spiral, cover or auto";
        assert_eq!(error, format!("unknown start 'up': expected {all}"));
        assert_eq!("auto".parse(), Ok(StartChoice::Auto));
        assert_eq!("spiral".parse(), Ok(StartChoice::Given(Start::Spiral)));
    }
}
