//! A surface of triangles that share their vertices.

use std::hash::{DefaultHasher, Hash, Hasher};

use hashbrown::HashTable;
use thiserror::Error;

/// Triangles over shared vertices, in mm.
///
/// Invariant: every coordinate is finite and every index names a vertex.
/// Seen from outside the body, the vertices of a triangle run counter-clockwise;
/// [`Body::repair`](super::Body::repair) sees to that, and that the surface is closed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// Why vertices and triangles make no [`Mesh`].
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// A coordinate is not a number, or infinite.
    #[error("vertex {vertex} has the coordinate {value}")]
    NotFinite {
        /// Number of the vertex, from 0.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} has the vertex {vertex}, of {vertices}")]
    NoVertex {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// The number it names.
        vertex: u32,
        /// Vertices that there are.
        vertices: usize,
    },
}

/// The smallest box around something, in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least x, y and z.
    pub min: [f64; 3],
    /// Greatest x, y and z.
    pub max: [f64; 3],
}

impl Bounds {
    /// Around no point: every point widens it.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// Widens the box to hold a point.
    pub fn add(&mut self, point: [f64; 3]) {
        self.merge(&Self { min: point, max: point });
    }

    /// Widens the box to hold another.
    pub fn merge(&mut self, other: &Self) {
        self.min = [0, 1, 2].map(|axis| self.min[axis].min(other.min[axis]));
        self.max = [0, 1, 2].map(|axis| self.max[axis].max(other.max[axis]));
    }

    /// Lengths of its sides in mm; negative only around no point.
    pub fn size_mm(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.max[axis] - self.min[axis])
    }

    /// Length of its diagonal in mm.
    pub fn diagonal_mm(&self) -> f64 {
        self.size_mm().map(|side| side * side).iter().sum::<f64>().sqrt()
    }

    /// Whether a point lies in it or on its sides.
    pub fn contains(&self, point: [f64; 3]) -> bool {
        (0..3).all(|axis| (self.min[axis]..=self.max[axis]).contains(&point[axis]))
    }
}

impl Mesh {
    /// A mesh of vertices in mm and triangles that name them from 0.
    pub fn new(vertices: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        for (vertex, point) in vertices.iter().enumerate() {
            if let Some(&value) = point.iter().find(|value| !value.is_finite()) {
                return Err(MeshError::NotFinite { vertex, value });
            }
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= vertices.len())
            {
                return Err(MeshError::NoVertex { triangle, vertex, vertices: vertices.len() });
            }
        }
        Ok(Self { vertices, triangles })
    }

    /// Whether a move has left all coordinates finite.
    pub(super) fn is_finite(&self) -> bool {
        self.vertices.iter().flatten().all(|value| value.is_finite())
    }

    /// The vertices: x, y and z in mm.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// The triangles: three numbers of vertices each.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: [u32; 3]) -> [[f64; 3]; 3] {
        triangle.map(|vertex| self.vertices[vertex as usize])
    }

    /// The smallest box around all vertices that belong to a triangle.
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for &vertex in self.triangles.iter().flatten() {
            bounds.add(self.vertices[vertex as usize]);
        }
        bounds
    }

    /// The volume it encloses in mm³, negative if it is turned inside out.
    /// Meaningless for a surface with holes.
    pub fn volume_mm3(&self) -> f64 {
        // Seen from a point of the body, it is no difference of large numbers.
        let Some(&[first, ..]) = self.triangles.first() else { return 0.0 };
        let origin = self.vertices[first as usize];
        let spat = |&triangle: &[u32; 3]| {
            spat_mm3(self.corners(triangle).map(|corner| minus(corner, origin)))
        };
        self.triangles.iter().map(spat).sum()
    }

    /// Memory of its vertices and triangles, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.vertices) + size_of_val(&*self.triangles)
    }

    /// Maps every vertex, in mm; `mirrored` says that the map is a reflection, so that triangles
    /// must be turned over to keep facing outwards.
    pub fn map_vertices(&mut self, place: impl Fn([f64; 3]) -> [f64; 3], mirrored: bool) {
        self.vertices.iter_mut().for_each(|vertex| *vertex = place(*vertex));
        if mirrored {
            self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
    }

    pub(super) fn parts_mut(&mut self) -> (&mut Vec<[f64; 3]>, &mut Vec<[u32; 3]>) {
        (&mut self.vertices, &mut self.triangles)
    }
}

