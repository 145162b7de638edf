//! A matrix of costs of changes between zones or between tools.

use thiserror::Error;

/// Costs of changes: of crossings from one zone to another, or of tool changes.
///
/// There is one cost for each ordered pair of zones or tools, which are numbered from 0. Costs are
/// nonnegative numbers in any one unit: the volume to purge in mm³, seconds, or simply 1 each.
/// The change from b to a need not cost the same as the one from a to b, and a detour over c may be
/// cheaper than the direct change.
/// [`f64::INFINITY`] forbids a change.
///
/// # Rounding
/// The searches work with integers: each cost times [`scale`](Self::scale), rounded to the nearest
/// integer.
/// - Whole numbers up to [`MAX_SCALED`](Self::MAX_SCALED) have the scale 1 and are not rounded.
/// - For decimal numbers the scale is the smallest power of ten that makes all of them integers up
///   to that limit; they are not rounded either.
/// - Otherwise the scale maps the largest cost to the limit, and each cost is rounded to a multiple
///   of [`resolution`](Self::resolution).
///
/// Results are reported in the caller's unit.
/// They, their bounds and their optimality refer to the rounded costs.
/// [`exact`](crate::exact) needs smaller integers than other methods, and rounds large ones down
/// for its search; this may lower its bounds, but they remain valid.
///
/// Invariant: the size is at most [`MAX_SIZE`](Self::MAX_SIZE), and the diagonal is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct CostMatrix {
    pub(super) size: usize,
    /// Row by row; at most `MAX_SCALED`, or `FORBIDDEN`.
    pub(super) scaled: Vec<u32>,
    pub(super) scale: f64,
}

/// Why a [`CostMatrix`] could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CostMatrixError {
    /// The matrix has more than [`CostMatrix::MAX_SIZE`] rows.
    #[error("cost matrix: {got} rows, expected at most {max}", max = CostMatrix::MAX_SIZE)]
    TooLarge {
        /// Number of rows.
        got: usize,
    },
    /// A row has another number of costs than the matrix has rows.
    #[error("cost matrix: row {row} has {got} costs, expected {expected}, one for each row")]
    NotSquare {
        /// Number of the row, from 0.
        row: usize,
        /// Number of rows.
        expected: usize,
        /// Number of costs in this row.
        got: usize,
    },
    /// A cost is negative or not a number.
    #[error("cost matrix: row {row}, column {column}: cost {cost} is not a nonnegative number")]
    Invalid {
        /// Number of the row, from 0: where the change starts.
        row: usize,
        /// Number of the column, from 0: where the change ends.
        column: usize,
        /// The cost.
        cost: f64,
    },
    /// A cost on the diagonal is not 0.
    #[error("cost matrix: row {row}, column {row}: cost of no change is {cost}, expected 0")]
    Diagonal {
        /// Number of the row and the column, from 0.
        row: usize,
        /// The cost.
        cost: f64,
    },
}

/// Scaled cost of a change that is forbidden.
const FORBIDDEN: u32 = u32::MAX;

impl CostMatrix {
    /// The largest number of rows: zones and tools are numbered by bytes.
    pub const MAX_SIZE: usize = 255;

    /// The largest cost after scaling.
    pub const MAX_SCALED: u32 = 1_000_000_000;

    /// Makes a matrix from its rows: `rows[from][to]`.
    pub fn new(rows: &[Vec<f64>]) -> Result<Self, CostMatrixError> {
        let size = rows.len();
        if size > Self::MAX_SIZE {
            return Err(CostMatrixError::TooLarge { got: size });
        }
        for (row, costs) in rows.iter().enumerate() {
            if costs.len() != size {
                let got = costs.len();
                return Err(CostMatrixError::NotSquare { row, expected: size, got });
            }
            let is_invalid = |&(_, &cost): &(usize, &f64)| cost.is_nan() || cost < 0.0;
            if let Some((column, &cost)) = costs.iter().enumerate().find(is_invalid) {
                return Err(CostMatrixError::Invalid { row, column, cost });
            }
            if costs[row] > 0.0 {
                return Err(CostMatrixError::Diagonal { row, cost: costs[row] });
            }
        }
        let finite: Vec<f64> = rows.iter().flatten().copied().filter(|c| c.is_finite()).collect();
        let scale = choose_scale(&finite);
        let scaled = |&cost: &f64| {
            if cost.is_finite() { (cost * scale).round() as u32 } else { FORBIDDEN }
        };
        Ok(Self { size, scaled: rows.iter().flatten().map(scaled).collect(), scale })
    }

    /// Makes a matrix of `size` rows whose costs off the diagonal are `cost(from, to)`.
    pub fn from_fn(
        size: usize,
        cost: impl Fn(usize, usize) -> f64,
    ) -> Result<Self, CostMatrixError> {
        if size > Self::MAX_SIZE {
            return Err(CostMatrixError::TooLarge { got: size });
        }
        let entry = |from: usize, to: usize| if from == to { 0.0 } else { cost(from, to) };
        let row = |from: usize| (0..size).map(|to| entry(from, to)).collect();
        Self::new(&(0..size).map(row).collect::<Vec<_>>())
    }

