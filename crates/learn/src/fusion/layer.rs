//! A layer and a state of its path as the network sees them.

use beadwork_grid::{Crossings, Links, PlacedVariant, Region, Symmetry, Zones};
use tch::{Device, Kind, Tensor};

use super::{CHANNELS, History};

/// What of a layer stays the same whatever the path.
#[derive(Clone, Debug)]
pub struct Layer {
    size: (u32, u32),
    /// Of each cell of the plane, row by row; [`Zones::OUTSIDE`] outside the layer.
    zones: Vec<u8>,
    /// The greatest of them inside, at least 1.
    greatest_zone: u8,
    /// Whether a cell lies beside another zone.
    boundary: Vec<bool>,
    crossings: Crossings,
}

/// Rows and columns of an image, both multiples of 16.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Canvas {
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
}

impl Canvas {
    /// The smallest that holds a plane of so many columns and rows.
    pub fn holding((width, height): (u32, u32)) -> Self {
        Self { height: height.next_multiple_of(16), width: width.next_multiple_of(16) }
    }

    /// Cells of it.
    pub fn cells(self) -> usize {
        (self.height * self.width) as usize
    }
}

/// A move that was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Made {
    /// The move.
    pub placed: PlacedVariant,
    /// Crossings before it.
    pub before: u32,
    /// Crossings after it.
    pub after: u32,
}

/// A state of a layer's path, and how it came about.
#[derive(Clone, Copy, Debug)]
pub struct State<'a> {
    /// The layer.
    pub layer: &'a Layer,
    /// Its path's links.
    pub links: &'a Links,
    /// Crossings of the path.
    pub crossings: u32,
    /// Crossings at the start, to which those of the network's inputs are relative.
    pub initial: u32,
    /// The moves made, the last one last.
    pub made: &'a [Made],
}

impl Layer {
    /// Notes zones and where they meet.
    /// Linear in the plane's cells.
    pub fn new(region: &Region, zones: &Zones) -> Self {
        let inside = |cell: u32| region.contains(cell).then(|| zones.id(cell));
        let cells = 0..region.grid_len() as u32;
        let boundary = cells.map(|cell| {
            let own = inside(cell);
            own.is_some() && region.neighbours(cell).any(|other| inside(other) != own)
        });
        let greatest = zones.ids().iter().filter(|&&id| id != Zones::OUTSIDE).max();
        Self {
            size: (region.width(), region.height()),
            zones: zones.ids().to_vec(),
            greatest_zone: greatest.map_or(1, |&zone| zone.max(1)),
            boundary: boundary.collect(),
            crossings: Crossings::new(region, zones),
        }
    }

    /// Columns and rows of its plane.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Which links cross.
    pub fn crossings(&self) -> &Crossings {
        &self.crossings
    }

    /// By how much a move changes the crossings.
    pub fn change(&self, placed: PlacedVariant) -> i32 {
        placed.switches(self.size.0).iter().map(|&switch| self.crossings.change(switch)).sum()
    }

    /// Whether a cell lies beside another zone.
    pub fn is_boundary(&self, x: u32, y: u32) -> bool {
        self.boundary[(y * self.size.0 + x) as usize]
    }
}

/// Inputs of the network for layers that lie on one canvas, in the order in which they are added.
#[derive(Clone, Debug)]
pub struct Inputs {
    canvas: Canvas,
    /// Moves remembered of each, K.
    history: usize,
    count: usize,
    /// `[batch, y, x, channel]`: convolutions are fastest when the channels lie together.
    state: Vec<f32>,
    action: Vec<i64>,
    y: Vec<i64>,
    x: Vec<i64>,
    before: Vec<f32>,
    after: Vec<f32>,
    mask: Vec<f32>,
}

impl Inputs {
    /// None yet.
    pub fn new(canvas: Canvas, history: usize) -> Self {
        Self {
            canvas,
            history,
            count: 0,
            state: Vec::new(),
            action: Vec::new(),
            y: Vec::new(),
            x: Vec::new(),
            before: Vec::new(),
            after: Vec::new(),
            mask: Vec::new(),
        }
    }

    /// The canvas of all.
    pub fn canvas(&self) -> Canvas {
        self.canvas
    }

