//! Maximum bipartite matching by augmenting paths (Kuhn's algorithm).

/// Matches as many left vertices as possible with right vertices; returns for each left vertex the
/// position of its chosen edge in `edges[left]`.
///
/// Edges are tried in the given order, so of equally large matchings those that come first are
/// preferred.
/// O(vertices * edges).
pub(super) fn maximum_matching(edges: &[Vec<usize>], right_count: usize) -> Vec<Option<usize>> {
    let mut matching = Matching {
        edges,
        left_of: vec![None; right_count],
        chosen: vec![None; edges.len()],
        visited: vec![usize::MAX; right_count],
    };
    for left in 0..edges.len() {
        matching.augment(left, left);
    }
    matching.chosen
}

struct Matching<'a> {
    edges: &'a [Vec<usize>],
    /// For each right vertex, its left one.
    left_of: Vec<Option<usize>>,
    /// For each left vertex, the position of its edge.
    chosen: Vec<Option<usize>>,
    /// For each right vertex, the last round that visited it.
    visited: Vec<usize>,
}

impl Matching<'_> {
    /// Matches a left vertex, if need be by moving others; returns whether it succeeded.
    fn augment(&mut self, left: usize, round: usize) -> bool {
        for (at, &right) in self.edges[left].iter().enumerate() {
            if std::mem::replace(&mut self.visited[right], round) == round {
                continue;
            }
            let is_free = match self.left_of[right] {
                None => true,
                Some(other) => self.augment(other, round),
            };
            if is_free {
                self.left_of[right] = Some(left);
                self.chosen[left] = Some(at);
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// Maximum size by trying everything.
    fn brute_force(edges: &[Vec<usize>], used: u32) -> usize {
        let Some((first, rest)) = edges.split_first() else { return 0 };
        let without = brute_force(rest, used);
        let with = first.iter().filter(|&&right| used & 1 << right == 0);
        with.map(|&right| 1 + brute_force(rest, used | 1 << right)).max().unwrap_or(0).max(without)
    }

    #[test]
    fn matchings_are_maximum() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..3000 {
            let right = rng.random_range(1..6);
            let edges: Vec<Vec<usize>> = (0..rng.random_range(0..6))
                .map(|_| (0..right).filter(|_| rng.random_range(0..3) == 0).collect())
                .collect();
            let chosen = maximum_matching(&edges, right);
            let mut used: Vec<usize> =
                (0..edges.len()).filter_map(|left| Some(edges[left][chosen[left]?])).collect();
            assert_eq!(used.len(), brute_force(&edges, 0));
            used.sort_unstable();
            assert!(used.windows(2).all(|pair| pair[0] < pair[1]), "each right vertex once");
        }
    }
}
