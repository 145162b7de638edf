//! Checks settings and layers before they are written as a program or compared with one.

use beadwork_gcode::Feature;
use beadwork_grid::Zones;

use super::layer::Layer;
use super::process::CrossSection;
use super::settings::{Purge, Settings};
use super::settings_error::SettingsError;
use crate::{BeadLayer, Frame};

/// Upper limit of speeds, accelerations and purge volumes.
const MAX_VALUE: f64 = 1e6;

/// Upper limit of the size of a bed, in mm.
/// The filament in a cube of this size can still be written as a [`beadwork_gcode::Number`].
const MAX_BED_MM: f64 = 1e4;

/// Minimum width and height of a bead, in mm; smaller ones would be distorted by rounding to the
/// decimals of a file.
const MIN_BEAD_MM: f64 = 0.01;

/// Rounding error of positions that are given in the settings, in mm.
const ROUNDING_MM: f64 = 1e-6;

/// Checks the settings, layers of cells, and that they fit together and on the bed.
pub(super) fn validate_layers(
    layers: &[Layer<'_>],
    frame: &Frame,
    settings: &Settings,
) -> Result<(), SettingsError> {
    check_settings(settings, frame)?;
    if settings.process.cross_section == CrossSection::Oval && frame.layer_mm > frame.cell_mm {
        let &Frame { layer_mm, cell_mm, .. } = frame;
        return Err(SettingsError::HighBead { layer_mm, cell_mm });
    }
    for (field, value) in [("frame.left_mm", frame.left_mm), ("frame.back_mm", frame.back_mm)] {
        check_not_negative(field, value)?;
    }
    check_layers(layers, frame, settings)?;
    check_positions(layers.len(), frame, frame.sides_mm(), settings)
}

/// Checks the settings, layers of beads, and that they fit together and on the bed.
pub(super) fn validate_beads(
    layers: &[BeadLayer],
    frame: &Frame,
    settings: &Settings,
) -> Result<(), SettingsError> {
    check_settings(settings, frame)?;
    check_numbers(layers.iter().map(|layer| layer.number))?;
    let tools = settings.tools.len();
    let mut sides_mm = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for layer in layers {
        let number = layer.number;
        if layer.beads.is_empty() {
            return Err(SettingsError::NoBeads { layer: number });
        }
        for (index, bead) in layer.beads.iter().enumerate() {
            if usize::from(bead.tool) >= tools {
                let tool = bead.tool;
                return Err(SettingsError::BeadTool { layer: number, bead: index, tool, tools });
            }
            let field = |name| format!("layer {number}, bead {index}: {name}");
            for (step, (from, to, width_mm)) in bead.moves.iter().zip(bead.lines()) {
                if !is_part(step.feature) {
                    let feature = step.feature;
                    return Err(SettingsError::Feature { layer: number, bead: index, feature });
                }
                check_range(
                    || field("width_mm"),
                    width_mm,
                    MIN_BEAD_MM,
                    MAX_BED_MM,
                    "from 0.01 to 10000",
                )?;
                for (name, value) in [("x", from[0]), ("y", from[1]), ("x", to[0]), ("y", to[1])] {
                    check_range(|| field(name), value, -MAX_BED_MM, MAX_BED_MM, "on the bed")?;
                }
                for (axis, at) in [from[0], from[1], to[0], to[1]].into_iter().enumerate() {
                    let axis = axis % 2;
                    sides_mm[axis] = sides_mm[axis].min(at - width_mm / 2.0);
                    sides_mm[2 + axis] = sides_mm[2 + axis].max(at + width_mm / 2.0);
                }
            }
        }
    }
    check_positions(layers.len(), frame, sides_mm, settings)
}

/// Whether a feature belongs to a part.
fn is_part(feature: Feature) -> bool {
    matches!(
        feature,
        Feature::OuterWall
            | Feature::InnerWall
            | Feature::ThinWall
            | Feature::GapFill
            | Feature::Infill
            | Feature::SolidInfill
    )
}

/// Checks each number of the settings and the frame on its own.
fn check_settings(settings: &Settings, frame: &Frame) -> Result<(), SettingsError> {
    let Settings { printer, tools, process, purge } = settings;
    let [x, y, z] = printer.bed_mm;
    let positive = [
        ("printer.acceleration_mm_s2", printer.acceleration_mm_s2),
        ("printer.max_speed_mm_s", printer.max_speed_mm_s),
        ("process.retract_mm_s", process.retract_mm_s),
    ];
    let of_features = [
        ("process.outer_wall_mm_s", process.outer_wall_mm_s),
        ("process.inner_wall_mm_s", process.inner_wall_mm_s),
        ("process.infill_mm_s", process.infill_mm_s),
        ("process.solid_infill_mm_s", process.solid_infill_mm_s),
        ("process.gap_fill_mm_s", process.gap_fill_mm_s),
        ("process.small_perimeter_mm_s", process.small_perimeter_mm_s),
    ];
    let mut toolhead_speeds = vec![
        ("process.print_mm_s", process.print_mm_s),
        ("process.first_layer_mm_s", process.first_layer_mm_s),
        ("process.travel_mm_s", process.travel_mm_s),
    ];
    toolhead_speeds
        .extend(of_features.iter().filter_map(|&(field, speed)| speed.map(|speed| (field, speed))));
    let not_negative = [
        ("printer.square_corner_mm_s", printer.square_corner_mm_s),
        ("process.bed_c", process.bed_c),
        ("process.retract_mm", process.retract_mm),
        ("process.retract_beyond_mm", process.retract_beyond_mm),
        ("process.wipe_mm", process.wipe_mm),
        ("process.z_hop_mm", process.z_hop_mm),
        ("process.small_perimeter_below_mm", process.small_perimeter_below_mm),
    ];
    for (field, value) in
        [("printer.bed_mm[0]", x), ("printer.bed_mm[1]", y), ("printer.bed_mm[2]", z)]
    {
        check_range(|| field.to_owned(), value, 1.0, MAX_BED_MM, "from 1 to 10000")?;
    }
    positive
        .iter()
        .chain(&toolhead_speeds)
        .try_for_each(|&(field, value)| check_positive(field, value))?;
    not_negative.iter().try_for_each(|&(field, value)| check_not_negative(field, value))?;
    if let Some(&(field, value)) =
        toolhead_speeds.iter().find(|(_, value)| *value > printer.max_speed_mm_s)
    {
        let max_speed_mm_s = printer.max_speed_mm_s;
        return Err(SettingsError::TooFast { field, value, max_speed_mm_s });
    }
    check_range(|| "process.fan".to_owned(), process.fan, 0.0, 1.0, "from 0 to 1")?;
    for (field, value) in [("frame.cell_mm", frame.cell_mm), ("frame.layer_mm", frame.layer_mm)] {
        check_range(|| field.to_owned(), value, MIN_BEAD_MM, MAX_BED_MM, "from 0.01 to 10000")?;
    }
    for (number, tool) in tools.iter().enumerate() {
        let field = |name| format!("tools[{number}].{name}");
        check_range(|| field("filament_mm"), tool.filament_mm, 0.5, 20.0, "from 0.5 to 20")?;
        check_not_negative(&field("nozzle_c"), tool.nozzle_c)?;
        check_range(|| field("density_g_cm3"), tool.density_g_cm3, 0.0, 100.0, "from 0 to 100")?;
    }
    purge.as_ref().map_or(Ok(()), |purge| check_purge(purge, tools.len()))
}

fn check_purge(purge: &Purge, tools: usize) -> Result<(), SettingsError> {
    let rows = purge.volume_mm3.len();
    let wrong_row = purge.volume_mm3.iter().map(Vec::len).find(|&columns| columns != tools);
    if let Some(got) = wrong_row.or((rows != tools).then_some(rows)) {
        return Err(SettingsError::PurgeSize { tools, got });
    }
    for (from, row) in purge.volume_mm3.iter().enumerate() {
        for (to, &volume) in row.iter().enumerate() {
            check_not_negative(&format!("purge.volume_mm3[{from}][{to}]"), volume)?;
        }
    }
    let Some(tower) = purge.tower else { return Ok(()) };
    check_not_negative("purge.tower.left_mm", tower.left_mm)?;
    check_not_negative("purge.tower.front_mm", tower.front_mm)?;
    check_positive("purge.tower.width_mm", tower.width_mm)?;
    check_positive("purge.tower.depth_mm", tower.depth_mm)
}

fn check_positive(field: &str, value: f64) -> Result<(), SettingsError> {
    // A speed below a thousandth would be written as 0.
    check_range(
        || field.to_owned(),
        value,
        0.001,
        MAX_VALUE,
        "at least 0.001 and at most a million",
    )
}

fn check_not_negative(field: &str, value: f64) -> Result<(), SettingsError> {
    check_range(|| field.to_owned(), value, 0.0, MAX_VALUE, "at least 0 and at most a million")
}

fn check_range(
    field: impl FnOnce() -> String,
    value: f64,
    low: f64,
    high: f64,
    expected: &'static str,
) -> Result<(), SettingsError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(SettingsError::Value { field: field(), value, expected })
}

