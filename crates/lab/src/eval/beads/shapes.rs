//! Generated shapes like those of *ORNL toolpath RL*, which states neither sizes nor files.

use std::f64::consts::TAU;

use beadwork_mesh::{Body, Material, Mesh, Model, Role, Solid};

/// Layer height in mm for which the heights of the shapes are multiples.
pub(super) const LAYER_MM: f64 = 0.25;

/// A shape of the paper, standing on z = 0.
///
/// Flat shapes have two layers, so that infill whose direction alternates has both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Disc with a diameter of 40 mm: a convex part, whose infill the nearest neighbour starts in
    /// the middle.
    Disc,
    /// Disc with a diameter of 40 mm from which a wedge of 60 degrees is cut, open to the right.
    Pacman,
    /// Plate of 60 x 40 mm with a round hole with a diameter of 20 mm in its centre.
    OneHole,
    /// Plate of 60 x 60 mm with five round holes with a diameter of 12 mm: one in the centre, four
    /// towards the corners.
    FiveHoles,
    /// 40 square pillars of 5 mm in 5 rows, 4 mm apart: isolated regions, whose infill cannot be
    /// joined.
    Pillars,
    /// Manifold of 183 layers: a flange with two bores, two pipes that rise from it and lean
    /// towards each other, and the collector into which they lead.
    ///
    /// Its outlines have 549 rings in all, so two insets along each give the paper's 1,098 beads.
    Manifold,
}

beadwork_base::named_enum! {
    Shape, "shape":
    Disc = "disc",
    Pacman = "pacman",
    OneHole = "one-hole",
    FiveHoles = "five-holes",
    Pillars = "pillars",
    Manifold = "manifold",
}

impl Shape {
    /// The bodies.
    pub(super) fn model(self) -> Model {
        match self {
            Self::Disc => plate(circle([20.0, 20.0], 20.0), &[]),
            Self::Pacman => {
                let centre = [20.0, 20.0];
                let mut outline_mm = vec![centre];
                outline_mm.extend((0..=150).map(|step| {
                    on_circle(centre, 20.0, TAU * (f64::from(step) / 180.0 + 1.0 / 12.0))
                }));
                plate(outline_mm, &[])
            }
            Self::OneHole => plate(rectangle([0.0, 0.0], [60.0, 40.0]), &[([30.0, 20.0], 10.0)]),
            Self::FiveHoles => Self::plate(5),
            Self::Pillars => {
                let pillar = |number: u32| {
                    let [x, y] = [number % 8, number / 8].map(|index| 9.0 * f64::from(index));
                    prism(rectangle([x, y], [5.0, 5.0]), FLAT_MM)
                };
                model((0..40).map(|number| body(pillar(number), Role::Solid)).collect())
            }
            Self::Manifold => manifold(),
        }
    }

    /// A plate of 60 x 60 mm with up to six round holes with a diameter of 12 mm.
    ///
    /// Two holes lie towards opposite corners, four towards all corners; a third or fifth one is in
    /// the centre; six lie in two rows.
    pub(super) fn plate(holes: usize) -> Model {
        let [low, middle, high] = [15.0, 30.0, 45.0];
        let mut centres = vec![[low, low], [high, high], [high, low], [low, high]];
        match holes {
            6 => centres.extend([[low, middle], [high, middle]]),
            odd if odd % 2 == 1 => centres.insert(odd - 1, [middle, middle]),
            _ => {}
        }
        let holes: Vec<_> = centres.iter().take(holes).map(|&centre| (centre, 6.0)).collect();
        plate(rectangle([0.0, 0.0], [60.0, 60.0]), &holes)
    }
}

const FLAT_LAYERS: usize = 2;

/// z of the bottom and of the top of flat shapes.
const FLAT_MM: [f64; 2] = [0.0, FLAT_LAYERS as f64 * LAYER_MM];

/// Steps of a full circle.
const STEPS: u32 = 96;

