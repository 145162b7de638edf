//! An elastic plate with free edges that takes the shape of minimum bending energy.
//!
//! Each cell of the plate has a bending stiffness D and curvatures κx, κy and κxy that it would
//! take alone.
//! Of all deflections w, the plate takes the one that minimizes the energy (Kirchhoff plate theory,
//! with Poisson's ratio 0)
//!
//! `Σ D ((w_xx - κx)² + (w_yy - κy)² + 2 (w_xy - κxy)²)`.
//!
//! Derivatives are second differences: those along an axis wherever three cells lie in a row, the
//! mixed one on each square of four cells.
//! Free edges are the natural boundary condition of this energy, so edges need no equations, and a
//! plate may have any outline and holes.
//! With the same curvatures everywhere, the result is exactly a paraboloid.

use beadwork_base::{Control, Interrupted};

/// The cells of a plate, `[y, x]`.
#[derive(Clone, Debug)]
pub(super) struct Plate {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Distance between the centres of neighbouring cells.
    pub(super) spacing: f64,
    /// Bending stiffness, in any unit; 0 where there is no plate.
    pub(super) stiffness: Vec<f64>,
    /// The curvatures `w_xx`, `w_yy` and `w_xy` that each cell would take alone, in one over the
    /// unit of `spacing`.
    pub(super) curvature: Vec<[f64; 3]>,
}

/// Stiffness of a spring that holds each cell at 0, as a fraction of the cell's bending stiffness.
///
/// The energy does not change if the plate, or one of several connected pieces of it, is moved or
/// tilted; the springs make the system of equations positive definite, and are too weak to matter
/// otherwise.
const SPRING: f64 = 1e-10;

/// Rows of the system between two polls of the control.
const ROWS_PER_POLL: usize = 16;

impl Plate {
    /// The deflection of each cell above the best-fitting plane, in the unit of `spacing`; 0
    /// outside the plate.
    ///
    /// Costs the number of cells times the square of the shorter side.
    /// Progress counts cells of the plate.
    pub(super) fn deflection(&self, control: &Control<'_>) -> Result<Vec<f64>, Interrupted> {
        let cells: Vec<[usize; 2]> = self.cells().collect();
        if cells.is_empty() {
            return Ok(vec![0.0; self.stiffness.len()]);
        }
        // Numbered along the shorter side, neighbours have close numbers and the band is narrow.
        let mut sorted = cells.clone();
        sorted.sort_by_key(|&[x, y]| if self.width < self.height { [y, x] } else { [x, y] });
        let mut numbers = vec![usize::MAX; self.stiffness.len()];
        (0..).zip(&sorted).for_each(|(number, &[x, y])| numbers[y * self.width + x] = number);
        let terms: Vec<Term> = self.terms(&cells, &numbers).collect();
        let bandwidth = terms.iter().map(Term::bandwidth).max().unwrap_or(0);
        // The energy is a sum of squares, so its minimum is the solution of a least-squares
        // problem: these are the normal equations.
        let mut system = BandedMatrix::zero(cells.len(), bandwidth);
        let mut right = vec![0.0; cells.len()];
        for (number, &[x, y]) in sorted.iter().enumerate() {
            *system.at(number, number) += SPRING * self.stiffness[y * self.width + x];
        }
        for term in &terms {
            for &(i, a) in term.entries() {
                right[i] += term.weight * a * term.target;
                for &(j, b) in term.entries().iter().filter(|&&(j, _)| j <= i) {
                    *system.at(i, j) += term.weight * a * b;
                }
            }
        }
        system.solve(&mut right, control)?;
        let mut deflection: Vec<f64> =
            numbers.iter().map(|&number| right.get(number).copied().unwrap_or(0.0)).collect();
        self.level(&cells, &mut deflection);
        Ok(deflection)
    }

    /// x and y of all cells, row by row.
    pub(super) fn cells(&self) -> impl Iterator<Item = [usize; 2]> {
        let all = (0..self.height).flat_map(|y| (0..self.width).map(move |x| [x, y]));
        all.filter(|&[x, y]| self.stiffness[y * self.width + x] > 0.0)
    }

