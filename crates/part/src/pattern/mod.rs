//! The 38 named orders in which the cells of a layer may be deposited.

mod outline;
mod sheet;
mod sweep;
mod table;
#[cfg(test)]
mod tests;
pub(crate) mod view;

pub use sheet::pattern_sheet;
pub use table::{Pattern, UnknownPattern};
