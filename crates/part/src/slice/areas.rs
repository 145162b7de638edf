//! The area of each material in every layer.

use beadwork_base::{Control, Interrupted};
use beadwork_mesh::Role;

use super::body_cut::{BodyCut, BodyMaterial};
use super::colour_areas::colour_areas;
use super::cut::Cut;
use super::grid_fit::fit;
use super::outline::Outline;
use super::plane_sweep::plane_mm;
use super::settings::{Settings, SliceError};
use super::surface_colours::Faces;
use super::surface_columns::SurfaceColumns;
use super::work::Work;
use crate::area::{Area, Ring};
use crate::frame::Frame;

/// Size in mm² below which pieces of an area are rounding errors of boolean operations.
const SLIVER_MM2: f64 = 1e-4;

/// Width in mm below which a hole is a slit.
const SLIT_MM: f64 = 0.02;

/// The area of each material in a layer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerAreas {
    /// The areas, none of them empty, by increasing number of the material.
    /// They do not overlap.
    pub areas: Vec<MaterialArea>,
}

/// The area of one material in a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialArea {
    /// The material, which is the number of the tool that prints it.
    pub material: u8,
    /// Its area.
    pub area: Area,
}

impl LayerAreas {
    /// Fills holes that are narrower than 0.02 mm on average.
    ///
    /// Surfaces that should touch leave such slits between them.
    /// They are far too narrow to be printed, but every bead beside them would keep its distance.
    pub fn fill_slits(&mut self) {
        for each in &mut self.areas {
            each.area = std::mem::take(&mut each.area).without_slits(SLIT_MM);
        }
    }

    /// The area of all materials together.
    pub fn union(&self) -> Area {
        Area::union_of(self.areas.iter().map(|each| each.area.clone()).collect())
    }
}

impl Cut {
    /// The area of each material in every layer, from the bottom up.
    ///
    /// Materials are assigned to points as [`Cut::layers`] assigns them to cell centres: objects in
    /// order, each over those before it; modifiers change the material of their object, and
    /// negative bodies remove from it.
    /// Areas that touch share their border to within rounding, a millionth of their extent; pieces
    /// below 0.0001 mm² are dropped.
    /// The area of a painted body ends at its outline, but inside it the borders between colours
    /// follow the cells of [`Cut::layers`].
    ///
    /// Only [`Settings::fill_rule`] affects bodies that are not painted.
    /// The layer height must be that of the cut.
    /// Progress counts layers.
    ///
    /// O(n log n) in the corners of the outlines, for each body that overlaps others again.
    ///
    /// # Errors
    /// As [`Cut::layers`]; [`SliceError::NoCells`] if all areas are empty.
    pub fn areas(
        &self,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Vec<LayerAreas>, SliceError> {
        self.check_layer_height(settings)?;
        let (frame, layer_count) = fit(self.bounds(), settings)?;
        let builder = Builder::new(self.bodies(), settings, &frame);
        let work = Work::new(control, layer_count);
        let layers =
            control.threads.map_numbers(layer_count, |number| work.unit(|| builder.layer(number)));
        let layers = layers.into_iter().collect::<Result<Vec<_>, Interrupted>>()?;
        if layers.iter().all(|layer| layer.areas.is_empty()) {
            return Err(self.no_cells(settings));
        }
        Ok(layers)
    }
}

/// Bodies, and the colours of those that are painted.
struct Builder<'a> {
    settings: &'a Settings,
    frame: &'a Frame,
    bodies: Vec<(&'a BodyCut, Option<SurfaceColumns>)>,
}

impl<'a> Builder<'a> {
    fn new(bodies: &'a [BodyCut], settings: &'a Settings, frame: &'a Frame) -> Self {
        let columns = |body: &BodyCut| {
            let (mesh, colours) = body.painted.as_ref()?;
            Some(SurfaceColumns::new(mesh, colours, frame))
        };
        let bodies = bodies.iter().map(|body| (body, columns(body))).collect();
        Self { settings, frame, bodies }
    }

