//! The outline of a body in a layer.

use beadwork_base::named_enum;
use i_overlay::core::fill_rule::FillRule as OverlayRule;
use i_overlay::float::simplify::SimplifyShape;

/// Which points count as inside outlines that overlap or intersect themselves.
///
/// The **winding number** of a point is how often the outlines go around it counter-clockwise, less
/// how often they go around it clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillRule {
    /// Points with a winding number other than 0: overlapping shells are united.
    #[default]
    NonZero,
    /// Points with an odd winding number: where two shells overlap there is a hole.
    EvenOdd,
}

named_enum! {
    FillRule, "fill rule":
    NonZero = "nonzero",
    EvenOdd = "evenodd",
}

impl FillRule {
    pub(super) fn is_inside(self, winding: i32) -> bool {
        match self {
            Self::NonZero => winding != 0,
            Self::EvenOdd => winding % 2 != 0,
        }
    }
}

/// Closed polygonal loops with the inside of the body on their left: seen from above, outer loops
/// run counter-clockwise and holes clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// The corners of all loops, loop after loop: x and y in mm.
    points: Vec<[f64; 2]>,
    /// For each loop the index after its last point.
    ends: Vec<usize>,
    /// For each point the colour of the line that begins there, which is the colour of the triangle
    /// that was cut; empty if the body has no colours.
    colours: Vec<u8>,
}

/// An area with holes.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// Corners of the outer border, counter-clockwise, x and y in mm.
    pub outer: Vec<[f64; 2]>,
    /// Borders of the holes, clockwise, in the same form.
    pub holes: Vec<Vec<[f64; 2]>>,
}

impl Outline {
    /// Appends a corner to the loop under construction, with the colour of the line that begins
    /// there.
    pub(super) fn push(&mut self, point: [f64; 2], colour: Option<u8>) {
        self.points.push(point);
        self.colours.extend(colour);
    }

    /// Ends the loop under construction.
    pub(super) fn close(&mut self) {
        self.ends.push(self.points.len());
    }

    /// Appends the loops of another outline; colours are kept only if both have them.
    pub fn append(&mut self, other: &Self) {
        let before = self.points.len();
        if before == 0 || self.colours.len() == before {
            self.colours.extend_from_slice(&other.colours);
        }
        self.points.extend_from_slice(&other.points);
        self.ends.extend(other.ends.iter().map(|end| before + end));
        if self.colours.len() != self.points.len() {
            self.colours.clear();
        }
    }

    /// Whether there are no loops.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The corners of each loop, x and y in mm; the last corner is joined to the first.
    pub fn loops(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.points[start..end])
    }

    /// All lines: both ends, and the colour if the body has colours.
    pub(super) fn lines(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], Option<u8>)> {
        let mut start = 0;
        self.ends.iter().flat_map(move |&end| {
            let begin = std::mem::replace(&mut start, end);
            (begin..end).map(move |at| {
                let next = if at + 1 == end { begin } else { at + 1 };
                (self.points[at], self.points[next], self.colours.get(at).copied())
            })
        })
    }

    /// Area weighted by the winding number, in mm²: holes subtract, overlaps count twice.
    pub fn area_mm2(&self) -> f64 {
        self.lines().map(|(from, to, _)| (from[0] * to[1] - to[0] * from[1]) / 2.0).sum()
    }

    /// The inside as polygons that neither overlap nor intersect themselves, each with its holes.
    pub fn polygons(&self, rule: FillRule) -> Vec<Polygon> {
        let loops: Vec<Vec<[f64; 2]>> = self.loops().map(<[_]>::to_vec).collect();
        let rule = match rule {
            FillRule::NonZero => OverlayRule::NonZero,
            FillRule::EvenOdd => OverlayRule::EvenOdd,
        };
        let polygon = |mut loops: Vec<Vec<[f64; 2]>>| {
            let holes = loops.split_off(1);
            Polygon { outer: loops.pop().expect("every polygon has an outer border"), holes }
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
    fn appended_outlines_keep_all_loops() {
        let mut both = outline(&[square(0.0, 2.0, false)]);
        both.append(&outline(&[square(5.0, 1.0, false), square(7.0, 1.0, true)]));
        assert_eq!(both.loops().map(<[_]>::len).collect::<Vec<_>>(), [4, 4, 4]);
        assert!((both.area_mm2() - 4.0).abs() < 1e-12);
        let mut coloured = Outline::default();
        coloured.push([0.0; 2], Some(3));
        coloured.close();
        let mut twice = Outline::default();
        twice.append(&coloured);
        twice.append(&coloured);
        assert_eq!(twice.colours, [3, 3]);
        twice.append(&both);
        assert!(twice.colours.is_empty());
    }

    #[test]
    fn overlapping_shells_are_united_or_subtracted() {
        let outline = outline(&[square(0.0, 2.0, false), square(1.0, 2.0, false)]);
        assert_eq!(outline.polygons(FillRule::NonZero).len(), 1);
        assert_eq!(outline.polygons(FillRule::EvenOdd).len(), 2);
    }
}
