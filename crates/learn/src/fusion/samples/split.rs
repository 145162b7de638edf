//! The split of a dataset into training, validation and test instances.

use std::fmt;

use beadwork_dataset::{Instance, Trajectory};

/// A part of a dataset.
/// All trajectories of one instance are in the same part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Training: eight of ten instances, and all pictures and layouts that are not random.
    Train,
    /// Validation: one of ten instances; their loss decides which weights are saved and when
    /// training stops early.
    Valid,
    /// Test: one of ten instances, which training never reads.
    Test,
}

impl Split {
    /// The part that a trajectory belongs to, in a dataset of `strata` combinations.
    ///
    /// Within each combination, trajectories 10 k + 8 are for validation and 10 k + 9 for tests.
    /// That separates instances, because each trajectory of a random layout has an instance of its
    /// own.
    /// A picture, or a layout that is not random, has only one instance, which is used for
    /// training.
    pub fn of(trajectory: &Trajectory, strata: u64) -> Self {
        let is_random = match &trajectory.instance {
            Instance::Layout { layout, .. } => layout.is_random(),
            Instance::Picture { .. } => false,
        };
        match trajectory.index / strata.max(1) % 10 {
            8 if is_random => Self::Valid,
            9 if is_random => Self::Test,
            _ => Self::Train,
        }
    }
}

impl fmt::Display for Split {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Train => "training",
            Self::Valid => "validation",
            Self::Test => "test",
        })
    }
}
