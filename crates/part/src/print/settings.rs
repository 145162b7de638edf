//! What a print depends on beside the part: printer, tools, speeds, and what changing tools costs.

use std::f64::consts::PI;

use beadwork_gcode::{Filament, MotionLimits};
use serde::Deserialize;
use thiserror::Error;

use crate::Frame;

/// Everything a print depends on beside the part.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The machine.
    pub printer: Printer,
    /// The tools by number; a zone is printed with the tool of its number.
    pub tools: Vec<Tool>,
    /// Speeds, temperatures, retraction.
    pub process: Process,
    /// What is purged when tools change; `None`: nothing, or the printer does it by itself.
    pub purge: Option<Purge>,
}

/// The dialect of the firmware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Flavour {
    /// Marlin and its kin: limits are set by `M204` and `M205`.
    /// Of the corners it gets both the junction deviation, which has to lie from 0.01 to 0.3 mm and
    /// is brought into these bounds, and the jerk of x and y: it takes the one it was built for.
    #[default]
    Marlin,
    /// Klipper: limits are set by `SET_VELOCITY_LIMIT`.
    Klipper,
}

/// Where the tools have their heat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Nozzles {
    /// The tools are filaments of one nozzle, which gets the temperature of the present one.
    #[default]
    Shared,
    /// Each tool has a nozzle of its own: all that print are heated at the beginning and stay hot
    /// to the end.
    Own,
}

/// The machine.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Printer {
    /// The dialect it understands.
    pub flavour: Flavour,
    /// Where the tools have their heat.
    pub nozzles: Nozzles,
    /// Greatest x, y and z in mm; all of them begin at 0, x and y in the front left corner.
    pub bed_mm: [f64; 3],
    /// Acceleration in mm/s².
    pub acceleration_mm_s2: f64,
    /// Speed through a right angle, in mm/s.
    pub square_corner_mm_s: f64,
    /// The greatest speed of the head, in mm/s; it is not written to the file, but no speed of the
    /// head in the process may be higher.
    #[serde(alias = "greatest_mm_s")]
    pub max_speed_mm_s: f64,
}

impl Default for Printer {
    /// A usual machine: Marlin, one nozzle, 250 x 210 x 210 mm, 1000 mm/s², 5 mm/s in corners, at
    /// most 200 mm/s.
    fn default() -> Self {
        Self {
            flavour: Flavour::default(),
            nozzles: Nozzles::default(),
            bed_mm: [250.0, 210.0, 210.0],
            acceleration_mm_s2: 1000.0,
            square_corner_mm_s: 5.0,
            max_speed_mm_s: 200.0,
        }
    }
}

impl Printer {
    /// What limits its motions.
    pub fn limits(&self) -> MotionLimits {
        MotionLimits {
            acceleration_mm_s2: self.acceleration_mm_s2,
            square_corner_mm_s: self.square_corner_mm_s,
            max_speed_mm_s: self.max_speed_mm_s,
        }
    }
}

/// A nozzle with its filament, or one of the filaments of a nozzle that changes between them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tool {
    /// Its name, for the comments of the file.
    pub name: String,
    /// Red, green and blue, for those who view the file.
    pub colour: [u8; 3],
    /// Temperature of the nozzle, in degrees Celsius.
    pub nozzle_c: f64,
    /// Diameter of the filament, in mm.
    pub filament_mm: f64,
    /// Density of the filament, in g/cm³.
    pub density_g_cm3: f64,
}

impl Default for Tool {
    /// 230 °C, the temperature of the paper on heat; filament of 1.75 mm and 1.24 g/cm³.
    fn default() -> Self {
        Self {
            name: String::new(),
            colour: [128; 3],
            nozzle_c: 230.0,
            filament_mm: 1.75,
            density_g_cm3: 1.24,
        }
    }
}

impl Tool {
    /// Its filament.
    pub fn filament(&self) -> Filament {
        Filament { diameter_mm: self.filament_mm, density_g_cm3: self.density_g_cm3 }
    }

    /// Cross-section of its filament, in mm².
    pub fn filament_mm2(&self) -> f64 {
        self.filament().area_mm2()
    }
}

