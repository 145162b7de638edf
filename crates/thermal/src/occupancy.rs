//! Which voxels are active, and which of their faces are covered.

use crate::aligned::LINE_LEN;
use crate::block_grid::BlockGrid;
use crate::coefficients::{Coefficients, VoxelCoefficients, face};
use crate::patch::{LineCode, Shape};

/// A voxel whose numbers a birth has changed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    /// x, y and z, halo counted.
    pub(crate) at: [usize; 3],
    pub(crate) voxel: VoxelCoefficients,
    pub(crate) line: LineCode,
    /// Whether it is the one that was born.
    pub(crate) born: bool,
}

/// The faces of all voxels, in the flat order of the part's patch.
#[derive(Clone, Debug)]
pub(crate) struct Occupancy {
    shape: Shape,
    faces: Vec<u8>,
    /// The same in blocks.
    block_grid: BlockGrid,
    /// Temperature above the air of what a voxel was laid on, just before it was; NaN where that
    /// was nothing.
    substrate_theta: Vec<f32>,
}

impl Occupancy {
    /// Nothing is active.
    pub(crate) fn none(shape: Shape, coefficients: &Coefficients) -> Self {
        let len = shape.len();
        let block_grid =
            BlockGrid::none(shape, f64::from(coefficients.vertical / coefficients.lateral).sqrt());
        Self { shape, faces: vec![0; len], block_grid, substrate_theta: vec![f32::NAN; len] }
    }

    /// What is active, in blocks.
    pub(crate) fn block_grid(&self) -> &BlockGrid {
        &self.block_grid
    }

    /// Whether a voxel is active.
    pub(crate) fn is_active(&self, index: usize) -> bool {
        self.faces[index] & face::ACTIVE != 0
    }

    /// Temperature above the air of the voxel below, just before this one was laid on it; NaN if
    /// there was none.
    pub(crate) fn substrate_theta(&self, index: usize) -> f32 {
        self.substrate_theta[index]
    }

    /// The faces of all voxels, each a set of the bits of [`face`].
    pub(crate) fn faces(&self) -> &[u8] {
        &self.faces
    }

    /// Makes a voxel active and tells what changes by it: the voxel itself first, then its active
    /// neighbours.
    /// What lies below has the temperature `below` above the air.
    pub(crate) fn birth(
        &mut self,
        at: [usize; 3],
        below: f32,
        coefficients: &Coefficients,
        changes: &mut Vec<Change>,
    ) {
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
            self.substrate_theta[index] = below;
        }
        let mut faces = face::ACTIVE;
        if z == 1 {
            faces |= face::PLATE;
        }
        for (towards, from, neighbour) in neighbours {
            let other = &mut self.faces[self.shape.index(neighbour)];
            if *other & face::ACTIVE != 0 {
                *other |= from;
                faces |= towards;
            }
        }
        self.faces[index] = faces;
        let active =
            neighbours.iter().enumerate().filter(|(_, (towards, ..))| faces & towards != 0);
        self.block_grid.birth(at, active.clone().map(|(place, _)| (place / 2, place % 2 == 1)));
        changes.push(self.change(at, coefficients, true));
        changes.extend(
            active.map(|(_, &(_, _, neighbour))| self.change(neighbour, coefficients, false)),
        );
    }

    /// The numbers of a voxel whose faces have changed.
    fn change(&self, at: [usize; 3], coefficients: &Coefficients, born: bool) -> Change {
        let index = self.shape.index(at);
        let line = self.faces[index / LINE_LEN * LINE_LEN..]
            .first_chunk()
            .expect("a patch has whole lines");
        Change {
            at,
            voxel: coefficients.by_faces[usize::from(self.faces[index])],
            line: LineCode::of(*line),
            born,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::material::ThermalMaterial;
    use crate::patch::{LineKind, Patch};
    use crate::process::ProcessParameters;

    #[test]
    fn changes_leave_every_line_and_number_as_the_faces_have_them() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        let coefficients = Coefficients::new(
            &ThermalMaterial::abs(),
            &ProcessParameters::default(),
            0.5e-3,
            0.25e-3,
        );
        let mut uniform = 0;
        for _ in 0..300 {
            let size = [90, 6, 6].map(|most| random.random_range(1..most));
            let shape = Shape::around(size[0], size[1], size[2]);
            let (mut occupancy, mut patch) =
                (Occupancy::none(shape, &coefficients), Patch::empty(shape, &coefficients));
            let filled = if random.random_bool(0.5) { 1.0 } else { 0.9 };
            let mut changes = Vec::new();
            for z in 1..=size[2] {
                for y in 1..=size[1] {
                    for x in (1..=size[0]).filter(|_| random.random_bool(filled)) {
                        occupancy.birth([x, y, z], 0.0, &coefficients, &mut changes);
                    }
                }
                // As several at once are taken up, too.
                patch.apply(&changes, &coefficients);
                changes.clear();
            }
            for (i, &faces) in occupancy.faces.iter().enumerate() {
                let known = coefficients.by_faces[usize::from(faces)].diagonal;
                assert_eq!(patch.arrays.diagonal[i].to_bits(), known.to_bits());
            }
            let lines = shape.row / LINE_LEN;
            for (i, (faces, &line)) in
                occupancy.faces.chunks_exact(LINE_LEN).zip(&patch.arrays.lines).enumerate()
            {
                let known = LineCode::of(*faces.first_chunk().unwrap());
                let end = [0, lines - 1].contains(&(i % lines));
                assert_eq!(line, if end { known.cut() } else { known });
                uniform += u32::from(matches!(line.kind(), LineKind::Uniform(_)));
            }
        }
        assert!(uniform > 500, "{uniform} lines are uniform");
    }
}
