//! Distances between the sides of the cells of a layer and the outlines of the part.
//!
//! Coordinates are in cells from the left back corner of the grid, so distances are in beads.

use std::collections::HashMap;
use std::f64::consts::SQRT_2;

use beadwork_grid::Region;
use beadwork_part::Frame;
use beadwork_part::slice::Layer;

/// Half a bead, plus rounding errors: the sides of cells lie at most this far from the outlines,
/// since a cell is filled where its centre is inside.
pub(super) const HALF: f64 = 0.5 + 1e-9;

/// Points per cell at which distances from the outlines are measured.
const POINTS_PER_CELL: f64 = 5.0;

/// Limit of the search for the side nearest to a point, in cells.
const MAX_RING: i64 = 16;

/// The distances of one layer, in beads.
pub(super) struct Distances {
    /// Distance from the centre of each side between a filled and an empty cell to the outlines,
    /// along the normal of the side.
    pub(super) of_cells: Vec<f64>,
    /// Distance from points along the outlines to the nearest such side, as the larger of the
    /// distances along x and y; infinite beyond [`MAX_RING`].
    pub(super) of_outline: Vec<f64>,
    /// For each of those points at a distance above [`HALF`], whether the part, or the gap next to
    /// it, is thinner there than the diagonal of a cell.
    pub(super) thin: Vec<bool>,
}

/// Point, or corner of an outline.
type Point = [f64; 2];

/// A side of a cell: x and y of its left or back end, and whether it runs along y ("vertical").
/// Such a side separates two cells of a row.
type Side = (i64, i64, bool);

impl Distances {
    /// Measures a layer against the outlines of the part, whose corners are in mm.
    pub(super) fn measure(layer: &Layer, outlines_mm: &[&[Point]], frame: &Frame) -> Self {
        let to_cells = |&[x, y]: &Point| {
            [(x - frame.left_mm) / frame.cell_mm, (frame.back_mm - y) / frame.cell_mm]
        };
        let outlines: Vec<Vec<Point>> =
            outlines_mm.iter().map(|corners| corners.iter().map(to_cells).collect()).collect();
        let sides = sides(&layer.region);
        let mut to_outline: HashMap<Side, f64> = HashMap::new();
        let mut of_outline = Vec::new();
        let mut thin = Vec::new();
        for (from, to) in outlines.iter().flat_map(|corners| edges(corners)) {
            for_each_crossing(from, to, |side, distance| {
                let nearest = to_outline.entry(side).or_insert(f64::INFINITY);
                *nearest = nearest.min(distance);
            });
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let points = (POINTS_PER_CELL * length).ceil().max(1.0);
            for number in 0..points as u32 {
                let share = f64::from(number) / points;
                let point = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                let distance = distance_to_sides(&sides, point);
                of_outline.push(distance);
                if distance > HALF && length > 0.0 {
                    let normal = [(to[1] - from[1]) / length, (from[0] - to[0]) / length];
                    thin.push(is_thin(&outlines, point, normal));
                }
            }
        }
        let of_side =
            |(x, y, vertical)| to_outline.get(&(x, y, vertical)).copied().unwrap_or(f64::INFINITY);
        let all_sides = sides
            .iter()
            .flat_map(|(&(x, y), vertical)| vertical.iter().map(move |&vertical| (x, y, vertical)));
        Self { of_cells: all_sides.map(of_side).collect(), of_outline, thin }
    }
}

