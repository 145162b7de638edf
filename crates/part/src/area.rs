//! Areas: sets of polygons with holes, with boolean operations and offsets.

use i_overlay::core::fill_rule::FillRule as OverlayFill;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::single::SingleFloatOverlay;
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};

use crate::slice::FillRule;

/// Angle in radians of the steps that approximate rounded corners: at a radius of 1 mm they deviate
/// by 0.001 mm.
const ROUND_STEP: f64 = 0.1;

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
        let mut points = self.rings().flatten();
        let first = *points.next()?;
        Some(points.fold([first; 2], |[min, max], point| {
            [[0, 1].map(|k| min[k].min(point[k])), [0, 1].map(|k| max[k].max(point[k]))]
        }))
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

    fn overlay(&self, other: &Self, rule: OverlayRule) -> Self {
        let components = self.components.overlay(&other.components, rule, OverlayFill::NonZero);
        Self { components }
    }

    /// The area grown by a distance in mm, or shrunk if it is negative, with rounded corners.
    ///
    /// Grown: all points within the distance of the area.
    /// Shrunk: the points whose distance to everything outside is at least the distance.
    #[must_use]
    pub fn offset(&self, by_mm: f64) -> Self {
        if by_mm.abs() < f64::EPSILON || self.is_empty() {
            return self.clone();
        }
        let style = OutlineStyle::new(by_mm).line_join(LineJoin::Round(ROUND_STEP));
        Self { components: self.components.outline(&style) }
    }

    /// The area without parts that are thinner than twice a distance in mm.
    #[must_use]
    pub fn opened(&self, by_mm: f64) -> Self {
        self.offset(-by_mm).offset(by_mm)
    }
}

/// Area enclosed by a ring in mm², negative if the ring is clockwise.
pub(crate) fn ring_size_mm2(ring: &[[f64; 2]]) -> f64 {
    let Some(&origin) = ring.first() else { return 0.0 };
    let from_origin = |point: [f64; 2]| [point[0] - origin[0], point[1] - origin[1]];
    let cross = |pair: &[[f64; 2]]| {
        let [a, b] = [pair[0], pair[1]].map(from_origin);
        (a[0] * b[1] - b[0] * a[1]) / 2.0
    };
    ring.windows(2).map(cross).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, side: f64) -> Ring {
        vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
    }

    fn area(rings: &[Ring]) -> Area {
        Area::from_rings(rings, FillRule::EvenOdd)
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
}
