//! Planned layers as a program.
//!
//! Each piece of a path is one bead, from the outer edge of its first cell along the middles to the
//! outer edge of its last: as long as it has cells, with the same flow everywhere.
//! Where the zone changes within a piece, the old tool ends at the edge between the two cells, and
//! the new one begins there.

use beadwork_base::{Control, Interrupted};
use beadwork_gcode::{
    Command, Feature, Filament, Line, Move, Number, Program, Totals, TraceError, Wait,
};
use thiserror::Error;

use super::header::header;
use super::prime_tower::PrimeTowerPlan;
use super::{Flavour, Layer, Nozzles, Process, Settings, SettingsError, Tool, layer};
use crate::Frame;

/// What the head of a file says of it.
#[derive(Clone, Copy, Debug)]
pub struct Title<'a> {
    /// Name of the part.
    pub part: &'a str,
    /// Version of beadwork.
    pub version: &'a str,
}

/// A print: what the printer does, and what that takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Print {
    /// The program.
    pub program: Program,
    /// What it takes.
    pub totals: Totals,
}

/// Why layers could not be written as a program.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PrintError {
    /// The layers, the frame and the settings are invalid or do not fit together.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The call was cancelled or ran out of time.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Decimals of places, as printers and slicers use them, and of filament.
pub(super) const PLACE_DECIMALS: u32 = 3;
const FILAMENT_DECIMALS: u32 = 5;

/// Where the head waits for the heat, in mm above the bed, if the printer is so high: away from the
/// bed, on which it would drip and stick.
const START_LIFT_MM: f64 = 5.0;

/// Speed of that lift, in mm/s, unless the printer is slower: a z axis is slow, and nothing has
/// been set so far.
const START_LIFT_MM_S: f64 = 10.0;

/// How far the head rises at least for a change of tools, in mm, if the printer is so high: one
/// that stood on the part would melt it.
const CHANGE_LIFT_MM: f64 = 1.0;

/// How far the head rises at the end, in mm, if the printer is so high.
const END_LIFT_MM: f64 = 10.0;

/// What Marlin accepts as junction deviation, in mm; it ignores anything else.
const JUNCTION_DEVIATIONS_MM: [f64; 2] = [0.01, 0.3];

impl Print {
    /// Writes the program of these layers, which are numbered from 0 without a gap.
    /// Linear in the cells.
    ///
    /// Every tool is taken to begin with its filament drawn back by `retract_mm`, as the end of a
    /// print leaves it.
    pub fn new(
        title: Title<'_>,
        layers: &[Layer<'_>],
        frame: &Frame,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Self, PrintError> {
        settings.check(frame)?;
        layer::check(layers, frame, settings)?;
        let tower = PrimeTowerPlan::new(layers, frame, settings)?;
        let first = layers[0].zones.id(layers[0].path.order()[0]);
        let mut writer = Writer::new(frame, settings, first, used(layers, settings));
        writer.start();
        for part in layers {
            control.check()?;
            writer.layer(part, tower.as_ref().filter(|tower| part.number <= tower.last_layer));
            control.report(part.number + 1, layers.len());
        }
        writer.end();
        let body = Program { lines: writer.lines };
        let filaments: Vec<Filament> = settings.tools.iter().map(Tool::filament).collect();
        let control = control.without_progress();
        let totals = Totals::measure(&body, settings.printer.limits(), &filaments, &control)
            .map_err(|error| match error {
                TraceError::Interrupted(interrupted) => interrupted,
                _ => unreachable!("checked settings make speeds above 0 and no arcs"),
            })?;
        let lifts = layers.iter().map(|layer| layer.path.pieces() as usize - 1).sum();
        let totals = Totals { layers: layers.len(), lifts, ..totals };
        let mut lines = header(title, frame, settings, &totals);
        lines.extend(body.lines);
        Ok(Self { program: Program { lines }, totals })
    }
}

/// Writes the lines, and knows where the head is and what it has done.
struct Writer<'a> {
    frame: &'a Frame,
    settings: &'a Settings,
    bead_mm2: f64,
    lines: Vec<Line>,
    /// Where the head is, rounded as it was written; `None` if that is not known: at the beginning,
    /// and after a change of tools, during which the printer goes where it likes.
    at: [Option<Number>; 3],
    feed: Option<Number>,
    /// At least so high goes the next travel, in mm; 0 if it does not matter.
    clear_mm: f64,
    feature: Feature,
    tool: u8,
    /// The tools that print anything.
    used: Vec<u8>,
    /// For each tool, whether its filament is drawn back.
    drawn: Vec<bool>,
    /// For each tool, the filament that rounding has kept back so far, in mm: from the part and
    /// from the tower.
    /// One sum for both would let the tower take a little from the part at each change.
    owed_mm: Vec<[f64; 2]>,
    /// z of the layer, in mm.
    top_mm: f64,
    /// Speed of printing in this layer.
    print_mm_s: f64,
    fan_runs: bool,
}

impl<'a> Writer<'a> {
    fn new(frame: &'a Frame, settings: &'a Settings, tool: u8, used: Vec<u8>) -> Self {
        let tools = settings.tools.len();
        Self {
            frame,
            settings,
            bead_mm2: settings.process.bead_mm2(frame),
            lines: Vec::new(),
            at: [None; 3],
            feed: None,
            clear_mm: 0.0,
            feature: Feature::Unknown,
            tool,
            used,
            drawn: vec![settings.process.retract_mm > 0.0; tools],
            owed_mm: vec![[0.0; 2]; tools],
            top_mm: 0.0,
            print_mm_s: settings.process.print_mm_s,
            fan_runs: false,
        }
    }

