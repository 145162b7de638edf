//! Checks an order of cells from its definition alone.

use thiserror::Error;

use crate::{Cell, Region};

/// Why an order of cells does not visit every cell of a region exactly once.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum VerifyError {
    /// The order has too few or too many cells.
    #[error("path has {got} cells, the region {expected}")]
    Length {
        /// Number of cells of the region.
        expected: usize,
        /// Number of cells of the order.
        got: usize,
    },
    /// A cell of the order does not belong to the region.
    #[error("cell {cell} at position {position} lies outside the region")]
    Outside {
        /// Number of the cell.
        cell: Cell,
        /// Position of the cell in the order, from 0.
        position: usize,
    },
    /// A cell occurs twice.
    #[error("cell {cell} at position {position} is visited for the second time")]
    Repeated {
        /// Number of the cell.
        cell: Cell,
        /// Position of its second occurrence in the order, from 0.
        position: usize,
    },
}

/// Checks that `order` visits every cell of the region exactly once, and returns the number of
/// pieces.
///
/// A new piece begins wherever two consecutive cells are not neighbours; a Hamiltonian path has one
/// piece.
/// Linear in the grid's cells.
///
/// This function shares no code with the moves, so that tests can check the moves with it.
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
