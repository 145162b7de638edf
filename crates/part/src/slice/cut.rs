//! A model cut into outlines, and outlines filled with cells.

use std::ops::Range;

use beadwork_base::{Control, Interrupted};
use beadwork_grid::Zones;
use beadwork_mesh::{Body, Bounds, Model, Role};

use super::body_cut::{BodyCut, BodyMaterial};
use super::fill::Filler;
use super::grid_fit::fit;
use super::layers::Layers;
use super::plane_sweep::cut_between;
use super::settings::{Settings, SliceError};
use super::work::Work;
use crate::frame::Frame;

/// Cuts a model into layers of cells.
///
/// The bodies of the model must stand on z = 0 ([`beadwork_mesh::Placement`]), be closed
/// ([`Body::repair`]) and have materials ([`Model::assign_materials`]).
/// Where solid bodies overlap, the later one takes the cells.
/// Modifiers then change the material of the cells of their object, and negative bodies remove
/// cells of their object.
///
/// A layer exists if its centre height lies within the part; a cell belongs to it if the cell's
/// centre lies inside a body.
/// So the surface of the part is approximated to half a bead across and half a layer in height.
/// The grid is the smallest around the part with the phase of the settings.
///
/// Progress counts layers: those of each body as they are cut, and those of the part as they are
/// filled.
/// Time and memory are those of [`cut()`](super::cut()), and linear in the cells of all layers.
pub fn slice(
    model: &Model,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Layers, SliceError> {
    let plan = CutPlan::new(model, settings)?;
    let work = Work::new(control, plan.outline_count() + plan.layer_count);
    let cut = plan.run(&work)?;
    cut.fill(settings, &work)
}

/// A model cut into the outlines of its bodies in every layer.
///
/// The outlines depend on the model and the layer height only.
/// So one cut serves several cell grids: cutting is the expensive part of slicing, and
/// [`Cut::layers`] repeats only the rest.
///
/// # Example
/// The number of cells of a disc depends on the phase of the grid:
/// ```
/// use beadwork_base::Control;
/// use beadwork_mesh::{Body, Model, Solid};
/// use beadwork_part::slice::{Cut, Settings};
///
/// let outline_mm = (0..60).map(|i| f64::from(i).to_radians() * 6.0);
/// let outline_mm = outline_mm.map(|a| [5.1 * a.cos(), 5.1 * a.sin()]).collect();
/// let mesh = Solid::Prism { outline_mm, z_mm: [0.0, 1.0] }.mesh();
/// let body = Body { name: "disc".into(), mesh, material: Some(0), ..Body::default() };
/// let model = Model { bodies: vec![body], ..Model::default() };
///
/// let (settings, control) = (Settings::default(), Control::default());
/// let cut = Cut::new(&model, &settings, &control)?;
/// let cells = |phase| -> Result<u64, Box<dyn std::error::Error>> {
///     Ok(cut.layers(&Settings { phase, ..settings }, &control)?.cell_count())
/// };
/// assert_ne!(cells([0.0, 0.0])?, cells([0.5, 0.0])?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    bounds: Bounds,
    layer_mm: f64,
    bodies: Vec<BodyCut>,
}