    /// A matrix in which each change costs 1, so that a total is the number of changes.
    ///
    /// # Panics
    /// If `size` is larger than [`CostMatrix::MAX_SIZE`].
    pub fn uniform(size: usize) -> Self {
        Self::from_fn(size, |_, _| 1.0).expect("the size is at most MAX_SIZE")
    }

    /// Number of rows: of zones, or of tools.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Cost of a change in the caller's unit, as the searches use it: a multiple of
    /// [`CostMatrix::resolution`], or infinite if the change is forbidden.
    ///
    /// # Panics
    /// If one of the numbers is not below [`CostMatrix::size`].
    pub fn cost(&self, from: u8, to: u8) -> f64 {
        match self.scaled(from, to) {
            FORBIDDEN => f64::INFINITY,
            scaled => self.unscaled(scaled.into()),
        }
    }

    /// Whether a change is forbidden.
    ///
    /// # Panics
    /// If one of the numbers is not below [`CostMatrix::size`].
    pub fn is_forbidden(&self, from: u8, to: u8) -> bool {
        self.scaled(from, to) == FORBIDDEN
    }

    /// The factor by which costs are multiplied before they are rounded to integers.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The difference between two successive scaled costs, in the caller's unit: the inverse of
    /// [`CostMatrix::scale`].
    /// Rounding changes a cost by at most half of it, and not at all if all costs are multiples of
    /// it.
    pub fn resolution(&self) -> f64 {
        1.0 / self.scale
    }

    /// Whether all pairs cost the same in both directions.
    pub fn is_symmetric(&self) -> bool {
        self.all_pairs(|a, b| self.at(a, b) == self.at(b, a))
    }

    /// Whether no detour is cheaper than a direct change (the triangle inequality).
    /// Cubic in the size.
    pub fn is_metric(&self) -> bool {
        self.with_detours() == *self
    }

    /// The first change that is forbidden, if there is one.
    pub(crate) fn first_forbidden(&self) -> Option<[u8; 2]> {
        let position = self.scaled.iter().position(|&cost| cost == FORBIDDEN)?;
        Some([position / self.size, position % self.size].map(|number| number as u8))
    }

    /// The scaled cost of a change that is not forbidden; `u32::MAX` if it is.
    ///
    /// # Panics
    /// If one of the numbers is not below [`CostMatrix::size`].
    #[inline]
    pub(crate) fn scaled(&self, from: u8, to: u8) -> u32 {
        assert!(usize::from(to) < self.size, "no cost of a change to {to}");
        self.scaled[usize::from(from) * self.size + usize::from(to)]
    }

    /// The scaled cost of a change, or `u64::MAX` if it is forbidden.
    #[inline]
    pub(crate) fn step(&self, from: u8, to: u8) -> u64 {
        match self.scaled(from, to) {
            FORBIDDEN => u64::MAX,
            cost => cost.into(),
        }
    }

    /// A sum of scaled costs in the caller's unit.
    pub(crate) fn unscaled(&self, sum: u64) -> f64 {
        sum as f64 / self.scale
    }

    /// A sum of costs that [`CostMatrix::unscaled`] returned, scaled again.
    pub(crate) fn rescaled(&self, sum: f64) -> u64 {
        (sum * self.scale).round() as u64
    }

    /// The largest scaled cost of the changes that are not forbidden.
    pub(crate) fn max_scaled(&self) -> u32 {
        self.scaled.iter().copied().filter(|&cost| cost != FORBIDDEN).max().unwrap_or(0)
    }

    /// The cost of the cheapest sequence of changes for each pair, by the Floyd-Warshall algorithm.
    ///
    /// The cost of a sequence is limited to `u32::MAX - 1`, the highest value that does not mean
    /// forbidden, so that the result stays a lower bound on the cost of any sequence of changes.
    pub(crate) fn with_detours(&self) -> Self {
        let n = self.size;
        let mut scaled = self.scaled.clone();
        for by in 0..n {
            for from in 0..n {
                for to in 0..n {
                    let parts = [scaled[from * n + by], scaled[by * n + to]];
                    if !parts.contains(&FORBIDDEN) {
                        let detour = parts[0].saturating_add(parts[1]).min(FORBIDDEN - 1);
                        let cost = &mut scaled[from * n + to];
                        *cost = detour.min(*cost);
                    }
                }
            }
        }
        Self { size: n, scaled, scale: self.scale }
    }

    #[inline]
    pub(super) fn at(&self, from: usize, to: usize) -> u32 {
        self.scaled[from * self.size + to]
    }

    fn all_pairs(&self, test: impl Fn(usize, usize) -> bool) -> bool {
        (0..self.size).all(|a| (0..a).all(|b| test(a, b)))
    }
}

