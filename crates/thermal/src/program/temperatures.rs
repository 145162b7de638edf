//! The temperatures at which a program prints.

use std::collections::BTreeMap;

use beadwork_base::Control;
use beadwork_gcode::{Event, Heater, Program, TraceError};

use super::heights::Heights;
use super::poll::Poll;

/// A temperature at which beads of the part are printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureShare {
    /// In °C; 0 for a heater that is off.
    pub celsius: f64,
    /// Share of the length of all beads whose temperature is known, 0 to 1.
    pub share: f64,
}

/// The temperatures at which a program prints the part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgramTemperatures {
    /// Of the nozzle that prints, the most common one first; empty if the program sets none.
    pub nozzle: Vec<TemperatureShare>,
    /// Of the build plate, the most common one first; empty if the program sets none.
    pub plate: Vec<TemperatureShare>,
}

/// Finds the temperatures that are set while a program prints the part.
///
/// The temperature of a bead is that of the tool that prints it: one that is preheated, on standby,
/// or used for a prime line before the first layer does not count.
/// A tool whose temperature is never set has that of the last tool that was heated while it was
/// selected: both print with the same nozzle.
///
/// Linear in the program's length; reports no progress.
pub fn program_temperatures(
    program: &Program,
    control: &Control<'_>,
) -> Result<ProgramTemperatures, TraceError> {
    let heights = Heights::of(program, control)?;
    let control = Control { progress: None, ..*control };
    let mut poll = Poll::new(&control, 0, program.lines.len());
    let mut by_tool = [None; 1 << 8];
    let (mut shared, mut plate) = (None, None);
    let mut selected = 0;
    let (mut nozzles, mut plates) = (Lengths::default(), Lengths::default());
    for event in program.trace() {
        let event = event?;
        poll.count(&event)?;
        match event {
            Event::Heat { heater: Heater::Nozzle(tool), celsius, .. } if celsius > 0.0 => {
                by_tool[usize::from(tool)] = Some(celsius);
                if tool == selected {
                    shared = Some(celsius);
                }
            }
            Event::Heat { heater: Heater::Bed, celsius, .. } => plate = Some(celsius.max(0.0)),
            Event::HeatersOff { .. } => plate = plate.and(Some(0.0)),
            Event::ToolChange { to, .. } => selected = to,
            Event::Motion(motion) if heights.is_part(&motion) => {
                let length_mm = motion.length_mm();
                nozzles.add(by_tool[usize::from(motion.tool)].or(shared), length_mm);
                plates.add(plate, length_mm);
            }
            _ => {}
        }
    }
    Ok(ProgramTemperatures { nozzle: nozzles.shares(), plate: plates.shares() })
}

/// Lengths of beads by temperature in millikelvins, in mm.
#[derive(Default)]
struct Lengths(BTreeMap<i64, (f64, f64)>);

impl Lengths {
    fn add(&mut self, celsius: Option<f64>, length_mm: f64) {
        if let Some(celsius) = celsius {
            self.0.entry((celsius * 1e3).round() as i64).or_insert((celsius, 0.0)).1 += length_mm;
        }
    }

    fn shares(self) -> Vec<TemperatureShare> {
        let total: f64 = self.0.values().map(|(_, length_mm)| length_mm).sum();
        let share = |(celsius, length_mm)| TemperatureShare { celsius, share: length_mm / total };
        let mut shares: Vec<_> = self.0.into_values().map(share).collect();
        shares.sort_by(|a, b| b.share.total_cmp(&a.share));
        shares
    }
}

#[cfg(test)]
mod tests;
