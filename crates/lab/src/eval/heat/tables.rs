//! Tables of plans.

use std::fmt::Write;

use beadwork_console::machine;
use beadwork_console::text::count;

use super::fields::{MOMENTS_S, PlaneDeviations};
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

/// All tables in Markdown.
pub(super) fn text(rows: &[PartRow], max_time: f64) -> Result<String, std::fmt::Error> {
    let mut text = format!("Machine: {}.\n", machine::line());
    gains(&mut text, rows, max_time)?;
    planes(&mut text, rows)?;
    Ok(text)
}

/// The gains of all plans, one table per part.
fn gains(text: &mut String, rows: &[PartRow], max_time: f64) -> std::fmt::Result {
    writeln!(
        text,
        "Gains over the conventional order, in %, within {:+.1} % of its printing time\n\
         (end: the paper's reward; no travel: the same if travel took no time;\n\
         time: deviation averaged over time; later: without the first layer).",
        100.0 * (max_time - 1.0)
    )?;
    for row in rows {
        let paper = PAPER.iter().find(|paper| paper.part == row.part);
        let paper = paper.map_or(String::new(), |paper| {
            format!("; the paper's agent gained {} %", paper.gain_percent)
        });
        writeln!(
            text,
            "\n**{}**: {} voxels of {} mm, {} layers of up to {}; conventional: reward {:.2} K, \
             {:.0} s, lift {:.3} mm{paper}; expected limit of *no travel*: {:.1} % for orders of \
             whole lines, {:.1} % for any order.\n",
            row.part,
            row.voxels,
            row.voxel_mm.map(|mm| mm.to_string()).join(" x "),
            row.layers,
            count(row.max_components.into(), "component"),
            row.reward,
            row.print_seconds,
            row.warpage_mm,
            row.whole_lines_bound_percent,
            row.bound_percent
        )?;
        *text += "| planner | end | no travel | time | later | printing time % | lift mm \
                  | travel moves | layers solved | planning s |\n\
                  |---|---|---|---|---|---|---|---|---|---|\n";
        for plan in &row.plans {
            writeln!(
                text,
                "| {} | {:.1} | {:.1} | {:.1} | {:.1} | {:+.2} | {:.3} | {} | {} | {:.1} |",
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
    Ok(())
}

/// The thermal deviations on planes, one table for all parts.
fn planes(text: &mut String, rows: &[PartRow]) -> std::fmt::Result {
    write!(
        text,
        "\nMaximum thermal deviation on planes, K, {} after the end\n\
         (planes along x and y are vertical; centre: the plane through the centre; mean: over all \
         parallel planes).\n\n\
         | part | planner | paper | along x: centre | mean | along y: centre | mean \
         | layers: centre | mean |\n\
         |---|---|---|---|---|---|---|---|---|\n",
        MOMENTS_S.map(|seconds| format!("{seconds} s")).join(" / ")
    )?;
    for row in rows {
        let paper = PAPER.iter().find(|paper| paper.part == row.part);
        for (planner, fields) in row.fields() {
            let paper = match (paper, planner) {
                (Some(paper), "conventional") => paper.deviations_k[0].to_string(),
                _ => String::new(),
            };
            write!(text, "| {} | {planner} | {paper} |", row.part)?;
            let columns: [fn(&PlaneDeviations) -> f64; 6] = [
                |planes| planes.along_x.central_k,
                |planes| planes.along_x.mean_k,
                |planes| planes.along_y.central_k,
                |planes| planes.along_y.mean_k,
                |planes| planes.layers.central_k,
                |planes| planes.layers.mean_k,
            ];
            for column in columns {
                let moments: Vec<String> =
                    fields.planes.iter().map(|planes| format!("{:.2}", column(planes))).collect();
                write!(text, " {} |", moments.join(" / "))?;
            }
            writeln!(text)?;
        }
        if let Some(paper) = paper {
            writeln!(text, "| {} | paper's agent | {} |||||||", row.part, paper.deviations_k[1])?;
        }
    }
    Ok(())
}
