//! 3MF files: every object that the build names, with its transforms, units and materials.
//!
//! Core specification 1.3, with the colour groups of the materials extension and the references to
//! other parts of the production extension.
//! What else an extension adds is passed over.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::BufRead;
use std::rc::Rc;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::model::{Body, MOST_MATERIALS, Material, Model, ReadError, ReadLimits};
use super::package::Package;
use super::placement::Transform;
use super::stl::number;
use super::surface::{Mesh, keep_used};

/// The part that lists what the archive is about.
const RELATIONSHIPS: &str = "_rels/.rels";
/// Where the model stands if that list does not say.
const USUAL_MODEL: &str = "3D/3dmodel.model";
/// Objects made of objects made of objects: deeper than any program writes them, and no circle ends
/// before.
const DEEPEST: usize = 32;
/// Names are cut after so many characters.
const LONGEST_NAME: usize = 200;

pub(super) fn read(bytes: &[u8], limits: &ReadLimits) -> Result<Model, ReadError> {
    let mut package = Package::open(bytes, limits)?;
    let root = match package.find(RELATIONSHIPS) {
        Some(_) => package.read(RELATIONSHIPS, |source| model_part(RELATIONSHIPS, source))?,
        None => None,
    };
    let root = root.unwrap_or_else(|| USUAL_MODEL.to_owned());
    let mut builder = Builder {
        package,
        limits,
        parts: HashMap::new(),
        model: Model::default(),
        materials: HashMap::new(),
        triangles: 0,
    };
    builder.build(&root)?;
    Ok(builder.model)
}

/// The target of the relationship that names the model.
fn model_part(part: &str, source: &mut dyn BufRead) -> Result<Option<String>, ReadError> {
    let mut found = None;
    each_element(part, source, |element, _| {
        if let Element::Open(start) = element
            && start.local_name().as_ref() == "Relationship"
            && attribute(start, "Type")?.is_some_and(|kind| kind.ends_with("/3dmodel"))
        {
            found = found.take().or(attribute(start, "Target")?.map(Cow::into_owned));
        }
        Ok(())
    })?;
    Ok(found)
}

/// What a model part says.
#[derive(Default)]
struct Part {
    mm: f64,
    objects: HashMap<u32, Object>,
    /// MaterialRule and colours by the number of their group.
    groups: HashMap<u32, Vec<Material>>,
    items: Vec<Reference>,
}

struct Object {
    name: String,
    /// Whether it is to be printed: supports and others are not.
    is_model: bool,
    property: Option<Property>,
    content: Content,
}

/// A material: the number of its group, and its place in it.
type Property = (u32, u32);

enum Content {
    Mesh {
        vertices: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
        /// For each triangle a number in `properties`, or nothing at all.
        paint: Vec<u16>,
        properties: Vec<Option<Property>>,
    },
    Components(Vec<Reference>),
}

/// An object somewhere, and how it is moved.
struct Reference {
    part: Option<String>,
    object: u32,
    transform: Transform,
}

/// Instances of objects, from all parts that they come from.
struct Builder<'a> {
    package: Package<'a>,
    limits: &'a ReadLimits,
    parts: HashMap<String, Rc<Part>>,
    model: Model,
    /// Numbers in the model of the materials of a part.
    materials: HashMap<(String, Property), Option<usize>>,
    triangles: usize,
}

