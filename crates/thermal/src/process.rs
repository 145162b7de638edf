//! Parameters of the print that matter for its temperatures.

use crate::material::ThermalMaterial;
use crate::property::{self, PropertyError};

/// Temperatures, heat transfer and speeds of a print.
///
/// The default is the process of the paper (Kim et al. 2026).
/// Construct it with `..ProcessParameters::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessParameters {
    /// Temperature at which a voxel is deposited, and held while the nozzle is on it, °C.
    pub extrusion_c: f64,
    /// Temperature of the build plate under layer 0, °C; `None` for an insulating plate.
    pub plate_c: Option<f64>,
    /// Temperature of the air and of all surroundings that radiate, °C.
    pub ambient_c: f64,
    /// Convective heat transfer coefficient, W/(m² K), at least 0.
    pub convection_w_m2k: f64,
    /// Print speed, mm/s, more than 0: depositing a voxel takes its width divided by this speed.
    pub print_mm_s: f64,
    /// Speed of travel moves between voxels that are not neighbours, mm/s; `None` for travel that
    /// takes no time.
    pub travel_mm_s: Option<f64>,
    /// Whether heat has to cross half a voxel before it leaves the surface.
    ///
    /// The paper's scheme, which is the default, uses the temperature at a voxel's centre as that
    /// of its surface, and therefore overestimates the loss.
    /// With the surface resistance, a surface at distance d from the centre has the heat transfer
    /// coefficient h / (1 + h d / k) instead of h, where h is that of convection and radiation
    /// together and k the conductivity.
    pub surface_resistance: bool,
}

impl Default for ProcessParameters {
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

impl ProcessParameters {
    /// The default with nozzle and plate temperatures that suit a material, by its name: 210 and 60
    /// °C for PLA, 240 and 80 °C for PETG, the default's for any other.
    pub fn suited_to(material: &ThermalMaterial) -> Self {
        let temperatures =
            |extrusion_c, plate_c| Self { extrusion_c, plate_c: Some(plate_c), ..Self::default() };
        match material.name.as_str() {
            "PLA" => temperatures(210.0, 60.0),
            "PETG" => temperatures(240.0, 80.0),
            _ => Self::default(),
        }
    }

    /// Returns an error for the first parameter that is out of its range.
    pub fn check(&self) -> Result<(), PropertyError> {
        property::temperature("ambient_c", self.ambient_c)?;
        property::temperature("extrusion_c", self.extrusion_c)?;
        self.plate_c.map_or(Ok(()), |plate| property::temperature("plate_c", plate))?;
        property::within("convection_w_m2k", self.convection_w_m2k, 0.0, 1e5)?;
        property::positive("print_mm_s", self.print_mm_s)?;
        self.travel_mm_s.map_or(Ok(()), |speed| property::positive("travel_mm_s", speed))
    }
}
