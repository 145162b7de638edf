//! What a change of tools costs.

use thiserror::Error;

/// The cost of a change for each ordered pair of tools, in any one unit: the volume to purge in
/// mm³, say, or seconds.
///
/// From b to a need not cost what from a to b does, and a detour over a third tool may be cheaper
/// than the direct change.
/// Tools are numbered from 0. Invariant: one cost for each ordered pair, staying with a tool costs
/// nothing, and there are at most [`ToolCosts::MAX_TOOLS`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ToolCosts {
    tools: usize,
    costs: Vec<u32>,
}

/// Why [`ToolCosts`] could not be made.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ToolCostsError {
    /// A row has not one cost for each tool.
    #[error("the row of tool {tool} has {got} costs, not one for each of {expected} tools")]
    NotSquare {
        /// The tool that the row changes from.
        tool: usize,
        /// Number of rows.
        expected: usize,
        /// Costs in this row.
        got: usize,
    },
    /// There are more tools than [`ToolCosts::MAX_TOOLS`].
    #[error("{got} tools are more than {max}", max = ToolCosts::MAX_TOOLS)]
    TooManyTools {
        /// Number of rows.
        got: usize,
    },
    /// Staying with a tool has a cost.
    #[error("staying with tool {tool} costs {cost}, not 0")]
    Staying {
        /// The tool.
        tool: usize,
        /// Its cost.
        cost: u32,
    },
}

impl ToolCosts {
    /// The most tools of a part.
    pub const MAX_TOOLS: usize = 255;

    /// Each change costs 1: the cost of a plan is the number of its changes.
    pub fn uniform(tools: u8) -> Self {
        let tools = usize::from(tools);
        let costs =
            (0..tools * tools).map(|pair| u32::from(pair / tools != pair % tools)).collect();
        Self { tools, costs }
    }

    /// Costs from one row for each tool: `rows[from][to]`.
    pub fn new(rows: &[Vec<u32>]) -> Result<Self, ToolCostsError> {
        let tools = rows.len();
        if tools > Self::MAX_TOOLS {
            return Err(ToolCostsError::TooManyTools { got: tools });
        }
        for (tool, row) in rows.iter().enumerate() {
            if row.len() != tools {
                return Err(ToolCostsError::NotSquare { tool, expected: tools, got: row.len() });
            }
            if row[tool] != 0 {
                return Err(ToolCostsError::Staying { tool, cost: row[tool] });
            }
        }
        Ok(Self { tools, costs: rows.concat() })
    }

    /// Number of tools.
    pub fn tools(&self) -> usize {
        self.tools
    }

    /// The cost of a change.
    ///
    /// # Panics
    /// If one of the tools is not below [`ToolCosts::tools`].
    pub fn cost(&self, from: u8, to: u8) -> u32 {
        assert!(usize::from(to) < self.tools, "tool {to} has no cost");
        self.costs[usize::from(from) * self.tools + usize::from(to)]
    }

    /// Whether no detour over other tools is cheaper than a direct change.
    /// Cubic in the tools.
    pub fn is_metric(&self) -> bool {
        self.with_detours() == *self
    }

    /// What the cheapest way from each tool to each other costs, over any tools: by the method of
    /// Floyd and Warshall.
    pub(crate) fn with_detours(&self) -> Self {
        let n = self.tools;
        let mut costs = self.costs.clone();
        for by in 0..n {
            for from in 0..n {
                for to in 0..n {
                    let detour = costs[from * n + by].saturating_add(costs[by * n + to]);
                    let cost = &mut costs[from * n + to];
                    *cost = detour.min(*cost);
                }
            }
        }
        Self { tools: n, costs }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_checked() {
        let costs = ToolCosts::new(&[vec![0, 7], vec![3, 0]]).unwrap();
        assert_eq!(
            (costs.tools(), costs.cost(0, 1), costs.cost(1, 0), costs.cost(1, 1)),
            (2, 7, 3, 0)
        );
        let error = |rows: &[Vec<u32>]| ToolCosts::new(rows).unwrap_err();
        let crooked = ToolCostsError::NotSquare { tool: 1, expected: 2, got: 1 };
        assert_eq!(error(&[vec![0, 1], vec![2]]), crooked);
        assert_eq!(error(&[vec![0, 1], vec![2, 5]]), ToolCostsError::Staying { tool: 1, cost: 5 });
        assert_eq!(error(&vec![vec![0; 256]; 256]), ToolCostsError::TooManyTools { got: 256 });
        assert_eq!(ToolCosts::uniform(255).cost(254, 0), 1);
    }

    #[test]
    fn detours_are_found() {
        let costs = ToolCosts::new(&[vec![0, 9, 1], vec![9, 0, u32::MAX], vec![5, 2, 0]]).unwrap();
        let least = ToolCosts::new(&[vec![0, 3, 1], vec![9, 0, 10], vec![5, 2, 0]]).unwrap();
        assert_eq!(costs.with_detours(), least);
        assert!(!costs.is_metric() && least.is_metric() && ToolCosts::uniform(7).is_metric());
    }
}
