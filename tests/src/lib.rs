//! End-to-end tests of the binary `beadwork`: what these helpers start is what a user would.
//!
//! It is the one in the target folder, which cargo builds with the tests of the whole workspace, or
//! the one that `BEADWORK_BIN` names.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The binary, ready to be given arguments.
///
/// # Panics
/// If it has not been built.
pub fn beadwork() -> Command {
    let mut command = Command::new(binary());
    command.current_dir(std::env::temp_dir());
    command
}

/// The path of the binary.
///
/// # Panics
/// If it has not been built.
pub fn binary() -> PathBuf {
    if let Some(path) = std::env::var_os("BEADWORK_BIN") {
        return path.into();
    }
    let test = std::env::current_exe().expect("a test has a file");
    let profile = test.ancestors().nth(2).expect("tests lie two folders below their profile");
    let binary = profile.join("beadwork").with_extension(std::env::consts::EXE_EXTENSION);
    assert!(
        binary.exists(),
        "the binary is built with all tests: run `cargo xtask test`, or `cargo build -p beadwork-cli` first"
    );
    binary
}

/// Runs the binary with arguments that must work, and gives what it printed.
///
/// # Panics
/// If it fails.
pub fn run(arguments: &[&str]) -> String {
    let output = beadwork().args(arguments).output().expect("the binary starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("it prints text")
}

/// Runs the binary with arguments that must fail, and gives its one line of error.
///
/// # Panics
/// If it succeeds, prints more or less than one line, or ends with another exit code than 1.
pub fn fail(arguments: &[&str]) -> String {
    let output = beadwork().args(arguments).output().expect("the binary starts");
    one_error(&output)
}

/// The one line of error of a run that failed.
///
/// # Panics
/// If the run did not fail like that.
pub fn one_error(output: &Output) -> String {
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    let lines: Vec<&str> = stderr.lines().collect();
    assert_eq!(lines.len(), 1, "one line of error, not: {stderr}");
    assert!(lines[0].starts_with("beadwork: "), "{stderr}");
    lines[0].to_owned()
}

/// Runs the binary with arguments that make no sense, and gives its complaint.
///
/// # Panics
/// If it ends with another exit code than 2.
pub fn misused(arguments: &[&str]) -> String {
    let output = beadwork().args(arguments).output().expect("the binary starts");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    stderr
}

/// Name and bytes of every file of a dataset; the times of the searches are no part of it.
///
/// # Panics
/// If the folder can't be read.
pub fn dataset(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("it can be read").path());
    let files = entries.filter(|path| !path.to_string_lossy().ends_with(".ms.csv"));
    files
        .map(|path| {
            let name = path.file_name().expect("a file has a name").to_string_lossy().into_owned();
            (name, fs::read(&path).expect("it can be read"))
        })
        .collect()
}

/// A path as text.
///
/// # Panics
/// If it is no Unicode.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("temporary folders have plain names")
}
