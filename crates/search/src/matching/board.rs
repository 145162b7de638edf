//! One connected component of a region as a padded grid: the graph of the exact search.

use beadwork_grid::{Cell, Region, Zones, region_components};

use crate::CostMatrix;

/// Index of a cell on a [`Board`], row by row; the padding has indices too.
pub(crate) type Node = u32;

/// A direction: 0 right, 1 down, 2 left, 3 up.
/// In a set of directions it is the bit `1 << dir`.
pub(crate) type Dir = usize;

/// The opposite direction.
#[inline]
pub(crate) fn opposite(dir: Dir) -> Dir {
    dir ^ 2
}

/// The cells of one component, coloured like a chessboard, with their zones and the costs of
/// crossings.
///
/// The cells are padded by empty ones on all sides, so the neighbour in any direction has an index.
/// Rows are an odd number of nodes apart, so the sum of column and row of a node is even exactly if
/// its index is: black nodes have even indices, white nodes odd ones.
#[derive(Clone)]
pub(crate) struct Board {
    /// Number of nodes in a row, padding included; odd.
    stride: usize,
    /// 2^[`Board::SHIFT`] / stride, rounded up, for division by multiplication: searches compute
    /// coordinates all the time.
    inverse_stride: u64,
    /// Column and row, in the region's grid, of the node at column 1 and row 1; the column may be
    /// -1.
    origin: (i64, i64),
    /// Width of the region's grid, in cells.
    width: u32,
    /// The nodes that are cells, in ascending order.
    pub(crate) cells: Vec<Node>,
    /// For each node the set of directions in which it has a neighbour; empty for the padding.
    pub(crate) neighbours: Vec<u8>,
    /// For each node the set of directions in which it has a neighbour in another zone.
    pub(crate) across: Vec<u8>,
    /// For each node its zone; [`Zones::OUTSIDE`] for the padding.
    zone: Vec<u8>,
    /// Cost of a crossing between zones a and b, in either direction, at `a * zones + b`.
    costs: Vec<i32>,
    /// Number of zones that have costs.
    zones: usize,
}

impl Board {
    const SHIFT: u32 = 38;

    /// The boards of all components of a region, in the order of their first cells.
    ///
    /// # Panics
    /// If the zones or the costs belong to another region.
    pub(crate) fn of_components(region: &Region, zones: &Zones, costs: &CostMatrix) -> Vec<Self> {
        assert_eq!(zones.ids().len(), region.grid_len(), "zones belong to another grid");
        assert!(
            region.cells().all(|cell| zones.id(cell) != Zones::OUTSIDE),
            "each cell of the region has a zone"
        );
        let labels = region_components(region);
        let mut members = vec![Vec::new(); labels.count() as usize];
        for cell in region.cells() {
            members[labels.label(cell) as usize].push(cell);
        }
        members.iter().map(|cells| Self::new(region, zones, costs, cells)).collect()
    }

    /// The board of some cells of a region, in ascending order and at least one.
    fn new(region: &Region, zones: &Zones, costs: &CostMatrix, members: &[Cell]) -> Self {
        let positions = || members.iter().map(|&cell| region.xy(cell));
        let left = positions().map(|(x, _)| x).min().expect("a board has cells");
        let right = positions().map(|(x, _)| x).max().expect("a board has cells");
        let (top, bottom) = (
            positions().next().expect("a board has cells").1,
            region.xy(members[members.len() - 1]).1,
        );
        // Each cell keeps the chessboard colour that it has in the region's grid, whatever the
        // bounding box of its component: the origin moves left by one column if necessary.
        // One column of padding on both sides, and one more if the stride would be even.
        let shift = (left + top) % 2;
        let stride = ((right - left + 3 + shift) | 1) as usize;
        let origin = (i64::from(left) - i64::from(shift), i64::from(top));
        let nodes = stride * (bottom - top + 3) as usize;
        let mut board = Self {
            stride,
            inverse_stride: (1_u64 << Self::SHIFT).div_ceil(stride as u64),
            origin,
            width: region.width(),
            cells: Vec::with_capacity(members.len()),
            neighbours: vec![0; nodes],
            across: vec![0; nodes],
            zone: vec![Zones::OUTSIDE; nodes],
            costs: costs.cheaper_direction(),
            zones: costs.size(),
        };
        for &cell in members {
            let (column, row) = board.position(region, cell);
            let node = (row * board.stride as i64 + column) as Node;
            board.cells.push(node);
            board.zone[node as usize] = zones.id(cell);
        }
        for &node in &board.cells {
            let zone = board.zone[node as usize];
            for dir in 0..4 {
                let other = board.zone[board.neighbour(node, dir) as usize];
                let is_cell = other != Zones::OUTSIDE;
                board.neighbours[node as usize] |= u8::from(is_cell) << dir;
                board.across[node as usize] |= u8::from(is_cell && other != zone) << dir;
            }
        }
        board
    }

