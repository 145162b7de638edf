//! Layers of beads: walls in their order, then the lines of the infill in any.

mod pieces;
mod row_order;
mod timing;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use beadwork_part::{Bead, BeadLayer, Frame, TurnedBead, turn_beads};
use beadwork_thermal::DepositionEvent;
use beadwork_thermal::program::path_visits;
use ndarray::Array3;

use self::pieces::Pieces;
pub use self::row_order::{RowOrder, Strips};
pub use self::timing::BeadTiming;
use super::{Draft, Fill, LineSet};

/// The beads of each layer of a part.
///
/// A path lists beads of the layer by their numbers: all that are not infill come first, in the
/// order in which they were given; then those of the infill, which are cut so that each has one
/// line, with the link before it.
/// So a path has the moves of the given layer, each of them once; lines that follow one another
/// stay linked.
///
/// A bead deposits the cells that it visits first in the given order, in any other order, too.
#[derive(Clone, Debug)]
pub struct Beads {
    layers: Vec<Arc<Layer>>,
    timing: BeadTiming,
    frame: Frame,
}

/// A layer of beads.
#[derive(Debug)]
struct Layer {
    pieces: Pieces,
    /// What each of them deposits, and when.
    events: Vec<Vec<DepositionEvent>>,
    /// The cells of each of them.
    cells: Vec<Vec<Cell>>,
    voxels: usize,
}

impl Beads {
    /// The beads of some layers, on a grid of cells as wide as a bead.
    ///
    /// Layers are numbered from 0; numbers that are missing have no beads.
    /// Linear in the length of all beads in cells and in the number of cells, but for the sorting
    /// of rows.
    pub fn new(layers: &[BeadLayer], frame: Frame, timing: BeadTiming) -> Self {
        let depth = layers.iter().map(|layer| layer.number + 1).max().unwrap_or(0);
        let mut beads: Vec<&[Bead]> = vec![&[]; depth];
        for layer in layers {
            beads[layer.number] = &layer.beads;
        }
        let layers = beads
            .iter()
            .enumerate()
            .map(|(number, beads)| Arc::new(Layer::new(number, beads, &frame, &timing)))
            .collect();
        Self { layers, timing, frame }
    }

    /// The part that the beads deposit.
    pub fn voxels(&self) -> Voxels {
        let (width, height) = (self.frame.width as usize, self.frame.height as usize);
        let mut materials = Array3::from_elem((self.layers.len(), height, width), Voxels::EMPTY);
        for (z, layer) in self.layers.iter().enumerate() {
            for cell in layer.cells.iter().flatten().map(|&cell| cell as usize) {
                materials[[z, cell / width, cell % width]] = 0;
            }
        }
        Voxels::new(self.frame, materials)
    }

    /// The beads of a path; those that follow one another without travel are one.
    ///
    /// # Panics
    /// If the path is one of another layer.
    pub fn beads(&self, layer: u32, path: &[TurnedBead]) -> Vec<Bead> {
        self.layers[layer as usize].pieces.join(path)
    }
}

impl Layer {
    fn new(number: usize, beads: &[Bead], frame: &Frame, timing: &BeadTiming) -> Self {
        let pieces = Pieces::of(beads);
        let mut events = vec![Vec::new(); pieces.beads.len()];
        let mut cells = vec![Vec::new(); pieces.beads.len()];
        let mut seen = vec![false; frame.width as usize * frame.height as usize];
        for turned in &pieces.listed {
            let piece = turned.bead as usize;
            let bead = turned.of(&pieces.beads);
            for visit in path_visits(timing.lines(&bead, number), frame) {
                let [voxel, pause] = [visit.cell, None].map(|cell| DepositionEvent {
                    voxel: cell.map(|[x, y]| [x, y, number as u32]),
                    seconds: visit.seconds,
                });
                let cell = visit.cell.map(|[x, y]| y * frame.width + x);
                let cell = cell.filter(|&cell| !std::mem::replace(&mut seen[cell as usize], true));
                events[piece].push(if cell.is_some() { voxel } else { pause });
                cells[piece].extend(cell);
            }
            if turned.is_reversed {
                events[piece].reverse();
            }
        }
        let voxels = cells.iter().map(Vec::len).sum();
        Self { pieces, events, cells, voxels }
    }

    fn ends(&self, turned: TurnedBead) -> [[f64; 2]; 2] {
        let bead = &self.pieces.beads[turned.bead as usize];
        let [start, end] = [bead.start_mm, bead.end_mm()];
        if turned.is_reversed { [end, start] } else { [start, end] }
    }

    /// The beads that stay in their order.
    fn fixed(&self) -> impl Iterator<Item = TurnedBead> {
        (0..self.pieces.fixed as u32).map(|bead| TurnedBead { bead, is_reversed: false })
    }

    /// Where the nozzle is before the infill, if it comes from `from`.
    fn after_fixed(&self, from: Option<[f64; 2]>) -> Option<[f64; 2]> {
        self.fixed().last().map(|last| self.ends(last)[1]).or(from)
    }

