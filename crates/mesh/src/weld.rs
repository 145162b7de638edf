//! Merges points with equal coordinates into one vertex.
//!
//! Points are equal if all bits of their coordinates are, except that 0 and -0 are equal too.
//! There is no tolerance: nothing moves, and no small detail collapses.

use std::hash::{DefaultHasher, Hash, Hasher};

use hashbrown::HashTable;

use crate::mesh::{Mesh, MeshError};

fn bits(point: [f64; 3]) -> [u64; 3] {
    point.map(f64::to_bits)
}

fn hash(point: [f64; 3]) -> u64 {
    let mut hasher = DefaultHasher::new();
    bits(point).hash(&mut hasher);
    hasher.finish()
}

/// Builds a mesh from triangles whose corners are given as points.
#[derive(Default)]
pub(crate) struct Welder {
    /// Numbers of vertices by the hash of their coordinates, which are in `vertices` only: as keys
    /// of a map they would take more memory than the mesh.
    table: HashTable<u32>,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Welder {
    pub(crate) fn with_capacity(triangles: usize) -> Self {
        Self { triangles: Vec::with_capacity(triangles), ..Self::default() }
    }

    pub(crate) fn add_triangle(&mut self, corners: [[f64; 3]; 3]) {
        let triangle = corners.map(|corner| self.vertex(corner));
        self.triangles.push(triangle);
    }

    /// The number of the vertex at a point, which is added if it is new.
    fn vertex(&mut self, point: [f64; 3]) -> u32 {
        // Adding 0 turns -0 into 0.
        let point = point.map(|value| value + 0.0);
        let Self { table, vertices, .. } = self;
        let is_equal = |&number: &u32| bits(vertices[number as usize]) == bits(point);
        if let Some(&number) = table.find(hash(point), is_equal) {
            return number;
        }
        let number = vertices.len() as u32;
        vertices.push(point);
        table.insert_unique(hash(point), number, |&number| hash(vertices[number as usize]));
        number
    }

    /// Number of triangles so far.
    pub(crate) fn len(&self) -> usize {
        self.triangles.len()
    }

    pub(crate) fn into_mesh(self) -> Result<Mesh, MeshError> {
        drop(self.table);
        Mesh::new(self.vertices, self.triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_at_the_same_position_become_one_vertex() {
        let mut welder = Welder::default();
        welder.add_triangle([[0.0, -0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        welder.add_triangle([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let mesh = welder.into_mesh().unwrap();
        assert_eq!((mesh.vertices().len(), mesh.triangles()), (4, &[[0, 1, 2], [0, 2, 3]][..]));
    }
}
