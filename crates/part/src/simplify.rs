//! Simplifies closed lines: the method of Douglas and Peucker (1973).

use crate::area::Ring;

/// Width in mm of spikes.
const SPIKE_MM: f64 = 1e-4;

/// A ring with some of the corners of another one, to whose lines all corners left out are at most
/// as far as a tolerance, in mm.
///
/// `None` if fewer than three corners remain.
/// O(n log n) for rings without many nearly equal corners, O(n²) at worst.
pub(crate) fn simplified(ring: &[[f64; 2]], tolerance_mm: f64) -> Option<Ring> {
    if ring.len() < 3 {
        return None;
    }
    // The corner farthest from the first one is kept, too, so that two open lines remain.
    let first = ring[0];
    let farthest = (1..ring.len())
        .max_by(|&a, &b| squared(first, ring[a]).total_cmp(&squared(first, ring[b])))?;
    let mut is_kept = vec![false; ring.len()];
    (is_kept[0], is_kept[farthest]) = (true, true);
    let mut intervals = vec![(0, farthest), (farthest, ring.len())];
    while let Some((from, to)) = intervals.pop() {
        let (start, end) = (ring[from], ring[to % ring.len()]);
        let distance = |at: &usize| squared_to_line(ring[*at], start, end);
        let Some((at, distance)) =
            (from + 1..to).map(|at| (at, distance(&at))).max_by(|a, b| a.1.total_cmp(&b.1))
        else {
            continue;
        };
        if distance > tolerance_mm * tolerance_mm {
            is_kept[at] = true;
            intervals.extend([(from, at), (at, to)]);
        }
    }
    let kept: Ring = ring.iter().zip(is_kept).filter(|(_, kept)| *kept).map(|(p, _)| *p).collect();
    (kept.len() >= 3).then_some(kept)
}

/// A ring without corners where it turns back on itself; `None` if fewer than three corners remain.
///
/// Linear in the corners, unless spikes consist of many of them.
pub(crate) fn without_spikes(ring: &[[f64; 2]]) -> Option<Ring> {
    let mut kept: Ring = Ring::with_capacity(ring.len());
    for &point in ring {
        kept.push(point);
        while let [.., before, corner, after] = kept[..]
            && is_spike(before, corner, after)
        {
            kept.truncate(kept.len() - 2);
            kept.push(after);
        }
    }
    // Spikes where the ring is closed.
    let mut first = 0;
    while let [start, second, .., before_last, last] = kept[first..] {
        if is_spike(before_last, last, start) {
            kept.pop();
        } else if is_spike(last, start, second) {
            first += 1;
        } else {
            break;
        }
    }
    kept.drain(..first);
    (kept.len() >= 3).then_some(kept)
}

/// Whether a corner is the tip of a spike.
fn is_spike(before: [f64; 2], corner: [f64; 2], after: [f64; 2]) -> bool {
    let [from, to] = [before, after].map(|end| [end[0] - corner[0], end[1] - corner[1]]);
    let turns_back = from[0] * to[0] + from[1] * to[1] > 0.0;
    let nearer = squared_to_line(after, before, corner).min(squared_to_line(before, corner, after));
    turns_back && nearer < SPIKE_MM * SPIKE_MM
}

fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [a[0] - b[0], a[1] - b[1]];
    x * x + y * y
}

/// Squared distance from a point to the nearest point of a line between two points.
pub(crate) fn squared_to_line(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let length = dx * dx + dy * dy;
    let along = (point[0] - from[0]) * dx + (point[1] - from[1]) * dy;
    let part = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
    squared(point, [from[0] + part * dx, from[1] + part * dy])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn circles_of_many_points_keep_few() {
        let point = |i: u32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 10_000.0;
            [10.0 * angle.cos(), 10.0 * angle.sin()]
        };
        let ring: Ring = (0..10_000).map(point).collect();
        let few = simplified(&ring, 0.005).unwrap();
        assert!((70..150).contains(&few.len()), "{}", few.len());
        assert_eq!(simplified(&[[0.0; 2], [1.0, 0.0], [0.5, 0.001]], 0.005), None);
        assert_eq!(simplified(&[[0.0; 2]; 5], 0.005), None);
        assert_eq!(simplified(&[], 0.005), None);
    }

    #[test]
    fn spikes_are_removed_wherever_rings_begin() {
        let square = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let mut spiked = square.clone();
        spiked.splice(1..1, [[1.0, 0.0], [1.0, -3.0], [1.0, -5.0], [1.0, 1e-6]]);
        for _ in 0..spiked.len() {
            spiked.rotate_left(1);
            let cleared = without_spikes(&spiked).unwrap();
            assert!(square.iter().all(|corner| cleared.contains(corner)), "{cleared:?}");
            assert!(cleared.iter().all(|corner| corner[1] >= 0.0), "{cleared:?}");
        }
        assert_eq!(without_spikes(&square), Some(square));
        assert_eq!(without_spikes(&[]), None);
    }

    proptest! {
        /// Every corner left out is near a line that remains.
        #[test]
        fn no_corner_moves_by_more_than_the_tolerance(
            ring in prop::collection::vec([0.0..2.0_f64, 0.0..2.0_f64], 3..40),
            tolerance_mm in 0.01..0.5_f64,
        ) {
            if let Some(few) = simplified(&ring, tolerance_mm) {
                for &point in &ring {
                    let lines = (0..few.len()).map(|at| (few[at], few[(at + 1) % few.len()]));
                    let distance = lines
                        .map(|(from, to)| squared_to_line(point, from, to).sqrt())
                        .fold(f64::INFINITY, f64::min);
                    prop_assert!(distance <= tolerance_mm + 1e-9, "{distance}");
                }
            }
        }
    }
}
