//! The outline of a body in a layer.

use i_overlay::core::fill_rule::FillRule as OverlayRule;
use i_overlay::float::simplify::SimplifyShape;

/// Which points lie within outlines that overlap or run into each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillRule {
    /// Those that the outlines go around, on balance: shells that overlap are joined.
    #[default]
    NonZero,
    /// Those that a ray leaves through an odd number of outlines: where two shells overlap is a
    /// hole.
    EvenOdd,
}

impl FillRule {
    pub(super) fn is_inside(self, winding: i32) -> bool {
        match self {
            Self::NonZero => winding != 0,
            Self::EvenOdd => winding % 2 != 0,
        }
    }
}

/// Closed loops of straight lines, the body on the left of each: outer ones run counter-clockwise
/// seen from above, holes clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    points: Vec<[f64; 2]>,
    /// Where each loop ends in `points`.
    ends: Vec<usize>,
    /// For the line from each point on the number its triangle was painted with; empty without
    /// paint.
    paint: Vec<u8>,
}

/// An area with holes.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// Its outer border, counter-clockwise, x and y in mm.
    pub outer: Vec<[f64; 2]>,
    /// The borders of its holes, clockwise.
    pub holes: Vec<Vec<[f64; 2]>>,
}

impl Outline {
    pub(super) fn push(&mut self, point: [f64; 2], paint: Option<u8>) {
        self.points.push(point);
        self.paint.extend(paint);
    }

    pub(super) fn close(&mut self) {
        self.ends.push(self.points.len());
    }

    /// Takes over the loops of another outline; paint is kept only if both have it.
    pub fn append(&mut self, other: &Self) {
        let before = self.points.len();
        if before == 0 || self.paint.len() == before {
            self.paint.extend_from_slice(&other.paint);
        }
        self.points.extend_from_slice(&other.points);
        self.ends.extend(other.ends.iter().map(|end| before + end));
        if self.paint.len() != self.points.len() {
            self.paint.clear();
        }
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The loops: corners, x and y in mm; the last one is linked to the first.
    pub fn loops(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.points[start..end])
    }

    /// All lines, from and to, with their paint if there is any.
    pub(super) fn lines(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], Option<u8>)> {
        let mut start = 0;
        self.ends.iter().flat_map(move |&end| {
            let begin = std::mem::replace(&mut start, end);
            (begin..end).map(move |at| {
                let next = if at + 1 == end { begin } else { at + 1 };
                (self.points[at], self.points[next], self.paint.get(at).copied())
            })
        })
    }

    /// Area by how often the outlines go around, in mm²: holes count against it.
    pub fn area_mm2(&self) -> f64 {
        self.lines().map(|(from, to, _)| (from[0] * to[1] - to[0] * from[1]) / 2.0).sum()
    }

    /// The area within as polygons that neither overlap nor cross themselves, each with its holes.
    pub fn polygons(&self, rule: FillRule) -> Vec<Polygon> {
        let loops: Vec<Vec<[f64; 2]>> = self.loops().map(<[_]>::to_vec).collect();
        let rule = match rule {
            FillRule::NonZero => OverlayRule::NonZero,
            FillRule::EvenOdd => OverlayRule::EvenOdd,
        };
        let polygon = |mut loops: Vec<Vec<[f64; 2]>>| {
            let holes = loops.split_off(1);
            Polygon { outer: loops.pop().expect("every shape has an outer border"), holes }
        };
        loops.simplify_shape(rule).into_iter().map(polygon).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, side: f64, is_hole: bool) -> Vec<[f64; 2]> {
        let mut corners = vec![[x, x], [x + side, x], [x + side, x + side], [x, x + side]];
        if is_hole {
            corners.reverse();
        }
        corners
    }

    fn outline(loops: &[Vec<[f64; 2]>]) -> Outline {
        let mut outline = Outline::default();
        for corners in loops {
            corners.iter().for_each(|&corner| outline.push(corner, None));
            outline.close();
        }
        outline
    }

    #[test]
    fn holes_belong_to_their_polygons() {
        let outline =
            outline(&[square(0.0, 10.0, false), square(2.0, 5.0, true), square(3.0, 1.0, false)]);
        assert!((outline.area_mm2() - 76.0).abs() < 1e-12);
        let mut polygons = outline.polygons(FillRule::NonZero);
        polygons.sort_by_key(|polygon| polygon.holes.len());
        assert_eq!(polygons.iter().map(|polygon| polygon.holes.len()).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(outline.loops().count(), 3);
        assert_eq!(outline.lines().count(), 12);
    }

    #[test]
    fn outlines_are_joined() {
        let mut both = outline(&[square(0.0, 2.0, false)]);
        both.append(&outline(&[square(5.0, 1.0, false), square(7.0, 1.0, true)]));
        assert_eq!(both.loops().map(<[_]>::len).collect::<Vec<_>>(), [4, 4, 4]);
        assert!((both.area_mm2() - 4.0).abs() < 1e-12);
        let mut painted = Outline::default();
        painted.push([0.0; 2], Some(3));
        painted.close();
        let mut twice = Outline::default();
        twice.append(&painted);
        twice.append(&painted);
        assert_eq!(twice.paint, [3, 3]);
        twice.append(&both);
        assert!(twice.paint.is_empty());
    }

    #[test]
    fn overlapping_shells_are_joined_or_taken_apart() {
        let outline = outline(&[square(0.0, 2.0, false), square(1.0, 2.0, false)]);
        assert_eq!(outline.polygons(FillRule::NonZero).len(), 1);
        assert_eq!(outline.polygons(FillRule::EvenOdd).len(), 2);
    }
}
