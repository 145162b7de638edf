//! How often a true move would be met without a network.

use super::layer::State;

use beadwork_grid::PlacedVariant;

/// Chances on one example, or their sums over several.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Odds {
    /// That a place drawn from those where a move applies is the true one.
    pub chance_1: f64,
    /// That it is among five of them.
    pub chance_5: f64,
    /// That a variant drawn from those that apply at the true place is the true one.
    pub chance_action: f64,
    /// That a place drawn from those of moves that lower the crossings most is the true one.
    pub greedy_1: f64,
    /// That it is among five, first of those, then of the others.
    pub greedy_5: f64,
}

impl Odds {
    /// Of a state with the move that was made there.
    pub fn of(state: &State<'_>, truth: PlacedVariant) -> Self {
        // The least change at each place; moves come place by place.
        let mut places: Vec<((u16, u16), i32)> = Vec::new();
        let mut variants = 0;
        state.links.for_each_variant(|placed| {
            let (place, change) = ((placed.x, placed.y), state.layer.change(placed));
            variants += u32::from(place == (truth.x, truth.y));
            match places.last_mut() {
                Some((last, least)) if *last == place => *least = change.min(*least),
                _ => places.push((place, change)),
            }
        });
        let least = places.iter().map(|&(_, change)| change).min().unwrap_or(0);
        let best = places.iter().filter(|&&(_, change)| change == least).count() as f64;
        let is_best = places.contains(&((truth.x, truth.y), least));
        let count = places.len() as f64;
        let among =
            |five: f64, all: f64| if all > 0.0 { (five / all).clamp(0.0, 1.0) } else { 0.0 };
        Self {
            chance_1: among(1.0, count),
            chance_5: among(5.0, count),
            chance_action: among(1.0, f64::from(variants)),
            greedy_1: if is_best { 1.0 / best } else { 0.0 },
            greedy_5: if is_best { among(5.0, best) } else { among(5.0 - best, count - best) },
        }
    }

    /// Adds those of another example.
    pub fn add(&mut self, other: Self) {
        self.chance_1 += other.chance_1;
        self.chance_5 += other.chance_5;
        self.chance_action += other.chance_action;
        self.greedy_1 += other.greedy_1;
        self.greedy_5 += other.greedy_5;
    }
}
