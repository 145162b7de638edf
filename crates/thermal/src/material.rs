//! Thermal and mechanical properties of a filament.

use crate::property::{self, PropertyError};

/// Properties of a thermoplastic that matter for temperatures and warpage.
///
/// They do not depend on the temperature, and melting takes no latent heat.
/// The [presets](Preset) are typical values of unfilled filament; prefer a spool's data sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct ThermalMaterial {
    /// Name, such as `ABS`.
    pub name: String,
    /// Thermal conductivity, W/(m K), more than 0.
    pub conductivity_w_mk: f64,
    /// Specific heat, J/(kg K), more than 0.
    pub specific_heat_j_kgk: f64,
    /// Density, kg/m³, more than 0.
    pub density_kg_m3: f64,
    /// Emissivity of the surface, 0 to 1.
    pub emissivity: f64,
    /// Glass transition temperature, °C: below it, a bead is solid.
    pub glass_transition_c: f64,
    /// Coefficient of linear thermal expansion below the glass transition, 1/K, 0 to 0.01.
    pub expansion_per_k: f64,
}

/// A filament with typical properties.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Preset {
    /// [`ThermalMaterial::abs`].
    Abs,
    /// [`ThermalMaterial::pla`].
    Pla,
    /// [`ThermalMaterial::petg`].
    Petg,
}

beadwork_base::named_enum! {
    Preset, "material":
    Abs = "abs",
    Pla = "pla",
    Petg = "petg",
}

impl Preset {
    /// Its properties.
    pub fn material(self) -> ThermalMaterial {
        match self {
            Self::Abs => ThermalMaterial::abs(),
            Self::Pla => ThermalMaterial::pla(),
            Self::Petg => ThermalMaterial::petg(),
        }
    }
}

impl ThermalMaterial {
    /// ABS.
    ///
    /// The thermal properties are those of the paper (Kim et al. 2026, table of the solver); glass
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

    /// PLA.
    ///
    /// Conductivity, specific heat and glass transition are those of makeitfrom.com (polylactic
    /// acid), the density is that of Ingeo 2003D.
    /// Sources disagree on its expansion, so it is that of PETG.
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

    /// PETG.
    ///
    /// The density is the mean of 1.25 to 1.29 g/cm³ on data sheets; all other properties are those
    /// of makeitfrom.com (glycol-modified polyethylene terephthalate).
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

    /// Volumetric heat capacity, J/(m³ K).
    pub fn heat_capacity_j_m3k(&self) -> f64 {
        self.density_kg_m3 * self.specific_heat_j_kgk
    }

    /// Thermal diffusivity, m²/s.
    pub fn diffusivity_m2_s(&self) -> f64 {
        self.conductivity_w_mk / self.heat_capacity_j_m3k()
    }

    /// Returns an error for the first property that is out of its range.
    pub fn check(&self) -> Result<(), PropertyError> {
        property::positive("conductivity_w_mk", self.conductivity_w_mk)?;
        property::positive("specific_heat_j_kgk", self.specific_heat_j_kgk)?;
        property::positive("density_kg_m3", self.density_kg_m3)?;
        property::within("emissivity", self.emissivity, 0.0, 1.0)?;
        property::temperature("glass_transition_c", self.glass_transition_c)?;
        property::within("expansion_per_k", self.expansion_per_k, 0.0, 0.01)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_have_valid_properties_and_their_own_name() {
        for preset in Preset::ALL {
            let material = preset.material();
            assert_eq!(material.check(), Ok(()));
            assert_eq!(material.name.to_lowercase(), preset.name());
        }
    }
}
