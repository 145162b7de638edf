//! 3MF files: all objects that are to be printed, with transforms, units and materials.
//!
//! A 3MF file is a ZIP archive of XML documents.
//! The root document lists the **build items**: objects to print.
//! An **object** is a mesh, or is composed of **components**, other objects with a transform; each
//! mesh that is reached from the build items becomes a body, once for every path to it.
//!
//! Supported are the core specification 1.3, colour groups of the materials extension, and
//! references to other documents of the production extension.
//! Content of other extensions is ignored.

mod archive;
mod document;
mod xml;

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::BufRead;
use std::rc::Rc;

use beadwork_base::Control;

use self::archive::Archive;
use self::document::{Content, Document, Object, Property};
use self::xml::{Element, attribute, each_element};
use super::error::{ReadError, ReadLimits};
use crate::mesh::Mesh;
use crate::model::{Body, Model};
use crate::transform::Transform;

/// The entry that names the root document.
const RELATIONSHIPS: &str = "_rels/.rels";
/// The root document if that entry is missing or does not name one.
const DEFAULT_ROOT: &str = "3D/3dmodel.model";
/// Maximum nesting of components: deeper than any program writes.
/// It also catches objects that contain themselves.
const MAX_DEPTH: usize = 32;

pub(super) fn read(
    bytes: &[u8],
    limits: &ReadLimits,
    control: &Control<'_>,
) -> Result<Model, ReadError> {
    let mut archive = Archive::open(bytes, limits, control)?;
    let root = if archive.contains(RELATIONSHIPS) {
        archive.read(RELATIONSHIPS, |source| root_entry(RELATIONSHIPS, source))?
    } else {
        None
    };
    let mut builder = Builder {
        archive,
        limits,
        control,
        documents: HashMap::new(),
        model: Model::default(),
        materials: HashMap::new(),
        triangles: 0,
    };
    builder.build(root.as_deref().unwrap_or(DEFAULT_ROOT))?;
    Ok(builder.model)
}

/// The target of the relationship that names the root document.
fn root_entry(entry: &str, source: &mut dyn BufRead) -> Result<Option<String>, ReadError> {
    let mut found = None;
    each_element(entry, source, |element| {
        if let Element::Start(start) = element
            && start.local_name().as_ref() == "Relationship"
            && attribute(start, "Type")?.is_some_and(|kind| kind.ends_with("/3dmodel"))
        {
            found = found.take().or(attribute(start, "Target")?.map(Cow::into_owned));
        }
        Ok(())
    })?;
    Ok(found)
}

/// Turns the objects of all documents into bodies.
struct Builder<'a> {
    archive: Archive<'a>,
    limits: &'a ReadLimits,
    control: &'a Control<'a>,
    /// Documents by the name of their entry.
    documents: HashMap<String, Rc<Document>>,
    model: Model,
    /// Indices into the model's materials, by entry and property.
    materials: HashMap<(String, Property), Option<usize>>,
    /// Triangles and components so far.
    triangles: usize,
}

