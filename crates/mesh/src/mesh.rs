//! Triangle meshes.

use std::collections::HashMap;

use ndarray::ArrayView2;
use thiserror::Error;

use crate::bounds::Bounds;
use crate::vector::{cross, dot, minus, tetrahedron_mm3};

/// Triangles that share vertices, in mm.
///
/// Invariant: every coordinate is finite and every triangle refers to existing vertices.
///
/// Seen from outside the body, the vertices of a triangle run counter-clockwise.
/// That, and that the surface is closed, is ensured by [`Body::repair`](crate::Body::repair).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// Why vertices and triangles are not a valid [`Mesh`].
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// A coordinate is infinite or NaN.
    #[error("vertex {vertex}: coordinate {value} is not finite")]
    NotFinite {
        /// Number of the vertex, from 0.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle}: vertex {vertex} does not exist, mesh has {vertices}")]
    NoVertex {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// The vertex it refers to.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// An array does not have three columns.
    #[error("array of {array} has {columns} columns, expected 3")]
    Columns {
        /// "vertices" or "triangles".
        array: &'static str,
        /// Number of columns.
        columns: usize,
    },
}

impl Mesh {
    /// Creates a mesh from vertices in mm, and triangles that refer to them by number, from 0.
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

    /// Creates a mesh from arrays: vertices `[n, 3]` in mm, and triangles `[m, 3]` that refer to
    /// them by number, from 0.
    pub fn from_arrays(
        vertices: ArrayView2<'_, f64>,
        triangles: ArrayView2<'_, u32>,
    ) -> Result<Self, MeshError> {
        Self::new(rows("vertices", vertices)?, rows("triangles", triangles)?)
    }

    /// A mesh of those vertices that the triangles use, in the order of their first use.
    ///
    /// # Panics
    /// If a used vertex does not exist or is not finite.
    pub(crate) fn of_used_vertices(vertices: &[[f64; 3]], mut triangles: Vec<[u32; 3]>) -> Self {
        let mut number_of = HashMap::new();
        let mut used = Vec::new();
        for vertex in triangles.iter_mut().flatten() {
            *vertex = *number_of.entry(*vertex).or_insert_with_key(|&old| {
                used.push(vertices[old as usize]);
                used.len() as u32 - 1
            });
        }
        Self::new(used, triangles).expect("the vertices are finite, and the triangles use them")
    }

    /// The vertices: x, y and z in mm.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// The triangles: numbers of three vertices each.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The vertices as an array `[n, 3]`: one row per vertex, columns x, y and z in mm.
    pub fn vertex_array(&self) -> ArrayView2<'_, f64> {
        ArrayView2::from(&self.vertices[..])
    }

    /// The triangles as an array `[m, 3]`: one row per triangle, numbers of vertices.
    pub fn triangle_array(&self) -> ArrayView2<'_, u32> {
        ArrayView2::from(&self.triangles[..])
    }

    /// The corners of a triangle, in mm.
    ///
    /// # Panics
    /// If a vertex does not exist.
    pub fn corners(&self, triangle: [u32; 3]) -> [[f64; 3]; 3] {
        triangle.map(|vertex| self.vertices[vertex as usize])
    }

    /// The smallest box around all vertices that belong to a triangle.
    /// Linear in the triangles.
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for &vertex in self.triangles.iter().flatten() {
            bounds.add(self.vertices[vertex as usize]);
        }
        bounds
    }

    /// The enclosed volume in mm³, negative if the surface is inside out.
    /// Meaningless if the surface has holes.
    /// Linear in the triangles.
    pub fn volume_mm3(&self) -> f64 {
        // Relative to a point of the body rather than to a distant origin: otherwise the volume
        // would be the small difference of large numbers.
        let Some(&[first, ..]) = self.triangles.first() else { return 0.0 };
        let origin = self.vertices[first as usize];
        let volume = |&triangle: &[u32; 3]| {
            tetrahedron_mm3(self.corners(triangle).map(|corner| minus(corner, origin)))
        };
        self.triangles.iter().map(volume).sum()
    }

    /// Area of all triangles in mm².
    /// Linear in the triangles.
    pub fn surface_mm2(&self) -> f64 {
        let doubled = |&triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(triangle);
            let normal = cross(minus(b, a), minus(c, a));
            dot(normal, normal).sqrt()
        };
        self.triangles.iter().map(doubled).sum::<f64>() / 2.0
    }

    /// Memory of vertices and triangles in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.vertices) + size_of_val(&*self.triangles)
    }

    /// Moves every vertex to `map(vertex)`, in mm; the results must be finite.
    /// Set `mirrored` if the map is a reflection: then triangles are reversed to keep facing
    /// outwards.
    pub fn map_vertices(&mut self, map: impl Fn([f64; 3]) -> [f64; 3], mirrored: bool) {
        self.vertices.iter_mut().for_each(|vertex| *vertex = map(*vertex));
        if mirrored {
            self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
    }

    /// Whether all coordinates are still finite after [`Mesh::map_vertices`].
    pub(crate) fn is_finite(&self) -> bool {
        self.vertices.iter().flatten().all(|value| value.is_finite())
    }

    /// Mutable access; the caller keeps up the invariant.
    pub(crate) fn parts_mut(&mut self) -> (&mut Vec<[f64; 3]>, &mut Vec<[u32; 3]>) {
        (&mut self.vertices, &mut self.triangles)
    }
}

