//! Fills the outlines of bodies with the cells of a grid.

use beadwork_grid::{Region, Zones};
use beadwork_mesh::Role;

use super::body_cut::{BodyCut, BodyMaterial};
use super::layers::Layer;
use super::plane_sweep::plane_mm;
use super::raster::for_each_run;
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
        for bodies in self.bodies.chunk_by(|(a, _), (b, _)| a.object == b.object) {
            if bodies.iter().all(|(body, _)| body.role == Role::Solid) {
                bodies.iter().for_each(|body| self.fill(body, number, &mut materials));
            } else {
                // The others affect only this object, which therefore is filled separately.
                let mut object = vec![Zones::OUTSIDE; width * height];
                self.fill_object(bodies, number, &mut object);
                let cells = materials.iter_mut().zip(object);
                cells.filter(|(_, of)| *of != Zones::OUTSIDE).for_each(|(cell, of)| *cell = of);
            }
        }
        let inside = materials.iter().map(|&material| material != Zones::OUTSIDE).collect();
        let region = Region::from_mask(self.frame.width, self.frame.height, inside).ok()?;
        let zones = Zones::new(&region, materials).expect("every cell has a material");
        Some(Layer { region, zones })
    }

    /// Fills a layer of an object that has modifiers or negative bodies, into an empty layer.
    /// They apply after all solid bodies, wherever they are in the list.
    fn fill_object(
        &self,
        bodies: &[(&BodyCut, Option<SurfaceColumns>)],
        number: usize,
        object: &mut [u8],
    ) {
        let with_role = |role| bodies.iter().filter(move |(body, _)| body.role == role);
        with_role(Role::Solid).for_each(|body| self.fill(body, number, object));
        for body in with_role(Role::Modifier) {
            let mut changed = vec![Zones::OUTSIDE; object.len()];
            self.fill(body, number, &mut changed);
            for (cell, to) in object.iter_mut().zip(changed) {
                if *cell != Zones::OUTSIDE && to != Zones::OUTSIDE {
                    *cell = to;
                }
            }
        }
        for outline in with_role(Role::Negative).filter_map(|(body, _)| body.layer(number)) {
            for_each_run(outline, self.settings.fill_rule, self.frame, |row, first, end| {
                let row = row as usize * self.frame.width as usize;
                object[row + first as usize..row + end as usize].fill(Zones::OUTSIDE);
            });
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
