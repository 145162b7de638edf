//! What the layers of a part are printed from, and the orders in which they can be printed.

mod beads;
mod cells;

use std::fmt::{Debug, Display};
use std::hash::Hash;

use beadwork_grid::Cell;
use beadwork_part::Order;
use beadwork_thermal::DepositionEvent;

use crate::candidates::OrderSet;

pub use self::beads::{BeadLines, BeadTiming, Beads, RowOrder, Strips};
pub use self::cells::{CellLines, Cells, CellsError};

/// What the layers of a part are printed from: [`Cells`], or [`Beads`].
///
/// Planners choose a [`Fill::Path`] for each layer, which prints the whole layer, and do not depend
/// on what it consists of.
pub trait Fill: Clone + Send + Sync {
    /// All of a layer, in some order; the default prints nothing.
    type Path: Clone + Debug + Default + Eq + Hash + Send + Sync;

    /// Name of an order.
    type Name: OrderName;

    /// Where the nozzle is.
    type Position: Copy + Debug + PartialEq + Send + Sync;

    /// The lines of a layer, for searches that permute them.
    type Lines: LineSet<Path = Self::Path, Position = Self::Position>;

    /// Number of layers.
    fn layer_count(&self) -> usize;

    /// Number of voxels of a layer; planners leave out layers without any.
    fn voxel_count(&self, layer: u32) -> usize;

    /// The conventional order of a layer that has voxels.
    fn conventional(&self, layer: u32) -> Draft<Self::Path, Self::Name>;

    /// A named order of a layer that has voxels.
    fn named(&self, layer: u32, name: Self::Name) -> Draft<Self::Path, Self::Name>;

    /// The lines of a layer that has voxels, as a named order has them; those of a default order
    /// without a name, or if the order has no lines.
    fn lines(&self, layer: u32, name: Option<Self::Name>) -> Self::Lines;

    /// All ways in which a layer that has voxels can be divided into lines.
    fn all_lines(&self, layer: u32) -> Vec<Self::Lines>;

    /// Where a path begins and ends; `None` if it prints nothing.
    fn ends(&self, layer: u32, path: &Self::Path) -> Option<[Self::Position; 2]>;

    /// Time from the end of a path to the beginning of the next one, s.
    fn travel_seconds(&self, from: Self::Position, to: Self::Position) -> f64;

    /// The deposition events of a path, with travel as pauses.
    ///
    /// The nozzle comes from `from`; with `None`, it starts at the path's beginning.
    fn events(
        &self,
        layer: u32,
        from: Option<Self::Position>,
        path: &Self::Path,
    ) -> Vec<DepositionEvent>;

    /// Time of a path, s: that of its events.
    fn seconds(&self, layer: u32, from: Option<Self::Position>, path: &Self::Path) -> f64 {
        self.events(layer, from, path).iter().map(|event| event.seconds).sum()
    }
}

/// The name of an order of a layer.
pub trait OrderName: Copy + Debug + Display + PartialEq + Send + Sync + 'static {
    /// All orders that planners choose from by default.
    fn all() -> Vec<Self>;
}

impl OrderName for Order {
    /// The 38 patterns and 240 orders of lines.
    fn all() -> Vec<Self> {
        OrderSet::All.orders()
    }
}

/// Lines of a layer, in any order.
pub trait LineSet: Send + Sync {
    /// As [`Fill::Path`].
    type Path;

    /// As [`Fill::Position`].
    type Position;

    /// Number of lines.
    fn count(&self) -> usize;

    /// The cells of a line.
    fn cells(&self, line: usize) -> &[Cell];

    /// Time to print a line, s.
    fn seconds(&self, line: usize) -> f64;

    /// The numbers of the lines in the order from which a search begins.
    fn start(&self, from: Option<Self::Position>) -> Vec<usize>;

    /// The path that prints everything else of the layer, if there is anything, and then the lines
    /// of a list, each from the end nearer to the nozzle: a permutation of all lines, or its first
    /// ones.
    fn path(&self, lines: &[usize], from: Option<Self::Position>) -> Self::Path;

    /// The path that prints only the lines of a list, such as the last ones of a permutation, each
    /// from the end nearer to the nozzle.
    ///
    /// After the path of the first ones, from its end, it is the rest of the path of all.
    fn rest(&self, lines: &[usize], from: Option<Self::Position>) -> Self::Path;
}

/// A layer before it is deposited.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft<P, N> {
    /// All of the layer, in order.
    pub path: P,
    /// Name of the order; `None` if a search made it, or the layer is empty.
    pub name: Option<N>,
}

/// A draft of a layer of a fill.
pub type DraftOf<F> = Draft<<F as Fill>::Path, <F as Fill>::Name>;

impl<P: Default, N> Default for Draft<P, N> {
    /// The draft of a layer without voxels.
    fn default() -> Self {
        Self { path: P::default(), name: None }
    }
}