    fn process(&self) -> &'a Process {
        &self.settings.process
    }

    fn selected(&self) -> &'a Tool {
        &self.settings.tools[usize::from(self.tool)]
    }

    fn command(&mut self, command: Command) {
        self.lines.push(Line::from(command));
    }

    fn other(&mut self, text: &'static str) {
        self.command(Command::other(text).expect("only codes without a type are written here"));
    }

    fn comment(&mut self, text: String) {
        self.lines.push(comment(text));
    }

    fn start(&mut self) {
        let bed = number(self.process().bed_c, PLACE_DECIMALS);
        self.feature(Feature::Custom);
        self.other("G21");
        self.modes();
        self.command(Command::BedTemperature { celsius: bed, wait: false });
        self.heat_first(Wait::No);
        self.command(Command::Home { x: false, y: false, z: false });
        let printer = &self.settings.printer;
        self.clear_mm = START_LIFT_MM.min(printer.bed_mm[2]);
        let speed = START_LIFT_MM_S.min(printer.max_speed_mm_s);
        self.go([None, None, Some(number(self.clear_mm, PLACE_DECIMALS))], None, speed);
        self.command(Command::BedTemperature { celsius: bed, wait: true });
        self.heat_first(Wait::Heating);
        // Printers that fetch a tool or load filament refuse to while they are cold or not homed.
        self.select(self.tool);
        self.command(Command::Fan(None));
        self.limits();
    }

    /// Coordinates are places, and filament is counted from move to move.
    /// In this order: `G90` makes Marlin count filament from the start.
    fn modes(&mut self) {
        self.command(Command::AbsolutePositioning);
        self.command(Command::RelativeExtrusion);
    }

    /// Heats what prints first: the one nozzle, or all of them, so that no change has to wait.
    fn heat_first(&mut self, wait: Wait) {
        match self.settings.printer.nozzles {
            Nozzles::Shared => self.heat(self.tool, None, wait),
            Nozzles::Own => {
                for tool in self.used.clone() {
                    self.heat(tool, Some(tool), wait);
                }
            }
        }
    }

    /// Heats a nozzle to the temperature of a tool.
    fn heat(&mut self, of: u8, tool: Option<u8>, wait: Wait) {
        let celsius = number(self.settings.tools[usize::from(of)].nozzle_c, PLACE_DECIMALS);
        self.command(Command::NozzleTemperature { celsius, tool, wait });
    }

    fn limits(&mut self) {
        let printer = &self.settings.printer;
        let acceleration = Some(number(printer.acceleration_mm_s2, PLACE_DECIMALS));
        let square_corner = Some(number(printer.square_corner_mm_s, PLACE_DECIMALS));
        match printer.flavour {
            Flavour::Marlin => {
                self.command(Command::Acceleration {
                    print: acceleration,
                    travel: acceleration,
                    retract: None,
                    all: None,
                });
                // Each Marlin knows one of the two, as it was built.
                // The deviation gives the same corners as Klipper's square corner velocity.
                let corner2 = printer.square_corner_mm_s * printer.square_corner_mm_s;
                let deviation =
                    corner2 * (std::f64::consts::SQRT_2 - 1.0) / printer.acceleration_mm_s2;
                let [least, most] = JUNCTION_DEVIATIONS_MM;
                let junction_deviation =
                    Some(number(deviation.clamp(least, most), FILAMENT_DECIMALS));
                self.command(Command::Jerk {
                    x: square_corner,
                    y: square_corner,
                    z: None,
                    e: None,
                    junction_deviation,
                });
            }
            Flavour::Klipper => {
                self.command(Command::VelocityLimit {
                    velocity: None,
                    acceleration,
                    square_corner,
                });
            }
        }
    }

    /// Selects a tool; how the printer does it, and where the head is then, is not known.
    fn select(&mut self, tool: u8) {
        self.tool = tool;
        self.command(Command::Tool(tool));
        self.at = [None; 3];
        self.feed = None;
        // What is done to change tools may have set others.
        self.modes();
    }

    fn layer(&mut self, part: &Layer<'_>, tower: Option<&PrimeTowerPlan>) {
        let process = self.process();
        let index = part.number;
        self.top_mm = self.frame.top_mm(index);
        self.print_mm_s = if index == 0 { process.first_layer_mm_s } else { process.print_mm_s };
        self.comment("LAYER_CHANGE".to_owned());
        self.comment(format!("Z:{}", number(self.top_mm, PLACE_DECIMALS)));
        self.comment(format!("HEIGHT:{}", number(self.frame.layer_mm, PLACE_DECIMALS)));
        self.feature = Feature::Unknown;
        if process.fan > 0.0 && index >= process.fan_from_layer && !self.fan_runs {
            self.fan_runs = true;
            self.command(Command::Fan(Some(number(255.0 * process.fan, 0))));
        }
        if let Some(tower) = tower {
            let purged = self.purged_rows(part, tower);
            self.tower_bead(tower, &tower.outline());
            let rest = if index == 0 {
                tower.solid(purged, tower.rows() - purged)
            } else {
                tower.sparse(purged)
            };
            self.tower_bead(tower, &rest);
        }
        let mut rows = 0;
        for run in part.runs() {
            if run.zone != self.tool {
                let needed = self.rows_for(run.zone, tower);
                self.change_tool(run.zone, tower.map(|tower| (tower, rows, needed)));
                rows += needed;
            }
            self.part_bead(&run.corners(|cell| part.place(cell)));
        }
    }

    /// Rows of the tower that a layer purges into.
    fn purged_rows(&self, part: &Layer<'_>, tower: &PrimeTowerPlan) -> i32 {
        let mut tool = self.tool;
        let rows = part.runs().map(|run| {
            let before = std::mem::replace(&mut tool, run.zone);
            self.rows_between(before, run.zone, tower)
        });
        rows.sum()
    }

    fn rows_between(&self, from: u8, to: u8, tower: &PrimeTowerPlan) -> i32 {
        let purge = self.settings.purge.as_ref();
        tower.rows_of(purge.map_or(0.0, |purge| purge.prime_tower_mm3(from, to)))
    }

    fn rows_for(&self, to: u8, tower: Option<&PrimeTowerPlan>) -> i32 {
        tower.map_or(0, |tower| self.rows_between(self.tool, to, tower))
    }

    /// Changes to a tool; purges into so many rows of the tower.
    fn change_tool(&mut self, to: u8, tower: Option<(&PrimeTowerPlan, i32, i32)>) {
        self.draw_back();
        let slot = tower.filter(|&(_, _, rows)| rows > 0);
        let slot = slot.map(|(tower, begin, rows)| (tower, tower.solid(begin, rows)));
        let speed = self.process().travel_mm_s;
        self.clear_mm = self.lifted_mm(self.process().z_hop_mm.max(CHANGE_LIFT_MM));
        self.go([None, None, Some(number(self.clear_mm, PLACE_DECIMALS))], None, speed);
        if let Some((tower, corners)) = &slot {
            // Whatever drips during the change drips where the purge covers it.
            let [x, y] = tower.place(corners[0]).map(|value| Some(number(value, PLACE_DECIMALS)));
            self.go([x, y, None], None, speed);
        }
        let before = self.selected().nozzle_c;
        self.select(to);
        let after = self.selected().nozzle_c;
        let printer = &self.settings.printer;
        if printer.nozzles == Nozzles::Shared && (before - after).abs() > 0.0 {
            // Klipper waits for a nozzle that cools, too, and takes no other word for it.
            let cools = after < before && printer.flavour == Flavour::Marlin;
            self.heat(to, None, if cools { Wait::HeatingOrCooling } else { Wait::Heating });
        }
        if let Some((tower, corners)) = &slot {
            self.tower_bead(tower, corners);
            self.draw_back();
        }
    }

    /// So far above the layer, in mm, or as far as the printer goes.
    fn lifted_mm(&self, by_mm: f64) -> f64 {
        (self.top_mm + by_mm).min(self.settings.printer.bed_mm[2]).max(self.top_mm)
    }

    fn part_bead(&mut self, corners: &[[i32; 2]]) {
        let Frame { left_mm, back_mm, cell_mm, .. } = *self.frame;
        let along = |halves: i32| f64::from(halves) / 2.0 * cell_mm;
        self.bead(Feature::SolidInfill, corners, |[x, y]| [left_mm + along(x), back_mm - along(y)]);
    }

    fn tower_bead(&mut self, tower: &PrimeTowerPlan, corners: &[[i32; 2]]) {
        self.bead(Feature::PrimeTower, corners, |corner| tower.place(corner));
    }

    /// Lays a bead along corners, which are given in halves of a cell.
    fn bead(
        &mut self,
        feature: Feature,
        corners: &[[i32; 2]],
        place: impl Fn([i32; 2]) -> [f64; 2],
    ) {
        let Some(&first) = corners.first() else { return };
        self.travel(place(first));
        if feature != self.feature {
            self.feature(feature);
            self.comment(format!("WIDTH:{}", number(self.frame.cell_mm, PLACE_DECIMALS)));
        }
        self.push_out();
        let mm_per_half = 0.5 * self.frame.cell_mm * self.bead_mm2 / self.selected().filament_mm2();
        for pair in corners.windows(2) {
            let halves = pair[0][0].abs_diff(pair[1][0]) + pair[0][1].abs_diff(pair[1][1]);
            let owed = &mut self.owed_mm[usize::from(self.tool)]
                [usize::from(feature == Feature::PrimeTower)];
            *owed += f64::from(halves) * mm_per_half;
            let e = number(*owed, FILAMENT_DECIMALS);
            *owed -= e.to_f64();
            let [x, y] = place(pair[1]).map(|value| number(value, PLACE_DECIMALS));
            self.go([Some(x), Some(y), None], Some(e), self.print_mm_s);
        }
    }

    /// Goes to the beginning of a bead, in the height of the layer.
    fn travel(&mut self, to: [f64; 2]) {
        let [x, y] = to.map(|value| number(value, PLACE_DECIMALS));
        let distance = match self.at {
            [Some(from_x), Some(from_y), _] => {
                let (dx, dy) = (x.to_f64() - from_x.to_f64(), y.to_f64() - from_y.to_f64());
                (dx * dx + dy * dy).sqrt()
            }
            _ => f64::INFINITY,
        };
        let process = self.process();
        if distance > process.retract_beyond_mm {
            self.draw_back();
        }
        let lifted = process.z_hop_mm > 0.0 && distance > 0.0 && self.drawn[usize::from(self.tool)];
        let hop = if lifted { process.z_hop_mm } else { 0.0 };
        let height = f64::max(self.top_mm + hop, std::mem::take(&mut self.clear_mm));
        let speed = process.travel_mm_s;
        // Up before across: the layer below may be in the way.
        self.go([None, None, Some(number(height, PLACE_DECIMALS))], None, speed);
        self.go([Some(x), Some(y), None], None, speed);
        self.go([None, None, Some(number(self.top_mm, PLACE_DECIMALS))], None, speed);
    }

    /// A move; only what changes is written, and nothing if nothing does.
    fn go(&mut self, to: [Option<Number>; 3], e: Option<Number>, speed_mm_s: f64) {
        let changed = |axis: usize| to[axis].filter(|_| to[axis] != self.at[axis]);
        let [x, y, z] = [0, 1, 2].map(changed);
        if x.or(y).or(z).or(e.filter(|&e| e != Number::ZERO)).is_none() {
            return;
        }
        self.at = [0, 1, 2].map(|axis| to[axis].or(self.at[axis]));
        let f = self.feed_to(speed_mm_s);
        self.command(Command::Move(Move { rapid: false, x, y, z, e, f }));
    }

    fn feed_to(&mut self, speed_mm_s: f64) -> Option<Number> {
        let feed = number(60.0 * speed_mm_s, PLACE_DECIMALS);
        (self.feed.replace(feed) != Some(feed)).then_some(feed)
    }

    fn draw_back(&mut self) {
        if self.process().retract_mm > 0.0 && !self.drawn[usize::from(self.tool)] {
            self.drawn[usize::from(self.tool)] = true;
            self.filament(-self.process().retract_mm);
        }
    }

    fn push_out(&mut self) {
        if std::mem::replace(&mut self.drawn[usize::from(self.tool)], false) {
            self.filament(self.process().retract_mm);
        }
    }

    fn filament(&mut self, length_mm: f64) {
        self.go([None; 3], Some(number(length_mm, FILAMENT_DECIMALS)), self.process().retract_mm_s);
    }

    fn feature(&mut self, feature: Feature) {
        self.feature = feature;
        self.comment(format!("TYPE:{}", feature.name()));
    }

    fn end(&mut self) {
        self.draw_back();
        self.feature(Feature::Custom);
        let lifted = number(self.lifted_mm(END_LIFT_MM), PLACE_DECIMALS);
        self.go([None, None, Some(lifted)], None, self.process().travel_mm_s);
        match self.settings.printer.flavour {
            Flavour::Marlin => {
                let off = |tool| Command::NozzleTemperature {
                    celsius: Number::ZERO,
                    tool,
                    wait: Wait::No,
                };
                // A tool that was put aside may have a heater of its own; the last line is for
                // printers that number their tools otherwise.
                if self.used.len() > 1 {
                    for tool in self.used.clone() {
                        self.command(off(Some(tool)));
                    }
                }
                self.command(off(None));
                self.command(Command::BedTemperature { celsius: Number::ZERO, wait: false });
            }
            Flavour::Klipper => self.other("TURN_OFF_HEATERS"),
        }
        self.command(Command::Fan(None));
        self.other("M84");
    }
}

/// The tools that print anything, in their order.
fn used(layers: &[Layer<'_>], settings: &Settings) -> Vec<u8> {
    let prints = |tool: &u8| layers.iter().any(|layer| layer.zones.ids().contains(tool));
    (0..settings.tools.len()).map(|tool| tool as u8).filter(prints).collect()
}

/// A comment; line breaks and other control characters in names become blanks.
pub(super) fn comment(text: String) -> Line {
    let text =
        if text.contains(char::is_control) { text.replace(char::is_control, " ") } else { text };
    Line::new(None, Some(text)).expect("it has no line break")
}

/// A value of the settings or made of them.
pub(super) fn number(value: f64, decimals: u32) -> Number {
    Number::from_f64(value, decimals)
        .expect("checked settings and what a bed holds are far below the limit")
}

#[cfg(test)]
mod tests;
