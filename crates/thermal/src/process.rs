//! How a part is printed.

use crate::material::Material;
use crate::property::{self, PropertyError};

/// How a part is printed, as far as heat goes.
/// The default is the paper's (Kim et al. 2026).
#[derive(Clone, Debug, PartialEq)]
pub struct Process {
    /// Temperature at which a voxel is laid down and held while the nozzle is on it, °C.
    pub extrusion_c: f64,
    /// Temperature of the build plate under layer 0, °C; `None` for a plate that takes up no heat.
    pub plate_c: Option<f64>,
    /// Temperature of the air and of everything around, °C.
    pub ambient_c: f64,
    /// Heat transfer to the air, W/(m² K).
    /// At least 0.
    pub convection_w_m2k: f64,
    /// Speed of printing, mm/s: a voxel takes its width over this.
    /// More than 0.
    pub print_mm_s: f64,
    /// Speed of travel between voxels that are not neighbours, mm/s; `None` for a nozzle that is
    /// there at once.
    pub travel_mm_s: Option<f64>,
    /// Whether heat from a surface first has to cross the half voxel behind it.
    ///
    /// The plain scheme takes the temperature of a voxel's centre for that of its surface, which
    /// loses too much; with this, a surface at distance d from the centre passes h / (1 + h d / k)
    /// in place of h, for convection and radiation together.
    /// Off for the paper's results.
    pub surface_resistance: bool,
}

impl Default for Process {
    fn default() -> Self {
        Self {
            extrusion_c: 230.0,
            plate_c: Some(80.0),
            ambient_c: 25.0,
            convection_w_m2k: 10.0,
            print_mm_s: 30.0,
            travel_mm_s: Some(150.0),
            surface_resistance: false,
        }
    }
}

impl Process {
    /// Temperatures that suit a preset of [`Material`]: 210 °C and a plate of 60 °C for PLA, 240 °C
    /// and 80 °C for PETG, the paper's for all else.
    pub fn suited_to(material: &Material) -> Self {
        let temperatures =
            |extrusion_c, plate_c| Self { extrusion_c, plate_c: Some(plate_c), ..Self::default() };
        match material.name.as_str() {
            "PLA" => temperatures(210.0, 60.0),
            "PETG" => temperatures(240.0, 80.0),
            _ => Self::default(),
        }
    }

    /// Whether all settings are such as a printer can have.
    pub fn check(&self) -> Result<(), PropertyError> {
        property::temperature("ambient_c", self.ambient_c)?;
        property::temperature("extrusion_c", self.extrusion_c)?;
        self.plate_c.map_or(Ok(()), |plate| property::temperature("plate_c", plate))?;
        property::within("convection_w_m2k", self.convection_w_m2k, 0.0, 1e5)?;
        property::positive("print_mm_s", self.print_mm_s)?;
        self.travel_mm_s.map_or(Ok(()), |speed| property::positive("travel_mm_s", speed))
    }
}
