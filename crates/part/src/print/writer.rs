//! Writes layers as G-code commands.
//!
//! Each piece of a path is one bead with constant flow per length; it runs from the outer edge of
//! its first cell through the centres of the cells to the outer edge of its last one.
//! Where the zone changes within a piece, the old tool stops at the edge between the two cells, and
//! the new tool continues from there after a tool change.
//!
//! # State
//! The [`Writer`] tracks the state of the printer: position, feed rate, tool, retraction.
//! So it writes only parameters that change, and omits travel that would not move the nozzle.
//! It tracks positions as rounded for the file, because the printer moves between rounded
//! positions.
//!
//! # Filament
//! Filament lengths are relative to the previous move (`M83`) and rounded to 5 decimals.
//! The rounding error of each move is carried into the next one, so it does not add up.
//!
//! # Travel
//! Between two beads the filament is retracted if they are far enough apart
//! ([`Process::retract_beyond_mm`]), and the nozzle is raised while it is retracted
//! ([`Process::z_hop_mm`]); see [`Writer::travel`].

use beadwork_gcode::{Command, Feature, Line, LinearMove, Number, Wait};

use super::layer::Layer;
use super::prime_tower::PrimeTowerPlan;
use super::settings::{Flavour, Nozzles, Process, Settings, Tool};
use super::text::{DECIMALS, FILAMENT_DECIMALS, comment, number};
use crate::Frame;

/// Height above the bed at which the nozzle waits until it is hot, in mm, or the maximum height of
/// the printer if that is less: closer to the bed, filament would ooze onto it and stick.
const HEATING_HEIGHT_MM: f64 = 5.0;

/// Speed of the move to [`HEATING_HEIGHT_MM`], in mm/s, unless the printer is slower.
/// The z axis is slow, and the file has not set any limits yet.
const HEATING_MOVE_MM_S: f64 = 10.0;

/// Minimum z-hop of a tool change, in mm, unless the printer's height limits it: a nozzle that
/// rests on the part would melt it.
const TOOL_CHANGE_HOP_MM: f64 = 1.0;

/// Rise of the nozzle at the end, in mm, unless the printer's height limits it.
const END_RISE_MM: f64 = 10.0;

/// The junction deviations that Marlin accepts, in mm; it ignores all others.
const JUNCTION_DEVIATIONS_MM: [f64; 2] = [0.01, 0.3];

/// The lines written so far, and the state of the printer after them.
pub(super) struct Writer<'a> {
    frame: &'a Frame,
    settings: &'a Settings,
    /// Cross-sectional area of a bead.
    bead_mm2: f64,
    lines: Vec<Line>,
    /// Position of the nozzle as it was written; `None` where it is unknown: at the start, and
    /// after a tool change, during which the printer moves on its own.
    position: [Option<Number>; 3],
    /// Feed rate in mm/min; `None` if unknown.
    feed: Option<Number>,
    /// Minimum z of the next travel in mm, set by heating and tool changes; 0 if there is none.
    clearance_mm: f64,
    /// The feature of the last `;TYPE:` comment.
    feature: Feature,
    tool: u8,
    /// The tools that print anything.
    used_tools: Vec<u8>,
    /// For each tool, whether its filament is retracted.
    is_retracted: Vec<bool>,
    /// For each tool, the filament in mm that rounding has withheld from the part and from the
    /// prime tower, which is added to its next move.
    /// The two are separate: with a common sum, the tower would receive a little of the part's
    /// filament at each change.
    withheld_mm: Vec<[f64; 2]>,
    /// z of the current layer, in mm.
    top_mm: f64,
    /// Printing speed of the current layer, in mm/s.
    print_mm_s: f64,
    is_fan_on: bool,
}

