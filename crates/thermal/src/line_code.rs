//! Codes of cache lines: which loop of a sweep can process them.

use crate::aligned::LINE_LEN;
use crate::coefficients::face;

/// How a sweep treats one cache line, which is 16 voxels in x.
///
/// A single byte, so that a sweep can compare eight of them at a time: the [`face`] bits that all
/// 16 voxels share, or [`LineCode::MIXED`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LineCode(u8);

/// What a [`LineCode`] stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LineKind {
    /// No voxel is active: all temperatures are 0 and stay so.
    Empty,
    /// All voxels are active and have these [`face`] bits, so they share their coefficients.
    Uniform(u8),
    /// Anything else: coefficients are loaded voxel by voxel, and inactive voxels are masked.
    Mixed,
}

impl LineCode {
    pub(crate) const EMPTY: Self = Self(0);
    /// The bits of six active neighbours without the voxel's own active bit.
    /// Only active voxels have bits set, so no voxel has this value.
    pub(crate) const MIXED: Self = Self(face::ALL);

    /// The code of a line whose voxels have these [`face`] bits.
    pub(crate) fn from_faces(faces: [u8; LINE_LEN]) -> Self {
        if faces == [faces[0]; LINE_LEN] { Self(faces[0]) } else { Self::MIXED }
    }

    /// Number of lines at the start of `lines` that equal this one.
    ///
    /// Compares eight codes at a time as one integer: sweeps are limited by loads, and these loads
    /// compete with those of the temperatures.
    /// Little-endian order makes the first differing code the lowest non-zero byte.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "called in sweeps, for every run of lines")]
    pub(crate) fn run_length(self, lines: &[Self]) -> usize {
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

    /// The code after some voxels of the line became part of a halo, or got coefficients of their
    /// own.
    pub(crate) fn not_uniform(self) -> Self {
        if self == Self::EMPTY { self } else { Self::MIXED }
    }

    /// Whether a voxel of the line may lose heat to the air.
    pub(crate) fn may_be_exposed(self) -> bool {
        !matches!(self.kind(), LineKind::Empty | LineKind::Uniform(face::INTERIOR))
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "called in sweeps, for every run of lines")]
    pub(crate) fn kind(self) -> LineKind {
        match self {
            Self::EMPTY => LineKind::Empty,
            Self::MIXED => LineKind::Mixed,
            Self(faces) => LineKind::Uniform(faces),
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn run_length_counts_equal_lines() {
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
                assert_eq!(line.run_length(&lines[i..]), equal);
            }
        }
    }
}
