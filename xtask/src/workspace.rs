//! The folder of the workspace, and its cargo.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

/// The folder of the root manifest.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask is in a folder of the workspace")
}

/// The cargo that started this program, so that `cargo +VERSION xtask` uses that version
/// throughout.
pub(crate) fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo")))
}
