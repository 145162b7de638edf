//! Groups of materials, colours, and mixtures of them.
//!
//! A printer with several tools prints each triangle with one material:
//! - A colour is opaque (materials extension, section 2.1) and is named `#RRGGBB`, however the file
//!   writes it, so that equal colours are one material.
//! - A composite material is its largest constituent.
//! - Of multiproperties, a colour covers the material below it, or is mixed with the material's
//!   display colour if it is translucent, as section 5 defines for printers.
//! - Textures are not used.

use std::collections::HashMap;

use super::notes::Notes;
use super::xml::Tag;
use crate::model::Material;
use crate::read::text::{number, shown};

/// A reference to a property: the id of its group, and its index in the group.
pub(super) type Property = (u32, u32);

/// A group of properties.
pub(super) enum Group {
    /// Base materials.
    Materials(Vec<Material>),
    /// Colours and their opacity, 0 to 1.
    Colours(Vec<(Material, f64)>),
    /// Mixtures of the materials of a group.
    Composites {
        /// The group of base materials.
        group: u32,
        /// Indices of the constituents.
        indices: Vec<u32>,
        /// The index of the largest constituent of each mixture.
        largest: Vec<u32>,
    },
    /// Layers of properties.
    Layers {
        /// The group of each layer, the lowest first.
        groups: Vec<u32>,
        /// Whether each layer after the first is multiplied with those below.
        multiply: Vec<bool>,
        /// The indices of each entry.
        entries: Vec<Vec<u32>>,
    },
    /// Coordinates in a texture.
    Texture,
}

impl Group {
    /// Starts a group: an element of the core specification or of the materials extension.
    /// `None` if the element is not a group.
    pub(super) fn start(tag: &Tag<'_>) -> Result<Option<Self>, String> {
        Ok(Some(match tag.name {
            "basematerials" => Self::Materials(Vec::new()),
            "colorgroup" => Self::Colours(Vec::new()),
            "compositematerials" => {
                let group = tag.integer("matid")?.ok_or("composite materials have no matid")?;
                let indices = indices(tag, "matindices")?;
                if indices.is_empty() {
                    return Err("composite materials have no matindices".into());
                }
                Self::Composites { group, indices, largest: Vec::new() }
            }
            "multiproperties" => {
                let multiply = tag.attribute("blendmethods")?.unwrap_or_default();
                let multiply =
                    multiply.split_ascii_whitespace().map(|word| word == "multiply").collect();
                Self::Layers { groups: indices(tag, "pids")?, multiply, entries: Vec::new() }
            }
            "texture2dgroup" => Self::Texture,
            _ => return Ok(None),
        }))
    }

    /// Adds an entry; other elements have no effect.
    pub(super) fn add(&mut self, tag: &Tag<'_>) -> Result<(), String> {
        match (self, tag.name) {
            (Self::Materials(materials), "base") => materials.push(base_material(tag)?),
            (Self::Colours(colours), "color") => {
                let text = tag.attribute("color")?.ok_or("color has no value")?;
                let (colour, opacity) = colour(&text)
                    .ok_or_else(|| format!("'{}' is not a colour #RRGGBB", shown(&text)))?;
                colours
                    .push((Material { name: colour_name(colour), colour: Some(colour) }, opacity));
            }
            (Self::Composites { indices, largest, .. }, "composite") => {
                let values = tag.attribute("values")?.unwrap_or_default();
                let mut found = (0, 0.0);
                for (place, word) in values.split_ascii_whitespace().enumerate().take(indices.len())
                {
                    let share = number(word)?;
                    if share > found.1 {
                        found = (place, share);
                    }
                }
                largest.push(indices[found.0]);
            }
            (Self::Layers { entries, .. }, "multi") => entries.push(indices(tag, "pindices")?),
            _ => {}
        }
        Ok(())
    }
}

