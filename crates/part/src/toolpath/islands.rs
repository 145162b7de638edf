//! Islands of all layers.

use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{Control, Interrupted};

use super::infill;
use super::insets::Walls;
use super::island::Island;
use super::settings::{Settings, ToolpathError};
use super::skeleton::{Skeleton, SkeletonSettings, skeletons};
use super::solid::{Near, Surfaces, coarse, divide};
use crate::area::Area;
use crate::slice::LayerAreas;

/// Width and length, in beads, below which skeletons are dropped: 0.2 mm of 0.5 mm, and a margin.
const MIN_SKELETON: f64 = 0.38;

/// Maximum width of skeletons in beads: insets reach wider places.
const MAX_SKELETON: f64 = 1.6;

/// Length in beads, and size in squares of a bead, below which skeletons in islands with insets are
/// dropped: to start and end such a bead costs more than it adds.
const MIN_GAP_LENGTH: f64 = 2.0;
const MIN_GAP_SIZE: f64 = 1.0;

/// Lays out the insets, the skeletons and the infill of every layer.
///
/// The islands of a layer are in the order of their materials.
/// Layers without areas have no islands.
/// The result does not depend on the number of threads.
/// Progress counts layers.
///
/// O(n log n) in the corners of each layer's outlines, times the number of insets; and in the
/// infill lines.
///
/// # Errors
/// [`ToolpathError::Range`] if a setting is out of range, [`ToolpathError::Size`] if a layer is
/// longer than [`Settings::MAX_BEADS`] beads.
pub fn islands(
    layers: &[LayerAreas],
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Vec<Vec<Island>>, ToolpathError> {
    settings.check()?;
    check_sizes(layers, settings)?;
    let threads = control.threads;
    let surfaces = if settings.density < 1.0 {
        let unions = threads.map(layers, |layer| coarse(&layer.union(), settings));
        let surfaces = threads.map_numbers(layers.len(), |number| {
            control.check()?;
            let below = number.checked_sub(1).map(|below| &unions[below]);
            Ok(Surfaces::new(&unions[number], below, unions.get(number + 1)))
        });
        surfaces.into_iter().collect::<Result<Vec<_>, Interrupted>>()?
    } else {
        vec![Surfaces::default(); layers.len()]
    };
    let done = AtomicUsize::new(0);
    let layer = |number: usize| {
        control.check()?;
        let near = Near::new(&surfaces, number, settings);
        let mut islands = Vec::new();
        for each in &layers[number].areas {
            for outline in each.area.clone().into_components() {
                islands.push(island(each.material, outline, &near, settings, number));
            }
        }
        control.report(done.fetch_add(1, Ordering::Relaxed) + 1, layers.len());
        Ok(islands)
    };
    Ok(threads.map_numbers(layers.len(), layer).into_iter().collect::<Result<_, Interrupted>>()?)
}

fn island(
    material: u8,
    outline: Area,
    near: &Near<'_>,
    settings: &Settings,
    layer: usize,
) -> Island {
    let Walls { insets, thin, gaps, infill, inside } = Walls::new(&outline, settings);
    let mut skeletons = Vec::new();
    if settings.thin_walls {
        skeletons.extend(beads_along(&thin, insets.is_empty(), settings));
    }
    if settings.gap_fill {
        skeletons.extend(beads_along(&gaps, insets.is_empty(), settings));
    }
    let mut residue = thin;
    residue.append(gaps);
    let (solid, sparse) = divide(infill, &inside, near, settings);
    let mut infill = Vec::new();
    if !solid.is_empty() {
        infill.push(infill::solid(solid, settings, layer));
    }
    if !sparse.is_empty() {
        infill.push(infill::sparse(sparse, settings, layer));
    }
    Island { material, outline, insets, residue, skeletons, infill }
}

/// The skeletons of residue, without those that are too short next to insets.
fn beads_along(residue: &Area, is_alone: bool, settings: &Settings) -> Vec<Skeleton> {
    let bead_mm = settings.bead_mm;
    let skeleton_settings = SkeletonSettings {
        min_width_mm: MIN_SKELETON * bead_mm,
        max_width_mm: MAX_SKELETON * bead_mm,
        min_length_mm: MIN_SKELETON * bead_mm,
        ..SkeletonSettings::default()
    };
    let mut found = skeletons(residue, &skeleton_settings);
    found.retain(|skeleton| {
        is_alone
            || skeleton.length_mm() >= MIN_GAP_LENGTH * bead_mm
                && skeleton.area_mm2() >= MIN_GAP_SIZE * bead_mm * bead_mm
    });
    found
}

/// Returns an error if lines would be too many to hold.
fn check_sizes(layers: &[LayerAreas], settings: &Settings) -> Result<(), ToolpathError> {
    let bead_mm = settings.bead_mm;
    for (layer, areas) in layers.iter().enumerate() {
        for [min, max] in areas.areas.iter().filter_map(|each| each.area.bounds()) {
            let side_mm = (max[0] - min[0]).max(max[1] - min[1]);
            if side_mm > bead_mm * f64::from(Settings::MAX_BEADS) {
                return Err(ToolpathError::Size { layer, side_mm, bead_mm });
            }
        }
    }
    Ok(())
}