/// The scale of finite costs: see the type's documentation.
fn choose_scale(costs: &[f64]) -> f64 {
    let max_scaled = f64::from(CostMatrix::MAX_SCALED);
    let largest = costs.iter().copied().fold(0.0, f64::max);
    let mut scale = 1.0;
    while scale <= max_scaled && largest * scale <= max_scaled {
        // Both the division and the parser that read a decimal number round correctly, so exactly
        // the numbers with few enough decimals survive the round trip.
        let is_kept = |&cost: &f64| ((cost * scale).round() / scale).to_bits() == cost.to_bits();
        if costs.iter().all(|cost| is_kept(&cost.abs())) {
            return scale;
        }
        scale *= 10.0;
    }
    (max_scaled / largest).min(f64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_checked() {
        let costs = CostMatrix::new(&[vec![0.0, 7.0], vec![3.0, 0.0]]).unwrap();
        assert_eq!((costs.size(), costs.scaled(0, 1), costs.scaled(1, 0)), (2, 7, 3));
        let error = |rows: &[Vec<f64>]| CostMatrix::new(rows).unwrap_err().to_string();
        assert_eq!(
            error(&[vec![0.0, 1.0], vec![2.0]]),
            "cost matrix: row 1 has 1 costs, expected 2, one for each row"
        );
        assert_eq!(
            error(&[vec![0.0, 1.0], vec![2.0, 5.0]]),
            "cost matrix: row 1, column 1: cost of no change is 5, expected 0"
        );
        assert_eq!(
            error(&[vec![0.0, -1.5], vec![2.0, 0.0]]),
            "cost matrix: row 0, column 1: cost -1.5 is not a nonnegative number"
        );
        assert_eq!(
            error(&[vec![0.0, 1.0], vec![f64::NAN, 0.0]]),
            "cost matrix: row 1, column 0: cost NaN is not a nonnegative number"
        );
        assert_eq!(
            error(&vec![vec![0.0; 256]; 256]),
            "cost matrix: 256 rows, expected at most 255"
        );
        assert_eq!(CostMatrix::uniform(255).scaled(254, 0), 1);
        assert_eq!(CostMatrix::uniform(0).size(), 0);
    }

    fn two(there: f64, back: f64) -> CostMatrix {
        CostMatrix::new(&[vec![0.0, there], vec![back, 0.0]]).unwrap()
    }

    #[test]
    fn whole_and_decimal_costs_are_not_rounded() {
        for (there, back, scale) in [
            (5.0_f64, 7.0_f64, 1.0_f64),
            (1e9, 1.0, 1.0),
            (0.0, 0.0, 1.0),
            (0.07, 12.5, 100.0),
            (0.1, 0.3, 10.0),
            (0.123_456_789, 1.0, 1e9),
            (f64::INFINITY, 0.5, 10.0),
        ] {
            let costs = two(there, back);
            assert_eq!(costs.scale().to_bits(), scale.to_bits(), "{there} {back}");
            assert_eq!(costs.cost(0, 1).to_bits(), there.to_bits());
            assert_eq!(costs.cost(1, 0).to_bits(), back.to_bits());
        }
    }

    #[test]
    fn other_costs_are_rounded_to_the_resolution() {
        for (there, back) in [(1.0 / 3.0, 2.0 / 7.0), (2e9, 1.0), (1e300, 1e290), (1e-290, 7e-292)]
        {
            let costs = two(there, back);
            assert_eq!(costs.max_scaled(), CostMatrix::MAX_SCALED);
            for (cost, rounded) in [(there, costs.cost(0, 1)), (back, costs.cost(1, 0))] {
                assert!(
                    (cost - rounded).abs() <= 0.500_001 * costs.resolution(),
                    "{cost} {rounded}"
                );
            }
        }
    }

    #[test]
    fn forbidden_changes_have_infinite_costs() {
        let costs = two(f64::INFINITY, 2.0);
        assert!(costs.is_forbidden(0, 1) && !costs.is_forbidden(1, 0));
        assert_eq!(costs.cost(0, 1).to_bits(), f64::INFINITY.to_bits());
        assert_eq!((costs.step(0, 1), costs.step(1, 0)), (u64::MAX, 2));
        assert_eq!((costs.first_forbidden(), costs.max_scaled()), (Some([0, 1]), 2));
        assert!(!costs.is_symmetric());
    }

    #[test]
    fn detours_are_found() {
        let rows = |far: f64, back: f64| {
            CostMatrix::new(&[vec![0.0, far, 1.0], vec![9.0, 0.0, back], vec![5.0, 2.0, 0.0]])
        };
        let shortest = rows(3.0, 10.0).unwrap();
        assert_eq!(rows(9.0, 1e9).unwrap().with_detours(), shortest);
        assert_eq!(rows(f64::INFINITY, f64::INFINITY).unwrap().with_detours(), shortest);
        assert!(!rows(9.0, 1.0).unwrap().is_metric());
        assert!(shortest.is_metric() && CostMatrix::uniform(7).is_metric());
        // Every sequence of changes from 0 is forbidden.
        let dead_end =
            CostMatrix::from_fn(3, |from, _| if from == 0 { f64::INFINITY } else { 1.0 });
        assert!(dead_end.unwrap().with_detours().is_forbidden(0, 1));
    }
}
