//! Where outlines begin.

use beadwork_part::toolpath::Island;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rstar::RTree;

use super::settings::Seam;
use crate::join::Position;

/// Distance in mm within which a seam follows that of the layer below.
const FOLLOW_MM: f64 = 3.0;

/// For each layer, island and inset, the corner where the loop begins.
/// `None` for insets that may begin anywhere: all of them with [`Seam::Nearest`], and all but the
/// outermost ones otherwise.
///
/// O(n log n) for n corners.
pub(super) fn seams(
    layers: &[Vec<Island>],
    rule: Seam,
    seed: u64,
) -> Vec<Vec<Vec<Option<Position>>>> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut below = RTree::new();
    let mut result = Vec::with_capacity(layers.len());
    for islands in layers {
        let mut points = Vec::new();
        let mut seam = |ring: &[[f64; 2]]| {
            let corner = match rule {
                Seam::Nearest => return None,
                Seam::Rear => rear(ring)?,
                Seam::Random if ring.is_empty() => return None,
                Seam::Random => rng.random_range(0..ring.len()),
                Seam::Aligned => aligned(ring, &below)?,
            };
            points.push(ring[corner]);
            Some(Position { edge: corner, point_mm: ring[corner] })
        };
        let of_island = |island: &Island| -> Vec<Option<Position>> {
            let insets = island.insets.iter();
            insets.map(|inset| if inset.depth == 0 { seam(&inset.ring) } else { None }).collect()
        };
        result.push(islands.iter().map(of_island).collect());
        below = RTree::bulk_load(points);
    }
    result
}

/// The corner of a ring with the maximum y; of several, the one with the maximum x.
fn rear(ring: &[[f64; 2]]) -> Option<usize> {
    let compare = |&a: &usize, &b: &usize| {
        let [a, b] = [ring[a], ring[b]];
        a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]))
    };
    (0..ring.len()).max_by(compare)
}

/// The corner nearest to a seam of the layer below, or the sharpest one if none is near.
fn aligned(ring: &[[f64; 2]], below: &RTree<[f64; 2]>) -> Option<usize> {
    let nearest = (0..ring.len()).filter_map(|corner| {
        let near = below.nearest_neighbor(ring[corner])?;
        let distance2 = (0..2).map(|axis| (near[axis] - ring[corner][axis]).powi(2)).sum::<f64>();
        (distance2 <= FOLLOW_MM * FOLLOW_MM).then_some((corner, distance2))
    });
    let nearest = nearest.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    nearest.map(|(corner, _)| corner).or_else(|| sharpest(ring))
}

/// The corner with the smallest angle, where a seam is hard to see; of equally sharp ones, the
/// rearmost.
fn sharpest(ring: &[[f64; 2]]) -> Option<usize> {
    let count = ring.len();
    let cosine = |corner: usize| {
        let [before, here, after] =
            [(corner + count - 1) % count, corner, (corner + 1) % count].map(|at| ring[at]);
        let [a, b] = [before, after].map(|other| [other[0] - here[0], other[1] - here[1]]);
        let lengths = (a[0] * a[0] + a[1] * a[1]).sqrt() * (b[0] * b[0] + b[1] * b[1]).sqrt();
        if lengths > 0.0 { (a[0] * b[0] + a[1] * b[1]) / lengths } else { -1.0 }
    };
    // Corners of a round outline are equally sharp but for rounding.
    let rank = |corner: usize| (cosine(corner) * 16.0).round();
    let compare = |&a: &usize, &b: &usize| {
        let by_sharpness = rank(a).total_cmp(&rank(b));
        let [p, q] = [ring[a], ring[b]];
        by_sharpness.then(p[1].total_cmp(&q[1])).then(p[0].total_cmp(&q[0]))
    };
    (0..count).max_by(compare)
}