    /// The same cells with other costs of crossings, indexed by `a * zones + b`.
    pub(crate) fn with_costs(&self, costs: Vec<i32>) -> Self {
        Self { costs, ..self.clone() }
    }

    /// The same cells with all costs multiplied by a factor.
    pub(crate) fn with_scaled_costs(&self, factor: i32) -> Self {
        self.with_costs(self.costs.iter().map(|cost| cost * factor).collect())
    }

    /// The same cells as a single zone, so that all links are free.
    pub(crate) fn without_zones(&self) -> Self {
        Self { across: vec![0; self.node_count()], ..self.clone() }
    }

    /// The minimum cost of a crossing; 0 if all cells are in one zone.
    pub(crate) fn min_crossing_cost(&self) -> u32 {
        let costs = self.cells.iter().flat_map(|&node| {
            dirs(self.across[node as usize]).map(move |dir| self.link_cost(node, dir) as u32)
        });
        costs.min().unwrap_or(0)
    }

    /// Number of nodes, padding included: the length of an array indexed by [`Node`].
    pub(crate) fn node_count(&self) -> usize {
        self.zone.len()
    }

    /// Difference between the indices of a node and of the one below it.
    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    /// The zone of a cell.
    pub(crate) fn zone(&self, node: Node) -> u8 {
        self.zone[node as usize]
    }

    /// Column and row on the board, padding included, of a cell of the region; may lie outside.
    fn position(&self, region: &Region, cell: Cell) -> (i64, i64) {
        let (x, y) = region.xy(cell);
        (i64::from(x) - self.origin.0 + 1, i64::from(y) - self.origin.1 + 1)
    }

    /// The node of a cell of the region; `None` if it belongs to another component.
    pub(crate) fn find(&self, region: &Region, cell: Cell) -> Option<Node> {
        let (column, row) = self.position(region, cell);
        let rows = (self.node_count() / self.stride) as i64;
        let on_board = (0..self.stride as i64).contains(&column) && (0..rows).contains(&row);
        let node = (row * self.stride as i64 + column) as Node;
        (on_board && self.zone(node) != Zones::OUTSIDE).then_some(node)
    }

    /// The cell of the region that a node stands for.
    pub(crate) fn cell(&self, node: Node) -> Cell {
        let (column, row) = self.xy(node);
        let (x, y) = (i64::from(column) - 1 + self.origin.0, i64::from(row) - 1 + self.origin.1);
        (y * i64::from(self.width) + x) as Cell
    }

    /// Column and row on the board, padding included.
    #[inline]
    pub(crate) fn xy(&self, node: Node) -> (u32, u32) {
        // Multiplying by the rounded inverse is exact as long as node * stride < 2^SHIFT.
        // There are at most 2^25 nodes, at a stride of at most 2^13.
        let y = ((u64::from(node) * self.inverse_stride) >> Self::SHIFT) as u32;
        (node - y * self.stride as u32, y)
    }

    /// Whether a node is black: even column + row.
    #[inline]
    pub(crate) fn is_black(node: Node) -> bool {
        node.is_multiple_of(2)
    }

    /// The node next to a cell in this direction, which may be padding.
    #[inline]
    pub(crate) fn neighbour(&self, node: Node, dir: Dir) -> Node {
        match dir {
            0 => node + 1,
            1 => node + self.stride as Node,
            2 => node - 1,
            _ => node - self.stride as Node,
        }
    }

    /// Whether a cell has a neighbour of the same zone in this direction.
    #[inline]
    pub(crate) fn stays_in_zone(&self, node: Node, dir: Dir) -> bool {
        (self.neighbours[node as usize] & !self.across[node as usize]) & (1 << dir) != 0
    }

    /// The cost of a link between a cell and its neighbour in this direction; 0 inside a zone.
    #[inline]
    pub(crate) fn link_cost(&self, node: Node, dir: Dir) -> i32 {
        if self.across[node as usize] & (1 << dir) == 0 {
            return 0;
        }
        let other = self.neighbour(node, dir);
        self.costs[usize::from(self.zone(node)) * self.zones + usize::from(self.zone(other))]
    }
}

/// The directions in a set, in ascending order.
#[inline]
pub(crate) fn dirs(mut set: u8) -> impl Iterator<Item = Dir> {
    std::iter::from_fn(move || {
        let dir = set.trailing_zeros();
        set &= set.wrapping_sub(1);
        (dir < 8).then_some(dir as Dir)
    })
}
