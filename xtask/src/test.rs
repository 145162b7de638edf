//! `cargo xtask test`: everything a change has to pass, in the order of what fails fastest.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};

use crate::{tidy, workspace};

/// Runs all steps; the first that fails is the last.
pub(crate) fn run() -> Result<()> {
    let begin = Instant::now();
    cargo_step(&["fmt", "--all", "--check"], None)?;
    cargo_step(&["clippy", "--locked", "--all-targets", "--", "-D", "warnings"], None)?;
    step("tidy", tidy::run)?;
    // The end-to-end tests run the binary as it ships; which file that is, only cargo knows for sure.
    let binary = step("cargo build --locked --release -p beadwork-cli --bin beadwork", build_binary)?;
    let binary = Some(("BEADWORK_BIN", binary));
    if has_nextest() {
        cargo_step(&["nextest", "run", "--locked"], binary.clone())?;
        // Nextest runs no examples in documentation.
        cargo_step(&["test", "--doc", "--locked"], binary)?;
    } else {
        cargo_step(&["test", "--locked"], binary)?;
    }
    cargo_step(&["doc", "--no-deps", "--locked"], Some(("RUSTDOCFLAGS", PathBuf::from("-D warnings"))))?;
    eprintln!("xtask: all passed in {:.1} s", begin.elapsed().as_secs_f64());
    Ok(())
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

fn cargo_step(words: &[&str], variable: Option<(&str, PathBuf)>) -> Result<()> {
    let name = format!("cargo {}", words.join(" "));
    step(&name, || {
        let status = cargo_at_root(words).envs(variable).status().context("cargo could not be started")?;
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

/// Builds `beadwork` in release and gives the path of the file.
fn build_binary() -> Result<PathBuf> {
    let words = ["build", "--locked", "--release", "-p", "beadwork-cli", "--bin", "beadwork"];
    let output = cargo_at_root(&words)
        .arg("--message-format=json-render-diagnostics")
        .stderr(Stdio::inherit())
        .output()
        .context("cargo could not be started")?;
    ensure!(output.status.success(), "the binary could not be built: {}", output.status);
    let messages = String::from_utf8(output.stdout).context("cargo's messages are not UTF-8")?;
    let Some(binary) = last_executable(&messages) else { bail!("cargo built the binary but named no file") };
    Ok(binary)
}

/// The file that the last of cargo's JSON messages to name one calls `executable`.
///
/// A reader of JSON would be this program's largest dependency; the one string it needs is quoted here.
fn last_executable(messages: &str) -> Option<PathBuf> {
    let (_, quoted) = messages.rsplit_once(r#""executable":""#)?;
    let mut path = String::new();
    let mut chars = quoted.chars();
    loop {
        match chars.next()? {
            '"' => return Some(PathBuf::from(path)),
            '\\' => match chars.next()? {
                escaped @ ('"' | '\\' | '/') => path.push(escaped),
                // Control characters: nobody names a folder so.
                _ => return None,
            },
            other => path.push(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_executable_is_found_among_messages() {
        let messages = concat!(
            r#"{"reason":"compiler-artifact","target":{"kind":["lib"]},"executable":null,"fresh":true}"#,
            "\n",
            r#"{"reason":"compiler-artifact","executable":"/a folder/release/beadwork","fresh":true}"#,
            "\n",
            r#"{"reason":"build-finished","success":true}"#,
        );
        assert_eq!(last_executable(messages), Some(PathBuf::from("/a folder/release/beadwork")));
    }

    #[test]
    fn escapes_in_the_path_are_undone() {
        let message = r#"{"executable":"C:\\target\\release\\a \"b\".exe"}"#;
        assert_eq!(last_executable(message), Some(PathBuf::from(r#"C:\target\release\a "b".exe"#)));
    }

    #[test]
    fn no_executable_is_none() {
        assert_eq!(last_executable(r#"{"reason":"build-finished","success":true}"#), None);
        assert_eq!(last_executable(r#"{"executable":"cut off"#), None);
    }
}