    /// The squared differences that add up to the energy.
    fn terms(&self, cells: &[[usize; 2]], numbers: &[usize]) -> impl Iterator<Item = Term> {
        let number = |x: usize, y: usize| {
            let inside = x < self.width && y < self.height;
            inside.then(|| numbers[y * self.width + x]).filter(|&number| number != usize::MAX)
        };
        cells.iter().flat_map(move |&[x, y]| {
            let at = |[x, y]: [usize; 2]| y * self.width + x;
            let area = self.spacing * self.spacing;
            let bending = |ends: [Option<usize>; 2], axis: usize| {
                let [a, c] = ends;
                let entries = [(a?, 1.0), (number(x, y)?, -2.0), (c?, 1.0), (0, 0.0)];
                let target = self.curvature[at([x, y])][axis] * area;
                Some(Term { entries, count: 3, target, weight: self.stiffness[at([x, y])] })
            };
            let twisting = || {
                let entries = [
                    (number(x, y)?, 1.0),
                    (number(x + 1, y)?, -1.0),
                    (number(x, y + 1)?, -1.0),
                    (number(x + 1, y + 1)?, 1.0),
                ];
                let corners = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
                // Twice the mean stiffness, as the energy has the mixed derivative twice.
                let weight =
                    corners.map(|corner| self.stiffness[at(corner)]).iter().sum::<f64>() / 2.0;
                let twist = corners.map(|corner| self.curvature[at(corner)][2]).iter().sum::<f64>();
                Some(Term { entries, count: 4, target: twist / 4.0 * area, weight })
            };
            let along_x = bending([number(x.wrapping_sub(1), y), number(x + 1, y)], 0);
            let along_y = bending([number(x, y.wrapping_sub(1)), number(x, y + 1)], 1);
            [along_x, along_y, twisting()].into_iter().flatten()
        })
    }

    /// Subtracts the best-fitting plane.
    fn level(&self, cells: &[[usize; 2]], deflection: &mut [f64]) {
        let count = cells.len() as f64;
        let mean = |value: &dyn Fn([usize; 2]) -> f64| {
            cells.iter().map(|&cell| value(cell)).sum::<f64>() / count
        };
        let at = |[x, y]: [usize; 2]| y * self.width + x;
        let (x0, y0) = (mean(&|[x, _]| x as f64), mean(&|[_, y]| y as f64));
        let centred = |[x, y]: [usize; 2]| (x as f64 - x0, y as f64 - y0);
        let w0 = mean(&|cell| deflection[at(cell)]);
        let moment = |value: &dyn Fn(f64, f64, f64) -> f64| {
            mean(&|cell| value(centred(cell).0, centred(cell).1, deflection[at(cell)] - w0))
        };
        let (xy, xw, yw) =
            (moment(&|x, y, _| x * y), moment(&|x, _, w| x * w), moment(&|_, y, w| y * w));
        // For a single row of cells, the slope across the row is undetermined and the matrix
        // singular: a small addition to the diagonal makes that slope 0.
        let more = 1e-12 * moment(&|x, y, _| x * x + y * y) + f64::MIN_POSITIVE;
        let (xx, yy) = (moment(&|x, _, _| x * x) + more, moment(&|_, y, _| y * y) + more);
        let determinant = xx * yy - xy * xy;
        let (by_x, by_y) = ((yy * xw - xy * yw) / determinant, (xx * yw - xy * xw) / determinant);
        for &cell in cells {
            let (x, y) = centred(cell);
            deflection[at(cell)] -= w0 + by_x * x + by_y * y;
        }
    }
}

/// A term of the energy: weight (Σ factor w - target)².
struct Term {
    /// Numbers of cells, each with its factor.
    entries: [(usize, f64); 4],
    /// Number of entries that are used.
    count: usize,
    target: f64,
    weight: f64,
}

impl Term {
    fn entries(&self) -> &[(usize, f64)] {
        &self.entries[..self.count]
    }

    /// The largest difference between numbers of its cells.
    fn bandwidth(&self) -> usize {
        let numbers = || self.entries().iter().map(|&(number, _)| number);
        numbers().max().unwrap_or(0) - numbers().min().unwrap_or(0)
    }
}

/// The lower triangle of a symmetric banded matrix.
struct BandedMatrix {
    band: usize,
    /// The last `band` + 1 numbers of each row up to the diagonal.
    rows: Vec<f64>,
}

impl BandedMatrix {
    fn zero(size: usize, band: usize) -> Self {
        Self { band, rows: vec![0.0; size * (band + 1)] }
    }

