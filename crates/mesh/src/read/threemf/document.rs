//! One XML document of a 3MF archive: objects, materials, and build items.

use std::collections::HashMap;
use std::io::BufRead;

use super::mesh::{MeshReader, Surface, vertex};
use super::namespace::Namespace;
use super::notes::Notes;
use super::properties::{Group, Property};
use super::xml::{Element, Tag, each_element};
use crate::read::error::{ReadError, ReadLimits};
use crate::read::text::{number, shown};
use crate::transform::Transform;

/// Names are cut to this many characters, because every instance of an object gets a copy.
const MAX_NAME_CHARS: usize = 200;

/// The content of a document.
#[derive(Default)]
pub(super) struct Document {
    /// Length of its unit in mm.
    pub(super) unit_mm: f64,
    /// Objects by their id.
    pub(super) objects: HashMap<u32, Object>,
    /// Materials and colours by the id of their group.
    pub(super) groups: HashMap<u32, Group>,
    /// The objects to print; `None` if the document has no build.
    pub(super) items: Option<Vec<Item>>,
    /// Whether facets are painted with filaments.
    pub(super) is_painted: bool,
    /// What is not used.
    pub(super) notes: Notes,
}

pub(super) struct Object {
    pub(super) name: String,
    /// The type, unless it is one that is printed as a solid.
    pub(super) auxiliary: Option<&'static str>,
    pub(super) property: Option<Property>,
    pub(super) content: Content,
    /// The extension that part of the content belongs to, which is not supported.
    pub(super) extension: Option<String>,
    /// Why the mesh is not what is to be printed, as the end of a sentence about the object.
    pub(super) refusal: Option<String>,
}

pub(super) enum Content {
    Mesh(Surface),
    /// The object is composed of other objects.
    Components(Vec<Reference>),
}

/// An object to print.
pub(super) struct Item {
    pub(super) reference: Reference,
    pub(super) is_printable: bool,
}

/// An object, possibly in another document, and where it is.
pub(super) struct Reference {
    /// The archive entry of the document; `None` for the same document.
    pub(super) entry: Option<String>,
    pub(super) object: u32,
    pub(super) transform: Transform,
}

impl Document {
    pub(super) fn read(
        entry: &str,
        source: &mut dyn BufRead,
        limits: &ReadLimits,
    ) -> Result<Self, ReadError> {
        let mut reader = DocumentReader {
            document: Self { unit_mm: 1.0, ..Self::default() },
            object: None,
            in_mesh: false,
            group: None,
            mesh: MeshReader::default(),
            triangles: 0,
            max_triangles: limits.triangles,
        };
        let mut is_model = false;
        each_element(entry, source, |element| match element {
            Element::Start(tag) => {
                if tag.depth == 0 && tag.name == "model" {
                    if tag.namespace != Namespace::Core {
                        let name = tag.extension();
                        return Err(format!("<model> is not a 3MF model, but of the {name}"));
                    }
                    is_model = true;
                }
                reader.start(tag)
            }
            Element::End(namespace, name) => {
                reader.end(namespace, name);
                Ok(())
            }
        })?;
        if reader.triangles > reader.max_triangles {
            return Err(ReadError::too_large(reader.max_triangles, "triangles"));
        }
        if !is_model {
            let message = "document has no <model> element".into();
            return Err(ReadError::Entry { entry: entry.to_owned(), byte: None, message });
        }
        Ok(reader.document)
    }
}

/// Reads a document from top to bottom, element by element.
struct DocumentReader {
    document: Document,
    /// The object that is being read, and its id.
    object: Option<(u32, Object)>,
    in_mesh: bool,
    /// The group of materials that is being read, and its id.
    group: Option<(u32, Group)>,
    /// What is known of the mesh of the object.
    mesh: MeshReader,
    triangles: usize,
    max_triangles: usize,
}

impl DocumentReader {
    fn start(&mut self, tag: &Tag<'_>) -> Result<(), String> {
        match tag.namespace {
            Namespace::Core => self.start_core(tag),
            Namespace::Materials => {
                if let Some((_, group)) = &mut self.group {
                    return group.add(tag);
                }
                self.start_group(tag)
            }
            Namespace::Other => {
                self.start_foreign(tag);
                Ok(())
            }
            Namespace::Slic3r => self.start_slic3r(tag),
            // Names of sets of triangles, other models of the same object, and the like.
            _ => Ok(()),
        }
    }

