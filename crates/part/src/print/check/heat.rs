//! Checks that bed and nozzles are hot when something is printed.
//!
//! A program sets target temperatures and may wait for them; the actual temperature is not known.
//! So the check tracks an interval that contains the temperature of each heater: setting a target
//! without waiting extends the interval to the target, and waiting shrinks it.

use beadwork_gcode::{Event, Heater, Wait};

use super::error::CheckError;
use super::tolerance;
use crate::print::settings::{Flavour, Nozzles, Settings};

/// Target of a heater and an interval that contains its temperature, in °C.
/// A bound of 0 stands for room temperature.
#[derive(Clone, Copy, Debug, Default)]
struct Temperature {
    target: f64,
    low: f64,
    high: f64,
}

impl Temperature {
    fn set(&mut self, celsius: f64, wait: Wait, flavour: Flavour) {
        let (celsius, wait) = match (wait, flavour) {
            // Klipper ignores the parameter R of `M109` and sets the heater to 0.
            (Wait::HeatingOrCooling, Flavour::Klipper) => (0.0, Wait::No),
            // After `M109 S`, Marlin waits only while the nozzle heats up, Klipper also while it
            // cools down.
            (Wait::Heating, Flavour::Klipper) => (celsius, Wait::HeatingOrCooling),
            (wait, _) => (celsius, wait),
        };
        self.target = celsius;
        self.low = if wait == Wait::No { self.low.min(celsius) } else { celsius };
        self.high = if wait == Wait::HeatingOrCooling { celsius } else { self.high.max(celsius) };
    }

    fn check(&self, heater: Heater, expected_c: f64, line: usize) -> Result<(), CheckError> {
        let is = |value: f64| (value - expected_c).abs() <= tolerance::TEMPERATURE_C;
        if !is(self.target) {
            return Err(CheckError::Temperature { line, heater, expected_c, got_c: self.target });
        }
        if is(self.low) && is(self.high) {
            Ok(())
        } else {
            Err(CheckError::NotWaited { line, heater })
        }
    }
}

/// The heaters of a printer, which are cold at the start, and its motors.
#[derive(Debug)]
pub(super) struct Heaters<'a> {
    settings: &'a Settings,
    /// One for each tool, or a single one if it is shared.
    nozzles: Vec<Temperature>,
    bed: Temperature,
    motors_off: bool,
}

impl<'a> Heaters<'a> {
    pub(super) fn new(settings: &'a Settings) -> Self {
        let count = match settings.printer.nozzles {
            Nozzles::Shared => 1,
            Nozzles::Own => settings.tools.len(),
        };
        Self {
            settings,
            nozzles: vec![Temperature::default(); count],
            bed: Temperature::default(),
            motors_off: false,
        }
    }

    fn nozzle(&mut self, tool: u8) -> Option<&mut Temperature> {
        match self.settings.printer.nozzles {
            Nozzles::Shared => self.nozzles.first_mut(),
            Nozzles::Own => self.nozzles.get_mut(usize::from(tool)),
        }
    }

    pub(super) fn event(&mut self, event: &Event) {
        let flavour = self.settings.printer.flavour;
        match *event {
            Event::Heat { heater: Heater::Bed, celsius, wait, .. } => {
                self.bed.set(celsius, wait, flavour);
            }
            Event::Heat { heater: Heater::Nozzle(tool), celsius, wait, .. } => {
                if let Some(nozzle) = self.nozzle(tool) {
                    nozzle.set(celsius, wait, flavour);
                }
            }
            Event::HeatersOff { .. } => {
                for heater in self.nozzles.iter_mut().chain([&mut self.bed]) {
                    heater.set(0.0, Wait::No, flavour);
                }
            }
            Event::MotorsOff { .. } => self.motors_off = true,
            _ => {}
        }
    }

    /// Checks that a tool may extrude: motors on, bed and nozzle at their temperatures.
    ///
    /// # Panics
    /// If the settings do not define the tool.
    pub(super) fn check(&mut self, tool: u8, line: usize) -> Result<(), CheckError> {
        if self.motors_off {
            return Err(CheckError::MotorsOff { line });
        }
        self.bed.check(Heater::Bed, self.settings.process.bed_c, line)?;
        let expected_c = self.settings.tools[usize::from(tool)].nozzle_c;
        self.nozzle(tool)
            .map_or(Ok(()), |nozzle| nozzle.check(Heater::Nozzle(tool), expected_c, line))
    }
}
