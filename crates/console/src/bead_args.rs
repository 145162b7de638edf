//! Flags of beads: insets, infill, solid layers, seams.

use beadwork_part::toolpath::{self, InfillPattern};
use beadwork_search::plan::beads::{self, Seam};
use beadwork_search::{join, travel};

/// Spanning trees of the bound on travel, each of which takes O(n²) for the n beads of a tool in a
/// layer.
const BOUND_ITERATIONS: u32 = 20;

/// Flags that name the beads of a part.
#[derive(clap::Args)]
pub struct BeadArgs {
    /// Infill density in per cent; 100 for solid parts.
    #[arg(
        long,
        value_name = "PERCENT",
        default_value_t = 20.0,
        value_parser = percent,
        allow_hyphen_values = true
    )]
    pub density: f64,
    /// Infill pattern: lines, grid, triangles, hexagons, hybrid (triangles and hexagons) or
    /// concentric.
    #[arg(long, value_name = "NAME", default_value = "lines")]
    pattern: InfillPattern,
    /// Direction of infill lines in degrees, from the x axis; lines turn by 90 degrees in each
    /// layer.
    #[arg(long, value_name = "DEGREES", default_value_t = 45.0, allow_hyphen_values = true)]
    angle: f64,
    /// Number of insets along each outline.
    #[arg(long, value_name = "N", default_value_t = 2)]
    perimeters: u32,
    /// Number of solid layers at the top and at the bottom.
    #[arg(long, value_name = "N", default_value_t = 3)]
    solid_layers: u32,
    /// Leave gaps between insets, and between them and infill, empty.
    #[arg(long)]
    no_gap_fill: bool,
    /// Leave out walls that are too thin for an inset.
    #[arg(long)]
    no_thin_walls: bool,
    /// Join the insets and the infill of each island to one bead where the geometry allows it.
    #[arg(long)]
    join: bool,
    /// Where outlines begin: aligned (above each other), nearest (shortest travel), rear or random.
    /// With --join, an outline that is joined to infill begins near an end of that infill.
    #[arg(long, value_name = "RULE", default_value = "aligned")]
    seam: Seam,
    /// Order of the beads of a layer: islands (one island after the other, loops before infill) or
    /// free (shortest travel).
    #[arg(long, value_name = "RULE", default_value = "islands")]
    order: OrderName,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum OrderName {
    Islands,
    Free,
}

fn percent(text: &str) -> Result<f64, String> {
    let percent = text.parse().ok().filter(|percent| (0.0..=100.0).contains(percent));
    percent.ok_or_else(|| "expected a number from 0 to 100".to_owned())
}

impl BeadArgs {
    /// Settings of insets and infill, for beads of a width in mm.
    pub fn toolpath(&self, bead_mm: f64) -> toolpath::Settings {
        toolpath::Settings {
            bead_mm,
            perimeters: self.perimeters,
            density: self.density / 100.0,
            pattern: self.pattern,
            angle_degrees: self.angle,
            top_layers: self.solid_layers,
            bottom_layers: self.solid_layers,
            gap_fill: !self.no_gap_fill,
            thin_walls: !self.no_thin_walls,
            ..toolpath::Settings::default()
        }
    }

    /// Whether insets and infill are joined.
    pub fn has_joined(&self) -> bool {
        self.join
    }

    /// Settings of the planner, for beads of a width in mm.
    pub fn plan(&self, bead_mm: f64, seed: u64) -> beads::Settings {
        let join = join::Settings {
            max_step_mm: 2.0 * bead_mm,
            clearance_mm: 0.45 * bead_mm,
            slit_mm: bead_mm,
        };
        beads::Settings {
            join: self.join.then_some(join),
            order: match self.order {
                OrderName::Islands => travel::Order::Stages,
                OrderName::Free => travel::Order::Free,
            },
            seam: self.seam,
            bound_iterations: BOUND_ITERATIONS,
            seed,
            ..beads::Settings::default()
        }
    }
}
