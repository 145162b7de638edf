//! Fills the outlines of bodies with the cells of a grid.

use beadwork_grid::{Region, Zones};
use beadwork_mesh::Role;

use super::body_cut::{BodyCut, BodyMaterial};
use super::layers::Layer;
use super::plane_sweep::plane_mm;
use super::raster::for_each_run;
use super::rectangle::Rectangle;
use super::settings::Settings;
use super::surface_colours::{Faces, propagate};
use super::surface_columns::SurfaceColumns;
use crate::frame::Frame;

/// Bodies, and the grid that they are filled with.
pub(super) struct Filler<'a> {
    settings: &'a Settings,
    frame: &'a Frame,
    /// Bodies, and the colours of those that are painted.
    bodies: Vec<(&'a BodyCut, Option<SurfaceColumns>)>,
}

/// Layers that are empty between objects, so that each object does not need new ones.
#[derive(Default)]
struct Scratch {
    /// The cells of the object.
    object: Vec<u8>,
    /// The cells of one of its modifiers.
    changed: Vec<u8>,
}

impl<'a> Filler<'a> {
    pub(super) fn new(bodies: &'a [BodyCut], settings: &'a Settings, frame: &'a Frame) -> Self {
        let columns = |body: &BodyCut| {
            let (mesh, colours) = body.painted.as_ref()?;
            Some(SurfaceColumns::new(mesh, colours, frame))
        };
        let bodies = bodies.iter().map(|body| (body, columns(body))).collect();
        Self { settings, frame, bodies }
    }

    /// The cells of one layer: objects are filled in order, each over those before it.
    pub(super) fn layer(&self, number: usize) -> Option<Layer> {
        let (width, height) = (self.frame.width as usize, self.frame.height as usize);
        let mut materials = vec![Zones::OUTSIDE; width * height];
        let mut scratch = Scratch::default();
        for bodies in self.bodies.chunk_by(|(a, _), (b, _)| a.object == b.object) {
            if bodies.iter().all(|(body, _)| body.role == Role::Solid) {
                bodies.iter().for_each(|body| self.fill(body, number, &mut materials));
            } else {
                // The others affect only this object, which therefore is filled separately.
                scratch.object.resize(width * height, Zones::OUTSIDE);
                scratch.changed.resize(width * height, Zones::OUTSIDE);
                self.fill_object(bodies, number, &mut scratch, &mut materials);
            }
        }
        let inside = materials.iter().map(|&material| material != Zones::OUTSIDE).collect();
        let region = Region::from_mask(self.frame.width, self.frame.height, inside).ok()?;
        let zones = Zones::new(&region, materials).expect("every cell has a material");
        Some(Layer { region, zones })
    }

    /// Fills a layer of an object that has modifiers or negative bodies.
    /// They apply after all solid bodies, wherever they are in the list.
    ///
    /// Takes time for the cells that the object reaches, not for the whole layer: there may be many
    /// small objects on a large grid.
    fn fill_object(
        &self,
        bodies: &[(&BodyCut, Option<SurfaceColumns>)],
        number: usize,
        Scratch { object, changed }: &mut Scratch,
        materials: &mut [u8],
    ) {
        let with_role = |role| bodies.iter().filter(move |(body, _)| body.role == role);
        let outlines = |role| with_role(role).filter_map(|(body, _)| body.layer(number));
        if outlines(Role::Solid).next().is_none() {
            return;
        }
        // What modifiers reach beyond the solid bodies has to be cleared, too.
        let filled = outlines(Role::Solid).chain(outlines(Role::Modifier));
        let corners = filled.flat_map(|outline| outline.loops().flatten().copied());
        let Some(rectangle) = Rectangle::around(corners, self.frame) else { return };
        let width = self.frame.width as usize;
        let in_row =
            |row: usize| row * width + rectangle.columns.start..row * width + rectangle.columns.end;

        with_role(Role::Solid).for_each(|body| self.fill(body, number, object));
        for body in with_role(Role::Modifier) {
            self.fill(body, number, changed);
            for cells in rectangle.rows.clone().map(in_row) {
                for (cell, to) in object[cells.clone()].iter_mut().zip(&mut changed[cells]) {
                    let to = std::mem::replace(to, Zones::OUTSIDE);
                    if *cell != Zones::OUTSIDE && to != Zones::OUTSIDE {
                        *cell = to;
                    }
                }
            }
        }
        for outline in outlines(Role::Negative) {
            for_each_run(outline, self.settings.fill_rule, self.frame, |row, first, end| {
                let row = row as usize * width;
                object[row + first as usize..row + end as usize].fill(Zones::OUTSIDE);
            });
        }
        for cells in rectangle.rows.clone().map(in_row) {
            for (cell, of) in materials[cells.clone()].iter_mut().zip(&mut object[cells]) {
                let of = std::mem::replace(of, Zones::OUTSIDE);
                if of != Zones::OUTSIDE {
                    *cell = of;
                }
            }
        }
    }

    /// Writes the material of a body into the cells that it covers in a layer.
    fn fill(
        &self,
        (body, columns): &(&BodyCut, Option<SurfaceColumns>),
        number: usize,
        materials: &mut [u8],
    ) {
        let Self { settings, frame, .. } = self;
        let Some(outline) = body.layer(number) else { return };
        match (body.material, columns) {
            (BodyMaterial::One(material), _) => {
                for_each_run(outline, settings.fill_rule, frame, |row, first, end| {
                    let row = row as usize * frame.width as usize;
                    materials[row + first as usize..row + end as usize].fill(material);
                });
            }
            (BodyMaterial::FromSurface, Some(columns)) => {
                let z_mm = plane_mm(number, frame.layer_mm);
                let faces = Faces { columns, z_mm, depth_mm: settings.colour_depth_mm };
                propagate(outline, &faces, settings.fill_rule, frame, materials);
            }
            _ => {}
        }
    }
}
