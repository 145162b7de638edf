//! Accuracy of the network on moves of instances on which it was not trained.

use std::fmt::Write;

use anyhow::ensure;
use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_dataset::Dataset;
use beadwork_learn::Device;
use beadwork_learn::fusion::baseline::Baseline;
use beadwork_learn::fusion::evaluate::{Evaluation, Hits, evaluate};
use beadwork_learn::fusion::model::Model;
use beadwork_learn::fusion::samples::{Batches, Split};
use serde_json::{Value, json};

/// Evaluates the network on `per_trajectory` moves of each trajectory of the test split.
pub(super) fn on_test_split(
    dataset: &Dataset,
    per_trajectory: usize,
    model: &Model,
    device: Device,
) -> anyhow::Result<Evaluation> {
    let settings = model.config.held_out(per_trajectory);
    let control = control::cancellable(Threads::One)?;
    let mut examples = Vec::new();
    for batch in Batches::new(dataset, Split::Test, &settings, 0) {
        control.check()?;
        examples.push(batch?);
    }
    ensure!(!examples.is_empty(), "dataset: test split has no instances");
    let evaluation = control::with_bar("batches", Threads::One, |control| {
        evaluate(&model.network, &examples, &model.config, device, control)
    })?;
    Ok(evaluation?)
}

/// The accuracy of each layout as a JSON object.
pub(super) fn json(evaluation: &Evaluation) -> Value {
    let by_layout = evaluation.by_layout.iter();
    let by_layout =
        by_layout.map(|(layout, (hits, baseline))| (layout.clone(), percentages(hits, baseline)));
    Value::Object(by_layout.collect())
}

/// Percentages of the examples that the network, chance and greedy choice predict correctly.
fn percentages(hits: &Hits, baseline: &Baseline) -> Value {
    let count = hits.count.max(1) as f64;
    let percent = |sum: f64| 100.0 * sum / count;
    json!({
        "examples": hits.count,
        "top_1": percent(hits.top_1 as f64),
        "top_5": percent(hits.top_5 as f64),
        "action": percent(hits.action as f64),
        "chance_1": percent(baseline.chance_top_1),
        "chance_5": percent(baseline.chance_top_5),
        "chance_action": percent(baseline.chance_action),
        "greedy_1": percent(baseline.greedy_top_1),
        "greedy_5": percent(baseline.greedy_top_5),
    })
}

/// JSON keys and headings of the columns.
const COLUMNS: [(&str, &str); 8] = [
    ("top_1", "first"),
    ("greedy_1", "first: greedy"),
    ("chance_1", "first: chance"),
    ("top_5", "among five"),
    ("greedy_5", "among five: greedy"),
    ("chance_5", "among five: chance"),
    ("action", "action"),
    ("chance_action", "action: chance"),
];

/// Writes a table with a row for each layout.
pub(super) fn table(text: &mut String, evaluation: &Evaluation) -> std::fmt::Result {
    let headings = COLUMNS.map(|(_, heading)| heading).join(" | ");
    writeln!(
        text,
        "\nRecorded moves of the test split that the network, greedy choice and chance predict, \
         in %:\n\n\
         | layout | examples | {headings} |\n\
         |---|---|{}",
        "---|".repeat(COLUMNS.len())
    )?;
    for (layout, (hits, baseline)) in &evaluation.by_layout {
        let percentages = percentages(hits, baseline);
        let entries =
            COLUMNS.map(|(key, _)| format!("{:.1}", percentages[key].as_f64().unwrap_or(0.0)));
        writeln!(text, "| {layout} | {} | {} |", hits.count, entries.join(" | "))?;
    }
    Ok(())
}