    /// The number in row `i` and column `j`; `i - j` is from 0 to the bandwidth.
    fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        &mut self.rows[i * (self.band + 1) + self.band + j - i]
    }

    /// Solves a system by Cholesky decomposition, in place of its right side.
    ///
    /// The system is L Lᵀ x = `right`.
    /// One loop computes the rows of L and, row by row, solves L y = `right`, which needs only the
    /// rows of L up to the present one; a second loop solves Lᵀ x = y.
    fn solve(mut self, right: &mut [f64], control: &Control<'_>) -> Result<(), Interrupted> {
        let (band, stride) = (self.band, self.band + 1);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for i in 0..right.len() {
            if i % ROWS_PER_POLL == 0 {
                control.report(i, right.len());
                control.check()?;
            }
            let (done, rest) = self.rows.split_at_mut(i * stride);
            let row = &mut rest[..stride];
            let first = i.saturating_sub(band);
            for j in first..i {
                let other = &done[j * stride..(j + 1) * stride];
                // Columns `first` to j: they end at the diagonal of the other row, and i - j before
                // the diagonal of this one.
                let (start, len) = (band + first - i, j - first);
                let known = dot(&row[start..start + len], &other[band - len..band]);
                row[start + len] = (row[start + len] - known) / other[band];
            }
            let start = band + first - i;
            row[band] = (row[band] - dot(&row[start..band], &row[start..band])).sqrt();
            right[i] = (right[i] - dot(&row[start..band], &right[first..i])) / row[band];
        }
        for i in (0..right.len()).rev() {
            let row = &self.rows[i * stride..(i + 1) * stride];
            right[i] /= row[band];
            let (value, first) = (right[i], i.saturating_sub(band));
            let factors = &row[band + first - i..band];
            right[first..i]
                .iter_mut()
                .zip(factors)
                .for_each(|(other, factor)| *other -= factor * value);
        }
        control.report(right.len(), right.len());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate(width: usize, height: usize, inside: impl Fn(usize, usize) -> bool) -> Plate {
        let at = |i: usize| if inside(i % width, i / width) { 2.0 } else { 0.0 };
        let stiffness = (0..width * height).map(at).collect();
        let curvature = vec![[0.1, 0.1, 0.0]; width * height];
        Plate { width, height, spacing: 0.5, stiffness, curvature }
    }

    fn deflection(plate: &Plate) -> Vec<f64> {
        plate.deflection(&Control::default()).unwrap()
    }

    fn assert_paraboloid(plate: &Plate) {
        // Minus a paraboloid with the curvature, the deflection is a plane.
        let mut rest = deflection(plate);
        for [x, y] in plate.cells() {
            let (x_, y_) = (x as f64 * plate.spacing, y as f64 * plate.spacing);
            rest[y * plate.width + x] -= 0.05 * (x_ * x_ + y_ * y_);
        }
        let cells: Vec<_> = plate.cells().collect();
        plate.level(&cells, &mut rest);
        assert!(rest.iter().all(|w| w.abs() < 1e-4), "{rest:?}");
    }

    #[test]
    fn one_curvature_makes_a_paraboloid_whatever_the_outline() {
        assert_paraboloid(&plate(20, 9, |_, _| true));
        assert_paraboloid(&plate(9, 20, |_, _| true));
        assert_paraboloid(&plate(15, 15, |x, y| !(5..10).contains(&x) || y < 5));
        assert_paraboloid(&plate(15, 15, |x, y| !(5..10).contains(&x) || !(5..10).contains(&y)));
        assert_paraboloid(&plate(20, 1, |_, _| true));
        // Any stiffness gives the same shape, as all cells agree on it.
        let mut uneven = plate(20, 9, |_, _| true);
        (1..).zip(&mut uneven.stiffness).for_each(|(i, stiffness)| *stiffness = f64::from(i * i));
        assert_paraboloid(&uneven);
    }

    #[test]
    fn a_strip_is_integrated_twice() {
        let mut strip = plate(41, 1, |_, _| true);
        (0..)
            .zip(&mut strip.curvature)
            .for_each(|(x, curvature)| curvature[0] = f64::from(x % 7) - 2.0);
        let w = deflection(&strip);
        for x in 1..40 {
            let curvature = (w[x - 1] - 2.0 * w[x] + w[x + 1]) / 0.25;
            assert!((curvature - strip.curvature[x][0]).abs() < 1e-3, "{x}: {curvature}");
        }
    }

    #[test]
    fn a_mirrored_plate_has_the_mirrored_shape() {
        let mut one = plate(12, 8, |x, y| x + y > 2);
        (0..).zip(&mut one.curvature).for_each(|(i, curvature)| {
            *curvature = [f64::from(i * 37 % 11), f64::from(i % 3), 0.0];
        });
        let mut other = one.clone();
        other.stiffness.chunks_mut(12).for_each(<[f64]>::reverse);
        other.curvature.chunks_mut(12).for_each(<[[f64; 3]]>::reverse);
        let mut mirrored = deflection(&other);
        mirrored.chunks_mut(12).for_each(<[f64]>::reverse);
        for (a, b) in deflection(&one).into_iter().zip(mirrored) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
    }

    #[test]
    fn no_plate_and_single_cells_are_flat() {
        assert_eq!(deflection(&plate(3, 3, |_, _| false)), [0.0; 9]);
        assert!(deflection(&plate(3, 3, |x, y| x == y)).iter().all(|w| w.abs() < 1e-12));
    }
}
