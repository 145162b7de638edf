//! Which voxels are active, and which of their faces are covered.

use crate::aligned::LINE;
use crate::law::{Law, Voxel, face};
use crate::patch::{Line, Shape};

/// A voxel whose numbers a birth has changed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    /// x, y and z, rim counted.
    pub(crate) at: [usize; 3],
    pub(crate) voxel: Voxel,
    pub(crate) line: Line,
    /// Whether it is the one that was born.
    pub(crate) born: bool,
}

/// The faces of all voxels, in the flat order of the part's patch.
#[derive(Clone, Debug)]
pub(crate) struct Occupancy {
    shape: Shape,
    faces: Vec<u8>,
    /// Interior voxels in each cache line.
    interior: Vec<u8>,
}

impl Occupancy {
    pub(crate) fn none(shape: Shape) -> Self {
        Self { shape, faces: vec![0; shape.len()], interior: vec![0; shape.len() / LINE] }
    }

    /// Whether a voxel is active.
    pub(crate) fn is_active(&self, index: usize) -> bool {
        self.faces[index] & face::ACTIVE != 0
    }

    /// The faces of all voxels, each a set of the bits of [`face`].
    pub(crate) fn faces(&self) -> &[u8] {
        &self.faces
    }

    /// Makes a voxel active and tells what changes by it: the voxel itself first, then its active neighbours.
    pub(crate) fn birth(&mut self, at: [usize; 3], law: &Law, changes: &mut Vec<Change>) {
        let [x, y, z] = at;
        let index = self.shape.index(at);
        let [left, right, back, front] = face::SIDES;
        let neighbours = [
            (left, right, [x - 1, y, z]),
            (right, left, [x + 1, y, z]),
            (back, front, [x, y - 1, z]),
            (front, back, [x, y + 1, z]),
            (face::BELOW, face::ABOVE, [x, y, z - 1]),
            (face::ABOVE, face::BELOW, [x, y, z + 1]),
        ];
        let own = changes.len();
        changes.push(Change { at, voxel: Voxel::default(), line: Line::Mixed, born: true });
        let mut faces = face::ACTIVE;
        if z == 1 {
            faces |= face::PLATE;
        }
        for (towards, from, neighbour) in neighbours {
            let other = self.shape.index(neighbour);
            if !self.is_active(other) {
                continue;
            }
            faces |= towards;
            self.faces[other] |= from;
            changes.push(self.settle(neighbour, other, law));
        }
        self.faces[index] = faces;
        changes[own] = Change { born: true, ..self.settle(at, index, law) };
    }

    /// The numbers of a voxel whose faces have changed.
    fn settle(&mut self, at: [usize; 3], index: usize, law: &Law) -> Change {
        let faces = self.faces[index];
        let inside = &mut self.interior[index / LINE];
        // Faces are covered one by one, so this is met once, with the last.
        *inside += u8::from(faces == face::ALL | face::ACTIVE);
        let line = if usize::from(*inside) == LINE { Line::Interior } else { Line::Mixed };
        Change { at, voxel: law.voxels[usize::from(faces)], line, born: false }
    }
}
