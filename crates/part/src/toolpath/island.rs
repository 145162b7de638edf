//! Islands: the connected areas of a layer, with their lines.

use super::skeleton::Skeleton;
use crate::area::{Area, Ring};

/// A connected area of one material in a layer, and the lines that fill it.
///
/// All lines are centrelines of beads, in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Island {
    /// The material, which is the number of the tool that prints it.
    pub material: u8,
    /// The area; it has one component.
    pub outline: Area,
    /// The insets from the outside inwards, by increasing depth.
    pub insets: Vec<Inset>,
    /// What neither insets nor infill reach: walls thinner than about 1.6 beads, gaps between
    /// insets, and slots too narrow for infill.
    pub residue: Area,
    /// Beads of varying width along the residue, from 0.38 to 1.6 beads wide.
    pub skeletons: Vec<Skeleton>,
    /// Solid and sparse infill, at most one of each; empty without an infill region.
    pub infill: Vec<Infill>,
}

/// A closed bead along the outline.
#[derive(Clone, Debug, PartialEq)]
pub struct Inset {
    /// 0 for the outermost inset.
    pub depth: u32,
    /// The centreline; the rest of the island lies to its left.
    pub ring: Ring,
    /// Index of the nearest inset of the next lower depth; `None` for the outermost insets.
    ///
    /// An inset lies inside the one with this index if that one is counter-clockwise, around it
    /// otherwise.
    pub parent: Option<usize>,
}

/// A region filled with a pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct Infill {
    /// Whether lines are one bead apart.
    pub is_solid: bool,
    /// Where the centrelines of its beads may lie.
    pub region: Area,
    /// Distance from one line to the next in mm, in patterns of one direction; patterns of several
    /// directions have as much length.
    pub spacing_mm: f64,
    /// Open lines with at least two points; they end on the border of the region.
    pub lines: Vec<Vec<[f64; 2]>>,
    /// Closed lines, of concentric infill only, from the outside inwards.
    pub loops: Vec<Ring>,
}

impl Island {
    /// Whether anything of the island is printed; not if it is too small.
    pub fn is_printed(&self) -> bool {
        let has_lines = |infill: &Infill| {
            infill.lines.iter().any(|line| line.len() > 1) || !infill.loops.is_empty()
        };
        !self.insets.is_empty() || !self.skeletons.is_empty() || self.infill.iter().any(has_lines)
    }
}
