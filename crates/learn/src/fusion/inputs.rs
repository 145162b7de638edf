//! The network's inputs: an image of each state and its last moves.
//!
//! Inputs are stored as plain arrays: [`Inputs::image`] and [`Inputs::history`] return `ndarray`
//! views of them, [`Inputs::tensors`] copies them to a device of libtorch.

use beadwork_grid::{Symmetry, Zones};
use ndarray::{ArrayView2, ArrayView4};
use tch::kind::Element;
use tch::{Device, Tensor};

use super::config::CHANNELS;
use super::history::History;
use super::layer::State;

/// Height and width of an image in cells, both multiples of 16.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Canvas {
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
}

impl Canvas {
    /// The smallest canvas that holds a grid of this width and height.
    pub fn holding((width, height): (u32, u32)) -> Self {
        Self { height: height.next_multiple_of(16), width: width.next_multiple_of(16) }
    }

    /// Number of cells.
    pub fn cells(self) -> usize {
        (self.height * self.width) as usize
    }
}

/// Inputs of the network for a batch of states on one canvas.
///
/// A layer lies in the top-left corner of the canvas; the rest of the canvas is 0 in all channels.
#[derive(Clone, Debug)]
pub struct Inputs {
    canvas: Canvas,
    /// Moves of the history, K.
    history: usize,
    /// Number of states.
    count: usize,
    /// `[example, y, x, channel]`.
    /// The channels of a cell are adjacent in memory (channels last), which makes convolutions 1.2
    /// to 1.5 times as fast as the usual order of axes.
    image: Vec<f32>,
    // Moves, `[example, move]`; see `HistoryArrays`.
    action: Vec<i64>,
    y: Vec<i64>,
    x: Vec<i64>,
    before: Vec<f32>,
    after: Vec<f32>,
    mask: Vec<f32>,
}

/// The last moves before each state of a batch: arrays with the axes `[example, move]`.
///
/// The moves of a state start at index 0, oldest first; the rest of its row is padding.
/// Moves are transformed by the same symmetry as the image.
#[derive(Clone, Copy, Debug)]
pub struct HistoryArrays<'a> {
    /// Variant of the move, 0 to 11.
    pub action: ArrayView2<'a, i64>,
    /// Row of its window's top-left cell.
    pub y: ArrayView2<'a, i64>,
    /// Column of its window's top-left cell.
    pub x: ArrayView2<'a, i64>,
    /// Crossings before the move, divided by those of the start path.
    pub before: ArrayView2<'a, f32>,
    /// Crossings after the move, divided by those of the start path.
    pub after: ArrayView2<'a, f32>,
    /// 1 for a move, 0 for padding.
    pub mask: ArrayView2<'a, f32>,
}

impl Inputs {
    /// An empty batch for images on `canvas` with up to `history` moves each.
    pub fn new(canvas: Canvas, history: usize) -> Self {
        Self {
            canvas,
            history,
            count: 0,
            image: Vec::new(),
            action: Vec::new(),
            y: Vec::new(),
            x: Vec::new(),
            before: Vec::new(),
            after: Vec::new(),
            mask: Vec::new(),
        }
    }

