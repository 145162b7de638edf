//! Objectives by name, and weighted sums of them.

use std::fmt;
use std::str::FromStr;

use beadwork_base::{UnknownName, named_enum};
use thiserror::Error;

use super::plan::HeatMeasures;

/// A measure that plans are judged by, as a cost: lower is better.
///
/// The [module's page](super) says how each can be gamed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Objective {
    /// Minus the paper's reward ([`HeatMeasures::reward`]), K.
    Reward,
    /// Minus the reward if travel and pauses took no time ([`HeatMeasures::no_travel_reward`]), K.
    NoTravel,
    /// Deviation averaged over the time of the print ([`HeatMeasures::time_averaged_std_c`]), K.
    TimeAveraged,
    /// Sum of the maximum deviations over time of all layers but the first
    /// ([`HeatMeasures::peak_std_sum_c`]), K.
    Peak,
    /// Estimated lift of the outline ([`HeatMeasures::warpage_mm`]), mm.
    Warpage,
}

named_enum! {
    Objective, "heat objective":
    Reward = "reward",
    NoTravel = "no_travel",
    TimeAveraged = "time_averaged",
    Peak = "peak",
    Warpage = "warpage",
}

impl Objective {
    /// The cost of a print; `None` if its measures lack it.
    pub fn cost(self, measures: &HeatMeasures) -> Option<f64> {
        match self {
            // Not `-reward`, which would be -0 without layers.
            Self::Reward => Some(0.0 - measures.reward()),
            Self::NoTravel => measures.no_travel_reward.map(|reward| 0.0 - reward),
            Self::TimeAveraged => Some(measures.time_averaged_std_c()),
            Self::Peak => Some(measures.peak_std_sum_c()),
            Self::Warpage => measures.warpage_mm,
        }
    }

    /// By how much the cost of `plan` is below that of `baseline`, in % of the latter: positive if
    /// the plan is better.
    ///
    /// `None` if measures lack the cost, or that of the baseline is 0.
    pub fn gain_percent(self, plan: &HeatMeasures, baseline: &HeatMeasures) -> Option<f64> {
        let (plan, baseline) = (self.cost(plan)?, self.cost(baseline)?);
        (baseline != 0.0).then(|| 100.0 * (baseline - plan) / baseline)
    }
}

/// A weighted sum of objectives.
///
/// Each cost is divided by that of a baseline, such as the conventional order, so that weights are
/// comparable: with weights that add up to 1, the baseline itself costs 1. As text, a list such as
/// `time_averaged=0.7,warpage=0.3`; an objective without a number has the weight 1.
///
/// ```
/// use beadwork_thermal::objective::{Objective, Weighted};
///
/// let weighted: Weighted = "time_averaged=0.7,warpage=0.3".parse()?;
/// assert_eq!(weighted.terms()[1], (Objective::Warpage, 0.3));
/// assert_eq!(weighted.to_string(), "time_averaged=0.7,warpage=0.3");
/// assert_eq!("reward".parse::<Weighted>()?, Weighted::from(Objective::Reward));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Weighted {
    /// Invariant: at least one; objectives are distinct; weights are finite and at least 0, and one
    /// is more than 0.
    terms: Vec<(Objective, f64)>,
}

/// Why a weighted sum is invalid.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum WeightedError {
    /// An objective has an unknown name.
    #[error(transparent)]
    Name(#[from] UnknownName),
    /// A weight is not a number of at least 0.
    #[error("weight '{weight}' of {objective} is invalid: expected a number of at least 0")]
    Weight {
        /// The objective.
        objective: Objective,
        /// Its weight, as written.
        weight: String,
    },
    /// An objective occurs twice.
    #[error("{objective} occurs twice: give it one weight")]
    Repeated {
        /// The objective.
        objective: Objective,
    },
    /// No weight is more than 0.
    #[error("weighted sum has no weight above 0: give at least one objective")]
    Empty,
}

impl Weighted {
    /// A weighted sum of objectives, each with its weight, at least 0.
    pub fn new(terms: Vec<(Objective, f64)>) -> Result<Self, WeightedError> {
        for (number, &(objective, weight)) in terms.iter().enumerate() {
            if !(weight >= 0.0 && weight.is_finite()) {
                return Err(WeightedError::Weight { objective, weight: weight.to_string() });
            }
            if terms[..number].iter().any(|&(earlier, _)| earlier == objective) {
                return Err(WeightedError::Repeated { objective });
            }
        }
        if terms.iter().all(|&(_, weight)| weight == 0.0) {
            return Err(WeightedError::Empty);
        }
        Ok(Self { terms })
    }

    /// The default of planners: deviations at the layers' ends, with travel and, twice as much,
    /// without.
    ///
    /// The first alone can be lowered by waiting at the end of a layer, and the second alone by
    /// any amount of travel (see the [module's page](super)).
    pub fn even() -> Self {
        Self { terms: vec![(Objective::Reward, 1.0), (Objective::NoTravel, 2.0)] }
    }

    /// The objectives and their weights.
    pub fn terms(&self) -> &[(Objective, f64)] {
        &self.terms
    }

    /// Whether a print has to be measured with [`Settings::warpage`](super::Settings::warpage).
    pub fn needs_warpage(&self) -> bool {
        self.needs(Objective::Warpage)
    }

    /// Whether a print has to be simulated a second time, without travel.
    pub fn needs_no_travel(&self) -> bool {
        self.needs(Objective::NoTravel)
    }

    fn needs(&self, objective: Objective) -> bool {
        self.terms.iter().any(|&(term, weight)| term == objective && weight > 0.0)
    }

    /// The sum of the costs of `plan`, each relative to that of `baseline` and times its weight.
    ///
    /// `None` if measures lack a cost whose weight is more than 0, or the baseline's is 0.
    pub fn cost(&self, plan: &HeatMeasures, baseline: &HeatMeasures) -> Option<f64> {
        let mut sum = 0.0;
        for &(objective, weight) in self.terms.iter().filter(|&&(_, weight)| weight > 0.0) {
            let base = objective.cost(baseline).filter(|&base| base != 0.0)?;
            sum += weight * objective.cost(plan)? / base;
        }
        Some(sum)
    }
}

impl From<Objective> for Weighted {
    fn from(objective: Objective) -> Self {
        Self { terms: vec![(objective, 1.0)] }
    }
}

impl FromStr for Weighted {
    type Err = WeightedError;

    fn from_str(text: &str) -> Result<Self, WeightedError> {
        let term = |term: &str| {
            let (name, weight) = term.split_once('=').unwrap_or((term, "1"));
            let objective: Objective = name.trim().parse()?;
            let number = weight
                .trim()
                .parse()
                .map_err(|_| WeightedError::Weight { objective, weight: weight.to_owned() })?;
            Ok((objective, number))
        };
        Self::new(text.split(',').map(term).collect::<Result<_, WeightedError>>()?)
    }
}

impl fmt::Display for Weighted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, (objective, weight)) in self.terms.iter().enumerate() {
            let comma = if number > 0 { "," } else { "" };
            write!(f, "{comma}{objective}={weight}")?;
        }
        Ok(())
    }
}
