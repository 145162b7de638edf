//! One set of tools as a shortest Hamiltonian path problem.

use crate::CostMatrix;

/// Cost of a forbidden change: more than any sum of at most 255 costs, which are below 2^32.
pub(super) const PENALTY: u64 = 1 << 40;

/// Indices of tools within a set of at most 256 tools.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Members([u64; 4]);

impl Members {
    #[inline]
    pub(super) fn insert(&mut self, index: usize) {
        self.0[index / 64] |= 1 << (index % 64);
    }

    #[inline]
    pub(super) fn intersects(self, other: Self) -> bool {
        self.0.iter().zip(other.0).any(|(a, b)| a & b != 0)
    }

    pub(super) fn is_empty(self) -> bool {
        self == Self::default()
    }

    pub(super) fn contains(self, index: usize) -> bool {
        self.0[index / 64] & 1 << (index % 64) != 0
    }
}

/// The costs of changes between the tools of a set, and which tools must come before others.
/// Tools are addressed by their index in the set.
pub(super) struct Problem {
    /// Number of tools.
    pub(super) count: usize,
    /// Scaled costs, row by row; [`PENALTY`] if the change is forbidden.
    steps: Vec<u64>,
    /// For each tool, those that must come before it.
    pub(super) earlier: Vec<Members>,
    /// For each tool, whether it may be the last: no other tool must come after it.
    ends: Vec<bool>,
}

impl Problem {
    /// The problem of a set of tools under the constraints of `before` between tools of the set.
    pub(super) fn new(set: &[u8], costs: &CostMatrix, before: &[(u8, u8)]) -> Self {
        let count = set.len();
        let step = |pair: usize| costs.step(set[pair / count], set[pair % count]).min(PENALTY);
        let index = |tool: u8| set.iter().position(|&one| one == tool);
        let mut earlier = vec![Members::default(); count];
        let mut ends = vec![true; count];
        for &(a, b) in before {
            if let (Some(a), Some(b)) = (index(a), index(b)) {
                earlier[b].insert(a);
                ends[a] = false;
            }
        }
        Self { count, steps: (0..count * count).map(step).collect(), earlier, ends }
    }

    /// Scaled cost of a change.
    #[inline]
    pub(super) fn step(&self, from: usize, to: usize) -> u64 {
        self.steps[from * self.count + to]
    }

    /// Largest cost of a change that is not forbidden.
    pub(super) fn max_step(&self) -> u64 {
        self.steps.iter().copied().filter(|&step| step < PENALTY).max().unwrap_or(0)
    }

    /// Whether an order can begin with `first` and end with `last`, forbidden changes aside.
    pub(super) fn allows(&self, first: usize, last: usize) -> bool {
        self.earlier[first].is_empty() && self.ends[last] && (first != last || self.count == 1)
    }

    /// Scaled cost of an order.
    pub(super) fn cost(&self, order: &[usize]) -> u64 {
        order.windows(2).map(|pair| self.step(pair[0], pair[1])).sum()
    }
}
