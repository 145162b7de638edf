//! A recorded search as a sequence of states to learn from.

use beadwork_base::Control;
use beadwork_dataset::{ReplayError, Trajectory};
use beadwork_grid::{Links, PlacedVariant};
use beadwork_search::Move;

use super::layer::{AppliedMove, Layer};

/// A trajectory whose states can be visited, with the moves that its gains depended on.
#[derive(Clone, Debug)]
pub struct Episode {
    /// The layer.
    pub layer: Layer,
    /// The links of the start path.
    pub start: Links,
    /// All recorded moves.
    pub moves: Vec<AppliedMove>,
    /// Crossings of the start path.
    pub initial: u32,
    /// Indices of the needed moves, ascending: those that reached a new best, and all moves that
    /// these depended on.
    pub needed: Vec<usize>,
}

impl Episode {
    /// Draws the layer of a trajectory and finds its needed moves.
    /// Returns `None` if the trajectory has other moves than the paper's variants.
    ///
    /// The moves are not checked; [`Trajectory::replay`] does that.
    pub fn new(trajectory: &Trajectory) -> Result<Option<Self>, ReplayError> {
        let (region, zones) = trajectory.draw()?;
        let start = Links::new(&trajectory.start.path(&region, &Control::default())?);
        let mut moves = Vec::with_capacity(trajectory.moves.len());
        let mut is_best = Vec::with_capacity(trajectory.moves.len());
        for step in trajectory.steps() {
            let Move::Variant(placed) = step.action else { return Ok(None) };
            moves.push(AppliedMove { placed, before: step.before, after: step.after });
            is_best.push(step.effective);
        }
        let needed = needed_moves(&moves, &is_best, start.size());
        Ok(Some(Self {
            layer: Layer::new(&region, &zones),
            start,
            moves,
            initial: trajectory.initial,
            needed,
        }))
    }

    /// The links before the move at `index`.
    /// Linear in `index`.
    ///
    /// # Panics
    /// If a recorded move does not apply, or there are fewer than `index` moves.
    pub fn links_before(&self, index: usize) -> Links {
        let mut links = self.start.clone();
        for applied in &self.moves[..index] {
            assert!(links.apply_variant(applied.placed), "a recorded move applies");
        }
        links
    }
}

/// Indices of the moves that reached a new best, and of all moves that these depend on.
///
/// Whether a variant applies depends on the links of its window alone.
/// So a move depends directly on the last earlier move that changed each link of its window, and on
/// no others.
/// Following these dependencies backwards from the moves that reached a new best (a backward
/// program slice) finds a subsequence that applies without the remaining moves, which are random
/// noise or were undone later.
fn needed_moves(
    moves: &[AppliedMove],
    is_best: &[bool],
    (width, height): (u32, u32),
) -> Vec<usize> {
    const NONE: u32 = u32::MAX;
    // For each link the move that changed it last.
    let mut last_change = vec![NONE; (2 * width * height) as usize];
    let mut dependencies = Vec::with_capacity(moves.len());
    for (index, applied) in (0..).zip(moves) {
        let mut direct: Vec<u32> = Vec::new();
        applied.placed.for_each_link(|x, y, below, changed| {
            let last = &mut last_change[(2 * (y * width + x) + u32::from(below)) as usize];
            if *last != NONE && !direct.contains(last) {
                direct.push(*last);
            }
            if changed {
                *last = index;
            }
        });
        dependencies.push(direct);
    }
    let mut needed = is_best.to_vec();
    for index in (0..moves.len()).rev() {
        if needed[index] {
            dependencies[index].iter().for_each(|&earlier| needed[earlier as usize] = true);
        }
    }
    (0..moves.len()).filter(|&index| needed[index]).collect()
}

/// Quarter of the depth range that a move lies in: 0 at the layer's sides, 3 in its centre.
///
/// The depth is the distance in cells from the move's window to the nearest side of the grid.
pub(super) fn depth_quarter(placed: PlacedVariant, (width, height): (u32, u32)) -> usize {
    let (columns, rows) = placed.variant.window();
    let (x, y) = (u32::from(placed.x), u32::from(placed.y));
    let depth =
        x.min(y).min((width - columns).saturating_sub(x)).min((height - rows).saturating_sub(y));
    (8 * depth / width.min(height).max(1)).min(3) as usize
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use beadwork_dataset::{Config, Factory};

    use super::*;

    /// The needed moves apply without the others, so they still reach every new best's change.
    #[test]
    fn needed_moves_apply_without_the_others() {
        for (source, preset) in [("anneal", "short"), ("chains", "noisy")] {
            let config = format!(
                "count = 40\nsource = '{source}'\nsizes = ['20x17', '12x30']\n\
                 presets = ['{preset}']\nstarts = ['row_zigzag']\n\
                 layouts = [{{ name = 'voronoi' }}, {{ name = 'islands', side = 4 }}]"
            );
            let config = Config::from_toml(&config).unwrap();
            let factory = Factory::new(config, Vec::new(), &Control::default()).unwrap();
            let mut dropped = 0;
            for index in 0..40 {
                let trajectory = factory.trajectory(index, &Control::default()).unwrap();
                let episode = Episode::new(&trajectory).unwrap().unwrap();
                let mut links = episode.start.clone();
                for &needed in &episode.needed {
                    assert!(
                        links.apply_variant(episode.moves[needed].placed),
                        "{source} {index}: move {needed} applies"
                    );
                }
                dropped += episode.moves.len() - episode.needed.len();
                let best = trajectory.steps().filter(|step| step.effective).count();
                assert!(episode.needed.len() >= best);
            }
            assert!(dropped > 0, "{source}");
        }
    }
}
