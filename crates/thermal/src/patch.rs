//! A box of voxels, as flat arrays that can be swept from end to end.

use std::ops::Range;

use crate::aligned::{AlignedBuffer, LINE_LEN};
use crate::coefficients::{Coefficients, VoxelCoefficients, face};
use crate::occupancy::Change;

/// The sizes of a patch: `planes` planes of `rows` rows of `row` numbers.
/// Rows run along x; a plane is upright, its rows lie one above the other along z; planes follow
/// each other along y.
///
/// So the printed part of each plane is one range that grows upwards, and as parts have fewer
/// layers than rows, few planes of it fit into the fastest memory.
/// The first and the last of planes, of rows and of each row's numbers are **halo**: they are read
/// as neighbours but never change, so that a sweep may run over the ends of rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Numbers in a row, a multiple of a cache line's.
    pub(crate) row: usize,
    /// Rows in a plane.
    pub(crate) rows: usize,
    /// Planes.
    pub(crate) planes: usize,
}

impl Shape {
    /// For so many voxels, with the halo.
    pub(crate) fn around(width: usize, height: usize, depth: usize) -> Self {
        Self { row: (width + 2).next_multiple_of(LINE_LEN), rows: depth + 2, planes: height + 2 }
    }

    pub(crate) fn plane(&self) -> usize {
        self.row * self.rows
    }

    pub(crate) fn len(&self) -> usize {
        self.plane() * self.planes
    }

    /// Where a voxel lies, with the halo counted.
    pub(crate) fn index(&self, at: [usize; 3]) -> usize {
        let [x, y, z] = at;
        (y * self.rows + z) * self.row + x
    }
}

/// How the numbers of a cache line are to be swept.
///
/// In one byte, since sweeps look for where it changes: the faces that all its voxels have, or
/// [`LineCode::MIXED`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LineCode(u8);

/// What a [`LineCode`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LineKind {
    /// No voxel in it is active: all are 0, and stay so.
    Empty,
    /// All are active and have the same faces covered: these, as [`face`] has them.
    Uniform(u8),
    /// Anything else.
    Mixed,
}

impl LineCode {
    pub(crate) const EMPTY: Self = Self(0);
    /// No voxel has these faces, for it would not be active.
    pub(crate) const MIXED: Self = Self(face::ALL);

    /// Of voxels with the given faces.
    pub(crate) fn of(faces: [u8; LINE_LEN]) -> Self {
        if faces == [faces[0]; LINE_LEN] { Self(faces[0]) } else { Self::MIXED }
    }

    /// How many lines at the start of some are equal to this one: eight at a time, for loads are
    /// what limits a sweep.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "sweeps ask for every run of lines")]
    pub(crate) fn run(self, lines: &[Self]) -> usize {
        let equal = u64::from_le_bytes([self.0; 8]);
        let mut count = 0;
        while let Some(eight) = lines[count..].first_chunk() {
            let differences = equal ^ u64::from_le_bytes(eight.map(|Self(byte)| byte));
            if differences != 0 {
                return count + differences.trailing_zeros() as usize / 8;
            }
            count += 8;
        }
        count + lines[count..].iter().take_while(|&&line| line == self).count()
    }

    /// With some of its voxels changed.
    pub(crate) fn cut(self) -> Self {
        if self == Self::EMPTY { self } else { Self::MIXED }
    }

    /// Whether it may lose heat to the air.
    pub(crate) fn is_open(self) -> bool {
        !matches!(self.kind(), LineKind::Empty | LineKind::Uniform(face::INTERIOR))
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "sweeps ask for every run of lines")]
    pub(crate) fn kind(self) -> LineKind {
        match self {
            Self::EMPTY => LineKind::Empty,
            Self::MIXED => LineKind::Mixed,
            Self(faces) => LineKind::Uniform(faces),
        }
    }
}

/// Which voxels are active, and the numbers of each: as [`crate::coefficients::Coefficients`] has
/// them, one array each.
#[derive(Clone, Debug, Default)]
pub(crate) struct CoefficientArrays {
    pub(crate) diagonal: AlignedBuffer,
    pub(crate) exposed_area: AlignedBuffer,
    /// Of no numbers unless surfaces have a resistance.
    pub(crate) top_bottom_area: AlignedBuffer,
    /// One for each cache line of the other arrays.
    pub(crate) lines: Vec<LineCode>,
}

