//! All temperatures of a part at once, as arrays.

use std::sync::Arc;

use ndarray::{Array2, Array3, ArrayView3, Axis};
use thiserror::Error;

use super::setup::Simulation;
use crate::property;
use crate::rows::{Row, is_active};

/// Why a temperature field cannot be set.
/// The simulation is unchanged.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FieldError {
    /// The array's shape is not that of the part.
    #[error(
        "temperature field has shape {found:?}: the part has {expected:?} layers, rows and columns"
    )]
    Shape {
        /// Lengths of the array's axes.
        found: [usize; 3],
        /// Depth, height and width of the part.
        expected: [usize; 3],
    },
    /// The temperature of a deposited voxel is not finite, or out of range.
    #[error(
        "voxel {voxel:?} has a temperature of {celsius} °C: it must be from {} to {}",
        property::TEMPERATURE_RANGE_C[0],
        property::TEMPERATURE_RANGE_C[1]
    )]
    Temperature {
        /// x, y and z.
        voxel: [u32; 3],
        /// The temperature, °C.
        celsius: f64,
    },
}

impl Simulation {
    /// Temperatures of all voxels, °C, with the axes `[z, y, x]`; NaN where nothing is deposited.
    ///
    /// The shape is that of the part's bounding box: depth, height, width.
    /// Reads each row of voxels as a whole, about as fast as memory allows.
    pub fn temperatures_c(&self) -> Array3<f64> {
        let mut celsius = Array3::from_elem(self.field_shape(), f64::NAN);
        for row in self.rows(0..self.part.depth) {
            let mut out = celsius.index_axis_mut(Axis(0), row.z as usize);
            let mut out = out.index_axis_mut(Axis(0), row.y as usize);
            self.read_row(row, out.as_slice_mut().expect("a row of a standard array is a slice"));
        }
        celsius
    }

    /// Temperatures of a layer's voxels, °C, with the axes `[y, x]`; NaN where nothing is
    /// deposited, which is everywhere if the part has no such layer.
    pub fn layer_temperatures_c(&self, layer: u32) -> Array2<f64> {
        let [_, height, width] = self.field_shape();
        let mut celsius = Array2::from_elem([height, width], f64::NAN);
        let layer = layer as usize;
        for row in self.rows(layer..layer.saturating_add(1)) {
            let mut out = celsius.row_mut(row.y as usize);
            self.read_row(row, out.as_slice_mut().expect("a row of a standard array is a slice"));
        }
        celsius
    }

    /// Sets the temperatures of all deposited voxels, °C, so that the print can go on from a
    /// measured or predicted field.
    ///
    /// The array has the axes and the shape of [`Simulation::temperatures_c`]; its values where
    /// nothing is deposited are ignored, NaN included.
    /// Deposited voxels need temperatures from -273.15 to 1000 °C.
    /// Recorded substrate temperatures, time and the set of deposited voxels stay as they are.
    ///
    /// Setting a field that [`Simulation::temperatures_c`] has returned restores the same bits.
    /// The exception are voxels within 10⁻⁶ K of the ambient temperature: they may change by up to
    /// 10⁻¹³ K by rounding.
    /// The simulation stores each temperature as its difference from the ambient temperature, in
    /// single precision.
    /// If the difference is that small, adding the ambient temperature rounds it, even in double
    /// precision.
    ///
    /// [`Method::Fast`](super::Method::Fast) takes long steps away from recently deposited voxels
    /// and assumes that temperatures are smooth there, as they are in a print: the decay of sharp
    /// steps in the field is computed less accurately.
    /// Temperatures far above those of nozzle and plate make radiation so strong that explicit
    /// steps may become unstable.
    pub fn set_temperatures_c(&mut self, celsius: ArrayView3<'_, f64>) -> Result<(), FieldError> {
        let (found, expected) = (celsius.dim(), self.field_shape());
        if <[usize; 3]>::from(found) != expected {
            return Err(FieldError::Shape { found: found.into(), expected });
        }
        let [low, high] = property::TEMPERATURE_RANGE_C;
        for (voxel, _) in self.deposited(0..self.part.depth) {
            let [x, y, z] = voxel.map(|i| i as usize);
            let celsius = celsius[[z, y, x]];
            if !(low..=high).contains(&celsius) {
                return Err(FieldError::Temperature { voxel, celsius });
            }
        }
        let ambient_c = self.coefficients.ambient_c;
        let faces = self.state.occupancy.faces();
        let patch = Arc::make_mut(&mut self.state.patch);
        for (z, layer) in celsius.outer_iter().enumerate().take(self.state.top - 1) {
            for (y, row) in layer.outer_iter().enumerate() {
                let start = patch.shape.index([1, y + 1, z + 1]);
                let theta = &mut patch.theta[start..start + row.len()];
                let faces = &faces[start..start + row.len()];
                for ((theta, &faces), celsius) in theta.iter_mut().zip(faces).zip(row) {
                    if is_active(faces) {
                        *theta = (celsius - ambient_c) as f32;
                    }
                }
            }
        }
        Ok(())
    }

    /// Depth, height and width of the part.
    fn field_shape(&self) -> [usize; 3] {
        let frame = &self.part.frame;
        [self.part.depth, frame.height as usize, frame.width as usize]
    }

    fn read_row(&self, row: Row<'_>, out: &mut [f64]) {
        let ambient_c = self.coefficients.ambient_c;
        // The first number of a row is halo.
        let (theta, faces) = (&row.theta[1..][..out.len()], &row.faces[1..][..out.len()]);
        for ((out, &theta), &faces) in out.iter_mut().zip(theta).zip(faces) {
            *out = if is_active(faces) { f64::from(theta) + ambient_c } else { f64::NAN };
        }
    }
}
