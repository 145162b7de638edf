//! One connected part of a region, laid out for searches that step from cell to neighbour.

use beadwork_grid::{Cell, Region, Zones, region_components};

use crate::ZoneCosts;

/// The number of a cell on a [`Board`].
pub(crate) type Node = u32;

/// A direction: 0 right, 1 below, 2 left, 3 above.
/// As a bit, `1 << dir`.
pub(crate) type Dir = usize;

/// The direction back.
#[inline]
pub(crate) fn back(dir: Dir) -> Dir {
    dir ^ 2
}

/// Cells in a frame of empty ones, so that a step in any direction needs no check.
///
/// The rows are an odd number of nodes apart: hence a node is black, in a chessboard colouring,
/// exactly if its number is even.
#[derive(Clone)]
pub(crate) struct Board {
    stride: usize,
    /// 2^[`Board::SHIFT`] divided by the stride, rounded up: division by multiplication, for places
    /// are asked for all the time.
    inverse: u64,
    /// Column and row, in the region's plane, of the node at column 1 and row 1; the column may be
    /// -1.
    origin: (i64, i64),
    /// Width of the region's plane.
    width: u32,
    /// The cells in rising order.
    pub(crate) cells: Vec<Node>,
    /// For each node a bit for each direction in which there is a neighbour.
    pub(crate) neighbours: Vec<u8>,
    /// The same for neighbours in other zones.
    pub(crate) across: Vec<u8>,
    zone: Vec<u8>,
    /// What a crossing between two zones costs, in either direction, `a * zones + b`.
    costs: Vec<i32>,
    zones: usize,
}

impl Board {
    const SHIFT: u32 = 38;

    /// The board of some cells of a region, which must not be empty.
    pub(crate) fn new(region: &Region, zones: &Zones, costs: &ZoneCosts, members: &[Cell]) -> Self {
        let places = || members.iter().map(|&cell| region.xy(cell));
        let left = places().map(|(x, _)| x).min().expect("a board has cells");
        let right = places().map(|(x, _)| x).max().expect("a board has cells");
        let (top, bottom) = (
            places().next().expect("a board has cells").1,
            region.xy(members[members.len() - 1]).1,
        );
        // A frame on both sides, and one more column where that would make the number even.
        // The colours shall be the plane's, so the origin may move by one column.
        let shift = (left + top) % 2;
        let stride = ((right - left + 3 + shift) | 1) as usize;
        let origin = (i64::from(left) - i64::from(shift), i64::from(top));
        let nodes = stride * (bottom - top + 3) as usize;
        let mut board = Self {
            stride,
            inverse: (1_u64 << Self::SHIFT).div_ceil(stride as u64),
            origin,
            width: region.width(),
            cells: Vec::with_capacity(members.len()),
            neighbours: vec![0; nodes],
            across: vec![0; nodes],
            zone: vec![Zones::OUTSIDE; nodes],
            costs: costs.least(),
            zones: costs.zones(),
        };
        for &cell in members {
            let node = board.node(region, cell);
            board.cells.push(node);
            board.zone[node as usize] = zones.id(cell);
        }
        for &node in &board.cells {
            let zone = board.zone[node as usize];
            for dir in 0..4 {
                let other = board.zone[board.step(node, dir) as usize];
                let is_cell = other != Zones::OUTSIDE;
                board.neighbours[node as usize] |= u8::from(is_cell) << dir;
                board.across[node as usize] |= u8::from(is_cell && other != zone) << dir;
            }
        }
        board
    }

    /// The boards of all connected parts of a region, in the order of their first cells.
    ///
    /// # Panics
    /// If the zones or the costs are for another region.
    pub(crate) fn of_components(region: &Region, zones: &Zones, costs: &ZoneCosts) -> Vec<Self> {
        assert_eq!(zones.ids().len(), region.grid_len(), "the zones are those of another plane");
        assert!(
            region.cells().all(|cell| zones.id(cell) != Zones::OUTSIDE),
            "each cell has a zone"
        );
        let labels = region_components(region);
        let mut members = vec![Vec::new(); labels.count() as usize];
        for cell in region.cells() {
            members[labels.label(cell) as usize].push(cell);
        }
        members.iter().map(|cells| Self::new(region, zones, costs, cells)).collect()
    }

