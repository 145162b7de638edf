//! The tables in Markdown, and their numbers in JSON.

use std::fmt::{Result, Write};

use beadwork_console::search::Row;
use beadwork_grid::Layout;
use beadwork_search::anneal::Preset;
use beadwork_search::genetic;
use serde_json::{Value, json};

use super::runs::{Column, Runs, gap};
use crate::eval::zones::cell_table::{self, instances, percent};
use crate::statistics::Interval;

/// The columns of the tables with one row per cell, and their headings.
fn columns(presets: &[genetic::Preset]) -> Vec<(String, Column)> {
    let mut columns = vec![
        ("zigzag".to_owned(), Column::Zigzag),
        ("anneal `paper`".to_owned(), Column::Anneal(Preset::Paper)),
        ("anneal `fast`".to_owned(), Column::Anneal(Preset::Fast)),
    ];
    columns.extend(
        presets.iter().map(|&preset| (format!("genetic `{preset}`"), Column::Genetic(preset))),
    );
    columns.push(("exact".to_owned(), Column::Exact));
    columns
}

/// The numbers of one cell as a JSON object.
pub(super) fn summary(runs: &Runs, presets: &[genetic::Preset]) -> Value {
    let cell = &runs.cell;
    let mut columns = columns(presets);
    columns.push(("anneal paper's presets".to_owned(), Column::AnnealPaper));
    columns.push(("anneal averaged".to_owned(), Column::AnnealAveraged));
    let columns = columns.into_iter().map(|(name, column)| {
        let value = json!({
            "best_percent": runs.best(column),
            "mean_percent": runs.mean(column, Row::reduction),
            "mean_crossings": runs.mean_crossings(column),
            "mean_gap": runs.mean(column, gap),
            "mean_seconds": runs.mean(column, |row| row.seconds),
        });
        (name.replace('`', ""), value)
    });
    json!({
        "layout": cell.layout.name(), "size": cell.size.to_string(),
        "instances": runs.instances(),
        "mean_bound": runs.mean_bound(),
        "paper": {
            "zigzag": cell.zigzag, "anneal_best_percent": cell.best,
            "anneal_mean_percent": cell.mean, "genetic_best_percent": cell.genetic,
        },
        "ours": columns.collect::<serde_json::Map<String, Value>>(),
    })
}

