//! Costs of crossings as the exact search uses them.

use std::borrow::Cow;

use rand::Rng;

use super::matrix::CostMatrix;

/// Costs of crossings for the exact search.
///
/// That search sums fractions of costs over tens of thousands of crossings in 32 bits, so scaled
/// costs must be small.
/// Larger ones are divided by a common factor.
/// Costs that are not multiples of it are rounded **down**.
/// A path then costs at most its true cost divided by the factor, so lower bounds stay valid, but
/// optimality may be impossible to prove.
pub(crate) struct CrossingCosts<'a> {
    original: &'a CostMatrix,
    reduced: Cow<'a, CostMatrix>,
    /// The factor by which costs were divided, as a fraction.
    factor: [u32; 2],
}

impl<'a> CrossingCosts<'a> {
    /// The largest scaled cost of one crossing.
    const MAX: u32 = 10_000;

    pub(crate) fn new(original: &'a CostMatrix) -> Self {
        let max = original.max_scaled();
        if max <= Self::MAX {
            return Self { original, reduced: Cow::Borrowed(original), factor: [1, 1] };
        }
        let divisor = original.scaled.iter().copied().fold(0, greatest_common_divisor);
        let factor @ [over, under] =
            if max / divisor <= Self::MAX { [divisor, 1] } else { [max, Self::MAX] };
        let reduce = |&cost: &u32| (u64::from(cost) * u64::from(under) / u64::from(over)) as u32;
        let reduced = CostMatrix {
            size: original.size,
            scaled: original.scaled.iter().map(reduce).collect(),
            scale: original.scale * f64::from(under) / f64::from(over),
        };
        Self { original, reduced: Cow::Owned(reduced), factor }
    }

    /// The costs as the caller gave them.
    pub(crate) fn original(&self) -> &CostMatrix {
        self.original
    }

    /// The costs to search with.
    pub(crate) fn reduced(&self) -> &CostMatrix {
        &self.reduced
    }

    /// The lower bound, in the caller's unit, that follows from a lower bound for the reduced
    /// costs.
    pub(crate) fn bound(&self, reduced: u64) -> f64 {
        let [over, under] = self.factor.map(u128::from);
        let scaled = (u128::from(reduced) * over).div_ceil(under);
        self.original.unscaled(scaled as u64)
    }
}

/// The greatest common divisor, by Euclid's algorithm; if one number is 0, it is the other number.
fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// Symmetric costs derived from a matrix of crossing costs, whose entries are at most 10,000 and
/// not forbidden: one for each pair of zones, at `a * size + b`.
impl CostMatrix {
    /// The cost of the cheaper direction of each pair.
    pub(crate) fn cheaper_direction(&self) -> Vec<i32> {
        self.of_pairs(|a, b| self.at(a, b).min(self.at(b, a)) as i32)
    }

    /// The cost of the cheaper direction of each pair after costs were shifted by potentials, and
    /// the maximum change of the cost of one piece of a path by that shift.
    ///
    /// Give each zone a potential, and add to the cost of a step from a to b the potential of b
    /// minus that of a.
    /// Along a path these differences telescope: they sum to the potential of its last zone minus
    /// that of its first, which is at most the difference between the largest and the smallest
    /// potential.
    /// So a lower bound for the shifted costs, minus that difference for each piece, is a lower
    /// bound for the original costs.
    /// It is better than the bound without potentials where these make the two directions of each
    /// pair more alike: the cheaper direction is then closer to the mean of both, which a path pays
    /// that crosses back and forth.
    ///
    /// The potentials solve the least-squares problem over all pairs; they are halved until no
    /// shifted cost is negative.
    pub(crate) fn shifted_by_potentials(&self) -> (Vec<i32>, i32) {
        let size = self.size;
        let cost = |a: usize, b: usize| i64::from(self.at(a, b));
        let surplus_from = |a: usize| (0..size).map(|b| cost(a, b) - cost(b, a)).sum::<i64>();
        let mut potentials: Vec<i64> =
            (0..size).map(|a| surplus_from(a) / (2 * size as i64)).collect();
        let shifted =
            |potentials: &[i64], a: usize, b: usize| cost(a, b) + potentials[b] - potentials[a];
        let has_negative = |potentials: &[i64]| {
            (0..size).any(|a| (0..size).any(|b| shifted(potentials, a, b) < 0))
        };
        while has_negative(&potentials) {
            potentials.iter_mut().for_each(|potential| *potential /= 2);
        }
        let cheaper =
            self.of_pairs(|a, b| shifted(&potentials, a, b).min(shifted(&potentials, b, a)) as i32);
        let difference =
            potentials.iter().max().unwrap_or(&0) - potentials.iter().min().unwrap_or(&0);
        (cheaper, difference as i32)
    }

