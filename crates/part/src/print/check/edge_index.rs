//! An index of the edges of an area, for the distance of lines from its outline.
//!
//! A grid of square cells covers the area, with about as many cells as there are edges.
//! Each cell lists the edges that pass through it, and each row of cells the edges that reach into
//! it, so a query looks only at the edges nearby.

use crate::Area;

/// The edges of an area by position.
#[derive(Debug)]
pub(super) struct EdgeIndex {
    edges: Vec<[[f64; 2]; 2]>,
    grid: Grid,
    /// The edges of each cell, row by row.
    cells: Lists,
    /// The edges of each row.
    rows: Lists,
}

impl EdgeIndex {
    /// The index of an area.
    /// Takes time and memory linear in the edges, unless most of them are long.
    pub(super) fn new(area: &Area) -> Self {
        let edges: Vec<[[f64; 2]; 2]> = area
            .rings()
            .flat_map(|ring| {
                let next = ring.iter().cycle().skip(1);
                ring.iter().zip(next).map(|(&from, &to)| [from, to])
            })
            .collect();
        let grid = Grid::new(area.bounds().unwrap_or_default(), edges.len());
        let cells = Lists::new(grid.columns * grid.rows, edges.len(), |edge, add| {
            let [from, to] = edges[edge];
            grid.visit(from, to, 0.0, &mut |cell| {
                add(cell);
                true
            });
        });
        let rows = Lists::new(grid.rows, edges.len(), |edge, add| {
            let [from, to] = edges[edge];
            let (low, high) = (from[1].min(to[1]), from[1].max(to[1]));
            (grid.index(1, low - grid.margin_mm)..=grid.index(1, high + grid.margin_mm))
                .for_each(add);
        });
        Self { edges, grid, cells, rows }
    }

    /// Whether a point lies inside the area; either result is possible for a point on an edge.
    pub(super) fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let [min, max] = self.grid.bounds_mm;
        if !(min[1] <= y && y <= max[1]) {
            return false;
        }
        let crossings = self.rows.list(self.grid.index(1, y)).filter(|&edge| {
            let [from, to] = self.edges[edge];
            (from[1] > y) != (to[1] > y)
                && x < from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0])
        });
        crossings.count() % 2 == 1
    }

    /// Whether a line neither touches an edge nor comes closer to one than a distance in mm.
    pub(super) fn is_clear(&self, from: [f64; 2], to: [f64; 2], distance_mm: f64) -> bool {
        let limit2 = distance_mm * distance_mm;
        self.grid.visit(from, to, distance_mm, &mut |cell| {
            self.cells.list(cell).all(|edge| {
                let distance2 = distance2([from, to], self.edges[edge]);
                distance2 > 0.0 && distance2 >= limit2
            })
        })
    }
}

/// Lists of edges in one array.
#[derive(Debug)]
struct Lists {
    /// For each list the index of its first entry, and at the end the number of entries.
    starts: Vec<usize>,
    entries: Vec<u32>,
}

impl Lists {
    /// `visit` calls its last argument with the lists that an edge belongs to, the same ones each
    /// time.
    fn new(lists: usize, edges: usize, visit: impl Fn(usize, &mut dyn FnMut(usize))) -> Self {
        let mut starts = vec![0; lists + 1];
        for edge in 0..edges {
            visit(edge, &mut |list| starts[list + 1] += 1);
        }
        for list in 0..lists {
            starts[list + 1] += starts[list];
        }
        let mut entries = vec![0; starts[lists]];
        let mut next = starts.clone();
        for edge in 0..edges {
            visit(edge, &mut |list| {
                entries[next[list]] = edge as u32;
                next[list] += 1;
            });
        }
        Self { starts, entries }
    }

    fn list(&self, list: usize) -> impl Iterator<Item = usize> {
        self.entries[self.starts[list]..self.starts[list + 1]].iter().map(|&edge| edge as usize)
    }
}

/// Square cells over a rectangle.
#[derive(Debug)]
struct Grid {
    bounds_mm: [[f64; 2]; 2],
    cell_mm: f64,
    columns: usize,
    rows: usize,
    /// Added to all distances, because positions relative to the cells are rounded.
    margin_mm: f64,
}

impl Grid {
    fn new(bounds_mm: [[f64; 2]; 2], edges: usize) -> Self {
        let [width, height] = [0, 1].map(|axis| bounds_mm[1][axis] - bounds_mm[0][axis]);
        let count = edges.max(1) as f64;
        // At most as many cells along each side as there are edges: a thin area has few rows.
        let cell_mm = (width * height / count).sqrt().max(width.max(height) / count).max(1e-3);
        let cells = |length_mm: f64| (length_mm / cell_mm) as usize + 1;
        let (columns, rows) = (cells(width), cells(height));
        Self { bounds_mm, cell_mm, columns, rows, margin_mm: 1e-6 * cell_mm + 1e-6 }
    }

    /// Column (axis 0) or row (axis 1) of a coordinate, or the nearest one.
    fn index(&self, axis: usize, mm: f64) -> usize {
        let count = [self.columns, self.rows][axis];
        (((mm - self.bounds_mm[0][axis]) / self.cell_mm) as usize).min(count - 1)
    }

