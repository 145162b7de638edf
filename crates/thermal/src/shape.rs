//! The layout of voxels, and of blocks, in flat arrays.

use crate::aligned::LINE_LEN;

/// Sizes of a patch, which fix the position of each voxel in its flat arrays.
///
/// Arrays have the index order `[y, z, x]`, x fastest: a **row** runs along x, a **plane** holds
/// the rows of one y, one for each z, and planes follow each other along y.
///
/// ```text
/// index(x, y, z) = (y * rows + z) * row_len + x
///
///              z = rows - 1   . . . . . . . . . .      halo
///              (top)          . o o o o o o o o .      empty so far
///  one plane                  . x x x x x x x x .  \
///  of fixed y                 . x x x x x x x x .   }  printed: one contiguous range
///                             . x x x x x x x x .  /
///              z = 0          . . . . . . . . . .      halo: ghosts of the build plate
/// ```
///
/// The layers are not the outermost axis, unlike in most of the workspace, for two reasons:
///
/// - The printed layers of a plane are one contiguous range that starts at z = 1 and grows upwards,
///   so a sweep skips what is still empty without a test for each row.
/// - A sweep keeps three neighbouring planes in the cache.
///   Most parts have fewer layers than rows, which makes these planes smaller than layers.
///
/// The first and last plane, the first and last row of each plane, and the first and last element
/// of each row are the **halo** (ghost cells): they are read as neighbours, but sweeps never change
/// them.
/// So every voxel has six neighbours in the array, and a sweep can run through the ends of rows as
/// if they were voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Elements in a row, halo included: a multiple of [`LINE_LEN`].
    pub(crate) row_len: usize,
    /// Rows in a plane: layers, halo included.
    pub(crate) rows: usize,
    /// Planes, halo included.
    pub(crate) planes: usize,
}

impl Shape {
    /// Shape for a number of voxels along x, y and z, to which it adds the halo.
    pub(crate) fn with_halo(width: usize, height: usize, depth: usize) -> Self {
        Self {
            row_len: (width + 2).next_multiple_of(LINE_LEN),
            rows: depth + 2,
            planes: height + 2,
        }
    }

    /// Elements in a plane: the distance between neighbours in y.
    pub(crate) fn plane_len(&self) -> usize {
        self.row_len * self.rows
    }

    /// Elements in the patch.
    pub(crate) fn len(&self) -> usize {
        self.plane_len() * self.planes
    }

    /// Flat index of the voxel at x, y, z, with the halo counted.
    pub(crate) fn index(&self, position: [usize; 3]) -> usize {
        let [x, y, z] = position;
        (y * self.rows + z) * self.row_len + x
    }

    /// Sizes along x, y and z.
    pub(crate) fn sizes(&self) -> [usize; 3] {
        [self.row_len, self.planes, self.rows]
    }
}