/// The shape across a bead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CrossSection {
    /// The whole cell: width times height.
    /// Beads side by side fill the part.
    #[default]
    Rectangle,
    /// A rectangle with half a circle at either side, as slicers reckon single beads.
    /// Leaves gaps between beads a whole width apart.
    Oval,
}

/// Speeds, temperatures, retraction.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Process {
    /// Speed of printing, in mm/s.
    pub print_mm_s: f64,
    /// Speed of printing on the bed itself, in mm/s.
    pub first_layer_mm_s: f64,
    /// Speed of travel, in mm/s.
    pub travel_mm_s: f64,
    /// Temperature of the bed, in degrees Celsius.
    pub bed_c: f64,
    /// How much filament is drawn back before a travel or a change of tools, in mm; 0 for none.
    pub retract_mm: f64,
    /// Speed of that, in mm/s.
    pub retract_mm_s: f64,
    /// Travel of at most this length needs no retraction, in mm.
    pub retract_beyond_mm: f64,
    /// How far the nozzle is lifted while the filament is drawn back, in mm.
    pub z_hop_mm: f64,
    /// Speed of the fan, from 0 to 1.
    pub fan: f64,
    /// Number of the layer, from 0, from which on the fan runs.
    pub fan_from_layer: usize,
    /// The shape across a bead.
    pub cross_section: CrossSection,
}

impl Default for Process {
    /// The paper on heat prints at 30 mm/s, travels at 150 mm/s and keeps the bed at 80 °C; it has
    /// no fan.
    /// Retraction is that of a usual direct drive.
    fn default() -> Self {
        Self {
            print_mm_s: 30.0,
            first_layer_mm_s: 20.0,
            travel_mm_s: 150.0,
            bed_c: 80.0,
            retract_mm: 0.8,
            retract_mm_s: 35.0,
            retract_beyond_mm: 2.0,
            z_hop_mm: 0.0,
            fan: 0.0,
            fan_from_layer: 1,
            cross_section: CrossSection::Rectangle,
        }
    }
}

impl Process {
    /// Area across a bead, in mm².
    pub fn bead_mm2(&self, frame: &Frame) -> f64 {
        let (width, height) = (frame.cell_mm, frame.layer_mm);
        match self.cross_section {
            CrossSection::Rectangle => width * height,
            CrossSection::Oval => (width - height) * height + PI * height * height / 4.0,
        }
    }
}

/// What is purged when tools change.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Purge {
    /// How much, in mm³, from the tool of the row to that of the column: what the new one extrudes
    /// before it prints the part.
    /// What stands on the diagonal does not matter.
    pub volume_mm3: Vec<Vec<f64>>,
    /// Where it goes; `None`: the printer purges by itself when it is told to change tools.
    pub tower: Option<PrimeTower>,
}

impl Purge {
    /// The same volume for every change between so many tools, in mm³.
    pub fn uniform(tools: usize, volume_mm3: f64, tower: Option<PrimeTower>) -> Self {
        let row = |from| (0..tools).map(|to| if from == to { 0.0 } else { volume_mm3 }).collect();
        Self { volume_mm3: (0..tools).map(row).collect(), tower }
    }

    /// Volume that a change between two tools purges into the prime tower, in mm³; 0 without one.
    pub fn prime_tower_mm3(&self, from: u8, to: u8) -> f64 {
        let row =
            self.volume_mm3.get(usize::from(from)).filter(|_| self.tower.is_some() && from != to);
        row.and_then(|row| row.get(usize::from(to))).copied().unwrap_or(0.0)
    }
}

/// The place of the tower that takes up what is purged.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrimeTower {
    /// x of its left side, in mm.
    pub left_mm: f64,
    /// y of its front, in mm.
    pub front_mm: f64,
    /// Size along x, in mm.
    pub width_mm: f64,
    /// The greatest size along y, in mm; it takes what it needs.
    pub depth_mm: f64,
}

