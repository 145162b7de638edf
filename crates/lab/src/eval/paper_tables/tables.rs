//! The tables as Markdown, and their numbers.

use std::fmt::Write;

use beadwork_console::search::Row;
use beadwork_grid::Layout;
use beadwork_search::anneal::Preset;
use beadwork_search::genetic;
use serde_json::{Value, json};

use super::{Column, Runs};
use crate::eval::statistics::Interval;
use crate::eval::table::{instances, percent};
use crate::paper;

/// The columns that stand side by side, with their names in tables.
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

pub(super) fn summary(runs: &Runs, presets: &[genetic::Preset]) -> Value {
    let cell = &runs.cell;
    let mut columns = columns(presets);
    columns.push(("anneal paper's presets".to_owned(), Column::AnnealPaper));
    columns.push(("anneal averaged".to_owned(), Column::AnnealAveraged));
    let columns = columns.into_iter().map(|(name, column)| {
        let value = json!({
            "best_percent": runs.best(column),
            "mean_percent": runs.mean(column, Row::reduction),
            "mean_crossings": runs.mean(column, |row| f64::from(row.crossings)),
            "mean_gap": runs.mean(column, gap),
            "mean_seconds": runs.mean(column, |row| row.seconds),
        });
        (name.replace('`', ""), value)
    });
    json!({
        "layout": cell.layout.name(), "size": cell.size.to_string(), "instances": runs.instances(),
        "mean_bound": runs.mean(Column::Exact, |row| row.bound.unwrap_or_default()),
        "paper": {
            "zigzag": cell.zigzag, "anneal_best_percent": cell.best, "anneal_mean_percent": cell.mean,
            "genetic_best_percent": cell.genetic,
        },
        "ours": columns.collect::<serde_json::Map<String, Value>>(),
    })
}

fn gap(row: &Row) -> f64 {
    f64::from(row.crossings) - row.bound.unwrap_or_default()
}

/// Writes all tables.
pub(super) fn markdown(
    text: &mut String,
    all: &[Runs],
    presets: &[genetic::Preset],
) -> std::fmt::Result {
    let genetic = |runs: &Runs, value: &dyn Fn(&Runs, Column) -> f64| -> String {
        let values = presets.iter().map(|&preset| percent(value(runs, Column::Genetic(preset))));
        values.collect::<Vec<_>>().join(" / ")
    };
    let names = presets.iter().map(|preset| format!("`{preset}`")).collect::<Vec<_>>().join(" / ");
    let best = |runs: &Runs, column| runs.best(column);

    writeln!(
        text,
        "\n## Table 1: best reduction by the genetic algorithm, in %: {names} (the paper)\n"
    )?;
    table(text, all, |runs| format!("{} ({:.1})", genetic(runs, &best), runs.cell.genetic))?;
    writeln!(
        text,
        "\n## Table 3: best reduction by annealing, in %: the paper's presets / `fast` (the paper)\n"
    )?;
    table(text, all, |runs| {
        let [ours, fast] =
            [Column::AnnealPaper, Column::Anneal(Preset::Fast)].map(|column| runs.best(column));
        format!("{} / {} ({:.1})", percent(ours), percent(fast), runs.cell.best)
    })?;
    writeln!(
        text,
        "\n## Table 5: mean reduction by annealing, in %: preset `paper` / mean of `medium`, `paper`, `long` and `extra_long` (the paper)\n"
    )?;
    let mean = |runs: &Runs, column| runs.mean(column, Row::reduction);
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
    })?;
    crossings(text, all, presets)?;
    gains(text, all, presets)?;
    verdicts(text, all, presets)?;
    instances(text, all.iter().map(|runs| (runs.cell, runs.instances())))
}

