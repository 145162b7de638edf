//! Areas: sets of polygons with holes, with boolean operations and offsets.

use i_overlay::core::fill_rule::FillRule as OverlayFill;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::single::SingleFloatOverlay;

use crate::crossings::meeting;
use crate::measure::{bounds, overlap, ring_size_mm2};
use crate::offset::{Offset, offset};
use crate::simplify::simplified;
use crate::slice::FillRule;

/// Maximum deviation in mm of the lines that approximate rounded corners.
const ROUND_TOLERANCE_MM: f64 = 0.002;

/// A closed polygonal line, x and y in mm; the last corner is joined to the first.
pub type Ring = Vec<[f64; 2]>;

/// A set of points of the plane, bounded by rings.
///
/// It consists of components, each with one outer ring, counter-clockwise, and any number of holes,
/// clockwise: the inside lies to the left of every ring.
/// Rings neither cross nor overlap.
/// Coordinates are mm, x to the right and y to the back.
///
/// Operations round coordinates to a grid of at most a millionth of the extent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Area {
    /// The rings of each component, the outer one first.
    components: Vec<Vec<Ring>>,
}

impl Area {
    /// The points inside of rings that may overlap and cross, by a fill rule.
    pub fn from_rings(rings: &[Ring], rule: FillRule) -> Self {
        let rule = match rule {
            FillRule::NonZero => OverlayFill::NonZero,
            FillRule::EvenOdd => OverlayFill::EvenOdd,
        };
        Self { components: rings.simplify_shape(rule) }
    }

    /// Whether the area is empty.
    pub fn is_empty(&self) -> bool {
        self.components.is_empty()
    }

    /// The connected components; for each its rings, the outer one first.
    pub fn components(&self) -> &[Vec<Ring>] {
        &self.components
    }

    /// The components as areas of their own.
    pub fn into_components(self) -> impl Iterator<Item = Self> {
        self.components.into_iter().map(|rings| Self { components: vec![rings] })
    }

