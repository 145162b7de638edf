//! What a plan for even temperature gains, as JSON and as lines of a summary.

use std::fmt::{self, Write};

use beadwork_heat::bound::HeatBound;
use beadwork_thermal::objective::{HeatMeasures, Objective, Weighted};
use serde_json::{Value, json};

use super::args::PlannerName;

pub(super) struct Gains<'a> {
    pub(super) planner: PlannerName,
    pub(super) objective: &'a Weighted,
    /// Measures of the plan, and of the conventional order.
    pub(super) measures: &'a HeatMeasures,
    pub(super) baseline: &'a HeatMeasures,
    /// Expected limit of the gain without travel; `None` if it is not known.
    pub(super) bound: Option<&'a HeatBound>,
    /// Wall-clock time of the planner alone.
    pub(super) planning_seconds: f64,
    /// Names of the orders of the layers.
    pub(super) orders: Vec<String>,
}

impl Gains<'_> {
    fn of(&self, objective: Objective) -> Option<f64> {
        objective.gain_percent(self.measures, self.baseline)
    }

    /// The object `heat` of a document.
    pub(super) fn json(&self) -> Value {
        let Self { measures, baseline, bound, .. } = self;
        json!({
            "planner": self.planner.to_string(),
            "objective": self.objective.to_string(),
            "reward": measures.reward(),
            "conventional_reward": baseline.reward(),
            "gain_percent": self.of(Objective::Reward),
            "no_travel_gain_percent": self.of(Objective::NoTravel),
            "time_averaged_gain_percent": self.of(Objective::TimeAveraged),
            "warpage_mm": measures.warpage_mm,
            "conventional_warpage_mm": baseline.warpage_mm,
            "print_seconds": measures.print_seconds(),
            "conventional_print_seconds": baseline.print_seconds(),
            "planning_seconds": self.planning_seconds,
            // Of the gain if travel takes no time; by an argument, not a proof.
            "bound_percent": bound.and_then(HeatBound::any_order_percent),
            "whole_lines_bound_percent": bound.and_then(HeatBound::whole_lines_percent),
            "orders": self.orders,
        })
    }

    /// Writes the gains; `what` is printed in the stated time.
    pub(super) fn write(&self, text: &mut String, what: &str) -> fmt::Result {
        let Self { measures, baseline, .. } = self;
        let percent =
            |gain: Option<f64>| gain.map_or("-".to_owned(), |gain| format!("{gain:.1} %"));
        writeln!(
            text,
            "more even than the conventional order: {} at the layers' ends ({} if travel took no \
             time), {} on average over time",
            percent(self.of(Objective::Reward)),
            percent(self.of(Objective::NoTravel)),
            percent(self.of(Objective::TimeAveraged)),
        )?;
        if let Some(bound) = self.bound {
            writeln!(
                text,
                "expected limit of the gain if travel took no time: {} for orders of whole \
                 lines, {} for any order",
                percent(bound.whole_lines_percent()),
                percent(bound.any_order_percent()),
            )?;
        }
        let longer = 100.0 * (measures.print_seconds() / baseline.print_seconds() - 1.0);
        write!(text, "printing time of {what}: {longer:+.1} %")?;
        if let (Some(lift), Some(before)) = (measures.warpage_mm, baseline.warpage_mm) {
            write!(
                text,
                "; estimated lift of the outline: {lift:.3} mm, conventional {before:.3} mm"
            )?;
        }
        writeln!(text)
    }
}
