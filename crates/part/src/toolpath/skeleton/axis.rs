//! The medial axis of a component, as a graph.

use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, InsertionError, Point2, Triangulation};

use super::boundary::Boundary;
use super::vector::{Vector, add_scaled, cross, distance, dot, lerp, sub};

/// Shrinking a ball onto the boundary takes 3 steps as a rule; it is accurate enough after these.
const MAX_SHRINKS: usize = 16;
/// Accuracy of the radius of balls, in mm.
const ACCURACY_MM: f64 = 1e-6;

type Triangulated = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// A graph whose nodes are centres of the largest discs that fit into the component around them.
#[derive(Default)]
pub(super) struct Axis {
    /// Position of each node, in mm.
    pub(super) points: Vec<Vector>,
    /// Distance of each node to the boundary, in mm.
    /// Beyond the limit of the search it is a rough upper bound.
    pub(super) radii: Vec<f64>,
    /// Pairs of adjacent nodes.
    pub(super) links: Vec<[u32; 2]>,
}

impl Axis {
    /// The dual graph of a constrained Delaunay triangulation of the boundary's points.
    ///
    /// Each edge within the component is a node, and so is each triangle that has three of them or
    /// one.
    /// The graph thus has the topology of the component: a cycle for each hole, otherwise none.
    /// Nodes are then moved onto the medial axis of the segments, up to a distance of `limit_mm` of
    /// the boundary.
    pub(super) fn new(boundary: &Boundary, limit_mm: f64) -> Self {
        let Ok(triangulation) = triangulate(boundary) else { return Self::default() };
        let position = |vertex: FixedVertexHandle| -> Vector {
            let point = triangulation.vertex(vertex).position();
            [point.x, point.y]
        };
        let mut is_inside = vec![false; triangulation.num_all_faces()];
        for face in triangulation.inner_faces() {
            let [a, b, c] = face.vertices().map(|vertex| position(vertex.fix()));
            is_inside[face.fix().index()] = boundary.is_inside(centroid([a, b, c]));
        }

        let mut axis = Self::default();
        let mut node_of_edge = vec![u32::MAX; triangulation.num_undirected_edges()];
        for edge in triangulation.undirected_edges() {
            let [one, other] = [edge.as_directed(), edge.as_directed().rev()]
                .map(|side| is_inside[side.face().fix().index()]);
            if one && other && !edge.is_constraint_edge() {
                let ends = edge.vertices().map(|vertex| position(vertex.fix()));
                let middle = lerp(ends[0], ends[1], 0.5);
                let half = distance(ends[0], ends[1]) / 2.0;
                node_of_edge[edge.fix().index()] =
                    axis.push(onto_axis(boundary, middle, half, &ends, limit_mm));
            }
        }
        for face in triangulation.inner_faces() {
            if !is_inside[face.fix().index()] {
                continue;
            }
            let nodes = face
                .adjacent_edges()
                .map(|edge| (node_of_edge[edge.as_undirected().fix().index()], edge));
            let inner: Vec<_> = nodes.iter().filter(|(node, _)| *node != u32::MAX).collect();
            match inner[..] {
                [(node, edge)] => {
                    // The corner between two segments.
                    let corner = position(edge.next().to().fix());
                    let tip = axis.push((corner, 0.0));
                    axis.links.push([*node, tip]);
                }
                [(one, _), (other, _)] => axis.links.push([*one, *other]),
                [(a, _), (b, _), (c, _)] => {
                    let corners = face.vertices().map(|vertex| position(vertex.fix()));
                    let centre = circumcentre(corners)
                        .filter(|&centre| boundary.is_inside(centre))
                        .unwrap_or_else(|| centroid(corners));
                    let radius = distance(centre, corners[0]);
                    let junction =
                        axis.push(onto_axis(boundary, centre, radius, &corners, limit_mm));
                    axis.links.extend([a, b, c].map(|node| [*node, junction]));
                }
                _ => {}
            }
        }
        axis
    }

    fn push(&mut self, (point, radius): (Vector, f64)) -> u32 {
        self.points.push(point);
        self.radii.push(radius);
        self.points.len() as u32 - 1
    }
}

/// Moves a point away from the nearest point of the boundary until another one is as near.
///
/// Returns the point and its distance to the boundary.
/// `radius` is the assumed distance of points that are farther than `limit_mm` from the boundary,
/// and `others` are points of the boundary nearby.
fn onto_axis(
    boundary: &Boundary,
    point: Vector,
    radius: f64,
    others: &[Vector],
    limit_mm: f64,
) -> (Vector, f64) {
    let Some((depth, foot)) = boundary.nearest(point, limit_mm) else {
        return (point, radius.max(limit_mm));
    };
    if depth <= ACCURACY_MM {
        return (point, depth);
    }
    let normal = sub(point, foot).map(|x| x / depth);
    // Radius of the disc that touches the boundary at the foot and at another point.
    let touching = |other: Vector| {
        let chord = sub(other, foot);
        let height = dot(chord, normal);
        if height > 1e-9 { dot(chord, chord) / (2.0 * height) } else { f64::INFINITY }
    };
    let mut radius = others.iter().map(|&other| touching(other)).fold(limit_mm, f64::min);
    for _ in 0..MAX_SHRINKS {
        if radius <= depth {
            break;
        }
        let centre = add_scaled(foot, normal, radius);
        match boundary.nearest(centre, radius - ACCURACY_MM) {
            None => return (centre, radius),
            Some((_, other)) => radius = touching(other).min(radius - ACCURACY_MM),
        }
    }
    (point, depth)
}

/// Fails only if a coordinate is not finite, tiny or huge; those of a boundary are in range.
fn triangulate(boundary: &Boundary) -> Result<Triangulated, InsertionError> {
    let points = &boundary.points;
    let mut triangulation = Triangulated::new();
    let mut vertices = vec![None; points.len()];
    // In an order that halves the gaps: each new point lies between known ones, and changes few
    // triangles.
    let mut stride = points.len().next_power_of_two();
    let mut first = 0;
    while stride > 0 {
        for i in (first..points.len()).step_by(if first == 0 { stride } else { 2 * stride }) {
            let point = Point2::new(points[i][0], points[i][1]);
            let hint = i.checked_sub(stride).and_then(|before| vertices[before]);
            vertices[i] = Some(match hint {
                Some(hint) => triangulation.insert_with_hint(point, hint)?,
                None => triangulation.insert(point)?,
            });
        }
        stride /= 2;
        first = stride;
    }
    for &[from, to] in &boundary.segments {
        if let (Some(from), Some(to)) = (vertices[from], vertices[to])
            && from != to
        {
            // Segments may cross by the rounding of coordinates; these are left out.
            triangulation.try_add_constraint(from, to);
        }
    }
    Ok(triangulation)
}

fn centroid([a, b, c]: [Vector; 3]) -> Vector {
    [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0)
}

fn circumcentre([a, b, c]: [Vector; 3]) -> Option<Vector> {
    let [b, c] = [sub(b, a), sub(c, a)];
    let divisor = 2.0 * cross(b, c);
    let [b2, c2] = [dot(b, b), dot(c, c)];
    let offset = [(c[1] * b2 - b[1] * c2) / divisor, (b[0] * c2 - c[0] * b2) / divisor];
    let centre = [a[0] + offset[0], a[1] + offset[1]];
    centre.iter().all(|x| x.is_finite()).then_some(centre)
}
