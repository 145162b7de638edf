//! The mesh of an object, with the properties and the paint of its triangles.

use std::collections::HashMap;

use super::namespace::Namespace;
use super::notes::Notes;
use super::painting::{Node, decode};
use super::properties::Property;
use super::subdivision::{Trees, divide};
use super::xml::Tag;
use crate::mesh::drop_unused_vertices;
use crate::model::Model;
use crate::read::text::{number, shown};

/// The mesh of an object.
pub(super) struct Surface {
    pub(super) vertices: Vec<[f64; 3]>,
    /// Triangles; painted facets of the file may be several.
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each triangle an index into `properties`; empty if all are 0.
    pub(super) paint: Vec<u16>,
    /// The properties that triangles have; the first one is `None`.
    pub(super) properties: Vec<Option<Property>>,
    /// For each triangle the filament that it is painted with, or 0; empty if all are 0.
    pub(super) filaments: Vec<u8>,
    /// For each facet of the file its first triangle, and the number of triangles at the end.
    /// Empty if facets are triangles.
    pub(super) first_of_facet: Vec<u32>,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            vertices: Vec::new(),
            triangles: Vec::new(),
            paint: Vec::new(),
            properties: vec![None],
            filaments: Vec::new(),
            first_of_facet: Vec::new(),
        }
    }
}

impl Surface {
    /// Number of facets in the file.
    pub(super) fn facet_count(&self) -> usize {
        match self.first_of_facet.len() {
            0 => self.triangles.len(),
            count => count - 1,
        }
    }

    /// The first triangle of a facet of the file, or the number of triangles if there is none.
    pub(super) fn first_triangle(&self, facet: usize) -> usize {
        match self.first_of_facet.get(facet) {
            Some(&first) => first as usize,
            None => facet.min(self.triangles.len()),
        }
    }
}

/// Reads the vertices and triangles of one object.
#[derive(Default)]
pub(super) struct MeshReader {
    /// Indices into the `properties` of the surface.
    numbers: HashMap<Property, usize>,
    /// The facets that are painted in part.
    trees: Trees,
    /// Whether any triangle is painted with a filament.
    pub(super) is_painted: bool,
}

impl MeshReader {
    /// Adds a triangle; `group` is the group of properties of the object.
    pub(super) fn triangle(
        &mut self,
        tag: &Tag<'_>,
        surface: &mut Surface,
        group: Option<u32>,
        notes: &mut Notes,
    ) -> Result<(), String> {
        let mut corners = [None; 3];
        let (mut own_group, mut indices) = (None, [None; 3]);
        let number = surface.triangles.len();
        tag.each_attribute(|name, value| {
            let target = match name.as_bytes() {
                [b'v', b'1'] => &mut corners[0],
                [b'v', b'2'] => &mut corners[1],
                [b'v', b'3'] => &mut corners[2],
                [b'p', b'1'] => &mut indices[0],
                [b'p', b'2'] => &mut indices[1],
                [b'p', b'3'] => &mut indices[2],
                b"pid" => &mut own_group,
                b"paint_color" => return self.paint(value, number, &mut surface.filaments),
                _ => {
                    let (prefix, local) = name.split_once(':').unwrap_or(("", name));
                    let is_slic3r = tag.scope.namespace(prefix) == Namespace::Slic3r;
                    if is_slic3r && local == "mmu_segmentation" {
                        return self.paint(value, number, &mut surface.filaments);
                    }
                    note_attribute(tag, name, "attributes of triangles", notes);
                    return Ok(());
                }
            };
            let number: u32 = value.trim().parse().map_err(|_| {
                format!("{name} of a triangle is '{}', expected an integer", shown(value))
            })?;
            *target = Some(number);
            Ok(())
        })?;
        let [Some(a), Some(b), Some(c)] = corners else {
            return Err("triangle must have v1, v2 and v3".into());
        };
        surface.triangles.push([a, b, c]);
        if !surface.filaments.is_empty() {
            surface.filaments.resize(number + 1, 0);
        }
        if let [Some(first), Some(second), Some(third)] = indices
            && (first != second || first != third)
        {
            notes.approximated("colour gradients", "the first corner of each triangle counts");
        }
        // An index without a group refers to the group of the object.
        let property = own_group.or(group).and_then(|group| Some((group, indices[0]?)));
        self.add_property(property, surface)
    }

