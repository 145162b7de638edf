//! `cargo xtask COMMAND ...`: builds the binary `beadwork` in release and runs it, with the feature
//! `learn` where the command needs it.

use std::ffi::OsString;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::{setup, workspace};

/// Builds the binary and runs it in the current folder, so that relative paths work.
pub(crate) fn run(words: &[OsString]) -> Result<()> {
    let learns = needs_libtorch(words);
    if learns {
        setup::provide_any()?;
    }
    let mut cargo = workspace::cargo();
    cargo.args(["run", "--release", "--locked", "-p", "beadwork-cli", "--bin", "beadwork"]);
    if learns {
        cargo.args(["--features", "learn"]);
    }
    // The first build takes minutes, so cargo shows its progress; later ones are quick.
    if first_build(learns) {
        let time = if learns { "about ten minutes" } else { "about two minutes" };
        eprintln!("xtask: building beadwork for the first time, which takes {time}");
        if !std::io::stderr().is_terminal() {
            eprintln!("xtask: compiled packages are listed below");
        }
    } else {
        cargo.arg("--quiet");
    }
    cargo.arg("--").args(words);
    exec(cargo)
}

/// Whether this is the first release build of the binary, or the first with libtorch if `learns`.
fn first_build(learns: bool) -> bool {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| workspace::root().join("target"), PathBuf::from);
    let release = target.join("release");
    let has_libtorch = || {
        let packages = release.join("build").read_dir();
        packages.is_ok_and(|mut entries| {
            entries.any(|entry| {
                entry.is_ok_and(|e| e.file_name().to_string_lossy().starts_with("torch-sys-"))
            })
        })
    };
    let binary = release.join("beadwork").with_extension(std::env::consts::EXE_EXTENSION);
    !binary.exists() || learns && !has_libtorch()
}

/// Whether a command needs the feature `learn`, whose first build takes minutes longer.
fn needs_libtorch(words: &[OsString]) -> bool {
    let word = |at: usize| words.get(at).and_then(|word| word.to_str()).unwrap_or_default();
    match word(0) {
        "train" => true,
        "eval" => word(1) == "fusion",
        "bench" => word(1) == "learn",
        "zones" => has_flag(words, "--method", "fusion"),
        "plan" => has_flag(words, "--planner", "ppo"),
        _ => false,
    }
}

/// Whether a flag has a value, as one word or as two.
fn has_flag(words: &[OsString], flag: &str, value: &str) -> bool {
    words.windows(2).any(|pair| pair[0] == flag && pair[1] == value)
        || words.iter().any(|word| *word == *format!("{flag}={value}"))
}

/// Replaces this process with cargo, which replaces itself with the binary.
///
/// So signals and the exit code need no forwarding.
#[cfg(unix)]
fn exec(mut cargo: Command) -> Result<()> {
    use std::os::unix::process::CommandExt;

    Err(anyhow::Error::new(cargo.exec()).context("cannot start cargo"))
}

#[cfg(not(unix))]
fn exec(mut cargo: Command) -> Result<()> {
    use anyhow::Context;

    let status = cargo.status().context("cannot start cargo")?;
    std::process::exit(status.code().unwrap_or(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_commands_with_networks_need_libtorch() {
        let needs_libtorch = |line: &str| {
            needs_libtorch(&line.split_whitespace().map(OsString::from).collect::<Vec<_>>())
        };
        for line in [
            "train fusion --preset small",
            "train --help",
            "eval fusion",
            "bench learn",
            "zones --size 30x30 --method fusion",
            "zones --method=fusion",
            "plan part.stl --objective heat --planner ppo --policy runs/general",
            "plan part.stl --planner=ppo",
        ] {
            assert!(needs_libtorch(line), "{line}");
        }
        for line in [
            "eval zones",
            "eval",
            "bench grid",
            "zones --method anneal",
            "zones --svg fusion",
            "plan fusion",
            "plan part.stl --objective heat --planner lines",
        ] {
            assert!(!needs_libtorch(line), "{line}");
        }
    }
}
