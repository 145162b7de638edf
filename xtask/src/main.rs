//! `cargo xtask`: short names for the tasks of the project.
//!
//! Checks and set-up run here.
//! Every other command goes to the binary `beadwork`, which is built in release first.
//! This crate links no other crate of the workspace, so it builds in seconds.
//!
//! Exit codes: 0 success, 1 failure, 2 usage error.
//! A forwarded command returns the exit code of the binary.

#![allow(clippy::print_stderr, reason = "a task runner reports to its terminal")]

mod forward;
mod setup;
mod test;
mod tidy;
mod workspace;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use crate::setup::Target;

const HELP: &str = "\
Usage: cargo xtask COMMAND [ARGUMENTS]

Checks:
  test         check format, lints, tidy, tests and documentation; stops at the first failure
  tidy         check module docs, manifests, banned words, wide lines, leftovers

Set-up:
    setup        download libtorch for networks, once per user; if LIBTORCH is set, only check it;
                 with --cuda, a libtorch that also computes on graphics cards

Work: builds the binary `beadwork` in release and runs it
  gen-data     write training data
  inspect      show and check a dataset
  zones        find a path with few zone crossings for one layer
  plan         plan a part and write its G-code
  simulate     simulate the temperatures of a part while it is printed
    train        train a network; the first run downloads libtorch and builds for minutes
  eval         compare results with the papers' figures, and make tables of whole parts
    bench        measure run times, rates and memory on this machine
  doctor       report what is installed, what is missing, and how to get it
  completions  print a script that completes commands and flags in a shell
  Any other command goes to the binary too. `cargo xtask COMMAND --help` lists its arguments.

Examples:
  cargo xtask test
  cargo xtask zones --layout voronoi --size 30x30 --seed 1 --method anneal --svg path.svg
  cargo xtask plan example:logo-plate --objective tools --out logo.gcode
  cargo xtask simulate example:u-shape --pattern spiral-in-0
  cargo xtask gen-data --preset smoke --out datasets/smoke
  cargo xtask inspect datasets/smoke --verify
  cargo xtask train fusion --preset small --data datasets/chains --out runs/fusion
  cargo xtask bench grid
  cargo xtask setup --cuda
";

/// A task, as given on the command line.
#[derive(Debug, PartialEq, Eq)]
enum Task {
    Help,
    Setup(Target),
    Test,
    Tidy,
    /// A command of the binary, with its arguments.
    Forward(Vec<OsString>),
}

fn main() -> ExitCode {
    let task = match parse(std::env::args_os().skip(1).collect()) {
        Ok(task) => task,
        Err(error) => {
            eprintln!("xtask: {error}\nxtask: 'cargo xtask --help' lists the commands");
            return ExitCode::from(2);
        }
    };
    let done = match task {
        Task::Help => {
            // A closed pipe is not a failure.
            let _ = std::io::stdout().write_all(HELP.as_bytes());
            Ok(())
        }
        Task::Setup(target) => setup::run(target),
        Task::Test => test::run(),
        Task::Tidy => tidy::run(),
        Task::Forward(words) => forward::run(&words),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn parse(words: Vec<OsString>) -> Result<Task, String> {
    let is_help = |word: &OsString| word == "--help" || word == "-h";
    let Some(first) = words.first() else { return Ok(Task::Help) };
    let own = match first.to_str() {
        Some("help" | "--help" | "-h") => return Ok(Task::Help),
        Some("setup") if words.get(1).is_some_and(|word| word == "--cuda") && words.len() == 2 => {
            return Ok(Task::Setup(Target::Cuda));
        }
        Some("setup") => Task::Setup(Target::Cpu),
        Some("test") => Task::Test,
        Some("tidy") => Task::Tidy,
        _ if first.as_encoded_bytes().starts_with(b"-") => {
            return Err(format!("unknown option '{}'", first.display()));
        }
        _ => return Ok(Task::Forward(words)),
    };
    match words.get(1) {
        None => Ok(own),
        Some(word) if is_help(word) => Ok(Task::Help),
        Some(word) => Err(format!(
            "'{}' takes no arguments, but '{}' was given",
            first.display(),
            word.display()
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<OsString> {
        line.split_whitespace().map(OsString::from).collect()
    }

    #[test]
    fn own_commands_take_no_arguments() {
        assert_eq!(parse(words("test")), Ok(Task::Test));
        assert_eq!(parse(words("tidy")), Ok(Task::Tidy));
        assert_eq!(parse(words("setup")), Ok(Task::Setup(Target::Cpu)));
        assert_eq!(parse(words("setup --cuda")), Ok(Task::Setup(Target::Cuda)));
        assert!(parse(words("setup --cpu")).is_err());
        assert!(parse(words("test --cuda")).is_err());
        assert!(parse(words("test crates/grid")).is_err());
        assert!(parse(words("--json")).is_err());
    }

    #[test]
    fn help_of_own_commands_is_not_forwarded() {
        for line in ["", "help", "--help", "-h", "test --help", "tidy -h"] {
            assert_eq!(parse(words(line)), Ok(Task::Help), "'{line}'");
        }
    }

    #[test]
    fn other_commands_are_forwarded_unchanged() {
        for line in ["gen-data --out x", "zones --help", "no-such-word -- --json"] {
            assert_eq!(parse(words(line)), Ok(Task::Forward(words(line))), "'{line}'");
        }
    }
}
