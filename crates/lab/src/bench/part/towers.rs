//! Time to cut a layer against the height of the mesh.

use std::fmt;

use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_mesh::{Mesh, Solid};
use beadwork_part::slice::cut;
use serde::Serialize;

use crate::bench::timing::median_seconds;

/// A tower of equal spheres, whose layers do not depend on its height.
#[derive(Serialize)]
pub(super) struct TowerRow {
    height_mm: u32,
    triangles: usize,
    layers: usize,
    #[serde(rename = "micros_a_layer")]
    us_per_layer: f64,
}

/// Measures towers of 1 to 64 spheres of 4 mm, on one thread.
pub(super) fn measure(repeats: u64) -> anyhow::Result<Vec<TowerRow>> {
    [1, 4, 16, 64].into_iter().map(|spheres| row(spheres, repeats)).collect()
}

fn row(spheres: u32, repeats: u64) -> anyhow::Result<TowerRow> {
    let control = control::cancellable(Threads::One)?;
    let mesh = tower(spheres)?;
    let layers = spheres as usize * 40;
    let seconds = median_seconds(repeats, |_| {
        cut(&mesh, &[], 0.1, layers, &control)?;
        Ok(())
    })?;
    Ok(TowerRow {
        height_mm: 4 * spheres,
        triangles: mesh.triangles().len(),
        layers,
        us_per_layer: 1e6 * seconds / layers as f64,
    })
}

/// Spheres of 4 mm, one on top of the other.
fn tower(spheres: u32) -> anyhow::Result<Mesh> {
    let sphere = Solid::Sphere { radius_mm: 2.0, steps: 60 }.mesh();
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for number in 0..spheres {
        let first = vertices.len() as u32;
        let rise = 2.0 + 4.0 * f64::from(number);
        vertices.extend(sphere.vertices().iter().map(|&[x, y, z]| [x, y, z + rise]));
        let moved = sphere.triangles().iter().map(|corners| corners.map(|vertex| vertex + first));
        triangles.extend(moved);
    }
    Ok(Mesh::new(vertices, triangles)?)
}

/// A row of the table of towers.
impl fmt::Display for TowerRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { height_mm, triangles, layers, us_per_layer } = self;
        write!(f, "| {height_mm} | {triangles} | {layers} | {us_per_layer:.1} |")
    }
}