    fn start_core(&mut self, tag: &Tag<'_>) -> Result<(), String> {
        let notes = &mut self.document.notes;
        match (tag.name, &mut self.object) {
            ("vertex", Some((_, Object { content: Content::Mesh(surface), .. })))
                if self.in_mesh =>
            {
                surface.vertices.push(vertex(tag, notes)?);
            }
            ("triangle", Some((_, object))) if self.in_mesh => {
                // Triangles beyond the limit are counted, but not stored.
                self.triangles += 1;
                let group = object.property.map(|(group, _)| group);
                if self.triangles <= self.max_triangles
                    && let Content::Mesh(surface) = &mut object.content
                {
                    self.mesh.triangle(tag, surface, group, notes)?;
                }
            }
            ("mesh", Some(_)) => self.in_mesh = true,
            ("component", Some((id, Object { content, .. }))) => {
                if matches!(content, Content::Mesh(surface) if surface.triangles.is_empty()) {
                    *content = Content::Components(Vec::new());
                }
                let Content::Components(components) = content else {
                    return Err(format!("object {id} has both a mesh and components"));
                };
                components.push(reference(tag)?);
            }
            ("object", None) => {
                let (id, object) = object(tag, notes)?;
                if self.document.objects.contains_key(&id) {
                    return Err(format!("id {id} is used by two objects"));
                }
                self.mesh = MeshReader::default();
                self.object = Some((id, object));
            }
            ("build", None) => self.document.items = Some(Vec::new()),
            ("item", None) => {
                let printable = tag.attribute("printable")?;
                let is_printable =
                    !printable.is_some_and(|value| matches!(value.trim(), "0" | "false"));
                let reference = reference(tag)?;
                let items = self.document.items.get_or_insert_default();
                items.push(Item { reference, is_printable });
            }
            ("metadata", Some(_)) => self.object_metadata(tag)?,
            ("basematerials", None) => self.start_group(tag)?,
            ("base", None) => {
                if let Some((_, group)) = &mut self.group {
                    group.add(tag)?;
                }
            }
            ("model", None) => self.start_model(tag)?,
            _ => {}
        }
        Ok(())
    }

    fn start_model(&mut self, tag: &Tag<'_>) -> Result<(), String> {
        if let Some(unit) = tag.attribute("unit")? {
            self.document.unit_mm =
                unit_mm(&unit).ok_or_else(|| format!("unknown unit '{}'", shown(&unit)))?;
        }
        if let Some(required) = tag.attribute("requiredextensions")? {
            for prefix in required.split_ascii_whitespace() {
                if tag.scope.namespace(prefix) == Namespace::Other {
                    let name = tag.scope.extension(prefix);
                    return Err(format!("file requires the {name}, which is not supported"));
                }
            }
        }
        if let Some(recommended) = tag.attribute("recommendedextensions")? {
            for prefix in recommended.split_ascii_whitespace() {
                if tag.scope.namespace(prefix) == Namespace::Other {
                    self.note_extension(&tag.scope.extension(prefix));
                }
            }
        }
        Ok(())
    }

    fn start_group(&mut self, tag: &Tag<'_>) -> Result<(), String> {
        if tag.name == "texture2d" {
            self.document.notes.ignored("textures");
        }
        let Some(group) = Group::start(tag)? else { return Ok(()) };
        let id = tag.integer("id")?.ok_or("material group has no id")?;
        if self.document.groups.contains_key(&id) {
            return Err(format!("id {id} is used by two material groups"));
        }
        self.group = Some((id, group));
        Ok(())
    }

    /// An element of Slic3r, the predecessor of PrusaSlicer: parts of an object and their settings.
    fn start_slic3r(&mut self, tag: &Tag<'_>) -> Result<(), String> {
        let Some((_, object)) = &mut self.object else { return Ok(()) };
        if tag.name == "volume" && tag.attribute("modifier")?.is_some_and(|value| value == "1") {
            object.refusal = Some("has a modifier of Slic3r, which is not supported".into());
        }
        if tag.name == "metadata" {
            self.document.notes.ignored("settings of parts that Slic3r states");
        }
        Ok(())
    }

    /// Metadata of the object that is being read.
    fn object_metadata(&mut self, tag: &Tag<'_>) -> Result<(), String> {
        let (Some((_, object)), Some(name)) = (&mut self.object, tag.attribute("name")?) else {
            return Ok(());
        };
        // Names of programs have a prefix; others are descriptions.
        let Some((program, setting)) = name.split_once(':') else { return Ok(()) };
        let is_auxiliary = matches!(
            setting,
            "anti_overhang_mesh" | "cutting_mesh" | "infill_mesh" | "support_mesh"
        );
        if program == "cura" && is_auxiliary {
            let setting = setting.replace('_', " ");
            object.refusal =
                Some(format!("is marked as {setting} of Cura, which is not supported"));
        }
        self.document.notes.ignored_of("settings of objects", &name);
        Ok(())
    }

