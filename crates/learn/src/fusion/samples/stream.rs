//! The stream of batches of one epoch.

use std::collections::BTreeMap;
use std::sync::Arc;

use beadwork_dataset::{Dataset, DatasetError, ReplayError, Shuffled, Trajectory};
use beadwork_grid::Symmetry;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use super::batch::{Batch, Example, Negatives};
use super::split::Split;
use crate::fusion::config::MAX_SIDE;
use crate::fusion::episode::{Episode, depth_quarter};
use crate::fusion::inputs::Canvas;

/// How examples are drawn.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Seed of all random choices.
    pub seed: u64,
    /// Examples in a batch on a canvas of 32 x 32 cells.
    /// Batches on larger canvases have proportionally fewer, but at least 8.
    pub batch: usize,
    /// Examples drawn from a trajectory on a canvas of 32 x 32 cells.
    /// Larger canvases have proportionally fewer, because an example costs more there, unless
    /// `held_out` is set.
    pub per_trajectory: usize,
    /// Share of the examples, 0..=1, that are drawn evenly from all depths, from the layer's sides
    /// to its centre.
    /// The others are drawn evenly from all needed moves, most of which are near the sides.
    pub balance: f64,
    /// Size of a canvas's shuffle buffer, in batches: a batch is drawn from it whenever it is full.
    pub pool: usize,
    /// Moves of the history, K.
    pub history: usize,
    /// Which positions are negatives.
    pub negatives: Negatives,
    /// Whether the examples are for evaluation.
    /// They are then not transformed by a symmetry, trajectories of all sizes have the same number
    /// of examples, and [`Batch::baselines`] are computed, which doubles the cost.
    pub held_out: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 0,
            batch: 64,
            per_trajectory: 96,
            balance: 0.3,
            pool: 24,
            history: 32,
            negatives: Negatives::Applicable,
            held_out: false,
        }
    }
}

/// Cells of the canvas that the counts of [`Settings`] are given for.
const REFERENCE_CELLS: usize = 32 * 32;

impl Settings {
    fn batch_on(&self, canvas: Canvas) -> usize {
        (self.batch * REFERENCE_CELLS / canvas.cells()).clamp(8.min(self.batch), self.batch)
    }

    fn per_trajectory_on(&self, canvas: Canvas) -> usize {
        if self.held_out {
            return self.per_trajectory;
        }
        (self.per_trajectory * REFERENCE_CELLS / canvas.cells()).clamp(1, self.per_trajectory)
    }
}

/// Why examples cannot be drawn.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SampleError {
    /// The dataset cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A record cannot be replayed.
    #[error("trajectory {index}: {cause}")]
    Replay {
        /// Number of the trajectory.
        index: u64,
        /// What is wrong with it.
        cause: ReplayError,
    },
    /// A layer is larger than the network's coordinate embeddings.
    #[error(
        "trajectory {index}: layer is {width} x {height} cells, \
         the network takes at most {max} x {max}"
    )]
    TooLarge {
        /// Number of the trajectory.
        index: u64,
        /// Columns.
        width: u16,
        /// Rows.
        height: u16,
        /// Maximum of both.
        max: u32,
    },
    /// A split of the dataset has no examples.
    #[error("dataset has no {split} examples{}", hint(*split))]
    NoExamples {
        /// The split.
        split: Split,
    },
}

fn hint(split: Split) -> &'static str {
    match split {
        Split::Train => "",
        Split::Valid | Split::Test => {
            ": every combination of layout, size and preset needs ten random instances"
        }
    }
}

/// Iterator over the batches of one epoch.
/// Each epoch draws different examples in a different order.
pub struct Batches<'a> {
    settings: &'a Settings,
    split: Split,
    strata: u64,
    trajectories: Shuffled<'a, Trajectory>,
    rng: ChaCha8Rng,
    /// The shuffle buffer of each canvas.
    buffers: BTreeMap<Canvas, Vec<Example>>,
    /// Whether all trajectories have been read; the buffers are then emptied.
    ended: bool,
}

/// Blocks of the dataset that are shuffled at a time.
const WINDOW: usize = 16;

impl<'a> Batches<'a> {
    /// The batches of one split of a dataset.
    pub fn new(dataset: &'a Dataset, split: Split, settings: &'a Settings, epoch: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        rng.set_stream(1 << 32 | epoch);
        Self {
            settings,
            split,
            strata: dataset.manifest().strata.len() as u64,
            trajectories: dataset.shuffled(settings.seed, epoch, WINDOW),
            rng,
            buffers: BTreeMap::new(),
            ended: false,
        }
    }

