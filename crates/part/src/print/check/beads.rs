//! Checks which beads are printed, in which order, and whether they stay within the outlines.

use beadwork_base::Control;
use beadwork_gcode::{Feature, Motion, Program};

use super::checker::{Part, check_program};
use super::edge_index::EdgeIndex;
use super::error::CheckError;
use super::fill::{FillTracker, LayerFill, ToolFill};
use super::planned::{PlannedMotion, distance_mm, planned_motions};
use super::rates;
use crate::print::settings::Settings;
use crate::print::settings_error::SettingsError;
use crate::print::validate::validate_beads;
use crate::{Area, BeadLayer, Frame};

/// Deviation of a position in mm: both the program and the planned positions are rounded to the
/// same decimals, so only the conversion to binary numbers causes one.
const POSITION_MM: f64 = 1e-4;

/// Deviation of the filament of a tool in mm at any time: half of the last decimal, plus the
/// rounding of sums.
const SURPLUS_MM: f64 = 6e-6;

/// Distance in mm by which a bead may leave an outline due to the rounding of positions.
const OUTSIDE_MM: f64 = 0.002;

/// What a program of beads may do.
///
/// Construct it with `..BeadLimits::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeadLimits {
    /// Share of its width by which a bead may leave the outline of its material, from 0 to 0.5.
    pub outside: f64,
    /// The same for thin walls and gap fill, from 0 to 0.5: with 0.5, their centrelines must lie
    /// within the outline, but not their ends.
    pub outside_skeleton: f64,
    /// Minimum and maximum ratio of the extruded area to that of the outline, for each material in
    /// each layer; `None` for no limit.
    pub layer_fill: Option<[f64; 2]>,
    /// The same for each material in all layers together.
    pub total_fill: Option<[f64; 2]>,
}

impl Default for BeadLimits {
    /// Beads may leave the outlines by 5 % of their width; any fill is accepted.
    fn default() -> Self {
        Self { outside: 0.05, outside_skeleton: 0.05, layer_fill: None, total_fill: None }
    }
}

/// Totals of a checked print of beads.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BeadReport {
    /// Number of layers of the part.
    pub layers: usize,
    /// Number of printed beads in all layers.
    pub beads: usize,
    /// Number of beads that are too short to be printed; see
    /// [`Print::of_beads`](crate::print::Print::of_beads).
    pub dropped_beads: usize,
    /// Number of motions that extrude into the part.
    pub motions: usize,
    /// Volume of the part, in mm³.
    pub part_mm3: f64,
    /// Volume of the prime tower, in mm³.
    pub prime_tower_mm3: f64,
    /// Number of changes from one tool to another.
    pub tool_changes: usize,
    /// Extruded area and area of the outlines, for each tool.
    pub fill: Vec<ToolFill>,
    /// The material in a layer with the lowest ratio of extruded area to outline; `None` without
    /// outlines.
    pub lowest_fill: Option<LayerFill>,
    /// The one with the highest ratio.
    pub highest_fill: Option<LayerFill>,
}

