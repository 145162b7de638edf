//! The layers of a part and the constraints on them, checked.

use std::collections::BTreeMap;

use super::{Constraints, MAX_TOOLS, OrderError, ToolCosts};

/// The sets of tools of all layers.
///
/// Invariant: each set is sorted, without doubles, of 1..=12 tools that have costs.
pub(super) struct Layers {
    /// The different sets.
    pub(super) kinds: Vec<Vec<u8>>,
    /// For each layer, the number of its set.
    pub(super) kind_of: Vec<usize>,
}

impl Layers {
    /// Checks layers and constraints, but for what one permutation of all tools asks besides.
    pub(super) fn new(
        layers: &[Vec<u8>],
        costs: &ToolCosts,
        constraints: &Constraints,
    ) -> Result<Self, OrderError> {
        let tools = costs.tools();
        let known = |&tool: &u8| {
            if usize::from(tool) < tools {
                Ok(())
            } else {
                Err(OrderError::UnknownTool { tool, tools })
            }
        };
        let mut kinds = Vec::new();
        let mut kind_of = Vec::with_capacity(layers.len());
        let mut numbers: BTreeMap<Vec<u8>, usize> = BTreeMap::new();
        for (layer, tools) in layers.iter().enumerate() {
            let mut set = tools.clone();
            set.sort_unstable();
            set.dedup();
            set.iter().try_for_each(known)?;
            match set.len() {
                0 => return Err(OrderError::EmptyLayer { layer }),
                got if got > MAX_TOOLS => return Err(OrderError::TooManyTools { layer, got }),
                _ => {}
            }
            let number = *numbers.entry(set).or_insert_with_key(|set| {
                kinds.push(set.clone());
                kinds.len() - 1
            });
            kind_of.push(number);
        }
        let checked = Self { kinds, kind_of };
        constraints.before.iter().flat_map(|(a, b)| [a, b]).try_for_each(known)?;
        constraints.first.iter().try_for_each(known)?;
        if let Some((a, b)) = circle(&constraints.before) {
            return Err(OrderError::Circle { a, b });
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

    /// The set of each layer.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u8]> {
        self.kind_of.iter().map(|&kind| self.kinds[kind].as_slice())
    }
}

/// A pair that is part of a circle of pairs, if there is one.
fn circle(before: &[(u8, u8)]) -> Option<(u8, u8)> {
    // What nothing has to come before is in no circle; without it, neither are those that only it
    // came before.
    let mut left = before.to_vec();
    loop {
        let count = left.len();
        let kept: Vec<(u8, u8)> =
            left.iter().copied().filter(|&(a, _)| left.iter().any(|&(_, b)| a == b)).collect();
        left = kept;
        if left.len() == count {
            break;
        }
    }
    // Each tool left has one before it: going back comes round in the end.
    let mut tool = left.first()?.1;
    let mut seen = Vec::new();
    loop {
        seen.push(tool);
        let earlier = left.iter().find(|&&(_, b)| b == tool).map(|&(a, _)| a)?;
        if seen.contains(&earlier) {
            return Some((earlier, tool));
        }
        tool = earlier;
    }
}
