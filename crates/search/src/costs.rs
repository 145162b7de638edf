//! What a crossing costs.

use rand::Rng;
use thiserror::Error;

/// The cost of a crossing for each ordered pair of zones; from b to a need not cost what from a to
/// b does.
///
/// Invariant: a step inside a zone costs nothing, and no cost exceeds [`ZoneCosts::MAX`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZoneCosts {
    zones: usize,
    costs: Vec<u32>,
}

/// Why [`ZoneCosts`] could not be made.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ZoneCostsError {
    /// There is not one cost for each ordered pair of zones.
    #[error("{got} costs given for {zones} zones, which have {} ordered pairs", zones * zones)]
    Length {
        /// Number of zones.
        zones: usize,
        /// Costs given.
        got: usize,
    },
    /// A step inside a zone has a cost.
    #[error("a step inside zone {zone} costs {cost}, not 0")]
    Inside {
        /// The zone.
        zone: usize,
        /// Its cost.
        cost: u32,
    },
    /// A cost is larger than [`ZoneCosts::MAX`].
    #[error("from zone {from} to zone {to} costs {cost}, more than {max}", max = ZoneCosts::MAX)]
    TooLarge {
        /// The zone before the crossing.
        from: usize,
        /// The zone after it.
        to: usize,
        /// The cost.
        cost: u32,
    },
}

impl ZoneCosts {
    /// The largest cost of one crossing: sums over tens of thousands of crossings, in parts, must
    /// fit.
    pub const MAX: u32 = 10_000;

    /// Each crossing costs 1.
    pub fn uniform(zones: u32) -> Self {
        let zones = zones as usize;
        let costs =
            (0..zones * zones).map(|pair| u32::from(pair / zones != pair % zones)).collect();
        Self { zones, costs }
    }

    /// Costs from one number for each ordered pair: from zone a to zone b at `a * zones + b`, any
    /// unit.
    pub fn new(zones: u32, costs: Vec<u32>) -> Result<Self, ZoneCostsError> {
        let zones = zones as usize;
        if costs.len() != zones * zones {
            return Err(ZoneCostsError::Length { zones, got: costs.len() });
        }
        for (pair, &cost) in costs.iter().enumerate() {
            let (from, to) = (pair / zones, pair % zones);
            if from == to && cost != 0 {
                return Err(ZoneCostsError::Inside { zone: from, cost });
            }
            if cost > Self::MAX {
                return Err(ZoneCostsError::TooLarge { from, to, cost });
            }
        }
        Ok(Self { zones, costs })
    }

    /// Number of zones.
    pub fn zones(&self) -> usize {
        self.zones
    }

    /// The cost of a step from one zone to another.
    ///
    /// # Panics
    /// If one of them is not below [`ZoneCosts::zones`].
    pub fn cost(&self, from: u8, to: u8) -> u32 {
        assert!(usize::from(to) < self.zones, "zone {to} has no cost");
        self.costs[usize::from(from) * self.zones + usize::from(to)]
    }

    /// Whether no pair costs more in one direction than in the other.
    pub fn is_symmetric(&self) -> bool {
        (0..self.zones).all(|a| {
            (0..a).all(|b| self.costs[a * self.zones + b] == self.costs[b * self.zones + a])
        })
    }

    /// The cheaper direction of each pair: what a crossing costs at least.
    pub(crate) fn least(&self) -> Vec<i32> {
        self.of_pairs(u32::min)
    }

    /// What a crossing costs at least after a change of costs that each path's total follows, and
    /// by how much a path's total may fall behind.
    ///
    /// Give each zone a height, and let a step from a to b cost the height of b less that of a
    /// more.
    /// Along a path these sum to the difference of the heights of its ends, so its cost falls by no
    /// more than the greatest difference.
    /// With heights that make the two directions of pairs more alike, the cheaper one is nearer to
    /// what a path pays in turn.
    /// The heights are those of least squares over all pairs, halved until no step costs less than
    /// nothing.
    pub(crate) fn levelled(&self) -> (Vec<i32>, i32) {
        let zones = self.zones;
        let cost = |a: usize, b: usize| i64::from(self.costs[a * zones + b]);
        let dearer_from = |a: usize| (0..zones).map(|b| cost(a, b) - cost(b, a)).sum::<i64>();
        let mut heights: Vec<i64> =
            (0..zones).map(|a| dearer_from(a) / (2 * zones as i64)).collect();
        let is_below = |heights: &[i64]| {
            (0..zones).any(|a| (0..zones).any(|b| cost(a, b) + heights[b] - heights[a] < 0))
        };
        while is_below(&heights) {
            heights.iter_mut().for_each(|height| *height /= 2);
        }
        let levelled = |a: usize, b: usize| cost(a, b) + heights[b] - heights[a];
        let least = |pair: usize| {
            let (a, b) = (pair / zones, pair % zones);
            levelled(a, b).min(levelled(b, a)) as i32
        };
        let spread = heights.iter().max().unwrap_or(&0) - heights.iter().min().unwrap_or(&0);
        ((0..zones * zones).map(least).collect(), spread as i32)
    }

    /// For each pair a cost between that of its cheaper and that of its dearer direction, drawn at
    /// random.
    ///
    /// A path pays both directions in turn where it goes to and fro, or mostly one of them; which
    /// one can't be known before.
    pub(crate) fn drawn(&self, rng: &mut impl Rng) -> Vec<i32> {
        let mut drawn = self.of_pairs(|_, _| 0);
        for a in 0..self.zones {
            for b in 0..a {
                let (there, back) =
                    (self.costs[a * self.zones + b], self.costs[b * self.zones + a]);
                let (least, most) = (there.min(back), there.max(back));
                let cost = (least + (rng.next_u64() % u64::from(most - least + 1)) as u32) as i32;
                drawn[a * self.zones + b] = cost;
                drawn[b * self.zones + a] = cost;
            }
        }
        drawn
    }

    fn of_pairs(&self, cost: impl Fn(u32, u32) -> u32) -> Vec<i32> {
        let pair = |a: usize, b: usize| {
            cost(self.costs[a * self.zones + b], self.costs[b * self.zones + a]) as i32
        };
        let pair = &pair;
        (0..self.zones).flat_map(|a| (0..self.zones).map(move |b| pair(a, b))).collect()
    }
}
