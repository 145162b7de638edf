//! Sums over a whole program: tool changes, distances, time, filament.

use std::f64::consts::PI;

use beadwork_base::Control;
use serde::Serialize;

use crate::event::{Event, TraceError};
use crate::feature::Feature;
use crate::program::Program;
use crate::time::{MotionLimits, Stopwatch};

/// Sums over a whole print.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Totals {
    /// Number of layers of the part.
    pub layers: usize,
    /// Changes from one tool to another.
    pub tool_changes: usize,
    /// Printhead lifts, over all layers: breaks between two beads of a layer, each followed by a
    /// travel move.
    /// Breaks that are due to a tool change or the prime tower do not count.
    pub lifts: usize,
    /// Distance that the nozzle moves without extruding, in mm, from its home position on.
    pub travel_mm: f64,
    /// Distance that the nozzle moves while it prints the part, in mm.
    pub extrusion_mm: f64,
    /// Distance that the nozzle moves while it prints the prime tower, in mm.
    #[serde(rename = "tower_mm")]
    pub prime_tower_mm: f64,
    /// Printing time in s, as computed by a [`Stopwatch`].
    pub print_seconds: f64,
    /// One entry per tool, in order.
    pub tools: Vec<ToolUse>,
}

/// What a tool extrudes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ToolUse {
    /// Number of the tool.
    pub tool: u8,
    /// Length of filament in mm.
    pub filament_mm: f64,
    /// Volume in mm³.
    pub volume_mm3: f64,
    /// Weight in g.
    pub grams: f64,
    /// Length of the filament that goes into the prime tower, in mm.
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
    /// Area of the cross-section in mm².
    pub fn area_mm2(&self) -> f64 {
        PI * self.diameter_mm * self.diameter_mm / 4.0
    }
}

impl Totals {
    /// Sums up a program for a printer with these limits, whose tools have these filaments, one per
    /// tool.
    /// Filament of tools beyond the last one is not counted.
    ///
    /// [`Totals::layers`] and [`Totals::lifts`] stay 0: only the planner of the print knows them.
    ///
    /// Linear in lines and chords of arcs.
    /// Progress counts lines.
    pub fn measure(
        program: &Program,
        limits: MotionLimits,
        filaments: &[Filament],
        control: &Control<'_>,
    ) -> Result<Self, TraceError> {
        let tools =
            (0..filaments.len()).map(|tool| ToolUse { tool: tool as u8, ..ToolUse::default() });
        let mut totals = Self { tools: tools.collect(), ..Self::default() };
        let mut stopwatch = Stopwatch::new(limits);
        program.for_each_event(control, |event| {
            stopwatch.add(event);
            totals.add(event);
        })?;
        totals.print_seconds = stopwatch.seconds();
        for (tool, filament) in totals.tools.iter_mut().zip(filaments) {
            tool.volume_mm3 = tool.filament_mm * filament.area_mm2();
            tool.grams = tool.volume_mm3 / MM3_PER_CM3 * filament.density_g_cm3;
        }
        Ok(totals)
    }

    /// Adds everything about an event except its time.
    fn add(&mut self, event: &Event) {
        match event {
            Event::Motion(motion) if motion.is_extrusion() => {
                let in_tower = motion.feature == Feature::PrimeTower;
                let sum = if in_tower { &mut self.prime_tower_mm } else { &mut self.extrusion_mm };
                *sum += motion.length_mm();
                if let Some(tool) = self.tools.get_mut(usize::from(motion.tool)) {
                    tool.filament_mm += motion.extruded_mm;
                    tool.purge_mm += if in_tower { motion.extruded_mm } else { 0.0 };
                }
            }
            Event::Motion(motion) => self.travel_mm += motion.length_mm(),
            Event::ToolChange { from, .. } => self.tool_changes += usize::from(from.is_some()),
            _ => {}
        }
    }
}

const MM3_PER_CM3: f64 = 1000.0;