    /// Skips batches; costs less than iterating over them, because their arrays are not made.
    /// Returns the number skipped, less than `count` if the epoch ends.
    pub fn skip_batches(&mut self, count: u64) -> Result<u64, SampleError> {
        for skipped in 0..count {
            if self.next_examples()?.is_none() {
                return Ok(skipped);
            }
        }
        Ok(count)
    }

    /// The examples of the next batch, or `None` at the end of the epoch.
    ///
    /// Reads trajectories until the shuffle buffer of some canvas is full, then draws from it.
    fn next_examples(&mut self) -> Result<Option<(Canvas, Vec<Example>)>, SampleError> {
        loop {
            if let Some(canvas) = self.ready_canvas() {
                let buffer = self.buffers.get_mut(&canvas).expect("a ready canvas has a buffer");
                let count = self.settings.batch_on(canvas).min(buffer.len());
                let examples = (0..count)
                    .map(|_| buffer.swap_remove(self.rng.random_range(0..buffer.len())))
                    .collect();
                return Ok(Some((canvas, examples)));
            }
            if self.ended {
                return Ok(None);
            }
            match self.trajectories.next() {
                None => self.ended = true,
                Some(trajectory) => self.draw_examples(&trajectory?)?,
            }
        }
    }

    /// A canvas from whose shuffle buffer the next batch can be drawn.
    /// While there are trajectories to read, its buffer must be full.
    /// After that, a buffer with a whole batch is preferred to one with fewer examples.
    fn ready_canvas(&self) -> Option<Canvas> {
        let batches = if self.ended { 1 } else { self.settings.pool.max(1) };
        let is_full = |(canvas, buffer): &(&Canvas, &Vec<Example>)| {
            buffer.len() >= batches * self.settings.batch_on(**canvas)
        };
        let full = self.buffers.iter().find(is_full);
        let any = || self.buffers.iter().find(|(_, buffer)| self.ended && !buffer.is_empty());
        full.or_else(any).map(|(&canvas, _)| canvas)
    }

    /// Draws examples of a trajectory into the buffers of their canvases.
    fn draw_examples(&mut self, trajectory: &Trajectory) -> Result<(), SampleError> {
        if Split::of(trajectory, self.strata) != self.split {
            return Ok(());
        }
        let Trajectory { index, width, height, .. } = *trajectory;
        if u32::from(width.max(height)) > MAX_SIDE {
            return Err(SampleError::TooLarge { index, width, height, max: MAX_SIDE });
        }
        let replay = |cause| SampleError::Replay { index, cause };
        let Some(episode) = Episode::new(trajectory).map_err(replay)? else { return Ok(()) };
        if episode.needed.is_empty() {
            return Ok(());
        }
        let (episode, layout) = (Arc::new(episode), Arc::from(trajectory.instance.name()));
        let size = episode.layer.size();
        let mut by_depth: [Vec<usize>; 4] = Default::default();
        for &index in &episode.needed {
            by_depth[depth_quarter(episode.moves[index].placed, size)].push(index);
        }
        let by_depth: Vec<_> = by_depth.into_iter().filter(|quarter| !quarter.is_empty()).collect();
        let count = self.settings.per_trajectory_on(Canvas::holding(size));
        for _ in 0..count.min(episode.needed.len()) {
            let candidates = if self.rng.random::<f64>() < self.settings.balance {
                &by_depth[self.rng.random_range(0..by_depth.len())]
            } else {
                &episode.needed
            };
            let move_index = candidates[self.rng.random_range(0..candidates.len())];
            let symmetry = if self.settings.held_out { 0 } else { self.rng.random_range(0..8) };
            let symmetry = Symmetry::ALL[symmetry];
            let canvas = Canvas::holding(symmetry.map_size(size));
            let example = Example {
                episode: Arc::clone(&episode),
                layout: Arc::clone(&layout),
                move_index,
                symmetry,
            };
            self.buffers.entry(canvas).or_default().push(example);
        }
        Ok(())
    }
}

impl Iterator for Batches<'_> {
    type Item = Result<Batch, SampleError>;

    fn next(&mut self) -> Option<Self::Item> {
        let (canvas, examples) = match self.next_examples() {
            Ok(examples) => examples?,
            Err(error) => return Some(Err(error)),
        };
        let Settings { history, negatives, held_out, .. } = *self.settings;
        Some(Ok(Batch::new(canvas, &examples, history, negatives, held_out)))
    }
}
