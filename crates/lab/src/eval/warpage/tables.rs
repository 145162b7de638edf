//! The tables of `eval warpage`.

use std::fmt::{Result, Write};

use beadwork_console::machine;

use super::measured::{HeightRow, MeasuredTable};
use super::orders::{OBJECTIVES, OrderRows};
use super::published::Measured;

/// All tables in Markdown.
pub(super) fn text(
    measured: Option<&MeasuredTable>,
    heights: Option<&[HeightRow]>,
    orders: Option<&[OrderRows]>,
) -> std::result::Result<String, std::fmt::Error> {
    let mut text = format!("Machine: {}.\n", machine::line());
    measured.map_or(Ok(()), |table| measurements(&mut text, table))?;
    heights.map_or(Ok(()), |rows| of_heights(&mut text, rows))?;
    orders.map_or(Ok(()), |parts| of_orders(&mut text, parts))?;
    Ok(text)
}

fn measurements(text: &mut String, table: &MeasuredTable) -> Result {
    for publication in &table.publications {
        writeln!(text, "\n{} ({}).\n", publication.source, publication.note)?;
        *text += "| print | measured | estimated lift, mm | curvature along x, 1/m | along y |\n\
                  |---|---|---|---|---|\n";
        for row in &publication.cases {
            let measured = match row.measured {
                Measured::Mm(mm) => format!("{mm:.2} mm"),
                Measured::Rank(rank) => format!("rank {rank}"),
            };
            let [x, y] = row.curvatures_1_m;
            writeln!(text, "| {} | {measured} | {:.3} | {x:.2} | {y:.2} |", row.case, row.lift_mm)?;
        }
        writeln!(
            text,
            "\nRank correlation {:.2}; {} of {} pairs as measured.",
            publication.rank_correlation, publication.pairs.agree, publication.pairs.all
        )?;
    }
    writeln!(
        text,
        "\nIn all publications, {} of {} pairs are ordered as measured.",
        table.pairs.agree, table.pairs.all
    )
}

fn of_heights(text: &mut String, rows: &[HeightRow]) -> Result {
    *text += "\nBlocks of 60 x 20 mm in the conventional order:\n\n\
              | layers | height, mm | estimated lift, mm | mean curvature, 1/m |\n\
              |---|---|---|---|\n";
    for row in rows {
        let height_mm = f64::from(row.layers) * 0.25;
        writeln!(
            text,
            "| {} | {height_mm} | {:.3} | {:.2} |",
            row.layers, row.lift_mm, row.curvature_1_m
        )?;
    }
    Ok(())
}

fn of_orders(text: &mut String, parts: &[OrderRows]) -> Result {
    *text += "\nRank correlation of objectives with the estimated lift: 1 if the better plan \
              always lifts less.\n\n| part | among | orders |";
    OBJECTIVES.iter().try_for_each(|objective| write!(text, " {objective} |"))?;
    *text += "\n|---|---|---|---|---|---|---|\n";
    for part in parts {
        for row in &part.correlations {
            write!(text, "| {} | {} | {} |", part.part, row.among, row.count)?;
            row.rank_correlations.iter().try_for_each(|rho| write!(text, " {rho:.2} |"))?;
            *text += "\n";
        }
    }
    for part in parts {
        writeln!(text, "\nOrders of the {} part by their lift:\n", part.part)?;
        *text += "| order |";
        OBJECTIVES.iter().try_for_each(|objective| write!(text, " {objective} |"))?;
        *text += " lift, mm | printing time, s |\n|---|---|---|---|---|---|---|\n";
        let mut rows: Vec<_> = part.rows.iter().collect();
        rows.sort_by(|a, b| a.lift_mm.total_cmp(&b.lift_mm));
        for row in rows {
            write!(text, "| {} |", row.order)?;
            row.costs.iter().try_for_each(|cost| write!(text, " {cost:.2} |"))?;
            writeln!(text, " {:.3} | {:.0} |", row.lift_mm, row.print_seconds)?;
        }
    }
    Ok(())
}