/// Layers of the manifold's flange, of its pipes while they are apart, from where their walls
/// merge, and of the collector, whose outlines have 3, 4, 3 and 2 rings.
/// As many layers have 4 rings as have 2, so that the mean is 3.
const MANIFOLD_LAYERS: [usize; 4] = [20, 60, 43, 60];

/// Radii of the pipes: outside and bore.
const PIPE_MM: [f64; 2] = [9.0, 6.0];

/// Distances of the axes of the pipes from the centre: at the flange, where the walls merge, and at
/// the collector.
///
/// The second is a little less than the outer radius, so that the walls touch along more than two
/// insets in the first layer in which they do; in the centre of the layer below it, the distance
/// still exceeds the outer radius.
/// Up to the collector the wall between the bores is thicker than four insets.
const AXES_MM: [f64; 3] = [22.0, 8.9, 7.6];

fn manifold() -> Model {
    let mut bottom_mm = 0.0;
    let [flange, apart, merged, collector] = MANIFOLD_LAYERS.map(|layers| {
        let top_mm = bottom_mm + layers as f64 * LAYER_MM;
        [std::mem::replace(&mut bottom_mm, top_mm), top_mm]
    });
    let [outside, bore] = PIPE_MM;
    let mut solid = vec![prism(rectangle([-38.0, -14.0], [76.0, 28.0]), flange)];
    let mut negative = Vec::new();
    for side in [-1.0, 1.0] {
        let [wide, near, close] = AXES_MM.map(|distance| [side * distance, 0.0]);
        negative.push(prism(circle(wide, bore), flange));
        for (from, to, z_mm) in [(wide, near, apart), (near, close, merged)] {
            solid.push(pipe(from, to, outside, z_mm));
            negative.push(pipe(from, to, bore, z_mm));
        }
    }
    // The collector is as wide as the two pipes.
    let reach = AXES_MM[2] + bore;
    solid.push(prism(circle([0.0, 0.0], reach + outside - bore), collector));
    negative.push(prism(circle([0.0, 0.0], reach), collector));
    let solid = solid.into_iter().map(|mesh| body(mesh, Role::Solid));
    let negative = negative.into_iter().map(|mesh| body(mesh, Role::Negative));
    model(solid.chain(negative).collect())
}

fn pipe(from: [f64; 2], to: [f64; 2], radius: f64, z_mm: [f64; 2]) -> Mesh {
    Solid::Loft { bottom_mm: circle(from, radius), top_mm: circle(to, radius), z_mm }.mesh()
}

/// A flat plate with round holes, given by their centres and radii.
fn plate(outline_mm: Vec<[f64; 2]>, holes: &[([f64; 2], f64)]) -> Model {
    let plate = body(prism(outline_mm, FLAT_MM), Role::Solid);
    let holes = holes
        .iter()
        .map(|&(centre, radius)| body(prism(circle(centre, radius), FLAT_MM), Role::Negative));
    model(std::iter::once(plate).chain(holes).collect())
}

fn prism(outline_mm: Vec<[f64; 2]>, z_mm: [f64; 2]) -> Mesh {
    Solid::Prism { outline_mm, z_mm }.mesh()
}

/// A model of one object and one material.
fn model(bodies: Vec<Body>) -> Model {
    let materials = vec![Material { name: "grey".to_owned(), colour: Some([170, 174, 178]) }];
    Model { bodies, materials, ..Model::default() }
}

fn body(mesh: Mesh, role: Role) -> Body {
    let material = (role == Role::Solid).then_some(0);
    Body { name: "part".to_owned(), mesh, role, material, ..Body::default() }
}

fn rectangle([x, y]: [f64; 2], [width, depth]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[x, y], [x + width, y], [x + width, y + depth], [x, y + depth]]
}

fn circle(centre: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    (0..STEPS)
        .map(|step| on_circle(centre, radius, TAU * f64::from(step) / f64::from(STEPS)))
        .collect()
}

fn on_circle([x, y]: [f64; 2], radius: f64, angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [x + radius * cos, y + radius * sin]
}
