//! Example parts that need no file: for trying out commands, for tests and for tables.

use std::f64::consts::TAU;

use crate::mesh::Mesh;
use crate::model::{Body, Material, Model};
use crate::solid::Solid;

/// A part that is computed.
/// All parts stand on z = 0.
///
/// The cells named below are those of beads 0.5 mm wide in layers 0.25 mm high.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Example {
    /// A plate of 60 x 20 x 3 mm: 120 x 40 x 12 cells.
    Rectangular,
    /// A plate of 45 x 25 x 3 mm with a notch of 20 x 15 mm in the centre of its front: 39,600
    /// cells.
    UShape,
    /// A pyramid on a square of 30 mm, truncated at a height of 19.25 mm to a square of 2 mm: 77
    /// layers.
    Pyramid,
    /// A plate of 60 x 40 x 2 mm with an inlaid letter, 1 mm deep, of a second material.
    LogoPlate,
    /// A plate of 60 x 45 x 2 mm made of twelve squares, each of its own material.
    Palette,
}

impl Example {
    /// Creates the part.
    pub fn model(self) -> Model {
        match self {
            Self::Rectangular => single(&Solid::Cuboid { size_mm: [60.0, 20.0, 3.0] }),
            Self::UShape => {
                let corners =
                    [[0, 0], [25, 0], [25, 30], [65, 30], [65, 0], [90, 0], [90, 50], [0, 50]];
                let outline_mm =
                    corners.map(|corner| corner.map(|halves| f64::from(halves) / 2.0)).to_vec();
                single(&Solid::Prism { outline_mm, z_mm: [0.0, 3.0] })
            }
            Self::Pyramid => single(&Solid::Frustum { sides_mm: [30.0, 2.0], height_mm: 19.25 }),
            Self::LogoPlate => logo_plate(),
            Self::Palette => palette(),
        }
    }
}

beadwork_base::named_enum! {
    Example, "example":
    Rectangular = "rectangular",
    UShape = "u-shape",
    Pyramid = "pyramid",
    LogoPlate = "logo-plate",
    Palette = "palette",
}

fn body(name: &str, mesh: Mesh, material: usize) -> Body {
    Body { name: name.to_owned(), mesh, material: Some(material), ..Body::default() }
}

fn material(name: &str, colour: [u8; 3]) -> Material {
    Material { name: name.to_owned(), colour: Some(colour) }
}

fn single(solid: &Solid) -> Model {
    Model {
        bodies: vec![body("part", solid.mesh(), 0)],
        materials: vec![material("grey", [170, 174, 178])],
        ..Model::default()
    }
}

/// The letter b: a bar, and a disc with a smaller disc of the plate's material in its centre.
fn logo_plate() -> Model {
    let inlay = [1.0, 2.0];
    let bar = [[20.0, 6.0], [25.0, 6.0], [25.0, 34.0], [20.0, 34.0]].to_vec();
    let disc = |radius: f64| -> Vec<[f64; 2]> {
        let corner = |step: i32| {
            let (y, x) = (TAU * f64::from(step) / 96.0).sin_cos();
            [31.0 + radius * x, 15.0 + radius * y]
        };
        (0..96).map(corner).collect()
    };
    let prism = |outline_mm| Solid::Prism { outline_mm, z_mm: inlay }.mesh();
    Model {
        bodies: vec![
            body("plate", Solid::Cuboid { size_mm: [60.0, 40.0, 2.0] }.mesh(), 0),
            body("disc", prism(disc(9.0)), 1),
            body("eye", prism(disc(4.5)), 0),
            body("bar", prism(bar), 1),
        ],
        materials: vec![material("white", [244, 244, 240]), material("blue", [40, 96, 176])],
        ..Model::default()
    }
}

/// Squares of 15 mm, four per row.
fn palette() -> Model {
    let colours: [(&str, [u8; 3]); 12] = [
        ("white", [245, 245, 242]),
        ("yellow", [244, 208, 63]),
        ("orange", [230, 136, 52]),
        ("red", [203, 67, 53]),
        ("pink", [226, 132, 172]),
        ("violet", [125, 82, 160]),
        ("blue", [52, 100, 182]),
        ("cyan", [84, 176, 204]),
        ("green", [72, 158, 92]),
        ("olive", [142, 142, 72]),
        ("brown", [124, 86, 60]),
        ("black", [54, 54, 58]),
    ];
    let square = |(number, (name, _)): (usize, &(&str, [u8; 3]))| {
        let [x, y] = [number % 4, number / 4].map(|index| 15.0 * index as f64);
        let outline_mm = vec![[x, y], [x + 15.0, y], [x + 15.0, y + 15.0], [x, y + 15.0]];
        body(name, Solid::Prism { outline_mm, z_mm: [0.0, 2.0] }.mesh(), number)
    };
    Model {
        bodies: colours.iter().enumerate().map(square).collect(),
        materials: colours.iter().map(|&(name, colour)| material(name, colour)).collect(),
        ..Model::default()
    }
}
