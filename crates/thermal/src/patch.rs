//! A box of voxels, as flat arrays that can be swept from end to end.

use std::ops::Range;

use crate::aligned::{Aligned, LINE};
use crate::law::{Law, Voxel, face};
use crate::occupancy::Change;

/// The sizes of a patch: `planes` planes of `rows` rows of `row` numbers.
/// Rows run along x; a plane is upright, its rows lie one above the other along z; planes follow
/// each other along y.
///
/// So the printed part of each plane is one range that grows upwards, and as parts have fewer
/// layers than rows, few planes of it fit into the fastest memory.
/// The first and the last of planes, of rows and of each row's numbers are **rim**: they are read
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
    /// For so many voxels, with the rim.
    pub(crate) fn around(width: usize, height: usize, depth: usize) -> Self {
        Self { row: (width + 2).next_multiple_of(LINE), rows: depth + 2, planes: height + 2 }
    }

    pub(crate) fn plane(&self) -> usize {
        self.row * self.rows
    }

    pub(crate) fn len(&self) -> usize {
        self.plane() * self.planes
    }

    /// Where a voxel lies, with the rim counted.
    pub(crate) fn index(&self, at: [usize; 3]) -> usize {
        let [x, y, z] = at;
        (y * self.rows + z) * self.row + x
    }
}

/// How the numbers of a cache line are to be swept.
///
/// In one byte, since sweeps look for where it changes: the faces that all its voxels have, or
/// [`Line::MIXED`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Line(u8);

/// What a [`Line`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// No voxel in it is active: all are 0, and stay so.
    Empty,
    /// All are active and have the same faces covered: these, as [`face`] has them.
    Uniform(u8),
    /// Anything else.
    Mixed,
}

impl Line {
    pub(crate) const EMPTY: Self = Self(0);
    /// No voxel has these faces, for it would not be active.
    pub(crate) const MIXED: Self = Self(face::ALL);

    /// Of voxels with the given faces.
    pub(crate) fn of(faces: [u8; LINE]) -> Self {
        if faces == [faces[0]; LINE] { Self(faces[0]) } else { Self::MIXED }
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
        !matches!(self.kind(), Kind::Empty | Kind::Uniform(face::INTERIOR))
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "sweeps ask for every run of lines")]
    pub(crate) fn kind(self) -> Kind {
        match self {
            Self::EMPTY => Kind::Empty,
            Self::MIXED => Kind::Mixed,
            Self(faces) => Kind::Uniform(faces),
        }
    }
}

/// Which voxels are active, and the numbers of each: as [`crate::law::Law`] has them, one array
/// each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Activity {
    pub(crate) damping: Aligned,
    pub(crate) exposure: Aligned,
    /// Of no numbers unless surfaces have a resistance.
    pub(crate) caps: Aligned,
    /// One for each cache line of the other arrays.
    pub(crate) lines: Vec<Line>,
}

impl Activity {
    /// Nothing is active.
    pub(crate) fn none(shape: Shape, resistance: bool) -> Self {
        let len = shape.len();
        Self {
            damping: Aligned::zeros(len),
            exposure: Aligned::zeros(len),
            caps: Aligned::zeros(if resistance { len } else { 0 }),
            lines: vec![Line::EMPTY; len / LINE],
        }
    }

    pub(crate) fn set(&mut self, index: usize, voxel: Voxel, line: Line) {
        self.damping[index] = voxel.damping;
        self.exposure[index] = voxel.exposure;
        if let Some(caps) = self.caps.get_mut(index) {
            *caps = voxel.caps;
        }
        self.lines[index / LINE] = line;
    }
}

/// A box of voxels with their temperatures: the whole part, or a window into it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    pub(crate) shape: Shape,
    /// x, y and z of its first number in the part's patch; x is a multiple of a cache line.
    pub(crate) origin: [usize; 3],
    pub(crate) activity: Activity,
    /// Temperatures above that of the air, K; 0 where no voxel is active.
    pub(crate) theta: Aligned,
}

impl Patch {
    /// A part of which nothing is printed yet.
    pub(crate) fn empty(shape: Shape, law: &Law) -> Self {
        let mut theta = Aligned::zeros(shape.len());
        theta.chunks_exact_mut(shape.plane()).for_each(|plane| plane[..shape.row].fill(law.ghost));
        Self {
            shape,
            origin: [0; 3],
            activity: Activity::none(shape, law.resistance.is_some()),
            theta,
        }
    }

    /// The flat index of a voxel of the part's patch, or `None` if it isn't inside this one's rim.
    pub(crate) fn index(&self, at: [usize; 3]) -> Option<usize> {
        let Shape { row, rows, planes } = self.shape;
        let [x, y, z] = [0, 1, 2].map(|axis: usize| at[axis].wrapping_sub(self.origin[axis]));
        let inner = |i: usize, n: usize| i.wrapping_sub(1) < n - 2;
        (inner(x, row) && inner(y, planes) && inner(z, rows)).then(|| self.shape.index([x, y, z]))
    }

    /// Places along an axis, inside the rim, of the voxels of a block of so many; blocks are
    /// counted in the part.
    pub(crate) fn voxels(&self, axis: usize, block: usize, fold: usize) -> Range<usize> {
        let Shape { row, rows, planes } = self.shape;
        let first = (block - 1) * fold + 1 - self.origin[axis];
        first..(first + fold).min([row, planes, rows][axis] - 1)
    }

    /// Takes up births.
    pub(crate) fn take_up(&mut self, changes: &[Change], law: &Law) {
        let last = self.shape.row - LINE;
        for change in changes {
            let Some(index) = self.index(change.at) else { continue };
            // The ends of rows are rim, whatever they are in the part.
            let x = change.at[0] - self.origin[0];
            let end = x < LINE || x >= last;
            self.activity.set(
                index,
                change.voxel,
                if end { change.line.cut() } else { change.line },
            );
            if change.born {
                self.theta[index] = law.birth;
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
                Line::EMPTY,
                Line::MIXED,
                Line(face::INTERIOR),
                Line(face::INTERIOR - face::ABOVE),
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
