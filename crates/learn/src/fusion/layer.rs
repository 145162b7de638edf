//! A layer, and a state of its path.

use beadwork_grid::{Crossings, Links, PlacedVariant, Region, Zones};

/// The properties of a layer that do not depend on its path.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Width and height of the grid.
    size: (u32, u32),
    /// Zone of each cell, row by row; [`Zones::OUTSIDE`] outside the layer.
    zones: Vec<u8>,
    /// The highest zone number inside the layer, at least 1.
    max_zone: u8,
    /// Whether a cell has a neighbour in another zone.
    boundary: Vec<bool>,
    crossings: Crossings,
}

/// A move that was applied to a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AppliedMove {
    /// The move.
    pub placed: PlacedVariant,
    /// Crossings of the path before the move.
    pub before: u32,
    /// Crossings of the path after the move.
    pub after: u32,
}

/// A state of a layer's path, and the moves that led to it.
#[derive(Clone, Copy, Debug)]
pub struct State<'a> {
    /// The layer.
    pub layer: &'a Layer,
    /// The links of the path.
    pub links: &'a Links,
    /// Crossings of the path.
    pub crossings: u32,
    /// Crossings of the start path; the network sees crossings relative to these.
    pub initial: u32,
    /// The moves from the start path to this state, oldest first.
    pub moves: &'a [AppliedMove],
}

impl Layer {
    /// Prepares a region with zones: finds zone boundaries and crossing links.
    /// Linear in the cells of the grid.
    pub fn new(region: &Region, zones: &Zones) -> Self {
        let zone_inside = |cell: u32| region.contains(cell).then(|| zones.id(cell));
        let cells = 0..region.grid_len() as u32;
        let boundary = cells.map(|cell| {
            let zone = zone_inside(cell);
            zone.is_some() && region.neighbours(cell).any(|other| zone_inside(other) != zone)
        });
        let max_zone = zones.ids().iter().filter(|&&id| id != Zones::OUTSIDE).max();
        Self {
            size: (region.width(), region.height()),
            zones: zones.ids().to_vec(),
            max_zone: max_zone.map_or(1, |&zone| zone.max(1)),
            boundary: boundary.collect(),
            crossings: Crossings::new(region, zones),
        }
    }

    /// Width and height of the grid, in cells.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The zone of each cell, row by row; [`Zones::OUTSIDE`] outside the layer.
    pub fn zones(&self) -> &[u8] {
        &self.zones
    }

    /// The highest zone number inside the layer, at least 1.
    pub fn max_zone(&self) -> u8 {
        self.max_zone
    }

    /// The links that cross from one zone to another.
    pub fn crossings(&self) -> &Crossings {
        &self.crossings
    }

    /// Change of the number of crossings by a move, negative if it saves crossings.
    /// O(1).
    pub fn change(&self, placed: PlacedVariant) -> i32 {
        placed.switches(self.size.0).iter().map(|&switch| self.crossings.change(switch)).sum()
    }

    /// Whether the cell at (x, y) has a neighbour in another zone.
    pub fn is_boundary(&self, x: u32, y: u32) -> bool {
        self.boundary[(y * self.size.0 + x) as usize]
    }
}
