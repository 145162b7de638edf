//! Minimum spanning arborescences by the algorithm of Chu, Liu and Edmonds.

/// A tree in which every vertex but the root has one arc from its parent.
pub(super) struct Arborescence {
    /// Sum of the weights of its arcs.
    pub(super) weight: i64,
    /// Parent of each vertex; the entry of the root is meaningless.
    pub(super) parent: Vec<usize>,
}

/// Weight of a missing arc.
pub(super) const NO_ARC: i64 = i64::MAX / 4;

/// An arc between two of the original vertices.
type Arc = (u16, u16);

/// One round of contractions.
struct Level {
    /// For each vertex of this round, the vertex of the next round that contains it.
    contracted: Vec<usize>,
    /// For each vertex of this round, its cheapest incoming arc.
    cheapest: Vec<Arc>,
}

/// The spanning arborescence with the minimum sum of `weight(from, to)`, which must exist, by the
/// algorithm of Chu, Liu and Edmonds.
///
/// Every vertex but the root takes its cheapest incoming arc.
/// If the arcs form no cycle they are the minimum.
/// Otherwise some arc of each cycle must be replaced by one that enters the cycle.
/// From the weight of each arc into a vertex, subtract that of the vertex's cheapest arc.
/// What is left is the extra cost of using the arc instead of the cheapest one.
/// Then each cycle is contracted to one vertex, and the rest is a smaller problem of the same kind.
/// Its solution enters each cycle at one vertex; the other vertices of the cycle keep their
/// cheapest arcs.
///
/// O(n²) steps for each round of contractions; there are usually few rounds, and at most n / 2.
pub(super) fn minimum(
    count: usize,
    root: usize,
    weight: impl Fn(usize, usize) -> i64,
) -> Arborescence {
    let mut total = 0;
    let mut size = count;
    let mut root = root;
    let mut weights: Vec<i64> =
        (0..count * count).map(|pair| weight(pair / count, pair % count)).collect();
    let mut arcs: Vec<Arc> =
        (0..count * count).map(|pair| ((pair / count) as u16, (pair % count) as u16)).collect();
    let mut levels: Vec<Level> = Vec::new();
    let last = loop {
        let mut parents = vec![root; size];
        for to in (0..size).filter(|&to| to != root) {
            let from = (0..size).filter(|&from| from != to);
            let best = from.min_by_key(|&from| weights[from * size + to]);
            parents[to] = best.expect("there is another vertex");
            let min = weights[parents[to] * size + to];
            total += min;
            (0..size).for_each(|from| weights[from * size + to] -= min);
        }
        let cheapest: Vec<Arc> = (0..size).map(|to| arcs[parents[to] * size + to]).collect();
        let (contracted, next_size) = contract_cycles(&parents, root);
        if next_size == size {
            break cheapest;
        }
        let mut next_weights = vec![NO_ARC; next_size * next_size];
        let mut next_arcs = vec![(0, 0); next_size * next_size];
        for from in 0..size {
            for to in 0..size {
                let pair = contracted[from] * next_size + contracted[to];
                let weight = weights[from * size + to];
                if contracted[from] != contracted[to] && weight < next_weights[pair] {
                    next_weights[pair] = weight;
                    next_arcs[pair] = arcs[from * size + to];
                }
            }
        }
        root = contracted[root];
        (size, weights, arcs) = (next_size, next_weights, next_arcs);
        levels.push(Level { contracted, cheapest });
    };
    // For each level and each original vertex, the vertex of that level that contains it.
    let mut containing: Vec<Vec<usize>> = vec![(0..count).collect()];
    for level in &levels {
        let here = containing.last().expect("there is the first level");
        containing.push(here.iter().map(|&vertex| level.contracted[vertex]).collect());
    }
    let mut entering = last;
    for (level, containing) in levels.iter().zip(&containing).rev() {
        let arc = |vertex: usize| {
            let enters = entering[level.contracted[vertex]];
            let is_entered = containing[usize::from(enters.1)] == vertex;
            if is_entered { enters } else { level.cheapest[vertex] }
        };
        entering = (0..level.contracted.len()).map(arc).collect();
    }
    let parent = entering.iter().map(|&(from, _)| usize::from(from)).collect();
    Arborescence { weight: total, parent }
}

/// Numbers the vertices after all cycles of parents are contracted, and returns their number.
fn contract_cycles(parents: &[usize], root: usize) -> (Vec<usize>, usize) {
    const NONE: usize = usize::MAX;

    let mut number = vec![NONE; parents.len()];
    // The vertex from which each vertex was first visited.
    let mut visited_from = vec![NONE; parents.len()];
    let mut next = 0;
    for start in 0..parents.len() {
        let mut vertex = start;
        while vertex != root && visited_from[vertex] == NONE {
            visited_from[vertex] = start;
            vertex = parents[vertex];
        }
        // The walk has come back to itself: `vertex` lies on a new cycle.
        if vertex != root && visited_from[vertex] == start && number[vertex] == NONE {
            let begin = vertex;
            loop {
                number[vertex] = next;
                vertex = parents[vertex];
                if vertex == begin {
                    break;
                }
            }
            next += 1;
        }
    }
    for number in number.iter_mut().filter(|number| **number == NONE) {
        *number = next;
        next += 1;
    }
    (number, next)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// The minimum weight over all choices of parents that lead to the root.
    fn slow_minimum(count: usize, root: usize, weights: &[i64]) -> i64 {
        let mut best = i64::MAX;
        let choices = count.pow(count as u32);
        for choice in 0..choices {
            let parent = |vertex: usize| choice / count.pow(vertex as u32) % count;
            let reaches_root = |vertex: usize| {
                let mut at = vertex;
                (0..count).any(|_| {
                    let is_root = at == root;
                    at = parent(at);
                    is_root
                })
            };
            if (0..count).all(reaches_root) {
                let others = (0..count).filter(|&vertex| vertex != root);
                let sum = others.map(|vertex| weights[parent(vertex) * count + vertex]).sum();
                best = best.min(sum);
            }
        }
        best
    }

    #[test]
    fn arborescences_are_minimal() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..2000 {
            let count = rng.random_range(1..=5);
            let root = rng.random_range(0..count);
            let max = rng.random_range(1..30);
            let weights: Vec<i64> =
                (0..count * count).map(|_| rng.random_range(-max..=max)).collect();
            let found = minimum(count, root, |from, to| weights[from * count + to]);
            assert_eq!(found.weight, slow_minimum(count, root, &weights));
            check(count, root, &weights, &found);
        }
    }

    /// Large graphs have several levels of contractions.
    #[test]
    fn large_arborescences_have_the_stated_weight() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        for _ in 0..200 {
            let count = rng.random_range(20..60);
            let weights: Vec<i64> = (0..count * count).map(|_| rng.random_range(0..9)).collect();
            let found = minimum(count, 0, |from, to| weights[from * count + to]);
            check(count, 0, &weights, &found);
        }
    }

    fn check(count: usize, root: usize, weights: &[i64], found: &Arborescence) {
        let others = || (0..count).filter(|&vertex| vertex != root);
        let sum: i64 = others().map(|vertex| weights[found.parent[vertex] * count + vertex]).sum();
        assert_eq!(sum, found.weight);
        for vertex in others() {
            let mut at = vertex;
            let mut steps = 0;
            while at != root {
                at = found.parent[at];
                steps += 1;
                assert!(steps < count, "the arcs form a cycle");
            }
        }
    }
}
