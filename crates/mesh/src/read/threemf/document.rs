//! One XML document of a 3MF archive: objects, materials, and build items.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::BufRead;

use quick_xml::events::BytesStart;

use super::xml::{Element, attribute, each_attribute, each_element, integer};
use crate::mesh::drop_unused_vertices;
use crate::model::Material;
use crate::read::error::{ReadError, ReadLimits};
use crate::read::text::number;
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
    pub(super) groups: HashMap<u32, Vec<Material>>,
    /// The objects to print.
    pub(super) items: Vec<Reference>,
}

pub(super) struct Object {
    pub(super) name: String,
    /// Whether it is printed: false for support and other auxiliary objects.
    pub(super) is_model: bool,
    pub(super) property: Option<Property>,
    pub(super) content: Content,
}

/// A reference to a material: the id of its group, and its index in the group.
pub(super) type Property = (u32, u32);

pub(super) enum Content {
    Mesh {
        vertices: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
        /// For each triangle an index into `properties`; empty if all are 0.
        paint: Vec<u16>,
        /// The properties that triangles have; the first one is `None`.
        properties: Vec<Option<Property>>,
    },
    /// The object is composed of other objects.
    Components(Vec<Reference>),
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
            property_numbers: HashMap::new(),
            triangles: 0,
            max_triangles: limits.triangles,
        };
        let mut is_model = false;
        each_element(entry, source, |element| match element {
            Element::Start(start) => {
                is_model |= start.local_name().as_ref() == "model";
                reader.start(start)
            }
            Element::End(name) => {
                reader.end(name);
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
    /// The group of materials that is being read.
    group: Option<u32>,
    /// Indices into the object's `properties`.
    property_numbers: HashMap<Property, usize>,
    triangles: usize,
    max_triangles: usize,
}

impl DocumentReader {
    fn start(&mut self, start: &BytesStart<'_>) -> Result<(), String> {
        match (start.local_name().as_ref(), &mut self.object) {
            ("vertex", Some((_, Object { content: Content::Mesh { vertices, .. }, .. })))
                if self.in_mesh =>
            {
                vertices.push(vertex(start)?);
            }
            ("triangle", Some((_, object))) if self.in_mesh => {
                // Triangles beyond the limit are counted, but not stored.
                self.triangles += 1;
                if self.triangles <= self.max_triangles {
                    add_triangle(start, object, &mut self.property_numbers)?;
                }
            }
            ("mesh", Some(_)) => self.in_mesh = true,
            ("component", Some((_, Object { content, .. }))) => {
                if !matches!(content, Content::Components(_)) {
                    *content = Content::Components(Vec::new());
                }
                if let Content::Components(components) = content {
                    components.push(reference(start)?);
                }
            }
            ("object", None) => {
                self.property_numbers.clear();
                self.object = Some(object(start)?);
            }
            ("item", None) => self.document.items.push(reference(start)?),
            ("basematerials" | "colorgroup", None) => {
                let id = integer(start, "id")?.ok_or("material group has no id")?;
                self.document.groups.insert(id, Vec::new());
                self.group = Some(id);
            }
            ("base" | "color", None) => {
                let group = self.group.and_then(|id| self.document.groups.get_mut(&id));
                if let Some(group) = group {
                    group.push(material(start)?);
                }
            }
            ("model", None) => {
                if let Some(unit) = attribute(start, "unit")? {
                    self.document.unit_mm =
                        unit_mm(&unit).ok_or_else(|| format!("unknown unit '{unit}'"))?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn end(&mut self, name: &str) {
        match name {
            "mesh" => self.in_mesh = false,
            "object" => {
                if let Some((id, mut object)) = self.object.take() {
                    if let Content::Mesh { vertices, triangles, .. } = &mut object.content {
                        drop_unused_vertices(vertices, triangles);
                    }
                    self.document.objects.insert(id, object);
                }
                self.in_mesh = false;
            }
            "basematerials" | "colorgroup" => self.group = None,
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

fn object(start: &BytesStart<'_>) -> Result<(u32, Object), String> {
    let id = integer(start, "id")?.ok_or("object has no id")?;
    let property = match integer(start, "pid")? {
        Some(group) => Some((group, integer(start, "pindex")?.unwrap_or(0))),
        None => None,
    };
    let kind = attribute(start, "type")?;
    let name = attribute(start, "name")?
        .map_or_else(String::new, |name| name.chars().take(MAX_NAME_CHARS).collect());
    let object = Object {
        name,
        is_model: kind.is_none_or(|kind| kind == "model" || kind == "solidsupport"),
        property,
        content: Content::Mesh {
            vertices: Vec::new(),
            triangles: Vec::new(),
            paint: Vec::new(),
            properties: vec![None],
        },
    };
    Ok((id, object))
}

/// A `base` material, or a `color` of a colour group, which is named after its value.
fn material(start: &BytesStart<'_>) -> Result<Material, String> {
    let shown = attribute(start, "displaycolor")?.or(attribute(start, "color")?);
    let name = attribute(start, "name")?.or(shown.clone()).map(Cow::into_owned);
    let colour = shown.and_then(|text| colour(&text));
    Ok(Material { name: name.unwrap_or_default(), colour })
}

fn vertex(start: &BytesStart<'_>) -> Result<[f64; 3], String> {
    let mut point = [None; 3];
    each_attribute(start, |name, value| {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return Ok(()),
        };
        point[axis] = Some(number(value.trim())?);
        Ok(())
    })?;
    match point {
        [Some(x), Some(y), Some(z)] => Ok([x, y, z]),
        _ => Err("vertex must have x, y and z".into()),
    }
}

fn add_triangle(
    start: &BytesStart<'_>,
    object: &mut Object,
    numbers: &mut HashMap<Property, usize>,
) -> Result<(), String> {
    let mut corners = [None; 3];
    let (mut group, mut index) = (None, None);
    each_attribute(start, |name, value| {
        let target = match name {
            "v1" => &mut corners[0],
            "v2" => &mut corners[1],
            "v3" => &mut corners[2],
            "pid" => &mut group,
            "p1" => &mut index,
            _ => return Ok(()),
        };
        let number: u32 = value
            .trim()
            .parse()
            .map_err(|_| format!("{name} of a triangle is '{value}', expected an integer"))?;
        *target = Some(number);
        Ok(())
    })?;
    let [Some(a), Some(b), Some(c)] = corners else {
        return Err("triangle must have v1, v2 and v3".into());
    };
    let own = object.property.map(|(group, _)| group);
    let Content::Mesh { triangles, paint, properties, .. } = &mut object.content else {
        return Ok(());
    };
    triangles.push([a, b, c]);
    // An index without a group refers to the group of the object.
    let property = group.or(own).and_then(|group| Some((group, index?)));
    let number = match property {
        None => 0,
        Some(property) => {
            let next = properties.len();
            let number = *numbers.entry(property).or_insert(next);
            if number == next {
                properties.push(Some(property));
            }
            u16::try_from(number).map_err(|_| "object has more than 65,535 materials")?
        }
    };
    if number != 0 && paint.is_empty() {
        paint.resize(triangles.len() - 1, 0);
    }
    if number != 0 || !paint.is_empty() {
        paint.push(number);
    }
    Ok(())
}

/// A component of an object, or an item to print.
fn reference(start: &BytesStart<'_>) -> Result<Reference, String> {
    let object = integer(start, "objectid")?.ok_or("reference to an object has no objectid")?;
    let mut entry = None;
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        // `p:path` of the production extension, whatever its prefix is.
        if attribute.key.local_name().as_ref() == "path" {
            entry = Some(attribute.value.into_owned());
        }
    }
    let transform = match attribute(start, "transform")? {
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

/// Reads a colour: `#RRGGBB` or `#RRGGBBAA`.
fn colour(text: &str) -> Option<[u8; 3]> {
    let digits = text
        .strip_prefix('#')
        .filter(|digits| matches!(digits.len(), 6 | 8) && digits.is_ascii())?;
    let channel = |index: usize| u8::from_str_radix(&digits[index..index + 2], 16).ok();
    Some([channel(0)?, channel(2)?, channel(4)?])
}