impl Builder<'_> {
    fn build(&mut self, root: &str) -> Result<(), ReadError> {
        let said = self.load(root)?;
        let unit = Transform::scaling(said.mm);
        for item in &said.items {
            let part = item.part.as_deref().unwrap_or(root);
            self.instance(part, item.object, &item.transform.then(&unit), None, 0)?;
        }
        Ok(())
    }

    fn load(&mut self, part: &str) -> Result<Rc<Part>, ReadError> {
        if let Some(known) = self.parts.get(part) {
            return Ok(Rc::clone(known));
        }
        let limits = self.limits;
        let read =
            Rc::new(self.package.read(part, |source| PartReader::read(part, source, limits))?);
        self.parts.insert(part.to_owned(), Rc::clone(&read));
        Ok(read)
    }

    /// Adds the bodies of an object.
    /// `outer` is the material that the objects around it have.
    fn instance(
        &mut self,
        part: &str,
        number: u32,
        transform: &Transform,
        outer: Option<usize>,
        depth: usize,
    ) -> Result<(), ReadError> {
        let wrong = |what: String| ReadError::Part { part: part.to_owned(), byte: 0, what };
        if depth > DEEPEST {
            return Err(wrong(format!(
                "object {number} is made of itself, or of objects {DEEPEST} deep"
            )));
        }
        let said = self.load(part)?;
        let object = said.objects.get(&number);
        let object = object.ok_or_else(|| wrong(format!("there is no object {number}")))?;
        if !object.is_model {
            return Ok(());
        }
        let own = object.property;
        if let Content::Components(components) = &object.content {
            let outer = self.material(part, own)?.or(outer);
            for component in components {
                let other = component.part.as_deref().unwrap_or(part);
                let transform = component.transform.then(transform);
                self.instance(other, component.object, &transform, outer, depth + 1)?;
                // Components without triangles cost time too, and there can be 2^32 of them.
                self.count(1)?;
            }
            return Ok(());
        }
        let Content::Mesh { vertices, triangles, paint, properties } = &object.content else {
            unreachable!("it is not made of components")
        };
        if triangles.is_empty() {
            return Ok(());
        }
        let name = object.name.clone();
        let mut mesh = Mesh::new(vertices.clone(), triangles.clone())
            .map_err(|source| ReadError::Mesh { body: named(&name, number), source })?;
        self.count(mesh.triangles().len())?;
        transform.apply(&mut mesh);
        let sides = mesh.bounds().size_mm();
        if !mesh.is_finite() || !sides.iter().all(|side| side.is_finite()) {
            return Err(wrong(format!(
                "the transform of object {number} leads to coordinates beyond all numbers"
            )));
        }
        let material = self.material(part, own)?.or(outer);
        let of_property = properties
            .iter()
            .map(|&property| Ok(self.material(part, property)?.or(material)))
            .collect::<Result<Vec<_>, ReadError>>()?;
        let mut body = Body { name, mesh, material, paint: Vec::new() };
        let used: Vec<Option<usize>> =
            paint.iter().map(|&at| of_property[usize::from(at)]).collect();
        if let Some(&first) = used.first() {
            if used.iter().all(|&other| other == first) {
                body.material = first;
            } else {
                // Triangles that are not painted have the material of the body, or the first paint
                // if it has none.
                let rest = used.iter().flatten().next().copied().unwrap_or_default();
                body.paint = used.iter().map(|material| material.unwrap_or(rest) as u8).collect();
            }
        }
        self.model.bodies.push(body);
        Ok(())
    }

    fn count(&mut self, triangles: usize) -> Result<(), ReadError> {
        self.triangles += triangles;
        if self.triangles > self.limits.triangles {
            return Err(ReadError::TooLarge {
                most: self.limits.triangles as u64,
                what: "triangles",
            });
        }
        Ok(())
    }

    /// The number in the model of a material of a part; `None` also for textures and other groups
    /// that are no materials.
    fn material(
        &mut self,
        part: &str,
        property: Option<Property>,
    ) -> Result<Option<usize>, ReadError> {
        let Some(property @ (group, index)) = property else { return Ok(None) };
        let key = (part.to_owned(), property);
        if let Some(&known) = self.materials.get(&key) {
            return Ok(known);
        }
        let number = match self.parts[part].groups.get(&group) {
            None => None,
            Some(group) => {
                let material = group.get(index as usize).ok_or_else(|| ReadError::Part {
                    part: part.to_owned(),
                    byte: 0,
                    what: format!("group {} has no material {index}", property.0),
                })?;
                if self.model.materials.len() == MOST_MATERIALS {
                    return Err(ReadError::TooLarge {
                        most: MOST_MATERIALS as u64,
                        what: "materials",
                    });
                }
                self.model.materials.push(material.clone());
                Some(self.model.materials.len() - 1)
            }
        };
        self.materials.insert(key, number);
        Ok(number)
    }
}

fn named(name: &str, number: u32) -> String {
    if name.is_empty() { number.to_string() } else { name.to_owned() }
}

/// Reads a part from top to bottom, element by element.
struct PartReader {
    part: Part,
    object: Option<(u32, Object)>,
    in_mesh: bool,
    group: Option<u32>,
    /// Where in the object's `properties` they stand.
    property_numbers: HashMap<Property, usize>,
    triangles: usize,
    most: usize,
}