    /// The same cells with other costs of crossings, `a * zones + b`.
    pub(crate) fn with_costs(&self, costs: Vec<i32>) -> Self {
        Self { costs, ..self.clone() }
    }

    /// The same cells with each cost so many times as high.
    pub(crate) fn with_costs_in_parts(&self, parts: i32) -> Self {
        self.with_costs(self.costs.iter().map(|cost| cost * parts).collect())
    }

    /// The same cells as one zone: its links cost nothing.
    pub(crate) fn without_zones(&self) -> Self {
        Self { across: vec![0; self.nodes()], ..self.clone() }
    }

    /// The least that any crossing costs; 0 if there is none.
    pub(crate) fn least_cost(&self) -> u32 {
        let costs = self.cells.iter().flat_map(|&node| {
            dirs(self.across[node as usize]).map(move |dir| self.cost(node, dir) as u32)
        });
        costs.min().unwrap_or(0)
    }

    /// Number of nodes, the frame included: the length of an array indexed by [`Node`].
    pub(crate) fn nodes(&self) -> usize {
        self.zone.len()
    }

    /// Distance between a node and the one below.
    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    pub(crate) fn zone(&self, node: Node) -> u8 {
        self.zone[node as usize]
    }

    /// The node of one of the cells it is made of.
    fn node(&self, region: &Region, cell: Cell) -> Node {
        let (x, y) = region.xy(cell);
        let (column, row) = (i64::from(x) - self.origin.0 + 1, i64::from(y) - self.origin.1 + 1);
        (row * self.stride as i64 + column) as Node
    }

    /// The node of a cell, if it is one of the board's.
    pub(crate) fn find(&self, region: &Region, cell: Cell) -> Option<Node> {
        let (x, y) = region.xy(cell);
        let (column, row) = (i64::from(x) - self.origin.0 + 1, i64::from(y) - self.origin.1 + 1);
        let rows = (self.nodes() / self.stride) as i64;
        let on_board = (0..self.stride as i64).contains(&column) && (0..rows).contains(&row);
        let node = (row * self.stride as i64 + column) as Node;
        (on_board && self.zone(node) != Zones::OUTSIDE).then_some(node)
    }

    /// The cell of a node.
    pub(crate) fn cell(&self, node: Node) -> Cell {
        let (column, row) = self.xy(node);
        let (x, y) = (i64::from(column) - 1 + self.origin.0, i64::from(row) - 1 + self.origin.1);
        (y * i64::from(self.width) + x) as Cell
    }

    /// Column and row on the board, the frame included.
    #[inline]
    pub(crate) fn xy(&self, node: Node) -> (u32, u32) {
        // Exact as long as node times stride is below 2^SHIFT: there are at most 2^25 nodes, 2^13
        // apart.
        let y = ((u64::from(node) * self.inverse) >> Self::SHIFT) as u32;
        (node - y * self.stride as u32, y)
    }

    #[inline]
    pub(crate) fn is_black(node: Node) -> bool {
        node.is_multiple_of(2)
    }

    /// The node beside a cell.
    #[inline]
    pub(crate) fn step(&self, node: Node, dir: Dir) -> Node {
        match dir {
            0 => node + 1,
            1 => node + self.stride as Node,
            2 => node - 1,
            _ => node - self.stride as Node,
        }
    }

    /// Whether there is a neighbour in this direction, of the same zone.
    #[inline]
    pub(crate) fn in_zone(&self, node: Node, dir: Dir) -> bool {
        (self.neighbours[node as usize] & !self.across[node as usize]) & (1 << dir) != 0
    }

    /// What a link to the neighbour in this direction costs.
    #[inline]
    pub(crate) fn cost(&self, node: Node, dir: Dir) -> i32 {
        if self.across[node as usize] & (1 << dir) == 0 {
            return 0;
        }
        let other = self.step(node, dir);
        self.costs[usize::from(self.zone(node)) * self.zones + usize::from(self.zone(other))]
    }
}

/// The directions of the bits that are set.
#[inline]
pub(crate) fn dirs(mut bits: u8) -> impl Iterator<Item = Dir> {
    std::iter::from_fn(move || {
        let dir = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (dir < 8).then_some(dir as Dir)
    })
}
