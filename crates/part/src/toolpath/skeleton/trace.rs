//! Joins the links of a graph into long lines.

use super::prune::{Graph, Node};
use super::vector::{Vector, distance, dot, sub, unit};

/// A line along the medial axis.
#[derive(Debug)]
pub(super) struct Line {
    /// Its points; a closed one does not repeat the first point.
    pub(super) nodes: Vec<Node>,
    /// Whether the last point is joined to the first one.
    pub(super) is_closed: bool,
    /// Length in mm to remove at the start and the end, where it meets another line.
    pub(super) trim_mm: [f64; 2],
}

/// A sequence of links between two nodes that are ends or junctions; `nodes` includes both.
struct Branch {
    nodes: Vec<u32>,
    /// Whether it lies within a junction.
    is_contracted: bool,
}

/// The start or the end of a branch: twice its number, plus one for the end.
type End = usize;

/// The lines of a graph: straight through at junctions, where other lines end.
pub(super) fn trace(graph: &Graph, max_radius: f64) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut branches = branches(graph, &mut lines);
    let junctions = contract(graph, &mut branches);
    let mut partner: Vec<Option<End>> = vec![None; 2 * branches.len()];
    let mut trim = vec![0.0; 2 * branches.len()];
    // The centre of the junction at each end.
    let mut centre: Vec<Option<u32>> = vec![None; 2 * branches.len()];
    for (node, ends) in junctions {
        let Node { point, radius, .. } = graph.nodes[node as usize];
        let directions: Vec<_> = ends
            .iter()
            .map(|&end| direction(graph, &branches[end / 2], end % 2, point, 1.5 * radius))
            .collect();
        let mut best = (0.0, None);
        for i in 0..ends.len() {
            for j in 0..i {
                let cosine = dot(directions[i], directions[j]);
                if cosine < best.0 {
                    best = (cosine, Some([ends[i], ends[j]]));
                }
            }
        }
        for &end in &ends {
            centre[end] = Some(node);
            trim[end] = radius.min(max_radius);
        }
        if let Some([one, other]) = best.1 {
            (partner[one], partner[other]) = (Some(other), Some(one));
            (trim[one], trim[other]) = (0.0, 0.0);
        }
    }

    let mut is_used = vec![false; branches.len()];
    // Lines with ends first; what remains is closed.
    for only_ends in [true, false] {
        for start in 0..2 * branches.len() {
            let branch = &branches[start / 2];
            if is_used[start / 2] || branch.is_contracted || (only_ends && partner[start].is_some())
            {
                continue;
            }
            let mut nodes: Vec<u32> = Vec::new();
            let mut end = start;
            let last = loop {
                is_used[end / 2] = true;
                let of_branch = &branches[end / 2].nodes;
                nodes.extend(centre[end].filter(|_| partner[end].is_some()));
                if end.is_multiple_of(2) {
                    nodes.extend(of_branch);
                } else {
                    nodes.extend(of_branch.iter().rev());
                }
                match partner[end ^ 1] {
                    Some(next) if !is_used[next / 2] => end = next,
                    _ => break end ^ 1,
                }
            };
            nodes.dedup();
            let is_closed = !only_ends;
            if is_closed && nodes.len() > 1 && nodes.first() == nodes.last() {
                nodes.pop();
            }
            lines.push(Line {
                nodes: nodes.iter().map(|&node| graph.nodes[node as usize]).collect(),
                is_closed,
                trim_mm: [trim[start], trim[last]],
            });
        }
    }
    lines
}

