//! Iteration over the temperatures of a simulation, row by row in memory order.

use std::ops::Range;

use crate::coefficients::face;
use crate::simulation::Simulation;

/// A row of voxels along x.
///
/// Element `i` of both slices belongs to the voxel at x = `i` - 1: the first element and those
/// beyond the part's width are halo, which has no voxels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<'a> {
    pub(crate) y: u32,
    pub(crate) z: u32,
    /// Temperatures above the air, K.
    pub(crate) theta: &'a [f32],
    /// [`face`] bits.
    pub(crate) faces: &'a [u8],
    ambient_c: f64,
}

impl<'a> Row<'a> {
    /// x and temperature in °C of each deposited voxel, in order of increasing x.
    pub(crate) fn celsius(self) -> impl Iterator<Item = (u32, f64)> + Clone + 'a {
        (0u32..)
            .zip(self.theta.iter().zip(self.faces))
            .filter(|&(_, (_, &faces))| is_active(faces))
            .map(move |(i, (&theta, _))| (i - 1, f64::from(theta) + self.ambient_c))
    }
}

/// Whether [`face`] bits are those of a deposited voxel.
pub(crate) fn is_active(faces: u8) -> bool {
    faces & face::ACTIVE != 0
}

impl Simulation {
    /// Iterates over the rows of a range of layers: in order of increasing y, and for each y in
    /// order of increasing z.
    /// Skips layers in which nothing is deposited yet.
    pub(crate) fn rows(&self, layers: Range<usize>) -> impl Iterator<Item = Row<'_>> + Clone {
        let state = self.state();
        let shape = state.patch.shape;
        let layers = layers.start..layers.end.min(state.top - 1);
        let ambient_c = self.process().ambient_c;
        let rows = (0..shape.planes - 2).flat_map(move |y| layers.clone().map(move |z| (y, z)));
        rows.map(move |(y, z)| {
            let start = shape.index([0, y + 1, z + 1]);
            let row = start..start + shape.row_len;
            Row {
                y: y as u32,
                z: z as u32,
                theta: &state.patch.theta[row.clone()],
                faces: &state.occupancy.faces()[row],
                ambient_c,
            }
        })
    }

    /// Iterates over the deposited voxels of a range of layers as x, y, z and temperature in °C, in
    /// the order of [`Simulation::rows`].
    pub(crate) fn deposited(
        &self,
        layers: Range<usize>,
    ) -> impl Iterator<Item = ([u32; 3], f64)> + Clone {
        self.rows(layers)
            .flat_map(|row| row.celsius().map(move |(x, celsius)| ([x, row.y, row.z], celsius)))
    }
}
