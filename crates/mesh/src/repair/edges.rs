//! Finds the triangles that meet at each edge.

use beadwork_base::Interrupted;

use crate::mesh::Mesh;
use crate::work::Work;

/// All half-edges of a mesh, grouped by the edge that they belong to.
///
/// A half-edge is one side of a triangle, in the direction in which the triangle uses it.
/// Its number is three times the triangle, plus the corner at which it starts.
///
/// Stored as adjacency lists in one array: the half-edges whose lower vertex is `v` are
/// `entries[starts[v]..starts[v + 1]]`, sorted by their higher vertex.
pub(super) struct Edges {
    starts: Vec<u32>,
    /// The higher vertex, and the half-edge.
    entries: Vec<[u32; 2]>,
}

impl Edges {
    /// Groups the half-edges by counting sort over their lower vertices.
    pub(super) fn new(mesh: &Mesh, work: &mut Work<'_>) -> Result<Self, Interrupted> {
        let mut starts = vec![0_u32; mesh.vertices().len() + 1];
        for &corners in mesh.triangles() {
            work.poll(1)?;
            for corner in 0..3 {
                let [low, _] = ends(corners, corner);
                starts[low as usize + 1] += 1;
            }
        }
        for vertex in 1..starts.len() {
            starts[vertex] += starts[vertex - 1];
        }
        let mut entries = vec![[0; 2]; 3 * mesh.triangles().len()];
        for (triangle, &corners) in mesh.triangles().iter().enumerate() {
            work.tick(triangle)?;
            for corner in 0..3 {
                let [low, high] = ends(corners, corner);
                let start = &mut starts[low as usize];
                entries[*start as usize] = [high, (3 * triangle + corner) as u32];
                *start += 1;
            }
        }
        // Filling has advanced each start to the start of the next vertex.
        starts.rotate_right(1);
        starts[0] = 0;
        for vertex in 0..starts.len() - 1 {
            let list = starts[vertex] as usize..starts[vertex + 1] as usize;
            work.poll(list.len())?;
            entries[list].sort_unstable();
        }
        Ok(Self { starts, entries })
    }

    /// Number of half-edges.
    pub(super) fn len(&self) -> usize {
        self.entries.len()
    }

    /// The edges, each as its lower vertex and its half-edges; these are pairs of the higher
    /// vertex, equal for all of them, and the number of the half-edge.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, &[[u32; 2]])> {
        let of_vertex = |vertex: usize| {
            &self.entries[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
        };
        (0..self.starts.len() - 1).flat_map(move |vertex| {
            of_vertex(vertex).chunk_by(|a, b| a[0] == b[0]).map(move |edge| (vertex as u32, edge))
        })
    }
}

/// An edge at which an odd number of triangles meet: the surface is open there, whichever side its
/// triangles face.
#[derive(Clone, Copy)]
pub(super) struct OddEdge {
    /// The lower and the higher vertex.
    pub(super) vertices: [u32; 2],
    /// One of its half-edges.
    pub(super) half_edge: u32,
}

impl Edges {
    /// All edges at which an odd number of triangles meet.
    pub(super) fn odd(&self, work: &mut Work<'_>) -> Result<Vec<OddEdge>, Interrupted> {
        let mut odd = Vec::new();
        for (low, edge) in self.iter() {
            work.poll(edge.len())?;
            if edge.len() % 2 == 1 {
                let [high, half_edge] = edge[edge.len() - 1];
                odd.push(OddEdge { vertices: [low, high], half_edge });
            }
        }
        Ok(odd)
    }
}

/// The lower and the higher vertex of the half-edge that starts at a corner.
fn ends(corners: [u32; 3], corner: usize) -> [u32; 2] {
    let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
    [a.min(b), a.max(b)]
}

/// Whether a half-edge runs from the lower to the higher vertex.
pub(super) fn is_rising(mesh: &Mesh, half_edge: u32) -> bool {
    let corners = mesh.triangles()[half_edge as usize / 3];
    let corner = half_edge as usize % 3;
    corners[corner] < corners[(corner + 1) % 3]
}
