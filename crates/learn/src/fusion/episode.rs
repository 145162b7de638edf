//! A recorded search as examples to learn from.

use beadwork_base::Control;
use beadwork_dataset::{ReplayError, Trajectory};
use beadwork_grid::{Links, PlacedVariant};
use beadwork_search::Move;

use super::layer::{Layer, Made};

/// A trajectory whose states can be visited, and those of its moves that its gains needed.
#[derive(Clone, Debug)]
pub struct Episode {
    /// The layer.
    pub layer: Layer,
    /// The links that it starts from.
    pub start: Links,
    /// All moves.
    pub made: Vec<Made>,
    /// Crossings at the start.
    pub initial: u32,
    /// Numbers of the moves without which some new best would not have come about, ascending.
    pub needed: Vec<usize>,
}

impl Episode {
    /// Draws the layer and notes the moves; `None` for a record of other moves than the paper's
    /// variants.
    ///
    /// The record itself is taken as checked: see [`Trajectory::replay`].
    pub fn new(trajectory: &Trajectory) -> Result<Option<Self>, ReplayError> {
        let (region, zones) = trajectory.draw()?;
        let start = Links::new(&trajectory.start.path(&region, &Control::default())?);
        let mut made = Vec::with_capacity(trajectory.moves.len());
        let mut best = Vec::with_capacity(trajectory.moves.len());
        for step in trajectory.steps() {
            let Move::Variant(placed) = step.step else { return Ok(None) };
            made.push(Made { placed, before: step.before, after: step.after });
            best.push(step.effective);
        }
        let needed = needed(&made, &best, start.size());
        Ok(Some(Self {
            layer: Layer::new(&region, &zones),
            start,
            made,
            initial: trajectory.initial,
            needed,
        }))
    }

    /// The links before a move.
    /// Costs the moves up to there.
    pub fn links_before(&self, index: usize) -> Links {
        let mut links = self.start.clone();
        for made in &self.made[..index] {
            assert!(links.apply_variant(made.placed), "a record's moves apply");
        }
        links
    }
}

/// Of the moves those that led to a new best, and all on which one of these depends: what it found
/// in its window was left there by it.
/// The rest could be left out, and these would still apply.
fn needed(made: &[Made], best: &[bool], (width, height): (u32, u32)) -> Vec<usize> {
    const NOBODY: u32 = u32::MAX;
    let mut writers = vec![NOBODY; (2 * width * height) as usize];
    let mut dependencies = Vec::with_capacity(made.len());
    for (at, made) in (0..).zip(made) {
        let mut own: Vec<u32> = Vec::new();
        made.placed.for_each_link(|x, y, below, changed| {
            let writer = &mut writers[(2 * (y * width + x) + u32::from(below)) as usize];
            if *writer != NOBODY && !own.contains(writer) {
                own.push(*writer);
            }
            if changed {
                *writer = at;
            }
        });
        dependencies.push(own);
    }
    let mut kept = best.to_vec();
    for at in (0..made.len()).rev() {
        if kept[at] {
            dependencies[at].iter().for_each(|&earlier| kept[earlier as usize] = true);
        }
    }
    (0..made.len()).filter(|&at| kept[at]).collect()
}

/// How many cells a move lies from the layer's sides, as a share of the most that any can, in
/// quarters: 0 to 3.
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

    use std::sync::atomic::AtomicBool;

    use beadwork_dataset::{Config, Factory};

    use super::*;

    /// The needed moves, and no others, still lead to every link that some new best's move changed.
    #[test]
    fn needed_moves_stand_on_their_own() {
        for (source, preset) in [("anneal", "short"), ("chains", "noisy")] {
            let config = format!(
                "count = 40\nsource = '{source}'\nsizes = ['20x17', '12x30']\npresets = ['{preset}']\n\
                 starts = ['row_zigzag']\nlayouts = [{{ name = 'voronoi' }}, {{ name = 'islands', side = 4 }}]"
            );
            let factory = Factory::new(Config::from_toml(&config).unwrap(), Vec::new()).unwrap();
            let never = AtomicBool::new(false);
            let mut dropped = 0;
            for index in 0..40 {
                let trajectory = factory.trajectory(index, &never).unwrap().unwrap();
                let episode = Episode::new(&trajectory).unwrap().unwrap();
                let mut links = episode.start.clone();
                for &at in &episode.needed {
                    assert!(
                        links.apply_variant(episode.made[at].placed),
                        "{source} {index}: move {at} applies"
                    );
                }
                dropped += episode.made.len() - episode.needed.len();
                let best = trajectory.steps().filter(|step| step.effective).count();
                assert!(episode.needed.len() >= best);
            }
            assert!(dropped > 0, "{source}");
        }
    }
}