impl Cut {
    /// Cuts a model, which must be as for [`slice()`].
    ///
    /// Only [`Settings::layer_mm`] affects the outlines.
    /// All settings are checked, so that settings that cannot be sliced with are refused before the
    /// work.
    /// Progress counts the layers of each body.
    pub fn new(
        model: &Model,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Self, SliceError> {
        let plan = CutPlan::new(model, settings)?;
        Ok(plan.run(&Work::new(control, plan.outline_count()))?)
    }

    /// The bodies, in the order of the model.
    pub(super) fn bodies(&self) -> &[BodyCut] {
        &self.bodies
    }

    /// The bounding box of the model.
    pub(super) fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Returns an error if the layer height of settings is not that of the cut.
    pub(super) fn check_layer_height(&self, settings: &Settings) -> Result<(), SliceError> {
        if settings.layer_mm.to_bits() == self.layer_mm.to_bits() {
            return Ok(());
        }
        Err(SliceError::LayerHeight { cut_mm: self.layer_mm, got_mm: settings.layer_mm })
    }

    /// The error of a part that no layer has anything of.
    pub(super) fn no_cells(&self, settings: &Settings) -> SliceError {
        let &Settings { cell_mm, layer_mm, .. } = settings;
        let has_negative = self.bodies.iter().any(|body| body.role == Role::Negative);
        SliceError::NoCells { cell_mm, layer_mm, has_negative }
    }

    /// Position of the part on the bed, and the cell grid that [`Cut::layers`] fills.
    pub fn frame(&self, settings: &Settings) -> Result<Frame, SliceError> {
        Ok(fit(&self.bounds, settings)?.0)
    }

    /// Fills the outlines with cells.
    ///
    /// The settings may differ from those of [`Cut::new`] in everything but the layer height; the
    /// result is that of [`slice()`] with these settings.
    /// Progress counts layers.
    /// Linear in the cells of all layers, and O(r log r) where r counts the rows of cells that each
    /// line of an outline crosses.
    pub fn layers(&self, settings: &Settings, control: &Control<'_>) -> Result<Layers, SliceError> {
        self.check_layer_height(settings)?;
        let (_, layer_count) = fit(&self.bounds, settings)?;
        self.fill(settings, &Work::new(control, layer_count))
    }

    fn fill(&self, settings: &Settings, work: &Work<'_>) -> Result<Layers, SliceError> {
        let (frame, layer_count) = fit(&self.bounds, settings)?;
        let filler = Filler::new(&self.bodies, settings, &frame);
        let layers = work
            .control()
            .threads
            .map_numbers(layer_count, |number| work.unit(|| filler.layer(number)));
        let layers = layers.into_iter().collect::<Result<Vec<_>, Interrupted>>()?;
        if layers.iter().all(Option::is_none) {
            return Err(self.no_cells(settings));
        }
        Ok(Layers { frame, layers })
    }
}

/// A checked model, ready to be cut.
struct CutPlan<'a> {
    bounds: Bounds,
    layer_mm: f64,
    /// Number of layers of the part.
    layer_count: usize,
    bodies: Vec<BodyPlan<'a>>,
}

struct BodyPlan<'a> {
    body: &'a Body,
    material: BodyMaterial,
    /// The layers that the body may reach.
    layers: Range<usize>,
}

impl<'a> CutPlan<'a> {
    fn new(model: &'a Model, settings: &Settings) -> Result<Self, SliceError> {
        let bounds = model.bounds();
        let layer_mm = settings.layer_mm;
        let (_, layer_count) = fit(&bounds, settings)?;
        let plan = |(number, body): (usize, &'a Body)| {
            let material = material(body).ok_or(SliceError::Material(number))?;
            let layers = reached_layers(&body.mesh.bounds(), layer_mm, layer_count);
            Ok(BodyPlan { body, material, layers })
        };
        let bodies =
            model.bodies.iter().enumerate().map(plan).collect::<Result<Vec<_>, SliceError>>()?;
        Ok(Self { bounds, layer_mm, layer_count, bodies })
    }

    /// Number of outlines to be cut: one for each layer that each body may reach.
    fn outline_count(&self) -> usize {
        self.bodies.iter().map(|body| body.layers.len()).sum()
    }

    fn run(&self, work: &Work<'_>) -> Result<Cut, Interrupted> {
        let cut_body = |plan: &BodyPlan<'_>| {
            let BodyPlan { body, material, layers } = plan;
            let (first, layer_mm) = (layers.start, self.layer_mm);
            let outlines = cut_between(&body.mesh, &body.paint, layer_mm, layers.clone(), work)?;
            let (role, object) = (body.role, body.object);
            let is_painted = *material == BodyMaterial::FromSurface;
            let painted = is_painted.then(|| (body.mesh.clone(), body.paint.clone()));
            Ok(BodyCut { role, object, material: *material, first, outlines, painted })
        };
        let bodies = self.bodies.iter().map(cut_body).collect::<Result<Vec<_>, Interrupted>>()?;
        Ok(Cut { bounds: self.bounds, layer_mm: self.layer_mm, bodies })
    }
}

/// What the cells of a body are made of, or `None` if it has no material that a zone can have.
fn material(body: &Body) -> Option<BodyMaterial> {
    let is_valid = |material: usize| material < Zones::MAX as usize;
    let material = body.material.filter(|&material| is_valid(material));
    if body.role == Role::Negative {
        return Some(BodyMaterial::None);
    }
    if body.paint.is_empty() {
        return Some(BodyMaterial::One(material? as u8));
    }
    let has_valid_colours = body.paint.iter().all(|&colour| is_valid(colour.into()));
    (material.is_some() || has_valid_colours).then_some(BodyMaterial::FromSurface)
}

/// The layers that a body may reach: one more at either end, because the quotients are rounded.
fn reached_layers(bounds: &Bounds, layer_mm: f64, layer_count: usize) -> Range<usize> {
    let layer = |z: f64, more: f64| (z / layer_mm + more).clamp(0.0, layer_count as f64) as usize;
    let range = layer(bounds.min[2], -2.0)..layer(bounds.max[2], 2.0);
    range.start.min(range.end)..range.end
}

#[cfg(test)]
mod tests;
