//! How often the exact search proves the fewest crossings, and how fast.

mod cases;
mod growth;
mod runs;

use std::fmt::Write;

use beadwork_console::{machine, output, progress};
use serde_json::json;

use self::cases::cases;
use self::runs::{Runs, Totals, mean_crossings};
use crate::eval::zones::args::ZonesArgs;

/// Solves all instances one after the other, and prints the tables.
pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(100);
    let mut cases = cases(seeds);
    if args.smoke {
        cases.retain(|case| case.width.max(case.height) <= 100);
    }
    let bar = progress::bar(cases.iter().map(|case| case.seeds).sum(), "eval zones");
    let mut all = Vec::new();
    for case in cases {
        let mut runs = Runs::new(case);
        for seed in 0..runs.case.seeds {
            runs.add(seed)?;
            bar.inc(1);
        }
        all.push(runs);
    }
    let growth = growth::measure(&bar, args.smoke)?;
    bar.finish_and_clear();
    if let Some(file) = &args.plot {
        output::file(file, &growth.svg()?)?;
    }
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(),
            "seeds": seeds,
            "cases": all.iter().map(Runs::summary).collect::<Vec<_>>(),
            "growth": growth.json(),
            "rows": all.iter().flat_map(|runs| &runs.exact).collect::<Vec<_>>(),
        }));
    }
    let mut text = format!("Machine: {}. Seeds from 0.\n", machine::line());
    table(&mut text, &all)?;
    growth.table(&mut text)?;
    output::text(&text)
}

/// A table for each group, with a row for each of its cases.
fn table(text: &mut String, all: &[Runs]) -> std::fmt::Result {
    let mut group = "";
    for runs in all {
        let case = &runs.case;
        if case.group != group {
            group = case.group;
            writeln!(text, "\n## {}{}\n", group[..1].to_uppercase(), &group[1..])?;
            writeln!(
                text,
                "| case | size | proven | worst gap | pieces = bound | p50 / p95 / max, ms \
                 | crossings | first ten: exact | fast | anneal | zigzag |\n\
                 |---|---|---|---|---|---|---|---|---|---|---|"
            )?;
        }
        let Totals { optimal, max_gap, pieces_optimal, ms: [p50, p95, max], .. } =
            Totals::of(&runs.exact);
        let count = runs.exact.len();
        writeln!(
            text,
            "| {} | {}x{} | {optimal} of {count} | {max_gap} | {pieces_optimal} of {count} \
             | {p50:.2} / {p95:.2} / {max:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |",
            case.name,
            case.width,
            case.height,
            mean_crossings(&runs.exact),
            mean_crossings(runs.exact_compared()),
            mean_crossings(&runs.fast),
            mean_crossings(&runs.anneal),
            mean_crossings(&runs.zigzag),
        )?;
    }
    Ok(())
}
