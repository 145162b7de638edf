//! Solid layers: which parts of an infill region lie near the top or bottom of the part.

use super::insets::mean_width_mm;
use super::settings::Settings;
use crate::area::{Area, Ring};

/// Size in mm² below which a piece of a surface is dropped: a disc of 0.1 mm does not fit into it.
const SLIVER_MM2: f64 = 0.0078;

/// Tolerance, in beads, of outlines that are compared with those of the next layer.
const TOLERANCE: f64 = 0.02;

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

/// The outline of a layer, as exact as the comparison with other layers needs.
pub(super) fn coarse(layer: &Area, settings: &Settings) -> Area {
    layer.simplified(TOLERANCE * settings.bead_mm)
}

impl Surfaces {
    /// The surfaces of a layer; the layers below and above are `None` beyond the part.
    pub(super) fn new(layer: &Area, below: Option<&Area>, above: Option<&Area>) -> Self {
        let uncovered = |other: Option<&Area>| match other {
            None => layer.clone(),
            Some(other) if other == layer => Area::default(),
            Some(other) => layer.difference(other).without_slivers(SLIVER_MM2),
        };
        Self { top: uncovered(above), bottom: uncovered(below) }
    }
}

/// The centres of discs, nearly a bead wide, that have to be solid in a layer.
///
/// A point lies below fewer layers of the part than required if, at that point, one of these layers
/// has a top surface; so surfaces need to be compared with the next layer only.
pub(super) fn near_surface(surfaces: &[Surfaces], layer: usize, settings: &Settings) -> Area {
    let above = surfaces[layer..].iter().take(settings.top_layers as usize);
    let below = surfaces[..=layer].iter().rev().take(settings.bottom_layers as usize);
    let tops = above.map(|surfaces| &surfaces.top);
    let bottoms = below.map(|surfaces| &surfaces.bottom);
    let near = Area::union_of(tops.chain(bottoms).cloned().collect());
    offset(&near, -MIN_HALF_WIDTH, settings)
}

/// The area offset by a number of beads, to within the tolerance.
fn offset(area: &Area, beads: f64, settings: &Settings) -> Area {
    let tolerance_mm = TOLERANCE * settings.bead_mm;
    area.simplified(tolerance_mm).offset_within(beads * settings.bead_mm, tolerance_mm)
}

/// Divides an infill region into solid and sparse, which share a border.
///
/// `near_surface` is that of the layer.
/// Solid pieces grow, so that they are anchored in their surroundings.
pub(super) fn divide(region: Area, near_surface: &Area, settings: &Settings) -> (Area, Area) {
    if settings.density >= 1.0 {
        return (region, Area::default());
    }
    let near = region.intersection(near_surface).without_slivers(SLIVER_MM2);
    let solid = offset(&near, MIN_HALF_WIDTH + ANCHOR, settings).intersection(&region);
    if solid.is_empty() {
        return (Area::default(), region);
    }
    // Sparse pieces that are too narrow become solid.
    let is_wide = |rings: &[Ring]| mean_width_mm(rings) >= settings.bead_mm;
    let (sparse, narrow) = region.difference(&solid).split(is_wide);
    if sparse.is_empty() {
        return (region, sparse);
    }
    if narrow.is_empty() {
        return (solid, sparse);
    }
    (region.difference(&sparse), sparse)
}
