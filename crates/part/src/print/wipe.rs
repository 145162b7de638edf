//! The way back along a bead, on which filament is retracted.

use beadwork_gcode::Number;

use super::toolpath::rounded;

/// The positions from the end of a bead back along it, up to a length in mm or to its start, each
/// with its distance from the end along the bead, in mm.
///
/// `trail` are the positions of the bead from its start to its end.
/// The last position is rounded, so the total length may differ by 0.001 mm.
pub(super) fn wipe_route(trail: &[[Number; 2]], length_mm: f64) -> Vec<([Number; 2], f64)> {
    let mut route = Vec::new();
    let mut along_mm = 0.0;
    for pair in trail.windows(2).rev() {
        let rest_mm = length_mm - along_mm;
        if rest_mm <= 0.0 {
            break;
        }
        let [to, from] = [pair[0], pair[1]];
        let whole_mm = distance_mm(from, to);
        let to = if whole_mm <= rest_mm { to } else { between(from, to, rest_mm / whole_mm) };
        let step_mm = distance_mm(from, to);
        if step_mm > 0.0 {
            along_mm += step_mm;
            route.push((to, along_mm));
        }
        if whole_mm >= rest_mm {
            break;
        }
    }
    route
}

/// The position at a share of the way between two others.
fn between(from: [Number; 2], to: [Number; 2], share: f64) -> [Number; 2] {
    let at = |axis: usize| {
        let (from, to) = (from[axis].to_f64(), to[axis].to_f64());
        from + (to - from) * share
    };
    rounded([at(0), at(1)])
}

fn distance_mm(a: [Number; 2], b: [Number; 2]) -> f64 {
    let [x, y] = [0, 1].map(|axis| b[axis].to_f64() - a[axis].to_f64());
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn routes_lead_back_along_the_bead() {
        let trail = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0]].map(rounded);
        let route = |length_mm| {
            let steps = wipe_route(&trail, length_mm).into_iter();
            steps.map(|(at, along_mm)| (at.map(Number::to_f64), along_mm)).collect::<Vec<_>>()
        };
        assert_eq!(route(0.0), []);
        assert_eq!(route(0.0001), [], "rounded to nothing");
        assert_eq!(route(0.5), [([3.0, 0.5], 0.5)]);
        assert_eq!(route(1.0), [([3.0, 0.0], 1.0)]);
        assert_eq!(route(2.0), [([3.0, 0.0], 1.0), ([2.0, 0.0], 2.0)]);
        assert_eq!(route(9.0), [([3.0, 0.0], 1.0), ([0.0, 0.0], 4.0)], "the whole bead");
        assert_eq!(wipe_route(&trail[..1], 1.0), []);
    }
}
