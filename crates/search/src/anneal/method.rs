//! The two methods of annealing, with their parameters.

/// A method of annealing, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The annealer of Aali et al.: draws variants from a pool.
    Pooled(Pooled),
    /// Draws any two switches.
    Free(Free),
}

/// Parameters of the annealer of Aali et al.; the default is its standard run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pooled {
    /// Number of moves to propose.
    pub iterations: u32,
    /// Initial temperature, in units of the cost.
    pub hot: f64,
    /// Final temperature, in units of the cost.
    pub cold: f64,
    /// Share of the iterations, 0..=1, that draw transposes only; the later ones draw flips too.
    pub transposes_only: f64,
    /// Maximum number of moves in the pool.
    pub pool: usize,
    /// Number of iterations after which the pool is filled again.
    pub pool_life: u32,
    /// Number of iterations without a new best path after which the run is reheated.
    pub patience: u32,
    /// Factor by which a reheat raises `hot`.
    pub reheat: f64,
    /// Maximum of `hot` after reheats.
    pub hottest: f64,
}

impl Default for Pooled {
    fn default() -> Self {
        Self {
            iterations: 5000,
            hot: 80.0,
            cold: 0.5,
            transposes_only: 0.6,
            pool: 5000,
            pool_life: 250,
            patience: 3000,
            reheat: 1.5,
            hottest: 600.0,
        }
    }
}

/// Parameters of the annealer that combines any two switches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Number of moves to propose.
    pub proposals: u64,
    /// Initial temperature, in units of the cost; positive.
    pub hot: f64,
    /// Final temperature, in units of the cost; positive.
    /// The temperature falls geometrically from `hot` to it.
    pub cold: f64,
    /// Maximum distance, in cells along x and y, of the first switch from a unit cell whose switch
    /// can change the cost.
    pub reach: u32,
    /// Share of the proposals, 0..=1, whose second switch touches the first; the second switch of
    /// the others lies anywhere along the cycle.
    pub nearby: f64,
    /// Number of path positions that a move without a change of the cost may span; moves that span
    /// more are proposed less often, in inverse proportion.
    /// Without this limit such moves would take most of the time, and they help no more than short
    /// ones.
    pub span: u32,
}

impl Default for Free {
    fn default() -> Self {
        Self { proposals: 5_000_000, hot: 0.8, cold: 0.12, reach: 1, nearby: 0.3, span: 200 }
    }
}
