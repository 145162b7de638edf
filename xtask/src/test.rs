//! `cargo xtask test`: everything a change has to pass, in the order of what fails fastest.

use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, ensure};

use crate::{setup, tidy, workspace};

/// Runs all steps; the first that fails is the last.
pub(crate) fn run() -> Result<()> {
    let begin = Instant::now();
    cargo_step(&["fmt", "--all", "--check"], None)?;
    cargo_step(&["clippy", "--locked", "--all-targets", "--", "-D", "warnings"], None)?;
    step("tidy", tidy::run)?;
    if has_nextest() {
        cargo_step(&["nextest", "run", "--locked"], None)?;
        // Nextest runs no examples in documentation.
        cargo_step(&["test", "--doc", "--locked"], None)?;
    } else {
        cargo_step(&["test", "--locked"], None)?;
    }
    let strict = Some(("RUSTDOCFLAGS", "-D warnings"));
    cargo_step(&["doc", "--no-deps", "--locked"], strict)?;
    // What learns comes last: the first time it is fetched and built for minutes.
    step("what learns: libtorch", setup::provide_any)?;
    // In the tests' own profile, so that C++ is compiled once for both.
    let lints = ["clippy", "--locked", "--all-targets", "--profile", "test"];
    cargo_step(&learning(&lints, &["--", "-D", "warnings"]), None)?;
    // Tests already run side by side, and threads that wait for each other's cores cost more than
    // they bring.
    cargo_step(&learning(&["test", "--locked"], &[]), Some(("OMP_NUM_THREADS", "1")))?;
    cargo_step(&["doc", "--no-deps", "--locked", "-p", "beadwork-learn"], strict)?;
    eprintln!("xtask: all passed in {:.1} s", begin.elapsed().as_secs_f64());
    Ok(())
}

/// Words of cargo for what needs libtorch: it is not among the workspace's default members, for it
/// takes minutes to build.
fn learning<'a>(first: &[&'a str], last: &[&'a str]) -> Vec<&'a str> {
    let packages =
        ["-p", "beadwork-learn", "-p", "beadwork-cli", "--features", "beadwork-cli/learn"];
    [first, &packages, last].concat()
}

/// Announces a step, does it and tells the seconds.
fn step<T>(name: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
    eprintln!("xtask: {name}");
    let begin = Instant::now();
    let done = work();
    let how = if done.is_ok() { "passed" } else { "failed" };
    eprintln!("xtask: {name}: {how} in {:.1} s", begin.elapsed().as_secs_f64());
    done
}

fn cargo_step(words: &[&str], variable: Option<(&str, &str)>) -> Result<()> {
    let name = format!("cargo {}", words.join(" "));
    step(&name, || {
        let status =
            cargo_at_root(words).envs(variable).status().context("cargo could not be started")?;
        ensure!(status.success(), "'{name}' failed: {status}");
        Ok(())
    })
}

/// Elsewhere than at the root, cargo would mean the package of that folder only.
fn cargo_at_root(words: &[&str]) -> Command {
    let mut cargo = workspace::cargo();
    cargo.current_dir(workspace::root()).args(words);
    cargo
}

fn has_nextest() -> bool {
    let mut ask = cargo_at_root(&["nextest", "--version"]);
    ask.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}
