//! Whether rings cross or touch.

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
/// May be false if rings are too near each other, or too intricate to tell in short time.
/// O(n log n) for usual rings, O(200 n) at worst.
pub(super) fn are_clear(rings: &[Vec<Point>]) -> bool {
    let mut lines = Vec::with_capacity(rings.iter().map(Vec::len).sum());
    for (number, ring) in rings.iter().enumerate() {
        if ring.len() < 3 {
            return false;
        }
        for at in 0..ring.len() {
            let (a, b) = (ring[at], ring[(at + 1) % ring.len()]);
            let (left, right) = if a[0] <= b[0] { (a, b) } else { (b, a) };
            if !left.iter().chain(&right).all(|x| x.is_finite()) {
                return false;
            }
            lines.push(Line { left, right, ring: number, at });
        }
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
    let [one, two] = [other.left, other.right].map(|point| {
        along[0] * (point[1] - line.left[1]) - along[1] * (point[0] - line.left[0])
    });
    (one > margin && two > margin) || (one < -margin && two < -margin)
}

/// Whether a point lies inside a ring.
pub(super) fn contains(ring: &[Point], [x, y]: Point) -> bool {
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