/// Writes all tables.
pub(super) fn markdown(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> Result {
    reductions(text, all, presets)?;
    crossings(text, all, presets)?;
    seconds(text, all, presets)?;
    savings(text, all, presets)?;
    comparisons(text, all, presets)?;
    instances(text, all.iter().map(|runs| (runs.cell, runs.instances())))
}

/// Tables of reductions, with the paper's figures in brackets.
fn reductions(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> Result {
    let genetic = |runs: &Runs, value: &dyn Fn(&Runs, Column) -> f64| -> String {
        let values = presets.iter().map(|&preset| percent(value(runs, Column::Genetic(preset))));
        values.collect::<Vec<_>>().join(" / ")
    };
    let names = presets.iter().map(|preset| format!("`{preset}`")).collect::<Vec<_>>().join(" / ");
    let best = |runs: &Runs, column| runs.best(column);
    let mean = |runs: &Runs, column| runs.mean(column, Row::reduction);

    writeln!(
        text,
        "\n## Table 1: best reduction by the genetic algorithm, in %: {names} (the paper)\n"
    )?;
    table(text, all, |runs| format!("{} ({:.1})", genetic(runs, &best), runs.cell.genetic))?;
    writeln!(
        text,
        "\n## Table 3: best reduction by annealing, in %: the paper's presets / `fast` \
         (the paper)\n"
    )?;
    table(text, all, |runs| {
        let [ours, fast] =
            [Column::AnnealPaper, Column::Anneal(Preset::Fast)].map(|column| best(runs, column));
        format!("{} / {} ({:.1})", percent(ours), percent(fast), runs.cell.best)
    })?;
    writeln!(
        text,
        "\n## Table 5: mean reduction by annealing, in %: preset `paper` / mean of `medium`, \
         `paper`, `long` and `extra_long` (the paper)\n"
    )?;
    table(text, all, |runs| {
        let [paper, averaged] = [Column::Anneal(Preset::Paper), Column::AnnealAveraged]
            .map(|column| mean(runs, column));
        format!("{} / {} ({:.1})", percent(paper), percent(averaged), runs.cell.mean)
    })?;
    writeln!(text, "\n## Mean reduction, in %: genetic {names}; `fast`; exact\n")?;
    table(text, all, |runs| {
        let [fast, exact] =
            [Column::Anneal(Preset::Fast), Column::Exact].map(|column| mean(runs, column));
        format!("{}; {}; {}", genetic(runs, &mean), percent(fast), percent(exact))
    })
}

/// Table of crossings, bounds and gaps, with a row for each cell.
fn crossings(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> Result {
    writeln!(
        text,
        "\n## Mean crossings, mean of the proven bounds, and smallest gaps of annealing, genetic \
         and exact runs\n"
    )?;
    let columns = columns(presets);
    row_head(text, &columns, " bound | gaps |")?;
    for runs in all {
        let values: Vec<String> = columns
            .iter()
            .map(|&(_, column)| format!("{:.1}", runs.mean_crossings(column)))
            .collect();
        let min_gap = |column| runs.column(column).map(gap).fold(f64::NAN, f64::min);
        writeln!(
            text,
            "| {} | {} | {} | {:.1} | {:.0}, {:.0}, {:.0} |",
            runs.cell.layout,
            runs.cell.size,
            values.join(" | "),
            runs.mean_bound(),
            min_gap(Column::AnnealAny),
            min_gap(Column::GeneticAny),
            min_gap(Column::Exact),
        )?;
    }
    Ok(())
}

/// Table of run times, with a row for each cell.
fn seconds(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> Result {
    writeln!(text, "\n## Mean seconds, one thread each; genetic including its annealing runs\n")?;
    let columns = columns(presets);
    row_head(text, &columns, "")?;
    for runs in all {
        let values: Vec<String> = columns
            .iter()
            .map(|&(_, column)| format!("{:.4}", runs.mean(column, |row| row.seconds)))
            .collect();
        let values = values.join(" | ");
        writeln!(text, "| {} | {} | {values} |", runs.cell.layout, runs.cell.size)?;
    }
    Ok(())
}

/// The first two lines of a table with a row for each cell; `more` holds headings of further
/// columns, each followed by " |".
fn row_head(text: &mut String, columns: &[(String, Column)], more: &str) -> Result {
    let headings: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let count = 2 + columns.len() + more.matches('|').count();
    writeln!(text, "| layout | size | {} |{more}", headings.join(" | "))?;
    writeln!(text, "|{}", "---|".repeat(count))
}

/// Table of the crossings that crossover saves beyond the best annealing run of the first
/// population.
fn savings(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> Result {
    writeln!(
        text,
        "\n## Crossings that the genetic algorithm saves beyond the best run of its first \
         population\n\n\
         Mean over the sizes with its 95 % confidence interval, and the share of runs that save \
         any.\n"
    )?;
    let names = presets.iter().map(|preset| format!("`{preset}`")).collect::<Vec<_>>().join(" | ");
    writeln!(text, "| layout | {names} |\n|---|{}", "---|".repeat(presets.len()))?;
    for layout in Layout::PAPER {
        let entries = presets.iter().map(|&preset| {
            let saved =
                |row: &Row| Some(row.genetic.as_ref()?.seeded as f64 - f64::from(row.crossings));
            let saved_by_cell: Vec<Vec<f64>> = all
                .iter()
                .filter(|runs| runs.cell.layout == layout)
                .map(|runs| runs.column(Column::Genetic(preset)).filter_map(saved).collect())
                .collect();
            let (mut runs, mut saving) = (0, 0);
            for &saved in saved_by_cell.iter().flatten() {
                runs += 1;
                saving += usize::from(saved > 0.0);
            }
            let share = 100.0 * saving as f64 / f64::from(runs);
            format!("{}, {share:.0} %", Interval::of(&saved_by_cell))
        });
        writeln!(text, "| {layout} | {} |", entries.collect::<Vec<_>>().join(" | "))?;
    }
    Ok(())
}

/// List of comparisons: in how many cells one column is at least as good as another, and in which
/// cells it is not.
fn comparisons(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> Result {
    // The paper's figures have one decimal.
    const ROUNDING: f64 = 0.05;

    writeln!(text, "\n## Cells in which the best reduction is at least as large\n")?;
    let mut line = |what: &str, holds: &dyn Fn(&Runs) -> bool| {
        let exceptions: Vec<String> = all
            .iter()
            .filter(|runs| !holds(runs))
            .map(|runs| format!("{} {}", runs.cell.layout, runs.cell.size))
            .collect();
        let (count, of) = (all.len() - exceptions.len(), all.len());
        let except = if exceptions.is_empty() {
            String::new()
        } else {
            format!(" (not {})", exceptions.join(", "))
        };
        writeln!(text, "- {what}: {count} of {of}{except}")
    };
    for &preset in presets {
        let column = Column::Genetic(preset);
        line(&format!("genetic `{preset}` as the paper's Table 1"), &|runs| {
            runs.best(column) >= runs.cell.genetic - ROUNDING
        })?;
        line(&format!("genetic `{preset}` as annealing by the paper's presets"), &|runs| {
            runs.best(column) >= runs.best(Column::AnnealPaper)
        })?;
    }
    line("genetic, best preset, as the paper's Table 1", &|runs| {
        runs.best(Column::GeneticAny) >= runs.cell.genetic - ROUNDING
    })?;
    line("genetic, best preset, as annealing by any preset, including `fast`", &|runs| {
        runs.best(Column::GeneticAny) >= runs.best(Column::AnnealAny)
    })?;
    line("annealing by the paper's presets as the paper's Table 3", &|runs| {
        runs.best(Column::AnnealPaper) >= runs.cell.best - ROUNDING
    })?;
    line("annealing by any preset as the paper's Table 3", &|runs| {
        runs.best(Column::AnnealAny) >= runs.cell.best - ROUNDING
    })
}

/// A row for each layout, a column for each size.
fn table(text: &mut String, all: &[Runs], entry: impl Fn(&Runs) -> String) -> Result {
    cell_table::table(text, |cell| {
        let runs = all.iter().find(|runs| runs.cell.is_same(cell));
        runs.map_or_else(|| "-".to_owned(), &entry)
    })
}