    /// All rings, component by component.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        self.components.iter().flatten()
    }

    /// Size in mm².
    pub fn size_mm2(&self) -> f64 {
        self.rings().map(|ring| ring_size_mm2(ring)).sum()
    }

    /// Minimum and maximum x and y in mm; `None` if the area is empty.
    pub fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        bounds(self.components.iter().filter_map(|rings| rings.first()).flatten())
    }

    /// The points that belong to either area.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        self.overlay(other, OverlayRule::Union)
    }

    /// The points that belong to both areas.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        self.overlay(other, OverlayRule::Intersect)
    }

    /// The points of this area that do not belong to the other one.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Self {
        self.overlay(other, OverlayRule::Difference)
    }

    /// The points that belong to any of several areas.
    #[must_use]
    pub fn union_of(mut areas: Vec<Self>) -> Self {
        areas.retain(|area| !area.is_empty());
        if areas.len() <= 1 {
            return areas.pop().unwrap_or_default();
        }
        let rings: Vec<Ring> =
            areas.into_iter().flat_map(|area| area.components).flatten().collect();
        Self::from_rings(&rings, FillRule::NonZero)
    }

    /// The area without components and holes that are smaller than a size in mm².
    #[must_use]
    pub fn without_slivers(mut self, min_mm2: f64) -> Self {
        for rings in &mut self.components {
            let mut is_outer = true;
            rings.retain(|ring| std::mem::take(&mut is_outer) || -ring_size_mm2(ring) >= min_mm2);
        }
        self.components
            .retain(|rings| rings.iter().map(|ring| ring_size_mm2(ring)).sum::<f64>() >= min_mm2);
        self
    }

    /// The area without holes that are slits: those whose mean width, twice their size divided by
    /// their perimeter, is below a width in mm.
    #[must_use]
    pub fn without_slits(mut self, min_width_mm: f64) -> Self {
        for rings in &mut self.components {
            let mut is_outer = true;
            rings.retain(|ring| {
                let size_mm2 = -ring_size_mm2(ring);
                std::mem::take(&mut is_outer)
                    || 2.0 * size_mm2 >= min_width_mm * ring_length_mm(ring)
            });
        }
        self
    }

    /// The area with fewer corners: no point of its border moves by more than a tolerance in mm.
    ///
    /// Rings that keep fewer than three corners are left out.
    #[must_use]
    pub(crate) fn simplified(&self, tolerance_mm: f64) -> Self {
        self.map_rings(|ring| simplified(ring, tolerance_mm))
    }

    /// The area with changed rings; `None` leaves out a ring, or a component if it is the outer
    /// one.
    fn map_rings(&self, map: impl Fn(&[[f64; 2]]) -> Option<Ring>) -> Self {
        let component = |rings: &Vec<Ring>| -> Option<Vec<Ring>> {
            let outer = map(rings.first()?)?;
            let holes = rings[1..].iter().filter_map(|ring| map(ring));
            Some(std::iter::once(outer).chain(holes).collect())
        };
        Self { components: self.components.iter().filter_map(component).collect() }
    }

    /// Appends an area that does not overlap this one.
    pub(crate) fn append(&mut self, other: Self) {
        self.components.extend(other.components);
    }

    /// Splits off the components for which `is_kept` is false.
    pub(crate) fn split(self, is_kept: impl Fn(&[Ring]) -> bool) -> (Self, Self) {
        let (kept, rest) = self.components.into_iter().partition(|rings| is_kept(rings));
        (Self { components: kept }, Self { components: rest })
    }

    /// Combines the components whose bounding boxes reach those of the other area; the others stay
    /// as they are, which is most of the work where two areas hardly overlap.
    fn overlay(&self, other: &Self, rule: OverlayRule) -> Self {
        let (near, far) = self.split_near(other);
        let (other_near, other_far) = other.split_near(self);
        let (keeps_own, keeps_other) = match rule {
            OverlayRule::Intersect => (false, false),
            OverlayRule::Difference => (true, false),
            _ => (true, true),
        };
        let mut components = match (near.is_empty(), other_near.is_empty()) {
            (false, false) => near.overlay(&other_near, rule, OverlayFill::NonZero),
            (false, true) if keeps_own => near,
            (true, false) if keeps_other => other_near,
            _ => Vec::new(),
        };
        if keeps_own {
            components.extend(far);
        }
        if keeps_other {
            components.extend(other_far);
        }
        Self { components }
    }

    /// The components whose bounding boxes reach the bounding box of another area, and the others.
    fn split_near(&self, other: &Self) -> (Vec<Vec<Ring>>, Vec<Vec<Ring>>) {
        let Some([min, max]) = other.bounds() else {
            return (Vec::new(), self.components.clone());
        };
        let is_near =
            |rings: &Vec<Ring>| bounds(&rings[0]).is_some_and(|own| overlap(own, [min, max], 0.0));
        self.components.iter().cloned().partition(is_near)
    }

    /// The area grown by a distance in mm, or shrunk if it is negative, with rounded corners.
    ///
    /// Grown: all points within the distance of the area.
    /// Shrunk: the points whose distance to everything outside is at least the distance.
    /// Arcs lie outside the exact ones when growing, inside when shrinking, by at most 0.002 mm.
    ///
    /// O(n log n) in the corners, and in the crossings of the lines that move.
    #[must_use]
    pub fn offset(&self, by_mm: f64) -> Self {
        self.offset_within(by_mm, ROUND_TOLERANCE_MM)
    }

    /// As [`Area::offset`], with arcs that deviate by at most a tolerance in mm.
    #[must_use]
    pub(crate) fn offset_within(&self, by_mm: f64, tolerance_mm: f64) -> Self {
        if by_mm.abs() < f64::EPSILON || self.is_empty() {
            return self.clone();
        }
        Self { components: offset(&self.components, by_mm, tolerance_mm).components }
    }

    /// The area shrunk by a distance in mm, and whether each of its points is at most
    /// [`EVEN_SPEED`](crate::offset::EVEN_SPEED) times that distance from the result; false if that
    /// is unknown.
    pub(crate) fn shrunk_evenly(&self, by_mm: f64, tolerance_mm: f64) -> (Self, bool) {
        let Offset { components, is_even } = offset(&self.components, -by_mm, tolerance_mm);
        (Self { components }, is_even)
    }

    /// Of several components those that have a point in common with this area, as an area.
    ///
    /// They may overlap each other.
    /// A few that have none may be among them.
    pub(crate) fn union_of_meeting(&self, components: &[&Vec<Ring>]) -> Self {
        let rings: Vec<&Ring> = self.rings().collect();
        let groups: Vec<&[Ring]> = components.iter().map(|rings| &rings[..]).collect();
        let areas = meeting(&groups, &rings).into_iter().zip(components);
        let areas = areas.filter(|(is_met, _)| *is_met);
        Self::union_of(
            areas.map(|(_, rings)| Self { components: vec![(*rings).clone()] }).collect(),
        )
    }

    /// The area without parts that are thinner than twice a distance in mm.
    #[must_use]
    pub fn opened(&self, by_mm: f64) -> Self {
        self.offset(-by_mm).offset(by_mm)
    }
}

