//! Regions like those of parts, and the lines of their infill.

#![allow(dead_code, reason = "each test uses some of it")]

use std::f64::consts::{PI, TAU};

use beadwork_search::link::Point;

/// A closed polygonal line.
pub(crate) type Ring = Vec<Point>;

/// A regular polygon.
pub(crate) fn circle([x, y]: Point, radius: f64, corners: usize) -> Ring {
    spokes([x, y], corners, |_| radius)
}

/// A gear: two corners of each tooth lie at the radius, two deeper.
pub(crate) fn gear(centre: Point, radius: f64, teeth: usize, depth: f64) -> Ring {
    spokes(centre, 4 * teeth, |corner| if corner % 4 < 2 { radius } else { radius - depth })
}

/// A star: every second corner lies at a share of the radius.
pub(crate) fn star(centre: Point, radius: f64, spikes: usize, share: f64) -> Ring {
    spokes(centre, 2 * spikes, |corner| if corner % 2 == 0 { radius } else { share * radius })
}

/// A square with sides along the axes.
pub(crate) fn square(min: f64, max: f64) -> Ring {
    vec![[min, min], [max, min], [max, max], [min, max]]
}

fn spokes([x, y]: Point, corners: usize, radius: impl Fn(usize) -> f64) -> Ring {
    (0..corners)
        .map(|corner| {
            let (sine, cosine) = libm::sincos(TAU * corner as f64 / corners as f64);
            [x + radius(corner) * cosine, y + radius(corner) * sine]
        })
        .collect()
}

/// Parallel lines at an angle in radians, clipped at rings by the even-odd rule; pieces shorter
/// than 0.2 spacings are dropped.
pub(crate) fn lines(rings: &[Ring], spacing: f64, angle: f64) -> Vec<Vec<Point>> {
    let (sine, cosine) = libm::sincos(angle);
    let turn = |[x, y]: Point| [cosine * x + sine * y, cosine * y - sine * x];
    let back = |[x, y]: Point| [cosine * x - sine * y, cosine * y + sine * x];
    let turned: Vec<Ring> =
        rings.iter().map(|ring| ring.iter().map(|&corner| turn(corner)).collect()).collect();
    let heights = || turned.iter().flatten().map(|corner| corner[1]);
    let top = heights().fold(f64::NEG_INFINITY, f64::max);
    let mut y = heights().fold(f64::INFINITY, f64::min) + 0.37 * spacing;
    let mut lines = Vec::new();
    while y < top {
        let mut crossings: Vec<f64> = Vec::new();
        for ring in &turned {
            for index in 0..ring.len() {
                let [a, b] = [ring[index], ring[(index + 1) % ring.len()]];
                if (a[1] > y) != (b[1] > y) {
                    crossings.push(a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
                }
            }
        }
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            if pair[1] - pair[0] >= 0.2 * spacing {
                lines.push(vec![back([pair[0], y]), back([pair[1], y])]);
            }
        }
        y += spacing;
    }
    lines
}

/// A gear with a bore and holes, and a spacing at which it has about the given number of lines:
/// 100, 500, 2,000 or 20,000.
pub(crate) fn gear_like(count: usize) -> (Vec<Ring>, f64) {
    let (radius, holes) = match count {
        0..=150 => (12.0, 3),
        151..=1000 => (48.0, 5),
        1001..=5000 => (105.0, 12),
        _ => (560.0, 40),
    };
    let mut rings =
        vec![gear([0.0; 2], radius, 24 + holes, 0.1 * radius), circle([0.0; 2], 0.15 * radius, 60)];
    let around = |share: f64, step: f64| {
        let (sine, cosine) = libm::sincos(TAU * step / holes as f64 + 0.1);
        [share * radius * cosine, share * radius * sine]
    };
    let width = libm::sin(PI / holes as f64) * radius;
    for hole in 0..holes {
        rings.push(circle(around(0.6, hole as f64), 0.25 * width, 40));
        if count > 1000 {
            rings.push(star(around(0.36, hole as f64 + 0.5), 0.3 * width, 7, 0.45));
        }
    }
    (rings, 0.5)
}
