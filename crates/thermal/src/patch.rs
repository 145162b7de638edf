//! Patches: boxes of voxels in flat arrays, the unit on which all sweeps work.

use std::ops::Range;

use crate::aligned::{AlignedBuffer, LINE_LEN};
use crate::coefficients::{Coefficients, VoxelCoefficients};
use crate::interval::Interval;
use crate::line_code::LineCode;
use crate::occupancy::VoxelChange;
use crate::shape::Shape;

/// The coefficients of all voxels of a patch, as one array for each field of [`VoxelCoefficients`].
#[derive(Clone, Debug, Default)]
pub(crate) struct CoefficientArrays {
    pub(crate) diagonal: AlignedBuffer,
    pub(crate) exposed_area: AlignedBuffer,
    /// Empty unless surfaces have a resistance.
    pub(crate) top_bottom_area: AlignedBuffer,
    /// One code for each cache line of the other arrays.
    pub(crate) lines: Vec<LineCode>,
}

impl CoefficientArrays {
    /// Arrays without any active voxel.
    pub(crate) fn inactive(shape: Shape, resistance: bool) -> Self {
        let len = shape.len();
        Self {
            diagonal: AlignedBuffer::zeros(len),
            exposed_area: AlignedBuffer::zeros(len),
            top_bottom_area: AlignedBuffer::zeros(if resistance { len } else { 0 }),
            lines: vec![LineCode::EMPTY; len / LINE_LEN],
        }
    }

    /// Sets the coefficients of one voxel, and the code of its line.
    pub(crate) fn set(&mut self, index: usize, voxel: VoxelCoefficients, line: LineCode) {
        self.diagonal[index] = voxel.diagonal;
        self.exposed_area[index] = voxel.exposed_area;
        if let Some(area) = self.top_bottom_area.get_mut(index) {
            *area = voxel.top_bottom_area;
        }
        self.lines[index / LINE_LEN] = line;
    }
}

/// A box of voxels with temperatures and coefficients: the whole part, or a window into it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    pub(crate) shape: Shape,
    /// x, y and z of the first element, in the patch of the whole part; x is a multiple of
    /// [`LINE_LEN`].
    pub(crate) origin: [usize; 3],
    pub(crate) arrays: CoefficientArrays,
    /// Temperatures above the air, K. Invariant: 0 where no voxel is active, except in the halo.
    pub(crate) theta: AlignedBuffer,
}

impl Patch {
    /// The patch of a whole part of which nothing is printed yet.
    pub(crate) fn unprinted(shape: Shape, coefficients: &Coefficients) -> Self {
        let mut theta = AlignedBuffer::zeros(shape.len());
        // Row 0 of each plane holds the ghosts of the build plate.
        theta
            .chunks_exact_mut(shape.plane_len())
            .for_each(|plane| plane[..shape.row_len].fill(coefficients.plate_ghost));
        Self {
            shape,
            origin: [0; 3],
            arrays: CoefficientArrays::inactive(shape, coefficients.resistance.is_some()),
            theta,
        }
    }

    /// Flat index in this patch of a voxel given by its position in the part's patch; `None` if it
    /// lies outside this patch or in its halo.
    pub(crate) fn index(&self, position: [usize; 3]) -> Option<usize> {
        let local = [0, 1, 2].map(|axis: usize| position[axis].wrapping_sub(self.origin[axis]));
        let sizes = self.shape.sizes();
        // A position before the origin wraps around to a large number and fails the test as well.
        let inside = |axis: usize| local[axis].wrapping_sub(1) < sizes[axis] - 2;
        (inside(0) && inside(1) && inside(2)).then(|| self.shape.index(local))
    }

    /// Range, along an axis, of this patch's voxels that belong to a block of the part, which is
    /// `block_len` voxels long.
    /// Blocks count from 1, for their grid has a halo too.
    pub(crate) fn block_range(&self, axis: usize, block: usize, block_len: usize) -> Range<usize> {
        let first = (block - 1) * block_len + 1 - self.origin[axis];
        first..(first + block_len).min(self.shape.sizes()[axis] - 1)
    }

