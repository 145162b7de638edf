//! `cargo xtask WORD ...`: the binary `beadwork`, built in release.

use std::ffi::OsString;
use std::process::Command;

use anyhow::Result;

use crate::workspace;

/// Builds and runs the binary in the caller's folder, where relative paths among the words mean what they say.
pub(crate) fn run(words: &[OsString]) -> Result<()> {
    let mut cargo = workspace::cargo();
    cargo.args(["run", "--quiet", "--release", "--locked", "-p", "beadwork-cli", "--bin", "beadwork", "--"]);
    cargo.args(words);
    become_it(cargo)
}

/// Cargo takes this process's place, and the binary cargo's: signals reach it and its end is ours, without anyone between.
#[cfg(unix)]
fn become_it(mut cargo: Command) -> Result<()> {
    use std::os::unix::process::CommandExt;

    Err(anyhow::Error::new(cargo.exec()).context("cargo could not be started"))
}

#[cfg(not(unix))]
fn become_it(mut cargo: Command) -> Result<()> {
    use anyhow::Context;

    let status = cargo.status().context("cargo could not be started")?;
    std::process::exit(status.code().unwrap_or(1))
}