/// Settings that no print can be made of.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SettingsError {
    /// A number is not finite, too small or too large.
    #[error("{field} is {value}, and must be {wanted}")]
    Value {
        /// Which one.
        field: String,
        /// What it is.
        value: f64,
        /// What it must be.
        wanted: &'static str,
    },
    /// The head is to go faster than the printer can.
    #[error("{field} is {value}, and printer.max_speed_mm_s is {max_speed_mm_s}")]
    TooFast {
        /// Which speed.
        field: &'static str,
        /// What it is, in mm/s.
        value: f64,
        /// The greatest speed, in mm/s.
        max_speed_mm_s: f64,
    },
    /// An oval bead is higher than wide.
    #[error(
        "process.cross_section is oval, but the layers of {layer_mm} mm are higher than the beads of {cell_mm} mm are wide"
    )]
    HighBead {
        /// Height of a layer in mm.
        layer_mm: f64,
        /// Width of a bead in mm.
        cell_mm: f64,
    },
    /// The matrix of purge volumes is not as wide and as high as there are tools.
    #[error("purge.volume_mm3 has a row or column of {got}, for {tools} tools")]
    PurgeSize {
        /// Number of tools.
        tools: usize,
        /// Rows, or columns of the first row that has another number of them.
        got: usize,
    },
    /// The plane of the part lies partly outside the bed.
    #[error(
        "the part reaches from ({left_mm}, {front_mm}) to ({right_mm}, {back_mm}) mm, beyond the bed"
    )]
    PartOutside {
        /// Least x in mm.
        left_mm: f64,
        /// Least y in mm.
        front_mm: f64,
        /// Greatest x in mm.
        right_mm: f64,
        /// Greatest y in mm.
        back_mm: f64,
    },
    /// The part is too high.
    #[error("the nozzle would rise to {top_mm} mm, and printer.bed_mm allows {limit_mm}")]
    TooHigh {
        /// Greatest z in mm, lifted.
        top_mm: f64,
        /// Greatest z of the printer, in mm.
        limit_mm: f64,
    },
    /// The tower lies partly outside the bed.
    #[error("purge.tower reaches beyond the bed")]
    PrimeTowerOutside,
    /// The tower and the plane of the part overlap.
    #[error("purge.tower overlaps the part")]
    PrimeTowerOverlaps,
    /// The tower has no room for what is purged.
    #[error(
        "purge.tower.depth_mm is {depth_mm}, and must be at least {needed_mm} for what one layer purges"
    )]
    PrimeTowerDepth {
        /// Its depth in mm.
        depth_mm: f64,
        /// What it takes, in mm.
        needed_mm: f64,
    },
    /// The tower is too narrow for its walls and one bead between them.
    #[error("purge.tower.width_mm is {width_mm}, and must be at least {needed_mm}")]
    PrimeTowerWidth {
        /// Its width in mm.
        width_mm: f64,
        /// What it takes, in mm.
        needed_mm: f64,
    },
    /// A zone has no tool.
    #[error("layer {layer} has zone {zone}, and there are {tools} tools")]
    TooFewTools {
        /// Number of the layer.
        layer: usize,
        /// The zone.
        zone: u8,
        /// How many tools there are.
        tools: usize,
    },
    /// A layer's region, zones, path and the frame don't belong together.
    #[error("layer {layer}: {what} is not that of the others")]
    Layer {
        /// Number of the layer.
        layer: usize,
        /// What is odd.
        what: &'static str,
    },
    /// The numbers of the layers don't rise.
    #[error("layer {layer} comes after layer {before}")]
    LayerOrder {
        /// Number of a layer.
        layer: usize,
        /// Number of the one before it.
        before: usize,
    },
    /// A layer would be printed in the air.
    #[error("layer {layer} has nothing to rest on: the one below has no cells")]
    Gap {
        /// Number of the layer.
        layer: usize,
    },
    /// There is nothing to print.
    #[error("there are no layers")]
    NoLayers,
}

/// Larger than any speed, acceleration or volume of a purge.
const LARGEST: f64 = 1e6;

/// Larger than any bed, in mm.
/// The filament in a cube of this size still is a [`Number`](super::Number).
const LARGEST_BED_MM: f64 = 1e4;

/// Beads thinner than this, in mm, are lost in the decimals of a file.
const THINNEST_MM: f64 = 0.01;

