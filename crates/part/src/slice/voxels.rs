//! A part as one array of voxels.

use beadwork_grid::{Cell, Region, RegionError, Zones};
use ndarray::{Array3, ArrayView2, ArrayView3, Axis};

use crate::frame::Frame;

/// The voxels of a part: a voxel is one cell of one layer.
///
/// Axes are `[z, y, x]`: layers from the bottom up, rows from the back to the front (y down, as in
/// a [`Region`]), columns from the left.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxels {
    /// Position and size of the voxels; its width and height are those of every layer.
    pub frame: Frame,
    /// Number of layers.
    pub depth: usize,
    /// In standard layout: x varies fastest.
    materials: Array3<u8>,
}

impl Voxels {
    /// Value of a voxel that is not filled.
    pub const EMPTY: u8 = Zones::OUTSIDE;

    /// Voxels from an array `[z, y, x]` of material numbers, [`Voxels::EMPTY`] where there is none.
    ///
    /// # Panics
    /// If the layers of the array are not as wide and high as the frame.
    pub fn new(frame: Frame, materials: Array3<u8>) -> Self {
        let (depth, height, width) = materials.dim();
        assert_eq!(
            (width, height),
            (frame.width as usize, frame.height as usize),
            "a layer of the array has the width and height of the frame"
        );
        let materials = if materials.is_standard_layout() {
            materials
        } else {
            materials.as_standard_layout().into_owned()
        };
        Self { frame, depth, materials }
    }

    /// The materials of all voxels, axes `[z, y, x]`; [`Voxels::EMPTY`] where there is none.
    /// The view is contiguous, x fastest.
    pub fn materials(&self) -> ArrayView3<'_, u8> {
        self.materials.view()
    }

    /// The material of a voxel, or `None` if it is not filled or lies outside the array.
    pub fn material(&self, x: u32, y: u32, z: usize) -> Option<u8> {
        let material = *self.materials.get([z, y as usize, x as usize])?;
        (material != Self::EMPTY).then_some(material)
    }

    /// The materials of one layer, axes `[y, x]`; [`Voxels::EMPTY`] where there is none.
    ///
    /// # Panics
    /// If there is no such layer.
    pub fn layer(&self, z: usize) -> ArrayView2<'_, u8> {
        self.materials.index_axis(Axis(0), z)
    }

    /// The cells of the filled voxels of one layer, in ascending order.
    ///
    /// # Panics
    /// If there is no such layer.
    pub fn cells(&self, z: usize) -> impl Iterator<Item = Cell> {
        (0..)
            .zip(self.layer_slice(z))
            .filter(|&(_, &material)| material != Self::EMPTY)
            .map(|(cell, _)| cell)
    }

    /// The filled voxels of one layer.
    ///
    /// # Errors
    /// If the layer has none.
    ///
    /// # Panics
    /// If there is no such layer.
    pub fn region(&self, z: usize) -> Result<Region, RegionError> {
        let inside = self.layer_slice(z).iter().map(|&material| material != Self::EMPTY).collect();
        Region::from_mask(self.frame.width, self.frame.height, inside)
    }

    /// Number of filled voxels.
    pub fn count(&self) -> usize {
        self.materials.iter().filter(|&&material| material != Self::EMPTY).count()
    }

    /// Volume of the filled voxels in mm³.
    pub fn volume_mm3(&self) -> f64 {
        self.count() as f64 * self.frame.cell_mm3()
    }

    fn layer_slice(&self, z: usize) -> &[u8] {
        let all = self.materials.as_slice().expect("the constructor made the layout standard");
        let cells = self.frame.width as usize * self.frame.height as usize;
        &all[z * cells..(z + 1) * cells]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_any_layout_are_indexed_by_layer_row_and_column() {
        let frame =
            Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 4, height: 3 };
        let number = |z: usize, y: usize, x: usize| (z * 12 + y * 4 + x) as u8;
        let rows_first = Array3::from_shape_fn((2, 3, 4), |(z, y, x)| number(z, y, x));
        let columns_first = Array3::from_shape_fn((4, 3, 2), |(x, y, z)| number(z, y, x));
        let voxels = Voxels::new(frame, rows_first);
        assert_eq!(voxels, Voxels::new(frame, columns_first.reversed_axes()));
        assert_eq!((voxels.depth, voxels.count()), (2, 24));
        assert_eq!(voxels.material(3, 1, 1), Some(19));
        assert_eq!((voxels.material(4, 0, 0), voxels.material(0, 0, 2)), (None, None));
        assert_eq!(voxels.layer(1)[[1, 3]], 19);
        assert!(voxels.cells(1).eq(0..12));
        assert_eq!(voxels.materials().as_slice().map(<[u8]>::len), Some(24));
    }

    #[test]
    #[should_panic(expected = "the width and height of the frame")]
    fn arrays_of_another_size_are_refused() {
        let frame =
            Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 4, height: 3 };
        let _ = Voxels::new(frame, Array3::zeros((2, 4, 3)));
    }
}
