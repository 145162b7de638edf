//! What the reports of all plans have in common: totals, prime tower, wall-clock time.

use std::fmt::{self, Write};

use beadwork_console::text::duration;
use beadwork_gcode::Totals;
use beadwork_part::print::Settings;
use serde_json::{Value, json};

/// Wall-clock time of the steps, in s.
pub(super) struct Seconds {
    /// Reading, repairing and slicing.
    pub(super) slice: f64,
    /// Planning.
    pub(super) plan: f64,
    /// Writing and checking the G-code.
    pub(super) print: f64,
}

impl Seconds {
    pub(super) fn json(&self) -> Value {
        json!({ "slice": self.slice, "plan": self.plan, "print": self.print })
    }

    /// Writes the last line of a summary.
    pub(super) fn write(&self, text: &mut String) -> fmt::Result {
        let Self { slice, plan, print } = self;
        writeln!(
            text,
            "{slice:.2} s to slice, {plan:.2} s to plan, {print:.2} s to write and check"
        )
    }
}

/// The totals of a program as a JSON object with more keys, which replace equal ones.
pub(super) fn with_totals(totals: &Totals, more: Value) -> Value {
    extended(json!(totals), more)
}

/// A JSON object with more keys, which replace equal ones.
pub(super) fn extended(mut value: Value, more: Value) -> Value {
    if let (Value::Object(value), Value::Object(more)) = (&mut value, more) {
        value.extend(more);
    }
    value
}

/// Position of the prime tower, if anything is purged into it.
pub(super) fn tower(settings: &Settings, totals: &Totals) -> Option<Value> {
    let tower = settings.purge.as_ref()?.tower.filter(|_| totals.prime_tower_mm > 0.0)?;
    Some(json!({
        "left_mm": tower.left_mm, "front_mm": tower.front_mm, "width_mm": tower.width_mm,
    }))
}

/// Writes a line with printing time, filament and lengths.
pub(super) fn write_totals(text: &mut String, totals: &Totals) -> fmt::Result {
    let grams: f64 = totals.tools.iter().map(|tool| tool.grams).sum();
    writeln!(
        text,
        "{} to print, {grams:.1} g, {:.1} m of beads, {:.1} m of travel",
        duration(totals.print_seconds),
        totals.extrusion_mm / 1000.0,
        totals.travel_mm / 1000.0,
    )
}
