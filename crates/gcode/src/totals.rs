//! What a print takes: changes of tool, ways, time, filament.

use std::f64::consts::PI;

use serde::Serialize;

use crate::{Event, Feature, Limits, Program, Stopwatch, TraceError};

/// What a print takes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Totals {
    /// Layers of the part: as many as the program has comments of a layer's beginning.
    pub layers: usize,
    /// Changes from one tool to another.
    pub tool_changes: usize,
    /// Breaks between the beads of a layer, over all layers: pieces of the paths beyond the first
    /// of each layer.
    /// What changes of tool and the tower break does not count.
    pub lifts: usize,
    /// Way of the head without extruding, in mm, from its home on.
    pub travel_mm: f64,
    /// Way of the head while it prints the part, in mm.
    pub extrusion_mm: f64,
    /// Way of the head while it prints the tower, in mm.
    pub tower_mm: f64,
    /// How long it takes, in s; see [`Stopwatch`] for what that leaves out.
    pub print_seconds: f64,
    /// What each tool extrudes, one entry for each tool.
    pub tools: Vec<ToolUse>,
}

/// What a tool extrudes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ToolUse {
    /// Its number.
    pub tool: u8,
    /// Filament in mm.
    pub filament_mm: f64,
    /// Volume in mm³.
    pub volume_mm3: f64,
    /// Weight in g.
    pub grams: f64,
    /// How much of the filament goes into the tower, in mm.
    pub purge_mm: f64,
}

/// The filament of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filament {
    /// Diameter in mm.
    pub diameter_mm: f64,
    /// Density in g/cm³.
    pub density_g_cm3: f64,
}

impl Filament {
    /// Cross-section in mm².
    pub fn area_mm2(&self) -> f64 {
        PI * self.diameter_mm * self.diameter_mm / 4.0
    }
}

impl Totals {
    /// Adds up the motions of a program, whose tools have these filaments and which a machine with
    /// these limits runs.
    /// [`Totals::layers`] and [`Totals::lifts`] stay 0: only the planner of a print knows them.
    ///
    /// Linear in the lines; the error is that of the first line that cannot be followed.
    pub fn measure(
        program: &Program,
        limits: Limits,
        filaments: &[Filament],
    ) -> Result<Self, TraceError> {
        let tools =
            (0..filaments.len()).map(|tool| ToolUse { tool: tool as u8, ..ToolUse::default() });
        let mut totals = Self { tools: tools.collect(), ..Self::default() };
        let mut watch = Stopwatch::new(limits);
        for event in program.trace() {
            let event = event?;
            watch.take(&event);
            match event {
                Event::Motion(motion) if motion.is_stroke() => {
                    let in_tower = motion.feature == Feature::PrimeTower;
                    let way =
                        if in_tower { &mut totals.tower_mm } else { &mut totals.extrusion_mm };
                    *way += motion.length_mm();
                    if let Some(tool) = totals.tools.get_mut(usize::from(motion.tool)) {
                        tool.filament_mm += motion.extruded_mm;
                        tool.purge_mm += if in_tower { motion.extruded_mm } else { 0.0 };
                    }
                }
                Event::Motion(motion) => totals.travel_mm += motion.length_mm(),
                Event::ToolChange { from, .. } => {
                    totals.tool_changes += usize::from(from.is_some())
                }
                _ => {}
            }
        }
        totals.print_seconds = watch.seconds();
        for (tool, filament) in totals.tools.iter_mut().zip(filaments) {
            tool.volume_mm3 = tool.filament_mm * filament.area_mm2();
            // 1000 mm³ are one cm³.
            tool.grams = tool.volume_mm3 / 1000.0 * filament.density_g_cm3;
        }
        Ok(totals)
    }
}
