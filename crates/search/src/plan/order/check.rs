//! The layers of a part and the constraints on their tools, checked.

use std::collections::BTreeMap;

use super::constraints::{Constraints, OrderError};
use crate::CostMatrix;

/// The sets of tools of the layers that use any, and constraints that have been checked.
///
/// Invariant: each set is sorted, without duplicates, not empty, and its tools have costs.
pub(super) struct Layers {
    /// The different sets.
    pub(super) kinds: Vec<Vec<u8>>,
    /// For each layer that uses tools, the number of its set.
    pub(super) kind_of: Vec<usize>,
    /// For each layer that uses tools, its number among all layers.
    pub(super) number: Vec<usize>,
    /// Number of all layers.
    count: usize,
}

impl Layers {
    /// Checks layers and constraints, except whether one permutation of all tools can obey them.
    pub(super) fn new(
        layers: &[Vec<u8>],
        costs: &CostMatrix,
        constraints: &Constraints,
    ) -> Result<Self, OrderError> {
        let tools = costs.size();
        let is_known = |&tool: &u8| {
            if usize::from(tool) < tools {
                Ok(())
            } else {
                Err(OrderError::UnknownTool { tool, tools })
            }
        };
        let mut checked = Self {
            kinds: Vec::new(),
            kind_of: Vec::new(),
            number: Vec::new(),
            count: layers.len(),
        };
        let mut numbers: BTreeMap<Vec<u8>, usize> = BTreeMap::new();
        for (layer, tools) in layers.iter().enumerate() {
            let mut set = tools.clone();
            set.sort_unstable();
            set.dedup();
            set.iter().try_for_each(is_known)?;
            if set.is_empty() {
                continue;
            }
            let kind = *numbers.entry(set).or_insert_with_key(|set| {
                checked.kinds.push(set.clone());
                checked.kinds.len() - 1
            });
            checked.kind_of.push(kind);
            checked.number.push(layer);
        }
        constraints.before.iter().flat_map(|(a, b)| [a, b]).try_for_each(is_known)?;
        constraints.first.iter().try_for_each(is_known)?;
        constraints.loaded.iter().try_for_each(is_known)?;
        if let Some((a, b)) = find_cycle(&constraints.before) {
            return Err(OrderError::Cycle { a, b });
        }
        if let Some(first) = constraints.first {
            let set = checked.iter().next().filter(|set| set.contains(&first));
            let set = set.ok_or(OrderError::FirstMissing { first })?;
            let earlier = constraints
                .before
                .iter()
                .find(|&&(other, tool)| tool == first && set.contains(&other));
            if let Some(&(other, _)) = earlier {
                return Err(OrderError::FirstContradicted { first, other });
            }
        }
        Ok(checked)
    }

    /// The set of each layer that uses tools.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u8]> {
        self.kind_of.iter().map(|&kind| self.kinds[kind].as_slice())
    }

    /// One order for each layer, with empty ones for the layers that use no tool, from the orders
    /// of the others.
    pub(super) fn with_empty(&self, orders: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        let mut all = vec![Vec::new(); self.count];
        for (&number, order) in self.number.iter().zip(orders) {
            all[number] = order;
        }
        all
    }
}

/// Finds a cycle of pairs and returns one of its pairs; `None` if there is no cycle.
fn find_cycle(before: &[(u8, u8)]) -> Option<(u8, u8)> {
    // A tool that no other tool must precede lies on no cycle.
    // Removing its pairs may leave more such tools; if pairs remain in the end, they contain a
    // cycle.
    let mut remaining = before.to_vec();
    loop {
        let count = remaining.len();
        let kept = remaining.iter().copied();
        let kept: Vec<(u8, u8)> =
            kept.filter(|&(a, _)| remaining.iter().any(|&(_, b)| a == b)).collect();
        remaining = kept;
        if remaining.len() == count {
            break;
        }
    }
    // Each remaining tool has a predecessor, so going backwards must return to a tool that was
    // seen.
    let mut tool = remaining.first()?.1;
    let mut seen = Vec::new();
    loop {
        seen.push(tool);
        let earlier = remaining.iter().find(|&&(_, b)| b == tool).map(|&(a, _)| a)?;
        if seen.contains(&earlier) {
            return Some((earlier, tool));
        }
        tool = earlier;
    }
}