/// Length of a ring in mm.
fn ring_length_mm(ring: &[[f64; 2]]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt()).sum()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::simplify::squared_to_line;

    fn square(x: f64, y: f64, side: f64) -> Ring {
        vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
    }

    fn area(rings: &[Ring]) -> Area {
        Area::from_rings(rings, FillRule::EvenOdd)
    }

    #[test]
    fn slits_are_holes_of_little_width() {
        let slit =
            |width: f64| vec![[2.0, 2.0], [2.0, 2.0 + width], [8.0, 8.0 + width], [8.0, 8.0]];
        let with_slit = |width| area(&[square(0.0, 0.0, 10.0), slit(width)]);
        assert_eq!(with_slit(0.01).without_slits(0.02).components()[0].len(), 1);
        assert_eq!(with_slit(0.05).without_slits(0.02).components()[0].len(), 2);
    }

    #[test]
    fn sizes_of_boolean_operations() {
        let frame = area(&[square(0.0, 0.0, 10.0), square(2.0, 2.0, 6.0)]);
        let block = area(&[square(5.0, 5.0, 10.0)]);
        assert!((frame.size_mm2() - 64.0).abs() < 1e-4);
        assert_eq!(frame.components()[0].len(), 2);
        let sizes = [frame.union(&block), frame.intersection(&block), frame.difference(&block)]
            .map(|area| area.size_mm2());
        for (got, expected) in sizes.into_iter().zip([148.0, 16.0, 48.0]) {
            assert!((got - expected).abs() < 1e-3, "{got} {expected}");
        }
    }

    #[test]
    fn offsets_round_corners_outside_and_keep_them_inside() {
        let block = area(&[square(0.0, 0.0, 10.0)]);
        assert!((block.offset(-1.0).size_mm2() - 64.0).abs() < 1e-3);
        let grown = 100.0 + 4.0 * 10.0 + std::f64::consts::PI;
        assert!((block.offset(1.0).size_mm2() - grown).abs() < 0.01);
        let frame = area(&[square(0.0, 0.0, 10.0), square(2.0, 2.0, 6.0)]);
        assert!(frame.offset(-1.5).is_empty());
        assert!(
            (frame.opened(0.5).size_mm2() - (64.0 - (4.0 - std::f64::consts::PI) / 4.0)).abs()
                < 0.01
        );
    }

    /// Borders of offsets once had spikes, which reached back to a corner of the original border.
    #[test]
    fn shrunk_areas_keep_their_distance() {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(9);
        for _ in 0..4_000 {
            let corners = generator.random_range(3..120);
            let radius = generator.random_range(1.0..30.0);
            let waves = f64::from(generator.random_range(0..9_u32));
            let shift = generator.random_range(0.0..1.0);
            let centre = [0, 1].map(|_| generator.random_range(0.0..300.0));
            let corner = |i: u32| {
                let angle = (f64::from(i) + shift) * std::f64::consts::TAU / f64::from(corners);
                let radius = radius * (1.0 + 0.2 * (waves * angle).cos());
                [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
            };
            let mut ring: Ring = (0..corners).map(corner).collect();
            // Corners that are nearly on the line of their neighbours, as meshes have them.
            let part = generator.random_range(0.0..1.0);
            let middle = [0, 1].map(|k| ring[0][k] + part * (ring[1][k] - ring[0][k]));
            ring.insert(1, middle.map(|value| f64::from(value as f32)));
            ring.rotate_left(1);
            let area = area(std::slice::from_ref(&ring));
            for by_mm in [0.25, 0.75, 1.125] {
                for point in area.offset(-by_mm).rings().flatten() {
                    let lines = (0..ring.len()).map(|at| (ring[at], ring[(at + 1) % ring.len()]));
                    let squared = lines
                        .map(|(from, to)| squared_to_line(*point, from, to))
                        .fold(f64::INFINITY, f64::min);
                    assert!(squared.sqrt() > by_mm - 0.003, "{by_mm} {} {ring:?}", squared.sqrt());
                }
            }
        }
    }
}
