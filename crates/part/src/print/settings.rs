//! Settings of a print: printer, tools, process, and purging at tool changes.

use beadwork_base::named_enum;
use beadwork_gcode::{Filament, MotionLimits};
use serde::Deserialize;

use super::process::Process;

/// Everything that a print depends on, except the planned layers and their frame.
///
/// Profiles are these structures in TOML; the field names are the keys.
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The machine.
    pub printer: Printer,
    /// The tools by number; a zone is printed with the tool of the same number.
    pub tools: Vec<Tool>,
    /// Speeds, temperatures and retraction.
    pub process: Process,
    /// Purging at tool changes; `None` if nothing is purged or the printer's own tool change does
    /// it.
    pub purge: Option<Purge>,
}

/// Dialect of the firmware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Flavour {
    /// Marlin and relatives: limits are set by `M204` and `M205`.
    ///
    /// Builds of Marlin limit cornering either by junction deviation or by jerk, so both are
    /// written.
    /// The junction deviation is clamped to 0.01 to 0.3 mm, the range that Marlin accepts.
    #[default]
    Marlin,
    /// Klipper: limits are set by `SET_VELOCITY_LIMIT`.
    Klipper,
}

named_enum! {
    Flavour, "flavour":
    Marlin = "marlin",
    Klipper = "klipper",
}

/// Whether the tools share a heated nozzle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Nozzles {
    /// The tools are filaments of one nozzle, which is set to the temperature of the current
    /// filament.
    #[default]
    Shared,
    /// Each tool has its own nozzle; those that are used are heated at the start and stay hot until
    /// the end.
    Own,
}

named_enum! {
    Nozzles, "nozzles":
    Shared = "shared",
    Own = "own",
}

/// The machine.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Printer {
    /// Dialect of the firmware.
    pub flavour: Flavour,
    /// Whether the tools share a heated nozzle.
    pub nozzles: Nozzles,
    /// Maximum x, y and z in mm; the minimum is 0, with x = y = 0 at the front left corner.
    pub bed_mm: [f64; 3],
    /// Acceleration in mm/s².
    pub acceleration_mm_s2: f64,
    /// Speed at which the toolhead may take a right-angled corner, in mm/s.
    pub square_corner_mm_s: f64,
    /// Maximum speed of the toolhead in mm/s.
    /// It is not written to the file, but the speeds of [`Process`] must not exceed it.
    /// Profiles may also call it `greatest_mm_s`, its former name.
    #[serde(alias = "greatest_mm_s")]
    pub max_speed_mm_s: f64,
}

impl Default for Printer {
    /// A common printer: Marlin, one nozzle, 250 x 210 x 210 mm, 1000 mm/s², 5 mm/s in right-angled
    /// corners, at most 200 mm/s.
    fn default() -> Self {
        Self {
            flavour: Flavour::default(),
            nozzles: Nozzles::default(),
            bed_mm: [250.0, 210.0, 210.0],
            acceleration_mm_s2: 1000.0,
            square_corner_mm_s: 5.0,
            max_speed_mm_s: 200.0,
        }
    }
}

impl Printer {
    /// Acceleration, cornering and speed limits, for estimates of printing time.
    pub fn limits(&self) -> MotionLimits {
        MotionLimits {
            acceleration_mm_s2: self.acceleration_mm_s2,
            square_corner_mm_s: self.square_corner_mm_s,
            max_speed_mm_s: self.max_speed_mm_s,
        }
    }
}

/// A nozzle with its filament, or one of several filaments that share a nozzle.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tool {
    /// Name, for comments in the file.
    pub name: String,
    /// Red, green and blue, for viewers of the file.
    pub colour: [u8; 3],
    /// Temperature of the nozzle, in °C.
    pub nozzle_c: f64,
    /// Diameter of the filament, in mm.
    pub filament_mm: f64,
    /// Density of the filament, in g/cm³.
    pub density_g_cm3: f64,
}

impl Default for Tool {
    /// 230 °C, as in *Kim et al. 2026*; filament of 1.75 mm and 1.24 g/cm³.
    fn default() -> Self {
        Self {
            name: String::new(),
            colour: [128; 3],
            nozzle_c: 230.0,
            filament_mm: 1.75,
            density_g_cm3: 1.24,
        }
    }
}

impl Tool {
    /// Diameter and density of the filament.
    pub fn filament(&self) -> Filament {
        Filament { diameter_mm: self.filament_mm, density_g_cm3: self.density_g_cm3 }
    }

    /// Cross-sectional area of the filament, in mm².
    pub fn filament_mm2(&self) -> f64 {
        self.filament().area_mm2()
    }
}

/// Purging at tool changes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Purge {
    /// Purge matrix in mm³: `volume_mm3[from][to]` is the volume that tool `to` extrudes after a
    /// change from tool `from`, before it prints the part.
    /// The diagonal is not used.
    pub volume_mm3: Vec<Vec<f64>>,
    /// Position of the prime tower; `None` if the printer purges in its own tool change, in which
    /// case the program purges nothing.
    pub tower: Option<PrimeTower>,
}

impl Purge {
    /// Purging with the same volume for every change between two of `tools` tools, in mm³.
    pub fn uniform(tools: usize, volume_mm3: f64, tower: Option<PrimeTower>) -> Self {
        let row = |from| (0..tools).map(|to| if from == to { 0.0 } else { volume_mm3 }).collect();
        Self { volume_mm3: (0..tools).map(row).collect(), tower }
    }

    /// Volume that a change between two tools purges into the prime tower, in mm³; 0 without one.
    pub fn prime_tower_mm3(&self, from: u8, to: u8) -> f64 {
        let row =
            self.volume_mm3.get(usize::from(from)).filter(|_| self.tower.is_some() && from != to);
        row.and_then(|row| row.get(usize::from(to))).copied().unwrap_or(0.0)
    }
}

/// Position of the prime tower, the block beside the part that tool changes purge into.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrimeTower {
    /// x of the left side, in mm.
    pub left_mm: f64,
    /// y of the front, in mm.
    pub front_mm: f64,
    /// Size along x, in mm.
    pub width_mm: f64,
    /// Maximum size along y, in mm; the tower is only as deep as the layer that purges most
    /// requires.
    pub depth_mm: f64,
}

#[cfg(test)]
mod tests {
    use serde::de::IntoDeserializer;
    use serde::de::value::{Error, MapDeserializer};

    use super::*;
    use crate::print::CrossSection;

    #[test]
    fn profiles_may_use_the_former_name_of_the_maximum_speed() {
        for key in ["max_speed_mm_s", "greatest_mm_s"] {
            let entries = [(key, 150.0.into_deserializer())];
            let entries = MapDeserializer::<_, Error>::new(entries.into_iter());
            let printer = Printer::deserialize(entries).unwrap();
            assert_eq!(printer, Printer { max_speed_mm_s: 150.0, ..Printer::default() });
        }
    }

    #[test]
    fn names_are_those_of_profiles() {
        fn check<T: for<'de> Deserialize<'de> + PartialEq + std::fmt::Debug>(
            all: &[T],
            name: impl Fn(&T) -> &'static str,
        ) {
            for value in all {
                let name: serde::de::value::StrDeserializer<'_, Error> =
                    name(value).into_deserializer();
                assert_eq!(&T::deserialize(name).unwrap(), value);
            }
        }
        check(&Flavour::ALL, |flavour| flavour.name());
        check(&Nozzles::ALL, |nozzles| nozzles.name());
        check(&CrossSection::ALL, |cross_section| cross_section.name());
    }
}
