//! A path with every cell's place on it.

use thiserror::Error;

use crate::splice::Splicer;
use crate::{Cell, Region, Sides, VerifyError, verify};

/// Bits of [`Path::links`]: the neighbours a cell is linked to, and whether it is a corner.
pub(crate) mod link {
    pub(crate) const RIGHT: u8 = 1;
    pub(crate) const BELOW: u8 = 2;
    pub(crate) const LEFT: u8 = 4;
    pub(crate) const ABOVE: u8 = 8;
    /// The cell is the top-left one of a unit cell that lies in the plane.
    pub(crate) const CORNER: u8 = 16;
}

/// An order of all cells of a region in which consecutive cells are neighbours, except where one
/// piece ends and the next begins; of one piece, it is a Hamiltonian path.
///
/// Invariant: every cell of the region comes exactly once, and its position and links are known.
/// Hence neighbour and order queries cost O(1), and so does the question whether two switches keep
/// the path whole.
/// Two neighbouring cells are linked exactly if their positions differ by one; a step between
/// pieces joins cells that are not neighbours, so no move ever touches it.
#[derive(Clone, Debug)]
pub struct Path {
    pub(crate) width: u32,
    pub(crate) order: Vec<Cell>,
    /// Position of each cell of the plane; [`Path::NOWHERE`] outside the region.
    pub(crate) position: Vec<u32>,
    pub(crate) links: Vec<u8>,
    pub(crate) splicer: Splicer,
    pieces: u32,
}

/// Why an order of cells is no path of one piece.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum PathError {
    /// It does not visit every cell once.
    #[error(transparent)]
    Order(#[from] VerifyError),
    /// It visits every cell once, but in several pieces.
    #[error("the path falls into {0} pieces")]
    Pieces(u32),
}

impl Path {
    /// Position of a cell outside the region; no sum with it comes near a real position.
    const NOWHERE: u32 = u32::MAX / 2;

    /// The Hamiltonian path that visits the cells in this order.
    pub fn hamiltonian(region: &Region, order: Vec<Cell>) -> Result<Self, PathError> {
        let path = Self::in_pieces(region, order)?;
        if path.pieces == 1 { Ok(path) } else { Err(PathError::Pieces(path.pieces)) }
    }

    /// The path that visits the cells in this order, in as many pieces as it takes.
    pub fn in_pieces(region: &Region, order: Vec<Cell>) -> Result<Self, VerifyError> {
        let pieces = verify(region, &order)?;
        let mut position = vec![Self::NOWHERE; region.grid_len()];
        for (place, &cell) in (0..).zip(&order) {
            position[cell as usize] = place;
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
        Ok(Self { width, order, position, links, splicer: Splicer::default(), pieces })
    }

    /// Makes this path a copy of another one of the same region, without allocating.
    ///
    /// # Panics
    /// If the two have regions or planes of different sizes.
    pub fn copy_from(&mut self, other: &Self) {
        let sizes = |path: &Self| (path.order.len(), path.links.len());
        assert_eq!(sizes(self), sizes(other), "paths of one region are copied");
        self.width = other.width;
        self.pieces = other.pieces;
        self.order.copy_from_slice(&other.order);
        self.position.copy_from_slice(&other.position);
        self.links.copy_from_slice(&other.links);
    }

    /// The cells in the order of their visit.
    pub fn order(&self) -> &[Cell] {
        &self.order
    }

    /// Number of pieces, at least 1; no move changes it.
    pub fn pieces(&self) -> u32 {
        self.pieces
    }

    /// Width of the plane, in cells.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height of the plane, in cells.
    pub fn height(&self) -> u32 {
        self.links.len() as u32 / self.width
    }

    /// Place of a cell of the region on the path, from 0; a number past the end for the plane's
    /// other cells.
    ///
    /// # Panics
    /// If the cell lies outside the plane, as for all queries of a cell.
    #[inline]
    pub fn position(&self, cell: Cell) -> u32 {
        self.position[cell as usize]
    }

    /// Whether the path steps between this cell of the plane and its right neighbour.
    #[inline]
    pub fn linked_right(&self, cell: Cell) -> bool {
        self.links[cell as usize] & link::RIGHT != 0
    }

    /// Whether the path steps between this cell of the plane and the neighbour below.
    #[inline]
    pub fn linked_below(&self, cell: Cell) -> bool {
        self.links[cell as usize] & link::BELOW != 0
    }

    /// The cell before this one of the region; `None` at the beginning of a piece.
    pub fn previous(&self, cell: Cell) -> Option<Cell> {
        let before = *self.order.get((self.position(cell) as usize).checked_sub(1)?)?;
        self.is_step(before, cell).then_some(before)
    }

    /// The cell after this one of the region; `None` at the end of a piece.
    pub fn next(&self, cell: Cell) -> Option<Cell> {
        let after = *self.order.get(self.position(cell) as usize + 1)?;
        self.is_step(cell, after).then_some(after)
    }

    /// The pieces, each as the slice of its cells.
    pub fn iter_pieces(&self) -> impl Iterator<Item = &[Cell]> {
        self.order.chunk_by(|&a, &b| self.is_step(a, b))
    }

    /// The two parallel links of the unit cell at `corner`, if exactly those two of its four sides
    /// are linked: what a [`Switch`](crate::Switch) there can take out.
    /// `None` also where no unit cell begins, inside the plane or not.
    #[inline]
    pub fn sides(&self, corner: Cell) -> Option<Sides> {
        match self.square(corner) {
            square::HORIZONTAL => Some(Sides::Horizontal),
            square::VERTICAL => Some(Sides::Vertical),
            _ => None,
        }
    }

    /// The links of the unit cell at `corner` as bits: top, left, bottom, right, and
    /// [`link::CORNER`] if there is one.
    #[inline]
    pub(crate) fn square(&self, corner: Cell) -> u8 {
        let across = corner as usize + self.width as usize + 1;
        let Some(&opposite) = self.links.get(across) else { return 0 };
        self.links[corner as usize] & (link::CORNER | link::RIGHT | link::BELOW)
            | opposite & (link::LEFT | link::ABOVE)
    }

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

/// Values of [`Path::square`], and the bit in it of each side.
pub(crate) mod square {
    use super::link;

    pub(crate) const TOP: u8 = link::RIGHT;
    pub(crate) const LEFT: u8 = link::BELOW;
    pub(crate) const BOTTOM: u8 = link::LEFT;
    pub(crate) const RIGHT: u8 = link::ABOVE;
    pub(crate) const HORIZONTAL: u8 = link::CORNER | TOP | BOTTOM;
    pub(crate) const VERTICAL: u8 = link::CORNER | LEFT | RIGHT;
}

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
    fn a_path_in_pieces_breaks_between_cells_apart() {
        let region = Region::rectangle(2, 2).unwrap();
        assert_eq!(Path::hamiltonian(&region, vec![0, 1, 2, 3]), Err(PathError::Pieces(2)));
        let path = Path::in_pieces(&region, vec![0, 1, 2, 3]).unwrap();
        assert_eq!((path.next(1), path.previous(2), path.pieces()), (None, None, 2));
        assert_eq!(path.iter_pieces().collect::<Vec<_>>(), [[0, 1], [2, 3]]);
        assert_eq!(path.sides(0), Some(Sides::Horizontal));
    }
}
