//! Flags that set where a path starts and ends, and what its crossings cost.

use std::fs;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context, bail};
use beadwork_grid::Region;
use beadwork_search::CostMatrix;
use beadwork_search::exact::{Side, Terminal};

/// Value of `--start-at` and `--end-at`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TerminalName {
    Any,
    Cell { x: u32, y: u32 },
    Side(Side),
}

impl FromStr for TerminalName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = match text {
            "any" => return Ok(Self::Any),
            "left" => Side::Left,
            "top" => Side::Top,
            "right" => Side::Right,
            "bottom" => Side::Bottom,
            _ => {
                let cell = text
                    .split_once(',')
                    .and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)));
                return cell.map(|(x, y)| Self::Cell { x, y }).ok_or_else(|| {
                    "expected a cell X,Y, left, top, right, bottom or any".to_owned()
                });
            }
        };
        Ok(Self::Side(side))
    }
}

impl TerminalName {
    /// The terminal that the name stands for in a region.
    pub(crate) fn terminal(self, region: &Region) -> anyhow::Result<Terminal> {
        Ok(match self {
            Self::Any => Terminal::Any,
            Self::Side(side) => Terminal::Side(side),
            Self::Cell { x, y } => {
                if x >= region.width()
                    || y >= region.height()
                    || !region.contains(region.cell(x, y))
                {
                    bail!("cell {x},{y} lies outside of the region");
                }
                Terminal::Cell(region.cell(x, y))
            }
        })
    }
}

/// Reads the cost matrix of crossings: the row is the zone before the crossing, the column the zone
/// after it.
/// Numbers are separated by commas or blanks; empty lines are ignored.
pub(crate) fn read_costs(path: &PathBuf) -> anyhow::Result<CostMatrix> {
    let in_file = || format!("cannot read costs from '{}'", path.display());
    let text = fs::read_to_string(path).with_context(in_file)?;
    let rows: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    let mut costs = Vec::new();
    for (number, row) in rows.iter().enumerate() {
        let words =
            row.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
        for word in words {
            let cost = word.parse::<f64>();
            costs.push(
                cost.with_context(|| format!("'{word}' in row {}", number + 1))
                    .with_context(in_file)?,
            );
        }
        let expected = (number + 1) * rows.len();
        if costs.len() != expected {
            let got = costs.len() + rows.len() - expected;
            return Err(anyhow::anyhow!(
                "row {} has {got} numbers, but there are {} rows",
                number + 1,
                rows.len()
            ))
            .with_context(in_file);
        }
    }
    let rows: Vec<Vec<f64>> = costs.chunks(rows.len().max(1)).map(<[f64]>::to_vec).collect();
    CostMatrix::new(&rows).with_context(in_file)
}
