//! Figures of the tables: convergence of the populations, and heat maps like the paper's Figure 4.

use beadwork_console::chart::{
    self, Axis, BLUE, Chart, GREEN, GREY, HeatMap, LineStyle, ORANGE, PURPLE, Series, charts,
};
use beadwork_console::search::{Generation, Row};
use beadwork_grid::Layout;
use beadwork_search::anneal::Preset;
use beadwork_search::genetic;

use super::runs::{Column, Runs};
use crate::paper;
use crate::statistics::mean;

/// A chart for each cell: mean reduction over the seeds, in %, against the number of populations.
pub(super) fn convergence(all: &[Runs], presets: &[genetic::Preset]) -> anyhow::Result<String> {
    let panels: Vec<Chart> = all.iter().map(|runs| convergence_of_cell(runs, presets)).collect();
    charts(&panels, paper::SIZES.len(), (250, 220))
}

fn convergence_of_cell(runs: &Runs, presets: &[genetic::Preset]) -> Chart<'static> {
    let mut series = Vec::new();
    for (&preset, colour) in presets.iter().zip([BLUE, GREEN, PURPLE]) {
        let column = Column::Genetic(preset);
        let mut add = |what, style, cost: &dyn Fn(&Generation) -> f64| {
            let name = format!("genetic {preset}, {what}");
            let points = reduction_over_generations(runs, column, cost);
            series.push(Series { name, colour, style, points });
        };
        add("best", LineStyle::Plain, &|generation| generation.best as f64);
        add("mean", LineStyle::Thin, &|generation| generation.mean);
    }
    let last =
        series.iter().flat_map(|series| &series.points).fold(1.0, |last, point| point.0.max(last));
    for (name, column, colour) in
        [("anneal fast", Column::Anneal(Preset::Fast), ORANGE), ("exact", Column::Exact, GREY)]
    {
        let reduction = runs.mean(column, Row::reduction);
        let points = vec![(1.0, reduction), (last, reduction)];
        series.push(Series { name: name.to_owned(), colour, style: LineStyle::Plain, points });
    }
    Chart {
        title: format!("{} {}", runs.cell.layout, runs.cell.size),
        x: Axis { label: "populations", logarithmic: true, shown: &[1.0] },
        y: Axis { label: "reduction, %", logarithmic: false, shown: &[0.0, 100.0] },
        series,
    }
}

/// Points of the mean reduction, in %, at each stored generation; a run that stopped at its bound
/// keeps its last value.
fn reduction_over_generations(
    runs: &Runs,
    column: Column,
    cost: &dyn Fn(&Generation) -> f64,
) -> Vec<(f64, f64)> {
    let mut numbers: Vec<u32> = runs
        .column(column)
        .filter_map(|row| row.genetic.as_ref())
        .flat_map(|genetic| genetic.history.iter().map(|generation| generation.number))
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    let mean_reduction = |number: u32| {
        mean(runs.column(column).filter_map(|row| {
            let history = &row.genetic.as_ref()?.history;
            let last = history.iter().take_while(|it| it.number <= number).last()?;
            Some(100.0 * (1.0 - cost(last) / f64::from(row.initial.max(1))))
        }))
    };
    numbers.iter().map(|&number| (f64::from(number) + 1.0, mean_reduction(number))).collect()
}

/// Heat maps of the best reduction over layouts and sizes, for the paper's methods and ours.
pub(super) fn heat_maps(all: &[Runs], presets: &[genetic::Preset]) -> anyhow::Result<String> {
    let map = |title: String, value: &dyn Fn(&Runs) -> f64| {
        let of_cell = |cell: paper::Cell| {
            all.iter().find(|runs| runs.cell.is_same(&cell)).map_or(f64::NAN, value)
        };
        HeatMap {
            title,
            rows: Layout::PAPER.iter().map(ToString::to_string).collect(),
            columns: paper::SIZES.iter().map(ToString::to_string).collect(),
            values: paper::cells().map(of_cell).collect(),
        }
    };
    let best = |column: Column| move |runs: &Runs| runs.best(column);
    let mut maps = vec![
        map("paper: annealing, best reduction in %".to_owned(), &|runs| runs.cell.best),
        map("paper: genetic".to_owned(), &|runs| runs.cell.genetic),
        map("ours: annealing, the paper's presets".to_owned(), &best(Column::AnnealPaper)),
        map("ours: annealing, fast".to_owned(), &best(Column::Anneal(Preset::Fast))),
    ];
    for &preset in presets {
        maps.push(map(format!("ours: genetic, {preset}"), &best(Column::Genetic(preset))));
    }
    maps.push(map("ours: exact".to_owned(), &best(Column::Exact)));
    chart::heat_maps(&maps, 2, 100.0)
}
