//! Charts of a run of the genetic algorithm.

use beadwork_console::chart::{Axis, BLUE, Chart, GREEN, GREY, LineStyle, ORANGE, Series, charts};
use beadwork_console::search::{GeneticRow, Row};

/// Crossings and diversity over the generations of one run.
pub(crate) fn chart(row: &Row, genetic: &GeneticRow) -> anyhow::Result<String> {
    let over = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let history = genetic.history.iter().enumerate();
        history.map(|(index, generation)| (f64::from(generation.number), value(index))).collect()
    };
    let line = |name: &str, colour, style, value: &dyn Fn(usize) -> f64| Series {
        name: name.to_owned(),
        colour,
        style,
        points: over(value),
    };
    let axis = |label| Axis { label, logarithmic: false, shown: &[0.0] };
    let mut series = vec![
        line("best", BLUE, LineStyle::Plain, &|index| genetic.history[index].best as f64),
        line("mean", ORANGE, LineStyle::Thin, &|index| genetic.history[index].mean),
    ];
    if let Some(bound) = row.bound {
        series.push(line("bound", GREY, LineStyle::Thin, &|_| bound));
    }
    let diversity =
        line("diversity", GREEN, LineStyle::Plain, &|index| genetic.history[index].diversity);
    let preset = row.preset.as_deref().unwrap_or_default();
    let crossings = Chart {
        title: format!(
            "{} {}x{}, {preset}: {} at the start",
            row.layout, row.width, row.height, row.initial
        ),
        x: axis("generation"),
        y: axis("crossings"),
        series,
    };
    let diversity = Chart {
        title: "share of genes unlike the best".to_owned(),
        x: axis("generation"),
        y: axis("diversity"),
        series: vec![diversity],
    };
    charts(&[crossings, diversity], 2, (420, 300))
}
