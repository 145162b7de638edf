//! The results of a plan of beads for even temperature, as JSON and as a summary.

use beadwork_console::beads::{BeadPart, PrintedBeads};
use serde_json::{Value, json};

use super::args::Files;
use super::bead_report::{of_beads, write_gcode, write_part};
use super::gains::Gains;
use super::totals::{Seconds, extended, write_totals};

pub(super) struct BeadHeatReport<'a> {
    pub(super) part: &'a BeadPart,
    pub(super) printed: &'a PrintedBeads,
    pub(super) gains: Gains<'a>,
    pub(super) seconds: Seconds,
}

impl BeadHeatReport<'_> {
    /// All results; only the seconds differ between two runs.
    pub(super) fn json(&self) -> Value {
        let more = json!({
            "beads": self.printed.checked.beads,
            "heat": self.gains.json(),
            "seconds": self.seconds.json(),
        });
        extended(of_beads(self.part, self.printed), more)
    }

    /// A few lines of text.
    pub(super) fn text(&self, files: &Files<'_>) -> String {
        let mut text = String::new();
        self.write(&mut text, files).expect("writing to a string succeeds");
        text
    }

    fn write(&self, text: &mut String, files: &Files<'_>) -> std::fmt::Result {
        write_part(text, self.part, self.printed)?;
        self.gains.write(text, "the beads")?;
        write_totals(text, &self.printed.totals)?;
        write_gcode(text, self.printed, files)?;
        self.seconds.write(text)
    }
}