impl CoefficientArrays {
    /// Nothing is active.
    pub(crate) fn none(shape: Shape, resistance: bool) -> Self {
        let len = shape.len();
        Self {
            diagonal: AlignedBuffer::zeros(len),
            exposed_area: AlignedBuffer::zeros(len),
            top_bottom_area: AlignedBuffer::zeros(if resistance { len } else { 0 }),
            lines: vec![LineCode::EMPTY; len / LINE_LEN],
        }
    }

    pub(crate) fn set(&mut self, index: usize, voxel: VoxelCoefficients, line: LineCode) {
        self.diagonal[index] = voxel.diagonal;
        self.exposed_area[index] = voxel.exposed_area;
        if let Some(top_bottom_area) = self.top_bottom_area.get_mut(index) {
            *top_bottom_area = voxel.top_bottom_area;
        }
        self.lines[index / LINE_LEN] = line;
    }
}

/// A box of voxels with their temperatures: the whole part, or a window into it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    pub(crate) shape: Shape,
    /// x, y and z of its first number in the part's patch; x is a multiple of a cache line.
    pub(crate) origin: [usize; 3],
    pub(crate) arrays: CoefficientArrays,
    /// Temperatures above that of the air, K; 0 where no voxel is active.
    pub(crate) theta: AlignedBuffer,
}

impl Patch {
    /// A part of which nothing is printed yet.
    pub(crate) fn empty(shape: Shape, coefficients: &Coefficients) -> Self {
        let mut theta = AlignedBuffer::zeros(shape.len());
        theta
            .chunks_exact_mut(shape.plane())
            .for_each(|plane| plane[..shape.row].fill(coefficients.plate_ghost));
        Self {
            shape,
            origin: [0; 3],
            arrays: CoefficientArrays::none(shape, coefficients.resistance.is_some()),
            theta,
        }
    }

    /// The flat index of a voxel of the part's patch, or `None` if it isn't inside this one's halo.
    pub(crate) fn index(&self, at: [usize; 3]) -> Option<usize> {
        let Shape { row, rows, planes } = self.shape;
        let [x, y, z] = [0, 1, 2].map(|axis: usize| at[axis].wrapping_sub(self.origin[axis]));
        let inner = |i: usize, n: usize| i.wrapping_sub(1) < n - 2;
        (inner(x, row) && inner(y, planes) && inner(z, rows)).then(|| self.shape.index([x, y, z]))
    }

    /// Places along an axis, inside the halo, of the voxels of a block of so many; blocks are
    /// counted in the part.
    pub(crate) fn voxels(&self, axis: usize, block: usize, coarsening: usize) -> Range<usize> {
        let Shape { row, rows, planes } = self.shape;
        let first = (block - 1) * coarsening + 1 - self.origin[axis];
        first..(first + coarsening).min([row, planes, rows][axis] - 1)
    }

    /// Takes up births.
    pub(crate) fn apply(&mut self, changes: &[Change], coefficients: &Coefficients) {
        let last = self.shape.row - LINE_LEN;
        for change in changes {
            let Some(index) = self.index(change.at) else { continue };
            // The ends of rows are halo, whatever they are in the part.
            let x = change.at[0] - self.origin[0];
            let end = x < LINE_LEN || x >= last;
            self.arrays.set(index, change.voxel, if end { change.line.cut() } else { change.line });
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

    #[test]
    fn runs_are_as_long_as_lines_are_equal() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        for _ in 0..2000 {
            let kinds = [
                LineCode::EMPTY,
                LineCode::MIXED,
                LineCode(face::INTERIOR),
                LineCode(face::INTERIOR - face::ABOVE),
            ];
            let mut lines = Vec::new();
            for _ in 0..random.random_range(0..8) {
                lines.extend(vec![kinds[random.random_range(0..4)]; random.random_range(1..20)]);
            }
            for (i, line) in lines.iter().enumerate() {
                let equal = lines[i..].iter().take_while(|&other| other == line).count();
                assert_eq!(line.run(&lines[i..]), equal);
            }
        }
    }
}
