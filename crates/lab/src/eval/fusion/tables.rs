//! Tables of the moves and the time to the target, with a row for each layout and size.

use std::cmp::Reverse;
use std::fmt::{Result, Write};

use beadwork_console::machine;

use super::instance::{Effort, Row};
use crate::statistics::mean;

/// The instances of one layout and size.
struct Group<'a> {
    layout: &'a str,
    width: u32,
    height: u32,
    rows: Vec<&'a Row>,
}

impl Group<'_> {
    fn mean(&self, value: impl Fn(&Row) -> f64) -> f64 {
        mean(self.rows.iter().map(|row| value(row)))
    }

    fn mean_of(&self, method: &str, value: impl Fn(&Effort) -> f64) -> f64 {
        self.mean(|row| value(&row.methods[method]))
    }

    fn mean_moves(&self, method: &str) -> f64 {
        self.mean_of(method, |effort| effort.moves as f64)
    }

    /// Mean moves of a method, followed by the number of instances on which it reached the target
    /// in brackets, if that is not all of them.
    fn moves(&self, method: &str) -> String {
        let reached = self.rows.iter().filter(|row| row.methods[method].reached).count();
        let reached =
            if reached < self.rows.len() { format!(" ({reached})") } else { String::new() };
        format!("{:.0}{reached}", self.mean_moves(method))
    }
}

/// Groups rows by layout and size; the rows of a group must be consecutive.
fn groups(rows: &[Row]) -> Vec<Group<'_>> {
    let key = |row: &Row| (row.layout, row.width, row.height);
    let mut groups: Vec<Group<'_>> = rows
        .chunk_by(|a, b| key(a) == key(b))
        .map(|rows| Group {
            layout: rows[0].layout,
            width: rows[0].width,
            height: rows[0].height,
            rows: rows.iter().collect(),
        })
        .collect();
    // Voronoi before islands.
    groups.sort_by_key(|group| Reverse(group.layout));
    groups
}

/// All tables in Markdown.
pub(super) fn text(rows: &[Row]) -> std::result::Result<String, std::fmt::Error> {
    let groups = groups(rows);
    let mut text = format!("{}\n\n", machine::line());
    moves(&mut text, &groups)?;
    milliseconds(&mut text, &groups)?;
    let reached = rows.iter().filter(|row| row.methods["fusion"].reached).count();
    writeln!(text, "\nFusionNet reached the target on {reached} of {} instances.", rows.len())?;
    Ok(text)
}

fn moves(text: &mut String, groups: &[Group<'_>]) -> Result {
    writeln!(
        text,
        "Mean moves to the target; in brackets the number of instances on which it was reached, \
         if not on all:\n\n\
         | layout | size | instances | start | target | annealer | FusionNet \
         | FusionNet / annealer | greedy | chains | fast | exact: crossings |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|"
    )?;
    for group in groups {
        // If the annealer finds nothing better than the start, reaching the target takes no moves.
        let ratio = match group.mean_moves("annealer") {
            0.0 => "-".to_owned(),
            annealer => format!("{:.0} %", 100.0 * group.mean_moves("fusion") / annealer),
        };
        writeln!(
            text,
            "| {} | {}x{} | {} | {:.1} | {:.1} | {} | {} | {ratio} | {} | {} | {} | {:.1} |",
            group.layout,
            group.width,
            group.height,
            group.rows.len(),
            group.mean(|row| f64::from(row.initial)),
            group.mean(|row| f64::from(row.target)),
            group.moves("annealer"),
            group.moves("fusion"),
            group.moves("greedy"),
            group.moves("chains"),
            group.moves("fast"),
            group.mean_of("exact", |effort| f64::from(effort.crossings)),
        )?;
    }
    Ok(())
}

fn milliseconds(text: &mut String, groups: &[Group<'_>]) -> Result {
    writeln!(
        text,
        "\nMean milliseconds:\n\n\
         | layout | size | annealer | FusionNet | greedy | chains | fast | exact |\n\
         |---|---|---|---|---|---|---|---|"
    )?;
    for group in groups {
        write!(text, "| {} | {}x{} |", group.layout, group.width, group.height)?;
        for method in ["annealer", "fusion", "greedy", "chains", "fast", "exact"] {
            write!(text, " {:.1} |", 1e3 * group.mean_of(method, |effort| effort.seconds))?;
        }
        writeln!(text)?;
    }
    Ok(())
}
