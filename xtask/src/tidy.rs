//! `cargo xtask tidy`: what review forgets, and neither rustfmt nor clippy sees.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::io::ErrorKind;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::workspace;

/// A longer source file holds more than one concept.
const MAX_LINES: usize = 1200;

/// Git keeps every version of a file for ever.
const MAX_BYTES: u64 = 4 << 20;

/// Macros of unfinished work; without the exclamation mark, so that this list does not report
/// itself.
const LEFTOVERS: [&str; 3] = ["todo", "unimplemented", "dbg"];

/// What a crate takes from the workspace.
const INHERITED: [&str; 4] = ["version", "edition", "rust-version", "license"];

/// Something to mend.
#[derive(Debug, PartialEq, Eq)]
struct Problem {
    path: String,
    /// From 1.
    line: usize,
    what: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.path, self.line, self.what)
    }
}

/// Checks the files git tracks, and those it would take up with the next `git add`.
pub(crate) fn run() -> Result<()> {
    let tracked = git_files(&["--cached"])?;
    let fresh = git_files(&["--others", "--exclude-standard"])?;
    let mut problems = Vec::new();
    for path in tracked.union(&fresh) {
        let file = workspace::root().join(path);
        let metadata = match fs::symlink_metadata(&file) {
            Ok(metadata) => metadata,
            // Deleted, and git has not been told yet.
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            Err(error) => return Err(error).with_context(|| path.clone()),
        };
        if !metadata.is_file() {
            continue;
        }
        if tracked.contains(path) && metadata.len() > MAX_BYTES {
            let what = format!(
                "{} bytes in git, more than {MAX_BYTES}: generate or fetch it",
                metadata.len()
            );
            problems.push(Problem { path: path.clone(), line: 1, what });
        }
        if is_checked(path) {
            let text = fs::read_to_string(&file).with_context(|| path.clone())?;
            problems.extend(check(path, &text));
        }
    }
    for problem in &problems {
        eprintln!("{problem}");
    }
    ensure!(problems.is_empty(), "tidy: {} to mend", problems.len());
    Ok(())
}

fn git_files(which: &[&str]) -> Result<BTreeSet<String>> {
    let output = Command::new("git")
        .current_dir(workspace::root())
        .args(["ls-files", "-z"])
        .args(which)
        .output()
        .context("git could not be started")?;
    let complaint = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "git does not list the files: {}", complaint.trim_end());
    let names = String::from_utf8(output.stdout).context("a file's name is not UTF-8")?;
    Ok(names.split_terminator('\0').map(str::to_owned).collect())
}

fn has_extension(path: &str, extension: &str) -> bool {
    path.rsplit_once('.').is_some_and(|(_, found)| found == extension)
}

fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

fn is_checked(path: &str) -> bool {
    ["rs", "toml", "md"].into_iter().any(|extension| has_extension(path, extension))
}

/// All problems of a file, in the order of its lines.
/// The path has slashes and begins at the root.
fn check(path: &str, text: &str) -> Vec<Problem> {
    let mut found = blanks(text);
    if has_extension(path, "rs") {
        found.extend(source(file_name(path), text));
    }
    if file_name(path) == "Cargo.toml" {
        found.extend(manifest(text));
    }
    found.sort();
    found.into_iter().map(|(line, what)| Problem { path: path.to_owned(), line, what }).collect()
}

/// The number of each line, from 1, and the line.
fn numbered(text: &str) -> impl Iterator<Item = (usize, &str)> {
    (1..).zip(text.lines())
}

fn blanks(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in numbered(text) {
        if line.ends_with([' ', '\t']) {
            found.push((number, "blank at the end of the line".to_owned()));
        } else if line.contains('\t') {
            found.push((number, "tab".to_owned()));
        }
    }
    found
}

fn source(name: &str, text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    if name != "build.rs" && !text.starts_with("//!") {
        found.push((1, "does not begin with its documentation (//!)".to_owned()));
    }
    let lines = text.lines().count();
    if lines > MAX_LINES {
        found.push((MAX_LINES + 1, format!("{lines} lines, more than {MAX_LINES}: split it")));
    }
    for (number, line) in numbered(text) {
        let left = LEFTOVERS.into_iter().filter(|name| calls(line, name));
        found.extend(left.map(|name| (number, format!("{name}! is left over"))));
    }
    found
}

/// Whether the line names the macro `name!`, and not one that merely ends so.
fn calls(line: &str, name: &str) -> bool {
    line.match_indices(name).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        let within_a_word = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
        !within_a_word && line[at + name.len()..].starts_with('!')
    })
}

