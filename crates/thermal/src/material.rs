//! What a print is made of.

use crate::property::{self, PropertyError};

/// A thermoplastic, as far as heat goes.
/// Its properties do not depend on the temperature, and melting takes no heat.
///
/// The presets are typical values of unfilled filament; a spool's own data sheet knows better.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What it is called.
    pub name: String,
    /// Thermal conductivity, W/(m K).
    /// More than 0.
    pub conductivity_w_mk: f64,
    /// Specific heat, J/(kg K).
    /// More than 0.
    pub specific_heat_j_kgk: f64,
    /// Density, kg/m³.
    /// More than 0.
    pub density_kg_m3: f64,
    /// Emissivity of its surface, 0 to 1.
    pub emissivity: f64,
    /// Glass transition, °C: below it a bead holds its shape.
    pub glass_transition_c: f64,
    /// Linear thermal expansion below the glass transition, 1/K.
    /// 0 to 0.01.
    pub expansion_per_k: f64,
}

impl Material {
    /// ABS: the thermal properties of the paper (Kim et al. 2026, table of the solver); glass
    /// transition and expansion are typical of moulding grades.
    pub fn abs() -> Self {
        Self {
            name: "ABS".into(),
            conductivity_w_mk: 0.33,
            specific_heat_j_kgk: 1470.0,
            density_kg_m3: 945.0,
            emissivity: 0.92,
            glass_transition_c: 105.0,
            expansion_per_k: 90e-6,
        }
    }

    /// PLA: conductivity, specific heat and glass transition as on makeitfrom.com (polylactic
    /// acid), the density of Ingeo 2003D.
    /// Sources of its expansion differ: that of PETG stands in.
    pub fn pla() -> Self {
        Self {
            name: "PLA".into(),
            conductivity_w_mk: 0.13,
            specific_heat_j_kgk: 1800.0,
            density_kg_m3: 1240.0,
            emissivity: 0.92,
            glass_transition_c: 60.0,
            expansion_per_k: 68e-6,
        }
    }

    /// PETG: all but the density as on makeitfrom.com (glycol-modified polyethylene terephthalate);
    /// the density is the middle of 1.25 to 1.29 g/cm³ on data sheets.
    pub fn petg() -> Self {
        Self {
            name: "PETG".into(),
            conductivity_w_mk: 0.29,
            specific_heat_j_kgk: 1200.0,
            density_kg_m3: 1270.0,
            emissivity: 0.92,
            glass_transition_c: 81.0,
            expansion_per_k: 68e-6,
        }
    }

    /// The preset of a name, in any case: `abs`, `pla` or `petg`.
    pub fn preset(name: &str) -> Option<Self> {
        [Self::abs(), Self::pla(), Self::petg()]
            .into_iter()
            .find(|preset| preset.name.eq_ignore_ascii_case(name))
    }

    /// Heat to warm a cubic metre by one kelvin, J/(m³ K).
    pub fn heat_capacity_j_m3k(&self) -> f64 {
        self.density_kg_m3 * self.specific_heat_j_kgk
    }

    /// Thermal diffusivity, m²/s.
    pub fn diffusivity_m2_s(&self) -> f64 {
        self.conductivity_w_mk / self.heat_capacity_j_m3k()
    }

    /// Whether all properties are such as a material can have.
    pub fn check(&self) -> Result<(), PropertyError> {
        property::positive("conductivity_w_mk", self.conductivity_w_mk)?;
        property::positive("specific_heat_j_kgk", self.specific_heat_j_kgk)?;
        property::positive("density_kg_m3", self.density_kg_m3)?;
        property::within("emissivity", self.emissivity, 0.0, 1.0)?;
        property::temperature("glass_transition_c", self.glass_transition_c)?;
        property::within("expansion_per_k", self.expansion_per_k, 0.0, 0.01)
    }
}