/// Copies the rows of an array of three columns.
fn rows<T: Copy>(name: &'static str, array: ArrayView2<'_, T>) -> Result<Vec<[T; 3]>, MeshError> {
    match array.ncols() {
        3 => Ok(array.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect()),
        columns => Err(MeshError::Columns { array: name, columns }),
    }
}

/// Removes the vertices that no triangle uses, if there are more vertices than triangles can use.
/// This bounds the memory of a mesh by its triangles, however often it is copied.
///
/// Changes nothing if a triangle refers to a vertex that does not exist.
pub(crate) fn drop_unused_vertices(vertices: &mut Vec<[f64; 3]>, triangles: &mut [[u32; 3]]) {
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

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use super::*;
    use crate::solid::Solid;

    #[test]
    fn invalid_meshes_are_refused() {
        let vertices = vec![[0.0; 3], [1.0, 0.0, f64::NAN]];
        assert!(matches!(Mesh::new(vertices, vec![]), Err(MeshError::NotFinite { vertex: 1, .. })));
        let error = Mesh::new(vec![[0.0; 3]; 2], vec![[0, 1, 2]]);
        assert_eq!(error, Err(MeshError::NoVertex { triangle: 0, vertex: 2, vertices: 2 }));
    }

    #[test]
    fn volume_size_and_memory_of_a_box() {
        let mesh = Solid::Cuboid { size_mm: [2.0, 3.0, 4.0] }.mesh();
        assert!((mesh.volume_mm3() - 24.0).abs() < 1e-12);
        assert_eq!(mesh.bounds().size_mm(), [2.0, 3.0, 4.0]);
        assert!((mesh.surface_mm2() - 52.0).abs() < 1e-12);
        assert_eq!(mesh.memory_bytes(), 8 * 24 + 12 * 12);
    }

    #[test]
    fn arrays_hold_one_vertex_or_triangle_per_row() {
        let mesh = Solid::Cuboid { size_mm: [2.0, 3.0, 4.0] }.mesh();
        assert_eq!((mesh.vertex_array().dim(), mesh.triangle_array().dim()), ((8, 3), (12, 3)));
        assert_eq!(mesh.vertex_array().row(6), array![2.0, 3.0, 4.0]);
        assert_eq!(Mesh::from_arrays(mesh.vertex_array(), mesh.triangle_array()), Ok(mesh.clone()));
        // Any memory layout will do.
        let columns = mesh.vertex_array().t().as_standard_layout().into_owned();
        assert_eq!(Mesh::from_arrays(columns.t(), mesh.triangle_array()), Ok(mesh));
        let wide = Array2::zeros((2, 4));
        let error = Mesh::from_arrays(wide.view(), Array2::zeros((1, 3)).view()).unwrap_err();
        assert_eq!(error.to_string(), "array of vertices has 4 columns, expected 3");
    }
}
