//! Whether what prints is hot.

use beadwork_gcode::{Event, Heater, Wait};

use super::CheckError;
use crate::print::{Flavour, Nozzles, Settings};

/// Temperatures have three decimals: what may be lost, in degrees Celsius.
const ROUNDING_C: f64 = 0.001;

/// What is known of a temperature, in degrees Celsius: it lies between two bounds.
#[derive(Clone, Copy, Debug, Default)]
struct Warmth {
    target: f64,
    low: f64,
    high: f64,
}

impl Warmth {
    fn set(&mut self, celsius: f64, wait: Wait, flavour: Flavour) {
        let (celsius, wait) = match (wait, flavour) {
            // Klipper does not see the word R, and takes 0 for the temperature.
            (Wait::HeatingOrCooling, Flavour::Klipper) => (0.0, Wait::No),
            (Wait::Heating, Flavour::Klipper) => (celsius, Wait::HeatingOrCooling),
            (wait, _) => (celsius, wait),
        };
        self.target = celsius;
        self.low = if wait == Wait::No { self.low.min(celsius) } else { celsius };
        self.high = if wait == Wait::HeatingOrCooling { celsius } else { self.high.max(celsius) };
    }

    fn check(&self, heater: Heater, asked_c: f64, line: usize) -> Result<(), CheckError> {
        let is = |value: f64| (value - asked_c).abs() <= ROUNDING_C;
        if !is(self.target) {
            return Err(CheckError::Temperature { line, heater, asked_c, got_c: self.target });
        }
        if is(self.low) && is(self.high) {
            Ok(())
        } else {
            Err(CheckError::NotWaited { line, heater })
        }
    }
}

/// The heaters of a printer, which is cold at the beginning, and its motors.
#[derive(Debug)]
pub(super) struct Heaters<'a> {
    settings: &'a Settings,
    /// One for each tool, or a single one.
    nozzles: Vec<Warmth>,
    bed: Warmth,
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
            nozzles: vec![Warmth::default(); count],
            bed: Warmth::default(),
            motors_off: false,
        }
    }

    fn nozzle(&mut self, tool: u8) -> Option<&mut Warmth> {
        match self.settings.printer.nozzles {
            Nozzles::Shared => self.nozzles.first_mut(),
            Nozzles::Own => self.nozzles.get_mut(usize::from(tool)),
        }
    }

    pub(super) fn take(&mut self, event: &Event) {
        let flavour = self.settings.printer.flavour;
        match *event {
            Event::Heat { heater: Heater::Bed, celsius, wait, .. } => {
                self.bed.set(celsius, wait, flavour)
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

    /// Whether a tool of the settings may extrude.
    pub(super) fn check(&mut self, tool: u8, line: usize) -> Result<(), CheckError> {
        if self.motors_off {
            return Err(CheckError::MotorsOff { line });
        }
        self.bed.check(Heater::Bed, self.settings.process.bed_c, line)?;
        let asked_c = self.settings.tools[usize::from(tool)].nozzle_c;
        self.nozzle(tool).map_or(Ok(()), |nozzle| nozzle.check(Heater::Nozzle(tool), asked_c, line))
    }
}
