//! Makes the surface of a body closed and turns it outwards, and says what it had to change.
//!
//! Every triangle's boundary is a closed circle, so what is left of all triangles' boundaries, once
//! edges that are used both ways cancel out, is a set of closed loops too: the holes.
//! Each of them can be filled by a fan, and then the surface is closed, whatever it looked like
//! before.

mod above;

use beadwork_base::{Control, Interrupted};
use thiserror::Error;

use self::above::Above;

use super::model::Body;
use super::surface::{Mesh, cross, dot, minus, spat_mm3};

/// What a repair changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RepairReport {
    /// Vertices that lay on others and became one with them.
    pub merged_vertices: usize,
    /// Triangles with two corners at one place, which were dropped.
    pub dropped_triangles: usize,
    /// Triangles that faced against their neighbours, or a body that was inside out.
    pub flipped_triangles: usize,
    /// Holes that were closed.
    pub closed_holes: usize,
}

impl RepairReport {
    /// Whether nothing but double vertices was found, which many formats can't avoid.
    pub fn was_sound(&self) -> bool {
        (self.dropped_triangles, self.flipped_triangles, self.closed_holes) == (0, 0, 0)
    }
}

/// Why a body can't be repaired.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RepairError {
    /// No triangle has an area.
    #[error("none of its {0} triangles has an area")]
    NoArea(usize),
    /// It encloses nothing.
    #[error("its {0} triangles enclose no volume")]
    NoVolume(usize),
    /// It has a hole that is too large to be closed on a guess.
    #[error(
        "it has a hole of {edges} edges, {length_mm:.2} mm around, at ({:.2}, {:.2}, {:.2}): too large to be closed on a guess",
        .at_mm[0], .at_mm[1], .at_mm[2]
    )]
    Hole {
        /// Edges around it.
        edges: usize,
        /// Length around it in mm.
        length_mm: f64,
        /// One of its corners.
        at_mm: [f64; 3],
    },
    /// The caller ended the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Ray tests for bodies within bodies are given up beyond so many triangles looked at: some
/// seconds.
const MOST_LOOKS: usize = 500_000_000;

/// Holes are small if the way around them is at most so much of the body's diagonal.
/// Flat ones may be of any size.
const SMALL_HOLE: f64 = 1.0;
/// A body has a volume if it is thicker than this over its whole size, in mm.
const THINNEST_MM: f64 = 1e-6;

/// A hole is flat if no corner lies further from its plane than so much of the body's diagonal.
const FLAT_HOLE: f64 = 1e-3;

impl Body {
    /// Repairs the surface.
    ///
    /// 1. Vertices at the same place become one; triangles that are left with two corners at one
    ///    place are dropped.
    /// 2. Triangles are turned to agree with their neighbours: of each connected part the fewer.
    /// 3. Holes that are flat or small (no longer around than the body is across) are closed by
    ///    fans.
    /// 4. A body that is inside out is turned over, and so are connected parts of it, unless they
    ///    lie within another: those are cavities.
    ///    Of thousands of parts inside out, one above the other, some may be left as they are.
    ///
    /// Nearly linear in the triangles; needs about as much memory as the mesh itself, beside it.
    pub fn repair(&mut self, control: &Control<'_>) -> Result<RepairReport, RepairError> {
        control.check()?;
        let mut done = RepairReport::default();
        let triangles = self.mesh.triangles().len();
        done.merged_vertices = merge_vertices(&mut self.mesh);
        done.dropped_triangles = drop_degenerate(self);
        if self.mesh.triangles().is_empty() {
            return Err(RepairError::NoArea(triangles));
        }
        let mut edges = Edges::new(&self.mesh);
        let mut parts = Parts::new(&self.mesh, &edges);
        done.flipped_triangles = parts.flip_fewer(&mut self.mesh);
        if done.flipped_triangles > 0 {
            edges = Edges::new(&self.mesh);
        }
        parts.join_all(&edges);
        done.closed_holes = close_holes(self, &edges, &mut parts)?;
        drop(edges);
        done.flipped_triangles += turn_outwards(&mut self.mesh, &mut parts);
        let volume = self.mesh.volume_mm3().abs();
        // Coordinates beyond all use make it no number.
        if volume.is_nan() || volume < THINNEST_MM * self.mesh.bounds().diagonal_mm().powi(2) {
            return Err(RepairError::NoVolume(triangles));
        }
        Ok(done)
    }
}

