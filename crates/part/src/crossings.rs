//! Whether rings cross or touch.

use crate::measure::bounds;

/// Distance in mm below which lines count as touching.
const MARGIN_MM: f64 = 1e-7;

/// Number of pairs of lines, for each line, that are compared before rings count as crossing.
const MAX_PAIRS: usize = 200;

type Point = [f64; 2];

/// A line of a ring; its ends by x, and its position in the ring.
struct Line {
    left: Point,
    right: Point,
    ring: usize,
    at: usize,
}

/// Whether no line of the rings crosses or touches another one, apart from its neighbours.
///
/// May be false if rings are too near each other, or too intricate to compare in short time.
/// O(n log n) for usual rings, O(200 n) at worst.
pub(crate) fn are_clear(rings: &[Vec<Point>]) -> bool {
    let mut lines = Vec::with_capacity(rings.iter().map(Vec::len).sum());
    for (number, ring) in rings.iter().enumerate() {
        if ring.len() < 3 {
            return false;
        }
        if !ring.iter().flatten().all(|x| x.is_finite()) {
            return false;
        }
        push_lines(ring, number, &mut lines);
    }
    lines.sort_unstable_by(|a, b| a.left[0].total_cmp(&b.left[0]));
    let mut pairs = 0;
    // Lines that reach the left end of the current one.
    let mut open: Vec<&Line> = Vec::new();
    for line in &lines {
        open.retain(|other| other.right[0] + MARGIN_MM >= line.left[0]);
        pairs += open.len();
        if pairs > MAX_PAIRS * lines.len() {
            return false;
        }
        let is_clear = |other: &&Line| {
            let count = rings[line.ring].len();
            let is_neighbour = line.ring == other.ring
                && (line.at.abs_diff(other.at) == 1 || line.at.abs_diff(other.at) == count - 1);
            is_neighbour || are_apart(line, other)
        };
        if !open.iter().all(is_clear) {
            return false;
        }
        open.push(line);
    }
    true
}

/// For each of several components whether it has a point in common with an area, both as rings.
///
/// May be true for components that do not, if they are too intricate to compare in short time.
/// O(n log n) for usual rings, O(200 n) at worst, times the number of rings for those that neither
/// cross nor are left or right of each other.
pub(crate) fn meeting(components: &[&[Vec<Point>]], area: &[&Vec<Point>]) -> Vec<bool> {
    let Some([min, max]) = bounds(area.iter().copied().flatten()) else {
        return vec![false; components.len()];
    };
    let mut lines = Vec::new();
    let area_number = components.len();
    for (number, component) in components.iter().enumerate() {
        component.iter().for_each(|ring| push_lines(ring, number, &mut lines));
    }
    // Lines beside the area do not cross it.
    lines.retain(|line| {
        let (low, high) = (line.left[1].min(line.right[1]), line.left[1].max(line.right[1]));
        line.left[0] <= max[0] && line.right[0] >= min[0] && low <= max[1] && high >= min[1]
    });
    area.iter().for_each(|ring| push_lines(ring, area_number, &mut lines));
    lines.sort_unstable_by(|a, b| a.left[0].total_cmp(&b.left[0]));

    let mut is_met = vec![false; components.len()];
    let mut pairs = 0;
    // Lines of components, and of the area, that reach the left end of the current one.
    let mut open: [Vec<&Line>; 2] = [Vec::new(), Vec::new()];
    for line in &lines {
        let of_area = line.ring == area_number;
        if !of_area && is_met[line.ring] {
            continue;
        }
        let others = &mut open[usize::from(!of_area)];
        others.retain(|other| other.right[0] + MARGIN_MM >= line.left[0]);
        pairs += others.len();
        if pairs > MAX_PAIRS * lines.len() {
            return vec![true; components.len()];
        }
        for other in others {
            let number = line.ring.min(other.ring);
            if !is_met[number] && !are_apart(line, other) {
                is_met[number] = true;
            }
        }
        open[usize::from(of_area)].push(line);
    }
    // Without crossings, one may lie inside the other.
    for (is_met, component) in is_met.iter_mut().zip(components) {
        if !*is_met {
            *is_met =
                component.first().is_some_and(|outer| is_inside(area.iter().copied(), outer[0]))
                    || area.iter().any(|ring| is_inside(component.iter(), ring[0]));
        }
    }
    is_met
}

/// Whether the line through one of two lines has the other one on one side.
///
/// Their ranges of x overlap.
fn are_apart(a: &Line, b: &Line) -> bool {
    let range = |line: &Line| {
        (line.left[1].min(line.right[1]) - MARGIN_MM, line.left[1].max(line.right[1]))
    };
    let ((a_low, a_high), (b_low, b_high)) = (range(a), range(b));
    a_low > b_high || b_low > a_high || is_beside(a, b) || is_beside(b, a)
}

/// Whether all of a line is on one side of the line through another one.
fn is_beside(line: &Line, other: &Line) -> bool {
    let along = [0, 1].map(|k| line.right[k] - line.left[k]);
    let margin = MARGIN_MM * (along[0].abs() + along[1].abs());
    let [one, two] = [other.left, other.right]
        .map(|point| along[0] * (point[1] - line.left[1]) - along[1] * (point[0] - line.left[0]));
    (one > margin && two > margin) || (one < -margin && two < -margin)
}

fn push_lines(ring: &[Point], number: usize, lines: &mut Vec<Line>) {
    lines.extend((0..ring.len()).map(|at| {
        let (a, b) = (ring[at], ring[(at + 1) % ring.len()]);
        let (left, right) = if a[0] <= b[0] { (a, b) } else { (b, a) };
        Line { left, right, ring: number, at }
    }));
}

/// Whether a point lies inside an odd number of rings.
fn is_inside<'a>(rings: impl Iterator<Item = &'a Vec<Point>>, point: Point) -> bool {
    rings.filter(|ring| contains(ring, point)).count() % 2 == 1
}

/// Whether a point lies inside a ring.
pub(crate) fn contains(ring: &[Point], [x, y]: Point) -> bool {
    let mut is_inside = false;
    let mut from = ring[ring.len() - 1];
    for &to in ring {
        if (from[1] <= y) != (to[1] <= y)
            && from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]) > x
        {
            is_inside = !is_inside;
        }
        from = to;
    }
    is_inside
}
