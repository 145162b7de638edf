//! Batches of examples, streamed from a dataset.
//!
//! An example is a state of a recorded search, the moves before it and the needed move that was
//! made there, all seen after a random one of the eight symmetries.
//! Trajectories come in random order; of each some examples are drawn and wait, by canvas, in a
//! pool from which batches are drawn.
//! The batches depend on the dataset, the settings, the seed and the epoch alone.

use std::collections::BTreeMap;
use std::sync::Arc;

use beadwork_dataset::{Dataset, DatasetError, Instance, ReplayError, Shuffled, Trajectory};
use beadwork_grid::Symmetry;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tch::{Device, Tensor};
use thiserror::Error;

use super::PLACES;
use super::episode::{Episode, depth_quarter};
use super::layer::{Canvas, Inputs, State};
use super::odds::Odds;

/// Which instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Those to learn from: eight of ten, and all of layouts that are always drawn alike.
    Train,
    /// One of ten, by which training is steered.
    Valid,
    /// One of ten, which training never sees.
    Test,
}

impl Split {
    /// Where a trajectory of a dataset with so many strata belongs: by its place among those of its
    /// own layout and size, whose instances all differ.
    pub fn of(trajectory: &Trajectory, strata: u64) -> Self {
        let random = match &trajectory.instance {
            Instance::Layout { layout, .. } => layout.is_random(),
            Instance::Picture { .. } => false,
        };
        match trajectory.index / strata.max(1) % 10 {
            8 if random => Self::Valid,
            9 if random => Self::Test,
            _ => Self::Train,
        }
    }
}

/// Which positions the true one is to be ranked above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rivals {
    /// Those where a move applies: a planner sees that of the others anyway.
    #[default]
    Applicable,
    /// Cells beside another zone, as in the paper.
    Boundary,
}

/// How examples are drawn.
#[derive(Clone, Debug)]
pub struct SampleSettings {
    /// Seed of all choices.
    pub seed: u64,
    /// Examples in a batch on a canvas of 32 x 32 cells; on larger ones fewer in proportion, but at
    /// least 8.
    pub batch: usize,
    /// Examples drawn from a trajectory on a canvas of 32 x 32 cells; fewer in proportion on larger
    /// ones, whose examples cost more, unless they are held out.
    pub per_trajectory: usize,
    /// Share of the examples, 0..=1, that are drawn from all depths alike, from the layer's sides
    /// inwards; the others as they come.
    pub balance: f64,
    /// Batches that wait in each pool before one is drawn.
    pub pool: usize,
    /// Moves remembered, K.
    pub history: usize,
    /// What the true position is ranked above.
    pub rivals: Rivals,
    /// Whether they are to evaluate with: seen as they were recorded, equally many of trajectories
    /// of all sizes, with how often their moves would be met without a network, which costs as much
    /// as the rest.
    pub held_out: bool,
}

/// Cells of the canvas that counts are given for.
const UNIT: usize = 32 * 32;

impl SampleSettings {
    fn batch(&self, canvas: Canvas) -> usize {
        (self.batch * UNIT / canvas.cells()).clamp(8.min(self.batch), self.batch)
    }

    fn per_trajectory(&self, canvas: Canvas) -> usize {
        if self.held_out {
            return self.per_trajectory;
        }
        (self.per_trajectory * UNIT / canvas.cells()).clamp(1, self.per_trajectory)
    }
}

/// Why there are no more batches.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SampleError {
    /// The dataset can't be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A record can't be replayed.
    #[error("trajectory {index}: {cause}")]
    Replay {
        /// Its number.
        index: u64,
        /// What is wrong with it.
        cause: ReplayError,
    },
    /// A layer is larger than the network knows places.
    #[error(
        "trajectory {index} is of {width} x {height} cells: the network knows {most} places along each axis"
    )]
    TooLarge {
        /// Its number.
        index: u64,
        /// Columns.
        width: u16,
        /// Rows.
        height: u16,
        /// Most columns or rows.
        most: u32,
    },
}

