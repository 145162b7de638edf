//! The state of a simulation at one moment.

use std::sync::Arc;

use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::occupancy::{Occupancy, VoxelChange};
use crate::patch::Patch;
use crate::shape::Shape;

/// Which voxels are active, and their temperatures.
///
/// Copy on write: clones share all arrays until one of them changes.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub(crate) patch: Arc<Patch>,
    pub(crate) occupancy: Arc<Occupancy>,
    /// First row (layer) without a voxel, with the halo counted: all rows from here on are empty.
    pub(crate) top: usize,
}

/// Mutable access to a [`State`], split so that a stepper can change temperatures while it
/// registers births.
pub(crate) struct StateMut<'a> {
    pub(crate) patch: &'a mut Patch,
    pub(crate) occupancy: OccupancyMut<'a>,
}

/// The occupancy of a state, to which births are registered.
pub(crate) struct OccupancyMut<'a> {
    occupancy: &'a mut Occupancy,
    top: &'a mut usize,
}

impl State {
    /// The state of a part of which nothing is printed yet.
    pub(crate) fn unprinted(shape: Shape, coefficients: &Coefficients) -> Self {
        Self {
            patch: Arc::new(Patch::unprinted(shape, coefficients)),
            occupancy: Arc::new(Occupancy::unprinted(shape, coefficients)),
            top: 1,
        }
    }

    /// Mutable access; first copies the arrays that are shared with other states.
    pub(crate) fn make_mut(&mut self) -> StateMut<'_> {
        StateMut {
            patch: Arc::make_mut(&mut self.patch),
            occupancy: OccupancyMut {
                occupancy: Arc::make_mut(&mut self.occupancy),
                top: &mut self.top,
            },
        }
    }
}

impl OccupancyMut<'_> {
    /// Activates a voxel and appends all changes of coefficients that follow.
    ///
    /// Patches see a birth only once they apply these changes, so that nested patches can do so at
    /// different times.
    /// `patch` must contain the voxel; it provides the temperature of the one below.
    ///
    /// # Panics
    /// If the voxel lies outside `patch` or in its halo.
    pub(crate) fn birth(
        &mut self,
        position: [usize; 3],
        patch: &Patch,
        coefficients: &Coefficients,
        changes: &mut Vec<VoxelChange>,
    ) {
        let index = patch.index(position).expect("a patch contains all births of its steps");
        let below = patch.theta[index - patch.shape.row_len];
        self.occupancy.birth(position, below, coefficients, changes);
        *self.top = (*self.top).max(position[2] + 1);
    }

    /// Numbers of active voxels and of their faces in each block.
    pub(crate) fn block_grid(&self) -> &BlockGrid {
        self.occupancy.block_grid()
    }

    /// First row (layer) without a voxel, with the halo counted.
    pub(crate) fn top(&self) -> usize {
        *self.top
    }
}
