//! The halo of a window that is a region of the far field.

use crate::aligned::LINE_LEN;
use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::patch::Patch;

use super::{BorderPair, Region};

/// The numbers of a window's halo across which heat flows.
#[derive(Debug, Default)]
pub(crate) struct FluxHalo {
    /// Where each is, and the number of its pair of blocks.
    voxels: Vec<(usize, usize)>,
}

/// What flows between the pairs of blocks at a region's border, as the numbers that the window's
/// halo has to have: what flows by the conductance to it.
#[derive(Debug)]
pub(crate) struct BorderFluxes(Vec<f32>);

impl BorderFluxes {
    /// From what crosses from the inside to the outside in a time, K in voxels.
    pub(super) fn new<'a>(
        crossed: impl Iterator<Item = (&'a BorderPair, f32)>,
        seconds: f64,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
    ) -> Self {
        let flow = |(border, crossed): (&BorderPair, f32)| {
            let faces = block_grid.blocks[border.first()].shared_faces[border.axis];
            if faces == 0 {
                0.0
            } else {
                -crossed
                    / (seconds as f32 * f32::from(faces) * coefficients.conductance(border.axis))
            }
        };
        Self(crossed.map(flow).collect())
    }
}

impl FluxHalo {
    /// Closes the halo of a window into a part: its voxels conduct nothing to those beyond, but are
    /// given what the halo says.
    pub(crate) fn close(
        window: &mut Patch,
        part: &Patch,
        region: Region,
        block_grid: &BlockGrid,
        coefficients: &Coefficients,
    ) -> Self {
        let Patch { shape, origin, arrays, theta } = window;
        let sizes = [shape.row, shape.planes, shape.rows];
        let strides = [1, shape.plane(), shape.row];
        let outer_strides = [1, part.shape.plane(), part.shape.row];
        let mut voxels = Vec::new();
        // In the order of `Region::border`.
        let mut pairs = 0;
        for (axis, side, sheet) in region.sides(block_grid) {
            let mut ends = [0, 1, 2].map(|axis: usize| 1..sizes[axis] - 1);
            ends[axis] = if side == 0 { 1..2 } else { sizes[axis] - 2..sizes[axis] - 1 };
            let [x, y, z] = ends;
            let beyond = |index: usize, strides: [usize; 3]| {
                if side == 0 { index - strides[axis] } else { index + strides[axis] }
            };
            let sheet_size = [0, 1, 2].map(|axis: usize| sheet.high[axis] - sheet.low[axis]);
            for (y, z) in y.flat_map(|y| z.clone().map(move |z| (y, z))) {
                for x in x.clone() {
                    let own = shape.index([x, y, z]);
                    let at = [
                        x + origin[0] - part.origin[0],
                        y + origin[1] - part.origin[1],
                        z + origin[2] - part.origin[2],
                    ];
                    let outer = part.shape.index(at);
                    let index = beyond(own, strides);
                    theta[index] = 0.0;
                    let line = &mut arrays.lines[own / LINE_LEN];
                    *line = line.cut();
                    let there = part.arrays.diagonal[beyond(outer, outer_strides)];
                    if there < 0.0 && arrays.diagonal[own] < 0.0 {
                        arrays.diagonal[own] =
                            coefficients.without_neighbour(arrays.diagonal[own], axis);
                        let block = [0, 1, 2].map(|axis: usize| {
                            ((at[axis] - 1) / block_grid.coarsening[axis] + 1) - sheet.low[axis]
                        });
                        let pair = (block[1] * sheet_size[2] + block[2]) * sheet_size[0] + block[0];
                        voxels.push((index, pairs + pair));
                    }
                }
            }
            pairs += sheet_size.iter().product::<usize>();
        }
        Self { voxels }
    }

    /// Has flow what is to flow.
    pub(crate) fn set(&self, window: &mut Patch, flows: &BorderFluxes) {
        for &(index, pair) in &self.voxels {
            window.theta[index] = flows.0[pair];
        }
    }

    /// Has nothing flow.
    pub(crate) fn clear(&self, window: &mut Patch) {
        for &(index, _) in &self.voxels {
            window.theta[index] = 0.0;
        }
    }
}