/// What a triangle with a property is made of; `None` if that does not say.
pub(super) fn material(
    groups: &HashMap<u32, Group>,
    (id, index): Property,
    notes: &mut Notes,
) -> Result<Option<Material>, String> {
    let entry = |count: usize| match index as usize {
        index if index < count => Ok(index),
        _ => Err(format!("material group {id} has no entry {index}")),
    };
    match groups.get(&id) {
        None => {
            notes.ignored_of("material groups that do not exist", &id.to_string());
            Ok(None)
        }
        Some(Group::Texture) => {
            notes.ignored("textures");
            Ok(None)
        }
        Some(Group::Materials(materials)) => Ok(Some(materials[entry(materials.len())?].clone())),
        Some(Group::Colours(colours)) => Ok(Some(colours[entry(colours.len())?].0.clone())),
        Some(Group::Composites { group, largest, .. }) => {
            let Some(Group::Materials(materials)) = groups.get(group) else {
                return Err(format!("composite materials {id} do not refer to base materials"));
            };
            notes.approximated("composite materials", "the largest constituent is used");
            let index = largest[entry(largest.len())?] as usize;
            match materials.get(index) {
                Some(material) => Ok(Some(material.clone())),
                None => Err(format!("material group {group} has no entry {index}")),
            }
        }
        Some(Group::Layers { groups: layers, multiply, entries }) => {
            let indices = &entries[entry(entries.len())?];
            let mut below: Option<Material> = None;
            for (layer, &group) in layers.iter().enumerate() {
                // Missing indices are 0 (section 5.1).
                let index = indices.get(layer).copied().unwrap_or(0);
                match groups.get(&group) {
                    Some(Group::Layers { .. }) => {
                        return Err(format!("multiproperties {id} contain multiproperties"));
                    }
                    Some(Group::Colours(colours)) => {
                        let (colour, opacity) = colours.get(index as usize).ok_or_else(|| {
                            format!("material group {group} has no entry {index}")
                        })?;
                        // On a material, "multiply" starts from an opaque colour.
                        let is_mixed = layer > 0 && !multiply.get(layer - 1).unwrap_or(&false);
                        let opacity = if is_mixed { *opacity } else { 1.0 };
                        below = Some(cover(below, colour, opacity));
                    }
                    _ => below = material(groups, (group, index), notes)?.or(below),
                }
            }
            Ok(below)
        }
    }
}

/// A colour on a material.
fn cover(below: Option<Material>, colour: &Material, opacity: f64) -> Material {
    let (Some(below), Some(top)) = (below, colour.colour) else { return colour.clone() };
    if opacity == 0.0 {
        return below;
    }
    // A material of unknown colour cannot be mixed with.
    let Some(base) = below.colour.filter(|_| opacity < 1.0) else { return colour.clone() };
    let mixed = [0, 1, 2].map(|channel| {
        let value = linear(top[channel]) * opacity + linear(base[channel]) * (1.0 - opacity);
        from_linear(value)
    });
    Material { name: colour_name(mixed), colour: Some(mixed) }
}

