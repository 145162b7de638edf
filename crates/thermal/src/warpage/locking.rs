//! Which voxels are solid, and the stress-free strains that are locked into them.

use beadwork_part::slice::Voxels;

use super::membrane::{Membrane, POISSON, Strain};
use crate::material::ThermalMaterial;
use crate::simulation::Simulation;

/// Maximum number of blocks along each side of the part for which in-plane strains are computed.
const MAX_BLOCKS: usize = 16;

/// Number of layers below the highest one that are read at every sample; deeper ones change more
/// slowly and are read less often.
const RECENT_LAYERS: usize = 8;

/// Temperatures of the deposited voxels, °C.
pub(super) trait Temperatures {
    /// x, y, z and temperature of each voxel of a layer, in a fixed order.
    fn layer(&self, z: usize) -> impl Iterator<Item = ([u32; 3], f64)>;

    /// Temperature of the voxel at x, y and z; `None` if it is not deposited.
    fn celsius(&self, voxel: [u32; 3]) -> Option<f64>;
}

impl Temperatures for Simulation {
    fn layer(&self, z: usize) -> impl Iterator<Item = ([u32; 3], f64)> {
        self.deposited(z..z + 1)
    }

    fn celsius(&self, voxel: [u32; 3]) -> Option<f64> {
        self.temperature_c(voxel)
    }
}

/// The stress-free strains of all voxels, and sums of them over blocks of columns.
#[derive(Clone, Debug)]
pub(super) struct Locking {
    width: usize,
    height: usize,
    depth: usize,
    /// Side of a block, in voxels.
    side: usize,
    columns: usize,
    /// Coefficient of thermal expansion, 1/K.
    expansion: f64,
    transition_c: f64,
    /// Stress-free strain minus αθ of each voxel, `[y, x, z]`, so that columns are contiguous; NaN
    /// where none is locked.
    locked: Vec<[f32; 3]>,
    /// Number of voxels of each layer that are not locked.
    unlocked: Vec<usize>,
    /// Number of layers up to the highest one that had voxels at an earlier sample.
    top: usize,
    samples: usize,
    blocks: Vec<Block>,
    /// Temperatures of the locked voxels when they were last read, °C, summed over each block and
    /// layer: `[z, block]`.
    heat: Vec<f64>,
    membrane: Membrane,
}

/// Sums over the locked voxels of a block.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    count: usize,
    strain: Strain,
    /// Temperatures, °C.
    heat: f64,
}

/// A voxel that is locked at this sample.
struct Candidate {
    voxel: [u32; 3],
    celsius: f64,
}

impl Locking {
    pub(super) fn new(part: &Voxels, material: &ThermalMaterial) -> Self {
        let (width, height) = (part.frame.width as usize, part.frame.height as usize);
        let side = width.max(height).div_ceil(MAX_BLOCKS).max(1);
        let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
        let mut inside = vec![false; columns * rows];
        for cell in (0..part.depth).flat_map(|layer| part.cells(layer)) {
            let (x, y) = (cell as usize % width, cell as usize / width);
            inside[y / side * columns + x / side] = true;
        }
        Self {
            width,
            height,
            depth: part.depth,
            side,
            columns,
            expansion: material.expansion_per_k,
            transition_c: material.glass_transition_c,
            locked: vec![[f32::NAN; 3]; part.materials().len()],
            unlocked: (0..part.depth).map(|layer| part.cells(layer).count()).collect(),
            top: 0,
            samples: 0,
            blocks: vec![Block::default(); columns * rows],
            heat: vec![0.0; columns * rows * part.depth],
            membrane: Membrane::new(columns, rows, |block| inside[block]),
        }
    }

    /// Number of columns of voxels along y.
    pub(super) fn height(&self) -> usize {
        self.height
    }

    /// Number of columns of voxels along x.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// The strains of each column of voxels from the bottom up; columns are sorted by y, then x.
    pub(super) fn columns(&self) -> impl Iterator<Item = &[[f32; 3]]> {
        self.locked.chunks_exact(self.depth.max(1))
    }

