//! Parsers of values on the command line.

use clap::builder::RangedU64ValueParser;

/// Parser of a whole number that is at least 1.
pub(crate) fn positive<T: TryFrom<u64>>() -> RangedU64ValueParser<T> {
    RangedU64ValueParser::new().range(1..)
}
