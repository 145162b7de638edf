//! Markdown tables of the paper's 24 cells.

use std::fmt::Write;

use beadwork_grid::Layout;

use crate::paper::{self, Cell};

/// A number in per cent, or a dash if it is NaN because there are no runs.
pub(super) fn percent(value: f64) -> String {
    if value.is_nan() { "-".to_owned() } else { format!("{value:.1}") }
}

/// Writes a table with a row for each layout and a column for each size.
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

/// Number of different instances, given their seeds, which may repeat.
pub(super) fn distinct(seeds: impl Iterator<Item = u64>) -> usize {
    let mut seeds: Vec<u64> = seeds.collect();
    seeds.sort_unstable();
    seeds.dedup();
    seeds.len()
}

/// Lists, for each cell with a random layout, the number of instances like the paper's.
pub(super) fn instances(
    text: &mut String,
    counts: impl Iterator<Item = (Cell, usize)>,
) -> std::fmt::Result {
    writeln!(
        text,
        "\nInstances whose zigzag has as many crossings as the paper's, within 10 %:\n"
    )?;
    for (Cell { layout, size, zigzag, .. }, count) in
        counts.filter(|(cell, _)| cell.layout.is_random())
    {
        writeln!(text, "- {layout} {size}: {count} ({zigzag} crossings in the paper)")?;
    }
    Ok(())
}
