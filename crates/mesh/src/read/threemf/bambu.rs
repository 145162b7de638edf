//! Projects of Bambu Studio and Orca Slicer.
//!
//! The parts of an object are its components; an XML entry states the types and filaments of parts
//! by the id of the object that the component refers to, and which objects are on which plate.
//! The settings of the printer and the filaments are a JSON entry whose values are strings and
//! lists of strings.

use std::io::BufRead;

use serde::Deserialize;
use serde_json::Value;

use super::archive::Archive;
use super::project::{ObjectSettings, PartRole, PartSettings, Plate, Project, filament_number};
use super::prusa::{has_content, setting};
use super::xml::{Element, each_element};
use crate::read::error::ReadError;
use crate::read::text::number;

/// The entry with objects, parts and plates.
const OBJECTS: &str = "Metadata/model_settings.config";
/// The entry with the settings.
const SETTINGS: &str = "Metadata/project_settings.config";
/// Entries that change layers, and what they hold.
const LAYERS: [(&str, &str); 3] = [
    ("Metadata/custom_gcode_per_layer.xml", "filament changes and pauses at heights"),
    ("Metadata/layer_config_ranges.xml", "settings of ranges of height"),
    ("Metadata/layer_heights_profile.txt", "variable layer heights"),
];

/// Reads what an archive states, if it is a project.
pub(super) fn read(archive: &mut Archive<'_>, project: &mut Project) -> Result<(), ReadError> {
    if archive.contains(OBJECTS) {
        project.is_stated = true;
        archive.read(OBJECTS, |source| read_objects(source, project))?;
    }
    if archive.contains(SETTINGS) {
        project.is_stated = true;
        let settings = archive.read(SETTINGS, read_settings)?;
        settings.apply(project).map_err(|message| ReadError::entry(SETTINGS, message))?;
    }
    for (entry, what) in LAYERS {
        if archive.contains(entry) && has_content(archive, entry)? {
            project.notes.ignored(what);
        }
    }
    Ok(())
}

fn read_objects(source: &mut dyn BufRead, project: &mut Project) -> Result<(), ReadError> {
    let mut object: Option<(u32, ObjectSettings)> = None;
    let mut part: Option<(u32, PartSettings)> = None;
    let mut plate: Option<Plate> = None;
    let mut instance: Option<(u32, u32)> = None;
    each_element(OBJECTS, source, |element| {
        match element {
            Element::Start(tag) => match tag.name {
                "object" => {
                    let id = tag.integer("id")?.ok_or("object has no id")?;
                    object = Some((id, ObjectSettings::default()));
                }
                "part" if object.is_some() => {
                    let id = tag.integer("id")?.ok_or("part has no id")?;
                    let mut settings = PartSettings::default();
                    if let Some(role) = tag.attribute("subtype")? {
                        settings.role = PartRole::from_name(&role)?;
                    }
                    part = Some((id, settings));
                }
                "plate" => plate = Some(Plate::default()),
                "model_instance" if plate.is_some() => instance = Some((0, 0)),
                "metadata" => {
                    let (key, value) = setting(tag)?;
                    let integer = || {
                        let number = value.trim().parse::<u32>();
                        number.map_err(|_| format!("{key} is '{value}', expected an integer"))
                    };
                    match (&mut part, &mut object, &mut instance, &mut plate) {
                        (Some((_, part)), ..) => part.set(&key, &value)?,
                        (_, Some((_, object)), ..) => object.set(&key, &value)?,
                        (_, _, Some((id, _)), _) if key == "object_id" => *id = integer()?,
                        (_, _, Some((_, copy)), _) if key == "instance_id" => *copy = integer()?,
                        (_, _, None, Some(plate)) if key == "plater_id" => {
                            plate.number = integer()?;
                        }
                        _ => {}
                    }
                }
                _ => {}
            },
            Element::End(_, "part") => {
                if let (Some((_, object)), Some((id, part))) = (&mut object, part.take()) {
                    object.parts.insert(id, part);
                }
            }
            Element::End(_, "object") => {
                if let Some((id, object)) = object.take() {
                    project.objects.insert(id, object);
                }
            }
            Element::End(_, "model_instance") => {
                if let (Some(plate), Some(instance)) = (&mut plate, instance.take()) {
                    plate.instances.push(instance);
                }
            }
            Element::End(_, "plate") => project.plates.extend(plate.take()),
            Element::End(..) => {}
        }
        Ok(())
    })
}

/// The settings that are used, as the file writes them.
#[derive(Deserialize)]
struct Settings {
    filament_colour: Option<Value>,
    filament_type: Option<Value>,
    flush_volumes_matrix: Option<Value>,
    flush_multiplier: Option<Value>,
    wall_filament: Option<Value>,
}

fn read_settings(mut source: &mut dyn BufRead) -> Result<Settings, ReadError> {
    // Some editors write a byte order mark.
    if source.fill_buf().is_ok_and(|bytes| bytes.starts_with(b"\xEF\xBB\xBF")) {
        source.consume(3);
    }
    serde_json::from_reader(&mut source)
        .map_err(|error| ReadError::entry(SETTINGS, format!("not valid JSON: {error}")))
}

impl Settings {
    fn apply(&self, project: &mut Project) -> Result<(), String> {
        project.notes.ignored("print settings of the project");
        project.set_filaments(
            &list(self.filament_colour.as_ref()),
            &list(self.filament_type.as_ref()),
        );
        if let Some(filament) = list(self.wall_filament.as_ref()).first() {
            project.default_filament = filament_number(filament)?.unwrap_or_default();
        }
        // One for each nozzle; that of the first nozzle, like its volumes.
        let multiplier = match list(self.flush_multiplier.as_ref()).first() {
            Some(multiplier) => number(multiplier)?,
            None => 1.0,
        };
        project.set_purge(&list(self.flush_volumes_matrix.as_ref()), multiplier)
    }
}

/// The words of a value: strings or numbers, one or a list.
fn list(value: Option<&Value>) -> Vec<String> {
    match value {
        Some(Value::Array(values)) => values.iter().flat_map(|value| list(Some(value))).collect(),
        Some(Value::String(text)) => {
            text.split([';', ',']).map(|word| word.trim().to_owned()).collect()
        }
        Some(Value::Number(number)) => vec![number.to_string()],
        _ => Vec::new(),
    }
}
