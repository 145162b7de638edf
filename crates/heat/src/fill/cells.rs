//! Layers of cells: a whole layer is a list of cells, each a bead wide.

use std::sync::Arc;

use beadwork_grid::{Cell, Region, RegionError};
use beadwork_part::slice::Voxels;
use beadwork_part::{Axis, Corner, Ends, Frame, LineOrder, Lines, Order, Sequence};
use beadwork_thermal::event::layer_events;
use beadwork_thermal::{DepositionEvent, ProcessParameters};
use thiserror::Error;

use super::{Draft, Fill, LineSet};

/// Lines to permute where an order has none.
const DEFAULT_LINES: LineOrder =
    LineOrder { sequence: Sequence::Golden, axis: Axis::X, corner: Corner::MinXMinY };

/// The cells of each layer of a part.
///
/// A path is a list of cells, each of which is deposited once; times are those of
/// [`layer_events`].
#[derive(Clone, Debug)]
pub struct Cells {
    /// The region of each layer; `None` for layers without cells.
    regions: Arc<[Option<Region>]>,
    frame: Frame,
    process: ProcessParameters,
}

/// The error of a layer that cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("layer {layer}: {source}")]
pub struct CellsError {
    /// The layer.
    pub layer: usize,
    /// Why.
    pub source: RegionError,
}

impl Cells {
    /// The cells of a part, printed at the speeds of a process.
    ///
    /// # Errors
    /// If a layer is not a valid region.
    pub fn new(part: &Voxels, process: &ProcessParameters) -> Result<Self, CellsError> {
        let region = |layer: usize| match part.cells(layer).next() {
            None => Ok(None),
            Some(_) => part.region(layer).map(Some).map_err(|source| CellsError { layer, source }),
        };
        let regions: Vec<_> = (0..part.depth).map(region).collect::<Result<_, _>>()?;
        Ok(Self { regions: regions.into(), frame: part.frame, process: process.clone() })
    }

    /// The cells of a layer; `None` if it has none.
    pub fn region(&self, layer: u32) -> Option<&Region> {
        self.regions[layer as usize].as_ref()
    }

    fn printed(&self, layer: u32) -> &Region {
        self.region(layer).expect("the layer has cells")
    }

    fn lines_of(&self, layer: u32, order: LineOrder) -> CellLines {
        let cell_s = self.frame.cell_mm / self.process.print_mm_s;
        CellLines { lines: order.lines(self.printed(layer)), sequence: order.sequence, cell_s }
    }
}

impl Fill for Cells {
    type Path = Vec<Cell>;
    type Name = Order;
    type Position = Cell;
    type Lines = CellLines;

    fn layer_count(&self) -> usize {
        self.regions.len()
    }

    fn voxel_count(&self, layer: u32) -> usize {
        self.region(layer).map_or(0, |region| region.cell_count() as usize)
    }

    fn conventional(&self, layer: u32) -> Draft<Vec<Cell>, Order> {
        self.named(layer, Order::CONVENTIONAL)
    }

    fn named(&self, layer: u32, order: Order) -> Draft<Vec<Cell>, Order> {
        Draft { path: order.order(self.printed(layer)), name: Some(order) }
    }

    fn lines(&self, layer: u32, name: Option<Order>) -> CellLines {
        let order = match name {
            Some(Order::Lines(lines)) => lines,
            _ => DEFAULT_LINES,
        };
        self.lines_of(layer, order)
    }

    fn all_lines(&self, layer: u32) -> Vec<CellLines> {
        let along = |axis: Axis| self.lines_of(layer, LineOrder { axis, ..DEFAULT_LINES });
        vec![along(Axis::X), along(Axis::Y)]
    }

    fn ends(&self, _layer: u32, path: &Vec<Cell>) -> Option<[Cell; 2]> {
        Some([*path.first()?, *path.last()?])
    }

    fn travel_seconds(&self, from: Cell, to: Cell) -> f64 {
        // Only its voxel depends on the layer of an event.
        self.seconds(0, Some(from), &vec![to]) - self.seconds(0, None, &vec![to])
    }

    fn events(&self, layer: u32, from: Option<Cell>, path: &Vec<Cell>) -> Vec<DepositionEvent> {
        layer_events(path, layer, from, &self.frame, &self.process)
    }
}

/// Lines of cells.
#[derive(Clone, Debug)]
pub struct CellLines {
    lines: Lines,
    sequence: Sequence,
    /// Time to print a cell, s.
    cell_s: f64,
}

impl LineSet for CellLines {
    type Path = Vec<Cell>;
    type Position = Cell;

    fn count(&self) -> usize {
        self.lines.len()
    }

    fn cells(&self, line: usize) -> &[Cell] {
        self.lines.line(line)
    }

    fn seconds(&self, line: usize) -> f64 {
        self.lines.line(line).len() as f64 * self.cell_s
    }

    fn start(&self, from: Option<Cell>) -> Vec<usize> {
        self.lines.permutation(self.sequence, Ends::Nearest { from })
    }

    fn path(&self, lines: &[usize], from: Option<Cell>) -> Vec<Cell> {
        self.lines.flatten(lines, Ends::Nearest { from })
    }

    fn rest(&self, lines: &[usize], from: Option<Cell>) -> Vec<Cell> {
        self.path(lines, from)
    }
}
