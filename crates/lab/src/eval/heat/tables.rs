//! Tables of plans.

use std::fmt::Write;

use beadwork_console::text::count;

use super::fields::Deviations;
use super::plans::PartRow;

/// Figures of Kim et al. 2026 for a part.
struct Paper {
    part: &'static str,
    /// Gain of the agent in percent of the reward.
    gain_percent: f64,
    /// Maximum thermal deviations on a section, K (figure 10): conventional, and the agent's.
    deviations_k: [f64; 2],
}

const PAPER: [Paper; 3] = [
    Paper { part: "rectangular", gain_percent: 20.8, deviations_k: [7.27, 3.97] },
    Paper { part: "U", gain_percent: 25.9, deviations_k: [8.79, 3.03] },
    Paper { part: "pyramid", gain_percent: 5.1, deviations_k: [4.87, 4.06] },
];

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
        let paper = PAPER.iter().find(|paper| paper.part == row.part);
        let paper_gain = paper
            .map_or(String::new(), |paper| format!("; paper's agent: {} %", paper.gain_percent));
        writeln!(
            text,
            "\n{}: {} voxels of {} mm, {} layers of up to {}; conventional: reward {:.2} K, \
             {:.0} s, lift {:.3} mm{paper_gain}",
            row.part,
            row.voxels,
            row.voxel_mm.map(|mm| mm.to_string()).join(" x "),
            row.layers,
            count(row.max_components.into(), "component"),
            row.reward,
            row.print_seconds,
            row.warpage_mm
        )?;
        writeln!(
            text,
            "expected limit of 'no travel': {:.1} for orders of whole lines, {:.1} for any order",
            row.whole_lines_bound_percent, row.bound_percent
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
    text += &planes(rows)?;
    Ok(text)
}

/// The thermal deviations on planes.
fn planes(rows: &[PartRow]) -> Result<String, std::fmt::Error> {
    let mut text = String::from(
        "\nMaximum thermal deviation on planes after the end, K\n\
         (along x and y: vertical planes; centre: on the plane through the centre; mean: over all \
         parallel planes)\n",
    );
    for row in rows {
        let paper = PAPER.iter().find(|paper| paper.part == row.part);
        let paper = paper.map_or(String::new(), |Paper { deviations_k: [from, to], .. }| {
            format!("; paper: conventional {from} K, agent {to} K")
        });
        writeln!(
            text,
            "\n{}{paper}\n{:20} {:>7} {:>15} {:>7} {:>15} {:>7} {:>15} {:>7}",
            row.part,
            "planner",
            "after s",
            "along x: centre",
            "mean",
            "along y: centre",
            "mean",
            "layers: centre",
            "mean"
        )?;
        for (planner, fields) in row.fields() {
            for planes in &fields.planes {
                write!(text, "{planner:20} {:>7}", planes.after_s)?;
                for Deviations { central_k, mean_k } in
                    [planes.along_x, planes.along_y, planes.layers]
                {
                    write!(text, " {central_k:>15.2} {mean_k:>7.2}")?;
                }
                writeln!(text)?;
            }
        }
    }
    Ok(text)
}