/// Checks that a program prints these layers of beads within their outlines, and nothing else
/// besides the prime tower.
///
/// `outlines` are, for each layer, the areas of the materials, each given with its tool.
/// The layers must be numbered from 0 without a gap.
///
/// - The motions that extrude into the part are the moves of the beads in order, each once, with
///   the tool of its bead, marked with its feature, and not faster than the settings allow.
///   Positions are those of the moves, rounded to 0.001 mm.
///   Moves that are too short are merged as [`Print::of_beads`] states.
///   At no time does the filament of a tool differ from the volume of the moves by more than
///   rounding.
/// - Each motion, as wide as its move, stays within the outline of its material, except for a share
///   of its width ([`BeadLimits`]) and 0.002 mm.
///   Round ends count as part of the bead: all of its centreline keeps the distance.
/// - The ratios of extruded area to outlines are within the limits.
/// - Everything else is as for cells, see [`check`](super::check): layers, prime tower and purging,
///   height of the nozzle, retraction, extrusion modes, temperatures.
///   Filament is retracted in place, or back along the bead just printed, by at most
///   [`Process::wipe_mm`].
///
/// Not checked are the travel speed, the speed of retraction, speeds below the maximum,
/// accelerations, the fan, the shape of the prime tower, travel across the layer that is being
/// printed, and comments other than those of features.
/// Commands that the trace does not follow, such as macros, `G10`, `G11` and `M221`, do not count
/// ([`Program::unknown_commands`]).
///
/// Progress counts layers.
/// Takes time about linear in the motions and the edges of the outlines.
///
/// [`Print::of_beads`]: crate::print::Print::of_beads
/// [`Process::wipe_mm`]: crate::print::Process::wipe_mm
pub fn check_beads(
    program: &Program,
    layers: &[BeadLayer],
    outlines: &[Vec<(u8, Area)>],
    frame: &Frame,
    settings: &Settings,
    limits: &BeadLimits,
    control: &Control<'_>,
) -> Result<BeadReport, CheckError> {
    validate_beads(layers, frame, settings)?;
    check_limits(limits)?;
    if outlines.len() != layers.len() {
        let (expected, got) = (layers.len(), outlines.len());
        return Err(CheckError::OutlineLayers { expected, got });
    }
    let mut tracker = BeadTracker {
        layers,
        outlines,
        frame,
        settings,
        limits,
        control,
        current: 0,
        planned: Vec::new(),
        printed: 0,
        indices: Vec::new(),
        inside: None,
        surplus_mm: vec![0.0; settings.tools.len()],
        fill: FillTracker::new(settings.tools.len(), limits.layer_fill, limits.total_fill),
        beads: 0,
        dropped_beads: 0,
        motions: 0,
    };
    tracker.begin_layer()?;
    let totals = check_program(program, &mut tracker, frame, settings, control)?;
    let [lowest_fill, highest_fill] = tracker.fill.extremes();
    Ok(BeadReport {
        layers: layers.len(),
        beads: tracker.beads,
        dropped_beads: tracker.dropped_beads,
        motions: tracker.motions,
        part_mm3: totals.part_mm3,
        prime_tower_mm3: totals.prime_tower_mm3,
        tool_changes: totals.tool_changes,
        fill: tracker.fill.totals().to_vec(),
        lowest_fill,
        highest_fill,
    })
}

fn check_limits(limits: &BeadLimits) -> Result<(), SettingsError> {
    for (field, value) in
        [("outside", limits.outside), ("outside_skeleton", limits.outside_skeleton)]
    {
        if !(0.0..=0.5).contains(&value) {
            let field = format!("limits.{field}");
            return Err(SettingsError::Value { field, value, expected: "from 0 to 0.5" });
        }
    }
    Ok(())
}

/// Tracks which beads of the part were printed.
struct BeadTracker<'a> {
    layers: &'a [BeadLayer],
    outlines: &'a [Vec<(u8, Area)>],
    frame: &'a Frame,
    settings: &'a Settings,
    limits: &'a BeadLimits,
    control: &'a Control<'a>,
    /// Number of the layer that is being printed.
    current: usize,
    /// The motions of this layer.
    planned: Vec<PlannedMotion>,
    /// Number of its motions that were printed.
    printed: usize,
    /// The outlines of this layer, by tool.
    indices: Vec<(u8, EdgeIndex)>,
    /// A position that lies inside the outline of a tool: the end of the last motion.
    inside: Option<(u8, [f64; 2])>,
    /// For each tool, the filament that went into the part beyond that of the planned motions, in
    /// mm.
    surplus_mm: Vec<f64>,
    fill: FillTracker,
    /// Counts of the layers begun.
    beads: usize,
    dropped_beads: usize,
    motions: usize,
}

