//! A layer and what lies below it, in blocks of cells and levels of layers.

use std::ops::Range;

use beadwork_part::slice::Voxels;

/// Cells beside the printed layer that are part of the model, where lower layers have them.
const MARGIN: u32 = 8;

/// Blocks of a row that steps treat at once; rows are filled up with empty blocks.
pub(super) const LANES: usize = 16;

/// The box of voxels that a model covers.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    pub(super) columns: Range<u32>,
    pub(super) rows: Range<u32>,
    /// Layers of each level, from the top; the first level is the printed layer.
    pub(super) levels: Vec<Range<usize>>,
}

impl Extent {
    /// The box around a layer that has cells, and what lies below it: at most one level for each of
    /// `layers`, which are their numbers of layers from the top.
    pub(super) fn new(part: &Voxels, layer: usize, layers: &[usize]) -> Self {
        let (width, height) = (part.frame.width, part.frame.height);
        let (mut columns, mut rows) = (width..0, height..0);
        for cell in part.cells(layer) {
            let (x, y) = (cell % width, cell / width);
            columns = columns.start.min(x)..columns.end.max(x + 1);
            rows = rows.start.min(y)..rows.end.max(y + 1);
        }
        let widen = |range: Range<u32>, limit: u32| {
            range.start.saturating_sub(MARGIN)..(range.end + MARGIN).min(limit)
        };
        let mut levels = Vec::from([Range { start: layer, end: layer + 1 }]);
        let mut above = layer;
        for count in layers {
            let below = above.saturating_sub(*count);
            if below < above {
                levels.push(below..above);
            }
            above = below;
        }
        Self { columns: widen(columns, width), rows: widen(rows, height), levels }
    }

    /// The level of a voxel; `None` if the voxel is outside the box.
    pub(super) fn level(&self, [x, y]: [u32; 2], z: usize) -> Option<usize> {
        if !self.columns.contains(&x) || !self.rows.contains(&y) {
            return None;
        }
        self.levels.iter().position(|level| level.contains(&z))
    }

    /// The columns and rows of the box, row by row.
    pub(super) fn positions(&self) -> impl Iterator<Item = [u32; 2]> {
        let columns = self.columns.clone();
        self.rows.clone().flat_map(move |y| columns.clone().map(move |x| [x, y]))
    }
}

/// Square blocks of cells, in rows, with a border of one empty block on each side.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    /// Side of a block, in cells: a power of two.
    pub(super) side: u32,
    /// Blocks in a row, with the border: [`LANES`] times a number, plus 2.
    pub(super) width: usize,
    /// Rows of blocks, with the border.
    pub(super) height: usize,
    left: u32,
    top: u32,
    pub(super) levels: Vec<LevelBlocks>,
}

/// What the blocks of one level contain; each array has one number per block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LevelBlocks {
    /// Layers of the level.
    pub(super) layers: usize,
    /// Voxels of the part.
    pub(super) voxels: Vec<f32>,
    /// Pairs of voxels on both sides of the border to the block at larger x.
    pub(super) right: Vec<f32>,
    /// Pairs of voxels on both sides of the border to the block at larger y.
    pub(super) down: Vec<f32>,
    /// Pairs of voxels on both sides of the border to the level below.
    pub(super) below: Vec<f32>,
    /// Voxels on the build plate.
    pub(super) plate: Vec<f32>,
    /// Sides of voxels that face the air.
    pub(super) sides: Vec<f32>,
    /// Tops and bottoms of voxels that face the air once the layer is printed.
    pub(super) faces: Vec<f32>,
}

impl Blocks {
    /// The blocks of the given side, in cells, of the voxels of a box.
    ///
    /// Linear in the voxels of the box.
    pub(super) fn new(part: &Voxels, extent: &Extent, side: u32) -> Self {
        let mut blocks = Self::empty(extent, side);
        for (number, layers) in extent.levels.iter().enumerate() {
            let is_lowest = number + 1 == extent.levels.len();
            let level = blocks.level(part, extent, layers, is_lowest);
            blocks.levels.push(level);
        }
        blocks
    }

    fn empty(extent: &Extent, side: u32) -> Self {
        let blocks_of = |range: &Range<u32>| range.len().div_ceil(side as usize);
        let width = blocks_of(&extent.columns).next_multiple_of(LANES) + 2;
        let height = blocks_of(&extent.rows) + 2;
        let (left, top) = (extent.columns.start, extent.rows.start);
        Self { side, width, height, left, top, levels: Vec::new() }
    }

    fn empty_level(&self, layers: usize) -> LevelBlocks {
        let empty = || vec![0.0; self.len()];
        LevelBlocks {
            layers,
            voxels: empty(),
            right: empty(),
            down: empty(),
            below: empty(),
            plate: empty(),
            sides: empty(),
            faces: empty(),
        }
    }

