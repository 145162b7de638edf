//! A model as layers of cells.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use beadwork_grid::{Region, Zones};
use rayon::ThreadPool;
use thiserror::Error;

use super::cutter::{cut_between, plane_mm};
use super::each::each;
use super::outline::{FillRule, Outline};
use super::paint::spread;
use super::raster::each_run;
use super::voxels::Voxels;
use crate::frame::Frame;
use beadwork_mesh::{Body, Model};

/// How to slice.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// Side of a cell in mm: the width of a bead.
    /// More than 0.
    pub cell_mm: f64,
    /// Height of a layer in mm.
    /// More than 0.
    pub layer_mm: f64,
    /// What lies within a body whose surface runs into itself.
    pub rule: FillRule,
    /// Most cells of all layers' planes together; two bytes each.
    /// A layer counts as no less than 64.
    pub most_cells: u64,
    /// Where to work; `None` for the calling thread alone.
    /// The result does not depend on it.
    pub pool: Option<&'a ThreadPool>,
    /// Stops the work soon after it turns true.
    pub cancel: Option<&'a AtomicBool>,
    /// Told after each layer.
    pub observer: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl Default for Settings<'_> {
    /// Beads of 0.5 mm in layers of 0.25 mm (*Kim et al. 2026*, section on the domain), up to 2^30
    /// cells, on one thread.
    fn default() -> Self {
        Self {
            cell_mm: 0.5,
            layer_mm: 0.25,
            rule: FillRule::default(),
            most_cells: 1 << 30,
            pool: None,
            cancel: None,
            observer: None,
        }
    }
}

/// How far slicing has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Layers done.
    pub done: usize,
    /// Layers in all.
    pub layers: usize,
}

/// One layer of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Its cells.
    pub region: Region,
    /// The material of each: the number of the tool that prints it.
    pub zones: Zones,
}

/// All layers of a part, from the bottom up, on one plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Where they lie.
    pub frame: Frame,
    /// The layers; `None` where a part has nothing at that height.
    pub layers: Vec<Option<Layer>>,
}

/// Why a model can't be sliced.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SliceError {
    /// A length makes no sense.
    #[error("{what} is {value} mm: it must be more than 0")]
    Length {
        /// Which.
        what: &'static str,
        /// Its value in mm.
        value: f64,
    },
    /// There would be too many cells a side.
    #[error("beads of {cell_mm} mm make a layer of {width:.0} x {height:.0} cells, more than {max} a side", max = Region::MAX_SIDE)]
    Side {
        /// Width of a bead.
        cell_mm: f64,
        /// Cells along x.
        width: f64,
        /// Cells along y.
        height: f64,
    },
    /// There would be too many cells in all.
    #[error("{layers:.0} layers of {width} x {height} cells are more than {most} cells")]
    Cells {
        /// Layers.
        layers: f64,
        /// Cells along x.
        width: u32,
        /// Cells along y.
        height: u32,
        /// The limit.
        most: u64,
    },
    /// A body has no material, or one beyond the last that there can be.
    #[error("body {0} has no material, or one numbered beyond {max}", max = Zones::MAX - 1)]
    Material(usize),
    /// No layer has a cell: the part is thinner than a bead everywhere.
    #[error(
        "no layer has a cell: the part is thinner than {cell_mm} mm or lower than {layer_mm} mm"
    )]
    NoCells {
        /// Width of a bead.
        cell_mm: f64,
        /// Height of a layer.
        layer_mm: f64,
    },
    /// It was stopped.
    #[error("cancelled")]
    Cancelled,
}

/// Cuts a model into layers of cells.
///
/// The bodies stand on z = 0 ([`beadwork_mesh::Placement`]), are closed ([`Body::repair`]) and have
/// materials ([`Model::assign`]); where they overlap, the later one fills the place.
/// A layer lies where its middle is within the part; a cell where its centre is: the surface of the
/// part is met to half a bead and half a layer.
/// The cells' plane is the smallest around the part, with the part in its middle.
///
/// Time and memory are those of [`cut()`](super::cut()), and beside it linear in the cells of all
/// planes.
pub fn slice(model: &Model, settings: &Settings<'_>) -> Result<Layers, SliceError> {
    let (frame, count) = frame(model, settings)?;
    let is_cancelled = || settings.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed));
    let mut outlines = Vec::with_capacity(model.bodies.len());
    for body in &model.bodies {
        if is_cancelled() {
            return Err(SliceError::Cancelled);
        }
        outlines.push(Cuts::new(body, settings, count));
    }
    let done = AtomicUsize::new(0);
    let layers = each(settings.pool, count, |number| {
        if is_cancelled() {
            return None;
        }
        let bodies = model.bodies.iter().zip(&outlines);
        let layer = fill(
            bodies.filter_map(|(body, cuts)| Some((body, cuts.layer(number)?))),
            settings.rule,
            &frame,
        );
        if let Some(observer) = settings.observer {
            observer(Progress { done: done.fetch_add(1, Ordering::Relaxed) + 1, layers: count });
        }
        layer
    });
    if is_cancelled() {
        return Err(SliceError::Cancelled);
    }
    if layers.iter().all(Option::is_none) {
        return Err(SliceError::NoCells { cell_mm: settings.cell_mm, layer_mm: settings.layer_mm });
    }
    Ok(Layers { frame, layers })
}

/// The outlines of a body in those layers that it reaches: of many small bodies, all layers' would
/// take more memory than all cells.
struct Cuts {
    first: usize,
    outlines: Vec<Outline>,
}

