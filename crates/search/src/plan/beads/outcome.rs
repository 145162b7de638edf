//! Bead plans, and what is proven about them.

use beadwork_part::BeadLayer;

use crate::Stop;
use crate::plan::{FixedOrder, ToolOrder};

/// Numbers of beads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Counts {
    /// Beads in all.
    pub beads: usize,
    /// Proven lower bound on the number of beads that print the same lines under the same rules.
    pub bead_bound: usize,
    /// Insets: each is a closed loop.
    pub loops: usize,
    /// Beads of varying width in thin walls and gaps.
    pub skeletons: usize,
    /// Beads that infill lines are linked to, before they are joined to anything else.
    pub infill: usize,
    /// Proven lower bound on [`infill`](Self::infill).
    pub infill_bound: usize,
    /// Infill regions.
    pub regions: usize,
    /// Infill regions whose number of beads is proven to be the minimum.
    pub optimal_regions: usize,
}

impl Counts {
    /// Adds other counts to these.
    pub(super) fn add(&mut self, other: &Self) {
        self.beads += other.beads;
        self.bead_bound += other.bead_bound;
        self.loops += other.loops;
        self.skeletons += other.skeletons;
        self.infill += other.infill;
        self.infill_bound += other.infill_bound;
        self.regions += other.regions;
        self.optimal_regions += other.optimal_regions;
    }
}

/// The beads of a part in printing order.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BeadPlan {
    /// The layers, numbered from 0 at the bed.
    pub layers: Vec<BeadLayer>,
    /// The numbers of each layer.
    pub counts: Vec<Counts>,
    /// The order of the tools, with its bounds.
    pub order: ToolOrder,
    /// Cost of printing the tools of every layer in ascending order, for comparison.
    pub fixed: FixedOrder,
    /// Travel in mm between the beads of a tool within layers, and from each layer to the next if
    /// the tool stays.
    /// Travel to and from tool changes is not included.
    pub travel_mm: f64,
    /// Proven lower bound on the travel between the beads of a tool within layers, for the same
    /// beads and in any order that the settings permit.
    /// `None` without [`Settings::bound_iterations`](super::Settings::bound_iterations), or if
    /// loops are joined.
    pub travel_bound_mm: Option<f64>,
    /// Reason why the search stopped: [`Stop::Optimal`] if the number of beads and the tool changes
    /// are proven minimal.
    pub stop: Stop,
}

impl BeadPlan {
    /// The numbers of all layers together.
    pub fn total(&self) -> Counts {
        let mut total = Counts::default();
        self.counts.iter().for_each(|counts| total.add(counts));
        total
    }

    /// Number of lifts: breaks between two beads of a layer.
    pub fn lifts(&self) -> usize {
        self.layers.iter().map(|layer| layer.beads.len().saturating_sub(1)).sum()
    }
}
