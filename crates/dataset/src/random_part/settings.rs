//! What random parts are like.

use beadwork_base::named_enum;
use beadwork_grid::Region;
use thiserror::Error;

/// Settings of [`random_part`](super::random_part()).
///
/// Lengths are in cells.
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Kind of part.
    pub kind: Kind,
    /// Width of the grid: 8 to [`Region::MAX_SIDE`].
    pub width: u32,
    /// Height of the grid: 8 to [`Region::MAX_SIDE`].
    pub height: u32,
    /// Minimum number of layers: at least 1.
    pub min_layers: u32,
    /// Maximum number of layers: `min_layers` to [`Settings::MAX_LAYERS`], and at least 4 for kinds
    /// other than [`Kind::Plain`].
    pub max_layers: u32,
    /// Minimum side of the first layer's rectangle: at least 1.
    pub min_side: u32,
    /// Maximum side of the first layer's rectangle: `min_side` to the smaller side of the grid.
    pub max_side: u32,
    /// Chance that a layer is an overhang rather than an indentation: 0 to 1.
    pub overhang_chance: f64,
    /// Chance that an overhang keeps one of its new cells, before smoothing: 0 to 1.
    pub growth: f64,
    /// Maximum number of rectangles that an indentation removes: 1 to 1024. At least one is
    /// removed.
    pub max_indentations: u32,
    /// Maximum side of these rectangles: 1 to [`Region::MAX_SIDE`].
    /// Their minimum side is 1.
    pub max_indentation_side: u32,
    /// Radius of the elliptical kernel that smooths indentations: 0 (not smoothed) to 16. A radius
    /// of 2 is an ellipse of 5 x 5 cells, as image libraries draw it.
    pub indentation_radius: u32,
    /// Radius of the square kernel that smooths overhangs: 0 (not smoothed) to 16. A radius of 1 is
    /// a square of 3 x 3 cells.
    pub overhang_radius: u32,
    /// Maximum number of parts that are tried before [`random_part`](super::random_part()) fails:
    /// at least 1.
    pub max_attempts: u32,
    /// Side of a cell in mm: more than 0.
    pub cell_mm: f64,
    /// Height of a layer in mm: more than 0.
    pub layer_mm: f64,
}

/// Kind of a random part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Indentations and overhangs only: what the paper trains on.
    Plain,
    /// A trunk that splits into two to four branches, which move apart as they rise.
    Branches,
    /// One to three channels, vertical or inclined, with walls all around them.
    Holes,
    /// Two to four separate bodies on the build plate, which never merge.
    Islands,
}

named_enum! {
    Kind, "kind of part":
    Plain = "plain",
    Branches = "branches",
    Holes = "holes",
    Islands = "islands",
}

/// Size of random parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Preset {
    /// 32 x 32 cells, 15 to 32 layers.
    Grid32,
    /// 64 x 64 cells, 15 to 64 layers.
    Grid64,
    /// 128 x 128 cells, 15 to 128 layers, like the paper's parts.
    Grid128,
    /// 64 x 64 cells, 15 to 32 layers: for policies, which take one step a layer.
    Policy,
}

named_enum! {
    Preset, "preset":
    Grid32 = "grid32",
    Grid64 = "grid64",
    Grid128 = "grid128",
    Policy = "policy",
}

/// Why settings are invalid.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("random part: {field} is {value}, expected {expected}")]
#[non_exhaustive]
pub struct SettingsError {
    /// Name of the field.
    pub field: &'static str,
    /// Its value.
    pub value: f64,
    /// Description of the valid values.
    pub expected: String,
}

/// Minimum number of layers that show the feature of a kind other than [`Kind::Plain`].
pub(super) const MIN_FEATURE_LAYERS: usize = 3;

/// Upper limit of [`Settings::max_indentations`].
const MAX_INDENTATIONS: u32 = 1024;

/// Maximum radius of a kernel.
const MAX_RADIUS: u32 = 16;

/// Minimum side of the grid.
const MIN_GRID: u32 = 8;

impl Settings {
    /// Upper limit of [`Settings::max_layers`].
    pub const MAX_LAYERS: u32 = 4096;

    /// Settings of parts of a size.
    pub fn preset(preset: Preset) -> Self {
        let (side, max_layers) = match preset {
            Preset::Grid32 => (32, 32),
            Preset::Grid64 => (64, 64),
            Preset::Grid128 => (128, 128),
            Preset::Policy => (64, 32),
        };
        Self {
            kind: Kind::Plain,
            width: side,
            height: side,
            min_layers: 15,
            max_layers,
            min_side: side * 3 / 8,
            max_side: side * 7 / 8,
            overhang_chance: 0.5,
            growth: 0.5,
            max_indentations: 3,
            max_indentation_side: side / 4,
            indentation_radius: 2,
            overhang_radius: 1,
            max_attempts: 1000,
            cell_mm: 0.5,
            layer_mm: 0.25,
        }
    }

    /// Returns an error for the first field whose value is out of range.
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        let max_grid = Region::MAX_SIDE;
        let smaller = self.width.min(self.height);
        let min_max_layers =
            if self.kind == Kind::Plain { 1 } else { 1 + MIN_FEATURE_LAYERS as u32 };
        let counts = [
            ("width", self.width, MIN_GRID, max_grid),
            ("height", self.height, MIN_GRID, max_grid),
            ("min_layers", self.min_layers, 1, Self::MAX_LAYERS),
            ("max_layers", self.max_layers, self.min_layers.max(min_max_layers), Self::MAX_LAYERS),
            ("min_side", self.min_side, 1, smaller),
            ("max_side", self.max_side, self.min_side, smaller),
            ("max_indentations", self.max_indentations, 1, MAX_INDENTATIONS),
            ("max_indentation_side", self.max_indentation_side, 1, max_grid),
            ("indentation_radius", self.indentation_radius, 0, MAX_RADIUS),
            ("overhang_radius", self.overhang_radius, 0, MAX_RADIUS),
            ("max_attempts", self.max_attempts, 1, u32::MAX),
        ];
        for (field, value, min, max) in counts {
            if !(min..=max).contains(&value) {
                let (value, expected) = (f64::from(value), format!("{min} to {max}"));
                return Err(SettingsError { field, value, expected });
            }
        }
        for (field, value) in [("overhang_chance", self.overhang_chance), ("growth", self.growth)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(SettingsError { field, value, expected: "0 to 1".to_owned() });
            }
        }
        for (field, value) in [("cell_mm", self.cell_mm), ("layer_mm", self.layer_mm)] {
            if !(value.is_finite() && value > 0.0) {
                let expected = "a finite length of more than 0".to_owned();
                return Err(SettingsError { field, value, expected });
            }
        }
        Ok(())
    }
}

impl Default for Settings {
    /// [`Preset::Grid32`].
    fn default() -> Self {
        Self::preset(Preset::Grid32)
    }
}