/// Vertices in an order in which equal ones are neighbours.
fn merge_vertices(mesh: &mut Mesh) -> usize {
    let (vertices, triangles) = mesh.parts_mut();
    let key = |vertex: u32| vertices[vertex as usize].map(|value| (value + 0.0).to_bits());
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    // Ties by number: the first of equal vertices stands for all.
    order.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
    let mut number_of: Vec<u32> = (0..vertices.len() as u32).collect();
    let mut merged = 0;
    for equal in order.chunk_by(|&a, &b| key(a) == key(b)) {
        merged += equal.len() - 1;
        equal[1..].iter().for_each(|&vertex| number_of[vertex as usize] = equal[0]);
    }
    drop(order);
    if merged == 0 {
        return 0;
    }
    let mut kept = 0;
    for vertex in 0..vertices.len() {
        if number_of[vertex] == vertex as u32 {
            vertices[kept] = vertices[vertex];
            number_of[vertex] = kept as u32;
            kept += 1;
        } else {
            // The vertex that stands for it comes before it and has its new number.
            number_of[vertex] = number_of[number_of[vertex] as usize];
        }
    }
    vertices.truncate(kept);
    vertices.shrink_to_fit();
    triangles.iter_mut().flatten().for_each(|vertex| *vertex = number_of[*vertex as usize]);
    merged
}

fn drop_degenerate(body: &mut Body) -> usize {
    let (_, triangles) = body.mesh.parts_mut();
    let keep: Vec<bool> = triangles.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
    let dropped = keep.iter().filter(|&&keep| !keep).count();
    let mut kept = keep.iter();
    triangles.retain(|_| *kept.next().expect("one entry a triangle"));
    if !body.paint.is_empty() {
        let mut kept = keep.iter();
        body.paint.retain(|_| *kept.next().expect("one entry a triangle"));
    }
    dropped
}

/// The edges of all triangles, those between the same two vertices side by side.
struct Edges {
    /// For each vertex where its edges to vertices of higher numbers begin.
    starts: Vec<u32>,
    /// The higher vertex, and three times the triangle plus the corner from which the edge leaves.
    edges: Vec<[u32; 2]>,
}

impl Edges {
    fn new(mesh: &Mesh) -> Self {
        let mut starts = vec![0_u32; mesh.vertices().len() + 1];
        each_edge(mesh, |low, _, _| starts[low as usize + 1] += 1);
        for vertex in 1..starts.len() {
            starts[vertex] += starts[vertex - 1];
        }
        let mut edges = vec![[0; 2]; 3 * mesh.triangles().len()];
        // Filling moves every start to its end, which is the next one's start.
        each_edge(mesh, |low, high, half| {
            edges[starts[low as usize] as usize] = [high, half];
            starts[low as usize] += 1;
        });
        starts.rotate_right(1);
        starts[0] = 0;
        for vertex in 0..starts.len() - 1 {
            edges[starts[vertex] as usize..starts[vertex + 1] as usize].sort_unstable();
        }
        Self { starts, edges }
    }

    /// All edges between the same two vertices: the lower vertex, and the higher with the halves.
    fn groups(&self) -> impl Iterator<Item = (u32, &[[u32; 2]])> {
        let of_vertex = |vertex: usize| {
            &self.edges[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
        };
        (0..self.starts.len() - 1).flat_map(move |vertex| {
            of_vertex(vertex).chunk_by(|a, b| a[0] == b[0]).map(move |group| (vertex as u32, group))
        })
    }
}

fn each_edge(mesh: &Mesh, mut visit: impl FnMut(u32, u32, u32)) {
    for (triangle, corners) in (0..).zip(mesh.triangles()) {
        for corner in 0..3 {
            let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
            visit(a.min(b), a.max(b), 3 * triangle + corner as u32);
        }
    }
}

/// Whether a half edge runs from the lower to the higher vertex.
fn is_rising(mesh: &Mesh, half: u32) -> bool {
    let corners = mesh.triangles()[half as usize / 3];
    let corner = half as usize % 3;
    corners[corner] < corners[(corner + 1) % 3]
}

/// Triangles joined over edges that two of them share, each part a tree; a bit says whether a
/// triangle faces against its parent.
struct Parts {
    parents: Vec<u32>,
    against: Vec<bool>,
}

impl Parts {
    fn new(mesh: &Mesh, edges: &Edges) -> Self {
        let count = mesh.triangles().len();
        let mut parts = Self { parents: (0..count as u32).collect(), against: vec![false; count] };
        for (_, group) in edges.groups() {
            let &[[_, first], [_, second]] = group else { continue };
            let clash = is_rising(mesh, first) == is_rising(mesh, second);
            parts.join(first / 3, second / 3, clash);
        }
        parts
    }

    /// The root of a triangle's part, and whether the triangle faces against it.
    fn root(&mut self, triangle: u32) -> (u32, bool) {
        let mut root = triangle;
        let mut against = false;
        while self.parents[root as usize] != root {
            against ^= self.against[root as usize];
            root = self.parents[root as usize];
        }
        // The way is halved to nothing: all on it are hung below the root.
        let (mut at, mut to_root) = (triangle, against);
        while self.parents[at as usize] != root && at != root {
            let (parent, own) = (self.parents[at as usize], self.against[at as usize]);
            (self.parents[at as usize], self.against[at as usize]) = (root, to_root);
            to_root ^= own;
            at = parent;
        }
        (root, against)
    }

