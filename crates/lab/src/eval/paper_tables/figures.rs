//! Pictures of the tables: how populations converge, and the heat heat_maps of the paper's Figure 4.

use beadwork_console::chart::{
    self, Axis, BLUE, Chart, GREEN, GREY, HeatMap, LineStyle, ORANGE, PURPLE, Series, charts,
};
use beadwork_console::search::{Generation, Row};
use beadwork_grid::Layout;
use beadwork_search::anneal::Preset;
use beadwork_search::genetic;

use super::{Column, Runs};
use crate::eval::statistics::mean;
use crate::paper;

/// For each cell the reduction over the generations, mean of the seeds.
pub(super) fn convergence(all: &[Runs], presets: &[genetic::Preset]) -> anyhow::Result<String> {
    let chart = |runs: &Runs| {
        let mut series = Vec::new();
        for (&preset, colour) in presets.iter().zip([BLUE, GREEN, PURPLE]) {
            let column = Column::Genetic(preset);
            let line = |name: String, style, value: &dyn Fn(&Generation) -> f64| {
                let points = over_generations(runs, column, value);
                Series { name, colour, style, points }
            };
            series.push(line(format!("genetic {preset}, best"), LineStyle::Plain, &|it| {
                it.best as f64
            }));
            series.push(line(format!("genetic {preset}, mean"), LineStyle::Thin, &|it| it.mean));
        }
        let last = series
            .iter()
            .flat_map(|series| &series.points)
            .fold(1.0, |last, point| point.0.max(last));
        for (name, column, colour) in
            [("anneal fast", Column::Anneal(Preset::Fast), ORANGE), ("exact", Column::Exact, GREY)]
        {
            let value = runs.mean(column, Row::reduction);
            let points = vec![(1.0, value), (last, value)];
            series.push(Series { name: name.to_owned(), colour, style: LineStyle::Plain, points });
        }
        Chart {
            title: format!("{} {}", runs.cell.layout, runs.cell.size),
            x: Axis { label: "populations", logarithmic: true, shown: &[1.0] },
            y: Axis { label: "reduction, %", logarithmic: false, shown: &[0.0, 100.0] },
            series,
        }
    };
    charts(&all.iter().map(chart).collect::<Vec<_>>(), paper::SIZES.len(), (250, 220))
}

/// Mean reduction at each kept generation; a run that stopped at its bound stays there.
fn over_generations(
    runs: &Runs,
    column: Column,
    value: &dyn Fn(&Generation) -> f64,
) -> Vec<(f64, f64)> {
    let mut numbers: Vec<u32> = runs
        .column(column)
        .filter_map(|row| row.genetic.as_ref())
        .flat_map(|genetic| genetic.history.iter().map(|it| it.number))
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    let at = |number: u32| {
        mean(runs.column(column).filter_map(|row| {
            let history = &row.genetic.as_ref()?.history;
            let then = history.iter().take_while(|it| it.number <= number).last()?;
            Some(100.0 * (1.0 - value(then) / f64::from(row.initial.max(1))))
        }))
    };
    numbers.iter().map(|&number| (f64::from(number) + 1.0, at(number))).collect()
}

/// Best reduction over layouts and sizes: the paper's methods and ours.
pub(super) fn heat_maps(all: &[Runs], presets: &[genetic::Preset]) -> anyhow::Result<String> {
    let map = |title: String, value: &dyn Fn(&Runs) -> f64| {
        let of = |cell: paper::Cell| {
            let here =
                |runs: &&Runs| (runs.cell.layout, runs.cell.size) == (cell.layout, cell.size);
            all.iter().find(here).map_or(f64::NAN, value)
        };
        HeatMap {
            title,
            rows: Layout::PAPER.iter().map(ToString::to_string).collect(),
            columns: paper::SIZES.iter().map(ToString::to_string).collect(),
            values: paper::cells().map(of).collect(),
        }
    };
    let best = |column: Column| move |runs: &Runs| runs.best(column);
    let mut all_maps = vec![
        map("paper: annealing, best reduction in %".to_owned(), &|runs| runs.cell.best),
        map("paper: genetic".to_owned(), &|runs| runs.cell.genetic),
        map("ours: annealing, the paper's presets".to_owned(), &best(Column::AnnealPaper)),
        map("ours: annealing, fast".to_owned(), &best(Column::Anneal(Preset::Fast))),
    ];
    for &preset in presets {
        all_maps.push(map(format!("ours: genetic, {preset}"), &best(Column::Genetic(preset))));
    }
    all_maps.push(map("ours: exact".to_owned(), &best(Column::Exact)));
    chart::heat_maps(&all_maps, 2, 100.0)
}