    /// The property of the triangle that was added last.
    fn add_property(
        &mut self,
        property: Option<Property>,
        surface: &mut Surface,
    ) -> Result<(), String> {
        let number = match property {
            None => 0,
            Some(property) => {
                let next = surface.properties.len();
                let number = *self.numbers.entry(property).or_insert(next);
                if number == next {
                    surface.properties.push(Some(property));
                }
                u16::try_from(number).map_err(|_| "object has more than 65,535 materials")?
            }
        };
        if number != 0 && surface.paint.is_empty() {
            surface.paint.resize(surface.triangles.len() - 1, 0);
        }
        if number != 0 || !surface.paint.is_empty() {
            surface.paint.push(number);
        }
        Ok(())
    }

    /// Paints the triangle with a number.
    fn paint(&mut self, text: &str, number: usize, filaments: &mut Vec<u8>) -> Result<(), String> {
        let text = text.trim();
        if text.is_empty() {
            return Ok(());
        }
        let (mut whole, mut is_split) = (0, false);
        decode(text, |node| {
            match node {
                Node::Split(_) => is_split = true,
                Node::Leaf(state) if state as usize > Model::MAX_MATERIALS - 1 => {
                    let max = Model::MAX_MATERIALS - 1;
                    return Err(format!(
                        "triangle is painted with filament {state}, maximum is {max}"
                    ));
                }
                Node::Leaf(state) => whole = whole.max(state),
            }
            Ok(())
        })?;
        self.is_painted |= whole > 0;
        if is_split {
            self.trees.push(number as u32, text);
        } else if whole > 0 {
            filaments.resize(number + 1, 0);
            filaments[number] = whole as u8;
        }
        Ok(())
    }

    /// Divides the facets that are painted in part.
    /// Returns false if there are more than `max_triangles` then.
    pub(super) fn finish(self, surface: &mut Surface, max_triangles: usize) -> bool {
        if !self.trees.is_empty() {
            let Surface { vertices, triangles, filaments, .. } = surface;
            let Ok(divided) = divide(vertices, triangles, filaments, &self.trees, max_triangles)
            else {
                return false;
            };
            if !surface.paint.is_empty() {
                let of_facets = surface.paint.iter().zip(divided.first_of.windows(2));
                surface.paint = of_facets
                    .flat_map(|(&paint, ends)| (ends[0]..ends[1]).map(move |_| paint))
                    .collect();
            }
            surface.triangles = divided.triangles;
            surface.filaments = divided.states;
            surface.first_of_facet = divided.first_of;
        }
        drop_unused_vertices(&mut surface.vertices, &mut surface.triangles);
        true
    }
}

/// Reads a vertex.
pub(super) fn vertex(tag: &Tag<'_>, notes: &mut Notes) -> Result<[f64; 3], String> {
    let mut point = [None; 3];
    tag.each_attribute(|name, value| {
        // Patterns of bytes are compared without a call, which counts here.
        let axis = match name.as_bytes() {
            [b'x'] => 0,
            [b'y'] => 1,
            [b'z'] => 2,
            _ => {
                note_attribute(tag, name, "attributes of vertices", notes);
                return Ok(());
            }
        };
        point[axis] = Some(number(value.trim())?);
        Ok(())
    })?;
    match point {
        [Some(x), Some(y), Some(z)] => Ok([x, y, z]),
        _ => Err("vertex must have x, y and z".into()),
    }
}

/// Notes an attribute of a vertex or a triangle that is not used; `elements` names them all.
fn note_attribute(tag: &Tag<'_>, name: &str, elements: &str, notes: &mut Notes) {
    let (prefix, local) = name.split_once(':').unwrap_or(("", name));
    match tag.scope.namespace(prefix) {
        Namespace::Core
            if matches!(local, "paint_supports" | "paint_seam" | "paint_fuzzy_skin") =>
        {
            notes.ignored("painted supports, seams and fuzzy skin");
        }
        Namespace::Slic3r => notes.ignored("painted supports, seams and fuzzy skin"),
        Namespace::Core | Namespace::Other if prefix.is_empty() && name != "xmlns" => {
            notes.ignored_of(elements, local);
        }
        Namespace::Other => {
            notes.ignored(&format!("data of the {}", tag.scope.extension(prefix)));
        }
        _ => {}
    }
}
