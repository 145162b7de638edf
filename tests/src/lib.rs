//! Helpers of the end-to-end tests, which run the binary `beadwork` as a user would.
//!
//! The binary is the one in the target folder, which cargo builds with the tests of the workspace,
//! or the one that `BEADWORK_BIN` names.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A command that runs the binary in a temporary folder.
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
    let test = std::env::current_exe().expect("a test has an executable");
    let profile =
        test.ancestors().nth(2).expect("test executables lie two folders below the profile");
    let binary = profile.join("beadwork").with_extension(std::env::consts::EXE_EXTENSION);
    assert!(
        binary.exists(),
        "binary not built: run `cargo build -p beadwork-cli` first, or `cargo xtask test`"
    );
    binary
}

/// Runs the binary, which must succeed; returns its standard output.
///
/// # Panics
/// If it fails.
pub fn run(arguments: &[&str]) -> String {
    let output = beadwork().args(arguments).output().expect("the binary runs");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("output is UTF-8")
}

/// Runs the binary, which must fail; returns its one line of error.
///
/// # Panics
/// If it succeeds, prints more or less than one line, or ends with another exit code than 1.
pub fn fail(arguments: &[&str]) -> String {
    let output = beadwork().args(arguments).output().expect("the binary runs");
    one_error(&output)
}

/// The one line of error of a failed run.
///
/// # Panics
/// If the run succeeded, printed more or fewer lines, or ended with another exit code than 1.
pub fn one_error(output: &Output) -> String {
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    let lines: Vec<&str> = stderr.lines().collect();
    assert_eq!(lines.len(), 1, "one line of error, not: {stderr}");
    assert!(lines[0].starts_with("beadwork: "), "{stderr}");
    lines[0].to_owned()
}

/// Runs the binary with invalid arguments; returns its standard error.
///
/// # Panics
/// If it ends with another exit code than 2.
pub fn misused(arguments: &[&str]) -> String {
    let output = beadwork().args(arguments).output().expect("the binary runs");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    stderr
}

/// Name and bytes of every file of a dataset, without the times of the searches.
///
/// # Panics
/// If the folder cannot be read.
pub fn dataset(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder)
        .expect("the folder exists")
        .map(|entry| entry.expect("the entry can be read").path());
    let files = entries.filter(|path| !path.to_string_lossy().ends_with(".ms.csv"));
    files
        .map(|path| {
            let name = path.file_name().expect("a file has a name").to_string_lossy().into_owned();
            (name, fs::read(&path).expect("the entry can be read"))
        })
        .collect()
}

/// A path as text.
///
/// # Panics
/// If the path is not Unicode.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("paths of temporary folders are Unicode")
}