impl Settings {
    /// Checks each number on its own.
    pub(super) fn check(&self, frame: &Frame) -> Result<(), SettingsError> {
        let Self { printer, tools, process, purge } = self;
        let [x, y, z] = printer.bed_mm;
        let positive = [
            ("printer.acceleration_mm_s2", printer.acceleration_mm_s2),
            ("printer.max_speed_mm_s", printer.max_speed_mm_s),
            ("process.retract_mm_s", process.retract_mm_s),
        ];
        let of_head = [
            ("process.print_mm_s", process.print_mm_s),
            ("process.first_layer_mm_s", process.first_layer_mm_s),
            ("process.travel_mm_s", process.travel_mm_s),
        ];
        let not_negative = [
            ("printer.square_corner_mm_s", printer.square_corner_mm_s),
            ("process.bed_c", process.bed_c),
            ("process.retract_mm", process.retract_mm),
            ("process.retract_beyond_mm", process.retract_beyond_mm),
            ("process.z_hop_mm", process.z_hop_mm),
        ];
        for (field, value) in
            [("printer.bed_mm[0]", x), ("printer.bed_mm[1]", y), ("printer.bed_mm[2]", z)]
        {
            within(field, value, 1.0, LARGEST_BED_MM, "from 1 to 10000")?;
        }
        positive
            .iter()
            .chain(&of_head)
            .try_for_each(|&(field, value)| check_positive(field, value))?;
        not_negative.iter().try_for_each(|&(field, value)| check_not_negative(field, value))?;
        if let Some(&(field, value)) =
            of_head.iter().find(|(_, value)| *value > printer.max_speed_mm_s)
        {
            return Err(SettingsError::TooFast {
                field,
                value,
                max_speed_mm_s: printer.max_speed_mm_s,
            });
        }
        within("process.fan", process.fan, 0.0, 1.0, "from 0 to 1")?;
        for (field, value) in [("frame.cell_mm", frame.cell_mm), ("frame.layer_mm", frame.layer_mm)]
        {
            within(field, value, THINNEST_MM, LARGEST_BED_MM, "from 0.01 to 10000")?;
        }
        for (field, value) in [("frame.left_mm", frame.left_mm), ("frame.back_mm", frame.back_mm)] {
            check_not_negative(field, value)?;
        }
        if process.cross_section == CrossSection::Oval && frame.layer_mm > frame.cell_mm {
            return Err(SettingsError::HighBead {
                layer_mm: frame.layer_mm,
                cell_mm: frame.cell_mm,
            });
        }
        for (number, tool) in tools.iter().enumerate() {
            let field = |name| format!("tools[{number}].{name}");
            within(&field("filament_mm"), tool.filament_mm, 0.5, 20.0, "from 0.5 to 20")?;
            check_not_negative(&field("nozzle_c"), tool.nozzle_c)?;
            within(&field("density_g_cm3"), tool.density_g_cm3, 0.0, 100.0, "from 0 to 100")?;
        }
        purge.as_ref().map_or(Ok(()), |purge| purge.check(tools.len()))
    }
}

impl Purge {
    fn check(&self, tools: usize) -> Result<(), SettingsError> {
        let rows = self.volume_mm3.len();
        let odd = self.volume_mm3.iter().map(Vec::len).find(|&columns| columns != tools);
        if let Some(got) = odd.or((rows != tools).then_some(rows)) {
            return Err(SettingsError::PurgeSize { tools, got });
        }
        for (from, row) in self.volume_mm3.iter().enumerate() {
            for (to, &volume) in row.iter().enumerate() {
                check_not_negative(&format!("purge.volume_mm3[{from}][{to}]"), volume)?;
            }
        }
        let Some(tower) = self.tower else { return Ok(()) };
        check_not_negative("purge.tower.left_mm", tower.left_mm)?;
        check_not_negative("purge.tower.front_mm", tower.front_mm)?;
        check_positive("purge.tower.width_mm", tower.width_mm)?;
        check_positive("purge.tower.depth_mm", tower.depth_mm)
    }
}

fn check_positive(field: &str, value: f64) -> Result<(), SettingsError> {
    // A speed below a thousandth would be written as 0.
    within(field, value, 0.001, LARGEST, "more than 0 and at most a million")
}

fn check_not_negative(field: &str, value: f64) -> Result<(), SettingsError> {
    within(field, value, 0.0, LARGEST, "at least 0 and at most a million")
}

fn within(
    field: &str,
    value: f64,
    low: f64,
    high: f64,
    wanted: &'static str,
) -> Result<(), SettingsError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(SettingsError::Value { field: field.to_owned(), value, wanted })
}
