//! Tables of plans.

use std::fmt::Write;

use super::plans::PartRow;

/// Gains of the paper's agent in percent of the reward (Kim et al. 2026), by part.
const PAPER: [(&str, f64); 3] = [("rectangular", 20.8), ("U", 25.9), ("pyramid", 5.1)];

/// One table per part.
pub(super) fn text(rows: &[PartRow], max_time: f64) -> anyhow::Result<String> {
    let mut text = String::new();
    writeln!(
        text,
        "Gains over the conventional order, in %, within {:+.1} % of its printing time\n\
         (end: the paper's reward; no travel: the same if travel took no time;\n\
         time: deviation averaged over time; later: without the first layer)",
        100.0 * (max_time - 1.0)
    )?;
    for row in rows {
        let paper = PAPER.iter().find(|(part, _)| *part == row.part);
        let paper = paper.map_or(String::new(), |(_, gain)| format!("; paper's agent: {gain} %"));
        writeln!(
            text,
            "\n{}: {} voxels, {} layers; conventional: reward {:.2} K, {:.0} s, lift {:.3} \
             mm{paper}",
            row.part, row.voxels, row.layers, row.reward, row.print_seconds, row.warpage_mm
        )?;
        writeln!(
            text,
            "{:20} {:>7} {:>10} {:>7} {:>7} {:>8} {:>8} {:>7} {:>9} {:>10}",
            "planner",
            "end",
            "no travel",
            "time",
            "later",
            "print %",
            "lift mm",
            "travels",
            "layers",
            "planning s"
        )?;
        for plan in &row.plans {
            writeln!(
                text,
                "{:20} {:>7.1} {:>10.1} {:>7.1} {:>7.1} {:>+8.2} {:>8.3} {:>7} {:>9} {:>10.2}",
                plan.planner,
                plan.reward_gain_percent,
                plan.no_travel_gain_percent,
                plan.time_averaged_gain_percent,
                plan.later_time_averaged_gain_percent,
                100.0 * (plan.print_seconds / row.print_seconds - 1.0),
                plan.warpage_mm,
                plan.travel_moves,
                plan.deposited_layers,
                plan.planning_seconds
            )?;
        }
    }
    Ok(text)
}