impl<'a> Writer<'a> {
    /// A writer at the start of a file; `tool` prints first.
    pub(super) fn new(
        frame: &'a Frame,
        settings: &'a Settings,
        tool: u8,
        used_tools: Vec<u8>,
    ) -> Self {
        let tools = settings.tools.len();
        Self {
            frame,
            settings,
            bead_mm2: settings.process.bead_mm2(frame),
            lines: Vec::new(),
            position: [None; 3],
            feed: None,
            clearance_mm: 0.0,
            feature: Feature::Unknown,
            tool,
            used_tools,
            is_retracted: vec![settings.process.retract_mm > 0.0; tools],
            withheld_mm: vec![[0.0; 2]; tools],
            top_mm: 0.0,
            print_mm_s: settings.process.print_mm_s,
            is_fan_on: false,
        }
    }

    pub(super) fn into_lines(self) -> Vec<Line> {
        self.lines
    }

    fn process(&self) -> &'a Process {
        &self.settings.process
    }

    fn current_tool(&self) -> &'a Tool {
        &self.settings.tools[usize::from(self.tool)]
    }

    fn command(&mut self, command: Command) {
        self.lines.push(Line::from(command));
    }

    /// Writes a command that has no variant of [`Command`].
    fn other(&mut self, text: &'static str) {
        self.command(Command::other(text).expect("callers pass only such commands"));
    }

    fn comment(&mut self, text: String) {
        self.lines.push(comment(text));
    }

    /// Heats, homes, selects the first tool and sets the limits.
    ///
    /// The nozzle heats up while it homes, and waits above the bed until it is hot.
    pub(super) fn start(&mut self) {
        let bed = number(self.process().bed_c, DECIMALS);
        self.feature(Feature::Custom);
        self.other("G21");
        self.modes();
        self.command(Command::BedTemperature { celsius: bed, wait: false });
        self.heat_first(Wait::No);
        self.command(Command::Home { x: false, y: false, z: false });
        let printer = &self.settings.printer;
        self.clearance_mm = HEATING_HEIGHT_MM.min(printer.bed_mm[2]);
        let speed = HEATING_MOVE_MM_S.min(printer.max_speed_mm_s);
        self.move_to([None, None, Some(number(self.clearance_mm, DECIMALS))], None, speed);
        self.command(Command::BedTemperature { celsius: bed, wait: true });
        self.heat_first(Wait::Heating);
        // Printers that pick up a tool or load filament refuse to do so before they are hot and
        // homed.
        self.select(self.tool);
        self.command(Command::Fan(None));
        self.limits();
    }

    /// Absolute positioning (`G90`), then relative extrusion (`M83`).
    /// The order matters: in Marlin, `G90` also makes extrusion absolute.
    fn modes(&mut self) {
        self.command(Command::AbsolutePositioning);
        self.command(Command::RelativeExtrusion);
    }

    /// Heats the shared nozzle for the first tool, or the nozzles of all used tools, so that no
    /// tool change has to wait for heat.
    fn heat_first(&mut self, wait: Wait) {
        match self.settings.printer.nozzles {
            Nozzles::Shared => self.heat(self.tool, None, wait),
            Nozzles::Own => {
                for tool in self.used_tools.clone() {
                    self.heat(tool, Some(tool), wait);
                }
            }
        }
    }

    /// Heats a nozzle to the temperature of `tool`; `nozzle` is `None` for the shared one.
    fn heat(&mut self, tool: u8, nozzle: Option<u8>, wait: Wait) {
        let celsius = number(self.settings.tools[usize::from(tool)].nozzle_c, DECIMALS);
        self.command(Command::NozzleTemperature { celsius, tool: nozzle, wait });
    }

    /// Sets acceleration and cornering.
    fn limits(&mut self) {
        let printer = &self.settings.printer;
        let acceleration = Some(number(printer.acceleration_mm_s2, DECIMALS));
        let square_corner = Some(number(printer.square_corner_mm_s, DECIMALS));
        match printer.flavour {
            Flavour::Marlin => {
                self.command(Command::Acceleration {
                    print: acceleration,
                    travel: acceleration,
                    retract: None,
                    all: None,
                });
                // A build of Marlin obeys either the jerk or the junction deviation, so both are
                // written.
                // This deviation allows the speed of the settings at a right angle, as Klipper's
                // square corner velocity does.
                let corner2 = printer.square_corner_mm_s * printer.square_corner_mm_s;
                let deviation =
                    corner2 * (std::f64::consts::SQRT_2 - 1.0) / printer.acceleration_mm_s2;
                let [min, max] = JUNCTION_DEVIATIONS_MM;
                let junction_deviation = Some(number(deviation.clamp(min, max), FILAMENT_DECIMALS));
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

    /// Selects a tool.
    /// The printer performs the change as it is configured to, so its position is unknown
    /// afterwards.
    fn select(&mut self, tool: u8) {
        self.tool = tool;
        self.command(Command::Tool(tool));
        self.position = [None; 3];
        self.feed = None;
        // The macros of a tool change may have set other modes.
        self.modes();
    }

    /// Writes a layer: first the outline and the rows of the prime tower that no tool change will
    /// fill, if the layer has a tower, then the runs of the part, with tool changes between them.
    pub(super) fn layer(&mut self, layer: &Layer<'_>, tower: Option<&PrimeTowerPlan>) {
        let process = self.process();
        let index = layer.number;
        self.top_mm = self.frame.top_mm(index);
        self.print_mm_s = if index == 0 { process.first_layer_mm_s } else { process.print_mm_s };
        self.comment("LAYER_CHANGE".to_owned());
        self.comment(format!("Z:{}", number(self.top_mm, DECIMALS)));
        self.comment(format!("HEIGHT:{}", number(self.frame.layer_mm, DECIMALS)));
        self.feature = Feature::Unknown;
        if process.fan > 0.0 && index >= process.fan_from_layer && !self.is_fan_on {
            self.is_fan_on = true;
            self.command(Command::Fan(Some(number(255.0 * process.fan, 0))));
        }
        if let Some(tower) = tower {
            let purged = self.purged_rows(layer, tower);
            self.tower_bead(tower, &tower.outline());
            let rest = if index == 0 {
                tower.solid(purged, tower.rows() - purged)
            } else {
                tower.sparse(purged)
            };
            self.tower_bead(tower, &rest);
        }
        let mut rows = 0;
        for run in layer.runs() {
            if run.zone != self.tool {
                let needed = tower.map_or(0, |tower| self.rows_between(self.tool, run.zone, tower));
                self.change_tool(run.zone, tower.map(|tower| (tower, rows, needed)));
                rows += needed;
            }
            self.part_bead(&run.toolpath(|cell| layer.column_and_row(cell)));
        }
    }

    /// Number of rows of the tower that a layer purges into.
    fn purged_rows(&self, layer: &Layer<'_>, tower: &PrimeTowerPlan) -> i32 {
        let mut tool = self.tool;
        let rows = layer.runs().map(|run| {
            let before = std::mem::replace(&mut tool, run.zone);
            self.rows_between(before, run.zone, tower)
        });
        rows.sum()
    }

    /// Number of rows that a tool change purges into.
    fn rows_between(&self, from: u8, to: u8, tower: &PrimeTowerPlan) -> i32 {
        let purge = self.settings.purge.as_ref();
        tower.rows_for(purge.map_or(0.0, |purge| purge.prime_tower_mm3(from, to)))
    }

    /// Changes to a tool and purges into `tower`, which is given with its first free row and the
    /// number of rows to fill.
    ///
    /// The filament is retracted, the nozzle is raised, and the change takes place above the first
    /// of these rows.
    fn change_tool(&mut self, to: u8, tower: Option<(&PrimeTowerPlan, i32, i32)>) {
        self.retract();
        let purge = tower.filter(|&(_, _, rows)| rows > 0);
        let purge = purge.map(|(tower, begin, rows)| (tower, tower.solid(begin, rows)));
        let speed = self.process().travel_mm_s;
        self.clearance_mm = self.raised_mm(self.process().z_hop_mm.max(TOOL_CHANGE_HOP_MM));
        self.move_to([None, None, Some(number(self.clearance_mm, DECIMALS))], None, speed);
        if let Some((tower, corners)) = &purge {
            // Filament that drips during the change is covered by the purge.
            let [x, y] = tower.position_mm(corners[0]).map(|value| Some(number(value, DECIMALS)));
            self.move_to([x, y, None], None, speed);
        }
        let before = self.current_tool().nozzle_c;
        self.select(to);
        let after = self.current_tool().nozzle_c;
        let printer = &self.settings.printer;
        if printer.nozzles == Nozzles::Shared && (before - after).abs() > 0.0 {
            // Klipper waits for a cooling nozzle as well, and does not know `M109 R`.
            let cools = after < before && printer.flavour == Flavour::Marlin;
            self.heat(to, None, if cools { Wait::HeatingOrCooling } else { Wait::Heating });
        }
        if let Some((tower, corners)) = &purge {
            self.tower_bead(tower, corners);
            self.retract();
        }
    }

    /// z in mm that is `by_mm` above the layer, or the printer's maximum if that is lower.
    fn raised_mm(&self, by_mm: f64) -> f64 {
        (self.top_mm + by_mm).min(self.settings.printer.bed_mm[2]).max(self.top_mm)
    }

    fn part_bead(&mut self, corners: &[[i32; 2]]) {
        let Frame { left_mm, back_mm, cell_mm, .. } = *self.frame;
        let along = |halves: i32| f64::from(halves) / 2.0 * cell_mm;
        self.bead(Feature::SolidInfill, corners, |[x, y]| [left_mm + along(x), back_mm - along(y)]);
    }

    fn tower_bead(&mut self, tower: &PrimeTowerPlan, corners: &[[i32; 2]]) {
        self.bead(Feature::PrimeTower, corners, |corner| tower.position_mm(corner));
    }

    /// Travels to the first corner and extrudes along the others.
    /// Corners are in units of half a cell; `position_mm` maps them to the bed.
    fn bead(
        &mut self,
        feature: Feature,
        corners: &[[i32; 2]],
        position_mm: impl Fn([i32; 2]) -> [f64; 2],
    ) {
        let Some(&first) = corners.first() else { return };
        self.travel(position_mm(first));
        if feature != self.feature {
            self.feature(feature);
            self.comment(format!("WIDTH:{}", number(self.frame.cell_mm, DECIMALS)));
        }
        self.unretract();
        let mm_per_half =
            0.5 * self.frame.cell_mm * self.bead_mm2 / self.current_tool().filament_mm2();
        for pair in corners.windows(2) {
            let halves = pair[0][0].abs_diff(pair[1][0]) + pair[0][1].abs_diff(pair[1][1]);
            let withheld = &mut self.withheld_mm[usize::from(self.tool)]
                [usize::from(feature == Feature::PrimeTower)];
            *withheld += f64::from(halves) * mm_per_half;
            let e = number(*withheld, FILAMENT_DECIMALS);
            *withheld -= e.to_f64();
            let [x, y] = position_mm(pair[1]).map(|value| number(value, DECIMALS));
            self.move_to([Some(x), Some(y), None], Some(e), self.print_mm_s);
        }
    }

    /// Travels to the start of a bead.
    ///
    /// Filament is retracted if the distance exceeds [`Process::retract_beyond_mm`] or is unknown,
    /// and the nozzle hops if the filament is retracted.
    /// The nozzle moves up, across and down again; moves that change nothing are not written.
    fn travel(&mut self, to: [f64; 2]) {
        let [x, y] = to.map(|value| number(value, DECIMALS));
        let distance = match self.position {
            [Some(from_x), Some(from_y), _] => {
                let (dx, dy) = (x.to_f64() - from_x.to_f64(), y.to_f64() - from_y.to_f64());
                (dx * dx + dy * dy).sqrt()
            }
            _ => f64::INFINITY,
        };
        let process = self.process();
        if distance > process.retract_beyond_mm {
            self.retract();
        }
        let is_hop =
            process.z_hop_mm > 0.0 && distance > 0.0 && self.is_retracted[usize::from(self.tool)];
        let hop = if is_hop { process.z_hop_mm } else { 0.0 };
        let height = f64::max(self.top_mm + hop, std::mem::take(&mut self.clearance_mm));
        let speed = process.travel_mm_s;
        // Up before across: at the height of the layer below, the nozzle would drag through its
        // beads.
        self.move_to([None, None, Some(number(height, DECIMALS))], None, speed);
        self.move_to([Some(x), Some(y), None], None, speed);
        self.move_to([None, None, Some(number(self.top_mm, DECIMALS))], None, speed);
    }

    /// Moves to a position, where `None` keeps a coordinate, and extrudes `e`.
    /// Writes only the parameters that change, and no move if none of them does.
    fn move_to(&mut self, to: [Option<Number>; 3], e: Option<Number>, speed_mm_s: f64) {
        let changed = |axis: usize| to[axis].filter(|_| to[axis] != self.position[axis]);
        let [x, y, z] = [0, 1, 2].map(changed);
        if x.or(y).or(z).or(e.filter(|&e| e != Number::ZERO)).is_none() {
            return;
        }
        self.position = [0, 1, 2].map(|axis| to[axis].or(self.position[axis]));
        let f = self.changed_feed(speed_mm_s);
        self.command(Command::Move(LinearMove { rapid: false, x, y, z, e, f }));
    }

    /// Sets the feed rate; returns it in mm/min if it changed.
    fn changed_feed(&mut self, speed_mm_s: f64) -> Option<Number> {
        let feed = number(60.0 * speed_mm_s, DECIMALS);
        (self.feed.replace(feed) != Some(feed)).then_some(feed)
    }

    /// Retracts the filament unless it is retracted already.
    fn retract(&mut self) {
        if self.process().retract_mm > 0.0 && !self.is_retracted[usize::from(self.tool)] {
            self.is_retracted[usize::from(self.tool)] = true;
            self.filament(-self.process().retract_mm);
        }
    }

    /// Unretracts the filament if it is retracted.
    fn unretract(&mut self) {
        if std::mem::replace(&mut self.is_retracted[usize::from(self.tool)], false) {
            self.filament(self.process().retract_mm);
        }
    }

    /// Moves filament without moving the nozzle.
    fn filament(&mut self, length_mm: f64) {
        self.move_to(
            [None; 3],
            Some(number(length_mm, FILAMENT_DECIMALS)),
            self.process().retract_mm_s,
        );
    }

    /// Begins a feature with its `;TYPE:` comment.
    fn feature(&mut self, feature: Feature) {
        self.feature = feature;
        self.comment(format!("TYPE:{}", feature.name()));
    }

    /// Retracts, raises the nozzle, and switches everything off.
    pub(super) fn end(&mut self) {
        self.retract();
        self.feature(Feature::Custom);
        let raised = number(self.raised_mm(END_RISE_MM), DECIMALS);
        self.move_to([None, None, Some(raised)], None, self.process().travel_mm_s);
        match self.settings.printer.flavour {
            Flavour::Marlin => {
                let off = |tool| Command::NozzleTemperature {
                    celsius: Number::ZERO,
                    tool,
                    wait: Wait::No,
                };
                // Tools that are not selected may have their own heaters.
                // The command without a tool is for printers that number tools differently.
                if self.used_tools.len() > 1 {
                    for tool in self.used_tools.clone() {
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
