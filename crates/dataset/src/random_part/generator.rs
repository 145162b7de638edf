//! Grows a part layer by layer.

use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use ndarray::Array3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use super::cavity::{Cavity, shows_feature, start};
use super::mask::{Kernel, Mask, Rectangle};
use super::settings::{Kind, Settings, SettingsError};

/// The error of a random part that cannot be generated.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RandomPartError {
    /// A setting is out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// No attempt gave a part that is long enough and shows the feature of its kind.
    #[error(
        "random part: none of {attempts} attempts gave a part of kind '{kind}' with at least \
         {min_layers} layers: smaller or fewer indentations help, and so does a larger first layer"
    )]
    Attempts {
        /// Number of attempts.
        attempts: u32,
        /// The requested kind.
        kind: Kind,
        /// Minimum number of layers.
        min_layers: u32,
    },
}

/// Generates a random part, all of material 0, on a grid of the settings' size.
///
/// The number of layers is that of the part, from [`Settings::min_layers`] to
/// [`Settings::max_layers`], and every layer has cells.
/// A part of a kind other than [`Kind::Plain`] shows its feature, several components or a hole, in
/// at least three layers.
///
/// Takes time linear in the number of voxels of the grid, at about 0.1 microseconds each, and
/// rarely more than a few attempts with a preset.
pub fn random_part(settings: &Settings, seed: u64) -> Result<Voxels, RandomPartError> {
    settings.check()?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let generator = Generator {
        settings,
        ellipse: Kernel::ellipse(settings.indentation_radius),
        square: Kernel::square(settings.overhang_radius),
    };
    for _ in 0..settings.max_attempts {
        let layers = generator.layers(&mut rng);
        if layers.len() >= settings.min_layers as usize && shows_feature(settings.kind, &layers) {
            return Ok(voxels(settings, &layers));
        }
    }
    let &Settings { kind, min_layers, max_attempts: attempts, .. } = settings;
    Err(RandomPartError::Attempts { attempts, kind, min_layers })
}

struct Generator<'a> {
    settings: &'a Settings,
    /// Smooths indentations.
    ellipse: Kernel,
    /// Smooths overhangs.
    square: Kernel,
}

impl Generator<'_> {
    /// The layers of one attempt, none of them empty.
    fn layers(&self, rng: &mut ChaCha8Rng) -> Vec<Mask> {
        let (first, cavities) = start(self.settings, rng);
        let mut layers = vec![first];
        for layer in 1..self.settings.max_layers {
            let below = &layers[layer as usize - 1];
            let next = self.next(below, layer, &cavities, rng);
            if next.is_empty() {
                break;
            }
            layers.push(next);
        }
        layers
    }

    /// The layer above `below`: empty if the part ends.
    fn next(&self, below: &Mask, layer: u32, cavities: &[Cavity], rng: &mut ChaCha8Rng) -> Mask {
        let is_overhang = rng.random_bool(self.settings.overhang_chance);
        let mut mask = if is_overhang { self.grown(below, rng) } else { self.indented(below, rng) };
        cavities.iter().for_each(|cavity| cavity.carve(layer, &mut mask));
        // An opening adds no cells, so it keeps to the overhang limit and to the cavities.
        let mut mask = mask.opened(if is_overhang { &self.square } else { &self.ellipse });
        let only_largest = matches!(self.settings.kind, Kind::Plain | Kind::Holes);
        mask.keep_supported(below, only_largest);
        mask
    }

    /// A layer without rectangles around some cells of its outer contour.
    fn indented(&self, below: &Mask, rng: &mut ChaCha8Rng) -> Mask {
        let contour = below.contour();
        let mut mask = below.clone();
        for _ in 0..rng.random_range(1..=self.settings.max_indentations) {
            let cell = contour[rng.random_range(0..contour.len())];
            let centre = [cell % below.width, cell / below.width];
            let size = [(); 2]
                .map(|()| i64::from(rng.random_range(1..=self.settings.max_indentation_side)));
            let corner = [0, 1].map(|axis| centre[axis] as i64 - size[axis] / 2);
            mask.set(Rectangle { corner, size }, false);
        }
        mask
    }

    /// A layer with a random subset of the cells beside it.
    fn grown(&self, below: &Mask, rng: &mut ChaCha8Rng) -> Mask {
        let mut mask = below.clone();
        for cell in below.beside() {
            mask.cells[cell] = rng.random_bool(self.settings.growth);
        }
        mask
    }
}

/// The part of which these are the layers, with its left and front sides at 0 mm.
fn voxels(settings: &Settings, layers: &[Mask]) -> Voxels {
    let &Settings { width, height, cell_mm, layer_mm, .. } = settings;
    let back_mm = f64::from(height) * cell_mm;
    let frame = Frame { left_mm: 0.0, back_mm, cell_mm, layer_mm, width, height };
    let shape = (layers.len(), height as usize, width as usize);
    let filled = layers.iter().flat_map(|layer| &layer.cells);
    let materials = filled.map(|&filled| if filled { 0 } else { Voxels::EMPTY }).collect();
    let materials = Array3::from_shape_vec(shape, materials)
        .expect("each layer has a value for each cell of the grid");
    Voxels::new(frame, materials)
}