/// Examples on one canvas.
#[derive(Clone, Debug)]
pub struct Batch {
    /// What the network is given.
    pub inputs: Inputs,
    /// The cell of the canvas, row by row, where the true move's window begins.
    pub position: Vec<i64>,
    /// The true move's class.
    pub action: Vec<i64>,
    /// For each cell of each canvas whether the true position is ranked above it; it itself is not
    /// marked.
    pub rivals: Vec<bool>,
    /// Names of the layouts.
    pub layouts: Vec<String>,
    /// How often the true moves would be met without a network; zeros where that was not asked for.
    pub odds: Vec<Odds>,
}

/// A batch as tensors.
#[derive(Debug)]
pub struct Targets {
    /// `[batch]`, cells of the canvas.
    pub position: Tensor,
    /// `[batch]`, classes.
    pub action: Tensor,
    /// `[batch, cells]`.
    pub rivals: Tensor,
}

impl Batch {
    fn new(canvas: Canvas, history: usize) -> Self {
        Self {
            inputs: Inputs::new(canvas, history),
            position: Vec::new(),
            action: Vec::new(),
            rivals: Vec::new(),
            layouts: Vec::new(),
            odds: Vec::new(),
        }
    }

    fn push(&mut self, example: &Example, settings: &SampleSettings) {
        let Example { episode, move_index, symmetry, .. } = example;
        let (canvas, size) = (self.inputs.canvas(), episode.layer.size());
        let links = episode.links_before(*move_index);
        let made = episode.made[*move_index];
        let state = State {
            layer: &episode.layer,
            links: &links,
            crossings: made.before,
            initial: episode.initial,
            made: &episode.made[..*move_index],
        };
        self.inputs.push(&state, *symmetry);
        let cell = |x: u32, y: u32| (y * canvas.width + x) as usize;
        let begin = self.rivals.len();
        self.rivals.resize(begin + canvas.cells(), false);
        let marked = &mut self.rivals[begin..];
        match settings.rivals {
            Rivals::Applicable => links.for_each_variant(|placed| {
                let placed = symmetry.map_variant(placed, size);
                marked[cell(placed.x.into(), placed.y.into())] = true;
            }),
            Rivals::Boundary => {
                let places = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
                for (x, y) in places.filter(|&(x, y)| episode.layer.is_boundary(x, y)) {
                    let (column, row) = symmetry.map_cell((x, y), size);
                    marked[cell(column, row)] = true;
                }
            }
        }
        let placed = symmetry.map_variant(made.placed, size);
        let position = cell(placed.x.into(), placed.y.into());
        marked[position] = false;
        self.position.push(position as i64);
        self.action.push(i64::from(placed.variant.class()));
        self.layouts.push(example.layout.to_string());
        self.odds.push(if settings.held_out {
            Odds::of(&state, made.placed)
        } else {
            Odds::default()
        });
    }

    /// Its targets as tensors.
    pub fn targets(&self, device: Device) -> Targets {
        let batch = self.position.len() as i64;
        Targets {
            position: Tensor::from_slice(&self.position).to_device(device),
            action: Tensor::from_slice(&self.action).to_device(device),
            rivals: Tensor::from_slice(&self.rivals).view([batch, -1]).to_device(device),
        }
    }
}

/// A move of an episode as it is to be seen.
struct Example {
    episode: Arc<Episode>,
    layout: Arc<str>,
    move_index: usize,
    symmetry: Symmetry,
}

/// The batches of one epoch.
pub struct Batches<'a> {
    settings: &'a SampleSettings,
    split: Split,
    strata: u64,
    trajectories: Shuffled<'a, Trajectory>,
    rng: ChaCha8Rng,
    pools: BTreeMap<Canvas, Vec<Example>>,
    ended: bool,
}

/// Blocks of the dataset that are mixed at a time.
const WINDOW: usize = 16;

impl<'a> Batches<'a> {
    /// Those of one part of a dataset; each epoch has another order and other examples.
    pub fn new(
        dataset: &'a Dataset,
        split: Split,
        settings: &'a SampleSettings,
        epoch: u64,
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        rng.set_stream(1 << 32 | epoch);
        Self {
            settings,
            split,
            strata: dataset.manifest().strata.len() as u64,
            trajectories: dataset.shuffled(settings.seed, epoch, WINDOW),
            rng,
            pools: BTreeMap::new(),
            ended: false,
        }
    }

