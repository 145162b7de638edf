//! Turns the objects of all documents of an archive into the bodies of a model.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::rc::Rc;

use beadwork_base::Control;
use ndarray::Array2;

use super::archive::Archive;
use super::document::{Content, Document, Item, Object, Reference};
use super::mesh::Surface;
use super::notes::Notes;
use super::parts::{part_of, parts};
use super::project::{PartRole, PartSettings, Project};
use super::properties::{self, Property};
use crate::mesh::Mesh;
use crate::model::{Body, Material, Model, Role};
use crate::read::error::{ReadError, ReadLimits};
use crate::transform::Transform;

/// Maximum nesting of components: deeper than any program writes.
/// It also catches objects that contain themselves.
const MAX_DEPTH: usize = 32;

/// A mesh of the file: the entry of its document, the id of its object, and its first triangle.
type MeshId = (String, u32, usize);

/// Turns the objects of all documents into bodies.
pub(super) struct Builder<'a> {
    archive: Archive<'a>,
    limits: &'a ReadLimits,
    control: &'a Control<'a>,
    project: Project,
    notes: Notes,
    /// Documents by the name of their entry.
    documents: HashMap<String, Rc<Document>>,
    model: Model,
    /// Indices into the model's materials, by entry and property.
    materials: HashMap<(String, Property), Option<usize>>,
    /// The filament of each of the model's materials that is one.
    filament_of: Vec<Option<u32>>,
    /// Numbers of meshes, for copies.
    meshes: HashMap<MeshId, usize>,
    /// Whether any document is painted with filaments.
    is_painted: bool,
    /// Triangles and components so far.
    triangles: usize,
}

/// Where an object is reached from the build.
struct Place<'a> {
    /// The document of the object.
    entry: &'a str,
    id: u32,
    transform: Transform,
    /// The material of the objects that contain it.
    outer: Option<usize>,
    /// Ids of the objects that contain it, the outermost first.
    path: Vec<u32>,
}

impl<'a> Builder<'a> {
    pub(super) fn new(
        archive: Archive<'a>,
        project: Project,
        limits: &'a ReadLimits,
        control: &'a Control<'a>,
    ) -> Self {
        Self {
            archive,
            limits,
            control,
            project,
            notes: Notes::default(),
            documents: HashMap::new(),
            model: Model::default(),
            materials: HashMap::new(),
            filament_of: Vec::new(),
            meshes: HashMap::new(),
            is_painted: false,
            triangles: 0,
        }
    }

    /// Adds everything that the build of the root document lists.
    pub(super) fn build(mut self, root: &str) -> Result<Model, ReadError> {
        let document = self.document(root)?;
        let items = match &document.items {
            Some(items) if !items.is_empty() => items,
            _ => return Err(ReadError::entry(root, self.empty_build(&document))),
        };
        let printed = self.printed_items(&document, items);
        if printed.is_empty() {
            let message = "build has no printable items: all are marked printable=\"0\"";
            return Err(ReadError::entry(root, message.into()));
        }
        let unit = Transform::scaling(document.unit_mm);
        for item in printed {
            let Reference { entry, object, transform } = &item.reference;
            let entry = entry.as_deref().unwrap_or(root);
            let transform = self.unit_of(entry, &document)?.then(transform).then(&unit);
            let (outer, path) = (None, Vec::new());
            let place = Place { entry, id: *object, transform, outer, path };
            self.add_object(root, &place)?;
            self.number_object();
        }
        self.finish();
        Ok(self.model)
    }

    /// Why there is nothing to print.
    fn empty_build(&self, document: &Document) -> String {
        let sliced = "Metadata/plate_1.gcode";
        if self.archive.contains(sliced) {
            return format!("build is empty: the file holds the G-code of a print ({sliced})");
        }
        match document.objects.len() {
            0 => "build is empty: it lists no objects to print".into(),
            1 => "build is empty: the file has an object, but does not list it for printing".into(),
            count => {
                format!("build is empty: the file has {count} objects, but lists none for printing")
            }
        }
    }

