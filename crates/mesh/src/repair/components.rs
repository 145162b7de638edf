//! Connected components of triangles, and which of their triangles face the other side.

use beadwork_base::Interrupted;

use super::edges::{Edges, is_rising};
use crate::mesh::Mesh;
use crate::work::Work;

/// Disjoint sets of triangles (union-find), each set stored as a tree.
///
/// Every triangle also knows whether it faces the same side as its parent.
/// The exclusive or of these bits along the path to the root is whether it faces the same side as
/// the root.
pub(super) struct Components {
    /// The parent of each triangle; roots are their own parents.
    parents: Vec<u32>,
    /// Whether a triangle faces the other side than its parent.
    opposed: Vec<bool>,
}

impl Components {
    /// As many components as triangles.
    pub(super) fn separate(count: usize) -> Self {
        Self { parents: (0..count as u32).collect(), opposed: vec![false; count] }
    }

    /// Joins triangles at every edge of exactly two triangles.
    /// Such triangles face the same side if they use the edge in opposite directions.
    pub(super) fn new(
        mesh: &Mesh,
        edges: &Edges,
        work: &mut Work<'_>,
    ) -> Result<Self, Interrupted> {
        let mut components = Self::separate(mesh.triangles().len());
        work.set_items(edges.len());
        let mut done = 0;
        for (_, edge) in edges.iter() {
            work.tick(done)?;
            done += edge.len();
            let &[[_, first], [_, second]] = edge else { continue };
            let opposed = is_rising(mesh, first) == is_rising(mesh, second);
            components.join(first / 3, second / 3, opposed);
        }
        Ok(components)
    }

    /// The root of a triangle's component, and whether the triangle faces the other side than it.
    pub(super) fn find(&mut self, triangle: u32) -> (u32, bool) {
        let mut root = triangle;
        let mut opposed = false;
        while self.parents[root as usize] != root {
            opposed ^= self.opposed[root as usize];
            root = self.parents[root as usize];
        }
        // Path compression: all triangles on the path become children of the root.
        let (mut current, mut to_root) = (triangle, opposed);
        while self.parents[current as usize] != root && current != root {
            let (parent, to_parent) =
                (self.parents[current as usize], self.opposed[current as usize]);
            (self.parents[current as usize], self.opposed[current as usize]) = (root, to_root);
            to_root ^= to_parent;
            current = parent;
        }
        (root, opposed)
    }

    /// Joins the components of two triangles, which face opposite sides if `opposed`.
    ///
    /// Does nothing if they are in one component already, even if they contradict it: a Moebius
    /// strip cannot face one side everywhere, so triangles disagree along some line across it.
    pub(super) fn join(&mut self, first: u32, second: u32, opposed: bool) {
        let ((a, a_opposed), (b, b_opposed)) = (self.find(first), self.find(second));
        let (low, high) = (a.min(b), a.max(b));
        if low != high {
            self.parents[high as usize] = low;
            self.opposed[high as usize] = a_opposed ^ b_opposed ^ opposed;
        }
    }

    /// Joins triangles at edges of any number of triangles.
    /// From then on only the roots are meaningful, not which side triangles face.
    pub(super) fn join_all(
        &mut self,
        edges: &Edges,
        work: &mut Work<'_>,
    ) -> Result<(), Interrupted> {
        for (_, edge) in edges.iter() {
            work.poll(1)?;
            for pair in edge.windows(2) {
                self.join(pair[0][1] / 3, pair[1][1] / 3, false);
            }
        }
        Ok(())
    }

    /// Adds a triangle to the component of another one.
    pub(super) fn push(&mut self, neighbour: u32) {
        let (root, _) = self.find(neighbour);
        self.parents.push(root);
        self.opposed.push(false);
    }

    /// Makes all triangles of each component face the same side, by flipping the minority of them;
    /// returns how many are flipped.
    pub(super) fn flip_minorities(&mut self, mesh: &mut Mesh) -> usize {
        let count = self.parents.len() as u32;
        if self.opposed.iter().all(|&opposed| !opposed) {
            return 0;
        }
        // For each root, triangles that face its side minus triangles that face the other.
        let mut balance = vec![0_i32; count as usize];
        for triangle in 0..count {
            let (root, opposed) = self.find(triangle);
            balance[root as usize] += if opposed { -1 } else { 1 };
        }
        let (_, triangles) = mesh.parts_mut();
        let mut flipped = 0;
        for triangle in 0..count {
            let (root, opposed) = self.find(triangle);
            if opposed == (balance[root as usize] >= 0) {
                triangles[triangle as usize].swap(1, 2);
                flipped += 1;
            }
        }
        flipped
    }
}