impl PartReader {
    fn read(part: &str, source: &mut dyn BufRead, limits: &ReadLimits) -> Result<Part, ReadError> {
        let mut reader = Self {
            part: Part { mm: 1.0, ..Part::default() },
            object: None,
            in_mesh: false,
            group: None,
            property_numbers: HashMap::new(),
            triangles: 0,
            most: limits.triangles,
        };
        let mut is_model = false;
        each_element(part, source, |element, is_empty| match element {
            Element::Open(start) => {
                is_model |= start.local_name().as_ref() == "model";
                reader.open(start)?;
                if is_empty {
                    reader.close(start.local_name().as_ref());
                }
                Ok(())
            }
            Element::Close(name) => {
                reader.close(name);
                Ok(())
            }
        })?;
        if reader.triangles > reader.most {
            return Err(ReadError::TooLarge { most: reader.most as u64, what: "triangles" });
        }
        if !is_model {
            return Err(ReadError::Part {
                part: part.to_owned(),
                byte: 0,
                what: "it is no 3MF model".into(),
            });
        }
        Ok(reader.part)
    }

    fn open(&mut self, start: &BytesStart<'_>) -> Result<(), String> {
        match (start.local_name().as_ref(), &mut self.object) {
            ("vertex", Some((_, Object { content: Content::Mesh { vertices, .. }, .. })))
                if self.in_mesh =>
            {
                vertices.push(vertex(start)?);
            }
            ("triangle", Some((_, object))) if self.in_mesh => {
                self.triangles += 1;
                if self.triangles <= self.most {
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
                let number = integer(start, "id")?.ok_or("an object without id")?;
                let property = integer(start, "pid")?
                    .map(|group| Ok((group, integer(start, "pindex")?.unwrap_or(0))));
                let kind = attribute(start, "type")?;
                self.property_numbers.clear();
                self.object = Some((
                    number,
                    Object {
                        // Every instance has a copy.
                        name: attribute(start, "name")?.map_or_else(String::new, |name| {
                            name.chars().take(LONGEST_NAME).collect()
                        }),
                        is_model: kind.is_none_or(|kind| kind == "model" || kind == "solidsupport"),
                        property: property.transpose().map_err(|error: String| error)?,
                        content: Content::Mesh {
                            vertices: Vec::new(),
                            triangles: Vec::new(),
                            paint: Vec::new(),
                            properties: vec![None],
                        },
                    },
                ));
            }
            ("item", None) => self.part.items.push(reference(start)?),
            ("basematerials" | "colorgroup", None) => {
                let number = integer(start, "id")?.ok_or("a group of materials without id")?;
                self.part.groups.insert(number, Vec::new());
                self.group = Some(number);
            }
            ("base" | "color", None) => {
                if let Some(group) = self.group.and_then(|number| self.part.groups.get_mut(&number))
                {
                    let shown = attribute(start, "displaycolor")?.or(attribute(start, "color")?);
                    let name = attribute(start, "name")?.or(shown.clone()).map(Cow::into_owned);
                    group.push(Material {
                        name: name.unwrap_or_default(),
                        colour: shown.and_then(|text| colour(&text)),
                    });
                }
            }
            ("model", None) => {
                if let Some(unit) = attribute(start, "unit")? {
                    self.part.mm =
                        unit_mm(&unit).ok_or_else(|| format!("unknown unit {unit:?}"))?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn close(&mut self, name: &str) {
        match name {
            "mesh" => self.in_mesh = false,
            "object" => {
                if let Some((number, mut object)) = self.object.take() {
                    if let Content::Mesh { vertices, triangles, .. } = &mut object.content {
                        keep_used(vertices, triangles);
                    }
                    self.part.objects.insert(number, object);
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

fn vertex(start: &BytesStart<'_>) -> Result<[f64; 3], String> {
    let mut point = [None; 3];
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        let axis = match attribute.key.as_ref() {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => continue,
        };
        point[axis] = Some(number(attribute.value.trim())?);
    }
    match point {
        [Some(x), Some(y), Some(z)] => Ok([x, y, z]),
        _ => Err("a vertex of less than 3 coordinates".into()),
    }
}

fn add_triangle(
    start: &BytesStart<'_>,
    object: &mut Object,
    numbers: &mut HashMap<Property, usize>,
) -> Result<(), String> {
    let mut corners = [None; 3];
    let (mut group, mut index) = (None, None);
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        let target = match attribute.key.as_ref() {
            "v1" => &mut corners[0],
            "v2" => &mut corners[1],
            "v3" => &mut corners[2],
            "pid" => &mut group,
            "p1" => &mut index,
            _ => continue,
        };
        let value: u32 = attribute
            .value
            .trim()
            .parse()
            .map_err(|_| format!("{:?} is no index", attribute.value))?;
        *target = Some(value);
    }
    let [Some(a), Some(b), Some(c)] = corners else {
        return Err("a triangle of less than 3 vertices".into());
    };
    let own = object.property.map(|(group, _)| group);
    let Content::Mesh { triangles, paint, properties, .. } = &mut object.content else {
        return Ok(());
    };
    triangles.push([a, b, c]);
    // An index alone belongs to the group of the object.
    let property = group.or(own).and_then(|group| Some((group, index?)));
    let number = match property {
        None => 0,
        Some(property) => {
            let next = properties.len();
            let number = *numbers.entry(property).or_insert(next);
            if number == next {
                properties.push(Some(property));
            }
            u16::try_from(number).map_err(|_| "more than 65,535 materials on one object")?
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

fn reference(start: &BytesStart<'_>) -> Result<Reference, String> {
    let object = integer(start, "objectid")?.ok_or("a reference without objectid")?;
    let mut part = None;
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        // `p:path` of the production extension, whatever its prefix.
        if attribute.key.local_name().as_ref() == "path" {
            part = Some(attribute.value.into_owned());
        }
    }
    let transform = match attribute(start, "transform")? {
        None => Transform::IDENTITY,
        Some(text) => {
            let values =
                text.split_ascii_whitespace().map(number).collect::<Result<Vec<_>, _>>()?;
            let count = values.len();
            let values =
                values.try_into().map_err(|_| format!("a transform of {count} numbers, not 12"))?;
            Transform::from_rows(values)
        }
    };
    Ok(Reference { part, object, transform })
}

/// Colours are `#RRGGBB` or `#RRGGBBAA`.
fn colour(text: &str) -> Option<[u8; 3]> {
    let digits = text
        .strip_prefix('#')
        .filter(|digits| matches!(digits.len(), 6 | 8) && digits.is_ascii())?;
    let channel = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).ok();
    Some([channel(0)?, channel(2)?, channel(4)?])
}

fn attribute<'a>(start: &'a BytesStart<'_>, name: &str) -> Result<Option<Cow<'a, str>>, String> {
    let found = start.try_get_attribute(name).map_err(|error| error.to_string())?;
    let Some(found) = found else { return Ok(None) };
    found.normalized_value(XmlVersion::Explicit1_0).map(Some).map_err(|error| error.to_string())
}

fn integer(start: &BytesStart<'_>, name: &str) -> Result<Option<u32>, String> {
    let Some(text) = attribute(start, name)? else { return Ok(None) };
    text.trim().parse().map(Some).map_err(|_| format!("{name} is {text:?}, not a whole number"))
}

/// An element's beginning or end.
enum Element<'a> {
    Open(&'a BytesStart<'a>),
    Close(&'a str),
}

/// Shows `visit` all elements in their order, and whether they end where they begin; tells where it
/// found fault.
fn each_element(
    part: &str,
    source: &mut dyn BufRead,
    mut visit: impl FnMut(Element<'_>, bool) -> Result<(), String>,
) -> Result<(), ReadError> {
    let mut reader = Reader::from_reader(source);
    let mut buffer = Vec::new();
    let mut depth = 0_u32;
    loop {
        buffer.clear();
        let wrong = |byte: u64, what: String| ReadError::Part { part: part.to_owned(), byte, what };
        let event = match reader.read_event_into(&mut buffer) {
            Ok(event) => event,
            Err(error) => return Err(wrong(reader.error_position(), error.to_string())),
        };
        let result = match &event {
            Event::Start(start) => {
                depth += 1;
                visit(Element::Open(start), false)
            }
            Event::Empty(start) => visit(Element::Open(start), true),
            Event::End(end) => {
                depth = depth.saturating_sub(1);
                visit(Element::Close(end.local_name().as_ref()), false)
            }
            Event::Eof if depth > 0 => Err("the XML ends within an element".into()),
            Event::Eof => return Ok(()),
            _ => Ok(()),
        };
        result.map_err(|what| wrong(reader.buffer_position(), what))?;
    }
}

#[cfg(test)]
mod tests;