    /// Adds to a new voxel the heat that it would conduct to its neighbours while the nozzle holds
    /// it, if it is not held: to the voxel below, and to one or two neighbours in the layer (1.5 on
    /// average).
    ///
    /// The temperature of the voxel below stands for all of them.
    ///
    /// # Panics
    /// If the patch does not contain the voxel.
    pub(crate) fn add_held_heat(&mut self, birth: &Interval, coefficients: &Coefficients) {
        let Some(position) = birth.held else { return };
        let index = self.index(position).expect("a window contains all births of its steps");
        let below = self.theta[index - self.shape.row_len];
        let conductance = coefficients.vertical + 1.5 * coefficients.lateral;
        let share = conductance * birth.seconds as f32;
        self.theta[index] += share * (coefficients.birth_theta - below).max(0.0);
    }

    /// Applies changes that births made to coefficients, and sets the temperature of new voxels.
    /// Voxels outside this patch are skipped.
    pub(crate) fn apply(&mut self, changes: &[VoxelChange], coefficients: &Coefficients) {
        let last_line = self.shape.row_len - LINE_LEN;
        for change in changes {
            let Some(index) = self.index(change.position) else { continue };
            // The first and last element of a row are halo in this patch, whatever they are in the
            // part, so the lines at both ends are never uniform.
            let x = change.position[0] - self.origin[0];
            let at_row_end = x < LINE_LEN || x >= last_line;
            let line = if at_row_end { change.line.not_uniform() } else { change.line };
            self.arrays.set(index, change.voxel, line);
            if change.born {
                self.theta[index] = coefficients.birth_theta;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::line_code::LineKind;
    use crate::material::ThermalMaterial;
    use crate::occupancy::Occupancy;
    use crate::process::ProcessParameters;

    #[test]
    fn changes_keep_lines_and_coefficients_consistent_with_faces() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        let coefficients = Coefficients::new(
            &ThermalMaterial::abs(),
            &ProcessParameters::default(),
            0.5e-3,
            0.25e-3,
        );
        let mut uniform = 0;
        for _ in 0..300 {
            let size = [90, 6, 6].map(|max| random.random_range(1..max));
            let shape = Shape::with_halo(size[0], size[1], size[2]);
            let (mut occupancy, mut patch) = (
                Occupancy::unprinted(shape, &coefficients),
                Patch::unprinted(shape, &coefficients),
            );
            let filled = if random.random_bool(0.5) { 1.0 } else { 0.9 };
            let mut changes = Vec::new();
            for z in 1..=size[2] {
                for y in 1..=size[1] {
                    for x in (1..=size[0]).filter(|_| random.random_bool(filled)) {
                        occupancy.birth([x, y, z], 0.0, &coefficients, &mut changes);
                    }
                }
                // Changes of many births may be applied together.
                patch.apply(&changes, &coefficients);
                changes.clear();
            }
            for (i, &faces) in occupancy.faces().iter().enumerate() {
                let expected = coefficients.by_faces[usize::from(faces)].diagonal;
                assert_eq!(patch.arrays.diagonal[i].to_bits(), expected.to_bits());
            }
            let lines = shape.row_len / LINE_LEN;
            for (i, (faces, &line)) in
                occupancy.faces().chunks_exact(LINE_LEN).zip(&patch.arrays.lines).enumerate()
            {
                let expected = LineCode::from_faces(*faces.first_chunk().unwrap());
                let row_end = [0, lines - 1].contains(&(i % lines));
                assert_eq!(line, if row_end { expected.not_uniform() } else { expected });
                uniform += u32::from(matches!(line.kind(), LineKind::Uniform(_)));
            }
        }
        assert!(uniform > 500, "{uniform} lines are uniform");
    }
}
