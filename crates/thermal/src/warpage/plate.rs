//! A plate that some cause bends, free at its edges.
//!
//! Of all deflections w, the plate takes the one of least energy (Kirchhoff's theory, Poisson's
//! ratio 0):
//!
//! `Σ D ((w_xx - κ)² + (w_yy - κ)² + 2 w_xy²)`,
//!
//! with κ the curvature each place would take alone and D its stiffness.
//! Second differences stand for derivatives: those along an axis wherever three cells lie in a row,
//! the mixed one on each square of four.
//! No condition at the edges is needed, so that plates may have any outline and holes.
//! One κ everywhere makes a paraboloid, exactly.

/// The cells of a plate, `[y, x]`.
#[derive(Clone, Debug)]
pub(super) struct Plate {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Distance of cells.
    pub(super) spacing: f64,
    /// Stiffness against bending, in any unit; 0 where there is no plate.
    pub(super) stiffness: Vec<f64>,
    /// The curvature each cell would take alone, in one over the unit of `spacing`.
    pub(super) curvature: Vec<f64>,
}

/// Ties each cell to the ground, by so much of its own stiffness: no more than what fixes how parts
/// of a plate that nothing else holds lie in space.
const TIE: f64 = 1e-10;

impl Plate {
    /// The deflection of each cell above the plane that fits all best, in the unit of `spacing`; 0
    /// outside the plate.
    ///
    /// Costs the number of cells times the square of the shorter side.
    pub(super) fn deflection(&self) -> Vec<f64> {
        let cells: Vec<[usize; 2]> = self.cells().collect();
        if cells.is_empty() {
            return vec![0.0; self.stiffness.len()];
        }
        // Numbered along the shorter side, neighbours have near numbers.
        let mut sorted = cells.clone();
        sorted.sort_by_key(|&[x, y]| if self.width < self.height { [y, x] } else { [x, y] });
        let mut numbers = vec![usize::MAX; self.stiffness.len()];
        (0..).zip(&sorted).for_each(|(number, &[x, y])| numbers[y * self.width + x] = number);
        let terms: Vec<Term> = self.terms(&cells, &numbers).collect();
        let mut system =
            Banded::zero(cells.len(), terms.iter().map(Term::reach).max().unwrap_or(0));
        let mut right = vec![0.0; cells.len()];
        for (number, &[x, y]) in sorted.iter().enumerate() {
            *system.at(number, number) += TIE * self.stiffness[y * self.width + x];
        }
        for term in &terms {
            for &(i, a) in term.entries() {
                right[i] += term.weight * a * term.target;
                for &(j, b) in term.entries().iter().filter(|&&(j, _)| j <= i) {
                    *system.at(i, j) += term.weight * a * b;
                }
            }
        }
        system.solve(&mut right);
        let mut deflection: Vec<f64> =
            numbers.iter().map(|&number| right.get(number).copied().unwrap_or(0.0)).collect();
        self.level(&cells, &mut deflection);
        deflection
    }

    pub(super) fn cells(&self) -> impl Iterator<Item = [usize; 2]> {
        let all = (0..self.height).flat_map(|y| (0..self.width).map(move |x| [x, y]));
        all.filter(|&[x, y]| self.stiffness[y * self.width + x] > 0.0)
    }

    /// All differences that the energy is made of.
    fn terms(&self, cells: &[[usize; 2]], numbers: &[usize]) -> impl Iterator<Item = Term> {
        let number = |x: usize, y: usize| {
            let inside = x < self.width && y < self.height;
            inside.then(|| numbers[y * self.width + x]).filter(|&number| number != usize::MAX)
        };
        cells.iter().flat_map(move |&[x, y]| {
            let of = |numbers: &[f64], [x, y]: [usize; 2]| numbers[y * self.width + x];
            let bent = |ends: [Option<usize>; 2]| {
                let [a, c] = ends;
                let entries = [(a?, 1.0), (number(x, y)?, -2.0), (c?, 1.0), (0, 0.0)];
                let target = of(&self.curvature, [x, y]) * self.spacing * self.spacing;
                Some(Term { entries, count: 3, target, weight: of(&self.stiffness, [x, y]) })
            };
            let twisted = || {
                let entries = [
                    (number(x, y)?, 1.0),
                    (number(x + 1, y)?, -1.0),
                    (number(x, y + 1)?, -1.0),
                    (number(x + 1, y + 1)?, 1.0),
                ];
                let corners = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
                // Their mean, twice: the energy has the mixed derivative twice.
                let weight =
                    corners.map(|corner| of(&self.stiffness, corner)).iter().sum::<f64>() / 2.0;
                Some(Term { entries, count: 4, target: 0.0, weight })
            };
            let along_x = bent([number(x.wrapping_sub(1), y), number(x + 1, y)]);
            let along_y = bent([number(x, y.wrapping_sub(1)), number(x, y + 1)]);
            [along_x, along_y, twisted()].into_iter().flatten()
        })
    }

