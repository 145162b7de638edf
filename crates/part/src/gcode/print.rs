//! Planned layers as a program.
//!
//! Each piece of a path is one bead, from the outer edge of its first cell along the middles to the outer edge of its last: as long as it has cells,
//! with the same flow everywhere. Where the zone changes within a piece, the old tool ends at the edge between the two cells, and the new one begins there.

use super::tower::TowerPlan;
use super::{
    Command, Feature, Flavour, Layer, Line, Move, Number, Process, Program, Settings, SettingsError, Tool,
    Totals, layer,
};
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

/// Decimals of places, as printers and slicers use them, and of filament.
const PLACE_DECIMALS: u32 = 3;
const FILAMENT_DECIMALS: u32 = 5;

/// How far the head rises at the end, in mm, if the printer is so high.
const END_LIFT_MM: f64 = 10.0;

impl Print {
    /// Writes the program of these layers, whose numbers rise. Linear in the cells.
    ///
    /// Every tool is taken to begin with its filament drawn back by `retract_mm`, as the end of a print leaves it.
    pub fn new(
        title: Title<'_>,
        layers: &[Layer<'_>],
        frame: &Frame,
        settings: &Settings,
    ) -> Result<Self, SettingsError> {
        settings.check(frame)?;
        layer::check(layers, frame, settings)?;
        let tower = TowerPlan::new(layers, frame, settings)?;
        let mut writer = Writer::new(frame, settings, layers[0].zones.id(layers[0].path.order()[0]));
        writer.start();
        let mut parts = layers.iter().peekable();
        let last = layers[layers.len() - 1].number;
        for number in 0..=last {
            let part = parts.next_if(|layer| layer.number == number);
            let tower = tower.as_ref().filter(|tower| number <= tower.last_layer);
            if part.is_some() || tower.is_some() {
                writer.layer(number, part, tower);
            }
        }
        writer.end(layers);
        let body = Program { lines: writer.lines };
        let totals = Totals::measure(&body, layers, settings)
            .expect("checked settings make speeds above 0 and no arcs");
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
    /// Where the head is, rounded as it was written; `None` before the first move along an axis.
    at: [Option<Number>; 3],
    feed: Option<Number>,
    feature: Feature,
    tool: u8,
    /// For each tool, whether its filament is drawn back.
    drawn: Vec<bool>,
    /// For each tool, the filament that rounding has kept back so far, in mm: from the part and from the tower. One sum for both would let
    /// the tower take a little from the part at each change.
    owed_mm: Vec<[f64; 2]>,
    /// z of the layer, in mm.
    top_mm: f64,
    /// Speed of printing in this layer.
    print_mm_s: f64,
    fan_runs: bool,
}

impl<'a> Writer<'a> {
    fn new(frame: &'a Frame, settings: &'a Settings, tool: u8) -> Self {
        let tools = settings.tools.len();
        Self {
            frame,
            settings,
            bead_mm2: settings.process.bead_mm2(frame),
            lines: Vec::new(),
            at: [None; 3],
            feed: None,
            feature: Feature::Unknown,
            tool,
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
        let printer = &self.settings.printer;
        let bed = number(self.process().bed_c, PLACE_DECIMALS);
        let nozzle = number(self.selected().nozzle_c, PLACE_DECIMALS);
        let heat = |wait| Command::NozzleTemperature { celsius: nozzle, tool: None, wait };
        self.feature(Feature::Custom);
        self.other("G21");
        self.command(Command::Absolute);
        self.command(Command::RelativeExtrusion);
        self.command(Command::BedTemperature { celsius: bed, wait: false });
        self.command(Command::Tool(self.tool));
        self.command(heat(false));
        self.command(Command::Home { x: false, y: false, z: false });
        self.command(Command::BedTemperature { celsius: bed, wait: true });
        self.command(heat(true));
        self.command(Command::Fan(None));
        let acceleration = Some(number(printer.acceleration_mm_s2, PLACE_DECIMALS));
        match printer.flavour {
            Flavour::Marlin => {
                self.command(Command::Acceleration { print: acceleration, travel: acceleration, all: None });
                // The same corners as Klipper's square corner velocity gives.
                let corner2 = printer.square_corner_mm_s * printer.square_corner_mm_s;
                let deviation = corner2 * (std::f64::consts::SQRT_2 - 1.0) / printer.acceleration_mm_s2;
                let junction_deviation = Some(number(deviation, FILAMENT_DECIMALS));
                self.command(Command::Jerk { x: None, y: None, z: None, e: None, junction_deviation });
            }
            Flavour::Klipper => {
                let square_corner = Some(number(printer.square_corner_mm_s, PLACE_DECIMALS));
                self.command(Command::VelocityLimit { velocity: None, acceleration, square_corner });
            }
        }
    }

    fn layer(&mut self, index: usize, part: Option<&Layer<'_>>, tower: Option<&TowerPlan>) {
        let process = self.process();
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
            let purged = part.map_or(0, |part| self.purged_rows(part, tower));
            self.tower_bead(tower, &tower.outline());
            let rest =
                if index == 0 { tower.solid(purged, tower.rows() - purged) } else { tower.sparse(purged) };
            self.tower_bead(tower, &rest);
        }
        let Some(part) = part else { return };
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
    fn purged_rows(&self, part: &Layer<'_>, tower: &TowerPlan) -> i32 {
        let mut tool = self.tool;
        let rows = part.runs().map(|run| {
            let before = std::mem::replace(&mut tool, run.zone);
            self.rows_between(before, run.zone, tower)
        });
        rows.sum()
    }

    fn rows_between(&self, from: u8, to: u8, tower: &TowerPlan) -> i32 {
        let purge = self.settings.purge.as_ref();
        tower.rows_of(purge.map_or(0.0, |purge| purge.into_tower_mm3(from, to)))
    }

    fn rows_for(&self, to: u8, tower: Option<&TowerPlan>) -> i32 {
        tower.map_or(0, |tower| self.rows_between(self.tool, to, tower))
    }

    /// Selects a tool; purges into so many rows of the tower.
    fn change_tool(&mut self, to: u8, tower: Option<(&TowerPlan, i32, i32)>) {
        self.draw_back();
        let slot = tower.filter(|&(_, _, rows)| rows > 0);
        let slot = slot.map(|(tower, begin, rows)| (tower, tower.solid(begin, rows)));
        if let Some((tower, corners)) = &slot {
            // Whatever drips during the change drips where the purge covers it.
            self.travel(tower.place(corners[0]));
        }
        let before = self.selected().nozzle_c;
        self.tool = to;
        self.command(Command::Tool(to));
        let after = self.selected().nozzle_c;
        if (before - after).abs() > 0.0 {
            let celsius = number(after, PLACE_DECIMALS);
            self.command(Command::NozzleTemperature { celsius, tool: None, wait: true });
        }
        if let Some((tower, corners)) = &slot {
            self.tower_bead(tower, corners);
            self.draw_back();
        }
    }

    fn part_bead(&mut self, corners: &[[i32; 2]]) {
        let Frame { left_mm, back_mm, cell_mm, .. } = *self.frame;
        let along = |halves: i32| f64::from(halves) / 2.0 * cell_mm;
        self.bead(Feature::SolidInfill, corners, |[x, y]| [left_mm + along(x), back_mm - along(y)]);
    }

    fn tower_bead(&mut self, tower: &TowerPlan, corners: &[[i32; 2]]) {
        self.bead(Feature::PrimeTower, corners, |corner| tower.place(corner));
    }

    /// Lays a bead along corners, which are given in halves of a cell.
    fn bead(&mut self, feature: Feature, corners: &[[i32; 2]], place: impl Fn([i32; 2]) -> [f64; 2]) {
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
            let owed = &mut self.owed_mm[usize::from(self.tool)][usize::from(feature == Feature::PrimeTower)];
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
        let speed = process.travel_mm_s;
        // Up before across: the layer below may be in the way.
        self.go([None, None, Some(number(self.top_mm + hop, PLACE_DECIMALS))], None, speed);
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

    fn end(&mut self, layers: &[Layer<'_>]) {
        self.draw_back();
        self.feature(Feature::Custom);
        let lifted = (self.top_mm + END_LIFT_MM).min(self.settings.printer.bed_mm[2]).max(self.top_mm);
        self.go([None, None, Some(number(lifted, PLACE_DECIMALS))], None, self.process().travel_mm_s);
        match self.settings.printer.flavour {
            // A tool that was put aside may have a heater of its own.
            Flavour::Marlin => {
                let used = |tool: &u8| layers.iter().any(|layer| layer.zones.ids().contains(tool));
                let used: Vec<u8> =
                    (0..self.settings.tools.len()).map(|tool| tool as u8).filter(used).collect();
                for &tool in &used {
                    let tool = (used.len() > 1).then_some(tool);
                    let celsius = Number::ZERO;
                    self.command(Command::NozzleTemperature { celsius, tool, wait: false });
                }
                self.command(Command::BedTemperature { celsius: Number::ZERO, wait: false });
            }
            Flavour::Klipper => self.other("TURN_OFF_HEATERS"),
        }
        self.command(Command::Fan(None));
        self.other("M84");
    }
}

/// The lines before the first command: what the print is, for people and for those programs that list and draw files.
fn header(title: Title<'_>, frame: &Frame, settings: &Settings, totals: &Totals) -> Vec<Line> {
    let tools = || settings.tools.iter().zip(&totals.tools);
    let list = |separator: &str, each: &mut dyn FnMut((&Tool, &super::ToolUse)) -> String| {
        tools().map(each).collect::<Vec<_>>().join(separator)
    };
    let place = |value| number(value, PLACE_DECIMALS);
    let hundredths = |value| number(value, 2);
    let colour = |[red, green, blue]: [u8; 3]| format!("#{red:02X}{green:02X}{blue:02X}");
    let mut texts = vec![
        format!("generated by beadwork {}", title.version),
        format!("part = {}", title.part),
        format!("total layers count = {}", totals.layers),
        format!("layer_height = {}", place(frame.layer_mm)),
        format!("first_layer_height = {}", place(frame.layer_mm)),
        format!("extrusion_width = {}", place(frame.cell_mm)),
        format!("tool changes = {}", totals.tool_changes),
        format!("lifts = {}", totals.lifts),
        format!("estimated printing time (normal mode) = {}", duration(totals.print_seconds)),
        format!("first_layer_bed_temperature = {}", place(settings.process.bed_c)),
        format!("temperature = {}", list(",", &mut |(tool, _)| place(tool.nozzle_c).to_string())),
        format!("filament_diameter = {}", list(",", &mut |(tool, _)| place(tool.filament_mm).to_string())),
        format!("filament_density = {}", list(",", &mut |(tool, _)| place(tool.density_g_cm3).to_string())),
        format!(
            "filament used [mm] = {}",
            list(", ", &mut |(_, used)| hundredths(used.filament_mm).to_string())
        ),
        format!(
            "filament used [cm3] = {}",
            list(", ", &mut |(_, used)| hundredths(used.volume_mm3 / 1000.0).to_string())
        ),
        format!("filament used [g] = {}", list(", ", &mut |(_, used)| hundredths(used.grams).to_string())),
        format!("filament_colour = {}", list(";", &mut |(tool, _)| colour(tool.colour))),
        format!("extruder_colour = {}", list(";", &mut |(tool, _)| colour(tool.colour))),
    ];
    texts.extend(tools().map(|(tool, used)| format!("tool {} = {}", used.tool, tool.name)));
    texts.into_iter().map(|text| comment(format!(" {text}"))).collect()
}

/// A comment; line breaks and other control characters in names become blanks.
fn comment(text: String) -> Line {
    let text = if text.contains(char::is_control) { text.replace(char::is_control, " ") } else { text };
    Line::new(None, Some(text)).expect("it has no line break")
}

/// Days, hours, minutes and seconds, as PrusaSlicer writes them.
fn duration(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    let parts =
        [(seconds / 86_400, 'd'), (seconds / 3600 % 24, 'h'), (seconds / 60 % 60, 'm'), (seconds % 60, 's')];
    let first = parts.iter().position(|&(count, _)| count > 0).unwrap_or(3);
    parts[first..].iter().map(|(count, unit)| format!("{count}{unit}")).collect::<Vec<_>>().join(" ")
}

/// A value of the settings or made of them.
fn number(value: f64, decimals: u32) -> Number {
    Number::from_f64(value, decimals).expect("checked settings and what a bed holds are far below the limit")
}

#[cfg(test)]
mod tests;