/// Checks a manifest line by line, in the spelling that all of them here share.
fn manifest(text: &str) -> Vec<(usize, String)> {
    let mut table = "";
    let mut package = None;
    let mut inherits = BTreeSet::new();
    for (number, line) in numbered(text) {
        let line = line.split('#').next().unwrap_or(line).trim();
        if line.starts_with('[') {
            table = line.trim_matches(['[', ']']).trim();
            match table {
                "package" => package = Some(number),
                // The root of a workspace has nobody to inherit from.
                "workspace" => return Vec::new(),
                _ => {}
            }
        } else if let Some((key, value)) = line.split_once('=') {
            match (table, key.trim(), value.trim()) {
                ("package", key, "true") => inherits.extend(key.strip_suffix(".workspace")),
                ("lints", "workspace", "true") => _ = inherits.insert("lints"),
                _ => {}
            }
        }
    }
    let Some(package) = package else { return Vec::new() };
    let missing = INHERITED.into_iter().filter(|key| !inherits.contains(key));
    let mut found: Vec<_> = missing
        .map(|key| (package, format!("{key} is not the workspace's: write {key}.workspace = true")))
        .collect();
    if !inherits.contains("lints") {
        found.push((
            package,
            "the lints are not the workspace's: write workspace = true under [lints]".to_owned(),
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(path: &str, text: &str) -> Vec<String> {
        check(path, text).iter().map(ToString::to_string).collect()
    }

    const GOOD: &str = "\
[package]
name = \"x\"
version.workspace = true
edition.workspace = true
rust-version.workspace = true # the oldest that is tried
license.workspace = true

[lints]
workspace = true
";

    #[test]
    fn a_good_source_passes() {
        assert!(report("crates/x/src/lib.rs", "//! Docs.\n\nfn f() {}\n").is_empty());
        assert!(report("crates/x/build.rs", "fn main() {}\n").is_empty());
    }

    #[test]
    fn docs_come_first() {
        let expected = ["a/b.rs:1: does not begin with its documentation (//!)"];
        assert_eq!(report("a/b.rs", "fn f() {}\n//! Docs.\n"), expected);
        assert_eq!(report("a/b.rs", ""), expected);
    }

    #[test]
    fn blanks_and_tabs_are_found_with_their_lines() {
        assert_eq!(
            report("a.md", "one \n\ntwo\t\n\tthree\n"),
            [
                "a.md:1: blank at the end of the line",
                "a.md:3: blank at the end of the line",
                "a.md:4: tab",
            ]
        );
        assert_eq!(report("a.toml", "x = 1 \n"), ["a.toml:1: blank at the end of the line"]);
        assert!(report("a.md", "one\r\ntwo\r\n").is_empty());
    }

    #[test]
    fn long_sources_are_found_but_not_long_texts() {
        let lines = |count: usize| "//! x\n".repeat(count);
        assert!(report("a.rs", &lines(MAX_LINES)).is_empty());
        assert_eq!(
            report("a.rs", &lines(MAX_LINES + 1)),
            ["a.rs:1201: 1201 lines, more than 1200: split it"]
        );
        assert!(report("a.md", &lines(MAX_LINES + 1)).is_empty());
    }

    #[test]
    fn leftovers_are_found_as_whole_words() {
        for name in LEFTOVERS {
            let text = format!("//! Docs.\nfn f() {{\n    std::{name}!()\n}}\n");
            assert_eq!(report("a.rs", &text), [format!("a.rs:3: {name}! is left over")]);
            let longer =
                format!("//! Docs.\nfn f() {{\n    my_{name}!();\n    let {name} = 1;\n}}\n");
            assert!(report("a.rs", &longer).is_empty());
        }
    }

    #[test]
    fn a_good_manifest_passes() {
        assert!(report("crates/x/Cargo.toml", GOOD).is_empty());
    }

    #[test]
    fn each_missing_inheritance_is_found() {
        for key in INHERITED {
            let text =
                GOOD.replace(&format!("\n{key}.workspace = true"), &format!("\n{key} = \"1\""));
            let what = format!(
                "x/Cargo.toml:1: {key} is not the workspace's: write {key}.workspace = true"
            );
            assert_eq!(report("x/Cargo.toml", &text), [what]);
        }
        let text = GOOD.replace("[lints]\nworkspace = true\n", "");
        let what = "x/Cargo.toml:1: the lints are not the workspace's: write workspace = true under [lints]";
        assert_eq!(report("x/Cargo.toml", &text), [what]);
    }

    #[test]
    fn a_dependency_does_not_count_as_inherited() {
        let text = GOOD
            .replace("license.workspace = true\n", "\n[dependencies]\nlicense.workspace = true\n");
        assert_eq!(report("x/Cargo.toml", &text).len(), 1);
    }

    #[test]
    fn the_root_and_other_tables_are_left_alone() {
        assert!(
            report(
                "Cargo.toml",
                "[workspace]\nmembers = []\n\n[workspace.package]\nversion = \"1\"\n"
            )
            .is_empty()
        );
        assert!(report("deny.toml", "[licenses]\nallow = []\n").is_empty());
    }
}