    /// Number of layers.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Adds a state as it looks after a symmetry.
    /// Linear in the canvas.
    ///
    /// # Panics
    /// If the canvas does not hold it.
    pub fn push(&mut self, state: &State<'_>, symmetry: Symmetry) {
        let size = state.layer.size;
        let (width, height) = symmetry.map_size(size);
        assert!(
            width <= self.canvas.width && height <= self.canvas.height,
            "{width} x {height} cells do not fit on {:?}",
            self.canvas
        );
        self.push_image(state, symmetry);
        let initial = state.initial.max(1) as f32;
        let made = &state.made[state.made.len().saturating_sub(self.history)..];
        for at in 0..self.history {
            let made = made.get(at);
            let placed = made.map(|made| symmetry.map_variant(made.placed, size));
            self.action.push(placed.map_or(0, |placed| i64::from(placed.variant.class())));
            self.y.push(placed.map_or(0, |placed| i64::from(placed.y)));
            self.x.push(placed.map_or(0, |placed| i64::from(placed.x)));
            self.before.push(made.map_or(0.0, |made| made.before as f32 / initial));
            self.after.push(made.map_or(0.0, |made| made.after as f32 / initial));
            self.mask.push(f32::from(u8::from(made.is_some())));
        }
        self.count += 1;
    }

    fn push_image(&mut self, state: &State<'_>, symmetry: Symmetry) {
        const FEATURES: usize = CHANNELS as usize;
        let Layer { size, zones, greatest_zone, boundary, crossings } = state.layer;
        let begin = self.state.len();
        self.state.resize(begin + self.canvas.cells() * FEATURES, 0.0);
        let image = &mut self.state[begin..];
        let (width, height) = symmetry.map_size(*size);
        let columns = self.canvas.width;
        let place = move |(x, y): (u32, u32)| (y * columns + x) as usize * FEATURES;
        let zone_scale = 1.0 / f32::from(*greatest_zone);
        let share = state.crossings as f32 / state.initial.max(1) as f32;
        let step = |count: u32| 1.0 / count.saturating_sub(1).max(1) as f32;
        let (step_x, step_y) = (step(width), step(height));
        let mut most = 0.0_f32;
        for y in 0..size.1 {
            for x in 0..size.0 {
                let cell = y * size.0 + x;
                let zone = zones[cell as usize];
                if zone == Zones::OUTSIDE {
                    continue;
                }
                let here = symmetry.map_cell((x, y), *size);
                let pixel = &mut image[place(here)..][..FEATURES];
                pixel[0] = f32::from(zone) * zone_scale;
                pixel[3] = 1.0;
                pixel[4] = f32::from(u8::from(boundary[cell as usize]));
                pixel[6] = share;
                pixel[7] = here.1 as f32 * step_y;
                pixel[8] = here.0 as f32 * step_x;
                let (right, below) = state.links.right_and_below(x, y);
                let links = [
                    (right, (x + 1, y), right && crossings.right(cell)),
                    (below, (x, y + 1), below && crossings.below(cell)),
                ];
                for (linked, neighbour, crosses) in links {
                    if !linked {
                        continue;
                    }
                    let there = symmetry.map_cell(neighbour, *size);
                    let first = (here.0.min(there.0), here.1.min(there.1));
                    image[place(first) + if here.1 == there.1 { 1 } else { 2 }] = 1.0;
                    if crosses {
                        for end in [here, there] {
                            let crossed = &mut image[place(end) + 5];
                            *crossed += 1.0;
                            most = most.max(*crossed);
                        }
                    }
                }
            }
        }
        if most > 0.0 {
            image.iter_mut().skip(5).step_by(FEATURES).for_each(|crossed| *crossed /= most);
        }
    }

    /// As tensors: the image `[batch, 9, y, x]`, whose channels lie together in memory, and the
    /// histories.
    pub fn tensors(&self, device: Device) -> (Tensor, History) {
        let batch = self.count as i64;
        let size = [batch, i64::from(self.canvas.height), i64::from(self.canvas.width), CHANNELS];
        let state =
            Tensor::from_slice(&self.state).view(size).to_device(device).permute([0, 3, 1, 2]);
        let moves = [batch, self.history as i64];
        let whole = |numbers: &[i64]| Tensor::from_slice(numbers).view(moves).to_device(device);
        let share = |numbers: &[f32]| Tensor::from_slice(numbers).view(moves).to_device(device);
        let history = History {
            action: whole(&self.action),
            y: whole(&self.y),
            x: whole(&self.x),
            before: share(&self.before),
            after: share(&self.after),
            mask: share(&self.mask),
        };
        debug_assert_eq!(state.kind(), Kind::Float);
        (state, history)
    }
}
