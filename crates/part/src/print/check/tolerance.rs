//! Tolerances of the check: the errors that rounding to the decimals of a file causes.

/// Positions have three decimals: error of each coordinate, in mm.
pub(super) const POSITION_MM: f64 = 0.001;

/// Filament has five decimals: error of a motion, in mm, including what was carried over from the
/// motion before.
pub(super) const FILAMENT_MM: f64 = 2e-5;

/// Speeds have three decimals in mm/min: error in mm/s.
pub(super) const SPEED_MM_S: f64 = 1e-4;

/// Temperatures have three decimals: error in °C.
pub(super) const TEMPERATURE_C: f64 = 0.001;

/// Relative error of the volume of a motion.
pub(super) const VOLUME: f64 = 0.01;

/// Relative error of a purge volume, which many rounded motions add up to.
pub(super) const PURGE: f64 = 0.001;