    fn layer(&self, number: usize) -> LayerAreas {
        let mut layer = Stack::default();
        for bodies in self.bodies.chunk_by(|(a, _), (b, _)| a.object == b.object) {
            let with_role = |role| bodies.iter().filter(move |(body, _)| body.role == role);
            let solid = with_role(Role::Solid).flat_map(|body| self.body(body, number));
            if bodies.iter().all(|(body, _)| body.role == Role::Solid) {
                solid.for_each(|(material, area)| layer.push(material, area));
                continue;
            }
            let mut object = Stack::default();
            solid.for_each(|(material, area)| object.push(material, area));
            for (material, area) in
                with_role(Role::Modifier).flat_map(|body| self.body(body, number))
            {
                object.modify(material, &area);
            }
            for (body, _) in with_role(Role::Negative) {
                if let Some(outline) = body.layer(number) {
                    object.remove(&self.inside(outline));
                }
            }
            object.finish().into_iter().for_each(|(material, area)| layer.push(material, area));
        }
        let areas = layer.finish().into_iter().filter_map(|(material, area)| {
            let area = area.without_slivers(SLIVER_MM2);
            (!area.is_empty()).then_some(MaterialArea { material, area })
        });
        let mut areas: Vec<MaterialArea> = areas.collect();
        areas.sort_by_key(|each| each.material);
        LayerAreas { areas }
    }

    /// The materials of a body in a layer, and their areas.
    fn body(
        &self,
        (body, columns): &(&BodyCut, Option<SurfaceColumns>),
        number: usize,
    ) -> Vec<(u8, Area)> {
        let Some(outline) = body.layer(number) else { return Vec::new() };
        let area = self.inside(outline);
        match (body.material, columns) {
            (BodyMaterial::One(material), _) => vec![(material, area)],
            (BodyMaterial::FromSurface, Some(columns)) => {
                let z_mm = plane_mm(number, self.frame.layer_mm);
                let faces = Faces { columns, z_mm, depth_mm: self.settings.colour_depth_mm };
                colour_areas(outline, area, &faces, self.settings, self.frame)
            }
            _ => Vec::new(),
        }
    }

    fn inside(&self, outline: &Outline) -> Area {
        let rings: Vec<Ring> = outline.loops().map(<[_]>::to_vec).collect();
        Area::from_rings(&rings, self.settings.fill_rule)
    }
}

/// Areas of materials, each over those before it.
#[derive(Default)]
struct Stack {
    /// The materials so far; their areas do not overlap.
    areas: Vec<(u8, Area)>,
    /// The areas of the material on top, which are not united yet: one operation on many bodies is
    /// faster than one for each body.
    top: Option<(u8, Vec<Area>)>,
}

impl Stack {
    fn push(&mut self, material: u8, area: Area) {
        match &mut self.top {
            Some((top, areas)) if *top == material => areas.push(area),
            _ => {
                self.settle();
                self.top = Some((material, vec![area]));
            }
        }
    }

    /// Unites the areas on top, and removes them from those below.
    fn settle(&mut self) {
        let Some((material, areas)) = self.top.take() else { return };
        let area = Area::union_of(areas);
        let mut is_new = true;
        for (other, below) in &mut self.areas {
            if *other == material {
                *below = below.union(&area);
                is_new = false;
            } else {
                *below = below.difference(&area);
            }
        }
        if is_new {
            self.areas.push((material, area));
        }
    }

    /// Changes the material within an area.
    fn modify(&mut self, material: u8, area: &Area) {
        self.settle();
        let changed = self.areas.iter().map(|(_, below)| below.intersection(area)).collect();
        self.push(material, Area::union_of(changed));
        self.settle();
    }

    fn remove(&mut self, area: &Area) {
        self.settle();
        self.areas.iter_mut().for_each(|(_, below)| *below = below.difference(area));
    }

    fn finish(mut self) -> Vec<(u8, Area)> {
        self.settle();
        self.areas
    }
}

#[cfg(test)]
mod tests;