impl BeadTracker<'_> {
    /// Prepares the motions and the outlines of the current layer.
    fn begin_layer(&mut self) -> Result<(), CheckError> {
        self.control.check()?;
        let layer = &self.layers[self.current];
        let (planned, dropped) = planned_motions(layer, self.frame, self.settings);
        self.beads += layer.beads.len() - dropped;
        self.dropped_beads += dropped;
        self.motions += planned.len();
        self.planned = planned;
        self.printed = 0;
        self.inside = None;
        self.indices.clear();
        for (tool, area) in &self.outlines[self.current] {
            if self.indices.iter().any(|(other, _)| other == tool) {
                return Err(CheckError::TwoOutlines { layer: self.current, tool: *tool });
            }
            self.indices.push((*tool, EdgeIndex::new(area)));
        }
        Ok(())
    }

    /// Ends the current layer; an error if a motion is missing.
    fn complete_layer(&mut self) -> Result<(), CheckError> {
        let layer = self.current;
        if let Some(missing) = self.planned.get(self.printed) {
            let PlannedMotion { bead, to_mm, .. } = *missing;
            return Err(CheckError::MissingBead { layer, bead, to_mm });
        }
        self.fill.end_layer(layer, &self.outlines[layer])?;
        self.current += 1;
        self.control.report(self.current, self.layers.len());
        if self.current < self.layers.len() { self.begin_layer() } else { Ok(()) }
    }

    /// Checks that a motion is a planned one.
    fn check_planned(
        &mut self,
        motion: &Motion,
        planned: &PlannedMotion,
    ) -> Result<(), CheckError> {
        let (line, layer, bead) = (motion.line, self.current, planned.bead);
        let [from_mm, to_mm] = ends(motion);
        if distance_mm(from_mm, planned.from_mm) > POSITION_MM
            || distance_mm(to_mm, planned.to_mm) > POSITION_MM
        {
            let expected_mm = [planned.from_mm, planned.to_mm];
            let got_mm = [from_mm, to_mm];
            return Err(CheckError::OffBead { line, layer, bead, expected_mm, got_mm });
        }
        let (expected, got) = (planned.tool, motion.tool);
        if expected != got {
            return Err(CheckError::BeadTool { line, layer, bead, expected, got });
        }
        // Some features share a name.
        let (expected, got) = (Feature::from_name(planned.feature.name()), motion.feature);
        if expected != got {
            return Err(CheckError::BeadFeature { line, layer, bead, expected, got });
        }
        rates::check_speed(motion, planned.max_mm_s)?;
        let surplus_mm = &mut self.surplus_mm[usize::from(planned.tool)];
        *surplus_mm += motion.extruded_mm - planned.filament_mm;
        if surplus_mm.abs() > SURPLUS_MM {
            let filament_mm2 = self.settings.tools[usize::from(planned.tool)].filament_mm2();
            let expected_mm3 = planned.filament_mm * filament_mm2;
            let got_mm3 = motion.extruded_mm * filament_mm2;
            return Err(CheckError::Volume { line, expected_mm3, got_mm3 });
        }
        Ok(())
    }

    /// Checks that a motion stays within the outline of its material.
    fn check_outline(
        &mut self,
        motion: &Motion,
        planned: &PlannedMotion,
    ) -> Result<(), CheckError> {
        let PlannedMotion { bead, tool, width_mm, .. } = *planned;
        let [from_mm, to_mm] = ends(motion);
        let outside = match planned.feature {
            Feature::ThinWall | Feature::GapFill => self.limits.outside_skeleton,
            _ => self.limits.outside,
        };
        let needed_mm = ((0.5 - outside) * width_mm - OUTSIDE_MM).max(0.0);
        let index = self.indices.iter().find(|(other, _)| *other == tool).map(|(_, index)| index);
        // A line that touches no edge ends on the side where it begins.
        let is_inside = index.is_some_and(|index| {
            (self.inside == Some((tool, from_mm)) || index.contains(from_mm))
                && index.is_clear(from_mm, to_mm, needed_mm)
        });
        if !is_inside {
            let (line, layer) = (motion.line, self.current);
            return Err(CheckError::OutsideOutline {
                line,
                layer,
                bead,
                tool,
                width_mm,
                from_mm,
                to_mm,
            });
        }
        self.inside = Some((tool, to_mm));
        Ok(())
    }
}

impl Part for BeadTracker<'_> {
    fn layers(&self) -> usize {
        self.layers.len()
    }

    fn motion(&mut self, motion: &Motion, layer: usize) -> Result<(), CheckError> {
        while self.current < layer {
            self.complete_layer()?;
        }
        let Some(&planned) = self.planned.get(self.printed) else {
            let [from_mm, to_mm] = ends(motion);
            return Err(CheckError::AfterBeads { line: motion.line, layer, from_mm, to_mm });
        };
        self.check_planned(motion, &planned)?;
        self.check_outline(motion, &planned)?;
        self.printed += 1;
        self.fill.add(planned.tool, planned.area_mm2);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), CheckError> {
        while self.current < self.layers.len() {
            self.complete_layer()?;
        }
        self.fill.finish()
    }
}

/// x and y of both ends of a motion, in mm.
fn ends(motion: &Motion) -> [[f64; 2]; 2] {
    [motion.from_mm, motion.to_mm].map(|[x, y, _]| [x, y])
}
