//! What a simulation knows at one moment.

use std::sync::Arc;

use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::occupancy::{Change, Occupancy};
use crate::patch::{Patch, Shape};

/// Which voxels are active, and how warm.
///
/// Copies share all of it until one of them changes.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub(crate) patch: Arc<Patch>,
    pub(crate) occupancy: Arc<Occupancy>,
    /// Rows from here on, halo counted, are empty.
    pub(crate) top: usize,
}

/// A [`State`] that may be changed.
pub(crate) struct StateMut<'a> {
    pub(crate) patch: &'a mut Patch,
    pub(crate) voxels: Voxels<'a>,
}

/// The part of a state that births change first.
pub(crate) struct Voxels<'a> {
    occupancy: &'a mut Occupancy,
    top: &'a mut usize,
}

impl State {
    /// A part of which nothing is printed yet.
    pub(crate) fn empty(shape: Shape, coefficients: &Coefficients) -> Self {
        Self {
            patch: Arc::new(Patch::empty(shape, coefficients)),
            occupancy: Arc::new(Occupancy::none(shape, coefficients)),
            top: 1,
        }
    }

    /// Copies whatever is shared, so that it may be changed.
    pub(crate) fn make_mut(&mut self) -> StateMut<'_> {
        StateMut {
            patch: Arc::make_mut(&mut self.patch),
            voxels: Voxels { occupancy: Arc::make_mut(&mut self.occupancy), top: &mut self.top },
        }
    }
}

impl Voxels<'_> {
    /// Makes a voxel active, and tells what changes by it; `patch` holds the voxel and the one
    /// below.
    pub(crate) fn birth(
        &mut self,
        at: [usize; 3],
        patch: &Patch,
        coefficients: &Coefficients,
        changes: &mut Vec<Change>,
    ) {
        let index = patch
            .index(at)
            .expect("births lie inside the halos of all patches that are stepped for them");
        self.occupancy.birth(at, patch.theta[index - patch.shape.row], coefficients, changes);
        *self.top = (*self.top).max(at[2] + 1);
    }

    /// What is active, in blocks.
    pub(crate) fn block_grid(&self) -> &BlockGrid {
        self.occupancy.block_grid()
    }

    /// Rows from here on, halo counted, are empty.
    pub(crate) fn top(&self) -> usize {
        *self.top
    }
}
