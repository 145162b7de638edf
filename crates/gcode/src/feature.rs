//! The comments with which slicers mark layers and features.

/// What a part of a program prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Feature {
    /// No comment has named a feature so far.
    #[default]
    Unknown,
    /// The outermost bead of a wall.
    OuterWall,
    /// Other beads of a wall, including overhangs.
    InnerWall,
    /// A wall of a single bead, which may vary in width.
    ThinWall,
    /// The filling of gaps between walls, with beads that may vary in width.
    GapFill,
    /// Sparse infill.
    Infill,
    /// Solid infill, including bridges and ironing; beadwork prints whole parts with it.
    SolidInfill,
    /// Support structures and their interfaces.
    Support,
    /// Skirt or brim: loops around the part.
    Skirt,
    /// The prime tower, which receives the filament that is purged at tool changes.
    PrimeTower,
    /// Custom G-code, such as the start and the end of a print.
    Custom,
    /// A name that is not listed here.
    Other,
}

/// The meaning of a comment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Marker {
    /// The next layer begins.
    NextLayer,
    /// The layer of this number begins; `None` for a layer below the part, such as a raft's.
    Layer(Option<u32>),
    /// The lines that follow print this feature.
    Feature(Feature),
}

impl Feature {
    /// The feature with this name in the comments of PrusaSlicer and its relatives, Cura,
    /// Simplify3D or ideaMaker, in any case; [`Feature::Other`] if none has it.
    pub fn from_name(name: &str) -> Self {
        let name = name.trim();
        let is = |names: &[&str]| names.iter().any(|known| name.eq_ignore_ascii_case(known));
        if is(&[
            "Solid infill",
            "Internal solid infill",
            "Top solid infill",
            "Bottom surface",
            "Top surface",
            "Bridge",
            "Bridge infill",
            "Internal Bridge",
            "Internal bridge infill",
            "Solid layer",
            "SOLID-FILL",
            "Ironing",
            "SKIN",
        ]) {
            Self::SolidInfill
        } else if is(&["Internal infill", "Sparse infill", "FILL", "Infill"]) {
            Self::Infill
        } else if is(&[
            "External perimeter",
            "Outer wall",
            "WALL-OUTER",
            "Outer perimeter",
            "OUTER-SHELL",
        ]) {
            Self::OuterWall
        } else if is(&[
            "Perimeter",
            "Inner wall",
            "Overhang perimeter",
            "Overhang wall",
            "WALL-INNER",
            "Internal perimeter",
            "Inner perimeter",
            "INNER-SHELL",
        ]) {
            Self::InnerWall
        } else if is(&["Thin wall"]) {
            Self::ThinWall
        } else if is(&["Gap fill", "Gap infill"]) {
            Self::GapFill
        } else if is(&["Prime tower", "Wipe tower", "PRIME-TOWER", "Prime pillar"]) {
            Self::PrimeTower
        } else if is(&[
            "Support material",
            "Support material interface",
            "Support",
            "Support interface",
            "SUPPORT-INTERFACE",
            "Support transition",
            "Support ironing",
            "Dense support",
            "Raft",
        ]) {
            Self::Support
        } else if is(&["Skirt", "Skirt/Brim", "Brim", "Draft shield", "Ooze shield"]) {
            Self::Skirt
        } else if is(&["Custom"]) {
            Self::Custom
        } else {
            Self::Other
        }
    }

    /// The name that PrusaSlicer and beadwork use in comments.
    ///
    /// [`from_name`](Self::from_name) reads it as this feature, except for thin walls:
    /// PrusaSlicer's viewer knows no name for them and counts them among the outer walls.
    pub fn name(self) -> &'static str {
        match self {
            Self::OuterWall | Self::ThinWall => "External perimeter",
            Self::InnerWall => "Perimeter",
            Self::GapFill => "Gap fill",
            Self::Infill => "Internal infill",
            Self::SolidInfill => "Solid infill",
            Self::Support => "Support material",
            Self::Skirt => "Skirt/Brim",
            Self::PrimeTower => "Wipe tower",
            Self::Custom => "Custom",
            Self::Unknown | Self::Other => "Unknown",
        }
    }
}

impl Marker {
    /// The meaning of a comment, given without its semicolon; `None` if it is not a marker.
    pub(crate) fn read(comment: &str) -> Option<Self> {
        let comment = comment.trim();
        if comment == "LAYER_CHANGE" || comment == "CHANGE_LAYER" {
            Some(Self::NextLayer)
        } else if let Some(number) = comment.strip_prefix("LAYER:") {
            let number: i64 = number.trim().parse().ok()?;
            Some(Self::Layer(u32::try_from(number).ok()))
        } else if let Some(layer) = comment.strip_prefix("layer ") {
            // Simplify3D: `; layer 1, Z = 0.200`, counted from 1.
            let (number, _) = layer.split_once(", Z = ")?;
            let number: i64 = number.parse().ok()?;
            Some(Self::Layer(u32::try_from(number - 1).ok()))
        } else if comment.starts_with("BEGIN_LAYER_OBJECT") {
            Some(Self::NextLayer)
        } else {
            let prefixes = ["TYPE:", "FEATURE:", "feature "];
            let name = prefixes.iter().find_map(|prefix| comment.strip_prefix(prefix))?;
            Some(Self::Feature(Feature::from_name(name)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_in_all_dialects() {
        use Feature::{
            Custom, GapFill, Infill, InnerWall, OuterWall, PrimeTower, Skirt, SolidInfill, Support,
            ThinWall,
        };
        for feature in
            [OuterWall, InnerWall, GapFill, Infill, SolidInfill, Support, Skirt, PrimeTower, Custom]
        {
            assert_eq!(Feature::from_name(feature.name()), feature);
        }
        for (name, feature) in [
            ("FILL", Infill),
            ("PRIME-TOWER", PrimeTower),
            ("wipe tower ", PrimeTower),
            ("Prime tower", PrimeTower),
            ("SKIN", SolidInfill),
            ("Bridge", SolidInfill),
            ("bridge infill", SolidInfill),
            ("Ironing", SolidInfill),
            ("Gap infill", GapFill),
            ("Thin wall", ThinWall),
        ] {
            assert_eq!(Feature::from_name(name), feature);
        }
        assert_eq!(Feature::from_name("Mystery"), Feature::Other);
    }

    #[test]
    fn comments_of_all_dialects() {
        for (comment, marker) in [
            ("LAYER_CHANGE", Some(Marker::NextLayer)),
            (" CHANGE_LAYER", Some(Marker::NextLayer)),
            ("LAYER:12", Some(Marker::Layer(Some(12)))),
            ("LAYER:-2", Some(Marker::Layer(None))),
            ("LAYER:x", None),
            ("TYPE:Solid infill", Some(Marker::Feature(Feature::SolidInfill))),
            (" FEATURE: Prime tower", Some(Marker::Feature(Feature::PrimeTower))),
            ("LAYER_COUNT:3", None),
            (" layer 1, Z = 0.200", Some(Marker::Layer(Some(0)))),
            (" layer height", None),
            (" layer end", None),
            (" feature outer perimeter", Some(Marker::Feature(Feature::OuterWall))),
            ("BEGIN_LAYER_OBJECT z=0.25", Some(Marker::NextLayer)),
            ("Z:0.2", None),
            ("", None),
        ] {
            assert_eq!(Marker::read(comment), marker, "{comment}");
        }
    }
}