    /// Takes the best-fitting plane away.
    fn level(&self, cells: &[[usize; 2]], deflection: &mut [f64]) {
        let count = cells.len() as f64;
        let mean = |of: &dyn Fn([usize; 2]) -> f64| {
            cells.iter().map(|&cell| of(cell)).sum::<f64>() / count
        };
        let at = |[x, y]: [usize; 2]| y * self.width + x;
        let (x0, y0) = (mean(&|[x, _]| x as f64), mean(&|[_, y]| y as f64));
        let away = |[x, y]: [usize; 2]| (x as f64 - x0, y as f64 - y0);
        let w0 = mean(&|cell| deflection[at(cell)]);
        let product = |of: &dyn Fn(f64, f64, f64) -> f64| {
            mean(&|cell| of(away(cell).0, away(cell).1, deflection[at(cell)] - w0))
        };
        let (xy, xw, yw) =
            (product(&|x, y, _| x * y), product(&|x, _, w| x * w), product(&|_, y, w| y * w));
        // A line of cells has no slope across it: a little more than its true moments gives it 0.
        let more = 1e-12 * product(&|x, y, _| x * x + y * y) + f64::MIN_POSITIVE;
        let (xx, yy) = (product(&|x, _, _| x * x) + more, product(&|_, y, _| y * y) + more);
        let determinant = xx * yy - xy * xy;
        let (by_x, by_y) = ((yy * xw - xy * yw) / determinant, (xx * yw - xy * xw) / determinant);
        for &cell in cells {
            let (x, y) = away(cell);
            deflection[at(cell)] -= w0 + by_x * x + by_y * y;
        }
    }
}

/// weight (Σ factor w - target)²
struct Term {
    entries: [(usize, f64); 4],
    count: usize,
    target: f64,
    weight: f64,
}

impl Term {
    fn entries(&self) -> &[(usize, f64)] {
        &self.entries[..self.count]
    }

    /// The largest difference of its numbers.
    fn reach(&self) -> usize {
        let numbers = || self.entries().iter().map(|&(number, _)| number);
        numbers().max().unwrap_or(0) - numbers().min().unwrap_or(0)
    }
}

/// The lower half of a symmetric matrix with nothing far from its diagonal.
struct Banded {
    band: usize,
    /// Of each row, the numbers up to the diagonal.
    rows: Vec<f64>,
}

impl Banded {
    fn zero(size: usize, band: usize) -> Self {
        Self { band, rows: vec![0.0; size * (band + 1)] }
    }

    /// The number in row `i` and column `j`, no farther left of the diagonal than the band.
    fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        &mut self.rows[i * (self.band + 1) + self.band + j - i]
    }

    /// Solves for a right side, in its place, by Cholesky's factors.
    /// The matrix is lost.
    fn solve(mut self, right: &mut [f64]) {
        let (band, stride) = (self.band, self.band + 1);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for i in 0..right.len() {
            let (done, rest) = self.rows.split_at_mut(i * stride);
            let row = &mut rest[..stride];
            let first = i.saturating_sub(band);
            for j in first..i {
                let other = &done[j * stride..(j + 1) * stride];
                // Columns from `first` to j: at the end of the other row, and so far before this
                // one's end.
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
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate(width: usize, height: usize, inside: impl Fn(usize, usize) -> bool) -> Plate {
        let at = |i: usize| if inside(i % width, i / width) { 2.0 } else { 0.0 };
        let stiffness = (0..width * height).map(at).collect();
        Plate { width, height, spacing: 0.5, stiffness, curvature: vec![0.1; width * height] }
    }

    fn assert_paraboloid(plate: &Plate) {
        // What is left of a paraboloid of the curvature must be level.
        let mut rest = plate.deflection();
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
        // As many stiffnesses as there are cells make no difference to what all agree on.
        let mut uneven = plate(20, 9, |_, _| true);
        (1..).zip(&mut uneven.stiffness).for_each(|(i, stiffness)| *stiffness = f64::from(i * i));
        assert_paraboloid(&uneven);
    }

    #[test]
    fn a_strip_is_integrated_twice() {
        let mut strip = plate(41, 1, |_, _| true);
        (0..)
            .zip(&mut strip.curvature)
            .for_each(|(x, curvature)| *curvature = f64::from(x % 7) - 2.0);
        let w = strip.deflection();
        for x in 1..40 {
            let bent = (w[x - 1] - 2.0 * w[x] + w[x + 1]) / 0.25;
            assert!((bent - strip.curvature[x]).abs() < 1e-3, "{x}: {bent}");
        }
    }

    #[test]
    fn a_mirrored_plate_bends_as_the_mirror_shows() {
        let mut one = plate(12, 8, |x, y| x + y > 2);
        (0..)
            .zip(&mut one.curvature)
            .for_each(|(i, curvature)| *curvature = f64::from(i * 37 % 11));
        let mut other = one.clone();
        other.stiffness.chunks_mut(12).for_each(<[f64]>::reverse);
        other.curvature.chunks_mut(12).for_each(<[f64]>::reverse);
        let mut mirrored = other.deflection();
        mirrored.chunks_mut(12).for_each(<[f64]>::reverse);
        for (a, b) in one.deflection().into_iter().zip(mirrored) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
    }

    #[test]
    fn no_plate_and_lone_cells_lie_flat() {
        assert_eq!(plate(3, 3, |_, _| false).deflection(), [0.0; 9]);
        assert!(plate(3, 3, |x, y| x == y).deflection().iter().all(|w| w.abs() < 1e-12));
    }
}
