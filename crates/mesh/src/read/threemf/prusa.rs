//! Projects of PrusaSlicer and of slicers that derive from it.
//!
//! The parts of an object are one mesh; an XML entry lists the ranges of their triangles, with
//! their types and extruders.
//! The settings of the printer and the filaments are lines `; key = value` in another entry.

use std::collections::HashMap;
use std::io::BufRead;

use super::archive::Archive;
use super::project::{ObjectSettings, PartSettings, Project, Volume};
use super::xml::{Element, Tag, each_element};
use crate::read::error::ReadError;

/// Entries with the parts of objects, the most common name first.
const OBJECTS: [&str; 3] = [
    "Metadata/Slic3r_PE_model.config",
    "Metadata/Slic3r_model.config",
    "Metadata/Superslicer_model.config",
];
/// Entries with the settings.
const SETTINGS: [&str; 3] =
    ["Metadata/Slic3r_PE.config", "Metadata/Slic3r.config", "Metadata/Superslicer.config"];
/// Entries that change layers, and what they hold.
const LAYERS: [(&str, &str); 3] = [
    ("Metadata/Prusa_Slicer_custom_gcode_per_print_z.xml", "tool changes and pauses at heights"),
    ("Metadata/Prusa_Slicer_layer_config_ranges.xml", "settings of ranges of height"),
    ("Metadata/Slic3r_PE_layer_heights_profile.txt", "variable layer heights"),
];

/// Reads what an archive states, if it is a project.
pub(super) fn read(archive: &mut Archive<'_>, project: &mut Project) -> Result<(), ReadError> {
    if let Some(entry) = OBJECTS.iter().find(|entry| archive.contains(entry)) {
        project.is_stated = true;
        archive.read(entry, |source| read_objects(entry, source, &mut project.objects))?;
    }
    if let Some(entry) = SETTINGS.iter().find(|entry| archive.contains(entry)) {
        project.is_stated = true;
        let settings = archive.read(entry, |source| read_settings(entry, source))?;
        apply(&settings, project).map_err(|message| ReadError::entry(entry, message))?;
    }
    if archive.contains("Metadata/PrusaSlicer3_project.json") {
        project.notes.ignored("settings and paint of PrusaSlicer 3");
    }
    for (entry, what) in LAYERS {
        if archive.contains(entry) && has_content(archive, entry)? {
            project.notes.ignored(what);
        }
    }
    Ok(())
}

/// Whether an entry holds more than an empty list.
/// Entries whose names end with "txt" are not XML.
pub(super) fn has_content(archive: &mut Archive<'_>, entry: &str) -> Result<bool, ReadError> {
    if entry.ends_with("txt") {
        return archive.read(entry, |source| {
            let ends = source.fill_buf().map_or(true, <[u8]>::is_empty);
            Ok(!ends)
        });
    }
    archive.read(entry, |source| {
        let mut found = false;
        each_element(entry, source, |element| {
            if let Element::Start(tag) = element {
                found |= matches!(tag.name, "code" | "layer" | "range");
            }
            Ok(())
        })?;
        Ok(found)
    })
}

fn read_objects(
    entry: &str,
    source: &mut dyn BufRead,
    objects: &mut HashMap<u32, ObjectSettings>,
) -> Result<(), ReadError> {
    let mut object: Option<(u32, ObjectSettings)> = None;
    let mut volume: Option<Volume> = None;
    each_element(entry, source, |element| {
        match element {
            Element::Start(tag) => match (tag.name, &mut object) {
                ("object", _) => {
                    let id = tag.integer("id")?.ok_or("object has no id")?;
                    object = Some((id, ObjectSettings::default()));
                }
                ("volume", Some(_)) => {
                    let end =
                        |name| tag.integer(name)?.ok_or_else(|| format!("volume has no {name}"));
                    let ends = [end("firstid")?, end("lastid")?];
                    volume = Some(Volume { ends, part: PartSettings::default() });
                }
                ("metadata", Some((_, object))) => {
                    let (key, value) = setting(tag)?;
                    match &mut volume {
                        Some(volume) => volume.part.set(&key, &value)?,
                        None => object.set(&key, &value)?,
                    }
                }
                _ => {}
            },
            Element::End(_, "volume") => {
                if let (Some((_, object)), Some(volume)) = (&mut object, volume.take()) {
                    object.volumes.push(volume);
                }
            }
            Element::End(_, "object") => {
                if let Some((id, object)) = object.take() {
                    objects.insert(id, object);
                }
            }
            Element::End(..) => {}
        }
        Ok(())
    })
}

