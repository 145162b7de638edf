//! Settings of plans of whole parts.

use crate::plan::Constraints;

/// How the layers of a part may be printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Each layer in the way that makes the part cheaper, at the given cost of a lift.
    #[default]
    Cheapest,
    /// Without lifts wherever possible: pieces cross zone borders, and the tool changes where they
    /// do.
    Continuous,
    /// Tool by tool: no piece crosses a zone border, and each layer uses each of its tools once.
    Free,
}

beadwork_base::named_enum! {
    Mode, "planning mode":
    Cheapest = "cheapest",
    Continuous = "continuous",
    Free = "free",
}

/// Which of two equally good paths of a layer to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stacking {
    /// The one with more links in common with the layer below: seams are stacked, and the surfaces
    /// of the layers look alike.
    Keep,
    /// The one with fewer links in common: beads cross those below and bind the layers.
    /// Straight runs follow the rows of one layer and the columns of the next.
    Break,
}

beadwork_base::named_enum! {
    Stacking, "stacking rule":
    Keep = "keep",
    Break = "break",
}

/// Settings of a plan.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Cost of a lift, in the unit of the tool costs; finite and nonnegative.
    pub lift_cost: f64,
    /// How the layers may be printed.
    pub mode: Mode,
    /// What the order of the tools must obey.
    /// [`Mode::Continuous`] supports [`Constraints::first`] and [`Constraints::loaded`] only.
    pub constraints: Constraints,
    /// If given, the path of the layer below is tried as a start for each layer, and the rule
    /// decides between equally good paths.
    /// If `None`, each layer is covered on its own.
    pub stacking: Option<Stacking>,
    /// Seed of all random choices.
    pub seed: u64,
    /// Maximum number of attempts at each connected component of a layer.
    pub attempts: u32,
}

impl Default for Settings {
    /// The cheapest mode, lifts that cost nothing, no constraints, layers on their own, seed 0, 50
    /// attempts.
    fn default() -> Self {
        Self {
            lift_cost: 0.0,
            mode: Mode::default(),
            constraints: Constraints::default(),
            stacking: None,
            seed: 0,
            attempts: 50,
        }
    }
}
