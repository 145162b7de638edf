//! `cargo xtask tidy`: checks that are not part of rustfmt or clippy.

mod manifest;
mod paths;
#[cfg(test)]
mod tests;
mod words;

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::io::ErrorKind;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use self::words::BannedWords;
use crate::workspace;

/// Maximum number of lines of a source file: a longer one holds more than one concept.
const MAX_LINES: usize = 1200;

/// Maximum width of a line, in characters.
const MAX_COLUMNS: usize = 100;

/// Maximum size of a file in bytes: git keeps every version of it forever.
const MAX_BYTES: u64 = 4 << 20;

/// Macros of unfinished work; without the exclamation mark, so that this list does not report
/// itself.
const LEFTOVERS: [&str; 3] = ["todo", "unimplemented", "dbg"];

/// A fault in a file.
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

/// Checks the files that git tracks, and those that `git add` would add.
pub(crate) fn run() -> Result<()> {
    let tracked = git_files(&["--cached"])?;
    let untracked = git_files(&["--others", "--exclude-standard"])?;
    let words = BannedWords::load();
    let mut problems = Vec::new();
    for path in tracked.union(&untracked) {
        let file = workspace::root().join(path);
        let metadata = match fs::symlink_metadata(&file) {
            Ok(metadata) => metadata,
            // Deleted, but still tracked.
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            Err(error) => return Err(error).with_context(|| path.clone()),
        };
        if !metadata.is_file() {
            continue;
        }
        if tracked.contains(path) && metadata.len() > MAX_BYTES {
            let what = format!(
                "{} bytes in git, more than {MAX_BYTES}: generate or download it",
                metadata.len()
            );
            problems.push(Problem { path: path.clone(), line: 1, what });
        }
        if is_checked(path) {
            let text = fs::read_to_string(&file).with_context(|| path.clone())?;
            problems.extend(check(path, &text, &words));
        }
    }
    for problem in &problems {
        eprintln!("{problem}");
    }
    ensure!(problems.is_empty(), "tidy: {} problems", problems.len());
    Ok(())
}

fn git_files(which: &[&str]) -> Result<BTreeSet<String>> {
    let output = Command::new("git")
        .current_dir(workspace::root())
        .args(["ls-files", "-z"])
        .args(which)
        .output()
        .context("cannot start git")?;
    let message = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "git cannot list the files: {}", message.trim_end());
    let names = String::from_utf8(output.stdout).context("a file name is not UTF-8")?;
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
/// The path is relative to the root and has slashes.
fn check(path: &str, text: &str, words: &BannedWords) -> Vec<Problem> {
    let mut found = blanks(text);
    found.extend(wide_lines(text));
    found.extend(words.check(text));
    if has_extension(path, "rs") {
        found.extend(source(file_name(path), text));
    }
    if has_extension(path, "md") {
        found.extend(paths::check(path, text, |named| workspace::root().join(named).exists()));
    }
    if file_name(path) == "Cargo.toml" {
        found.extend(manifest::check(text));
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

/// Lines wider than [`MAX_COLUMNS`], except those that cannot be broken: rows of Markdown tables,
/// and single words such as addresses.
fn wide_lines(text: &str) -> Vec<(usize, String)> {
    let cannot_be_broken = |line: &str| {
        let content = line.trim_start().trim_start_matches(['/', '!', '#', '-', '*']).trim_start();
        content.starts_with('|') || !content.contains(' ')
    };
    numbered(text)
        .map(|(number, line)| (number, line, line.chars().count()))
        .filter(|&(_, line, columns)| columns > MAX_COLUMNS && !cannot_be_broken(line))
        .map(|(number, _, columns)| (number, format!("{columns} columns, more than {MAX_COLUMNS}")))
        .collect()
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

/// Whether the line names the macro `name!`, rather than one whose name ends with it.
fn calls(line: &str, name: &str) -> bool {
    line.match_indices(name).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        let within_a_word = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
        !within_a_word && line[at + name.len()..].starts_with('!')
    })
}
