//! Checks that packages inherit metadata and lints from the workspace.

use std::collections::BTreeSet;

use super::numbered;

/// Keys of `[package]` that a package inherits from the workspace.
pub(super) const INHERITED: [&str; 4] = ["version", "edition", "rust-version", "license"];

/// Checks a manifest line by line; recognises only the spelling that this workspace uses.
pub(super) fn check(text: &str) -> Vec<(usize, String)> {
    let mut table = "";
    let mut package = None;
    let mut inherits = BTreeSet::new();
    for (number, line) in numbered(text) {
        let line = line.split('#').next().unwrap_or(line).trim();
        if line.starts_with('[') {
            table = line.trim_matches(['[', ']']).trim();
            match table {
                "package" => package = Some(number),
                // The root manifest inherits nothing.
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
        .map(|key| (package, format!("{key} is not inherited: write {key}.workspace = true")))
        .collect();
    if !inherits.contains("lints") {
        found.push((
            package,
            "lints are not inherited: write workspace = true under [lints]".to_owned(),
        ));
    }
    found
}
