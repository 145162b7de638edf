//! Closed borders: the halo of a window around a region holds heat fluxes instead of temperatures.

use crate::aligned::LINE_LEN;
use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::patch::Patch;

use super::region::{BorderPair, Region};

/// The halo of a window across whose border a prescribed flux flows.
///
/// A voxel at the border loses the term of its outer neighbour from its diagonal, so it conducts
/// nothing to it.
/// But the stencil still adds the conductance times the value of that neighbour.
/// With flux / conductance as this halo value, the stencil adds exactly the flux: a Neumann
/// boundary condition without a change to the sweeps.
#[derive(Debug, Default)]
pub(crate) struct FluxHalo {
    /// For each halo voxel with an active voxel on both sides of the border: its flat index in the
    /// window, and the number of its pair of blocks in the order of [`Region::border`].
    voxels: Vec<(usize, usize)>,
}

/// Flux between each pair of blocks at a region's border, as the halo value that produces it.
#[derive(Debug)]
pub(crate) struct BorderFluxes(Vec<f32>);

impl BorderFluxes {
    /// Fluxes from the heat that crosses from the inside to the outside of each pair during a time,
    /// in K voxels.
    /// The heat is spread evenly over the time, and over the faces that the two blocks share.
    pub(super) fn new<'a>(
        crossed: impl Iterator<Item = (&'a BorderPair, f32)>,
        seconds: f64,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
    ) -> Self {
        let halo_value = |(pair, crossed): (&BorderPair, f32)| {
            let faces = block_grid.blocks[pair.lower()].shared_faces[pair.axis];
            if faces == 0 {
                0.0
            } else {
                let conductance = coefficients.conductance(pair.axis);
                // Heat that leaves the region is a loss for the window's voxels: hence the sign.
                -crossed / (seconds as f32 * f32::from(faces) * conductance)
            }
        };
        Self(crossed.map(halo_value).collect())
    }
}

impl FluxHalo {
    /// Closes the border of a window into a part whose inside is a region: removes conduction to
    /// the voxels outside and sets all fluxes to 0.
    ///
    /// Sides of the region at the border of the part stay as they are.
    pub(crate) fn close(
        window: &mut Patch,
        part: &Patch,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
    ) -> Self {
        let Patch { shape, origin, arrays, theta } = window;
        let sizes = shape.sizes();
        let strides = [1, shape.plane_len(), shape.row_len];
        let part_strides = [1, part.shape.plane_len(), part.shape.row_len];
        let mut voxels = Vec::new();
        // Number of pairs on the sides before this one, in the order of `Region::border`.
        let mut pairs = 0;
        for (axis, side, sheet) in region.sides(block_grid) {
            // The layer of voxels just inside the halo on this side.
            let mut ranges = [0, 1, 2].map(|axis: usize| 1..sizes[axis] - 1);
            ranges[axis] = if side == 0 { 1..2 } else { sizes[axis] - 2..sizes[axis] - 1 };
            let [x, y, z] = ranges;
            let beyond = |index: usize, strides: [usize; 3]| {
                if side == 0 { index - strides[axis] } else { index + strides[axis] }
            };
            let sheet_size = [0, 1, 2].map(|axis: usize| sheet.high[axis] - sheet.low[axis]);
            for (y, z) in y.flat_map(|y| z.clone().map(move |z| (y, z))) {
                for x in x.clone() {
                    let inside = shape.index([x, y, z]);
                    let halo = beyond(inside, strides);
                    theta[halo] = 0.0;
                    // With the code of a uniform line, sweeps would use the shared diagonal instead
                    // of the changed one.
                    let line = &mut arrays.lines[inside / LINE_LEN];
                    *line = line.not_uniform();
                    let in_part = [
                        x + origin[0] - part.origin[0],
                        y + origin[1] - part.origin[1],
                        z + origin[2] - part.origin[2],
                    ];
                    let outside = beyond(part.shape.index(in_part), part_strides);
                    if part.arrays.diagonal[outside] < 0.0 && arrays.diagonal[inside] < 0.0 {
                        arrays.diagonal[inside] =
                            coefficients.without_neighbour(arrays.diagonal[inside], axis);
                        let block = [0, 1, 2].map(|axis: usize| {
                            (in_part[axis] - 1) / block_grid.coarsening[axis] + 1 - sheet.low[axis]
                        });
                        let pair = (block[1] * sheet_size[2] + block[2]) * sheet_size[0] + block[0];
                        voxels.push((halo, pairs + pair));
                    }
                }
            }
            pairs += sheet_size.iter().product::<usize>();
        }
        Self { voxels }
    }

    /// Sets the fluxes across the border.
    pub(crate) fn set(&self, window: &mut Patch, fluxes: &BorderFluxes) {
        for &(halo, pair) in &self.voxels {
            window.theta[halo] = fluxes.0[pair];
        }
    }

    /// Sets all fluxes to 0.
    pub(crate) fn clear(&self, window: &mut Patch) {
        for &(halo, _) in &self.voxels {
            window.theta[halo] = 0.0;
        }
    }
}
