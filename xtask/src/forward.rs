//! `cargo xtask WORD ...`: the binary `beadwork`, built in release, and with what learns where the
//! words ask for it.

use std::ffi::OsString;
use std::process::Command;

use anyhow::Result;

use crate::{setup, workspace};

/// Builds and runs the binary in the caller's folder, where relative paths among the words mean
/// what they say.
pub(crate) fn run(words: &[OsString]) -> Result<()> {
    let mut cargo = workspace::cargo();
    cargo.args([
        "run",
        "--quiet",
        "--release",
        "--locked",
        "-p",
        "beadwork-cli",
        "--bin",
        "beadwork",
    ]);
    if learns(words) {
        setup::provide_any()?;
        cargo.args(["--features", "learn"]);
    }
    cargo.arg("--").args(words);
    become_it(cargo)
}

/// Whether words need the feature `learn`, with which the binary takes minutes longer to build for
/// the first time.
fn learns(words: &[OsString]) -> bool {
    let word = |at: usize| words.get(at).and_then(|word| word.to_str()).unwrap_or_default();
    match word(0) {
        "train" => true,
        "eval" => word(1) == "fusion",
        "bench" => word(1) == "learn",
        "zones" => {
            words.windows(2).any(|pair| pair[0] == "--method" && pair[1] == "fusion")
                || words.iter().any(|word| word == "--method=fusion")
        }
        _ => false,
    }
}

/// Cargo takes this process's place, and the binary cargo's: signals reach it and its end is ours,
/// without anyone between.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_learns_needs_libtorch() {
        let learns =
            |line: &str| learns(&line.split_whitespace().map(OsString::from).collect::<Vec<_>>());
        for line in [
            "train fusion --preset small",
            "train --help",
            "eval fusion",
            "bench learn",
            "zones --size 30x30 --method fusion",
            "zones --method=fusion",
        ] {
            assert!(learns(line), "{line}");
        }
        for line in [
            "eval zones",
            "eval",
            "bench grid",
            "zones --method anneal",
            "zones --svg fusion",
            "plan fusion",
        ] {
            assert!(!learns(line), "{line}");
        }
    }
}