    /// An element of an extension that is not supported.
    fn start_foreign(&mut self, tag: &Tag<'_>) {
        let name = tag.extension();
        self.note_extension(&name);
        let Some((_, object)) = &mut self.object else { return };
        // The mesh of such objects is not their shape, or only part of it.
        let is_shape = matches!(
            tag.name,
            "booleanshape" | "boolean" | "beamlattice" | "displacementmesh" | "levelset"
        );
        if is_shape && object.refusal.is_none() {
            object.refusal = Some(format!("needs the {name}, which is not supported"));
        }
        object.extension.get_or_insert(name);
    }

    fn note_extension(&mut self, name: &str) {
        self.document.notes.ignored(&format!("data of the {name}"));
    }

    fn end(&mut self, namespace: Namespace, name: &str) {
        match (namespace, name) {
            (Namespace::Core, "mesh") => self.in_mesh = false,
            (Namespace::Core, "object") => {
                self.in_mesh = false;
                let Some((id, mut object)) = self.object.take() else { return };
                if let Content::Mesh(surface) = &mut object.content {
                    let mesh = std::mem::take(&mut self.mesh);
                    self.document.is_painted |= mesh.is_painted;
                    let before = surface.triangles.len();
                    let is_complete = mesh.finish(surface, self.max_triangles);
                    self.triangles += surface.triangles.len().saturating_sub(before);
                    if !is_complete {
                        self.triangles = self.max_triangles + 1;
                    }
                }
                self.document.objects.insert(id, object);
            }
            (
                Namespace::Core | Namespace::Materials,
                "basematerials" | "colorgroup" | "compositematerials" | "multiproperties"
                | "texture2dgroup",
            ) => {
                if let Some((id, group)) = self.group.take() {
                    self.document.groups.insert(id, group);
                }
            }
            _ => {}
        }
    }
}

/// Units of the core specification, section 3.4, in mm.
fn unit_mm(unit: &str) -> Option<f64> {
    Some(match unit {
        "micron" => 0.001,
        "millimeter" => 1.0,
        "centimeter" => 10.0,
        "inch" => 25.4,
        "foot" => 304.8,
        "meter" => 1000.0,
        _ => return None,
    })
}

fn object(tag: &Tag<'_>, notes: &mut Notes) -> Result<(u32, Object), String> {
    let id = tag.integer("id")?.ok_or("object has no id")?;
    let property = match tag.integer("pid")? {
        Some(group) => Some((group, tag.integer("pindex")?.unwrap_or(0))),
        None => None,
    };
    let kind = tag.attribute("type")?;
    let auxiliary = match kind.as_deref() {
        None | Some("model" | "solidsupport") => None,
        Some("support") => Some("support"),
        Some("surface") => Some("surface"),
        Some("other") => Some("other"),
        Some(kind) => return Err(format!("object {id} has the unknown type '{}'", shown(kind))),
    };
    let name = tag
        .attribute("name")?
        .map_or_else(String::new, |name| name.chars().take(MAX_NAME_CHARS).collect());
    let mut refusal = None;
    if let Some(resolution) = tag.attribute_in(Namespace::Alternatives, "modelresolution")?
        && resolution != "fullres"
    {
        let resolution = shown(&resolution);
        refusal = Some(format!("is only the {resolution} model of an object; expected fullres"));
    }
    let slices = tag.attribute_in(Namespace::Other, "slicestackid")?;
    if slices.is_some() {
        notes.ignored("slices of objects with a mesh");
        if tag.attribute_in(Namespace::Other, "meshresolution")?.is_some_and(|it| it == "lowres") {
            let reason = "is only a low-resolution mesh; its slices are not supported";
            refusal = Some(reason.into());
        }
    }
    let extension = slices.map(|_| "slice extension".to_owned());
    let content = Content::Mesh(Surface::default());
    Ok((id, Object { name, auxiliary, property, content, extension, refusal }))
}

/// A component of an object, or an item to print.
fn reference(tag: &Tag<'_>) -> Result<Reference, String> {
    let object = tag.integer("objectid")?.ok_or("reference to an object has no objectid")?;
    let entry = tag.attribute_in(Namespace::Production, "path")?;
    let entry = entry.map(|entry| entry.trim_start_matches('/').to_owned());
    let transform = match tag.attribute("transform")? {
        None => Transform::IDENTITY,
        Some(text) => {
            let values =
                text.split_ascii_whitespace().map(number).collect::<Result<Vec<_>, _>>()?;
            let count = values.len();
            let values = values
                .try_into()
                .map_err(|_| format!("transform has {count} numbers, expected 12"))?;
            Transform::from_rows(values)
        }
    };
    Ok(Reference { entry, object, transform })
}