/// Checks that layers are numbered from 0 without a gap.
fn check_numbers(numbers: impl Iterator<Item = usize> + Clone) -> Result<(), SettingsError> {
    let mut pairs = numbers.clone().zip(numbers.clone().skip(1));
    if let Some((before, layer)) = pairs.find(|(before, layer)| before >= layer) {
        return Err(SettingsError::LayerOrder { layer, before });
    }
    let mut count = 0;
    for layer in numbers {
        if layer != count {
            return Err(SettingsError::Gap { layer });
        }
        count += 1;
    }
    if count == 0 { Err(SettingsError::NoLayers) } else { Ok(()) }
}

/// Checks that the layers are numbered from 0, share the grid of the frame, and have tools.
fn check_layers(
    layers: &[Layer<'_>],
    frame: &Frame,
    settings: &Settings,
) -> Result<(), SettingsError> {
    check_numbers(layers.iter().map(|layer| layer.number))?;
    for layer in layers {
        let Layer { number, region, zones, path } = *layer;
        let expected = [frame.width, frame.height];
        let mismatch =
            |what, got| Err(SettingsError::LayerSize { layer: number, what, got, expected });
        let got = [region.width(), region.height()];
        if got != expected {
            return mismatch("region", got);
        }
        if zones.ids().len() != region.grid_len()
            || region.cells().any(|cell| zones.id(cell) == Zones::OUTSIDE)
        {
            return Err(SettingsError::LayerCells { layer: number, what: "zones" });
        }
        if path.width() != region.width() {
            return mismatch("path", [path.width(), path.height()]);
        }
        // A path visits no cell twice, so these two conditions mean that it visits each cell of the
        // region.
        let visits_region = path.order().len() == region.cell_count() as usize
            && path.order().iter().all(|&cell| region.contains(cell));
        if !visits_region {
            return Err(SettingsError::LayerCells { layer: number, what: "path" });
        }
        let tools = settings.tools.len();
        let max_zone = region.cells().map(|cell| zones.id(cell)).max();
        if let Some(zone) = max_zone.filter(|&zone| usize::from(zone) >= tools) {
            return Err(SettingsError::TooFewTools { layer: number, zone, tools });
        }
    }
    Ok(())
}

/// Checks that the part, which is given by its left, front, right and back, and the prime tower lie
/// on the bed and apart from each other.
fn check_positions(
    layers: usize,
    frame: &Frame,
    [left_mm, front_mm, right_mm, back_mm]: [f64; 4],
    settings: &Settings,
) -> Result<(), SettingsError> {
    let [bed_x, bed_y, bed_z] = settings.printer.bed_mm;
    if left_mm < -ROUNDING_MM
        || front_mm < -ROUNDING_MM
        || right_mm > bed_x + ROUNDING_MM
        || back_mm > bed_y + ROUNDING_MM
    {
        return Err(SettingsError::PartOutside { left_mm, front_mm, right_mm, back_mm });
    }
    let top_mm = frame.top_mm(layers.saturating_sub(1)) + settings.process.z_hop_mm;
    if top_mm > bed_z + ROUNDING_MM {
        return Err(SettingsError::TooHigh { top_mm, limit_mm: bed_z });
    }
    let Some(tower) = settings.purge.as_ref().and_then(|purge| purge.tower) else { return Ok(()) };
    let (right, back) = (tower.left_mm + tower.width_mm, tower.front_mm + tower.depth_mm);
    if right > bed_x + ROUNDING_MM || back > bed_y + ROUNDING_MM {
        return Err(SettingsError::PrimeTowerOutside);
    }
    let is_apart = right <= left_mm + ROUNDING_MM
        || tower.left_mm >= right_mm - ROUNDING_MM
        || back <= front_mm + ROUNDING_MM
        || tower.front_mm >= back_mm - ROUNDING_MM;
    if is_apart { Ok(()) } else { Err(SettingsError::PrimeTowerOverlaps) }
}
