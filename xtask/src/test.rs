//! `cargo xtask test`: all checks that a change must pass, the fastest first.

use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, ensure};

use crate::{setup, tidy, workspace};

/// Runs all steps, up to the first that fails.
pub(crate) fn run() -> Result<()> {
    let begin = Instant::now();
    cargo_step(&["fmt", "--all", "--check"], None)?;
    cargo_step(&["clippy", "--locked", "--all-targets", "--", "-D", "warnings"], None)?;
    step("tidy", tidy::run)?;
    if has_nextest() {
        cargo_step(&["nextest", "run", "--locked"], None)?;
        // Nextest does not run examples in documentation.
        cargo_step(&["test", "--doc", "--locked"], None)?;
    } else {
        cargo_step(&["test", "--locked"], None)?;
    }
    let strict = Some(("RUSTDOCFLAGS", "-D warnings"));
    cargo_step(&["doc", "--no-deps", "--locked"], strict)?;
    // Code that links libtorch comes last: the first time, libtorch is downloaded and built
    // against.
    step("libtorch", setup::provide_any)?;
    // The profile is that of the tests, so that C++ is compiled only once.
    let lints = ["clippy", "--locked", "--all-targets", "--profile", "test"];
    cargo_step(&with_libtorch(&lints, &["--", "-D", "warnings"]), None)?;
    // Tests run in parallel; letting libtorch start threads in each of them makes them slower.
    cargo_step(&with_libtorch(&["test", "--locked"], &[]), Some(("OMP_NUM_THREADS", "1")))?;
    cargo_step(&["doc", "--no-deps", "--locked", "-p", "beadwork-learn"], strict)?;
    eprintln!("xtask: all passed in {:.1} s", begin.elapsed().as_secs_f64());
    Ok(())
}

/// Arguments of cargo for the packages that link libtorch.
/// They are not default members of the workspace, since they take minutes to build.
fn with_libtorch<'a>(first: &[&'a str], last: &[&'a str]) -> Vec<&'a str> {
    let packages =
        ["-p", "beadwork-learn", "-p", "beadwork-cli", "--features", "beadwork-cli/learn"];
    [first, &packages, last].concat()
}

/// Announces a step, runs it and reports the time it took.
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
        let status = cargo_at_root(words).envs(variable).status().context("cannot start cargo")?;
        ensure!(status.success(), "'{name}' failed: {status}");
        Ok(())
    })
}

/// Cargo in the root folder: in the folder of a package it would check that package only.
fn cargo_at_root(words: &[&str]) -> Command {
    let mut cargo = workspace::cargo();
    cargo.current_dir(workspace::root()).args(words);
    cargo
}

fn has_nextest() -> bool {
    let mut version = cargo_at_root(&["nextest", "--version"]);
    version.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|s| s.success())
}
