//! Merges vertices, and drops triangles without an area.

use beadwork_base::Interrupted;

use crate::mesh::Mesh;
use crate::model::Body;
use crate::work::Work;

/// Merges vertices with equal coordinates into the first of them; returns how many disappear.
/// 0 and -0 are equal.
pub(super) fn merge_vertices(mesh: &mut Mesh, work: &mut Work<'_>) -> Result<usize, Interrupted> {
    let (vertices, triangles) = mesh.parts_mut();
    let order = grouped(vertices, work)?;
    // For each vertex the first one with its coordinates.
    let mut number_of: Vec<u32> = (0..vertices.len() as u32).collect();
    let mut merged = 0;
    for equal in order.chunk_by(|&a, &b| key(vertices[a as usize]) == key(vertices[b as usize])) {
        merged += equal.len() - 1;
        equal[1..].iter().for_each(|&vertex| number_of[vertex as usize] = equal[0]);
    }
    drop(order);
    if merged == 0 {
        return Ok(0);
    }
    // Close the gaps.
    let mut kept = 0;
    for vertex in 0..vertices.len() {
        if number_of[vertex] == vertex as u32 {
            vertices[kept] = vertices[vertex];
            number_of[vertex] = kept as u32;
            kept += 1;
        } else {
            // The first vertex comes before this one, so its entry is its new number already.
            number_of[vertex] = number_of[number_of[vertex] as usize];
        }
    }
    vertices.truncate(kept);
    vertices.shrink_to_fit();
    triangles.iter_mut().flatten().for_each(|vertex| *vertex = number_of[*vertex as usize]);
    Ok(merged)
}

/// The coordinates as integers; adding 0 turns -0 into 0.
fn key(point: [f64; 3]) -> [u64; 3] {
    point.map(|value| (value + 0.0).to_bits())
}

/// The numbers of all vertices, in an order in which equal vertices are adjacent and their numbers
/// rise.
///
/// Vertices are distributed over buckets by a hash of their coordinates, and each bucket is sorted.
/// That takes as long as sorting all vertices at once, but can be interrupted between buckets.
fn grouped(vertices: &[[f64; 3]], work: &mut Work<'_>) -> Result<Vec<u32>, Interrupted> {
    const BUCKET: usize = 1 << 10;
    let buckets = (vertices.len() / BUCKET).next_power_of_two();
    // The high bits of the product depend on all bits of the coordinates.
    let bucket_of = |point: [f64; 3]| {
        let mix =
            |hash: u64, word: u64| (hash.rotate_left(5) ^ word).wrapping_mul(0x517c_c1b7_2722_0a95);
        (key(point).into_iter().fold(0, mix) >> 32) as usize & (buckets - 1)
    };
    // Counting sort: where each bucket starts, and then, while it is filled, where it ends.
    let mut ends = vec![0_u32; buckets + 1];
    for &point in vertices {
        work.poll(1)?;
        ends[bucket_of(point) + 1] += 1;
    }
    for bucket in 1..ends.len() {
        ends[bucket] += ends[bucket - 1];
    }
    let mut order = vec![0; vertices.len()];
    for (vertex, &point) in vertices.iter().enumerate() {
        work.poll(1)?;
        let end = &mut ends[bucket_of(point)];
        order[*end as usize] = vertex as u32;
        *end += 1;
    }
    work.set_items(buckets);
    let mut start = 0;
    for (bucket, &end) in ends[..buckets].iter().enumerate() {
        work.tick(bucket)?;
        work.poll((end - start) as usize)?;
        order[start as usize..end as usize]
            .sort_unstable_by_key(|&vertex| (key(vertices[vertex as usize]), vertex));
        start = end;
    }
    Ok(order)
}

/// Drops triangles with two equal vertices; returns how many.
pub(super) fn drop_degenerate_triangles(body: &mut Body) -> usize {
    let (_, triangles) = body.mesh.parts_mut();
    let keep: Vec<bool> = triangles.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
    let dropped = keep.iter().filter(|&&keep| !keep).count();
    let mut kept = keep.iter();
    triangles.retain(|_| *kept.next().expect("one entry per triangle"));
    if !body.paint.is_empty() {
        let mut kept = keep.iter();
        body.paint.retain(|_| *kept.next().expect("one entry per triangle"));
    }
    dropped
}
