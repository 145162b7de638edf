//! Which voxels are active, and which of their faces are covered.

use crate::aligned::LINE;
use crate::law::{Law, Voxel, face};
use crate::patch::{Line, Shape};
use crate::tally::Tally;

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
    /// The same in blocks.
    tally: Tally,
    /// Temperature above the air of what a voxel was laid on, just before it was; NaN where that was nothing.
    landings: Vec<f32>,
}

impl Occupancy {
    /// Nothing is active.
    pub(crate) fn none(shape: Shape, law: &Law) -> Self {
        let len = shape.len();
        let tally = Tally::none(shape, f64::from(law.vertical / law.lateral).sqrt());
        Self {
            shape,
            faces: vec![0; len],
            interior: vec![0; len / LINE],
            tally,
            landings: vec![f32::NAN; len],
        }
    }

    /// What is active, in blocks.
    pub(crate) fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Whether a voxel is active.
    pub(crate) fn is_active(&self, index: usize) -> bool {
        self.faces[index] & face::ACTIVE != 0
    }

    /// Temperature above the air of the voxel below, just before this one was laid on it; NaN if there was none.
    pub(crate) fn landing(&self, index: usize) -> f32 {
        self.landings[index]
    }

    /// The faces of all voxels, each a set of the bits of [`face`].
    pub(crate) fn faces(&self) -> &[u8] {
        &self.faces
    }

    /// Makes a voxel active and tells what changes by it: the voxel itself first, then its active neighbours. What lies
    /// below has the temperature `below` above the air.
    pub(crate) fn birth(&mut self, at: [usize; 3], below: f32, law: &Law, changes: &mut Vec<Change>) {
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
        if self.is_active(self.shape.index([x, y, z - 1])) {
            self.landings[index] = below;
        }
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
        let active = neighbours.iter().enumerate().filter(|(_, (towards, _, _))| faces & towards != 0);
        self.tally.birth(at, active.map(|(place, _)| (place / 2, place % 2 == 1)));
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