/// Drops the vertices that no triangle uses if they are more than those that can be used: a mesh
/// then takes no more than its triangles say, however often it is copied.
/// Changes nothing if a triangle names a vertex that is not there.
pub(super) fn keep_used(vertices: &mut Vec<[f64; 3]>, triangles: &mut [[u32; 3]]) {
    if vertices.len() <= 3 * triangles.len() {
        return;
    }
    let mut number_of = vec![u32::MAX; vertices.len()];
    for &vertex in triangles.iter().flatten() {
        match number_of.get_mut(vertex as usize) {
            Some(number) => *number = 0,
            None => return,
        }
    }
    let mut kept = 0;
    for (vertex, number) in number_of.iter_mut().enumerate().filter(|(_, number)| **number == 0) {
        vertices[kept] = vertices[vertex];
        *number = kept as u32;
        kept += 1;
    }
    vertices.truncate(kept);
    vertices.shrink_to_fit();
    triangles.iter_mut().flatten().for_each(|vertex| *vertex = number_of[*vertex as usize]);
}

/// Signed volume of the tetrahedron between a triangle and the origin, in mm³.
pub(super) fn spat_mm3([a, b, c]: [[f64; 3]; 3]) -> f64 {
    dot(a, cross(b, c)) / 6.0
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Collects triangles whose corners are given as points, each point once.
///
/// Points are one vertex if all bits of their coordinates are equal (0 and -0 too): what touches
/// belongs together, and nothing is moved.
#[derive(Default)]
pub(super) struct Welder {
    /// Numbers of vertices by the hash of their coordinates, which stand in `vertices` alone: as
    /// keys they would take more memory than the mesh.
    numbers: HashTable<u32>,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

fn hash(point: [f64; 3]) -> u64 {
    let mut hasher = DefaultHasher::new();
    point.map(f64::to_bits).hash(&mut hasher);
    hasher.finish()
}

impl Welder {
    /// For so many triangles.
    pub(super) fn with_capacity(triangles: usize) -> Self {
        Self { triangles: Vec::with_capacity(triangles), ..Self::default() }
    }

    /// The number of a point.
    pub(super) fn vertex(&mut self, point: [f64; 3]) -> u32 {
        // Adding 0 makes -0 the same as 0.
        let point = point.map(|value| value + 0.0);
        let Self { numbers, vertices, .. } = self;
        let bits = |point: [f64; 3]| point.map(f64::to_bits);
        let is_it = |&number: &u32| bits(vertices[number as usize]) == bits(point);
        if let Some(&number) = numbers.find(hash(point), is_it) {
            return number;
        }
        let number = vertices.len() as u32;
        vertices.push(point);
        numbers.insert_unique(hash(point), number, |&number| hash(vertices[number as usize]));
        number
    }

    pub(super) fn triangle(&mut self, corners: [[f64; 3]; 3]) {
        let triangle = corners.map(|corner| self.vertex(corner));
        self.triangles.push(triangle);
    }

    pub(super) fn len(&self) -> usize {
        self.triangles.len()
    }

    pub(super) fn mesh(self) -> Result<Mesh, MeshError> {
        drop(self.numbers);
        Mesh::new(self.vertices, self.triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Solid;

    #[test]
    fn wrong_numbers_are_refused() {
        let vertices = vec![[0.0; 3], [1.0, 0.0, f64::NAN]];
        assert!(matches!(Mesh::new(vertices, vec![]), Err(MeshError::NotFinite { vertex: 1, .. })));
        let error = Mesh::new(vec![[0.0; 3]; 2], vec![[0, 1, 2]]);
        assert_eq!(error, Err(MeshError::NoVertex { triangle: 0, vertex: 2, vertices: 2 }));
    }

    #[test]
    fn a_box_has_its_volume_and_size() {
        let mesh = Solid::Cuboid { size_mm: [2.0, 3.0, 4.0] }.mesh();
        assert!((mesh.volume_mm3() - 24.0).abs() < 1e-12);
        assert_eq!(mesh.bounds().size_mm(), [2.0, 3.0, 4.0]);
        assert_eq!(mesh.memory_bytes(), 8 * 24 + 12 * 12);
    }

    #[test]
    fn touching_corners_are_one_vertex() {
        let mut welder = Welder::default();
        welder.triangle([[0.0, -0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        welder.triangle([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let mesh = welder.mesh().unwrap();
        assert_eq!((mesh.vertices().len(), mesh.triangles()), (4, &[[0, 1, 2], [0, 2, 3]][..]));
    }
}
