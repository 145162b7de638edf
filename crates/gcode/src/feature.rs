//! What the comments of slicers say of the lines that follow: the layer, and what is printed.

/// What a stretch of a program prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Feature {
    /// Nothing was said so far.
    #[default]
    Unknown,
    /// The outermost bead of a wall, and a wall of a single bead.
    OuterWall,
    /// Other beads of a wall, those that hang over, and those between walls.
    InnerWall,
    /// Sparse filling.
    Infill,
    /// Solid filling: what beadwork prints parts of.
    /// Bridges and ironing are of its kind.
    SolidInfill,
    /// What holds up overhangs, and where it meets them.
    Support,
    /// Loops around the part, whether they touch it or not.
    Skirt,
    /// The tower that takes up what is purged when tools change.
    PrimeTower,
    /// Written by hand: the beginning and the end of a print.
    Custom,
    /// A name that is not known here.
    Other,
}

/// What a comment says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Note {
    /// The next layer begins.
    NextLayer,
    /// The layer of this number begins; `None`: one below the part, such as a raft's.
    Layer(Option<u32>),
    /// This is printed from here on.
    Feature(Feature),
}

impl Feature {
    /// The feature that PrusaSlicer, its kin, or Cura call so, in any case.
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
            "Ironing",
            "SKIN",
        ]) {
            Self::SolidInfill
        } else if is(&["Internal infill", "Sparse infill", "FILL"]) {
            Self::Infill
        } else if is(&["External perimeter", "Outer wall", "Thin wall", "WALL-OUTER"]) {
            Self::OuterWall
        } else if is(&[
            "Perimeter",
            "Inner wall",
            "Overhang perimeter",
            "Overhang wall",
            "Gap fill",
            "Gap infill",
            "WALL-INNER",
        ]) {
            Self::InnerWall
        } else if is(&["Prime tower", "Wipe tower", "PRIME-TOWER"]) {
            Self::PrimeTower
        } else if is(&[
            "Support material",
            "Support material interface",
            "Support",
            "Support interface",
        ]) || is(&["SUPPORT-INTERFACE"])
        {
            Self::Support
        } else if is(&["Skirt", "Skirt/Brim", "Brim"]) {
            Self::Skirt
        } else if is(&["Custom"]) {
            Self::Custom
        } else {
            Self::Other
        }
    }

    /// Its name in the comments that beadwork writes: PrusaSlicer's.
    pub fn name(self) -> &'static str {
        match self {
            Self::OuterWall => "External perimeter",
            Self::InnerWall => "Perimeter",
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

impl Note {
    /// What a comment, without its semicolon, says of the lines after it; `None` if nothing.
    pub(super) fn read(comment: &str) -> Option<Self> {
        // Most comments are none of these, and tell so by their first letters.
        let comment = comment.trim();
        if comment == "LAYER_CHANGE" || comment == "CHANGE_LAYER" {
            Some(Self::NextLayer)
        } else if let Some(number) = comment.strip_prefix("LAYER:") {
            let number: i64 = number.trim().parse().ok()?;
            Some(Self::Layer(u32::try_from(number).ok()))
        } else {
            let name =
                comment.strip_prefix("TYPE:").or_else(|| comment.strip_prefix("FEATURE:"))?;
            Some(Self::Feature(Feature::from_name(name)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_as_what_they_name() {
        use Feature::{
            Custom, Infill, InnerWall, OuterWall, PrimeTower, Skirt, SolidInfill, Support,
        };
        for feature in
            [OuterWall, InnerWall, Infill, SolidInfill, Support, Skirt, PrimeTower, Custom]
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
            ("Gap infill", InnerWall),
            ("Thin wall", OuterWall),
        ] {
            assert_eq!(Feature::from_name(name), feature);
        }
        assert_eq!(Feature::from_name("Mystery"), Feature::Other);
    }

    #[test]
    fn comments_of_three_dialects() {
        for (comment, note) in [
            ("LAYER_CHANGE", Some(Note::NextLayer)),
            (" CHANGE_LAYER", Some(Note::NextLayer)),
            ("LAYER:12", Some(Note::Layer(Some(12)))),
            ("LAYER:-2", Some(Note::Layer(None))),
            ("LAYER:x", None),
            ("TYPE:Solid infill", Some(Note::Feature(Feature::SolidInfill))),
            (" FEATURE: Prime tower", Some(Note::Feature(Feature::PrimeTower))),
            ("LAYER_COUNT:3", None),
            ("Z:0.2", None),
            ("", None),
        ] {
            assert_eq!(Note::read(comment), note, "{comment}");
        }
    }
}