    /// A part that can't be turned to agree, such as a Moebius strip, stays as it is along one
    /// line.
    fn join(&mut self, first: u32, second: u32, clash: bool) {
        let ((a, a_against), (b, b_against)) = (self.root(first), self.root(second));
        let (low, high) = (a.min(b), a.max(b));
        if low != high {
            self.parents[high as usize] = low;
            self.against[high as usize] = a_against ^ b_against ^ clash;
        }
    }

    /// Joins what meets at an edge of more than two triangles too.
    /// How they face no longer matters: each part can only be turned as a whole.
    fn join_all(&mut self, edges: &Edges) {
        for (_, group) in edges.groups() {
            for pair in group.windows(2) {
                self.join(pair[0][1] / 3, pair[1][1] / 3, false);
            }
        }
    }

    /// Turns the triangles of each part to agree: the fewer of them.
    /// Tells how many.
    fn flip_fewer(&mut self, mesh: &mut Mesh) -> usize {
        let count = self.parents.len() as u32;
        if self.against.iter().all(|&against| !against) {
            return 0;
        }
        let mut balance = vec![0_i32; count as usize];
        for triangle in 0..count {
            let (root, against) = self.root(triangle);
            balance[root as usize] += if against { -1 } else { 1 };
        }
        let (_, triangles) = mesh.parts_mut();
        let mut flipped = 0;
        for triangle in 0..count {
            let (root, against) = self.root(triangle);
            if against == (balance[root as usize] >= 0) {
                triangles[triangle as usize].swap(1, 2);
                flipped += 1;
            }
        }
        flipped
    }
}

/// Fills the loops of edges that are used more often in one direction than in the other.
fn close_holes(body: &mut Body, edges: &Edges, parts: &mut Parts) -> Result<usize, RepairError> {
    let mesh = &body.mesh;
    // The fill's edges run against those that are too many: from, to, and the triangle there.
    let mut open: Vec<[u32; 3]> = Vec::new();
    for (low, group) in edges.groups() {
        let high = group[0][0];
        let rising = group.iter().filter(|&&[_, half]| is_rising(mesh, half)).count();
        let falling = group.len() - rising;
        let surplus = |wanted: bool, more: usize, less: usize| {
            let halves = group.iter().filter(move |&&[_, half]| is_rising(mesh, half) == wanted);
            halves.take(more.saturating_sub(less)).map(|&[_, half]| half / 3)
        };
        open.extend(surplus(true, rising, falling).map(|triangle| [high, low, triangle]));
        open.extend(surplus(false, falling, rising).map(|triangle| [low, high, triangle]));
    }
    if open.is_empty() {
        return Ok(0);
    }
    open.sort_unstable();
    let loops = loops(&open);
    let diagonal = mesh.bounds().diagonal_mm();
    for hole in &loops {
        let points: Vec<[f64; 3]> =
            hole.iter().map(|&edge| mesh.vertices()[open[edge][0] as usize]).collect();
        let length_mm = length_mm(&points);
        if length_mm > SMALL_HOLE * diagonal && !is_flat(&points, FLAT_HOLE * diagonal) {
            return Err(RepairError::Hole { edges: points.len(), length_mm, at_mm: points[0] });
        }
    }
    for hole in &loops {
        let [first, _, part] = open[hole[0]];
        // A hole between two parts makes them one.
        hole.iter().for_each(|&edge| parts.join(part, open[edge][2], false));
        for &edge in &hole[1..hole.len() - 1] {
            let [from, to, beside] = open[edge];
            let (root, _) = parts.root(beside);
            parts.parents.push(root);
            parts.against.push(false);
            body.mesh.parts_mut().1.push([first, from, to]);
            if !body.paint.is_empty() {
                body.paint.push(body.paint[beside as usize]);
            }
        }
    }
    Ok(loops.len())
}

/// Splits directed edges, sorted by their start, into simple loops, each a list of their numbers in
/// order.
///
/// As many edges lead to a vertex as from it, so a walk can only end where it began.
/// A vertex that comes twice closes a loop at once: two holes that touch are two.
fn loops(open: &[[u32; 3]]) -> Vec<Vec<usize>> {
    let first_from = |vertex: u32| open.partition_point(|edge| edge[0] < vertex);
    // For the first edge of each vertex, how many of its edges were walked.
    let mut walked = vec![0; open.len()];
    let mut loops = Vec::new();
    // Where on the walk a vertex was met.
    let mut met = std::collections::HashMap::new();
    let mut walk: Vec<usize> = Vec::new();
    for begin in 0..open.len() {
        let mut at = open[begin][0];
        loop {
            if let Some(since) = met.insert(at, walk.len())
                && since < walk.len()
            {
                let closed = walk.split_off(since);
                closed.iter().for_each(|&edge| {
                    met.remove(&open[edge][0]);
                });
                met.insert(at, since);
                loops.push(closed);
            }
            let first = first_from(at);
            let edge = first + walked[first];
            if open.get(edge).is_none_or(|edge| edge[0] != at) {
                break;
            }
            walked[first] += 1;
            walk.push(edge);
            at = open[edge][1];
        }
        // All that was walked is closed.
        // To clear the map would take the time of the most it ever held, for each edge.
        met.remove(&at);
    }
    loops
}

fn length_mm(points: &[[f64; 3]]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(&a, &b)| dot(minus(a, b), minus(a, b)).sqrt()).sum()
}

