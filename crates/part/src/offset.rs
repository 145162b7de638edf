//! Offsets of rings, without boolean operations where the result has no crossings.
//!
//! Every edge moves along its normal.
//! Where neighbours diverge, an arc joins them; where they converge, each is cut off at their
//! intersection, and an edge that has shrunk to nothing is left out.
//! The resulting *moved rings* wind once around the points of the offset area, and around other
//! points less often if the area shrinks, more often if it grows:
//!
//! - While a ring moves, it passes over points in one direction only, because no edge turns.
//! - It passes over every point within the distance.
//!   Let q be the point of the border nearest to p, on edge e, and let the segment from q to p
//!   leave what e passes over.
//!   It does so at a point r where e meets another edge f, which is then as far from r as q is.
//!   So p is nearer to f than to q, since the normals of e and f differ: a contradiction.
//!
//! So moved rings that neither cross nor touch are the border of the offset area.
//! Otherwise boolean operations remove the points whose winding number is wrong.
//! For them, an edge that cannot be cut off at an intersection keeps its full length, and is joined
//! to its neighbour through the corner between them.

mod moved;
#[cfg(test)]
mod tests;

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;

use self::moved::{Moved, moved};
use crate::crossings::{are_clear, contains};
use crate::measure::{bounds, overlap, ring_size_mm2};
use crate::simplify::without_spikes;

/// Size in mm² of rings that are left out.
const MIN_RING_MM2: f64 = 1e-7;

type Rings = Vec<Vec<[f64; 2]>>;

/// Maximum speed of corners, relative to edges, in even offsets: that of a corner of 74 degrees.
pub(crate) const EVEN_SPEED: f64 = 1.66;

/// The result of an offset.
pub(crate) struct Offset {
    /// The components, each with its outer ring first.
    pub(crate) components: Vec<Rings>,
    /// Whether every point that rings passed over is at most [`EVEN_SPEED`] times as far from the
    /// result as edges have moved.
    ///
    /// This holds if rings stay clear of each other and corners are not too acute: from each point
    /// passed over, the edge or the corner that passed it leads to the result.
    /// False where this is not known.
    pub(crate) is_even: bool,
}

/// Components, each with its outer ring first, grown by a distance in mm, or shrunk if it is
/// negative.
///
/// Arcs lie outside the exact ones by at most a tolerance in mm, on the side to which rings move.
pub(crate) fn offset(components: &[Rings], by_mm: f64, tolerance_mm: f64) -> Offset {
    let mut done = Vec::new();
    let mut is_even = true;
    let mut crossed: Rings = Vec::new();
    let is_alone = alone(components, by_mm, tolerance_mm);
    for (rings, is_alone) in components.iter().zip(is_alone) {
        let Some(moved) = Component::new(rings, by_mm, tolerance_mm) else {
            is_even = false;
            continue;
        };
        let is_clear = is_alone && moved.is_clear();
        is_even &= is_clear && moved.max_speed <= EVEN_SPEED;
        if is_clear {
            done.push(moved.rings);
        } else if is_alone {
            done.extend(resolved(&moved.rings));
        } else {
            crossed.extend(moved.rings);
        }
    }
    if !crossed.is_empty() {
        done.extend(resolved(&crossed));
    }
    Offset { components: done, is_even }
}

/// Whether the offset of each component cannot meet those of the others, by bounding boxes.
fn alone(components: &[Rings], by_mm: f64, tolerance_mm: f64) -> Vec<bool> {
    if by_mm < 0.0 || components.len() == 1 {
        return vec![true; components.len()];
    }
    let reach = 2.0 * (by_mm + tolerance_mm);
    let boxes: Vec<_> = components.iter().map(|rings| bounds(&rings[0])).collect();
    let meets =
        |a: usize, b: usize| boxes[a].zip(boxes[b]).is_some_and(|(a, b)| overlap(a, b, reach));
    (0..boxes.len()).map(|a| (0..boxes.len()).all(|b| a == b || !meets(a, b))).collect()
}

/// The points around which moved rings wind at least once, in components.
fn resolved(rings: &Rings) -> Vec<Rings> {
    // Where many lines meet in a corner, rounding leaves rings of almost zero size.
    let clean = |ring: &Vec<[f64; 2]>| {
        without_spikes(ring).filter(|ring| ring_size_mm2(ring).abs() > MIN_RING_MM2)
    };
    let clean = |component: Rings| -> Option<Rings> {
        let mut rings = component.iter();
        let outer = clean(rings.next()?)?;
        Some(std::iter::once(outer).chain(rings.filter_map(clean)).collect())
    };
    rings.simplify_shape(FillRule::Positive).into_iter().filter_map(clean).collect()
}

/// The moved rings of a component.
struct Component {
    rings: Rings,
    /// Whether no edge had to be joined through a corner.
    is_plain: bool,
    /// Maximum speed of corners, relative to edges.
    max_speed: f64,
    shrinks: bool,
}

impl Component {
    /// `None` if the component vanishes.
    fn new(rings: &Rings, by_mm: f64, tolerance_mm: f64) -> Option<Self> {
        let mut component =
            Self { rings: Vec::new(), is_plain: true, max_speed: 1.0, shrinks: by_mm < 0.0 };
        for (number, ring) in rings.iter().enumerate() {
            match moved(ring, by_mm, tolerance_mm) {
                Moved::Plain { ring, max_speed } => {
                    component.max_speed = component.max_speed.max(max_speed);
                    component.rings.push(ring);
                }
                Moved::Joined(ring) => {
                    component.is_plain = false;
                    component.rings.push(ring);
                }
                Moved::Nothing if number == 0 => return None,
                Moved::Nothing => {}
            }
        }
        Some(component)
    }

    /// Whether the rings are the border of one component.
    fn is_clear(&self) -> bool {
        if !self.is_plain || !are_clear(&self.rings) {
            return false;
        }
        // Holes that shrink stay where they are; those that grow may have passed each other.
        let [outer, holes @ ..] = &self.rings[..] else { return false };
        !self.shrinks
            || holes.iter().enumerate().all(|(number, hole)| {
                let others = holes.iter().enumerate().filter(|(other, _)| *other != number);
                contains(outer, hole[0])
                    && !others.into_iter().any(|(_, other)| contains(other, hole[0]))
            })
    }
}
