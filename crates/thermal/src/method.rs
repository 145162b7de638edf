//! How the heat equation is stepped through time.

use crate::fast::Accuracy;

/// How the heat equation is stepped through time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// Forward Euler, one step of the whole part per deposited voxel: the scheme of the paper (Kim
    /// et al. 2026), and the definition that the other methods approximate or improve on.
    ///
    /// An event that deposits a voxel must not be longer than
    /// [`Simulation::max_stable_step_s`](crate::Simulation::max_stable_step_s).
    /// Every event costs a sweep over all deposited voxels, so the cost of a part grows with the
    /// square of its number of voxels.
    Naive,
    /// Heun's method (second order) on the whole part, to measure the errors of other methods.
    /// A step costs two sweeps over all deposited voxels.
    Reference {
        /// Steps per deposited voxel, at least 1.
        ///
        /// An event that is longer than the deposition of a voxel at the process's speed, or than
        /// [`Simulation::max_stable_step_s`](crate::Simulation::max_stable_step_s), is split into
        /// equal intervals that are not, and each interval takes this number of steps.
        steps: u32,
    },
    /// Local time stepping: long steps far from the nozzle, short steps near it.
    Fast(Accuracy),
}

impl Default for Method {
    /// [`Method::Fast`] with [`Accuracy::Standard`].
    fn default() -> Self {
        Self::Fast(Accuracy::Standard)
    }
}

beadwork_base::named_enum! {
    Accuracy, "accuracy":
    Draft = "draft",
    Standard = "standard",
    High = "high",
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accuracies_have_names() {
        assert_eq!("high".parse(), Ok(Accuracy::High));
        assert_eq!(Accuracy::ALL.map(Accuracy::name), ["draft", "standard", "high"]);
    }
}