impl Builder<'_> {
    fn build(&mut self, root: &str) -> Result<(), ReadError> {
        let document = self.document(root)?;
        let unit = Transform::scaling(document.unit_mm);
        for item in &document.items {
            let entry = item.entry.as_deref().unwrap_or(root);
            self.add_object(entry, item.object, &item.transform.then(&unit), None, 0)?;
        }
        Ok(())
    }

    /// The document of an entry, which is read if it has not been yet.
    fn document(&mut self, entry: &str) -> Result<Rc<Document>, ReadError> {
        if let Some(known) = self.documents.get(entry) {
            return Ok(Rc::clone(known));
        }
        let limits = self.limits;
        let document =
            Rc::new(self.archive.read(entry, |source| Document::read(entry, source, limits))?);
        self.documents.insert(entry.to_owned(), Rc::clone(&document));
        Ok(document)
    }

    /// Adds the bodies of an object.
    /// `outer` is the material of the objects that contain it.
    fn add_object(
        &mut self,
        entry: &str,
        id: u32,
        transform: &Transform,
        outer: Option<usize>,
        depth: usize,
    ) -> Result<(), ReadError> {
        self.control.check()?;
        if depth > MAX_DEPTH {
            let message = format!(
                "object {id} contains itself, or nests components more than {MAX_DEPTH} deep"
            );
            return Err(entry_error(entry, message));
        }
        let document = self.document(entry)?;
        let object = document.objects.get(&id);
        let object =
            object.ok_or_else(|| entry_error(entry, format!("object {id} does not exist")))?;
        if !object.is_model {
            return Ok(());
        }
        match &object.content {
            Content::Components(components) => {
                let outer = self.material(entry, object.property)?.or(outer);
                for component in components {
                    let other = component.entry.as_deref().unwrap_or(entry);
                    let transform = component.transform.then(transform);
                    self.add_object(other, component.object, &transform, outer, depth + 1)?;
                    // Components without triangles take time too, and nesting can multiply them to
                    // 2^32.
                    self.count(1)?;
                }
                Ok(())
            }
            Content::Mesh { triangles, .. } if triangles.is_empty() => Ok(()),
            Content::Mesh { vertices, triangles, paint, properties } => {
                let mesh = self.instance(entry, id, object, vertices, triangles, transform)?;
                let material = self.material(entry, object.property)?.or(outer);
                let of_property = properties
                    .iter()
                    .map(|&property| Ok(self.material(entry, property)?.or(material)))
                    .collect::<Result<Vec<_>, ReadError>>()?;
                let name = object.name.clone();
                let mut body = Body { name, mesh, material, ..Body::default() };
                paint_body(&mut body, paint, &of_property);
                self.model.bodies.push(body);
                Ok(())
            }
        }
    }

    /// A transformed copy of the mesh of an object.
    fn instance(
        &mut self,
        entry: &str,
        id: u32,
        object: &Object,
        vertices: &[[f64; 3]],
        triangles: &[[u32; 3]],
        transform: &Transform,
    ) -> Result<Mesh, ReadError> {
        let mut mesh = Mesh::new(vertices.to_vec(), triangles.to_vec()).map_err(|source| {
            let body = if object.name.is_empty() { id.to_string() } else { object.name.clone() };
            ReadError::Mesh { body, source }
        })?;
        self.count(triangles.len())?;
        transform.apply(&mut mesh);
        let sides = mesh.bounds().size_mm();
        if !mesh.is_finite() || !sides.iter().all(|side| side.is_finite()) {
            let message = format!("transform of object {id} makes coordinates that are not finite");
            return Err(entry_error(entry, message));
        }
        Ok(mesh)
    }

    fn count(&mut self, triangles: usize) -> Result<(), ReadError> {
        self.triangles += triangles;
        if self.triangles > self.limits.triangles {
            return Err(ReadError::too_large(self.limits.triangles, "triangles"));
        }
        Ok(())
    }

    /// The index in the model of a material of a document, which is added if it is new.
    /// `None` for textures and other groups that are not materials.
    fn material(
        &mut self,
        entry: &str,
        property: Option<Property>,
    ) -> Result<Option<usize>, ReadError> {
        let Some(property @ (group_id, index)) = property else { return Ok(None) };
        let key = (entry.to_owned(), property);
        if let Some(&known) = self.materials.get(&key) {
            return Ok(known);
        }
        let number = match self.documents[entry].groups.get(&group_id) {
            None => None,
            Some(group) => {
                let material = group.get(index as usize).ok_or_else(|| {
                    entry_error(entry, format!("material group {group_id} has no entry {index}"))
                })?;
                if self.model.materials.len() == Model::MAX_MATERIALS {
                    return Err(ReadError::too_large(Model::MAX_MATERIALS, "materials"));
                }
                self.model.materials.push(material.clone());
                Some(self.model.materials.len() - 1)
            }
        };
        self.materials.insert(key, number);
        Ok(number)
    }
}

/// Gives a body its paint; `of_property` holds the material of every property.
fn paint_body(body: &mut Body, paint: &[u16], of_property: &[Option<usize>]) {
    let used: Vec<Option<usize>> =
        paint.iter().map(|&property| of_property[usize::from(property)]).collect();
    let Some(&first) = used.first() else { return };
    if used.iter().all(|&other| other == first) {
        body.material = first;
    } else {
        // Triangles without paint have the material of the body.
        // If it has none either, they get the first paint.
        let fallback = used.iter().flatten().next().copied().unwrap_or_default();
        body.paint = used.iter().map(|material| material.unwrap_or(fallback) as u8).collect();
    }
}

/// An error that concerns a whole document.
fn entry_error(entry: &str, message: String) -> ReadError {
    ReadError::Entry { entry: entry.to_owned(), byte: None, message }
}

#[cfg(test)]
mod tests;
