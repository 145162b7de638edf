//! The parts of a mesh that are bodies of their own.

use std::collections::HashMap;
use std::ops::Range;

use super::mesh::Surface;
use super::project::{ObjectSettings, PartRole, PartSettings};

/// Triangles that are one body, and what the project states about them.
pub(super) type Part = (Range<usize>, PartSettings);

/// The parts of a mesh, and whether the project states them.
///
/// `id` is the id of the object that is the mesh, and `path` are those of the objects that contain
/// it, the outermost first.
/// The error describes a range of triangles that does not exist.
pub(super) fn parts(
    settings: Option<&ObjectSettings>,
    surface: &Surface,
    id: u32,
    path: &[u32],
) -> Result<(Vec<Part>, bool), String> {
    let all = 0..surface.triangles.len();
    let Some(settings) = settings else { return Ok((vec![(all, PartSettings::default())], false)) };
    // What a part does not state, it has from the object.
    let complete = |part: &PartSettings| {
        let mut part = part.clone();
        if part.role == PartRole::Solid {
            part.filament = part.filament.or(settings.filament);
        }
        part
    };
    let remainder = complete(&PartSettings::default());
    if settings.volumes.is_empty() {
        let mut ids = [id].into_iter().chain(path.iter().rev().copied());
        let stated = ids.find_map(|id| settings.parts.get(&id));
        return Ok((vec![(all, stated.map_or(remainder, complete))], stated.is_some()));
    }
    let facets = surface.facet_count();
    let mut volumes: Vec<_> = settings.volumes.iter().collect();
    volumes.sort_by_key(|volume| volume.ends);
    let mut parts = Vec::new();
    let mut next = 0;
    for volume in volumes {
        let [first, last] = volume.ends.map(|end| end as usize);
        if first < next || last < first || last >= facets {
            return Err(format!(
                "object {id}: project has a part of the triangles {first} to {last}, expected \
                 ranges within 0 to {} that do not overlap",
                facets.saturating_sub(1)
            ));
        }
        if first > next {
            let between = surface.first_triangle(next)..surface.first_triangle(first);
            parts.push((between, remainder.clone()));
        }
        let range = surface.first_triangle(first)..surface.first_triangle(last + 1);
        parts.push((range, complete(&volume.part)));
        next = last + 1;
    }
    if next < facets {
        parts.push((surface.first_triangle(next)..surface.triangles.len(), remainder));
    }
    Ok((parts, true))
}

/// Some triangles of a mesh, with the vertices that they refer to.
pub(super) fn part_of(
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut number_of = HashMap::new();
    let mut kept = Vec::new();
    let mut renumber = |vertex: u32| {
        *number_of.entry(vertex).or_insert_with(|| match vertices.get(vertex as usize) {
            Some(&point) => {
                kept.push(point);
                kept.len() as u32 - 1
            }
            // The mesh is refused, with the number in the file.
            None => vertex.max(vertices.len() as u32),
        })
    };
    let triangles = triangles.iter().map(|corners| corners.map(&mut renumber)).collect::<Vec<_>>();
    (kept, triangles)
}
