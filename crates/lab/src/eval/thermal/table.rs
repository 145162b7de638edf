//! The tables of `eval thermal`.

use std::fmt::Write;

use beadwork_console::machine;
use beadwork_part::Pattern;

use super::{PartRow, Printed};

/// What Kim et al. 2026 give for a part: rewards of the conventional pattern and of the best of
/// three runs of PPO, and the largest thermal deviations on a section of both, K.
struct Paper {
    part: &'static str,
    rewards: [f64; 2],
    deviations_k: [f64; 2],
}

const PAPER: [Paper; 3] = [
    Paper { part: "rectangular", rewards: [-80.49, -63.72], deviations_k: [7.27, 3.97] },
    Paper { part: "U", rewards: [-97.39, -72.18], deviations_k: [8.79, 3.03] },
    Paper { part: "pyramid", rewards: [-628.76, -596.99], deviations_k: [4.87, 4.06] },
];

/// How much less of a cost is left, in percent of the first.
fn gain(first: f64, second: f64) -> f64 {
    100.0 * (first - second) / first
}

pub(super) fn text(rows: &[PartRow]) -> anyhow::Result<String> {
    let mut text = format!("Machine: {}. ABS at the paper's settings.\n\n", machine::line());
    text += "| part | voxels | layers | conventional | best pattern in all layers | gain | greedy, layer by layer | gain | paper: conventional | PPO | gain | s |\n";
    text += "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for row in rows {
        let (usual, best, greedy) = (row.conventional(), row.best(), &row.greedy);
        let paper = PAPER.iter().find(|paper| paper.part == row.part).map_or_else(
            || "| | |".to_owned(),
            |paper| {
                let [usual, best] = paper.rewards;
                format!("{usual:.2} | {best:.2} | {:.1} %", gain(usual, best))
            },
        );
        writeln!(
            text,
            "| {} | {} | {} | {:.2} | {:.2} ({}) | {:.1} % | {:.2} | {:.1} % | {paper} | {:.1} |",
            row.part,
            row.voxels,
            row.layers,
            usual.reward,
            best.reward,
            best.pattern,
            gain(usual.reward, best.reward),
            greedy.reward,
            gain(usual.reward, greedy.reward),
            row.seconds
        )?;
    }
    text += "\nThe three plans: thermal deviation on the middle section a second after the end, printing time, and the estimated lift of the corners. The estimate rewards warm ground under each bead, not evenness: it need not agree with the reward.\n\n";
    text += "| part | plan | deviation, K | paper's deviation, K | s to print | corner lift, mm |\n|---|---|---|---|---|---|\n";
    for row in rows {
        let paper =
            PAPER.iter().find(|paper| paper.part == row.part).map(|paper| paper.deviations_k);
        let plans = [
            ("conventional", row.conventional()),
            ("best pattern", row.best()),
            ("greedy", &row.greedy),
        ];
        let paper = paper.map_or([String::new(), String::new(), String::new()], |[usual, best]| {
            [format!("{usual:.2}"), String::new(), format!("{best:.2} (PPO)")]
        });
        for (((name, plan), lift_mm), paper) in plans.into_iter().zip(row.lifts_mm).zip(paper) {
            let Printed { deviation_k, print_seconds, .. } = plan;
            writeln!(
                text,
                "| {} | {name} | {deviation_k:.2} | {paper} | {print_seconds:.0} | {lift_mm:.3} |",
                row.part
            )?;
        }
    }
    text += "\nRewards of all patterns, each in all layers:\n\n| pattern |";
    rows.iter().try_for_each(|row| write!(text, " {} |", row.part))?;
    writeln!(text, "\n|---|{}", "---|".repeat(rows.len()))?;
    for pattern in Pattern::ALL {
        write!(text, "| {pattern} |")?;
        for row in rows {
            write!(text, " {:.2} |", row.patterns[pattern.number()].reward)?;
        }
        writeln!(text)?;
    }
    Ok(text)
}
