//! What an agent sees of a print.

use beadwork_part::slice::Voxels;
use beadwork_thermal::event::DepositionEvent;

/// The part of the temperature field that is observed.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// First column and row, which may lie outside of the grid.
    origin: [i64; 2],
    /// Columns and rows of the observation.
    pub(super) size: [usize; 2],
    /// Side of an observed cell, in voxels.
    pub(super) cell: usize,
    /// Observed layers below the one that is printed next.
    pub(super) depth: usize,
}

impl View {
    /// Shows the bounding box of a part's voxels: in cells of the given side, or, if there is a
    /// `window`, centred in a square of that many cells along each side.
    /// The cells of a window are as small as the part allows.
    pub(super) fn new(part: &Voxels, depth: usize, cell: usize, window: Option<usize>) -> Self {
        let width = part.frame.width;
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for filled in (0..part.depth).flat_map(|layer| part.cells(layer)) {
            for (axis, at) in [filled % width, filled / width].into_iter().enumerate() {
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at + 1);
            }
        }
        let low = low.map(|at| if at == u32::MAX { 0 } else { at });
        let sides = [0, 1].map(|axis| (high[axis] - low[axis]) as usize);
        let Some(window) = window else {
            let size = sides.map(|side| side.div_ceil(cell).max(1));
            return Self { origin: low.map(i64::from), size, cell, depth };
        };
        let cell = sides[0].max(sides[1]).div_ceil(window).max(1);
        let margin = |axis: usize| ((window * cell - sides[axis]) / 2) as i64;
        let origin = [0, 1].map(|axis| i64::from(low[axis]) - margin(axis));
        Self { origin, size: [window; 2], cell, depth }
    }

    /// Number of observed cells in a layer.
    pub(super) fn cells(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Observed cell of a voxel.
    pub(super) fn cell_of(&self, x: usize, y: usize) -> usize {
        let [x, y] = [x as i64 - self.origin[0], y as i64 - self.origin[1]].map(|at| at as usize);
        y / self.cell * self.size[0] + x / self.cell
    }

    /// Position of a voxel in the view, from 0 to 1 along x and y.
    pub(super) fn share_of(&self, [x, y]: [u32; 2]) -> [f32; 2] {
        let share = |axis: usize, at: u32| {
            let cells = (self.size[axis] * self.cell) as f32;
            (i64::from(at) - self.origin[axis]) as f32 / cells
        };
        [share(0, x), share(1, y)]
    }
}

/// Side of the squares whose warmth is compared, in voxels.
const BLOCK: u32 = 4;

/// Time after which a voxel has lost much of its heat to the layers below, s.
const SINK_S: f64 = 0.3;

/// Time after which a voxel has lost much of its heat to its surroundings, s.
const FADE_S: f64 = 2.0;

/// How uneven a layer is at its end, by two measures of a cell's warmth: both fall from 1 with the
/// time since its deposition, one slowly, as the heat of a sheet that sinks into a body, and one
/// exponentially.
/// They are averaged over squares of 4 x 4 voxels, and the standard deviations between these are
/// returned.
///
/// `events` are those of the layer, on a grid of `width` columns.
/// A crude form of the proxy of `beadwork_heat`, at a few nanoseconds a voxel.
pub(super) fn unevenness(events: &[DepositionEvent], width: u32) -> [f64; 2] {
    let columns = width.div_ceil(BLOCK) as usize;
    let mut blocks: Vec<(f64, [f64; 2])> = Vec::new();
    let mut age = 0.0;
    for event in events.iter().rev() {
        if let Some([x, y, _]) = event.voxel {
            let block = (y / BLOCK) as usize * columns + (x / BLOCK) as usize;
            if block >= blocks.len() {
                blocks.resize(block + 1, (0.0, [0.0; 2]));
            }
            let (count, sums) = &mut blocks[block];
            *count += 1.0;
            sums[0] += 1.0 / (1.0 + age / SINK_S).sqrt();
            sums[1] += libm::exp(-age / FADE_S);
        }
        age += event.seconds;
    }
    blocks.retain(|&(count, _)| count > 0.0);
    let cells: f64 = blocks.iter().map(|&(count, _)| count).sum();
    [0, 1].map(|measure| {
        let mean = blocks.iter().map(|(_, sums)| sums[measure]).sum::<f64>() / cells.max(1.0);
        let square = |(count, sums): &(f64, [f64; 2])| {
            count * (sums[measure] / count - mean) * (sums[measure] / count - mean)
        };
        (blocks.iter().map(square).sum::<f64>() / cells.max(1.0)).sqrt()
    })
}
