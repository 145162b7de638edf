//! Distances of segments, and a grid that finds the segments near one.

use crate::lists::Lists;

/// A point in the plane, x and y in mm.
type Point = [f64; 2];

/// A straight piece of a line or ring.
pub(crate) type Segment = [Point; 2];

/// Maximum number of cells of a grid, and of pairs of a cell and a segment, apart from one for each
/// segment.
const MAX_CELLS: f64 = 1e6;

/// The point at a share of a segment.
#[inline]
pub(crate) fn point_at([a, b]: Segment, share: f64) -> Point {
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

/// Length of a segment.
#[inline]
pub(crate) fn length([a, b]: Segment) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

/// Vector product of the steps from `a` to `b` and from `a` to `c`: positive if c lies to the left.
#[inline]
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Share of a segment at which it is nearest to a point, 0 to 1, and the distance there.
pub(crate) fn project(point: Point, segment: Segment) -> (f64, f64) {
    let [a, b] = segment;
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    let along = (point[0] - a[0]) * x + (point[1] - a[1]) * y;
    let square = x * x + y * y;
    let share = if along > 0.0 { (along / square).min(1.0) } else { 0.0 };
    (share, length([point, point_at(segment, share)]))
}

/// Whether two segments come within a distance of each other.
pub(crate) fn are_near(p: Segment, q: Segment, distance: f64) -> bool {
    let near = |point: Point, segment: Segment| project(point, segment).1 <= distance;
    crosses(p, q) || near(p[0], q) || near(p[1], q) || near(q[0], p) || near(q[1], p)
}

/// Whether the ends of each segment lie on opposite sides of the other.
fn crosses(p: Segment, q: Segment) -> bool {
    let separates = |p: Segment, q: Segment| {
        let [a, b] = q.map(|point| turn(p[0], p[1], point));
        (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0)
    };
    separates(p, q) && separates(q, p)
}

/// Whether two segments cross, and the ends of each lie on opposite sides of the other at more than
/// a distance from it.
pub(crate) fn cross_beyond(p: Segment, q: Segment, distance: f64) -> bool {
    let far = |p: Segment, q: Segment| {
        let limit = distance * length(p);
        q.iter().all(|&point| turn(p[0], p[1], point).abs() > limit)
    };
    crosses(p, q) && far(p, q) && far(q, p)
}

/// A segment without a margin at each end; `None` if nothing is left.
pub(crate) fn shorten(segment: Segment, margin: f64) -> Option<Segment> {
    let share = margin / length(segment);
    (share < 0.5).then(|| [point_at(segment, share), point_at(segment, 1.0 - share)])
}

/// The interval of shares of a segment at which it lies within a distance of another segment; empty
/// if the first number is above the second.
///
/// The points within a distance of a segment form a convex set, so there is one interval.
pub(crate) fn near_interval(segment: Segment, other: Segment, distance: f64) -> [f64; 2] {
    let mut interval = [f64::INFINITY, f64::NEG_INFINITY];
    let mut join = |[from, to]: [f64; 2]| {
        if from <= to {
            interval = [interval[0].min(from), interval[1].max(to)];
        }
    };
    let size = length(segment);
    if size == 0.0 {
        let is_near = project(segment[0], other).1 <= distance;
        return if is_near { [0.0, 1.0] } else { interval };
    }
    // Discs around the ends of the other segment.
    for point in other {
        let [x, y] = [0, 1].map(|k| (segment[1][k] - segment[0][k]) / size);
        let [dx, dy] = [0, 1].map(|k| point[k] - segment[0][k]);
        let (along, across) = (dx * x + dy * y, dx * y - dy * x);
        let half2 = distance * distance - across * across;
        if half2 >= 0.0 {
            let half = half2.sqrt();
            join([((along - half) / size).max(0.0), ((along + half) / size).min(1.0)]);
        }
    }
    // The rectangle along the other segment.
    let width = length(other);
    if width > 0.0 {
        let [x, y] = [0, 1].map(|k| (other[1][k] - other[0][k]) / width);
        let local = segment.map(|point| {
            let [dx, dy] = [0, 1].map(|k| point[k] - other[0][k]);
            [dx * x + dy * y, dy * x - dx * y]
        });
        let mut shares = [0.0_f64, 1.0];
        for (k, [low, high]) in [[0.0, width], [-distance, distance]].into_iter().enumerate() {
            let (start, step) = (local[0][k], local[1][k] - local[0][k]);
            if step == 0.0 {
                if start < low || start > high {
                    shares = [1.0, 0.0];
                }
            } else {
                let [a, b] = [(low - start) / step, (high - start) / step];
                shares = [shares[0].max(a.min(b)), shares[1].min(a.max(b))];
            }
        }
        join(shares);
    }
    interval
}

/// Segments by the cells of a square grid that they pass.
pub(crate) struct SegmentGrid {
    segments: Vec<Segment>,
    origin: Point,
    cell: f64,
    size: [usize; 2],
    cells: Lists,
}

impl SegmentGrid {
    /// A grid with cells of at least the given size in mm, larger where it would have too many.
    pub(crate) fn new(segments: Vec<Segment>, cell: f64) -> Self {
        let [mut min, mut max] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for &point in segments.as_flattened() {
            min = [0, 1].map(|k| min[k].min(point[k]));
            max = [0, 1].map(|k| max[k].max(point[k]));
        }
        if segments.is_empty() {
            [min, max] = [[0.0; 2]; 2];
        }
        let extent = [0, 1].map(|k| max[k] - min[k]);
        let total: f64 = segments.iter().map(|&segment| length(segment)).sum();
        let cell = cell
            .max((extent[0] * extent[1] / MAX_CELLS).sqrt())
            .max(extent[0].max(extent[1]) / MAX_CELLS)
            .max(total / MAX_CELLS);
        let size = extent.map(|extent| (extent / cell) as usize + 1);
        let mut grid = Self { segments, origin: min, cell, size, cells: Lists::default() };
        let passes: Vec<(usize, u32)> = (0..grid.segments.len())
            .flat_map(|number| {
                let mut cells = Vec::new();
                grid.pass(grid.segments[number], |cell| cells.push((cell, number as u32)));
                cells
            })
            .collect();
        grid.cells = Lists::new(size[0] * size[1], passes.into_iter());
        grid
    }

    /// Number of the column or row at a coordinate, that of the nearest if it lies outside.
    #[inline]
    fn band(&self, k: usize, value: f64) -> usize {
        (((value - self.origin[k]) / self.cell) as usize).min(self.size[k] - 1)
    }

    /// Calls `visit` with each cell that a segment passes, and a few more.
    fn pass(&self, [a, b]: Segment, mut visit: impl FnMut(usize)) {
        let [left, right] = if a[0] <= b[0] { [a, b] } else { [b, a] };
        // Cells that a segment touches at their border count, in spite of rounding.
        let slack = self.cell * 1e-6;
        let columns = [self.band(0, left[0] - slack), self.band(0, right[0] + slack)];
        for column in columns[0]..=columns[1] {
            let at = |x: f64| left[1] + (x - left[0]) / (right[0] - left[0]) * (right[1] - left[1]);
            let border = self.origin[0] + column as f64 * self.cell;
            let [first, last] = [border - slack, border + self.cell + slack];
            let from = if first <= left[0] { left[1] } else { at(first) };
            let to = if last >= right[0] { right[1] } else { at(last) };
            let rows = [self.band(1, from.min(to) - slack), self.band(1, from.max(to) + slack)];
            (rows[0]..=rows[1]).for_each(|row| visit(row * self.size[0] + column));
        }
    }

    /// The segments.
    pub(crate) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Calls `visit` with numbers of segments until it returns true; returns whether it did.
    ///
    /// Visits each segment within `distance` of the given one at least once, and others.
    pub(crate) fn any_near(
        &self,
        [a, b]: Segment,
        distance: f64,
        mut visit: impl FnMut(u32) -> bool,
    ) -> bool {
        let range = |k: usize| {
            self.band(k, a[k].min(b[k]) - distance)..=self.band(k, a[k].max(b[k]) + distance)
        };
        range(1).any(|row| {
            range(0).any(|column| {
                let cell = row * self.size[0] + column;
                self.cells.list(cell).iter().any(|&number| visit(number))
            })
        })
    }
}