/// Splits a graph at its ends and junctions, the nodes without exactly two neighbours.
///
/// Single nodes, and cycles without a junction, become lines.
fn branches(graph: &Graph, lines: &mut Vec<Line>) -> Vec<Branch> {
    let count = graph.nodes.len();
    let mut branches = Vec::new();
    let mut is_visited = vec![false; count];
    let mut line = |nodes: &[u32], is_closed| {
        let nodes = nodes.iter().map(|&node| graph.nodes[node as usize]).collect();
        lines.push(Line { nodes, is_closed, trim_mm: [0.0; 2] });
    };
    for node in 0..count {
        let neighbours = &graph.neighbours[node];
        if neighbours.len() == 2 {
            continue;
        }
        is_visited[node] = true;
        if neighbours.is_empty() {
            line(&[node as u32], false);
        }
        for &first in neighbours {
            let mut nodes = vec![node as u32];
            walk(graph, first, &mut nodes, &mut is_visited);
            // Each branch is found from both ends.
            let reversed = (nodes[nodes.len() - 1], nodes[nodes.len() - 2]);
            if (nodes[0], nodes[1]) <= reversed {
                branches.push(Branch { nodes, is_contracted: false });
            }
        }
    }
    for node in 0..count {
        if !is_visited[node] {
            is_visited[node] = true;
            let mut nodes = vec![node as u32];
            walk(graph, graph.neighbours[node][0], &mut nodes, &mut is_visited);
            nodes.pop();
            line(&nodes, true);
        }
    }
    branches
}

/// Appends the nodes from `next` to the next end or junction, or to the first of `nodes`.
fn walk(graph: &Graph, mut next: u32, nodes: &mut Vec<u32>, is_visited: &mut [bool]) {
    let start = nodes[0];
    let mut from = start;
    loop {
        nodes.push(next);
        let neighbours = &graph.neighbours[next as usize];
        if next == start || neighbours.len() != 2 {
            return;
        }
        is_visited[next as usize] = true;
        let onward = neighbours[usize::from(neighbours[0] == from)];
        from = std::mem::replace(&mut next, onward);
    }
}

/// Merges junctions that are nearer to each other than their radius.
///
/// Returns each merged junction's widest node and the ends of the branches that meet there.
fn contract(graph: &Graph, branches: &mut [Branch]) -> Vec<(u32, Vec<End>)> {
    let mut parent: Vec<u32> = (0..graph.nodes.len() as u32).collect();
    let find = |parent: &mut [u32], mut node: u32| {
        while parent[node as usize] != node {
            parent[node as usize] = parent[parent[node as usize] as usize];
            node = parent[node as usize];
        }
        node
    };
    let is_junction = |node: u32| graph.neighbours[node as usize].len() > 2;
    let radius = |node: u32| graph.nodes[node as usize].radius;
    for branch in branches.iter_mut() {
        let [a, b] = [branch.nodes[0], branch.nodes[branch.nodes.len() - 1]];
        if a != b && is_junction(a) && is_junction(b) {
            let point = |node: u32| graph.nodes[node as usize].point;
            let length: f64 =
                branch.nodes.windows(2).map(|pair| distance(point(pair[0]), point(pair[1]))).sum();
            if length < radius(a).max(radius(b)) {
                branch.is_contracted = true;
                let [a, b] = [a, b].map(|node| find(&mut parent, node));
                // The widest node represents the junction.
                let (wide, narrow) = if radius(a) >= radius(b) { (a, b) } else { (b, a) };
                parent[narrow as usize] = wide;
            }
        }
    }
    let mut ends_at: Vec<Vec<End>> = vec![Vec::new(); graph.nodes.len()];
    for (index, branch) in branches.iter().enumerate() {
        if !branch.is_contracted {
            for (side, node) in [branch.nodes[0], branch.nodes[branch.nodes.len() - 1]]
                .into_iter()
                .enumerate()
                .filter(|&(_, node)| is_junction(node))
            {
                ends_at[find(&mut parent, node) as usize].push(2 * index + side);
            }
        }
    }
    ends_at
        .into_iter()
        .enumerate()
        .filter(|(_, ends)| !ends.is_empty())
        .map(|(node, ends)| (node as u32, ends))
        .collect()
}

/// Direction from the centre of a junction to the point of a branch that is `reach` mm along it.
fn direction(graph: &Graph, branch: &Branch, side: usize, centre: Vector, reach: f64) -> Vector {
    let point = |i: usize| {
        let i = if side == 0 { i } else { branch.nodes.len() - 1 - i };
        graph.nodes[branch.nodes[i] as usize].point
    };
    let mut length = 0.0;
    let mut at = point(0);
    for i in 1..branch.nodes.len() {
        length += distance(at, point(i));
        at = point(i);
        if length >= reach {
            break;
        }
    }
    unit(sub(at, centre)).unwrap_or_default()
}
