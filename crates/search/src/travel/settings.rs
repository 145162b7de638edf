//! Settings of the search for a route.

/// Settings of [`solve`](super::solve).
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Orders that are allowed.
    pub order: Order,
    /// Position of the nozzle before the first item, in mm; `None` if travel to it costs nothing.
    pub from: Option<[f64; 2]>,
    /// What a retraction costs; `None` if only the length of travel counts.
    pub retraction: Option<Retraction>,
    /// Seed of the random choices.
    pub seed: u64,
    /// Number of kicks for each item: small random changes, each followed by local search, and
    /// undone if the route becomes longer.
    /// The time is proportional to it; 0 stops at the first local optimum.
    pub kicks_per_item: u32,
    /// Maximum number of spanning trees for the lower bound; 0 for no bound.
    ///
    /// Each takes O(n²) steps for n items, so a bound takes longer than the route.
    pub bound_iterations: u32,
}

impl Default for Settings {
    /// Free order from anywhere, no cost of retractions, seed 0, 10 kicks for each item, no bound.
    fn default() -> Self {
        Self {
            order: Order::Free,
            from: None,
            retraction: None,
            seed: 0,
            kicks_per_item: 10,
            bound_iterations: 0,
        }
    }
}

/// A retraction before each long move, which takes time in addition to the move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retraction {
    /// Length of a move in mm above which filament is retracted; finite, at least 0.
    pub beyond_mm: f64,
    /// Travel in mm that takes as long as a retraction and its undoing; finite, at least 0.
    pub cost_mm: f64,
}

/// Which orders of the items are allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Any order; groups and stages do not matter.
    #[default]
    Free,
    /// The items of each group one after the other, in any order; the groups in any order.
    Groups,
    /// As [`Groups`](Self::Groups), but the items of a group by ascending stage.
    Stages,
}
