//! The temperatures of a simulation, row by row as they lie in memory.

use std::ops::Range;

use crate::coefficients::face;
use crate::simulation::Simulation;

/// A row of voxels along x.
/// Both slices have the halo at their ends, where nothing is active.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<'a> {
    pub(crate) y: u32,
    pub(crate) z: u32,
    /// Temperatures above that of the air, K.
    pub(crate) theta: &'a [f32],
    pub(crate) faces: &'a [u8],
    ambient_c: f64,
}

impl<'a> Row<'a> {
    /// x and temperature in °C of each deposited voxel, by rising x.
    pub(crate) fn celsius(self) -> impl Iterator<Item = (u32, f64)> + Clone + 'a {
        (0u32..)
            .zip(self.theta.iter().zip(self.faces))
            .filter(|&(_, (_, &faces))| is_active(faces))
            .map(move |(x, (&theta, _))| (x - 1, f64::from(theta) + self.ambient_c))
    }
}

/// Whether a voxel of such faces is deposited.
pub(crate) fn is_active(faces: u8) -> bool {
    faces & face::ACTIVE != 0
}

impl Simulation {
    /// The rows of some layers in which something may be deposited: by rising y, and for each y by
    /// rising z.
    pub(crate) fn rows(&self, layers: Range<usize>) -> impl Iterator<Item = Row<'_>> + Clone {
        let state = self.state();
        let shape = state.patch.shape;
        let layers = layers.start..layers.end.min(state.top - 1);
        let ambient_c = self.process().ambient_c;
        let lines = (0..shape.planes - 2).flat_map(move |y| layers.clone().map(move |z| (y, z)));
        lines.map(move |(y, z)| {
            let start = shape.index([0, y + 1, z + 1]);
            let row = start..start + shape.row;
            Row {
                y: y as u32,
                z: z as u32,
                theta: &state.patch.theta[row.clone()],
                faces: &state.occupancy.faces()[row],
                ambient_c,
            }
        })
    }

    /// x, y, z and temperature in °C of each deposited voxel of some layers, in the order of
    /// [`Simulation::rows`].
    pub(crate) fn deposited(
        &self,
        layers: Range<usize>,
    ) -> impl Iterator<Item = ([u32; 3], f64)> + Clone {
        self.rows(layers)
            .flat_map(|row| row.celsius().map(move |(x, celsius)| ([x, row.y, row.z], celsius)))
    }
}
