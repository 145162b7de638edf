//! Accuracy of predictors that use no network, for comparison.

use beadwork_grid::PlacedVariant;

use super::layer::State;

/// Probabilities that predictors without a network find the recorded move of an example, or their
/// sums over several examples.
///
/// The *chance* predictor draws from all moves that apply, uniformly.
/// The *greedy* predictor draws from the positions of the moves that lower the crossings most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Baseline {
    /// That a random position where a move applies is the recorded one.
    pub chance_top_1: f64,
    /// That the recorded position is among five random ones where a move applies.
    pub chance_top_5: f64,
    /// That a random variant among those that apply at the recorded position is the recorded one.
    pub chance_action: f64,
    /// That a random position among those of the best moves is the recorded one.
    pub greedy_top_1: f64,
    /// That the recorded position is among five, drawn from those of the best moves first, then
    /// from the others.
    pub greedy_top_5: f64,
}

impl Baseline {
    /// The probabilities for a state and the move that was recorded there.
    /// Linear in the cells of the grid.
    pub fn new(state: &State<'_>, recorded: PlacedVariant) -> Self {
        let recorded_position = (recorded.x, recorded.y);
        // Each position where a move applies, with the lowest change of crossings there.
        // All moves of a position are visited in succession.
        let mut positions: Vec<((u16, u16), i32)> = Vec::new();
        let mut variants = 0;
        state.links.for_each_variant(|placed| {
            let (position, change) = ((placed.x, placed.y), state.layer.change(placed));
            variants += u32::from(position == recorded_position);
            match positions.last_mut() {
                Some((last, lowest)) if *last == position => *lowest = change.min(*lowest),
                _ => positions.push((position, change)),
            }
        });
        let lowest = positions.iter().map(|&(_, change)| change).min().unwrap_or(0);
        let best = positions.iter().filter(|&&(_, change)| change == lowest).count() as f64;
        let is_best = positions.contains(&(recorded_position, lowest));
        let count = positions.len() as f64;
        // Probability that one of `draws` positions, out of `all`, is the recorded one.
        let hit =
            |draws: f64, all: f64| if all > 0.0 { (draws / all).clamp(0.0, 1.0) } else { 0.0 };
        Self {
            chance_top_1: hit(1.0, count),
            chance_top_5: hit(5.0, count),
            chance_action: hit(1.0, f64::from(variants)),
            greedy_top_1: if is_best { 1.0 / best } else { 0.0 },
            greedy_top_5: if is_best { hit(5.0, best) } else { hit(5.0 - best, count - best) },
        }
    }

    /// Adds the probabilities of another example.
    pub fn add(&mut self, other: Self) {
        self.chance_top_1 += other.chance_top_1;
        self.chance_top_5 += other.chance_top_5;
        self.chance_action += other.chance_action;
        self.greedy_top_1 += other.greedy_top_1;
        self.greedy_top_5 += other.greedy_top_5;
    }
}