/// The key and the value of a `metadata` element.
pub(super) fn setting(tag: &Tag<'_>) -> Result<(String, String), String> {
    let text = |name| Ok::<_, String>(tag.attribute(name)?.unwrap_or_default().into_owned());
    Ok((text("key")?, text("value")?))
}

/// Reads lines `; key = value`.
fn read_settings(
    entry: &str,
    source: &mut dyn BufRead,
) -> Result<HashMap<String, String>, ReadError> {
    let mut settings = HashMap::new();
    let mut line = Vec::new();
    loop {
        line.clear();
        let read = source.read_until(b'\n', &mut line);
        if read.map_err(|error| ReadError::entry(entry, error.to_string()))? == 0 {
            return Ok(settings);
        }
        let text = String::from_utf8_lossy(&line);
        let text = text.trim().trim_start_matches(';');
        if let Some((key, value)) = text.split_once('=')
            && KEYS.contains(&key.trim())
        {
            settings.insert(key.trim().to_owned(), value.trim().to_owned());
        }
    }
}

/// The settings that are used.
const KEYS: [&str; 9] = [
    "extruder_colour",
    "filament_colour",
    "filament_type",
    "perimeter_extruder",
    "single_extruder_multi_material",
    "wiping_volumes_matrix",
    "wiping_volumes_use_custom_matrix",
    "multimaterial_purging",
    "filament_purge_multiplier",
];

fn apply(settings: &HashMap<String, String>, project: &mut Project) -> Result<(), String> {
    project.notes.ignored("print settings of the project");
    let list = |key: &str| {
        let text = settings.get(key).map_or("", String::as_str);
        let words = text.split([';', ',']).map(|word| word.trim().trim_matches('"').to_owned());
        if text.is_empty() { Vec::new() } else { words.collect::<Vec<_>>() }
    };
    let mut colours = list("filament_colour");
    // Colours of extruders, where they are set, override those of filaments.
    for (number, own) in list("extruder_colour").into_iter().enumerate() {
        match colours.get_mut(number) {
            Some(colour) if !own.is_empty() => *colour = own,
            Some(_) => {}
            None => colours.push(own),
        }
    }
    project.set_filaments(&colours, &list("filament_type"));
    if let Some(number) = settings.get("perimeter_extruder") {
        project.default_filament = super::project::filament_number(number)?.unwrap_or_default();
    }
    // Without a matrix of its own, the project has one volume, which filaments scale in per cent.
    let is_custom = settings.get("wiping_volumes_use_custom_matrix").is_none_or(|it| it != "0");
    let matrix = match settings.get("multimaterial_purging") {
        Some(volume) if !is_custom => {
            let volume = crate::read::text::number(volume)?;
            let shares = list("filament_purge_multiplier");
            let count = project.filaments.len();
            let mut matrix = Vec::with_capacity(count * count);
            for pair in 0..count * count {
                let share = match shares.get(pair % count) {
                    Some(share) => crate::read::text::number(share.trim_end_matches('%'))?,
                    None => 100.0,
                };
                matrix.push((volume * share / 100.0).to_string());
            }
            matrix
        }
        _ => list("wiping_volumes_matrix"),
    };
    if settings.get("single_extruder_multi_material").is_some_and(|it| it == "0") {
        if matrix.len() > 1 {
            project.notes.ignored("purge volumes of a project for several extruders");
        }
        return Ok(());
    }
    project.set_purge(&matrix, 1.0)
}