    /// The items to print: those that are printable, on the first plate that has any.
    fn printed_items<'d>(&mut self, document: &Document, items: &'d [Item]) -> Vec<&'d Item> {
        let name = |item: &Item| {
            let id = item.reference.object;
            let named = document.objects.get(&id).map(|object| object.name.clone());
            let settings = self.project.objects.get(&id).map(|object| object.name.clone());
            let name = named.filter(|name| !name.is_empty()).or(settings).unwrap_or_default();
            if name.is_empty() { format!("object {id}") } else { name }
        };
        let mut instances = HashMap::new();
        let mut printed = Vec::new();
        for item in items {
            let count: &mut u32 = instances.entry(item.reference.object).or_default();
            let instance = (item.reference.object, *count);
            *count += 1;
            if item.is_printable {
                printed.push((instance, item));
            } else {
                self.notes.ignored_of("objects that are marked printable=\"0\"", &name(item));
            }
        }
        let all: HashSet<_> = printed.iter().map(|(instance, _)| *instance).collect();
        let plates = self.project.plates.iter();
        let mut plates: Vec<_> = plates
            .filter(|plate| plate.instances.iter().any(|instance| all.contains(instance)))
            .collect();
        plates.sort_by_key(|plate| plate.number);
        // Plates lie beside each other and are printed one after another.
        if let [first, _, ..] = plates[..] {
            let chosen: HashSet<_> = first.instances.iter().copied().collect();
            let number = first.number;
            let what = format!("objects that are not on plate {number}, the first one");
            for (_, item) in printed.iter().filter(|(instance, _)| !chosen.contains(instance)) {
                self.notes.ignored_of(&what, &name(item));
            }
            printed.retain(|(instance, _)| chosen.contains(instance));
        }
        printed.into_iter().map(|(_, item)| item).collect()
    }

    /// The document of an entry, which is read if it has not been yet.
    fn document(&mut self, entry: &str) -> Result<Rc<Document>, ReadError> {
        if let Some(known) = self.documents.get(entry) {
            return Ok(Rc::clone(known));
        }
        let limits = self.limits;
        let document =
            Rc::new(self.archive.read(entry, |source| Document::read(entry, source, limits))?);
        self.notes.append(&document.notes);
        self.is_painted |= document.is_painted;
        self.documents.insert(entry.to_owned(), Rc::clone(&document));
        Ok(document)
    }

    /// Converts the unit of the document of an entry to that of another document.
    fn unit_of(&mut self, entry: &str, to: &Document) -> Result<Transform, ReadError> {
        Ok(Transform::scaling(self.document(entry)?.unit_mm / to.unit_mm))
    }

    /// Adds the bodies of an object.
    fn add_object(&mut self, root: &str, place: &Place<'_>) -> Result<(), ReadError> {
        self.control.check()?;
        let Place { entry, id, .. } = *place;
        if place.path.len() > MAX_DEPTH {
            let message = format!(
                "object {id} contains itself, or nests components more than {MAX_DEPTH} deep"
            );
            return Err(ReadError::entry(entry, message));
        }
        let document = self.document(entry)?;
        let object = document.objects.get(&id);
        let object =
            object.ok_or_else(|| ReadError::entry(entry, format!("object {id} does not exist")))?;
        if let Some(refusal) = &object.refusal {
            return Err(ReadError::entry(entry, format!("object {id} {refusal}")));
        }
        let components = match &object.content {
            Content::Mesh(surface) => {
                if surface.triangles.is_empty() {
                    return self.skip_empty(object, place);
                }
                return self.add_mesh(object, surface, place);
            }
            Content::Components(components) => components,
        };
        let outer = self.material(entry, object.property)?.or(place.outer);
        let mut path = place.path.clone();
        path.push(id);
        for component in components {
            let other = component.entry.as_deref().unwrap_or(entry);
            // Production extension, section 2.
            if other != entry && entry != root {
                let message = format!(
                    "object {id} refers to {other}: only objects of {root} may refer to other \
                     documents"
                );
                return Err(ReadError::entry(entry, message));
            }
            let transform = self.unit_of(other, &document)?;
            let transform = transform.then(&component.transform).then(&place.transform);
            let id = component.object;
            let inner = Place { entry: other, id, transform, outer, path: path.clone() };
            self.add_object(root, &inner)?;
            // Components without triangles take time too, and nesting can multiply them to 2^32.
            self.count(1)?;
        }
        Ok(())
    }

    /// An object without triangles.
    fn skip_empty(&mut self, object: &Object, place: &Place<'_>) -> Result<(), ReadError> {
        let name = name_of(object, place.id);
        match &object.extension {
            None => {
                self.notes.ignored_of("objects without triangles", &name);
                Ok(())
            }
            Some(extension) => {
                let id = place.id;
                let message = format!(
                    "object {id} has no triangles, but data of the {extension}, which is not \
                     supported"
                );
                Err(ReadError::entry(place.entry, message))
            }
        }
    }

    /// Adds the bodies of an object that is a mesh: one for each part.
    fn add_mesh(
        &mut self,
        object: &Object,
        surface: &Surface,
        place: &Place<'_>,
    ) -> Result<(), ReadError> {
        let mut ids = place.path.iter().chain([&place.id]);
        let settings = ids.find_map(|id| self.project.objects.get(id));
        let of_project = settings.map_or("", |settings| &settings.name);
        let name = if object.name.is_empty() { of_project } else { &object.name }.to_owned();
        let (parts, is_stated) = parts(settings, surface, place.id, &place.path)
            .map_err(|message| ReadError::entry(place.entry, message))?;
        // The roles of a project decide before the type of the object: Bambu Studio writes all
        // parts that are not solid as "other".
        if let Some(kind) = object.auxiliary.filter(|_| !is_stated) {
            let what = format!("objects of type {kind}");
            self.notes.ignored_of(&what, &name_of(object, place.id));
            return Ok(());
        }
        for (triangles, mut part) in parts {
            if part.name.is_empty() {
                part.name.clone_from(&name);
            }
            self.add_part(object, surface, place, triangles, &part)?;
        }
        Ok(())
    }

    /// Adds a range of the triangles of a mesh as a body.
    fn add_part(
        &mut self,
        object: &Object,
        surface: &Surface,
        place: &Place<'_>,
        triangles: Range<usize>,
        part: &PartSettings,
    ) -> Result<(), ReadError> {
        let name = part.name.clone();
        let shown = if name.is_empty() { format!("object {}", place.id) } else { name.clone() };
        let role = match part.role {
            PartRole::Solid => Role::Solid,
            PartRole::Negative => Role::Negative,
            PartRole::Modifier if part.filament.is_some() => Role::Modifier,
            PartRole::Modifier => {
                self.notes.ignored_of("modifiers that do not change the filament", &shown);
                return Ok(());
            }
            PartRole::Support => {
                self.notes.ignored_of("support enforcers and blockers", &shown);
                return Ok(());
            }
        };
        if triangles.is_empty() {
            return Ok(());
        }
        let first = triangles.start;
        let mesh = self.instance(place, &shown, surface, triangles.clone())?;
        let mut body = Body { name, mesh, role, ..Body::default() };
        if role != Role::Negative {
            self.set_material(&mut body, object, surface, place, triangles, part)?;
        }
        let next = self.meshes.len();
        let id = (place.entry.to_owned(), place.id, first);
        body.copy_of = Some(*self.meshes.entry(id).or_insert(next));
        // All bodies of one item are one object; the number is set when the item is complete.
        body.object = usize::MAX;
        self.model.bodies.push(body);
        Ok(())
    }

    /// Gives a body its material or its paint.
    fn set_material(
        &mut self,
        body: &mut Body,
        object: &Object,
        surface: &Surface,
        place: &Place<'_>,
        triangles: Range<usize>,
        part: &PartSettings,
    ) -> Result<(), ReadError> {
        let stated = match part.filament {
            Some(filament) => Some(self.filament(filament)?),
            None => None,
        };
        if stated.is_some() && (object.property.is_some() || surface.properties.len() > 1) {
            self.notes.ignored("materials of objects for which the project states a filament");
        }
        body.material = match stated {
            Some(filament) => Some(filament),
            None => self.material(place.entry, object.property)?.or(place.outer),
        };
        if body.role == Role::Modifier {
            return Ok(());
        }
        // The material of each property.
        let mut of_property = Vec::with_capacity(surface.properties.len());
        for &property in &surface.properties {
            let own = match stated {
                Some(_) => None,
                None => self.material(place.entry, property)?,
            };
            of_property.push(own.or(body.material));
        }
        // The material of each filament that the triangles are painted with.
        let mut of_filament = [None; Model::MAX_MATERIALS];
        let painted = surface.filaments.get(triangles.clone()).unwrap_or_default();
        for &filament in painted.iter().filter(|filament| **filament != 0) {
            if of_filament[usize::from(filament)].is_none() {
                of_filament[usize::from(filament)] = Some(self.filament(filament.into())?);
            }
        }
        if of_filament.iter().any(Option::is_some) {
            // What is not painted is printed with the filament of the part.
            let default = if of_property.iter().any(Option::is_none) {
                Some(self.filament(self.default_filament())?)
            } else {
                None
            };
            of_property.iter_mut().for_each(|material| *material = material.or(default));
        }
        if surface.filaments.is_empty() && surface.paint.is_empty() {
            body.material = of_property[0];
            return Ok(());
        }
        let is_complete = paint_body(body, triangles, |triangle| {
            let filament = surface.filaments.get(triangle).copied().unwrap_or_default();
            let property = surface.paint.get(triangle).copied().unwrap_or_default();
            of_filament[usize::from(filament)].or(of_property[usize::from(property)])
        });
        if !is_complete {
            let what = "triangles without a material, in objects where others have one";
            self.notes.approximated(what, "they have the first one");
        }
        Ok(())
    }

    /// A transformed copy of a range of triangles.
    fn instance(
        &mut self,
        place: &Place<'_>,
        name: &str,
        surface: &Surface,
        range: Range<usize>,
    ) -> Result<Mesh, ReadError> {
        let is_whole = range.len() == surface.triangles.len();
        let triangles = &surface.triangles[range];
        self.count(triangles.len())?;
        let (vertices, triangles) = if is_whole {
            (surface.vertices.clone(), triangles.to_vec())
        } else {
            part_of(&surface.vertices, triangles)
        };
        let mut mesh = Mesh::new(vertices, triangles).map_err(|error| {
            let body = name.strip_prefix("object ").unwrap_or(name).to_owned();
            ReadError::Mesh { body, error }
        })?;
        place.transform.apply(&mut mesh);
        let sides = mesh.bounds().size_mm();
        if !mesh.is_finite() || !sides.iter().all(|side| side.is_finite()) {
            let id = place.id;
            let message = format!("transform of object {id} makes coordinates that are not finite");
            return Err(ReadError::entry(place.entry, message));
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
        let Some(property) = property else { return Ok(None) };
        let key = (entry.to_owned(), property);
        if let Some(&known) = self.materials.get(&key) {
            return Ok(known);
        }
        let document = self.document(entry)?;
        let material = properties::material(&document.groups, property, &mut self.notes)
            .map_err(|message| ReadError::entry(entry, message))?;
        let number = match material {
            Some(material) => Some(self.add_material(material, None)?),
            None => None,
        };
        self.materials.insert(key, number);
        Ok(number)
    }

    /// The index in the model of a filament, which is added if it is new.
    fn filament(&mut self, number: u32) -> Result<usize, ReadError> {
        if let Some(known) = self.filament_of.iter().position(|of| *of == Some(number)) {
            return Ok(known);
        }
        let filament = self.project.filaments.get(number as usize - 1);
        let filament = filament.cloned().unwrap_or_default();
        let name = match &filament.kind[..] {
            "" => format!("filament {number}"),
            kind => format!("filament {number} ({kind})"),
        };
        self.add_material(Material { name, colour: filament.colour }, Some(number))
    }

    /// The index of a material, which is added if there is no equal one.
    fn add_material(
        &mut self,
        material: Material,
        filament: Option<u32>,
    ) -> Result<usize, ReadError> {
        let mut known = self.model.materials.iter().zip(&self.filament_of);
        if let Some(found) = known.position(|(other, of)| *other == material && *of == filament) {
            return Ok(found);
        }
        if self.model.materials.len() == Model::MAX_MATERIALS {
            return Err(ReadError::too_large(Model::MAX_MATERIALS, "materials"));
        }
        self.model.materials.push(material);
        self.filament_of.push(filament);
        Ok(self.model.materials.len() - 1)
    }

    fn default_filament(&self) -> u32 {
        self.project.default_filament.max(1)
    }

    /// Numbers the bodies that were added for one item.
    fn number_object(&mut self) {
        let added = self.model.bodies.iter().rposition(|body| body.object != usize::MAX);
        let added = added.map_or(0, |last| last + 1);
        let next = match added {
            0 => 0,
            _ => self.model.bodies[added - 1].object + 1,
        };
        self.model.bodies[added..].iter_mut().for_each(|body| body.object = next);
    }

    /// Completes the model when all bodies are known.
    fn finish(&mut self) {
        let is_project = self.project.is_stated || self.is_painted;
        let is_open = |body: &Body| {
            body.material.is_none() && body.paint.is_empty() && body.role == Role::Solid
        };
        if is_project && self.model.bodies.iter().any(is_open) {
            // If the file has the maximum of materials, bodies without one get their own later.
            if let Ok(default) = self.filament(self.default_filament()) {
                let open = self.model.bodies.iter_mut().filter(|body| is_open(body));
                open.for_each(|body| body.material = Some(default));
            }
        }
        let mut counts = vec![0; self.meshes.len()];
        for body in &self.model.bodies {
            body.copy_of.into_iter().for_each(|mesh| counts[mesh] += 1);
        }
        for body in &mut self.model.bodies {
            body.copy_of = body.copy_of.filter(|&mesh| counts[mesh] > 1);
        }
        self.sort_filaments();
        self.set_purge();
        self.notes.append(&self.project.notes);
        self.model.warnings = std::mem::take(&mut self.notes).into_warnings();
    }

    /// Puts filaments into the order of their numbers, after other materials.
    fn sort_filaments(&mut self) {
        let mut order: Vec<usize> = (0..self.filament_of.len()).collect();
        order.sort_by_key(|&material| self.filament_of[material]);
        let mut new_of = vec![0; order.len()];
        order.iter().enumerate().for_each(|(new, &old)| new_of[old] = new);
        self.model.materials =
            order.iter().map(|&material| self.model.materials[material].clone()).collect();
        self.filament_of = order.iter().map(|&material| self.filament_of[material]).collect();
        for body in &mut self.model.bodies {
            body.material = body.material.map(|material| new_of[material]);
            body.paint.iter_mut().for_each(|paint| *paint = new_of[usize::from(*paint)] as u8);
        }
    }

    /// Takes the purge volumes of the project, if all materials are filaments for which it states
    /// them.
    fn set_purge(&mut self) {
        let Some(purge) = &self.project.purge_mm3 else { return };
        let count = self.filament_of.len();
        let rows: Vec<usize> = self
            .filament_of
            .iter()
            .filter_map(|filament| filament.map(|number| number as usize - 1))
            .filter(|&row| row < purge.nrows())
            .collect();
        if count == 0 || rows.len() < count {
            let what = "purge volumes of the project, which does not state them for all materials";
            self.notes.ignored(what);
            return;
        }
        let volume = |(from, to): (usize, usize)| purge[[rows[from], rows[to]]];
        self.model.purge_mm3 = Some(Array2::from_shape_fn((count, count), volume));
    }
}

/// The name of an object, for messages.
fn name_of(object: &Object, id: u32) -> String {
    if object.name.is_empty() { format!("object {id}") } else { object.name.clone() }
}

/// Gives a body the materials of a range of triangles; `used` returns that of each of them.
/// Returns whether all triangles have a material, or none.
fn paint_body(
    body: &mut Body,
    triangles: Range<usize>,
    used: impl Fn(usize) -> Option<usize> + Copy,
) -> bool {
    let first = used(triangles.start);
    if triangles.clone().all(|triangle| used(triangle) == first) {
        body.material = first;
        true
    } else {
        // Triangles without paint have the material of the body.
        // If it has none either, they get the first paint.
        let fallback = triangles.clone().find_map(used).unwrap_or_default();
        let materials = triangles.clone().map(|triangle| used(triangle).unwrap_or(fallback) as u8);
        body.paint = materials.collect();
        triangles.map(used).all(|material| material.is_some())
    }
}
