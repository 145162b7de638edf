//! Temperatures on a plane through the part.

use ndarray::Array2;

use crate::simulation::Simulation;

/// A plane through the part, one voxel thick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Plane {
    /// The voxels at this x.
    X(u32),
    /// The voxels at this y.
    Y(u32),
    /// The voxels of this layer.
    Layer(u32),
}

/// Temperatures on a plane through the part.
///
/// Arrays have the axes `[z, y, x]` without the one that is fixed: `[z, y]` on [`Plane::X`],
/// `[z, x]` on [`Plane::Y`] and `[y, x]` on [`Plane::Layer`].
/// Row 0 of a vertical section is layer 0, so an upright picture shows the rows from the bottom up.
#[derive(Clone, Debug)]
pub struct Section {
    /// The plane.
    pub plane: Plane,
    /// Temperatures, °C; NaN where nothing is deposited.
    pub temperatures_c: Array2<f64>,
}

impl Simulation {
    /// Temperatures on a plane; all NaN if it lies outside the part.
    /// Linear in the plane's voxels.
    pub fn section(&self, plane: Plane) -> Section {
        let (frame, depth) = (&self.part().frame, self.part().depth);
        let (width, height) = (frame.width as usize, frame.height as usize);
        let shape = match plane {
            Plane::X(_) => (depth, height),
            Plane::Y(_) => (depth, width),
            Plane::Layer(_) => (height, width),
        };
        let voxel = |row: u32, column: u32| match plane {
            Plane::X(x) => [x, column, row],
            Plane::Y(y) => [column, y, row],
            Plane::Layer(z) => [column, row, z],
        };
        let temperatures_c = Array2::from_shape_fn(shape, |(row, column)| {
            self.temperature_c(voxel(row as u32, column as u32)).unwrap_or(f64::NAN)
        });
        Section { plane, temperatures_c }
    }
}

impl Section {
    /// Mean of all temperatures on the plane, °C; `None` if nothing is deposited there.
    pub fn mean_c(&self) -> Option<f64> {
        let deposited = || self.temperatures_c.iter().filter(|celsius| !celsius.is_nan());
        let count = deposited().count();
        (count > 0).then(|| deposited().sum::<f64>() / count as f64)
    }

    /// The thermal deviation of each voxel, K, with the axes of the temperatures: the plane's mean
    /// minus the voxel's temperature (Kim et al. 2026, figure 10), so that cold voxels have
    /// positive deviations.
    /// NaN where nothing is deposited.
    pub fn deviation_k(&self) -> Array2<f64> {
        let mean_c = self.mean_c().unwrap_or(f64::NAN);
        self.temperatures_c.mapv(|celsius| mean_c - celsius)
    }

    /// Maximum of the absolute thermal deviations, K; `None` if nothing is deposited on the plane.
    pub fn max_deviation_k(&self) -> Option<f64> {
        let deviations = self.deviation_k();
        deviations.iter().filter(|k| !k.is_nan()).map(|k| k.abs()).reduce(f64::max)
    }
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;
    use crate::testing::{half_printed, stairs};

    #[test]
    fn sections_meet_in_the_same_voxels() {
        let simulation = half_printed(&stairs(13, 7, 5));
        let (by_x, by_y) = (simulation.section(Plane::X(6)), simulation.section(Plane::Y(2)));
        assert_eq!((by_x.temperatures_c.dim(), by_y.temperatures_c.dim()), ((5, 7), (5, 13)));
        for z in 0..5u32 {
            let layer = simulation.section(Plane::Layer(z));
            assert_eq!(layer.temperatures_c.dim(), (7, 13));
            let row = z as usize;
            let common = [
                by_x.temperatures_c[[row, 2]],
                by_y.temperatures_c[[row, 6]],
                layer.temperatures_c[[2, 6]],
            ];
            assert!(common.iter().all(|celsius| celsius.to_bits() == common[0].to_bits()));
            let (mean, statistics) = (layer.mean_c(), simulation.layer_statistics(z));
            assert_eq!(mean.is_some(), statistics.is_some());
            let near = |(mean, own): (f64, f64)| (mean - own).abs() < 1e-9;
            assert!(mean.zip(statistics.map(|all| all.mean_c)).is_none_or(near));
        }
        assert_eq!(simulation.section(Plane::Layer(5)).max_deviation_k(), None);
    }

    #[test]
    fn deviation_is_the_mean_minus_the_temperature() {
        let temperatures_c = array![[60.0, f64::NAN], [90.0, 30.0]];
        let section = Section { plane: Plane::X(0), temperatures_c };
        assert_eq!(section.mean_c(), Some(60.0));
        let deviations = section.deviation_k();
        assert!(deviations[[0, 1]].is_nan());
        let others: Vec<f64> = deviations.into_iter().filter(|k| !k.is_nan()).collect();
        assert_eq!(others, [0.0, -30.0, 30.0]);
        assert_eq!(section.max_deviation_k(), Some(30.0));
    }
}
