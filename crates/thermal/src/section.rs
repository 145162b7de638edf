//! Cuts through a part.

use crate::simulation::Simulation;

/// A plane of voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Plane {
    /// All voxels of this x: columns run along y, rows along z.
    X(u32),
    /// All voxels of this y: columns run along x, rows along z.
    Y(u32),
    /// A layer: columns run along x, rows along y.
    Layer(u32),
}

/// Temperatures on a plane: the array `[z, y, x]` of the part's temperatures with one axis fixed.
///
/// So row 0 of an upright plane is layer 0: to draw it as it stands, the rows go from the bottom
/// up.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Which plane.
    pub plane: Plane,
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Temperatures, °C, `[row, column]`; `None` where nothing is deposited.
    pub celsius: Vec<Option<f64>>,
}

impl Simulation {
    /// Temperatures on a plane; all `None` if it lies outside the part.
    /// Linear in the plane's voxels.
    pub fn section(&self, plane: Plane) -> Section {
        let (frame, depth) = (&self.part().frame, self.part().depth);
        let (width, height) = (frame.width as usize, frame.height as usize);
        let (rows, columns) = match plane {
            Plane::X(_) => (depth, height),
            Plane::Y(_) => (depth, width),
            Plane::Layer(_) => (height, width),
        };
        let voxel = |row: u32, column: u32| match plane {
            Plane::X(x) => [x, column, row],
            Plane::Y(y) => [column, y, row],
            Plane::Layer(z) => [column, row, z],
        };
        let cells =
            (0..rows as u32).flat_map(|row| (0..columns as u32).map(move |column| (row, column)));
        let celsius = cells.map(|(row, column)| self.temperature_c(voxel(row, column))).collect();
        Section { plane, rows, columns, celsius }
    }
}

impl Section {
    /// The temperature at a row and a column, °C; `None` where nothing is deposited.
    ///
    /// # Panics
    /// If there is no such row or column.
    pub fn at(&self, row: usize, column: usize) -> Option<f64> {
        assert!(row < self.rows && column < self.columns, "{row}, {column} lies in the section");
        self.celsius[row * self.columns + column]
    }

    /// Mean of all temperatures on the plane, °C; `None` if there are none.
    pub fn mean_c(&self) -> Option<f64> {
        let count = self.celsius.iter().flatten().count();
        (count > 0).then(|| self.celsius.iter().flatten().sum::<f64>() / count as f64)
    }

    /// The thermal deviation at each place, K, `[row, column]`: the plane's mean less the
    /// temperature there (Kim et al. 2026, figure 10), so that cold places are positive.
    /// `None` where nothing is deposited.
    pub fn deviation_k(&self) -> Vec<Option<f64>> {
        let mean_c = self.mean_c();
        self.celsius.iter().map(|&celsius| Some(mean_c? - celsius?)).collect()
    }

    /// The largest thermal deviation, whatever its sign, K; `None` if nothing is deposited on the
    /// plane.
    pub fn largest_deviation_k(&self) -> Option<f64> {
        self.deviation_k().into_iter().flatten().map(f64::abs).reduce(f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{half_printed, stairs};

    #[test]
    fn sections_meet_in_the_same_voxels() {
        let simulation = half_printed(&stairs(13, 7, 5));
        let (by_x, by_y) = (simulation.section(Plane::X(6)), simulation.section(Plane::Y(2)));
        assert_eq!((by_x.rows, by_x.columns, by_y.rows, by_y.columns), (5, 7, 5, 13));
        for z in 0..5u32 {
            let layer = simulation.section(Plane::Layer(z));
            assert_eq!((layer.rows, layer.columns), (7, 13));
            assert_eq!(by_x.at(z as usize, 2), by_y.at(z as usize, 6));
            assert_eq!(by_x.at(z as usize, 2), layer.at(2, 6));
            let (mean, spread) = (layer.mean_c(), simulation.layer_spread(z));
            assert_eq!(mean.is_some(), spread.is_some());
            assert!(
                mean.zip(spread).is_none_or(|(mean, spread)| (mean - spread.mean_c).abs() < 1e-9)
            );
        }
        assert_eq!(simulation.section(Plane::Layer(5)).largest_deviation_k(), None);
    }

    #[test]
    fn deviation_is_the_mean_less_the_place() {
        let celsius = vec![Some(60.0), None, Some(90.0), Some(30.0)];
        let section = Section { plane: Plane::X(0), rows: 2, columns: 2, celsius };
        assert_eq!(section.mean_c(), Some(60.0));
        assert_eq!(section.deviation_k(), [Some(0.0), None, Some(-30.0), Some(30.0)]);
        assert_eq!(section.largest_deviation_k(), Some(30.0));
    }
}