    /// Passes over batches at less than the cost of making them; gives how many there were to pass
    /// over.
    pub fn skip_batches(&mut self, count: u64) -> Result<u64, SampleError> {
        for skipped in 0..count {
            if self.draw()?.is_none() {
                return Ok(skipped);
            }
        }
        Ok(count)
    }

    /// The examples of the next batch.
    fn draw(&mut self) -> Result<Option<(Canvas, Vec<Example>)>, SampleError> {
        loop {
            let waits_for = if self.ended { 1 } else { self.settings.pool.max(1) };
            let full = self
                .pools
                .iter()
                .find(|(canvas, pool)| pool.len() >= waits_for * self.settings.batch(**canvas));
            let canvas = full.map(|(&canvas, _)| canvas);
            let left =
                || self.pools.iter().find(|(_, pool)| !pool.is_empty()).map(|(&canvas, _)| canvas);
            if let Some(canvas) = canvas.or_else(|| if self.ended { left() } else { None }) {
                let count = self.settings.batch(canvas);
                let pool = self.pools.get_mut(&canvas).expect("just found");
                let count = count.min(pool.len());
                let drawn = (0..count)
                    .map(|_| pool.swap_remove(self.rng.random_range(0..pool.len())))
                    .collect();
                return Ok(Some((canvas, drawn)));
            }
            if self.ended {
                return Ok(None);
            }
            match self.trajectories.next() {
                None => self.ended = true,
                Some(trajectory) => self.take(&trajectory?)?,
            }
        }
    }

    /// Puts some examples of a trajectory into the pool of each canvas that their symmetries need.
    fn take(&mut self, trajectory: &Trajectory) -> Result<(), SampleError> {
        if Split::of(trajectory, self.strata) != self.split {
            return Ok(());
        }
        let Trajectory { index, width, height, .. } = *trajectory;
        if u32::from(width.max(height)) > PLACES {
            return Err(SampleError::TooLarge { index, width, height, most: PLACES });
        }
        let replay = |cause| SampleError::Replay { index, cause };
        let Some(episode) = Episode::new(trajectory).map_err(replay)? else { return Ok(()) };
        if episode.needed.is_empty() {
            return Ok(());
        }
        let (episode, layout) = (Arc::new(episode), Arc::from(trajectory.instance.name()));
        let size = episode.layer.size();
        let mut quarters: [Vec<usize>; 4] = Default::default();
        for &at in &episode.needed {
            quarters[depth_quarter(episode.made[at].placed, size)].push(at);
        }
        let occupied: Vec<_> = quarters.into_iter().filter(|quarter| !quarter.is_empty()).collect();
        let count = self.settings.per_trajectory(Canvas::holding(size)).min(episode.needed.len());
        for _ in 0..count {
            let from = if self.rng.random::<f64>() < self.settings.balance {
                &occupied[self.rng.random_range(0..occupied.len())]
            } else {
                &episode.needed
            };
            let move_index = from[self.rng.random_range(0..from.len())];
            let symmetry = if self.settings.held_out { 0 } else { self.rng.random_range(0..8) };
            let symmetry = Symmetry::ALL[symmetry];
            let canvas = Canvas::holding(symmetry.map_size(size));
            let example = Example {
                episode: Arc::clone(&episode),
                layout: Arc::clone(&layout),
                move_index,
                symmetry,
            };
            self.pools.entry(canvas).or_default().push(example);
        }
        Ok(())
    }
}

impl Iterator for Batches<'_> {
    type Item = Result<Batch, SampleError>;

    fn next(&mut self) -> Option<Self::Item> {
        let (canvas, examples) = match self.draw() {
            Ok(drawn) => drawn?,
            Err(error) => return Some(Err(error)),
        };
        let mut batch = Batch::new(canvas, self.settings.history);
        examples.iter().for_each(|example| batch.push(example, self.settings));
        Some(Ok(batch))
    }
}
