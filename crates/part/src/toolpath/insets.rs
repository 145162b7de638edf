//! Insets, the region inside them, and the gaps between them.
//!
//! Inset k is the border of the island's outline offset by k + 1/2 beads, always computed from the
//! outline, so that errors do not add up.
//! Where less than 1.6 beads of width are left, the two sides of an inset would overlap: there the
//! inset is cut out, and the area belongs to the residue.

use super::island::Inset;
use super::settings::Settings;
use crate::area::{Area, Ring};
use crate::simplify::squared_to_line;

/// Half the width, in beads, below which an inset is cut out.
const WIDE: f64 = 0.8;

/// Length, in beads, by which an inset reaches into narrower places.
const REACH: f64 = 0.3;

/// Maximum deviation in mm of the outline that offsets are computed from.
const OUTLINE_TOLERANCE_MM: f64 = 0.004;

/// Maximum deviation in mm of an inset from the exact offset of that outline.
const INSET_TOLERANCE_MM: f64 = 0.004;

/// Maximum deviation in mm of arcs of insets.
const ARC_TOLERANCE_MM: f64 = 0.002;

/// Tolerance, in beads, of the areas that gaps are found with, which takes most of the time.
/// Growing concave arcs of many corners would be slow, because all lines meet in the centre.
const GAP_TOLERANCE: f64 = 0.02;

/// Width, in beads, below which thin walls are dropped.
const MIN_WALL: f64 = 0.2;

/// Width, in beads, below which gaps inside the outermost inset are dropped.
const MIN_GAP: f64 = 0.4;

/// Size, in squares of a bead, below which a piece of the residue is dropped.
const MIN_SIZE: f64 = 0.25;

/// Mean width, in beads, below which a component of the infill region belongs to the residue.
const MIN_INFILL: f64 = 0.5;

/// The insets of an island, and what is inside and between them.
#[derive(Default)]
pub(super) struct Walls {
    pub(super) insets: Vec<Inset>,
    /// Walls too thin for the outermost inset.
    pub(super) thin: Area,
    /// What is left between insets, and between them and infill.
    pub(super) gaps: Area,
    /// Where the centrelines of infill may lie.
    pub(super) infill: Area,
    /// The area between the innermost insets.
    pub(super) inside: Area,
}

impl Walls {
    pub(super) fn new(outline: &Area, settings: &Settings) -> Self {
        let bead_mm = settings.bead_mm;
        let fine = outline.simplified(OUTLINE_TOLERANCE_MM);
        let inner = |beads: f64| fine.shrunk_evenly(beads * bead_mm, ARC_TOLERANCE_MM);
        let coarse = Coarse::new(&fine, bead_mm);
        let mut walls = Self { inside: coarse.outline.clone(), ..Self::default() };
        let mut outer_depth = 0..0;
        for depth in 0..settings.perimeters {
            let beads = f64::from(depth);
            let (wide, is_even) = coarse.inner(beads + WIDE);
            let min_width = if depth == 0 { MIN_WALL } else { MIN_GAP };
            let gaps = if is_even {
                Area::default()
            } else {
                coarse.gaps(&walls.inside, &coarse.grown(&wide, WIDE + REACH), min_width)
            };
            // An even result may be too thin to be left when it is simplified.
            if is_even || !wide.is_empty() {
                let (mut centre, _) = inner(beads + 0.5);
                if !gaps.is_empty() {
                    centre = centre.intersection(&coarse.grown(&wide, WIDE + REACH - 0.5));
                }
                outer_depth = walls.push(depth, outer_depth, &centre);
            }
            if depth == 0 {
                walls.thin = gaps;
            } else {
                walls.gaps.append(gaps);
            }
            (walls.inside, _) = coarse.inner(beads + 1.0);
            if walls.inside.is_empty() {
                return walls;
            }
        }
        // Without insets there is nothing to overlap: infill must stay within the outline.
        let overlap = if settings.perimeters > 0 { settings.infill_overlap } else { 0.0 };
        let margin = 0.5 - overlap;
        let is_wide = |rings: &[Ring]| mean_width_mm(rings) >= MIN_INFILL * bead_mm;
        let (infill, is_even) = inner(f64::from(settings.perimeters) + margin);
        let count = infill.components().len();
        (walls.infill, _) = infill.simplified(INSET_TOLERANCE_MM).split(is_wide);
        if !is_even || walls.infill.components().len() < count {
            let reached = coarse.grown(&walls.infill, margin + REACH);
            walls.gaps.append(coarse.gaps(&walls.inside, &reached, MIN_GAP));
        }
        walls
    }