/// Brightness 0 to 1 of an sRGB value (section 1.2).
fn linear(value: u8) -> f64 {
    let value = f64::from(value) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn from_linear(value: f64) -> u8 {
    let value =
        if value <= 0.003_130_8 { value * 12.92 } else { value.powf(1.0 / 2.4) * 1.055 - 0.055 };
    (value * 255.0).round() as u8
}

/// A base material: its name, or its colour if it has none.
/// A name that is the material's colour is written as colours are.
fn base_material(tag: &Tag<'_>) -> Result<Material, String> {
    let display = tag.attribute("displaycolor")?;
    // It is only for display, so a malformed one does no harm.
    let colour = display.and_then(|text| colour(&text)).map(|(colour, _)| colour);
    let name = tag.attribute("name")?.unwrap_or_default();
    let name = match (self::colour(&name), colour) {
        (Some((named, _)), Some(colour)) if named == colour => colour_name(colour),
        (_, Some(colour)) if name.trim().is_empty() => colour_name(colour),
        _ => name.into_owned(),
    };
    Ok(Material { name, colour })
}

/// Reads a list of ids or indices.
fn indices(tag: &Tag<'_>, name: &str) -> Result<Vec<u32>, String> {
    let text = tag.attribute(name)?.unwrap_or_default();
    let index = |word: &str| {
        word.parse().map_err(|_| format!("{name} contains '{}', expected integers", shown(word)))
    };
    text.split_ascii_whitespace().map(index).collect()
}

/// The name of a material that is known by its colour.
pub(super) fn colour_name([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// Reads a colour and its opacity: `#RRGGBB` or `#RRGGBBAA`.
pub(super) fn colour(text: &str) -> Option<([u8; 3], f64)> {
    let digits = text.trim().strip_prefix('#').filter(|digits| {
        matches!(digits.len(), 6 | 8) && digits.bytes().all(|byte| byte.is_ascii_hexdigit())
    })?;
    let channel = |index: usize| u8::from_str_radix(&digits[index..index + 2], 16).ok();
    let opacity = if digits.len() == 8 { f64::from(channel(6)?) / 255.0 } else { 1.0 };
    Some(([channel(0)?, channel(2)?, channel(4)?], opacity))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material_of(colour: [u8; 3]) -> Material {
        Material { name: colour_name(colour), colour: Some(colour) }
    }

    #[test]
    fn colours_are_read_in_every_form() {
        assert_eq!(colour("#ff0080"), Some(([255, 0, 128], 1.0)));
        assert_eq!(colour(" #FF008000 "), Some(([255, 0, 128], 0.0)));
        for text in ["ff0080", "#ff008", "#ff0080+1", "#+f0080", "#ÿÿÿ", ""] {
            assert_eq!(colour(text), None, "{text}");
        }
        for value in 0..=255 {
            assert_eq!(from_linear(linear(value)), value);
        }
    }

    #[test]
    fn layers_are_mixed_as_printers_do() {
        let base = Material { name: "PLA".into(), colour: Some([0; 3]) };
        let groups = HashMap::from([
            (1, Group::Materials(vec![base.clone()])),
            (
                2,
                Group::Colours(vec![
                    (material_of([255, 0, 0]), 1.0),
                    (material_of([255, 255, 255]), 0.5),
                    (material_of([0, 0, 255]), 0.0),
                ]),
            ),
            (3, Group::Texture),
            (
                4,
                Group::Layers {
                    groups: vec![1, 2],
                    multiply: vec![],
                    entries: vec![vec![0, 0], vec![0, 1], vec![0, 2], vec![], vec![0, 7]],
                },
            ),
            (5, Group::Layers { groups: vec![2, 3], multiply: vec![], entries: vec![vec![2, 0]] }),
            (
                6,
                Group::Layers {
                    groups: vec![1, 2],
                    multiply: vec![true],
                    entries: vec![vec![0, 1]],
                },
            ),
            (7, Group::Layers { groups: vec![4], multiply: vec![], entries: vec![vec![0]] }),
        ]);
        let mut notes = Notes::default();
        let mut of = |property| material(&groups, property, &mut notes);
        assert_eq!(of((4, 0)), Ok(Some(material_of([255, 0, 0]))));
        assert_eq!(of((4, 1)), Ok(Some(material_of([188, 188, 188]))));
        assert_eq!(of((4, 2)), Ok(Some(base)));
        assert_eq!(of((4, 3)), Ok(Some(material_of([255, 0, 0]))));
        assert_eq!(of((4, 4)), Err("material group 2 has no entry 7".into()));
        assert_eq!(of((5, 0)), Ok(Some(material_of([0, 0, 255]))));
        assert_eq!(of((6, 0)), Ok(Some(material_of([255, 255, 255]))));
        assert!(of((7, 0)).is_err());
        assert_eq!(of((8, 0)), Ok(None));
        assert_eq!(notes.into_warnings().len(), 2);
    }
}