    /// The beads in a named order.
    fn named(&self, name: RowOrder, from: Option<[f64; 2]>) -> Vec<TurnedBead> {
        match name {
            RowOrder::Listed => self.pieces.listed.clone(),
            RowOrder::Strips(strips) => self.in_strips(strips, from),
        }
    }

    /// The rows of all directions in the given order.
    fn in_strips(&self, strips: Strips, from: Option<[f64; 2]>) -> Vec<TurnedBead> {
        let mut path: Vec<TurnedBead> = self.fixed().collect();
        let (mut nozzle, mut first) = (self.after_fixed(from), self.pieces.fixed as u32);
        for rows in &self.pieces.directions {
            let ordered = rows.row_order(&strips.order(rows.row_count()), nozzle);
            path.extend(ordered.into_iter().map(|at| TurnedBead { bead: first + at.bead, ..at }));
            nozzle = path.last().map(|&last| self.ends(last)[1]);
            first += rows.beads().len() as u32;
        }
        path
    }
}

impl Fill for Beads {
    type Path = Vec<TurnedBead>;
    type Name = RowOrder;
    type Position = [f64; 2];
    type Lines = BeadLines;

    fn layer_count(&self) -> usize {
        self.layers.len()
    }

    fn voxel_count(&self, layer: u32) -> usize {
        self.layers[layer as usize].voxels
    }

    /// The beads as they were given.
    fn conventional(&self, layer: u32) -> Draft<Vec<TurnedBead>, RowOrder> {
        self.named(layer, RowOrder::Listed)
    }

    fn named(&self, layer: u32, name: RowOrder) -> Draft<Vec<TurnedBead>, RowOrder> {
        Draft { path: self.layers[layer as usize].named(name, None), name: Some(name) }
    }

    fn lines(&self, layer: u32, name: Option<RowOrder>) -> BeadLines {
        let name = name.unwrap_or(RowOrder::Listed);
        BeadLines { layer: self.layers[layer as usize].clone(), name }
    }

    fn all_lines(&self, layer: u32) -> Vec<BeadLines> {
        vec![self.lines(layer, None)]
    }

    fn ends(&self, layer: u32, path: &Vec<TurnedBead>) -> Option<[[f64; 2]; 2]> {
        let layer = &self.layers[layer as usize];
        let [begin, _] = layer.ends(*path.first()?);
        let [_, end] = layer.ends(*path.last()?);
        Some([begin, end])
    }

    fn travel_seconds(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        self.timing.travel_s(from, to)
    }

    fn events(
        &self,
        layer: u32,
        from: Option<[f64; 2]>,
        path: &Vec<TurnedBead>,
    ) -> Vec<DepositionEvent> {
        let layer = &self.layers[layer as usize];
        let mut events = Vec::with_capacity(layer.voxels + path.len());
        let mut nozzle = from;
        for &turned in path {
            let [begin, end] = layer.ends(turned);
            let travel_s = nozzle.map_or(0.0, |from| self.timing.travel_s(from, begin));
            if travel_s > 0.0 {
                events.push(DepositionEvent::pause(travel_s));
            }
            let own = &layer.events[turned.bead as usize];
            if turned.is_reversed {
                events.extend(own.iter().rev());
            } else {
                events.extend(own);
            }
            nozzle = Some(end);
        }
        events
    }
}

/// The lines of the infill of a layer of beads.
#[derive(Clone, Debug)]
pub struct BeadLines {
    layer: Arc<Layer>,
    name: RowOrder,
}

impl BeadLines {
    /// Number of the bead of a line.
    fn bead(&self, line: usize) -> usize {
        self.layer.pieces.fixed + line
    }
}

impl LineSet for BeadLines {
    type Path = Vec<TurnedBead>;
    type Position = [f64; 2];

    fn count(&self) -> usize {
        self.layer.pieces.beads.len() - self.layer.pieces.fixed
    }

    fn cells(&self, line: usize) -> &[Cell] {
        &self.layer.cells[self.bead(line)]
    }

    fn seconds(&self, line: usize) -> f64 {
        self.layer.events[self.bead(line)].iter().map(|event| event.seconds).sum()
    }

    fn start(&self, from: Option<[f64; 2]>) -> Vec<usize> {
        let fixed = self.layer.pieces.fixed;
        let path = self.layer.named(self.name, from);
        path.iter().filter_map(|turned| (turned.bead as usize).checked_sub(fixed)).collect()
    }

    fn path(&self, lines: &[usize], from: Option<[f64; 2]>) -> Vec<TurnedBead> {
        let mut path: Vec<TurnedBead> = self.layer.fixed().collect();
        path.extend(self.rest(lines, self.layer.after_fixed(from)));
        path
    }

    fn rest(&self, lines: &[usize], from: Option<[f64; 2]>) -> Vec<TurnedBead> {
        let order = lines.iter().map(|&line| self.bead(line));
        turn_beads(&self.layer.pieces.beads, order, from)
    }
}