    /// Visits the cells within a distance of a line, and possibly a few more, until `visit` returns
    /// false; returns whether it never did.
    fn visit(
        &self,
        from: [f64; 2],
        to: [f64; 2],
        distance_mm: f64,
        visit: &mut dyn FnMut(usize) -> bool,
    ) -> bool {
        let reach_mm = distance_mm + self.margin_mm;
        let [min, max] = self.bounds_mm;
        let is_far = (0..2).any(|axis| {
            from[axis].min(to[axis]) - reach_mm > max[axis]
                || from[axis].max(to[axis]) + reach_mm < min[axis]
        });
        if is_far {
            return true;
        }
        let (low, high) = (from[1].min(to[1]), from[1].max(to[1]));
        (self.index(1, low - reach_mm)..=self.index(1, high + reach_mm)).all(|row| {
            let front = min[1] + row as f64 * self.cell_mm;
            // The part of the line that is near the row.
            let [a, b] = if high - low <= self.cell_mm {
                [from[0], to[0]]
            } else {
                let slope = (to[0] - from[0]) / (to[1] - from[1]);
                let near = [front - reach_mm, front + self.cell_mm + reach_mm];
                near.map(|y| from[0] + (y.clamp(low, high) - from[1]) * slope)
            };
            let columns = self.index(0, a.min(b) - reach_mm)..=self.index(0, a.max(b) + reach_mm);
            columns.into_iter().all(|column| visit(row * self.columns + column))
        })
    }
}

/// Square of the distance of two line segments; 0 if they touch or cross.
fn distance2(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> f64 {
    let side = |line: [[f64; 2]; 2], point: [f64; 2]| {
        let [along, offset] = [sub(line[1], line[0]), sub(point, line[0])];
        along[0] * offset[1] - along[1] * offset[0]
    };
    let is_apart = |line, [p, q]: [[f64; 2]; 2]| side(line, p) * side(line, q) > 0.0;
    let ends = [
        point_distance2(a[0], b),
        point_distance2(a[1], b),
        point_distance2(b[0], a),
        point_distance2(b[1], a),
    ];
    let nearest = ends.into_iter().fold(f64::INFINITY, f64::min);
    // Parallel lines have all signs equal to 0 if they are on one line: then the ends decide.
    let is_crossing = !is_apart(a, b)
        && !is_apart(b, a)
        && (side(a, b[0]).abs() > 0.0 || side(a, b[1]).abs() > 0.0);
    if is_crossing { 0.0 } else { nearest }
}

/// Square of the distance of a point from a line segment.
fn point_distance2(point: [f64; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
    let (along, offset) = (sub(to, from), sub(point, from));
    let length2 = dot(along, along);
    let share = if length2 > 0.0 { (dot(along, offset) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let rest = sub(offset, along.map(|value| share * value));
    dot(rest, rest)
}

fn sub(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::slice::FillRule;

    #[test]
    fn distances_of_segments() {
        let a = [[0.0, 0.0], [2.0, 0.0]];
        for (b, expected) in [
            ([[1.0, -1.0], [1.0, 1.0]], 0.0),
            ([[1.0, 0.0], [1.0, 1.0]], 0.0),
            ([[2.0, 0.0], [3.0, 0.0]], 0.0),
            ([[3.0, 0.0], [4.0, 0.0]], 1.0),
            ([[3.0, 1.0], [4.0, 0.0]], 2.0),
            ([[0.0, 2.0], [2.0, 2.0]], 4.0),
            ([[1.0, 3.0], [1.0, 2.0]], 4.0),
            ([[5.0, 4.0], [5.0, 4.0]], 25.0),
            ([[1.0, 0.0], [1.0, 0.0]], 0.0),
        ] {
            assert_eq!(distance2(a, b), expected, "{b:?}");
            assert_eq!(distance2(b, a), expected, "{b:?}");
        }
    }

    /// Compares the index with a look at all edges.
    #[test]
    fn queries_are_those_of_all_edges() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut counts = [0; 4];
        for _ in 0..600 {
            let size = [rng.random_range(0.1..30.0), rng.random_range(0.1..30.0)];
            let mut ring = |points: usize| -> Vec<[f64; 2]> {
                let is_whole: bool = rng.random();
                (0..points)
                    .map(|_| {
                        size.map(|size| {
                            let at = rng.random_range(0.0..size);
                            if is_whole { f64::floor(at) } else { at }
                        })
                    })
                    .collect()
            };
            let rings = [ring(3), ring(8), ring(40)];
            let count = rng.random_range(1..=3);
            let area = Area::from_rings(&rings[..count], FillRule::EvenOdd);
            let index = EdgeIndex::new(&area);
            for _ in 0..40 {
                let mut point = || {
                    let at = size.map(|size| rng.random_range(-0.2 * size..1.2 * size));
                    if rng.random_range(0..4) == 0 { at.map(f64::floor) } else { at }
                };
                let (from, to) = (point(), point());
                let length = rng.random_range(0.0..1.0_f64).powi(4);
                let to = [0, 1].map(|axis| from[axis] + length * (to[axis] - from[axis]));
                let distance = rng.random_range(0.0..0.5);
                let nearest = index
                    .edges
                    .iter()
                    .map(|&edge| distance2([from, to], edge))
                    .fold(f64::INFINITY, f64::min);
                let is_clear = nearest > 0.0 && nearest >= distance * distance;
                assert_eq!(index.is_clear(from, to, distance), is_clear, "{from:?} {to:?}");
                let crossings = index.edges.iter().filter(|[a, b]| {
                    (a[1] > from[1]) != (b[1] > from[1])
                        && from[0] < a[0] + (from[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
                });
                let is_inside = crossings.count() % 2 == 1;
                assert_eq!(index.contains(from), is_inside, "{from:?}");
                counts[usize::from(is_clear) * 2 + usize::from(is_inside)] += 1;
            }
        }
        assert!(counts.iter().all(|&count| count > 200), "{counts:?}");
    }

    #[test]
    fn an_empty_area_contains_nothing() {
        let index = EdgeIndex::new(&Area::default());
        assert!(!index.contains([0.0, 0.0]) && index.is_clear([0.0, 0.0], [1.0, 0.0], 1.0));
    }
}
