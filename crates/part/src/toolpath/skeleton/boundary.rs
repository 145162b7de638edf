//! The boundary of a component as short segments that can be searched.

use super::vector::{Vector, add_scaled, cross, distance, lerp, nearest_on_segment, sub};
use crate::area::Ring;

/// Deviation in mm up to which corners of the outline are dropped.
const SIMPLIFY_MM: f64 = 1e-3;
/// Number of corners that one segment may replace, which bounds the work.
const SIMPLIFY_WINDOW: usize = 64;
/// Coordinates are multiples of this number of mm.
/// Points that are almost equal become one.
const SNAP_MM: f64 = 1.0 / (1 << 20) as f64;
/// Number of segments above which they become longer.
const MAX_SEGMENTS: f64 = 2e5;

/// Rings cut into segments of limited length, in coordinates relative to `origin`.
pub(super) struct Boundary {
    /// Corner of the bounding box, in mm.
    pub(super) origin: Vector,
    /// Ends of segments; those of a ring are consecutive.
    pub(super) points: Vec<Vector>,
    /// Indices of the ends of segments; the inside lies to the left.
    pub(super) segments: Vec<[usize; 2]>,
    /// The segments that touch each cell of a grid, row by row.
    cells: Buckets,
    /// The segments that touch each row of equal height.
    rows: Buckets,
    row_count: usize,
    rows_per_mm: f64,
    /// Numbers of columns and rows.
    size: [usize; 2],
    /// Side of a cell, in mm.
    cell_mm: f64,
}

impl Boundary {
    /// Cuts rings into segments of at most `step_mm`; `None` if nothing is left of them.
    pub(super) fn new(rings: &[Ring], step_mm: f64) -> Option<Self> {
        let mut corners = rings.iter().flatten();
        let first = *corners.next()?;
        let (min, max) = corners.fold((first, first), |(min, max), p| {
            ([min[0].min(p[0]), min[1].min(p[1])], [max[0].max(p[0]), max[1].max(p[1])])
        });
        let extent = sub(max, min);
        if !extent.iter().all(|side| side.is_finite()) {
            return None;
        }
        let perimeter: f64 = rings
            .iter()
            .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)))
            .map(|(&a, &b)| distance(a, b))
            .sum();
        let step_mm = step_mm.max(perimeter / MAX_SEGMENTS);

        let mut points = Vec::new();
        let mut segments = Vec::new();
        for ring in rings {
            let ring: Vec<_> = ring.iter().map(|&point| sub(point, min)).collect();
            let first = points.len();
            sample_ring(&simplified(&ring, step_mm), step_mm, &mut points);
            let count = points.len() - first;
            if count < 3 {
                points.truncate(first);
                continue;
            }
            segments.extend((0..count).map(|i| [first + i, first + (i + 1) % count]));
        }
        if segments.is_empty() {
            return None;
        }

        let cells_wanted = (4 * segments.len() + 1024) as f64;
        let cell_mm = (3.0 * step_mm)
            .max((extent[0] * extent[1] / cells_wanted).sqrt())
            .max((extent[0] + extent[1]) / cells_wanted);
        let size = extent.map(|side| (side / cell_mm) as usize + 1);
        let cell_of = |point: Vector| -> [usize; 2] {
            [0, 1].map(|k| ((point[k] / cell_mm).max(0.0) as usize).min(size[k] - 1))
        };
        let boxes: Vec<_> = segments
            .iter()
            .map(|&[a, b]| {
                let [a, b] = [a, b].map(|end| cell_of(points[end]));
                [[a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]]
            })
            .collect();
        let cells = Buckets::new(size[0] * size[1], boxes.len(), |segment, visit| {
            let [low, high] = boxes[segment];
            for y in low[1]..=high[1] {
                (low[0]..=high[0]).for_each(|x| visit(y * size[0] + x));
            }
        });
        // As many rows as give each segment a few of them, however flat the component is.
        let heights = segments.iter().map(|&[a, b]| [points[a][1], points[b][1]]);
        let climb: f64 = heights.clone().map(|[a, b]| (a - b).abs()).sum();
        let count = segments.len() as f64;
        let row_count = (3.0 * count * extent[1] / climb).clamp(1.0, 4.0 * count) as usize;
        let rows_per_mm = if extent[1] > 0.0 { row_count as f64 / extent[1] } else { 0.0 };
        let spans: Vec<_> = heights
            .map(|ends| {
                let [a, b] = ends.map(|y| ((y * rows_per_mm) as usize).min(row_count - 1));
                a.min(b)..=a.max(b)
            })
            .collect();
        let rows = Buckets::new(row_count, spans.len(), |segment, visit| {
            spans[segment].clone().for_each(visit);
        });
        Some(Self {
            origin: min,
            points,
            segments,
            cells,
            rows,
            row_count,
            rows_per_mm,
            size,
            cell_mm,
        })
    }

    /// Whether a point lies inside, by the winding number of the rings.
    pub(super) fn is_inside(&self, point: Vector) -> bool {
        let row = ((point[1] * self.rows_per_mm).max(0.0) as usize).min(self.row_count - 1);
        let mut winding = 0;
        for &segment in self.rows.of(row) {
            let [a, b] = self.segment(segment as usize);
            if (a[1] <= point[1]) != (b[1] <= point[1]) {
                let side = cross(sub(b, a), sub(point, a));
                if a[1] <= point[1] && side > 0.0 {
                    winding += 1;
                } else if a[1] > point[1] && side < 0.0 {
                    winding -= 1;
                }
            }
        }
        winding > 0
    }

    /// The nearest point of the boundary and its distance; `None` if it is farther than `limit_mm`.
    pub(super) fn nearest(&self, point: Vector, limit_mm: f64) -> Option<(f64, Vector)> {
        let home = [0, 1].map(|k| (point[k] / self.cell_mm).floor() as isize);
        // Distance to the border of the cell of the point.
        let margin = [0, 1]
            .map(|k| {
                let from_low = point[k] - home[k] as f64 * self.cell_mm;
                from_low.min(self.cell_mm - from_low)
            })
            .into_iter()
            .fold(self.cell_mm, f64::min);
        let mut best = (limit_mm, None);
        for reach in 0_isize.. {
            if reach > 0 && (reach - 1) as f64 * self.cell_mm + margin > best.0 {
                break;
            }
            for y in home[1] - reach..=home[1] + reach {
                let is_border = (y - home[1]).abs() == reach;
                let step = if is_border || reach == 0 { 1 } else { 2 * reach };
                let mut x = home[0] - reach;
                while x <= home[0] + reach {
                    for &segment in self.segments_at(x, y) {
                        let near = nearest_on_segment(self.segment(segment as usize), point);
                        let distance = distance(near, point);
                        if distance < best.0 {
                            best = (distance, Some(near));
                        }
                    }
                    x += step;
                }
            }
        }
        best.1.map(|near| (best.0, near))
    }

    /// Distance along a ray of unit direction to the boundary, at most `limit_mm`.
    pub(super) fn hit(&self, from: Vector, direction: Vector, limit_mm: f64) -> f64 {
        let to = add_scaled(from, direction, limit_mm);
        let [low, high] = [f64::min, f64::max]
            .map(|pick| [0, 1].map(|k| (pick(from[k], to[k]) / self.cell_mm).floor() as isize));
        let mut best = limit_mm;
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                for &segment in self.segments_at(x, y) {
                    let [a, b] = self.segment(segment as usize);
                    let along = sub(b, a);
                    let divisor = cross(direction, along);
                    if divisor == 0.0 {
                        continue;
                    }
                    let to_a = sub(a, from);
                    let t = cross(to_a, along) / divisor;
                    let u = cross(to_a, direction) / divisor;
                    if t >= 0.0 && t < best && (-1e-9..=1.0 + 1e-9).contains(&u) {
                        best = t;
                    }
                }
            }
        }
        best
    }

    fn segment(&self, segment: usize) -> [Vector; 2] {
        self.segments[segment].map(|end| self.points[end])
    }

    fn segments_at(&self, x: isize, y: isize) -> &[u32] {
        let is_within = |at: isize, size: usize| at >= 0 && at < size as isize;
        if is_within(x, self.size[0]) && is_within(y, self.size[1]) {
            self.cells.of(y as usize * self.size[0] + x as usize)
        } else {
            &[]
        }
    }
}

