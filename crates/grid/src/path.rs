//! A path, with the position of every cell on it.

use thiserror::Error;

use crate::bits::{link, square};
use crate::splice_plan::SplicePlan;
use crate::{Cell, Region, Sides, VerifyError, verify};

/// An order of all cells of a region, in one or several pieces.
///
/// Consecutive cells are neighbours, except where one piece ends and the next begins.
/// A path of one piece is a Hamiltonian path of the region.
///
/// Invariant: every cell of the region occurs exactly once in the order, and the path stores the
/// position and the links of every cell.
/// Therefore queries of neighbours and positions cost O(1), and so does the test whether two
/// switches keep the path in one piece ([`Path::allows_pair`]).
///
/// Two neighbouring cells are linked exactly if their positions differ by one.
/// A jump between two pieces joins cells that are not neighbours: it is not a link, and no move
/// changes it.
///
/// Memory: 9 bytes for each cell of the grid (5 outside the region).
#[derive(Clone, Debug)]
pub struct Path {
    pub(crate) width: u32,
    pub(crate) order: Vec<Cell>,
    /// Position of each cell of the grid; [`Path::NOWHERE`] outside the region.
    pub(crate) position: Vec<u32>,
    /// Links of each cell of the grid, as bits of [`link`].
    pub(crate) links: Vec<u8>,
    /// Buffers of [`Path::apply`], kept so that applying a move does not allocate.
    pub(crate) splice_plan: SplicePlan,
    pieces: u32,
}

/// Why an order of cells is not a path of one piece.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum PathError {
    /// The order does not visit every cell exactly once.
    #[error(transparent)]
    Order(#[from] VerifyError),
    /// The order visits every cell once, but in several pieces.
    #[error("path has {0} pieces, expected one")]
    Pieces(u32),
}

impl Path {
    /// Position of cells outside the region.
    /// It differs from every real position by more than one, and adding to it does not overflow.
    const NOWHERE: u32 = u32::MAX / 2;

    /// Makes the Hamiltonian path that visits the cells in this order.
    /// Linear in the grid's cells.
    pub fn hamiltonian(region: &Region, order: Vec<Cell>) -> Result<Self, PathError> {
        let path = Self::in_pieces(region, order)?;
        if path.pieces == 1 { Ok(path) } else { Err(PathError::Pieces(path.pieces)) }
    }

    /// Makes the path that visits the cells in this order, with a new piece after each jump.
    /// Linear in the grid's cells.
    pub fn in_pieces(region: &Region, order: Vec<Cell>) -> Result<Self, VerifyError> {
        let pieces = verify(region, &order)?;
        let mut position = vec![Self::NOWHERE; region.grid_len()];
        for (index, &cell) in (0..).zip(&order) {
            position[cell as usize] = index;
        }
        let (width, height) = (region.width(), region.height());
        let linked = |a: Cell, b: Cell| position[a as usize].abs_diff(position[b as usize]) == 1;
        let mut links = vec![0; region.grid_len()];
        for cell in 0..region.grid_len() as Cell {
            let (x, y) = region.xy(cell);
            if x + 1 < width && linked(cell, cell + 1) {
                links[cell as usize] |= link::RIGHT;
                links[cell as usize + 1] |= link::LEFT;
            }
            if y + 1 < height && linked(cell, cell + width) {
                links[cell as usize] |= link::BELOW;
                links[(cell + width) as usize] |= link::ABOVE;
            }
            if x + 1 < width && y + 1 < height {
                links[cell as usize] |= link::CORNER;
            }
        }
        Ok(Self { width, order, position, links, splice_plan: SplicePlan::default(), pieces })
    }

    /// Makes this path a copy of another path of the same region, without allocating.
    ///
    /// # Panics
    /// If the regions of the two have different numbers of cells, or their grids have.
    pub fn copy_from(&mut self, other: &Self) {
        let sizes = |path: &Self| (path.order.len(), path.links.len());
        assert_eq!(sizes(self), sizes(other), "copy_from needs two paths of one region");
        self.width = other.width;
        self.pieces = other.pieces;
        self.order.copy_from_slice(&other.order);
        self.position.copy_from_slice(&other.position);
        self.links.copy_from_slice(&other.links);
    }

    /// The cells in the order in which the path visits them.
    pub fn order(&self) -> &[Cell] {
        &self.order
    }

    /// Number of pieces, at least 1; moves do not change it.
    pub fn pieces(&self) -> u32 {
        self.pieces
    }

    /// Width of the grid, in cells.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height of the grid, in cells.
    pub fn height(&self) -> u32 {
        self.links.len() as u32 / self.width
    }

