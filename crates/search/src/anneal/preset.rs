//! Named settings of the annealers.

use super::method::{Free, Method, Pooled};

/// Named settings of the annealers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Preset {
    /// The standard run of Aali et al.: [`Pooled`], 5000 iterations, temperatures from 80 to 0.5.
    Paper,
    /// [`Pooled`], 1000 iterations, temperatures from 60 to 0.5.
    Short,
    /// [`Pooled`], 3000 iterations, temperatures from 80 to 0.5.
    Medium,
    /// [`Pooled`], 8000 iterations, temperatures from 100 to 0.3.
    Long,
    /// [`Pooled`], 15,000 iterations, temperatures from 120 to 0.2.
    ExtraLong,
    /// [`Free`] with its default parameters.
    Fast,
}

beadwork_base::named_enum! {
    Preset, "annealing preset":
    Paper = "paper",
    Short = "short",
    Medium = "medium",
    Long = "long",
    ExtraLong = "extra_long",
    Fast = "fast",
}

impl Preset {
    /// The method and the parameters that the name stands for.
    pub fn method(self) -> Method {
        let pooled = |iterations, hot, cold| {
            Method::Pooled(Pooled { iterations, hot, cold, ..Pooled::default() })
        };
        match self {
            Self::Paper => Method::Pooled(Pooled::default()),
            Self::Short => pooled(1000, 60.0, 0.5),
            Self::Medium => pooled(3000, 80.0, 0.5),
            Self::Long => pooled(8000, 100.0, 0.3),
            Self::ExtraLong => pooled(15_000, 120.0, 0.2),
            Self::Fast => Method::Free(Free::default()),
        }
    }
}