    /// The canvas of all images.
    pub fn canvas(&self) -> Canvas {
        self.canvas
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether the batch is empty.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Appends a state, transformed by a symmetry.
    /// Linear in the cells of the canvas.
    ///
    /// # Panics
    /// If the layer is larger than the canvas.
    pub fn push(&mut self, state: &State<'_>, symmetry: Symmetry) {
        let size = state.layer.size();
        let (width, height) = symmetry.map_size(size);
        assert!(
            width <= self.canvas.width && height <= self.canvas.height,
            "{width} x {height} cells do not fit on {:?}",
            self.canvas
        );
        self.push_image(state, symmetry);
        let initial = state.initial.max(1) as f32;
        let recent = &state.moves[state.moves.len().saturating_sub(self.history)..];
        for index in 0..self.history {
            let applied = recent.get(index);
            let placed = applied.map(|applied| symmetry.map_variant(applied.placed, size));
            self.action.push(placed.map_or(0, |placed| i64::from(placed.variant.class())));
            self.y.push(placed.map_or(0, |placed| i64::from(placed.y)));
            self.x.push(placed.map_or(0, |placed| i64::from(placed.x)));
            self.before.push(applied.map_or(0.0, |applied| applied.before as f32 / initial));
            self.after.push(applied.map_or(0.0, |applied| applied.after as f32 / initial));
            self.mask.push(f32::from(u8::from(applied.is_some())));
        }
        self.count += 1;
    }

    /// Appends the image of a state; [`CHANNELS`] lists the channels.
    ///
    /// One pass over the grid in its own orientation: each cell and each link is written to the
    /// position that the symmetry maps it to.
    fn push_image(&mut self, state: &State<'_>, symmetry: Symmetry) {
        const FEATURES: usize = CHANNELS as usize;
        let State { layer, links, .. } = *state;
        let (size, zones, crossings) = (layer.size(), layer.zones(), layer.crossings());
        let begin = self.image.len();
        self.image.resize(begin + self.canvas.cells() * FEATURES, 0.0);
        let image = &mut self.image[begin..];
        let (width, height) = symmetry.map_size(size);
        let canvas_width = self.canvas.width;
        let index_of = move |(x, y): (u32, u32)| (y * canvas_width + x) as usize * FEATURES;
        let zone_scale = 1.0 / f32::from(layer.max_zone());
        let relative_crossings = state.crossings as f32 / state.initial.max(1) as f32;
        let coordinate_scale = |count: u32| 1.0 / count.saturating_sub(1).max(1) as f32;
        let (scale_x, scale_y) = (coordinate_scale(width), coordinate_scale(height));
        let mut max_crossings_at_cell = 0.0_f32;
        for y in 0..size.1 {
            for x in 0..size.0 {
                let cell = y * size.0 + x;
                let zone = zones[cell as usize];
                if zone == Zones::OUTSIDE {
                    continue;
                }
                let here = symmetry.map_cell((x, y), size);
                let pixel = &mut image[index_of(here)..][..FEATURES];
                pixel[0] = f32::from(zone) * zone_scale;
                pixel[3] = 1.0;
                pixel[4] = f32::from(u8::from(layer.is_boundary(x, y)));
                pixel[6] = relative_crossings;
                pixel[7] = here.1 as f32 * scale_y;
                pixel[8] = here.0 as f32 * scale_x;
                let (right, below) = links.right_and_below(x, y);
                let cell_links = [
                    (right, (x + 1, y), right && crossings.right(cell)),
                    (below, (x, y + 1), below && crossings.below(cell)),
                ];
                for (linked, neighbour, crosses) in cell_links {
                    if !linked {
                        continue;
                    }
                    // A link is drawn at the upper or left of its two cells, which the symmetry may
                    // have swapped; it may also have turned a horizontal link into a vertical one.
                    let there = symmetry.map_cell(neighbour, size);
                    let first = (here.0.min(there.0), here.1.min(there.1));
                    image[index_of(first) + if here.1 == there.1 { 1 } else { 2 }] = 1.0;
                    if crosses {
                        for end in [here, there] {
                            let count = &mut image[index_of(end) + 5];
                            *count += 1.0;
                            max_crossings_at_cell = max_crossings_at_cell.max(*count);
                        }
                    }
                }
            }
        }
        if max_crossings_at_cell > 0.0 {
            let counts = image.iter_mut().skip(5).step_by(FEATURES);
            counts.for_each(|count| *count /= max_crossings_at_cell);
        }
    }

    /// The images, with the axes `[example, y, x, channel]`; [`CHANNELS`] lists the channels.
    ///
    /// ```no_run
    /// # fn images(inputs: &beadwork_learn::fusion::inputs::Inputs) -> Result<(), tch::TchError> {
    /// let image = tch::Tensor::try_from(&inputs.image())?;
    /// # Ok(())
    /// # }
    /// ```
    pub fn image(&self) -> ArrayView4<'_, f32> {
        let Canvas { height, width } = self.canvas;
        let shape = (self.count, height as usize, width as usize, CHANNELS as usize);
        ArrayView4::from_shape(shape, &self.image).expect("push appends whole images")
    }

    /// The last moves before each state.
    pub fn history(&self) -> HistoryArrays<'_> {
        HistoryArrays {
            action: self.moves(&self.action),
            y: self.moves(&self.y),
            x: self.moves(&self.x),
            before: self.moves(&self.before),
            after: self.moves(&self.after),
            mask: self.moves(&self.mask),
        }
    }

    fn moves<'a, T>(&self, values: &'a [T]) -> ArrayView2<'a, T> {
        ArrayView2::from_shape((self.count, self.history), values)
            .expect("push appends K values of each kind")
    }

    /// Copies the inputs to a device: images `[batch, 9, y, x]`, in channels-last memory order, and
    /// histories.
    pub fn tensors(&self, device: Device) -> (Tensor, History) {
        let image = Tensor::try_from(&self.image()).expect("the view is contiguous");
        let image = image.to_device(device).permute([0, 3, 1, 2]);
        (image, self.history().tensors(device))
    }
}

impl HistoryArrays<'_> {
    /// Copies the moves to a device.
    pub fn tensors(&self, device: Device) -> History {
        History {
            action: to_device(&self.action, device),
            y: to_device(&self.y, device),
            x: to_device(&self.x, device),
            before: to_device(&self.before, device),
            after: to_device(&self.after, device),
            mask: to_device(&self.mask, device),
        }
    }
}

fn to_device<T: Element>(array: &ArrayView2<'_, T>, device: Device) -> Tensor {
    Tensor::try_from(array).expect("the view is contiguous").to_device(device)
}
