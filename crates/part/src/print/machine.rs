//! The printer as the writer drives it: state, start and end, heating, travel and retraction.
//!
//! # State
//! The [`Machine`] tracks position, feed rate, tool and retraction.
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
//! ([`Process::z_hop_mm`]); see [`Machine::travel`].
//! With [`Process::wipe_mm`], it is retracted on the way back along the bead just printed.

use beadwork_gcode::{Command, Feature, Line, LinearMove, Number, Wait};

use super::process::Process;
use super::settings::{Flavour, Nozzles, Settings, Tool};
use super::text::{DECIMALS, FILAMENT_DECIMALS, comment, number};
use super::toolpath::{ToolpathMove, rounded};
use super::wipe::wipe_route;

/// Height above the bed at which the nozzle waits until it is hot, in mm, or the maximum height of
/// the printer if that is less: closer to the bed, filament would ooze onto it and stick.
const HEATING_HEIGHT_MM: f64 = 5.0;

/// Speed of the move to [`HEATING_HEIGHT_MM`], in mm/s, unless the printer is slower.
/// The z axis is slow, and the file has not set any limits yet.
const HEATING_MOVE_MM_S: f64 = 10.0;

/// Minimum z-hop of a tool change, in mm, unless the printer's height limits it: a nozzle that
/// rests on the part would melt it.
pub(super) const TOOL_CHANGE_HOP_MM: f64 = 1.0;

/// Rise of the nozzle at the end, in mm, unless the printer's height limits it.
const END_RISE_MM: f64 = 10.0;

/// The junction deviations that Marlin accepts, in mm; it ignores all others.
const JUNCTION_DEVIATIONS_MM: [f64; 2] = [0.01, 0.3];

/// The lines written so far, and the state of the printer after them.
pub(super) struct Machine<'a> {
    settings: &'a Settings,
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
    /// The width of the last `;WIDTH:` comment, in mm.
    width: Number,
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
    /// The positions that the nozzle passed while extruding, since it last moved without.
    trail: Vec<[Number; 2]>,
    /// z of the current layer, in mm.
    top_mm: f64,
    is_fan_on: bool,
}

impl<'a> Machine<'a> {
    /// A printer at the start of a file; `tool` prints first.
    pub(super) fn new(settings: &'a Settings, tool: u8, used_tools: Vec<u8>) -> Self {
        let tools = settings.tools.len();
        Self {
            settings,
            lines: Vec::new(),
            position: [None; 3],
            feed: None,
            clearance_mm: 0.0,
            feature: Feature::Unknown,
            width: Number::ZERO,
            tool,
            used_tools,
            is_retracted: vec![settings.process.retract_mm > 0.0; tools],
            withheld_mm: vec![[0.0; 2]; tools],
            trail: Vec::new(),
            top_mm: 0.0,
            is_fan_on: false,
        }
    }

    pub(super) fn into_lines(self) -> Vec<Line> {
        self.lines
    }

    /// The selected tool.
    pub(super) fn tool(&self) -> u8 {
        self.tool
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
        self.trail.clear();
        self.feed = None;
        // The macros of a tool change may have set other modes.
        self.modes();
    }

    /// Begins a layer with its comments, and switches the fan on if it is due.
    pub(super) fn begin_layer(&mut self, number_from_0: usize, top_mm: f64, height_mm: f64) {
        let process = self.process();
        self.top_mm = top_mm;
        self.comment("LAYER_CHANGE".to_owned());
        self.comment(format!("Z:{}", number(top_mm, DECIMALS)));
        self.comment(format!("HEIGHT:{}", number(height_mm, DECIMALS)));
        self.feature = Feature::Unknown;
        if process.fan > 0.0 && number_from_0 >= process.fan_from_layer && !self.is_fan_on {
            self.is_fan_on = true;
            self.command(Command::Fan(Some(number(255.0 * process.fan, 0))));
        }
    }

