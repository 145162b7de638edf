//! Published measurements of warpage, each with a print that stands for it.

use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Pattern};
use beadwork_thermal::ProcessParameters;
use ndarray::Array3;
use serde::Serialize;

use crate::heat_parts::HeatPart;

/// A publication, with measurements that may be compared with each other.
pub(super) struct Publication {
    /// Authors or title, year and journal.
    pub(super) source: &'static str,
    /// What was measured, and what of the print is not published or was coarsened.
    pub(super) note: &'static str,
    pub(super) cases: Vec<Case>,
}

/// One measured print.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) part: Voxels,
    pub(super) process: ProcessParameters,
    pub(super) plan: Plan,
    /// Time between samples of the estimator, s.
    pub(super) sample_s: f64,
    pub(super) measured: Measured,
}

/// The orders of the layers of a print.
#[derive(Clone, Copy)]
pub(super) enum Plan {
    /// One pattern in all layers.
    Constant(Pattern),
    /// In each layer, the pattern after which temperatures are most even: what the paper's agent is
    /// trained for.
    Even,
}

/// What was measured.
#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Measured {
    /// Warpage, mm.
    Mm(f64),
    /// Rank among the cases of the publication: a higher one warps more; cases with the same rank
    /// are not compared.
    Rank(u8),
}

impl Measured {
    /// A number that increases with the warpage; comparable within a publication only.
    pub(super) fn value(self) -> f64 {
        match self {
            Self::Mm(mm) => mm,
            Self::Rank(rank) => f64::from(rank),
        }
    }
}

/// Seconds between samples of prints in voxels of 0.5 mm.
const SAMPLE_S: f64 = 0.5;

/// All publications.
pub(super) fn publications() -> Vec<Publication> {
    vec![kim(), choi(), sheets()]
}

/// The three parts with the conventional program, and with the best of the paper's three runs.
fn kim() -> Publication {
    let case = |name, part: HeatPart, plan, mm| Case {
        name,
        part: part.voxels(),
        process: ProcessParameters::default(),
        plan,
        sample_s: SAMPLE_S,
        measured: Measured::Mm(mm),
    };
    let (usual, even) = (Plan::Constant(Pattern::CONVENTIONAL), Plan::Even);
    // The paper gives reductions of 85.8, 83.8 and 96.0 %.
    let reduced = |mm: f64, percent: f64| mm * (1.0 - percent / 100.0);
    Publication {
        source: "Kim et al. 2026, Virtual Phys. Prototyp. 21",
        note: "ABS; sizes of the parts are not published, these are ours; \"even\" is a greedy \
               choice of patterns by the paper's reward, not the paper's own program",
        cases: vec![
            case("rectangular, conventional", HeatPart::Rectangular, usual, 2.04),
            case("rectangular, even", HeatPart::Rectangular, even, reduced(2.04, 85.8)),
            case("U, conventional", HeatPart::U, usual, 4.14),
            case("U, even", HeatPart::U, even, reduced(4.14, 83.8)),
            case("pyramid, conventional", HeatPart::Pyramid, usual, 5.49),
            case("pyramid, even", HeatPart::Pyramid, even, reduced(5.49, 96.0)),
        ],
    }
}

/// A block of 100 x 50 x 50 mm at four temperatures of the plate.
fn choi() -> Publication {
    let case = |name, plate_c, rank| Case {
        name,
        part: block([50, 25, 50], [2.0, 1.0]),
        process: ProcessParameters {
            extrusion_c: 240.0,
            plate_c: Some(plate_c),
            // 50 mm/s with beads of 0.5 x 0.25 mm, as volume per time.
            print_mm_s: 50.0 * (0.5 * 0.25) / (2.0 * 1.0),
            ..ProcessParameters::default()
        },
        plan: Plan::Constant(Pattern::CONVENTIONAL),
        sample_s: 8.0 * SAMPLE_S,
        measured: Measured::Rank(rank),
    };
    Publication {
        source: "Choi, Kim, Jeong and Youn 2016, World J. Eng. Technol. 4",
        note: "ABS block of 100 x 50 x 50 mm; only the order of the shape errors is at hand: the \
               hotter the plate, the smaller; simulated in voxels of 2 x 2 x 1 mm at the same \
               volume per time, full infill, air at 25 °C; beads of 0.5 x 0.25 mm are assumed",
        cases: vec![
            case("plate at 50 °C", 50.0, 4),
            case("plate at 70 °C", 70.0, 3),
            case("plate at 90 °C", 90.0, 2),
            case("plate at 110 °C", 110.0, 1),
        ],
    }
}

/// Thin sheets with lines in three directions.
fn sheets() -> Publication {
    let case = |name, pattern: &str, rank| Case {
        name,
        part: block([60, 60, 4], [0.5, 0.25]),
        process: ProcessParameters::default(),
        plan: Plan::Constant(pattern.parse().expect("the pattern exists")),
        sample_s: SAMPLE_S,
        measured: Measured::Rank(rank),
    };
    Publication {
        source: "Part warping by thermal-structural coupling, 2023, 3D Print. Addit. Manuf. 10, \
                 doi 10.1089/3dp.2021.0119",
        note: "thin sheets; only the order is at hand: lines along the diagonal warp most; the \
               sheet of 30 x 30 x 1 mm and ABS are ours",
        cases: vec![
            case("lines along a side", "zigzag-x-0", 1),
            case("lines along the other side", "zigzag-y-0", 1),
            case("lines along the diagonal", "diagonal-0", 2),
        ],
    }
}

/// A full block; `size` is its number of voxels, `sides_mm` the width and the height of one.
pub(super) fn block([width, height, depth]: [u32; 3], sides_mm: [f64; 2]) -> Voxels {
    let [cell_mm, layer_mm] = sides_mm;
    let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm, layer_mm, width, height };
    Voxels::new(frame, Array3::zeros((depth as usize, height as usize, width as usize)))
}
