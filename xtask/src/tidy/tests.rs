//! Tests of each check of `tidy`, with good and bad texts.

use super::manifest::INHERITED;
use super::*;

fn report(path: &str, text: &str) -> Vec<String> {
    check(path, text, &BannedWords::load()).iter().map(ToString::to_string).collect()
}

const GOOD: &str = "\
[package]
name = \"x\"
version.workspace = true
edition.workspace = true
rust-version.workspace = true # the oldest that is tested
license.workspace = true

[lints]
workspace = true
";

#[test]
fn good_source_passes() {
    assert!(report("crates/x/src/lib.rs", "//! Docs.\n\nfn f() {}\n").is_empty());
    assert!(report("crates/x/build.rs", "fn main() {}\n").is_empty());
}

#[test]
fn module_docs_come_first() {
    let expected = ["a/b.rs:1: does not begin with its documentation (//!)"];
    assert_eq!(report("a/b.rs", "fn f() {}\n//! Docs.\n"), expected);
    assert_eq!(report("a/b.rs", ""), expected);
}

#[test]
fn blanks_and_tabs_are_reported() {
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
fn long_sources_are_reported_but_not_long_texts() {
    let lines = |count: usize| "//! x\n".repeat(count);
    assert!(report("a.rs", &lines(MAX_LINES)).is_empty());
    assert_eq!(
        report("a.rs", &lines(MAX_LINES + 1)),
        ["a.rs:1201: 1201 lines, more than 1200: split it"]
    );
    assert!(report("a.md", &lines(MAX_LINES + 1)).is_empty());
}

#[test]
fn leftovers_are_reported_as_whole_words() {
    for name in LEFTOVERS {
        let text = format!("//! Docs.\nfn f() {{\n    std::{name}!()\n}}\n");
        assert_eq!(report("a.rs", &text), [format!("a.rs:3: {name}! is left over")]);
        let longer = format!("//! Docs.\nfn f() {{\n    my_{name}!();\n    let {name} = 1;\n}}\n");
        assert!(report("a.rs", &longer).is_empty());
    }
}

#[test]
fn good_manifest_passes() {
    assert!(report("crates/x/Cargo.toml", GOOD).is_empty());
}

#[test]
fn missing_inheritance_is_reported() {
    for key in INHERITED {
        let text = GOOD.replace(&format!("\n{key}.workspace = true"), &format!("\n{key} = \"1\""));
        let what = format!("x/Cargo.toml:1: {key} is not inherited: write {key}.workspace = true");
        assert_eq!(report("x/Cargo.toml", &text), [what]);
    }
    let text = GOOD.replace("[lints]\nworkspace = true\n", "");
    let what = "x/Cargo.toml:1: lints are not inherited: write workspace = true under [lints]";
    assert_eq!(report("x/Cargo.toml", &text), [what]);
}

#[test]
fn dependency_does_not_count_as_inherited() {
    let text =
        GOOD.replace("license.workspace = true\n", "\n[dependencies]\nlicense.workspace = true\n");
    assert_eq!(report("x/Cargo.toml", &text).len(), 1);
}

#[test]
fn root_and_other_tables_are_ignored() {
    assert!(
        report("Cargo.toml", "[workspace]\nmembers = []\n\n[workspace.package]\nversion = \"1\"\n")
            .is_empty()
    );
    assert!(report("deny.toml", "[licenses]\nallow = []\n").is_empty());
}

#[test]
fn wide_lines_are_reported_unless_they_cannot_be_broken() {
    let wide = "word ".repeat(21).trim_end().to_owned();
    assert_eq!(report("a.md", &wide), ["a.md:1: 104 columns, more than 100"]);
    assert!(report("a.md", &wide[..99]).is_empty());
    assert!(report("a.md", &format!("| {wide} |")).is_empty());
    assert!(report("a.rs", &format!("//! Docs.\n// https://{}\n", "x".repeat(100))).is_empty());
}