    /// Changes to a tool above a position, given as x and y in mm; `None` stands for the current
    /// one.
    ///
    /// The filament is retracted and the nozzle is raised first.
    pub(super) fn change_tool(&mut self, to: u8, above_mm: Option<[f64; 2]>) {
        self.retract();
        let speed = self.process().travel_mm_s;
        self.clearance_mm = self.raised_mm(self.process().z_hop_mm.max(TOOL_CHANGE_HOP_MM));
        self.move_to([None, None, Some(number(self.clearance_mm, DECIMALS))], None, speed);
        if let Some(above_mm) = above_mm {
            let [x, y] = rounded(above_mm);
            self.move_to([Some(x), Some(y), None], None, speed);
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
    }

    /// z in mm that is `by_mm` above the layer, or the printer's maximum if that is lower.
    fn raised_mm(&self, by_mm: f64) -> f64 {
        (self.top_mm + by_mm).min(self.settings.printer.bed_mm[2]).max(self.top_mm)
    }

    /// Travels to the start of a bead.
    ///
    /// Filament is retracted if the distance exceeds [`Process::retract_beyond_mm`] or is unknown,
    /// and the nozzle hops if the filament is retracted.
    /// The nozzle moves up, across and down again; moves that change nothing are not written.
    pub(super) fn travel(&mut self, to: [f64; 2]) {
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

    /// Extrudes along a move.
    pub(super) fn extrude(&mut self, step: &ToolpathMove) {
        self.begin_feature(step.feature, step.width_mm);
        let withheld_mm = &mut self.withheld_mm[usize::from(self.tool)]
            [usize::from(step.feature == Feature::PrimeTower)];
        *withheld_mm += step.filament_mm;
        let e = number(*withheld_mm, FILAMENT_DECIMALS);
        *withheld_mm -= e.to_f64();
        let [x, y] = rounded(step.to_mm);
        let mut trail = std::mem::take(&mut self.trail);
        if let (true, [Some(from_x), Some(from_y), _]) = (trail.is_empty(), self.position) {
            trail.push([from_x, from_y]);
        }
        trail.push([x, y]);
        self.move_to([Some(x), Some(y), None], Some(e), step.speed_mm_s);
        self.trail = trail;
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
        if x.or(y).or(z).is_some() {
            self.trail.clear();
        }
        let f = self.changed_feed(speed_mm_s);
        self.command(Command::Move(LinearMove { rapid: false, x, y, z, e, f }));
    }

    /// Sets the feed rate; returns it in mm/min if it changed.
    fn changed_feed(&mut self, speed_mm_s: f64) -> Option<Number> {
        let feed = number(60.0 * speed_mm_s, DECIMALS);
        (self.feed.replace(feed) != Some(feed)).then_some(feed)
    }

    /// Retracts the filament unless it is retracted already, on the way back along the bead just
    /// printed if [`Process::wipe_mm`] says so.
    pub(super) fn retract(&mut self) {
        let Process { retract_mm, retract_mm_s, wipe_mm, travel_mm_s, .. } = *self.process();
        if retract_mm <= 0.0 || self.is_retracted[usize::from(self.tool)] {
            return;
        }
        self.is_retracted[usize::from(self.tool)] = true;
        let trail = std::mem::take(&mut self.trail);
        let route = wipe_route(&trail, wipe_mm);
        let length_mm = route.last().map_or(0.0, |step| step.1);
        let speed = (retract_mm_s * length_mm / retract_mm).min(travel_mm_s);
        if number(60.0 * speed, DECIMALS) <= Number::ZERO {
            return self.filament(-retract_mm);
        }
        let mut retracted = Number::ZERO;
        for ([x, y], along_mm) in route {
            let target = number(-retract_mm * (along_mm / length_mm), FILAMENT_DECIMALS);
            let e = Number::from_millionths(target.millionths() - retracted.millionths());
            retracted = target;
            self.move_to([Some(x), Some(y), None], Some(e), speed);
        }
    }

    /// Unretracts the filament if it is retracted.
    pub(super) fn unretract(&mut self) {
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

    /// Begins a feature of a width in mm, with comments for what changes.
    pub(super) fn begin_feature(&mut self, feature: Feature, width_mm: f64) {
        let width = number(width_mm, DECIMALS);
        let is_new = feature != self.feature;
        if is_new {
            self.feature(feature);
        }
        if is_new || width != self.width {
            self.width = width;
            self.comment(format!("WIDTH:{width}"));
        }
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