    /// Position of a cell of the region on the path, from 0; for a cell of the grid outside the
    /// region, a number beyond the path's end.
    ///
    /// # Panics
    /// If the cell lies outside the grid.
    #[inline]
    pub fn position(&self, cell: Cell) -> u32 {
        self.position[cell as usize]
    }

    /// Whether the path links this cell of the grid with its right neighbour.
    ///
    /// # Panics
    /// If the cell lies outside the grid.
    #[inline]
    pub fn linked_right(&self, cell: Cell) -> bool {
        self.links[cell as usize] & link::RIGHT != 0
    }

    /// Whether the path links this cell of the grid with the neighbour below.
    ///
    /// # Panics
    /// If the cell lies outside the grid.
    #[inline]
    pub fn linked_below(&self, cell: Cell) -> bool {
        self.links[cell as usize] & link::BELOW != 0
    }

    /// The cell before this cell of the region; `None` at the start of a piece.
    ///
    /// # Panics
    /// If the cell lies outside the grid.
    pub fn previous(&self, cell: Cell) -> Option<Cell> {
        let before = *self.order.get((self.position(cell) as usize).checked_sub(1)?)?;
        self.is_step(before, cell).then_some(before)
    }

    /// The cell after this cell of the region; `None` at the end of a piece.
    ///
    /// # Panics
    /// If the cell lies outside the grid.
    pub fn next(&self, cell: Cell) -> Option<Cell> {
        let after = *self.order.get(self.position(cell) as usize + 1)?;
        self.is_step(cell, after).then_some(after)
    }

    /// The pieces, each as the slice of its cells.
    pub fn iter_pieces(&self) -> impl Iterator<Item = &[Cell]> {
        self.order.chunk_by(|&a, &b| self.is_step(a, b))
    }

    /// The sides that a [`Switch`](crate::Switch) can take out of the unit cell at `corner`: its
    /// horizontal or its vertical ones, if these two and no others are linked.
    /// `None` also if no unit cell begins at `corner`, inside the grid or outside of it.
    #[inline]
    pub fn sides(&self, corner: Cell) -> Option<Sides> {
        match self.square(corner) {
            square::HORIZONTAL => Some(Sides::Horizontal),
            square::VERTICAL => Some(Sides::Vertical),
            _ => None,
        }
    }

    /// The linked sides of the unit cell at `corner`, as bits of [`square`], and [`link::CORNER`]
    /// if there is such a unit cell.
    #[inline]
    pub(crate) fn square(&self, corner: Cell) -> u8 {
        let opposite = corner as usize + self.width as usize + 1;
        let Some(&opposite) = self.links.get(opposite) else { return 0 };
        self.links[corner as usize] & (link::CORNER | link::RIGHT | link::BELOW)
            | opposite & (link::LEFT | link::ABOVE)
    }

    /// Whether two cells with consecutive positions are linked rather than joined by a jump.
    fn is_step(&self, a: Cell, b: Cell) -> bool {
        let bits = self.links[a as usize];
        (b == a + 1 && bits & link::RIGHT != 0)
            || (b == a + self.width && bits & link::BELOW != 0)
            || (b + 1 == a && bits & link::LEFT != 0)
            || (b + self.width == a && bits & link::ABOVE != 0)
    }
}

/// Two paths are equal if they visit the same cells in the same order.
impl PartialEq for Path {
    fn eq(&self, other: &Self) -> bool {
        self.width == other.width && self.order == other.order
    }
}

impl Eq for Path {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_follow_the_order() {
        let region = Region::rectangle(2, 2).unwrap();
        let path = Path::hamiltonian(&region, vec![0, 1, 3, 2]).unwrap();
        assert_eq!((path.previous(0), path.next(0)), (None, Some(1)));
        assert_eq!((path.previous(2), path.next(2)), (Some(3), None));
        assert!(path.linked_right(0) && path.linked_below(1) && !path.linked_below(0));
        assert_eq!(path.sides(0), None, "three sides are linked");
        assert_eq!(path.sides(1), None, "no unit cell begins in the last column");
    }

    #[test]
    fn pieces_end_where_consecutive_cells_are_not_neighbours() {
        let region = Region::rectangle(2, 2).unwrap();
        assert_eq!(Path::hamiltonian(&region, vec![0, 1, 2, 3]), Err(PathError::Pieces(2)));
        let path = Path::in_pieces(&region, vec![0, 1, 2, 3]).unwrap();
        assert_eq!((path.next(1), path.previous(2), path.pieces()), (None, None, 2));
        assert_eq!(path.iter_pieces().collect::<Vec<_>>(), [[0, 1], [2, 3]]);
        assert_eq!(path.sides(0), Some(Sides::Horizontal));
    }
}