    /// Takes a sample: unlocks voxels that are above the glass transition, and locks all others.
    pub(super) fn sample(&mut self, temperatures: &impl Temperatures) {
        let candidates = self.read(temperatures, self.transition_c);
        if candidates.is_empty() {
            return;
        }
        self.solve();
        let strains: Vec<Strain> =
            candidates.iter().map(|candidate| self.strain(candidate, temperatures)).collect();
        candidates.iter().zip(strains).for_each(|(voxel, strain)| self.lock(voxel, strain));
    }

    /// Locks all voxels that are not locked yet, whatever their temperatures.
    pub(super) fn finish(&mut self, temperatures: &impl Temperatures) {
        self.sample(temperatures);
        let candidates = self.read(temperatures, f64::INFINITY);
        self.solve();
        for candidate in candidates {
            let strain = self.membrane.strain(self.block(candidate.voxel));
            self.lock(&candidate, strain);
        }
    }

    fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        (y as usize * self.width + x as usize) * self.depth + z as usize
    }

    fn block(&self, [x, y, _]: [u32; 3]) -> usize {
        y as usize / self.side * self.columns + x as usize / self.side
    }

    fn is_locked(&self, voxel: [u32; 3]) -> bool {
        !self.locked[self.index(voxel)][0].is_nan()
    }

    /// Reads the layers that are due: unlocks voxels hotter than `max_c`, and returns those that
    /// are not locked and not hotter.
    fn read(&mut self, temperatures: &impl Temperatures, max_c: f64) -> Vec<Candidate> {
        let mut candidates = Vec::new();
        let mut heat = vec![0.0; self.blocks.len()];
        for z in 0..self.depth {
            let period = (self.top.saturating_sub(z) / RECENT_LAYERS + 1).next_power_of_two();
            if self.unlocked[z] == 0 && !self.samples.is_multiple_of(period) {
                continue;
            }
            heat.fill(0.0);
            for (voxel, celsius) in temperatures.layer(z) {
                self.top = self.top.max(z + 1);
                match (self.is_locked(voxel), celsius <= max_c) {
                    (true, true) => heat[self.block(voxel)] += celsius.min(self.transition_c),
                    (true, false) => self.unlock(voxel),
                    (false, true) => candidates.push(Candidate { voxel, celsius }),
                    (false, false) => {}
                }
            }
            let of_layer = &mut self.heat[z * heat.len()..(z + 1) * heat.len()];
            for ((block, before), &heat) in self.blocks.iter_mut().zip(of_layer).zip(&heat) {
                block.heat += heat - *before;
                *before = heat;
            }
        }
        self.samples += 1;
        candidates
    }

    /// Computes the strains of all blocks from their locked voxels.
    fn solve(&mut self) {
        let thickness: Vec<f64> = self.blocks.iter().map(|block| block.count as f64).collect();
        let free = |block: &Block| {
            let (count, thermal) = (block.count.max(1) as f64, self.expansion * block.heat);
            let [x, y, shear] = block.strain;
            [(x + thermal) / count, (y + thermal) / count, shear / count]
        };
        let free: Vec<Strain> = self.blocks.iter().map(free).collect();
        self.membrane.solve(&thickness, &free);
    }

    /// The strain at the position of a voxel that is about to lock: that of its block, and what
    /// varies within the block.
    fn strain(&self, candidate: &Candidate, temperatures: &impl Temperatures) -> Strain {
        let voxel = candidate.voxel;
        let ridge = self.ridge(voxel, temperatures);
        let gap = self.gap(voxel, temperatures);
        let of_block = self.membrane.strain(self.block(voxel));
        std::array::from_fn(|i| of_block[i] + ridge[i] + gap[i])
    }

    /// Strain because the voxel below is hotter or colder than its block.
    ///
    /// Material whose thermal strain varies along one axis follows it (1 + ν) times along this axis
    /// and not at all along the other one.
    /// The axis is that of the second differences of the temperature: their tensor divided by its
    /// trace is the projection on the axis.
    fn ridge(&self, [x, y, z]: [u32; 3], temperatures: &impl Temperatures) -> Strain {
        let Some(below) = z.checked_sub(1).map(|z| [x, y, z]) else {
            return [0.0; 3];
        };
        let solid = |voxel: [u32; 3]| Some(temperatures.celsius(voxel)?.min(self.transition_c));
        let Some(celsius) = solid(below).filter(|_| self.is_locked(below)) else {
            return [0.0; 3];
        };
        let at = |step: [i32; 2]| solid(beside(below, step)).unwrap_or(celsius);
        let along_x = at([-1, 0]) - 2.0 * celsius + at([1, 0]);
        let along_y = at([0, -1]) - 2.0 * celsius + at([0, 1]);
        let mixed = (at([-1, -1]) - at([1, -1]) - at([-1, 1]) + at([1, 1])) / 4.0;
        let trace = along_x.abs() + along_y.abs();
        if trace == 0.0 {
            return [0.0; 3];
        }
        let block = &self.blocks[self.block(below)];
        let excess = celsius - block.heat / block.count as f64;
        let strain = (1.0 + POISSON) * self.expansion * excess;
        // Of a projection, the mixed component is at most the geometric mean of the others.
        let limit = (along_x * along_y).abs().sqrt();
        let mixed = mixed.clamp(-limit, limit) * (along_x + along_y).signum();
        [along_x.abs(), along_y.abs(), mixed].map(|share| strain * share / trace)
    }

    /// Strain because neighbours in the same layer have shrunk away from a voxel that locks now.
    ///
    /// Half of what a solid neighbour has shrunk since it was at the glass transition is on the
    /// side of the voxel.
    fn gap(&self, voxel: [u32; 3], temperatures: &impl Temperatures) -> Strain {
        let width = |step: [i32; 2]| {
            let neighbour = beside(voxel, step);
            match temperatures.celsius(neighbour) {
                Some(celsius) if self.is_locked(neighbour) => {
                    self.expansion * (self.transition_c - celsius).max(0.0) / 2.0
                }
                _ => 0.0,
            }
        };
        let [left, right] = [[-1, 0], [1, 0]].map(width);
        let [back, front] = [[0, -1], [0, 1]].map(width);
        // Gaps along both axes are one gap along a diagonal.
        let shear = left.min(back) + right.min(front) - left.min(front) - right.min(back);
        [left + right, back + front, shear]
    }

    fn lock(&mut self, &Candidate { voxel, celsius }: &Candidate, [x, y, shear]: Strain) {
        let at_transition = self.expansion * self.transition_c;
        let strain = [x - at_transition, y - at_transition, shear].map(|strain| strain as f32);
        let (index, number, z) = (self.index(voxel), self.block(voxel), voxel[2] as usize);
        self.locked[index] = strain;
        self.unlocked[z] -= 1;
        let heat = celsius.min(self.transition_c);
        self.heat[z * self.blocks.len() + number] += heat;
        let block = &mut self.blocks[number];
        block.count += 1;
        block.heat += heat;
        block.strain.iter_mut().zip(strain).for_each(|(sum, strain)| *sum += f64::from(strain));
    }

    /// Unlocks a voxel; its temperature is subtracted from the sums when its layer has been read.
    fn unlock(&mut self, voxel: [u32; 3]) {
        let (index, number) = (self.index(voxel), self.block(voxel));
        let strain = std::mem::replace(&mut self.locked[index], [f32::NAN; 3]);
        self.unlocked[voxel[2] as usize] += 1;
        let block = &mut self.blocks[number];
        block.count -= 1;
        block.strain.iter_mut().zip(strain).for_each(|(sum, strain)| *sum -= f64::from(strain));
    }
}

/// The position some steps from a voxel along x and y; positions outside the grid are huge.
fn beside([x, y, z]: [u32; 3], [along_x, along_y]: [i32; 2]) -> [u32; 3] {
    [x.wrapping_add_signed(along_x), y.wrapping_add_signed(along_y), z]
}

#[cfg(test)]
mod tests;