/// A row for each cell: crossings, bound and gap, and what they cost in time.
fn crossings(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> std::fmt::Result {
    let columns = columns(presets);
    let heads = columns.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(" | ");
    let rule = "---|".repeat(columns.len());

    writeln!(
        text,
        "\n## Mean crossings, mean of the proven bounds, and smallest gaps of annealing, genetic and exact runs\n"
    )?;
    writeln!(text, "| layout | size | {heads} | bound | gaps |\n|---|---|{rule}---|---|")?;
    for runs in all {
        let values = columns.iter().map(|&(_, column)| {
            let crossings = runs.mean(column, |row| f64::from(row.crossings));
            format!("{crossings:.1}")
        });
        let least = |column| runs.column(column).map(gap).fold(f64::NAN, f64::min);
        writeln!(
            text,
            "| {} | {} | {} | {:.1} | {:.0}, {:.0}, {:.0} |",
            runs.cell.layout,
            runs.cell.size,
            values.collect::<Vec<_>>().join(" | "),
            runs.mean(Column::Exact, |row| row.bound.unwrap_or_default()),
            least(Column::AnnealAny),
            least(Column::GeneticAny),
            least(Column::Exact),
        )?;
    }
    writeln!(text, "\n## Mean seconds, one thread each; genetic with its annealing runs\n")?;
    writeln!(text, "| layout | size | {heads} |\n|---|---|{rule}")?;
    for runs in all {
        let seconds = columns
            .iter()
            .map(|&(_, column)| format!("{:.4}", runs.mean(column, |row| row.seconds)));
        let seconds = seconds.collect::<Vec<_>>().join(" | ");
        writeln!(text, "| {} | {} | {seconds} |", runs.cell.layout, runs.cell.size)?;
    }
    Ok(())
}

/// What crossover adds to the best of the annealing runs that it began with.
fn gains(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> std::fmt::Result {
    writeln!(
        text,
        "\n## Crossings that the genetic algorithm saves on the best run of its first population\n"
    )?;
    writeln!(
        text,
        "Mean over the sizes with its confidence interval of 95 %, and the share of the runs that save any.\n"
    )?;
    let heads = presets.iter().map(|preset| format!("`{preset}`")).collect::<Vec<_>>().join(" | ");
    writeln!(text, "| layout | {heads} |\n|---|{}", "---|".repeat(presets.len()))?;
    for layout in Layout::PAPER {
        let cells = presets.iter().map(|&preset| {
            let here = all.iter().filter(|runs| runs.cell.layout == layout);
            let saved =
                |row: &Row| Some(row.genetic.as_ref()?.seeded as f64 - f64::from(row.crossings));
            let saved: Vec<Vec<f64>> = here
                .map(|runs| runs.column(Column::Genetic(preset)).filter_map(saved).collect())
                .collect();
            let runs: Vec<f64> = saved.iter().flatten().copied().collect();
            let some = runs.iter().filter(|&&saved| saved > 0.0).count();
            let share = 100.0 * some as f64 / runs.len() as f64;
            format!("{}, {share:.0} %", Interval::of(&saved))
        });
        writeln!(text, "| {layout} | {} |", cells.collect::<Vec<_>>().join(" | "))?;
    }
    Ok(())
}

/// In how many cells one column is at least as good as another.
fn verdicts(text: &mut String, all: &[Runs], presets: &[genetic::Preset]) -> std::fmt::Result {
    // Figures of the paper have one decimal.
    const ROUNDING: f64 = 0.05;

    let count = |holds: &dyn Fn(&Runs) -> bool| {
        let misses: Vec<String> = all
            .iter()
            .filter(|runs| !holds(runs))
            .map(|runs| format!("{} {}", runs.cell.layout, runs.cell.size))
            .collect();
        let but =
            if misses.is_empty() { String::new() } else { format!(" (not {})", misses.join(", ")) };
        format!("{} of {}{but}", all.len() - misses.len(), all.len())
    };
    writeln!(text, "\n## Cells in which the best reduction is at least as large\n")?;
    let mut line =
        |what: &str, holds: &dyn Fn(&Runs) -> bool| writeln!(text, "- {what}: {}", count(holds));
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
    line("genetic, best preset, as annealing by any preset, `fast` included", &|runs| {
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
fn table(text: &mut String, all: &[Runs], entry: impl Fn(&Runs) -> String) -> std::fmt::Result {
    let here = |cell: &paper::Cell| {
        all.iter().find(|runs| (runs.cell.layout, runs.cell.size) == (cell.layout, cell.size))
    };
    crate::eval::table::table(text, |cell| here(cell).map_or_else(|| "-".to_owned(), &entry))
}
