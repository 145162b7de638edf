//! Finds a vertex that is far away from the rest of a model, which is why it does not fit.

use thiserror::Error;

use crate::model::Body;

/// A vertex that is far away from the rest of its model.
#[derive(Clone, Debug, Error, PartialEq)]
#[error(
    "a vertex of body '{body}' at ({}, {}, {}) is far away from the others",
    length(.at_mm[0]), length(.at_mm[1]), length(.at_mm[2])
)]
pub struct StrayVertex {
    /// Name of its body.
    pub body: String,
    /// Its position as the reader returned it, in mm.
    pub at_mm: [f64; 3],
}

/// A vertex is stray if it is this many times farther from the centre than half of the vertices.
const STRAY: f64 = 10.0;

impl StrayVertex {
    /// The vertex of some bodies that is farthest away, if it is stray.
    ///
    /// The centre is the median of the vertices, so it does not move with a few stray ones.
    /// Linear in the vertices.
    pub(crate) fn find<'a>(bodies: &(impl Iterator<Item = &'a Body> + Clone)) -> Option<Self> {
        let vertices = || bodies.clone().flat_map(|body| body.mesh.vertices().iter().copied());
        let along = |axis: usize| median(vertices().map(|vertex| vertex[axis]).collect());
        let centre = [along(0)?, along(1)?, along(2)?];
        let distance = |vertex: [f64; 3]| {
            let apart = [0, 1, 2].map(|axis| (vertex[axis] - centre[axis]).abs());
            apart.into_iter().fold(0.0, f64::max)
        };
        let usual = median(vertices().map(distance).collect())?;
        let of_body = |body: &'a Body| body.mesh.vertices().iter().map(move |&at| (at, body));
        let all = bodies.clone().flat_map(of_body);
        let (at_mm, body) = all.max_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))?;
        (distance(at_mm) > STRAY * usual).then(|| Self { body: body.name.clone(), at_mm })
    }
}

/// The median; `None` without values.
fn median(mut values: Vec<f64>) -> Option<f64> {
    let half = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(half, f64::total_cmp).1)
}

/// A length with one decimal, or in scientific notation if it is beyond all reason.
pub(crate) fn length(mm: f64) -> String {
    if mm.abs() < 1e7 { format!("{mm:.1}") } else { format!("{mm:.1e}") }
}