    /// For each pair a random cost between those of its two directions.
    ///
    /// A path that crosses a border back and forth pays both directions alternately; other paths
    /// mostly pay one of them, but which one is known only once there is a path.
    pub(crate) fn between_directions(&self, rng: &mut impl Rng) -> Vec<i32> {
        let mut costs = self.of_pairs(|_, _| 0);
        for a in 0..self.size {
            for b in 0..a {
                let [min, max] = {
                    let both = [self.at(a, b), self.at(b, a)];
                    [both[0].min(both[1]), both[0].max(both[1])]
                };
                let cost = (min + (rng.next_u64() % u64::from(max - min + 1)) as u32) as i32;
                costs[a * self.size + b] = cost;
                costs[b * self.size + a] = cost;
            }
        }
        costs
    }

    fn of_pairs(&self, cost: impl Fn(usize, usize) -> i32) -> Vec<i32> {
        let cost = &cost;
        (0..self.size).flat_map(|a| (0..self.size).map(move |b| cost(a, b))).collect()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn small_costs_are_not_reduced() {
        let costs = CostMatrix::from_fn(3, |from, to| (10_000 - from - to) as f64).unwrap();
        let crossing = CrossingCosts::new(&costs);
        assert_eq!(crossing.reduced(), &costs);
        assert_eq!(crossing.bound(123).to_bits(), 123.0_f64.to_bits());
    }

    /// Costs of hundreds of thousands with a large common divisor are searched without rounding.
    #[test]
    fn common_divisors_are_divided_out() {
        let costs = CostMatrix::from_fn(3, |from, to| 250.25 * (from + 2 * to) as f64).unwrap();
        assert!(costs.max_scaled() > CrossingCosts::MAX);
        let crossing = CrossingCosts::new(&costs);
        let reduced = crossing.reduced();
        assert_eq!([reduced.scaled(0, 1), reduced.scaled(2, 1)], [2, 4]);
        assert_eq!(crossing.bound(3).to_bits(), 750.75_f64.to_bits());
        assert!((reduced.cost(2, 1) - 1001.0).abs() < 1e-9);
    }

    /// The reduced cost of a path gives a lower bound on its cost, which is nearly tight.
    #[test]
    fn bounds_of_reduced_costs_hold() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..1000 {
            let largest = 1.0 + (rng.next_u64() % 2_000_000_000) as f64 / 7.0;
            let costs = CostMatrix::from_fn(4, |from, to| {
                largest * (1 + (from * 5 + to * 3) % 7) as f64 / 7.0
            });
            let costs = costs.unwrap();
            let crossing = CrossingCosts::new(&costs);
            assert!(crossing.reduced().max_scaled() <= CrossingCosts::MAX);
            let path: Vec<u8> = (0..100).map(|_| (rng.next_u64() % 4) as u8).collect();
            let sum = |costs: &CostMatrix| {
                path.windows(2).map(|step| costs.step(step[0], step[1])).sum::<u64>()
            };
            let (total, bound) =
                (costs.unscaled(sum(&costs)), crossing.bound(sum(crossing.reduced())));
            assert!(bound <= total && bound >= 0.999 * total, "{bound} {total}");
        }
    }
}
