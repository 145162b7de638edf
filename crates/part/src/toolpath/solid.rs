//! Solid layers: which parts of an infill region lie near the top or bottom of the part.

use super::insets::mean_width_mm;
use super::settings::Settings;
use crate::area::{Area, Ring};
use crate::measure::{Bounds, bounds, overlap, ring_size_mm2};

/// Size in mm² below which a piece of a surface is dropped: a disc of 0.1 mm does not fit into it.
const SLIVER_MM2: f64 = 0.0078;

/// Tolerance, in beads, of outlines that are compared with those of the next layer.
const TOLERANCE: f64 = 0.02;

/// Size, in squares of a bead, below which solid pieces within a larger region become sparse, and
/// sparse pieces solid.
const MIN_SIZE: f64 = 16.0;

/// Half the width, in beads, below which solid pieces are dropped.
const MIN_HALF_WIDTH: f64 = 0.45;

/// Mean width, in beads, below which sparse pieces stay empty beside solid ones.
const MIN_SPARSE: f64 = 0.5;

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

/// The surfaces within as many layers of a layer as have to be solid.
pub(super) struct Near<'a>(Vec<(Bounds, &'a Vec<Ring>)>);

impl<'a> Near<'a> {
    /// The surfaces near a layer.
    ///
    /// A point lies below fewer layers of the part than required if, at that point, one of these
    /// layers has a top surface; so surfaces need to be compared with the next layer only.
    pub(super) fn new(surfaces: &'a [Surfaces], layer: usize, settings: &Settings) -> Self {
        let above = surfaces[layer..].iter().take(settings.top_layers as usize);
        let below = surfaces[..=layer].iter().rev().take(settings.bottom_layers as usize);
        let tops = above.map(|surfaces| &surfaces.top);
        let bottoms = below.map(|surfaces| &surfaces.bottom);
        let components = tops.chain(bottoms).flat_map(Area::components);
        Self(components.filter_map(|rings| Some((bounds(&rings[0])?, rings))).collect())
    }

    /// The centres of discs, nearly a bead wide, that have to be solid, within an area.
    ///
    /// Most surfaces are slivers along the outline, which discs within the area do not reach.
    fn discs(&self, inside: &Area, settings: &Settings) -> Area {
        let Some(inner) = inside.bounds() else { return Area::default() };
        let near = self.0.iter().filter(|(outer, _)| overlap(*outer, inner, 0.0));
        let near: Vec<_> = near.map(|(_, rings)| *rings).collect();
        offset(&inside.union_of_meeting(&near), -MIN_HALF_WIDTH, settings)
    }
}

/// The area offset by a number of beads, to within the tolerance.
fn offset(area: &Area, beads: f64, settings: &Settings) -> Area {
    let tolerance_mm = TOLERANCE * settings.bead_mm;
    area.simplified(tolerance_mm).offset_within(beads * settings.bead_mm, tolerance_mm)
}

/// Divides an infill region into solid and sparse, one bead apart except for the overlap of infill.
///
/// With a common border, beads that are linked along it on both sides would lie over one another.
/// `inside` is the area between the innermost insets, around the region.
/// Solid pieces grow, so that they are anchored in their surroundings.
/// Small solid pieces within larger ones become sparse; sparse pieces that are small or narrow
/// become solid.
pub(super) fn divide(
    region: Area,
    inside: &Area,
    near: &Near<'_>,
    settings: &Settings,
) -> (Area, Area) {
    if settings.density >= 1.0 {
        return (region, Area::default());
    }
    let is_large = |rings: &[Ring]| {
        let mm2: f64 = rings.iter().map(|ring| ring_size_mm2(ring)).sum();
        // Without sparse infill, small pieces stay empty like large ones.
        settings.density == 0.0 || mm2 >= MIN_SIZE * settings.bead_mm * settings.bead_mm
    };
    let (region, small) = region.split(is_large);
    let near = near.discs(inside, settings).intersection(&region).without_slivers(SLIVER_MM2);
    let solid = offset(&near, MIN_HALF_WIDTH + ANCHOR, settings).intersection(&region);
    let (mut solid, _) = solid.split(is_large);
    let mut sparse = region;
    if !solid.is_empty() {
        // Sparse pieces that are too narrow become solid.
        let is_wide = |rings: &[Ring]| mean_width_mm(rings) >= settings.bead_mm && is_large(rings);
        let region = sparse;
        let narrow;
        (sparse, narrow) = region.difference(&solid).split(is_wide);
        if sparse.is_empty() {
            solid = region;
        } else if !narrow.is_empty() {
            solid = region.difference(&sparse);
        }
    }
    solid.append(small);
    if !solid.is_empty() && !sparse.is_empty() {
        let apart = offset(&solid, 1.0 - settings.infill_overlap, settings);
        let is_wide = |rings: &[Ring]| mean_width_mm(rings) >= MIN_SPARSE * settings.bead_mm;
        (sparse, _) = sparse.difference(&apart).split(is_wide);
    }
    (solid, sparse)
}
