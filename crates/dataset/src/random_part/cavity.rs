//! Space that stays empty, which makes the kinds of parts other than plain ones.

use std::ops::Range;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::mask::{Mask, Rectangle};
use super::settings::{Kind, MIN_FEATURE_LAYERS, Settings};

/// Space that stays empty: a rectangle in each of some layers.
#[derive(Clone, Debug)]
pub(super) struct Cavity {
    /// The layers, from the bottom.
    layers: Range<u32>,
    /// The rectangle in the first of them.
    first: Rectangle,
    /// Number of layers per step.
    period: u32,
    /// Change of the rectangle's corner and of its size at each step.
    step: [[i64; 2]; 2],
    /// Maximum number of steps.
    max_steps: u32,
}

/// Width of the gap between islands.
const MIN_GAP: i64 = 2;

/// Maximum width of the gap between islands.
const MAX_GAP: i64 = 5;

/// Minimum side of a hole.
const MIN_HOLE: i64 = 3;

/// The first layer of a part, and its cavities.
pub(super) fn start(settings: &Settings, rng: &mut ChaCha8Rng) -> (Mask, Vec<Cavity>) {
    let mut mask = Mask::empty(settings.width, settings.height);
    if settings.kind == Kind::Islands {
        let (tiles, cuts) = islands(settings, rng);
        for tile in tiles {
            mask.set(rectangle(settings, tile, rng), true);
        }
        return (mask, cuts);
    }
    let grid = Rectangle { corner: [0; 2], size: [settings.width.into(), settings.height.into()] };
    let first = rectangle(settings, grid, rng);
    mask.set(first, true);
    let cavities = match settings.kind {
        Kind::Branches => branches(settings, first, rng),
        Kind::Holes => holes(settings, first, rng),
        Kind::Plain | Kind::Islands => Vec::new(),
    };
    (mask, cavities)
}

/// True if a part shows the feature of its kind.
pub(super) fn shows_feature(kind: Kind, layers: &[Mask]) -> bool {
    let count = |shows: fn(&Mask) -> bool| layers.iter().filter(|layer| shows(layer)).count();
    match kind {
        Kind::Plain => true,
        Kind::Branches | Kind::Islands => {
            count(|layer| layer.component_count() > 1) >= MIN_FEATURE_LAYERS
        }
        Kind::Holes => count(Mask::has_hole) >= MIN_FEATURE_LAYERS,
    }
}

impl Cavity {
    /// Empties the cells of the cavity in a layer.
    pub(super) fn carve(&self, layer: u32, mask: &mut Mask) {
        if self.layers.contains(&layer) {
            let steps = ((layer - self.layers.start) / self.period).min(self.max_steps);
            let at = |value: [i64; 2], change: [i64; 2]| {
                [0, 1].map(|axis| value[axis] + i64::from(steps) * change[axis])
            };
            let corner = at(self.first.corner, self.step[0]);
            mask.set(Rectangle { corner, size: at(self.first.size, self.step[1]) }, false);
        }
    }
}

/// A random rectangle of the settings' sides within another one.
fn rectangle(settings: &Settings, within: Rectangle, rng: &mut ChaCha8Rng) -> Rectangle {
    let size = within.size.map(|space| {
        let max = i64::from(settings.max_side).min(space);
        rng.random_range(i64::from(settings.min_side).min(max)..=max)
    });
    let corner = [0, 1]
        .map(|axis| within.corner[axis] + rng.random_range(0..=within.size[axis] - size[axis]));
    Rectangle { corner, size }
}

/// The axes across which a part is cut: one of them, or both.
fn cut_axes(rng: &mut ChaCha8Rng) -> &'static [usize] {
    [&[0][..], &[1], &[0, 1]][rng.random_range(0..3)]
}

/// Tiles of the grid, one for each island, and the gaps between them.
fn islands(settings: &Settings, rng: &mut ChaCha8Rng) -> (Vec<Rectangle>, Vec<Cavity>) {
    let grid = [i64::from(settings.width), i64::from(settings.height)];
    let mut tiles = vec![Rectangle { corner: [0; 2], size: grid }];
    let mut cuts = Vec::new();
    for &axis in cut_axes(rng) {
        let gap = rng.random_range(MIN_GAP..=MAX_GAP.min(grid[axis] - 2));
        let low = ((grid[axis] - gap) / 3).max(1);
        let at = rng.random_range(low..=(grid[axis] - gap - low).max(low));
        tiles = tiles.into_iter().flat_map(|tile| split(tile, axis, at, gap)).collect();
        let mut first = Rectangle { corner: [0; 2], size: grid };
        first.corner[axis] = at;
        first.size[axis] = gap;
        let layers = 0..u32::MAX;
        cuts.push(Cavity { layers, first, period: 1, step: [[0; 2]; 2], max_steps: 0 });
    }
    (tiles, cuts)
}

/// The two sides of a gap of a tile.
fn split(tile: Rectangle, axis: usize, at: i64, gap: i64) -> [Rectangle; 2] {
    let (mut low, mut high) = (tile, tile);
    low.size[axis] = at - tile.corner[axis];
    high.corner[axis] = at + gap;
    high.size[axis] = tile.corner[axis] + tile.size[axis] - at - gap;
    [low, high]
}

/// Cuts through the middle third of the first layer, which begin in the lower half of the part and
/// grow wider.
fn branches(settings: &Settings, first: Rectangle, rng: &mut ChaCha8Rng) -> Vec<Cavity> {
    let from = rng.random_range(1..=(settings.min_layers / 2).max(1));
    let axes = cut_axes(rng);
    let cut = |&axis: &usize| {
        let third = first.size[axis] / 3;
        let at = first.corner[axis] + rng.random_range(third..=first.size[axis] - third);
        let mut cut =
            Rectangle { corner: [0; 2], size: [settings.width.into(), settings.height.into()] };
        (cut.corner[axis], cut.size[axis]) = (at, 1);
        // Each step moves both sides by one cell.
        let mut step = [[0; 2]; 2];
        (step[0][axis], step[1][axis]) = (-1, 2);
        let period = rng.random_range(1..=3);
        let max_steps = rng.random_range(1..=(first.size[axis] as u32 / 4).max(1));
        Cavity { layers: from..u32::MAX, first: cut, period, step, max_steps }
    };
    axes.iter().map(cut).collect()
}

/// Channels with square cross-sections, which begin within the first layer's rectangle in the lower
/// half of the part.
/// Each is vertical, or inclined along x or y by at most one cell a layer.
fn holes(settings: &Settings, first: Rectangle, rng: &mut ChaCha8Rng) -> Vec<Cavity> {
    let smaller = first.size[0].min(first.size[1]);
    let count = rng.random_range(1..=3);
    let hole = |_: i32| {
        let side = rng.random_range(MIN_HOLE..=(smaller / 4).max(MIN_HOLE));
        let corner = [0, 1].map(|axis| {
            first.corner[axis] + rng.random_range(0..=(first.size[axis] - side).max(0))
        });
        let from = rng.random_range(0..=settings.min_layers / 2);
        let layers = from..from + rng.random_range(MIN_FEATURE_LAYERS as u32..=settings.max_layers);
        let mut step = [[0; 2]; 2];
        step[0] = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]][rng.random_range(0..5)];
        let period = rng.random_range(1..=6);
        let first = Rectangle { corner, size: [side; 2] };
        Cavity { layers, first, period, step, max_steps: u32::MAX }
    };
    (0..count).map(hole).collect()
}
