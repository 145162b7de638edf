//! The layers of a sliced part.

use beadwork_grid::{Region, Zones};
use ndarray::{Array3, ArrayView2};

use super::plane_sweep::plane_mm;
use super::voxels::Voxels;
use crate::frame::Frame;

/// One layer of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Its cells.
    pub region: Region,
    /// The material of each cell, which is the number of the tool that prints it.
    pub zones: Zones,
}

impl Layer {
    /// The materials of all cells of the grid, axes `[y, x]`; [`Voxels::EMPTY`] outside the region.
    pub fn materials(&self) -> ArrayView2<'_, u8> {
        self.zones.view(&self.region)
    }
}

/// All layers of a part from the bottom up; all have the same grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Position of the grid, and sizes of cells and layers.
    pub frame: Frame,
    /// The layers; `None` where the part has no cell at that height.
    pub layers: Vec<Option<Layer>>,
}

impl Layers {
    /// The cells of all layers as one array.
    pub fn voxels(&self) -> Voxels {
        let (width, height) = (self.frame.width as usize, self.frame.height as usize);
        let mut materials = Vec::with_capacity(width * height * self.layers.len());
        for layer in &self.layers {
            match layer {
                Some(layer) => materials.extend_from_slice(layer.zones.ids()),
                None => materials.resize(materials.len() + width * height, Voxels::EMPTY),
            }
        }
        let materials = Array3::from_shape_vec((self.layers.len(), height, width), materials)
            .expect("each layer adds one value for each cell of the grid");
        Voxels::new(self.frame, materials)
    }

    /// Number of layers without cells at the bottom, as a tip thinner than a bead has them.
    pub fn empty_below(&self) -> usize {
        self.layers.iter().take_while(|layer| layer.is_none()).count()
    }

    /// The lowest layer without cells between layers with cells, if there is one: everything above
    /// it would be printed in the air.
    pub fn gap(&self) -> Option<usize> {
        let last = self.layers.iter().rposition(Option::is_some)?;
        (self.empty_below()..last).find(|&layer| self.layers[layer].is_none())
    }

    /// Height at which a layer was cut, in mm: the centre of the layer.
    pub fn cut_mm(&self, layer: usize) -> f64 {
        plane_mm(layer, self.frame.layer_mm)
    }

    /// Number of cells in all layers.
    pub fn cell_count(&self) -> u64 {
        self.layers.iter().flatten().map(|layer| u64::from(layer.region.cell_count())).sum()
    }

    /// Number of tools: one more than the highest number of a material.
    pub fn tools(&self) -> u32 {
        self.layers.iter().flatten().map(|layer| layer.zones.count()).max().unwrap_or(0)
    }
}
