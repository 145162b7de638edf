//! Solid layers: which parts of an infill region lie near the top or bottom of the part.

use super::insets::mean_width_mm;
use super::settings::Settings;
use crate::area::{Area, Ring};

/// Mean width in mm below which a piece of a surface is a rounding error.
const SLIVER_MM: f64 = 0.005;

/// Half the width, in beads, below which solid pieces are dropped.
const MIN_HALF_WIDTH: f64 = 0.45;

/// Distance, in beads, by which solid pieces grow into the sparse region.
const ANCHOR: f64 = 1.0;

/// The surfaces of a layer that nothing of the part covers.
#[derive(Clone, Debug, Default)]
pub(super) struct Surfaces {
    /// What the layer above does not cover.
    pub(super) top: Area,
    /// What the layer below does not support.
    pub(super) bottom: Area,
}

impl Surfaces {
    /// The surfaces of a layer; the layers below and above are `None` beyond the part.
    pub(super) fn new(layer: &Area, below: Option<&Area>, above: Option<&Area>) -> Self {
        let uncovered = |other: Option<&Area>| match other {
            None => layer.clone(),
            Some(other) if other == layer => Area::default(),
            Some(other) => {
                let is_real = |rings: &[Ring]| mean_width_mm(rings) >= SLIVER_MM;
                layer.difference(other).split(is_real).0
            }
        };
        Self { top: uncovered(above), bottom: uncovered(below) }
    }
}

/// Where a layer is solid.
///
/// A point lies below fewer layers of the part than required if, at that point, one of these layers
/// has a top surface; so surfaces need to be compared with the next layer only.
pub(super) fn near_surface(surfaces: &[Surfaces], layer: usize, settings: &Settings) -> Area {
    let above = surfaces[layer..].iter().take(settings.top_layers as usize);
    let below = surfaces[..=layer].iter().rev().take(settings.bottom_layers as usize);
    let tops = above.map(|surfaces| &surfaces.top);
    let bottoms = below.map(|surfaces| &surfaces.bottom);
    Area::union_of(tops.chain(bottoms).cloned().collect())
}

/// Divides an infill region into solid and sparse, which share a border.
pub(super) fn divide(region: Area, near_surface: &Area, settings: &Settings) -> (Area, Area) {
    let bead_mm = settings.bead_mm;
    if settings.density >= 1.0 {
        return (region, Area::default());
    }
    let solid = region.intersection(near_surface).offset(-MIN_HALF_WIDTH * bead_mm);
    if solid.is_empty() {
        return (Area::default(), region);
    }
    let solid = solid.offset((MIN_HALF_WIDTH + ANCHOR) * bead_mm).intersection(&region);
    // Sparse pieces that are too narrow become solid.
    let is_wide = |rings: &[Ring]| mean_width_mm(rings) >= bead_mm;
    let (sparse, narrow) = region.difference(&solid).split(is_wide);
    if narrow.is_empty() {
        return (solid, sparse);
    }
    (region.difference(&sparse), sparse)
}
