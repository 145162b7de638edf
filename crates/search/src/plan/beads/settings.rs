//! Settings of bead plans.

use beadwork_base::named_enum;

use crate::plan::Constraints;
use crate::{join, link, travel};

/// Where the outermost loop of an outline begins and ends, which leaves a visible mark.
///
/// All other loops begin where travel is shortest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Seam {
    /// Above the seam of the layer below where the outlines are alike, otherwise at the sharpest
    /// corner.
    #[default]
    Aligned,
    /// Where travel is shortest.
    Nearest,
    /// At the maximum y.
    Rear,
    /// At a random corner.
    Random,
}

named_enum! {
    Seam, "seam":
    Aligned = "aligned",
    Nearest = "nearest",
    Rear = "rear",
    Random = "random",
}

/// How the beads of a part are planned.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Which line ends may be joined by extrusion, in multiples of the infill's spacing.
    pub rule: link::Rule,
    /// How infill lines are linked.
    pub link: link::Settings,
    /// How loops and infill of an island are joined to one bead; `None` if they are not.
    pub join: Option<join::Settings>,
    /// In which order the beads of a layer may be printed; an island is a group, and its loops come
    /// in the stage before its infill.
    pub order: travel::Order,
    /// Where outlines begin.
    pub seam: Seam,
    /// Where the nozzle is after each change of the tool, x and y in mm: the prime tower.
    /// If `None`, it changes the tool where it is.
    pub tool_change_mm: Option<[f64; 2]>,
    /// What a retraction costs beside the length of travel; `None` if nothing.
    pub retraction: Option<travel::Retraction>,
    /// Kicks of the search for short travel, for each bead.
    pub kicks_per_bead: u32,
    /// Spanning trees of the bound on travel, for each layer and tool; 0 for no bound.
    pub bound_iterations: u32,
    /// What the order of the tools must obey.
    pub constraints: Constraints,
    /// Seed of all random choices.
    pub seed: u64,
}

impl Default for Settings {
    /// Infill linked by [`Method::Cover`](link::Method::Cover), nothing joined, island by island
    /// with loops before infill, aligned seams, tools changed in place, no cost of
    /// retractions, no bound on travel, no constraints, seed 0.
    fn default() -> Self {
        Self {
            rule: link::Rule::default(),
            link: link::Settings::default(),
            join: None,
            order: travel::Order::Stages,
            seam: Seam::default(),
            tool_change_mm: None,
            retraction: None,
            kicks_per_bead: 6,
            bound_iterations: 0,
            constraints: Constraints::default(),
            seed: 0,
        }
    }
}
