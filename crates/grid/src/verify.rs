//! The judge: checks an order of cells from its definition alone.

use thiserror::Error;

use crate::{Cell, Region};

/// What is wrong with an order of cells.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum VerifyError {
    /// It has too few or too many cells.
    #[error("the path has {got} cells, the region {expected}")]
    Length {
        /// Cells of the region.
        expected: usize,
        /// Cells of the order.
        got: usize,
    },
    /// A cell is not one of the region's.
    #[error("cell {cell} at position {position} lies outside the region")]
    Outside {
        /// The cell.
        cell: Cell,
        /// Its position in the order, from 0.
        position: usize,
    },
    /// A cell comes twice.
    #[error("cell {cell} at position {position} was visited before")]
    Repeated {
        /// The cell.
        cell: Cell,
        /// Its second position in the order, from 0.
        position: usize,
    },
}

/// Checks that `order` visits every cell of the region once and gives the number of pieces: 1 more
/// than the number of steps between cells that are not neighbours.
/// A Hamiltonian path has one piece.
///
/// Linear in the region's cells.
/// It shares no code with the moves, so that it can judge them.
pub fn verify(region: &Region, order: &[Cell]) -> Result<u32, VerifyError> {
    let expected = region.cell_count() as usize;
    if order.len() != expected {
        return Err(VerifyError::Length { expected, got: order.len() });
    }
    let mut seen = vec![false; region.grid_len()];
    let mut pieces = 1;
    for (position, &cell) in order.iter().enumerate() {
        if !region.contains(cell) {
            return Err(VerifyError::Outside { cell, position });
        }
        if seen[cell as usize] {
            return Err(VerifyError::Repeated { cell, position });
        }
        seen[cell as usize] = true;
        if position > 0 && !region.adjacent(order[position - 1], cell) {
            pieces += 1;
        }
    }
    Ok(pieces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_is_named() {
        let region = Region::from_mask(2, 2, vec![true, true, true, false]).unwrap();
        assert_eq!(verify(&region, &[1, 0, 2]), Ok(1));
        assert_eq!(verify(&region, &[0, 1, 2]), Ok(2));
        assert_eq!(verify(&region, &[0, 1]), Err(VerifyError::Length { expected: 3, got: 2 }));
        assert_eq!(verify(&region, &[0, 1, 3]), Err(VerifyError::Outside { cell: 3, position: 2 }));
        assert_eq!(verify(&region, &[0, 1, 9]), Err(VerifyError::Outside { cell: 9, position: 2 }));
        assert_eq!(
            verify(&region, &[0, 1, 0]),
            Err(VerifyError::Repeated { cell: 0, position: 2 })
        );
    }
}
