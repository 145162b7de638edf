//! The tables of `eval thermal`.

use std::fmt::{Result, Write};

use beadwork_console::machine;
use beadwork_part::Pattern;

use super::part_row::{PartRow, SimulatedPrint};

/// Figures of Kim et al. 2026 for a part, each for the conventional pattern and for the best of
/// three runs of PPO.
struct Paper {
    part: &'static str,
    rewards: [f64; 2],
    /// Maximum thermal deviations on a section, K.
    deviations_k: [f64; 2],
}

const PAPER: [Paper; 3] = [
    Paper { part: "rectangular", rewards: [-80.49, -63.72], deviations_k: [7.27, 3.97] },
    Paper { part: "U", rewards: [-97.39, -72.18], deviations_k: [8.79, 3.03] },
    Paper { part: "pyramid", rewards: [-628.76, -596.99], deviations_k: [4.87, 4.06] },
];

impl Paper {
    fn of(part: &str) -> Option<&'static Self> {
        PAPER.iter().find(|paper| paper.part == part)
    }
}

/// Decrease of a cost (or of minus a reward), in percent of the first.
fn gain(first: f64, second: f64) -> f64 {
    100.0 * (first - second) / first
}

/// All tables in Markdown.
pub(super) fn text(rows: &[PartRow]) -> std::result::Result<String, std::fmt::Error> {
    let mut text = format!("Machine: {}. ABS with the paper's settings.\n\n", machine::line());
    rewards(&mut text, rows)?;
    plans(&mut text, rows)?;
    patterns(&mut text, rows)?;
    Ok(text)
}

fn rewards(text: &mut String, rows: &[PartRow]) -> Result {
    *text += "| part | voxels | layers | conventional | best pattern in all layers | gain \
              | greedy, layer by layer | gain | paper: conventional | PPO | gain | s |\n\
              |---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for row in rows {
        let (conventional, best, greedy) = (row.conventional(), row.best(), &row.greedy);
        let paper = Paper::of(row.part).map_or_else(
            || "| |".to_owned(),
            |paper| {
                let [conventional, ppo] = paper.rewards;
                format!("{conventional:.2} | {ppo:.2} | {:.1} %", gain(conventional, ppo))
            },
        );
        writeln!(
            text,
            "| {} | {} | {} | {:.2} | {:.2} ({}) | {:.1} % | {:.2} | {:.1} % | {paper} | {:.1} |",
            row.part,
            row.voxels,
            row.layers,
            conventional.reward,
            best.reward,
            best.pattern,
            gain(conventional.reward, best.reward),
            greedy.reward,
            gain(conventional.reward, greedy.reward),
            row.seconds
        )?;
    }
    Ok(())
}

fn plans(text: &mut String, rows: &[PartRow]) -> Result {
    *text += "\nThe three plans: maximum thermal deviation on the central section one second \
              after the end, printing time, and estimated lift of the corners. The estimate \
              depends on the direction of lines more than on temperatures, so it may rank \
              plans differently from the reward.\n\n\
              | part | plan | deviation, K | paper's deviation, K | printing time, s \
              | corner lift, mm |\n\
              |---|---|---|---|---|---|\n";
    for row in rows {
        let plans = [
            ("conventional", row.conventional()),
            ("best pattern", row.best()),
            ("greedy", &row.greedy),
        ];
        let paper = Paper::of(row.part).map_or_else(Default::default, |paper| {
            let [conventional, ppo] = paper.deviations_k;
            [format!("{conventional:.2}"), String::new(), format!("{ppo:.2} (PPO)")]
        });
        for (((name, plan), lift_mm), paper) in plans.into_iter().zip(row.lifts_mm).zip(paper) {
            let SimulatedPrint { deviation_k, print_seconds, .. } = plan;
            writeln!(
                text,
                "| {} | {name} | {deviation_k:.2} | {paper} | {print_seconds:.0} | {lift_mm:.3} |",
                row.part
            )?;
        }
    }
    Ok(())
}

fn patterns(text: &mut String, rows: &[PartRow]) -> Result {
    *text += "\nRewards of all patterns, each in all layers:\n\n| pattern |";
    rows.iter().try_for_each(|row| write!(text, " {} |", row.part))?;
    writeln!(text, "\n|---|{}", "---|".repeat(rows.len()))?;
    for pattern in Pattern::ALL {
        write!(text, "| {pattern} |")?;
        for row in rows {
            write!(text, " {:.2} |", row.patterns[pattern.number()].reward)?;
        }
        writeln!(text)?;
    }
    Ok(())
}
