//! What the projects of slicers state besides the model: filaments, roles, plates, purge volumes.

use std::collections::HashMap;

use ndarray::Array2;

use super::notes::Notes;
use super::properties::colour;
use crate::model::Model;
use crate::read::text::number;

/// Settings of a project; those that a file does not state are empty.
#[derive(Default)]
pub(super) struct Project {
    /// Whether the file is a project: then objects without a filament have the first one.
    pub(super) is_stated: bool,
    /// Number of the filament of objects that do not state one, from 1; 0 stands for 1.
    pub(super) default_filament: u32,
    /// The filaments; number k is at k - 1.
    pub(super) filaments: Vec<Filament>,
    /// Volumes in mm³ that are purged between filaments, `[from, to]`.
    pub(super) purge_mm3: Option<Array2<f64>>,
    /// Settings of objects, by the id of the object.
    pub(super) objects: HashMap<u32, ObjectSettings>,
    /// Plates, if the project has any.
    pub(super) plates: Vec<Plate>,
    pub(super) notes: Notes,
}

/// A filament; what is not stated is empty.
#[derive(Clone, Debug, Default)]
pub(super) struct Filament {
    /// Such as "PETG".
    pub(super) kind: String,
    pub(super) colour: Option<[u8; 3]>,
}

#[derive(Debug, Default)]
pub(super) struct ObjectSettings {
    pub(super) name: String,
    /// Number of the filament, from 1.
    pub(super) filament: Option<u32>,
    /// Settings of components, by the id of the object that they refer to.
    pub(super) parts: HashMap<u32, PartSettings>,
    /// Settings of ranges of triangles, if the parts of the object are one mesh.
    pub(super) volumes: Vec<Volume>,
}

/// A part that is a range of triangles.
#[derive(Debug, Default)]
pub(super) struct Volume {
    /// Its first triangle and its last one.
    pub(super) ends: [u32; 2],
    pub(super) part: PartSettings,
}

#[derive(Clone, Debug, Default)]
pub(super) struct PartSettings {
    pub(super) name: String,
    pub(super) role: PartRole,
    /// Number of the filament, from 1.
    pub(super) filament: Option<u32>,
}

/// What a part is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum PartRole {
    #[default]
    Solid,
    Negative,
    Modifier,
    /// It enforces or blocks supports.
    Support,
}

/// The objects that are printed at once.
#[derive(Debug, Default)]
pub(super) struct Plate {
    pub(super) number: u32,
    /// Ids of objects, and which instance of the object.
    pub(super) instances: Vec<(u32, u32)>,
}

impl PartRole {
    /// The role that slicers call by a name.
    pub(super) fn from_name(name: &str) -> Result<Self, String> {
        Ok(match name {
            "ModelPart" | "normal_part" => Self::Solid,
            "NegativeVolume" | "negative_part" => Self::Negative,
            "ParameterModifier" | "modifier_part" => Self::Modifier,
            "SupportEnforcer" | "SupportBlocker" | "support_enforcer" | "support_blocker" => {
                Self::Support
            }
            _ => {
                let name: String = name.chars().take(40).collect();
                return Err(format!("unknown type of a part: '{name}'"));
            }
        })
    }
}

impl PartSettings {
    /// Applies a setting of the part.
    pub(super) fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        match key {
            "name" => self.name = value.chars().take(200).collect(),
            "extruder" => self.filament = filament_number(value)?,
            "volume_type" | "part_type" => self.role = PartRole::from_name(value)?,
            // The older form of "ParameterModifier".
            "modifier" if value == "1" => self.role = PartRole::Modifier,
            _ => {}
        }
        Ok(())
    }
}

impl ObjectSettings {
    /// Applies a setting of the object.
    pub(super) fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        match key {
            "name" => self.name = value.chars().take(200).collect(),
            "extruder" => self.filament = filament_number(value)?,
            _ => {}
        }
        Ok(())
    }
}

/// Reads the number of a filament; 0 means that none is stated.
pub(super) fn filament_number(value: &str) -> Result<Option<u32>, String> {
    let found =
        value.trim().parse().ok().filter(|&number: &u32| number < Model::MAX_MATERIALS as u32);
    let number = found.ok_or_else(|| {
        let (value, max) = (crate::read::text::shown(value), Model::MAX_MATERIALS - 1);
        format!("extruder is '{value}', expected an integer from 0 to {max}")
    })?;
    Ok(Some(number).filter(|&number| number > 0))
}

impl Project {
    /// Sets the filaments from lists of their colours and types.
    pub(super) fn set_filaments(&mut self, colours: &[String], kinds: &[String]) {
        let count = colours.len().max(kinds.len()).min(Model::MAX_MATERIALS - 1);
        self.filaments = (0..count)
            .map(|number| Filament {
                kind: kinds.get(number).cloned().unwrap_or_default(),
                colour: colours.get(number).and_then(|text| colour(text)).map(|(rgb, _)| rgb),
            })
            .collect();
    }

    /// Sets the purge volumes from a list of rows, one for each filament that is purged.
    /// A printer with several nozzles may have one matrix for each of them.
    pub(super) fn set_purge(&mut self, words: &[String], multiplier: f64) -> Result<(), String> {
        let volumes = words.iter().map(|word| number(word)).collect::<Result<Vec<_>, _>>()?;
        let count = match self.filaments.len() {
            0 => volumes.len().isqrt(),
            count => count,
        };
        let block = count * count;
        if volumes.is_empty() || count < 2 {
            return Ok(());
        }
        if block == 0 || volumes.len() % block != 0 {
            let what = format!(
                "purge volumes of the project ({} numbers for {count} filaments)",
                volumes.len()
            );
            self.notes.ignored(&what);
            return Ok(());
        }
        let scaled = |volume: f64| volume * multiplier;
        if let Some(wrong) = volumes.iter().find(|&&volume| !(0.0..=1e6).contains(&scaled(volume)))
        {
            return Err(format!("purge volume {wrong} is not between 0 and 1,000,000 mm³"));
        }
        if volumes.chunks(block).any(|other| other != &volumes[..block]) {
            let what = "purge volumes of several nozzles";
            self.notes.approximated(what, "those of the first nozzle are used");
        }
        let volume = |(from, to): (usize, usize)| {
            if from == to { 0.0 } else { scaled(volumes[from * count + to]) }
        };
        self.purge_mm3 = Some(Array2::from_shape_fn((count, count), volume));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn purge_volumes_are_rows_from_a_filament() {
        let mut project = Project::default();
        project.set_purge(&words("9 100 200 9"), 0.5).unwrap();
        assert_eq!(project.purge_mm3, Some(array![[0.0, 50.0], [100.0, 0.0]]));
        // Two nozzles.
        project.set_filaments(&words("#FF0000 #00FF00"), &[]);
        project.set_purge(&words("0 1 2 0 0 3 4 0"), 1.0).unwrap();
        assert_eq!(project.purge_mm3, Some(array![[0.0, 1.0], [2.0, 0.0]]));
        project.set_purge(&words("0 1 2"), 1.0).unwrap();
        let lines: Vec<_> = project.notes.into_warnings().iter().map(ToString::to_string).collect();
        assert_eq!(
            lines,
            [
                "purge volumes of several nozzles: those of the first nozzle are used",
                "purge volumes of the project (3 numbers for 2 filaments): not used",
            ]
        );
        let mut project = Project::default();
        assert!(project.set_purge(&words("0 x 1 0"), 1.0).is_err());
        assert!(project.set_purge(&words("0 -1 1 0"), 1.0).is_err());
    }
}
