//! A batch of examples as arrays, and its targets as tensors.

use std::sync::Arc;

use beadwork_grid::Symmetry;
use ndarray::{Array1, Array3};
use serde::{Deserialize, Serialize};
use tch::{Device, Tensor};

use crate::fusion::baseline::Baseline;
use crate::fusion::episode::Episode;
use crate::fusion::inputs::{Canvas, Inputs};
use crate::fusion::layer::State;

/// Which positions are negatives: the recorded position should score above each of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Negatives {
    /// Positions where a move applies: a planner never proposes any other.
    #[default]
    Applicable,
    /// Cells with a neighbour in another zone, as in the paper.
    Boundary,
}

/// Examples on one canvas.
///
/// Arrays convert to tensors without a loop, for instance `Tensor::try_from(&batch.inputs.image())`
/// or `Tensor::try_from(&batch.negatives)`.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Images and histories.
    pub inputs: Inputs,
    /// Target position, `[example]`: the top-left cell of the recorded move's window as
    /// `y * canvas width + x`.
    pub position: Array1<i64>,
    /// Target action, `[example]`: the recorded move's variant, 0 to 11.
    pub action: Array1<i64>,
    /// Negative positions, `[example, y, x]`, on the whole canvas.
    /// The target position is not among them.
    pub negatives: Array3<bool>,
    /// Name of each example's layout, or of its picture.
    pub layouts: Vec<String>,
    /// Baseline of each example; zeros unless [`Settings::held_out`](super::Settings::held_out) is
    /// set.
    pub baselines: Vec<Baseline>,
}

/// The targets of a batch as tensors.
#[derive(Debug)]
pub struct Targets {
    /// `[batch]`: `y * canvas width + x` of the recorded position.
    pub position: Tensor,
    /// `[batch]`: variant of the recorded move.
    pub action: Tensor,
    /// `[batch, y * x]`: whether a cell is a negative position.
    pub negatives: Tensor,
}

/// A needed move of an episode, and the symmetry that transforms the example.
pub(super) struct Example {
    pub(super) episode: Arc<Episode>,
    pub(super) layout: Arc<str>,
    pub(super) move_index: usize,
    pub(super) symmetry: Symmetry,
}

impl Batch {
    /// Turns examples, whose layers must fit on `canvas`, into arrays.
    /// Linear in the cells of all canvases and in the moves before each example.
    pub(super) fn new(
        canvas: Canvas,
        examples: &[Example],
        history: usize,
        negatives: Negatives,
        with_baselines: bool,
    ) -> Self {
        let mut inputs = Inputs::new(canvas, history);
        let shape = (examples.len(), canvas.height as usize, canvas.width as usize);
        let mut is_negative = Array3::from_elem(shape, false);
        let (mut positions, mut actions) = (Vec::new(), Vec::new());
        let (mut layouts, mut baselines) = (Vec::new(), Vec::new());
        for (index, example) in examples.iter().enumerate() {
            let Example { episode, move_index, symmetry, .. } = example;
            let links = episode.links_before(*move_index);
            let recorded = episode.moves[*move_index];
            let state = State {
                layer: &episode.layer,
                links: &links,
                crossings: recorded.before,
                initial: episode.initial,
                moves: &episode.moves[..*move_index],
            };
            inputs.push(&state, *symmetry);

            let size = episode.layer.size();
            let mut mark = |(x, y): (u32, u32), negative| {
                is_negative[[index, y as usize, x as usize]] = negative;
            };
            match negatives {
                Negatives::Applicable => links.for_each_variant(|placed| {
                    let placed = symmetry.map_variant(placed, size);
                    mark((placed.x.into(), placed.y.into()), true);
                }),
                Negatives::Boundary => {
                    let cells = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
                    let boundary = cells.filter(|&(x, y)| episode.layer.is_boundary(x, y));
                    boundary.for_each(|cell| mark(symmetry.map_cell(cell, size), true));
                }
            }
            let target = symmetry.map_variant(recorded.placed, size);
            mark((target.x.into(), target.y.into()), false);

            positions.push(i64::from(target.y) * i64::from(canvas.width) + i64::from(target.x));
            actions.push(i64::from(target.variant.class()));
            layouts.push(example.layout.to_string());
            baselines.push(if with_baselines {
                Baseline::new(&state, recorded.placed)
            } else {
                Baseline::default()
            });
        }
        Self {
            inputs,
            position: Array1::from_vec(positions),
            action: Array1::from_vec(actions),
            negatives: is_negative,
            layouts,
            baselines,
        }
    }

    /// Number of examples.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are no examples.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Copies the targets to a device.
    pub fn targets(&self, device: Device) -> Targets {
        let contiguous = "arrays made by `Batch::new` are contiguous";
        let negatives = Tensor::try_from(&self.negatives).expect(contiguous);
        Targets {
            position: Tensor::try_from(&self.position).expect(contiguous).to_device(device),
            action: Tensor::try_from(&self.action).expect(contiguous).to_device(device),
            negatives: negatives.flatten(1, -1).to_device(device),
        }
    }
}