impl Cuts {
    fn new(body: &Body, settings: &Settings<'_>, layers: usize) -> Self {
        let bounds = body.mesh.bounds();
        // One more at either end, for the quotients are rounded.
        let layer =
            |z: f64, more: f64| (z / settings.layer_mm + more).clamp(0.0, layers as f64) as usize;
        let range = layer(bounds.least[2], -2.0)..layer(bounds.greatest[2], 2.0);
        let range = range.start.min(range.end)..range.end;
        let first = range.start;
        let outlines =
            cut_between(&body.mesh, &body.paint, settings.layer_mm, range, settings.pool);
        Self { first, outlines }
    }

    /// `None` in a layer without any.
    fn layer(&self, number: usize) -> Option<&Outline> {
        self.outlines.get(number.checked_sub(self.first)?).filter(|outline| !outline.is_empty())
    }
}

/// What a layer takes beside its cells, counted in cells.
const LEAST_PLANE: f64 = 64.0;

/// The plane of all layers, and how many there are.
fn frame(model: &Model, settings: &Settings<'_>) -> Result<(Frame, usize), SliceError> {
    let &Settings { cell_mm, layer_mm, most_cells, .. } = settings;
    for (what, value) in [("the bead width", cell_mm), ("the layer height", layer_mm)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(SliceError::Length { what, value });
        }
    }
    for (number, body) in model.bodies.iter().enumerate() {
        let is_right = |material: usize| material < Zones::MAX as usize;
        let filled = body.material.is_some_and(is_right);
        let painted =
            !body.paint.is_empty() && body.paint.iter().all(|&material| is_right(material.into()));
        if !filled && !painted {
            return Err(SliceError::Material(number));
        }
    }
    let bounds = model.bounds();
    let size = bounds.size_mm();
    if !size.iter().all(|&side| side > 0.0) {
        return Err(SliceError::NoCells { cell_mm, layer_mm });
    }
    // A side of whole cells stays so, whatever its rounding.
    let cells = |axis: usize| (size[axis] / cell_mm - 1e-6).ceil().max(1.0);
    let (width, height) = (cells(0), cells(1));
    if width.max(height) > f64::from(Region::MAX_SIDE) {
        return Err(SliceError::Side { cell_mm, width, height });
    }
    let layers = (bounds.greatest[2] / layer_mm - 0.5).ceil().max(0.0);
    if layers * (width * height).max(LEAST_PLANE) > most_cells as f64 {
        return Err(SliceError::Cells {
            layers,
            width: width as u32,
            height: height as u32,
            most: most_cells,
        });
    }
    let spare = |axis: usize, cells: f64| (cells * cell_mm - size[axis]) / 2.0;
    let frame = Frame {
        left_mm: bounds.least[0] - spare(0, width),
        back_mm: bounds.greatest[1] + spare(1, height),
        cell_mm,
        layer_mm,
        width: width as u32,
        height: height as u32,
    };
    Ok((frame, layers as usize))
}

/// The cells of one layer: those of one body after the other.
fn fill<'a>(
    bodies: impl Iterator<Item = (&'a Body, &'a Outline)>,
    rule: FillRule,
    frame: &Frame,
) -> Option<Layer> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let mut materials = vec![Zones::OUTSIDE; width * height];
    for (body, outline) in bodies {
        if body.paint.is_empty() {
            let material = body.material.expect("checked before") as u8;
            each_run(outline, rule, frame, |row, first, end| {
                let row = row as usize * width;
                materials[row + first as usize..row + end as usize].fill(material);
            });
        } else {
            spread(outline, rule, frame, &mut materials);
        }
    }
    let inside = materials.iter().map(|&material| material != Zones::OUTSIDE).collect();
    let region = Region::from_mask(frame.width, frame.height, inside).ok()?;
    let zones = Zones::new(&region, materials).expect("every cell has a material");
    Some(Layer { region, zones })
}

impl Layers {
    /// The cells of all layers as one array.
    pub fn voxels(&self) -> Voxels {
        let plane = self.frame.width as usize * self.frame.height as usize;
        let mut materials = Vec::with_capacity(plane * self.layers.len());
        for layer in &self.layers {
            match layer {
                Some(layer) => materials.extend_from_slice(layer.zones.ids()),
                None => materials.resize(materials.len() + plane, Voxels::EMPTY),
            }
        }
        Voxels::new(self.frame, self.layers.len(), materials)
    }

    /// Layers at the bottom that have no cells, as those of a tip have, where it is thinner than a
    /// bead.
    pub fn empty_below(&self) -> usize {
        self.layers.iter().take_while(|layer| layer.is_none()).count()
    }

    /// The lowest layer without cells that has some above and below it: what lies above hangs in
    /// the air.
    pub fn gap(&self) -> Option<usize> {
        let last = self.layers.iter().rposition(Option::is_some)?;
        (self.empty_below()..last).find(|&layer| self.layers[layer].is_none())
    }

    /// Height of the middle of a layer in mm: where it was cut.
    pub fn cut_mm(&self, layer: usize) -> f64 {
        plane_mm(layer, self.frame.layer_mm)
    }

    /// Cells of all layers.
    pub fn cell_count(&self) -> u64 {
        self.layers.iter().flatten().map(|layer| u64::from(layer.region.cell_count())).sum()
    }

    /// Number of tools: one more than the greatest number of a material.
    pub fn tools(&self) -> u32 {
        self.layers.iter().flatten().map(|layer| layer.zones.count()).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests;
