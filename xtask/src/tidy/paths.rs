//! Checks that the files that documentation names exist.

use std::path::{Component, Path, PathBuf};

use super::numbered;

/// Folders of the root that a path in documentation may start with.
const FOLDERS: [&str; 7] = [".ci/", "configs/", "crates/", "docs/", "models/", "tests/", "xtask/"];

/// Paths in the text of a Markdown file that do not exist, according to `exists`.
///
/// This checks code spans that start with a folder of the root, such as `` `crates/grid` ``, and
/// links to files, which are relative to the folder of the Markdown file.
pub(super) fn check(
    path: &str,
    text: &str,
    exists: impl Fn(&Path) -> bool,
) -> Vec<(usize, String)> {
    let folder = Path::new(path).parent().unwrap_or(Path::new(""));
    let mut found = Vec::new();
    let mut in_code_block = false;
    for (number, line) in numbered(text) {
        if line.trim_start().starts_with("```") {
            in_code_block = !in_code_block;
        }
        if in_code_block {
            continue;
        }
        let spans = line.split('`').skip(1).step_by(2).filter(|span| is_path(span));
        let links = links(line).map(|link| folder.join(link));
        for named in spans.map(PathBuf::from).chain(links) {
            let named = normal(&named);
            if !exists(&named) {
                found.push((number, format!("'{}' does not exist", named.display())));
            }
        }
    }
    found
}

fn is_path(span: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "./_-".contains(c);
    FOLDERS.iter().any(|folder| span.starts_with(folder)) && span.chars().all(is_plain)
}

/// Targets of the links of a line, except web addresses and anchors within the page.
fn links(line: &str) -> impl Iterator<Item = &str> {
    line.split("](").skip(1).filter_map(|rest| {
        let target = rest.split(')').next()?.split('#').next()?;
        (!target.is_empty() && !target.contains("://")).then_some(target)
    })
}

/// Resolves `.` and `..` in a path, without looking at the file system.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => _ = normal.pop(),
            Component::CurDir => {}
            other => normal.push(other),
        }
    }
    normal
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(text: &str) -> Vec<String> {
        let exists = |path: &Path| path == Path::new("crates/x/a.rs");
        check("docs/page.md", text, exists).into_iter().map(|(_, what)| what).collect()
    }

    #[test]
    fn code_spans_and_links_are_checked() {
        assert!(
            missing("`crates/x/a.rs`, [a](../crates/x/a.rs#top), [web](https://x.y)").is_empty()
        );
        assert_eq!(missing("`crates/x/b.rs`"), ["'crates/x/b.rs' does not exist"]);
        assert_eq!(missing("[b](b.md)"), ["'docs/b.md' does not exist"]);
    }

    #[test]
    fn patterns_commands_and_code_blocks_are_ignored() {
        assert!(missing("`crates/*/x`, `docs/NAME --json`, `--out tests`, [top](#top)").is_empty());
        assert!(missing("```\n`crates/x/b.rs` [b](b.md)\n```\n").is_empty());
    }
}
