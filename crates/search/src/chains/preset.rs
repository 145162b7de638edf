//! Named settings of the search for chains.

/// Named settings of the search for chains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Preset {
    /// Chains only.
    Plain,
    /// One move in twenty is random.
    Noisy,
}

beadwork_base::named_enum! {
    Preset, "chains preset":
    Plain = "plain",
    Noisy = "noisy",
}

impl Preset {
    /// The probability of a random move.
    pub(super) fn noise(self) -> f64 {
        match self {
            Self::Plain => 0.0,
            Self::Noisy => 0.05,
        }
    }
}