/// Whether all points lie near the plane through their middle that is normal to their area.
fn is_flat(points: &[[f64; 3]], near_mm: f64) -> bool {
    let count = points.len() as f64;
    let middle = [0, 1, 2].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
    let next = points.iter().cycle().skip(1);
    let mut normal = [0.0; 3];
    for (&a, &b) in points.iter().zip(next) {
        let area = cross(minus(a, middle), minus(b, middle));
        (0..3).for_each(|axis| normal[axis] += area[axis]);
    }
    let length = dot(normal, normal).sqrt();
    // Points on a line have no plane, and no hole to speak of.
    length <= near_mm * near_mm
        || points.iter().all(|&point| dot(minus(point, middle), normal).abs() <= near_mm * length)
}

/// Turns over the parts that are inside out and no cavities; tells how many triangles.
fn turn_outwards(mesh: &mut Mesh, parts: &mut Parts) -> usize {
    let count = mesh.triangles().len();
    let roots: Vec<u32> = (0..count as u32).map(|triangle| parts.root(triangle).0).collect();
    // Seen from a point of the body, the volumes are no differences of large numbers.
    let origin = mesh.vertices()[mesh.triangles()[0][0] as usize];
    let mut volumes = vec![0.0; count];
    for (triangle, &root) in roots.iter().enumerate() {
        let corners = mesh.corners(mesh.triangles()[triangle]).map(|corner| minus(corner, origin));
        volumes[root as usize] += spat_mm3(corners);
    }
    // A body that is inside out as a whole has cavities that look like bodies.
    let is_inverted = volumes.iter().sum::<f64>() < 0.0;
    if is_inverted {
        mesh.parts_mut().1.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        volumes.iter_mut().for_each(|volume| *volume = -*volume);
    }
    let mut flipped = if is_inverted { count } else { 0 };
    let inverted: Vec<u32> =
        (0..count as u32).filter(|&root| volumes[root as usize] < 0.0).collect();
    if inverted.is_empty() {
        return flipped;
    }
    let mut outside: Vec<bool> = vec![false; count];
    let above = Above::new(mesh);
    let mut looks = 0;
    for root in inverted {
        if looks > MOST_LOOKS {
            break;
        }
        let point = mesh.vertices()[mesh.triangles()[root as usize][0] as usize];
        let mut winding = 0;
        looks += above.each(point, |triangle| {
            if roots[triangle as usize] != root {
                winding += turn_above(mesh.corners(mesh.triangles()[triangle as usize]), point);
            }
        });
        outside[root as usize] = winding == 0;
    }
    let (_, triangles) = mesh.parts_mut();
    for (triangle, &root) in triangles.iter_mut().zip(&roots) {
        if outside[root as usize] {
            triangle.swap(1, 2);
            flipped = if is_inverted { flipped - 1 } else { flipped + 1 };
        }
    }
    flipped
}

/// What a triangle adds to how often a ray upwards from a point leaves the body more than it enters
/// it: 1, -1 or 0.
fn turn_above(corners: [[f64; 3]; 3], point: [f64; 3]) -> i32 {
    let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    let is_above = normal[2] != 0.0
        && covers(corners, point)
        && dot(normal, minus(corners[0], point)) * normal[2].signum() > 0.0;
    if !is_above {
        0
    } else if normal[2] > 0.0 {
        1
    } else {
        -1
    }
}

/// Whether a triangle lies above or below a point; of triangles that share an edge exactly one
/// does.
fn covers(corners: [[f64; 3]; 3], point: [f64; 3]) -> bool {
    let mut is_inside = false;
    for corner in 0..3 {
        let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
        let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        if low[1] <= point[1] && point[1] < high[1] {
            let x = low[0] + (point[1] - low[1]) / (high[1] - low[1]) * (high[0] - low[0]);
            is_inside ^= x > point[0];
        }
    }
    is_inside
}

#[cfg(test)]
mod tests;