/// The edges of a closed polygon.
fn edges(corners: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// The sides between filled and empty cells.
/// The keys are the left or back ends of sides; the values state whether the sides that start there
/// are vertical.
fn sides(region: &Region) -> HashMap<(i64, i64), Vec<bool>> {
    let (width, height) = (i64::from(region.width()), i64::from(region.height()));
    let is_filled = |x: i64, y: i64| {
        (0..width).contains(&x)
            && (0..height).contains(&y)
            && region.contains(region.cell(x as u32, y as u32))
    };
    let mut sides: HashMap<(i64, i64), Vec<bool>> = HashMap::new();
    for y in 0..=height {
        for x in 0..=width {
            if is_filled(x, y) != is_filled(x - 1, y) {
                sides.entry((x, y)).or_default().push(true);
            }
            if is_filled(x, y) != is_filled(x, y - 1) {
                sides.entry((x, y)).or_default().push(false);
            }
        }
    }
    sides
}

/// Calls `emit` for each point at which an edge of an outline crosses the centre line of a row or a
/// column, with each of the three nearest sides on that line and its distance along the line.
///
/// The centre line of a row passes through the centres of all vertical sides of that row, at right
/// angles.
/// So the minimum over all edges is the distance of a side from the outlines along its normal.
fn for_each_crossing(from: Point, to: Point, mut emit: impl FnMut(Side, f64)) {
    for axis in 0..2 {
        let (low, high) = if from[axis] <= to[axis] { (from, to) } else { (to, from) };
        let first = (low[axis] - 0.5).floor() as i64;
        let last = (high[axis] - 0.5).ceil() as i64;
        for line in first..=last {
            let centre = line as f64 + 0.5;
            // The ends of the edge are included, so that an edge that lies on a centre line counts,
            // too.
            if centre < low[axis] || centre > high[axis] {
                continue;
            }
            let span = high[axis] - low[axis];
            let share = if span > 0.0 { (centre - low[axis]) / span } else { 0.0 };
            let across = low[1 - axis] + share * (high[1 - axis] - low[1 - axis]);
            let nearest = across.round() as i64;
            for side in [nearest - 1, nearest, nearest + 1] {
                let distance = (across - side as f64).abs();
                // Along the centre line of a row (constant y), sides are vertical.
                let side = if axis == 1 { (side, line, true) } else { (line, side, false) };
                emit(side, distance);
            }
        }
    }
}

/// Whether the part or the gap is thin at a point of an edge: whether the normal through the point,
/// in either direction, meets another edge within the length of a cell's diagonal.
fn is_thin(outlines: &[Vec<Point>], point: Point, normal: Point) -> bool {
    let meets = |(from, to): (Point, Point)| {
        let along = [to[0] - from[0], to[1] - from[1]];
        let away = [from[0] - point[0], from[1] - point[1]];
        // Solves point + on_ray * normal = from + on_edge * along.
        let cross = normal[0] * along[1] - normal[1] * along[0];
        let on_ray = (away[0] * along[1] - away[1] * along[0]) / cross;
        let on_edge = (away[0] * normal[1] - away[1] * normal[0]) / cross;
        cross != 0.0
            && (0.0..=1.0).contains(&on_edge)
            && on_ray.abs() > 1e-6
            && on_ray.abs() < SQRT_2
    };
    outlines.iter().any(|corners| edges(corners).any(meets))
}

/// Distance from a point to the nearest side, as the larger of the distances along x and y;
/// infinite if there is none within [`MAX_RING`] cells.
fn distance_to_sides(sides: &HashMap<(i64, i64), Vec<bool>>, [x, y]: Point) -> f64 {
    let (column, row) = (x.floor() as i64, y.floor() as i64);
    let mut nearest = f64::INFINITY;
    for ring in 1..=MAX_RING {
        for cell_y in row - ring..=row + ring {
            for cell_x in column - ring..=column + ring {
                for &vertical in sides.get(&(cell_x, cell_y)).into_iter().flatten() {
                    let begin = [cell_x as f64, cell_y as f64];
                    let end = if vertical {
                        [begin[0], begin[1] + 1.0]
                    } else {
                        [begin[0] + 1.0, begin[1]]
                    };
                    let offset = [x - x.clamp(begin[0], end[0]), y - y.clamp(begin[1], end[1])];
                    nearest = nearest.min(offset[0].abs().max(offset[1].abs()));
                }
            }
        }
        // Sides outside the ring are at least `ring` cells away.
        if nearest < ring as f64 {
            break;
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use beadwork_grid::Zones;

    use super::*;

    /// A square of 4 x 4 cells whose outline is 0.25 cells larger on each side.
    #[test]
    fn square_is_measured_in_both_directions() {
        let region = Region::rectangle(4, 4).expect("the region has cells");
        let zones = Zones::new(&region, vec![0; 16]).expect("one zone");
        let frame = Frame {
            left_mm: 10.0,
            back_mm: 20.0,
            cell_mm: 0.5,
            layer_mm: 0.2,
            width: 4,
            height: 4,
        };
        let outline = [[9.875, 20.125], [12.125, 20.125], [12.125, 17.875], [9.875, 17.875]];
        let layer = Layer { region, zones };
        let distances = Distances::measure(&layer, &[&outline], &frame);
        assert_eq!(distances.of_cells.len(), 16);
        assert!(distances.of_cells.iter().all(|distance| (distance - 0.25).abs() < 1e-9));
        assert!(distances.of_outline.iter().all(|distance| (distance - 0.25).abs() < 1e-9));
        assert!(distances.thin.is_empty());
    }
}
