//! Tables of the paper's 24 cells.

use std::fmt::Write;

use beadwork_grid::Layout;

use crate::paper::{self, Cell};

/// A share, or a dash where no run gave one.
pub(super) fn percent(value: f64) -> String {
    if value.is_nan() { "-".to_owned() } else { format!("{value:.1}") }
}

/// A table of the 24 cells, a row for each layout.
pub(super) fn table(text: &mut String, entry: impl Fn(&Cell) -> String) -> std::fmt::Result {
    let sizes = paper::SIZES.map(|size| size.to_string());
    writeln!(text, "| layout | {} |", sizes.join(" | "))?;
    writeln!(text, "|---|{}", "---|".repeat(sizes.len()))?;
    for layout in Layout::PAPER {
        let cells: Vec<String> =
            paper::cells().filter(|cell| cell.layout == layout).map(|cell| entry(&cell)).collect();
        writeln!(text, "| {layout} | {} |", cells.join(" | "))?;
    }
    Ok(())
}

/// How many instances of each random cell are like the paper's.
pub(super) fn instances(
    text: &mut String,
    counts: impl Iterator<Item = (Cell, usize)>,
) -> std::fmt::Result {
    writeln!(text, "\nInstances whose zigzag crosses within 10 % as often as the paper's:")?;
    for (Cell { layout, size, zigzag, .. }, count) in
        counts.filter(|(cell, _)| cell.layout.is_random())
    {
        writeln!(text, "- {layout} {size}: {count} (the paper's crosses {zigzag} times)")?;
    }
    Ok(())
}