/// Items sorted into buckets.
struct Buckets {
    /// Where each bucket begins in `items`, and the end of the last one.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Buckets {
    /// `visit_buckets` calls its argument with each bucket of an item.
    fn new(
        buckets: usize,
        items: usize,
        visit_buckets: impl Fn(usize, &mut dyn FnMut(usize)),
    ) -> Self {
        let mut starts = vec![0; buckets + 1];
        for item in 0..items {
            visit_buckets(item, &mut |bucket| starts[bucket + 1] += 1);
        }
        for bucket in 0..buckets {
            starts[bucket + 1] += starts[bucket];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0; starts[buckets] as usize];
        for item in 0..items {
            visit_buckets(item, &mut |bucket| {
                sorted[next[bucket] as usize] = item as u32;
                next[bucket] += 1;
            });
        }
        Self { starts, items: sorted }
    }

    fn of(&self, bucket: usize) -> &[u32] {
        &self.items[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }
}

/// Drops corners that deviate little from segments of at most `step_mm`.
fn simplified(ring: &[Vector], step_mm: f64) -> Ring {
    let mut kept: Ring = Vec::new();
    let mut at = 0;
    while at < ring.len() {
        let from = ring[at];
        kept.push(from);
        let mut next = at + 1;
        while next + 1 < ring.len().min(at + SIMPLIFY_WINDOW) {
            let to = ring[next + 1];
            let is_near = |&corner: &Vector| {
                distance(nearest_on_segment([from, to], corner), corner) <= SIMPLIFY_MM
            };
            if distance(from, to) > step_mm || !ring[at + 1..=next].iter().all(is_near) {
                break;
            }
            next += 1;
        }
        at = next;
    }
    kept
}

/// Appends the corners of a ring and points between them.
fn sample_ring(ring: &[Vector], step_mm: f64, points: &mut Vec<Vector>) {
    let first = points.len();
    let snap = |point: Vector| point.map(|x| (x / SNAP_MM).round() * SNAP_MM);
    for (i, &from) in ring.iter().enumerate() {
        let to = ring[(i + 1) % ring.len()];
        let count = (distance(from, to) / step_mm).ceil().max(1.0);
        for k in 0..count as usize {
            let point = snap(lerp(from, to, k as f64 / count));
            if points.len() == first || points.last() != Some(&point) {
                points.push(point);
            }
        }
    }
    while points.len() > first + 1 && points.last() == Some(&points[first]) {
        points.pop();
    }
}
