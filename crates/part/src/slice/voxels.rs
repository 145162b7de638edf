//! A part as one array of voxels.

use beadwork_grid::{Cell, Region, RegionError, Zones};

use crate::frame::Frame;

/// The voxels of a part: one cell of one layer each.
///
/// Indexed `[z, y, x]`, x fastest: layers from the bottom up, rows from the back to the front (y
/// down, as in a layer), columns from the left.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxels {
    /// Where they lie, and how large they are; its width and height are those of every layer.
    pub frame: Frame,
    /// Layers.
    pub depth: usize,
    materials: Vec<u8>,
}

impl Voxels {
    /// What stands for a voxel that is not filled.
    pub const EMPTY: u8 = Zones::OUTSIDE;

    /// From one number for each voxel: its material, or [`Voxels::EMPTY`].
    ///
    /// # Panics
    /// If there are not as many numbers as voxels.
    pub fn new(frame: Frame, depth: usize, materials: Vec<u8>) -> Self {
        let plane = frame.width as usize * frame.height as usize;
        assert_eq!(materials.len(), depth * plane, "one number for each voxel");
        Self { frame, depth, materials }
    }

    /// The materials of all voxels, `[z, y, x]`, [`Voxels::EMPTY`] where there is none.
    pub fn materials(&self) -> &[u8] {
        &self.materials
    }

    /// The material of a voxel, or `None` if it is not filled; also outside the array.
    pub fn material(&self, x: u32, y: u32, z: usize) -> Option<u8> {
        if x >= self.frame.width || y >= self.frame.height || z >= self.depth {
            return None;
        }
        let plane = self.layer(z);
        Some(plane[(y * self.frame.width + x) as usize]).filter(|&material| material != Self::EMPTY)
    }

    /// The materials of one layer, `[y, x]`.
    ///
    /// # Panics
    /// If there is no such layer.
    pub fn layer(&self, z: usize) -> &[u8] {
        let plane = self.frame.width as usize * self.frame.height as usize;
        &self.materials[z * plane..(z + 1) * plane]
    }

    /// The filled voxels of one layer, by the numbers of their cells, rising.
    pub fn cells(&self, z: usize) -> impl Iterator<Item = Cell> {
        (0..)
            .zip(self.layer(z))
            .filter(|&(_, &material)| material != Self::EMPTY)
            .map(|(cell, _)| cell)
    }

    /// The filled voxels of one layer.
    pub fn region(&self, z: usize) -> Result<Region, RegionError> {
        let inside = self.layer(z).iter().map(|&material| material != Self::EMPTY).collect();
        Region::from_mask(self.frame.width, self.frame.height, inside)
    }

    /// Number of filled voxels.
    pub fn count(&self) -> usize {
        self.materials.iter().filter(|&&material| material != Self::EMPTY).count()
    }

    /// Their volume in mm³.
    pub fn volume_mm3(&self) -> f64 {
        self.count() as f64 * self.frame.cell_mm3()
    }
}
