//! Which voxels are deposited, and which of their faces are covered.

use crate::aligned::LINE_LEN;
use crate::block_grid::BlockGrid;
use crate::coefficients::{Coefficients, VoxelCoefficients, face};
use crate::line_code::LineCode;
use crate::shape::Shape;

/// New coefficients of one voxel after a birth: those of the new voxel itself, or of a neighbour
/// whose face it covers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VoxelChange {
    /// x, y and z in the part's patch, with the halo counted.
    pub(crate) position: [usize; 3],
    pub(crate) voxel: VoxelCoefficients,
    /// Code of the cache line in which the voxel lies.
    pub(crate) line: LineCode,
    /// Whether this is the new voxel.
    pub(crate) born: bool,
}

/// The covered faces of all voxels of the part, in the flat order of its patch.
#[derive(Clone, Debug)]
pub(crate) struct Occupancy {
    shape: Shape,
    faces: Vec<u8>,
    /// Numbers of deposited voxels and of their faces in each block.
    block_grid: BlockGrid,
    /// Substrate temperature of each voxel: θ of the voxel below just before this one was deposited
    /// on it, K; NaN without one.
    substrate_theta: Vec<f32>,
}

impl Occupancy {
    /// Occupancy of a part of which nothing is printed yet.
    pub(crate) fn unprinted(shape: Shape, coefficients: &Coefficients) -> Self {
        let len = shape.len();
        // Conductances are inverse squares of lengths.
        let width_by_height = f64::from(coefficients.vertical / coefficients.lateral).sqrt();
        Self {
            shape,
            faces: vec![0; len],
            block_grid: BlockGrid::unprinted(shape, width_by_height),
            substrate_theta: vec![f32::NAN; len],
        }
    }

    /// Numbers of deposited voxels and of their faces in each block.
    pub(crate) fn block_grid(&self) -> &BlockGrid {
        &self.block_grid
    }

    /// Whether the voxel at a flat index is deposited.
    pub(crate) fn is_active(&self, index: usize) -> bool {
        self.faces[index] & face::ACTIVE != 0
    }

    /// Substrate temperature of a voxel: θ of the voxel below just before this one was deposited on
    /// it, K; NaN if there was none.
    pub(crate) fn substrate_theta(&self, index: usize) -> f32 {
        self.substrate_theta[index]
    }

    /// The [`face`] bits of all voxels, by flat index.
    pub(crate) fn faces(&self) -> &[u8] {
        &self.faces
    }

    /// Activates a voxel and appends all changes that follow: the voxel itself first, then its
    /// active neighbours.
    ///
    /// `below` is θ of the voxel below, which is recorded as substrate temperature if that voxel is
    /// active.
    pub(crate) fn birth(
        &mut self,
        position: [usize; 3],
        below: f32,
        coefficients: &Coefficients,
        changes: &mut Vec<VoxelChange>,
    ) {
        let [x, y, z] = position;
        let index = self.shape.index(position);
        let [left, right, back, front] = face::SIDES;
        // For each neighbour: the face of the new voxel towards it, its own face towards the new
        // voxel, and its position.
        // They come in pairs for each axis, the lower neighbour first.
        let neighbours = [
            (left, right, [x - 1, y, z]),
            (right, left, [x + 1, y, z]),
            (back, front, [x, y - 1, z]),
            (front, back, [x, y + 1, z]),
            (face::BELOW, face::ABOVE, [x, y, z - 1]),
            (face::ABOVE, face::BELOW, [x, y, z + 1]),
        ];
        if self.is_active(self.shape.index([x, y, z - 1])) {
            self.substrate_theta[index] = below;
        }
        let mut faces = face::ACTIVE;
        if z == 1 {
            faces |= face::PLATE;
        }
        for (own_face, their_face, neighbour) in neighbours {
            let other = &mut self.faces[self.shape.index(neighbour)];
            if *other & face::ACTIVE != 0 {
                *other |= their_face;
                faces |= own_face;
            }
        }
        self.faces[index] = faces;
        let active =
            neighbours.iter().enumerate().filter(|(_, (own_face, ..))| faces & own_face != 0);
        self.block_grid.birth(position, active.clone().map(|(i, _)| (i / 2, i % 2 == 1)));
        changes.push(self.change(position, coefficients, true));
        changes.extend(
            active.map(|(_, &(_, _, neighbour))| self.change(neighbour, coefficients, false)),
        );
    }

    /// The change that follows from the present [`face`] bits of a voxel.
    fn change(&self, position: [usize; 3], coefficients: &Coefficients, born: bool) -> VoxelChange {
        let index = self.shape.index(position);
        let line = self.faces[index / LINE_LEN * LINE_LEN..]
            .first_chunk()
            .expect("patches consist of whole lines");
        VoxelChange {
            position,
            voxel: coefficients.by_faces[usize::from(self.faces[index])],
            line: LineCode::from_faces(*line),
            born,
        }
    }
}