    fn level(
        &self,
        part: &Voxels,
        extent: &Extent,
        layers: &Range<usize>,
        is_lowest: bool,
    ) -> LevelBlocks {
        let printed = extent.levels[0].start;
        let mut level = self.empty_level(layers.len());
        for z in layers.clone() {
            let has = |x: u32, y: u32| part.material(x, y, z).is_some();
            for [x, y] in extent.positions().filter(|&[x, y]| has(x, y)) {
                let block = self.block([x, y]);
                level.voxels[block] += 1.0;
                for (x, y) in [(x.wrapping_sub(1), y), (x, y.wrapping_sub(1))] {
                    level.sides[block] += f32::from(u8::from(!has(x, y)));
                }
                // Contacts with what lies outside the box are neither air nor another block.
                for (next, pairs) in [([x + 1, y], &mut level.right), ([x, y + 1], &mut level.down)]
                {
                    if !has(next[0], next[1]) {
                        level.sides[block] += 1.0;
                    } else if extent.level(next, z).is_some() && self.block(next) != block {
                        pairs[block] += 1.0;
                    }
                }
                let is_covered = z < printed && part.material(x, y, z + 1).is_some();
                level.faces[block] += f32::from(u8::from(!is_covered));
                if z == 0 {
                    level.plate[block] += 1.0;
                } else if part.material(x, y, z - 1).is_none() {
                    level.faces[block] += 1.0;
                } else if z == layers.start && !is_lowest {
                    level.below[block] += 1.0;
                }
            }
        }
        level
    }

    /// The same box in blocks twice as wide.
    ///
    /// Linear in the number of blocks.
    pub(super) fn coarser(&self, extent: &Extent) -> Self {
        let mut coarse = Self::empty(extent, 2 * self.side);
        for fine in &self.levels {
            let mut level = coarse.empty_level(fine.layers);
            for (row, y) in (1..self.height - 1).enumerate() {
                for (column, x) in (1..self.width - 1).enumerate() {
                    let from = y * self.width + x;
                    if fine.voxels[from] == 0.0 {
                        continue;
                    }
                    let to = (row / 2 + 1) * coarse.width + column / 2 + 1;
                    level.voxels[to] += fine.voxels[from];
                    level.below[to] += fine.below[from];
                    level.plate[to] += fine.plate[from];
                    level.sides[to] += fine.sides[from];
                    level.faces[to] += fine.faces[from];
                    // Of two blocks side by side, the second has the border.
                    if column % 2 == 1 {
                        level.right[to] += fine.right[from];
                    }
                    if row % 2 == 1 {
                        level.down[to] += fine.down[from];
                    }
                }
            }
            coarse.levels.push(level);
        }
        coarse
    }

    /// Index of the block of a cell of the part.
    pub(super) fn block(&self, cell: [u32; 2]) -> usize {
        self.block_at(self.position(cell))
    }

    /// Column and row of a cell of the part in the box.
    pub(super) fn position(&self, [x, y]: [u32; 2]) -> [u32; 2] {
        [x - self.left, y - self.top]
    }

    /// Index of the block of the cell in a column and row of the box.
    pub(super) fn block_at(&self, [column, row]: [u32; 2]) -> usize {
        let shift = self.side.trailing_zeros();
        ((row >> shift) as usize + 1) * self.width + (column >> shift) as usize + 1
    }

    /// Number of blocks of a level, with the border.
    pub(super) fn len(&self) -> usize {
        self.width * self.height
    }

    /// Spreads values of blocks twice as wide over these blocks.
    pub(super) fn refine(&self, coarse: &Self, values: &[f32]) -> Vec<f32> {
        let mut fine = vec![0.0; self.len()];
        for y in 1..self.height - 1 {
            let from = &values[y.div_ceil(2) * coarse.width..][1..coarse.width - 1];
            let row = &mut fine[y * self.width..][1..self.width - 1];
            for (pair, value) in row.as_chunks_mut().0.iter_mut().zip(from) {
                *pair = [*value; 2];
            }
        }
        fine
    }

    /// Sums values of blocks half as wide.
    pub(super) fn sums(&self, fine: &Self, values: &[i32]) -> Vec<i32> {
        let mut sums = vec![0; self.len()];
        for y in 1..fine.height - 1 {
            let from = &values[y * fine.width..][1..fine.width - 1];
            let row = &mut sums[y.div_ceil(2) * self.width..][1..self.width - 1];
            for (sum, [left, right]) in row.iter_mut().zip(from.as_chunks().0) {
                *sum += left + right;
            }
        }
        sums
    }
}