    /// Appends the insets of a depth, and returns their indices.
    fn push(
        &mut self,
        depth: u32,
        outer: std::ops::Range<usize>,
        centre: &Area,
    ) -> std::ops::Range<usize> {
        let first = self.insets.len();
        for ring in centre.simplified(INSET_TOLERANCE_MM).rings() {
            let parent = nearest(ring, &self.insets, outer.clone());
            self.insets.push(Inset { depth, ring: ring.clone(), parent });
        }
        first..self.insets.len()
    }
}

/// An outline with few corners, to find gaps with.
struct Coarse {
    outline: Area,
    bead_mm: f64,
    tolerance_mm: f64,
}

impl Coarse {
    fn new(outline: &Area, bead_mm: f64) -> Self {
        let tolerance_mm = GAP_TOLERANCE * bead_mm;
        Self { outline: outline.simplified(tolerance_mm), bead_mm, tolerance_mm }
    }

    /// The outline shrunk by a number of beads, and whether that is even.
    fn inner(&self, beads: f64) -> (Area, bool) {
        let (inner, is_even) = self.outline.shrunk_evenly(beads * self.bead_mm, self.tolerance_mm);
        (inner.simplified(self.tolerance_mm), is_even)
    }

    /// An area grown by a number of beads.
    fn grown(&self, area: &Area, beads: f64) -> Area {
        let area = area.simplified(self.tolerance_mm);
        area.offset_within(beads * self.bead_mm, self.tolerance_mm)
    }

    /// What of an area is not reached, without pieces that are too small or narrower than a width
    /// in beads.
    fn gaps(&self, inside: &Area, reached: &Area, min_width: f64) -> Area {
        let min_mm2 = MIN_SIZE * self.bead_mm * self.bead_mm;
        let rest = inside.difference(reached).without_slivers(min_mm2);
        if rest.is_empty() {
            return rest;
        }
        rest.opened(min_width / 2.0 * self.bead_mm).without_slivers(min_mm2)
    }
}

/// Twice the size divided by the length of the border: the width of a long strip.
pub(super) fn mean_width_mm(rings: &[Ring]) -> f64 {
    let mut border_mm = 0.0;
    let mut twice_mm2 = 0.0;
    for ring in rings {
        for (from, to) in ring.iter().zip(ring.iter().skip(1).chain(ring.first())) {
            border_mm += (to[0] - from[0]).hypot(to[1] - from[1]);
            twice_mm2 += from[0] * to[1] - to[0] * from[1];
        }
    }
    if border_mm > 0.0 { twice_mm2 / border_mm } else { 0.0 }
}

/// The inset of a range that is nearest to the first corner of a ring.
fn nearest(ring: &Ring, insets: &[Inset], range: std::ops::Range<usize>) -> Option<usize> {
    let &corner = ring.first()?;
    let distance = |index: &usize| {
        let other = &insets[*index].ring;
        let ends = other.iter().skip(1).chain(other.first());
        other
            .iter()
            .zip(ends)
            .map(|(&from, &to)| squared_to_line(corner, from, to))
            .fold(f64::INFINITY, f64::min)
    };
    range.map(|index| (index, distance(&index))).min_by(|a, b| a.1.total_cmp(&b.1)).map(|it| it.0)
}
