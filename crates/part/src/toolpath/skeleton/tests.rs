//! Tests of skeletons: coverage of shapes, measured by a raster, and properties of random areas.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::area::Ring;
use crate::slice::FillRule;

type Point = [f64; 2];

fn area(rings: &[Ring]) -> Area {
    Area::from_rings(rings, FillRule::NonZero)
}

/// A strip of a width along a line, with flat ends and round joints.
fn stroke(line: &[Point], width: f64) -> Area {
    let half = width / 2.0;
    let mut rings = Vec::new();
    for pair in line.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let Some(along) = vector::unit(vector::sub(b, a)) else { continue };
        let side = vector::left(along);
        let at = |p: Point, sign: f64| add_scaled(p, side, sign * half);
        rings.push(vec![at(a, -1.0), at(b, -1.0), at(b, 1.0), at(a, 1.0)]);
    }
    for &joint in line.iter().skip(1).rev().skip(1) {
        rings.push(circle(joint, half, 48));
    }
    area(&rings)
}

fn strokes(lines: &[&[Point]], width: f64) -> Area {
    lines.iter().fold(Area::default(), |sum, line| sum.union(&stroke(line, width)))
}

fn circle(centre: Point, radius: f64, count: usize) -> Ring {
    (0..count)
        .map(|i| {
            let (sin, cos) = (i as f64 / count as f64 * std::f64::consts::TAU).sin_cos();
            add_scaled(centre, [cos, sin], radius)
        })
        .collect()
}

fn arc(centre: Point, radius: f64, from_degrees: f64, to_degrees: f64) -> Vec<Point> {
    (0..=60)
        .map(|i| {
            let degrees = from_degrees + (to_degrees - from_degrees) * f64::from(i) / 60.0;
            let (sin, cos) = degrees.to_radians().sin_cos();
            add_scaled(centre, [cos, sin], radius)
        })
        .collect()
}

fn ring_wall(radius: f64, width: f64, count: usize) -> Area {
    let [outer, inner] =
        [1.0, -1.0].map(|sign| area(&[circle([0.0; 2], radius + sign * width / 2.0, count)]));
    outer.difference(&inner)
}

fn star(tips: usize, radius: f64, ratio: f64) -> Area {
    let ring = circle([0.0; 2], 1.0, 2 * tips);
    area(&[ring
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let r = if i % 2 == 0 { radius } else { radius * ratio };
            [p[0] * r, p[1] * r]
        })
        .collect()])
}

fn mapped(area_: &Area, map: impl Fn(Point) -> Point) -> Area {
    let rings: Vec<Ring> =
        area_.rings().map(|ring| ring.iter().map(|&p| map(p)).collect()).collect();
    area(&rings)
}

fn rotated(area: &Area, degrees: f64) -> Area {
    let (sin, cos) = degrees.to_radians().sin_cos();
    mapped(area, |[x, y]| [x * cos - y * sin, x * sin + y * cos])
}

/// Letters of strokes, 5 mm high.
fn letters(width: f64) -> Vec<(&'static str, Area)> {
    let p = |x: f64, y: f64| [x, y];
    let join = |parts: &[Vec<Point>]| parts.concat();
    vec![
        ("A", strokes(&[&[p(0., 0.), p(2., 5.), p(4., 0.)], &[p(0.8, 2.), p(3.2, 2.)]], width)),
        ("B", {
            let upper =
                join(&[vec![p(0., 5.)], arc(p(1.5, 3.75), 1.25, 90., -90.), vec![p(0., 2.5)]]);
            let lower =
                join(&[vec![p(0., 2.5)], arc(p(1.5, 1.25), 1.25, 90., -90.), vec![p(0., 0.)]]);
            strokes(&[&[p(0., 0.), p(0., 5.)], &upper, &lower], width)
        }),
        (
            "E",
            strokes(
                &[&[p(3., 5.), p(0., 5.), p(0., 0.), p(3., 0.)], &[p(0., 2.5), p(2.5, 2.5)]],
                width,
            ),
        ),
        (
            "K",
            strokes(
                &[&[p(0., 0.), p(0., 5.)], &[p(3., 5.), p(0., 2.)], &[p(1.2, 3.2), p(3., 0.)]],
                width,
            ),
        ),
        ("O", strokes(&[&arc(p(2., 2.5), 2., 0., 360.)], width)),
        ("S", {
            let line =
                join(&[arc(p(1.5, 3.75), 1.25, 45., 270.), arc(p(1.5, 1.25), 1.25, 90., -135.)]);
            strokes(&[&line], width)
        }),
        ("W", strokes(&[&[p(0., 5.), p(1.2, 0.), p(2.4, 5.), p(3.6, 0.), p(4.8, 5.)]], width)),
        ("Y", strokes(&[&[p(0., 5.), p(2., 2.5), p(4., 5.)], &[p(2., 2.5), p(2., 0.)]], width)),
        (
            "8",
            strokes(
                &[&arc(p(1.5, 3.75), 1.25, 0., 360.), &arc(p(1.5, 1.25), 1.25, 0., 360.)],
                width,
            ),
        ),
    ]
}

fn shapes(width: f64) -> Vec<(String, Area)> {
    let p = |x: f64, y: f64| [x, y];
    let mut shapes: Vec<(String, Area)> = vec![
        ("wall".into(), stroke(&[p(0., 0.), p(10., 0.)], width)),
        ("wall at 30".into(), rotated(&stroke(&[p(0., 0.), p(10., 0.)], width), 30.0)),
        ("short wall".into(), stroke(&[p(0., 0.), p(2., 0.)], width)),
        ("ring".into(), ring_wall(3.0, width, 200)),
        ("arc".into(), stroke(&arc(p(0., 0.), 3.0, 20., 290.), width)),
        ("T".into(), strokes(&[&[p(0., 0.), p(8., 0.)], &[p(4., 0.), p(4., -5.)]], width)),
        ("cross".into(), strokes(&[&[p(0., 0.), p(8., 0.)], &[p(4., 4.), p(4., -4.)]], width)),
        (
            "L".into(),
            area(&[vec![
                p(0., 0.),
                p(6., 0.),
                p(6., width),
                p(width, width),
                p(width, 6.),
                p(0., 6.),
            ]]),
        ),
        (
            "frame".into(),
            area(&[vec![p(0., 0.), p(6., 0.), p(6., 6.), p(0., 6.)]]).difference(&area(&[vec![
                p(width, width),
                p(6. - width, width),
                p(6. - width, 6. - width),
                p(width, 6. - width),
            ]])),
        ),
        (
            "H".into(),
            strokes(
                &[&[p(0., 0.), p(0., 6.)], &[p(4., 0.), p(4., 6.)], &[p(0., 3.), p(4., 3.)]],
                width,
            ),
        ),
        (
            "round ends".into(),
            stroke(&[p(0., 0.), p(8., 0.)], width).union(&area(&[
                circle(p(0., 0.), width / 2.0, 64),
                circle(p(8., 0.), width / 2.0, 64),
            ])),
        ),
        (
            "slanted ends".into(),
            area(&[vec![p(0., 0.), p(8., 0.), p(8. + width, width), p(width, width)]]),
        ),
    ];
    shapes.extend(letters(width).into_iter().map(|(name, area)| (name.to_owned(), area)));
    shapes
}

/// What a raster of 0.0171 mm finds of the strips of skeletons, as ratios of the area.
#[derive(Debug)]
struct Coverage {
    /// Sum of length times width.
    sum: f64,
    /// Covered part of the area.
    covered: f64,
    /// Covered more than once by different skeletons.
    twice: f64,
    /// Covered outside of the area.
    outside: f64,
}

fn coverage(area: &Area, skeletons: &[Skeleton]) -> Coverage {
    let pitch = 0.0171;
    let [min, max] = area.bounds().unwrap();
    let min = min.map(|x| x - 1.0);
    let size = [0, 1].map(|k| ((max[k] + 1.0 - min[k]) / pitch) as usize);
    let centre =
        |x: usize, y: usize| [min[0] + (x as f64 + 0.5) * pitch, min[1] + (y as f64 + 0.5) * pitch];
    let mut count = vec![0_u8; size[0] * size[1]];
    for skeleton in skeletons {
        let mut own = vec![false; count.len()];
        let mut fill = |low: Point, high: Point, is_in: &dyn Fn(Point) -> bool| {
            let cell = |p: Point| [0, 1].map(|k| ((p[k] - min[k]) / pitch).max(0.0) as usize);
            let [low, high] = [cell(low), cell(high)];
            for y in low[1]..=high[1].min(size[1] - 1) {
                for x in low[0]..=high[0].min(size[0] - 1) {
                    if is_in(centre(x, y)) {
                        own[y * size[0] + x] = true;
                    }
                }
            }
        };
        for (i, [(a, wa), (b, wb)]) in skeleton.lines().enumerate() {
            let reach = wa.max(wb);
            let low = [0, 1].map(|k| a[k].min(b[k]) - reach);
            let high = [0, 1].map(|k| a[k].max(b[k]) + reach);
            let length = distance(a, b);
            fill(low, high, &|p| {
                let along = vector::dot(vector::sub(p, a), vector::sub(b, a)) / length / length;
                let off = vector::cross(vector::sub(p, a), vector::sub(b, a)).abs() / length;
                (0.0..=1.0).contains(&along) && off <= 0.5 * (wa + (wb - wa) * along)
            });
            if i > 0 || skeleton.is_closed {
                fill(a.map(|x| x - wa), a.map(|x| x + wa), &|p| distance(p, a) <= wa / 2.0);
            }
        }
        for (count, own) in count.iter_mut().zip(own) {
            *count += u8::from(own);
        }
    }
    let mut found = Coverage { sum: 0.0, covered: 0.0, twice: 0.0, outside: 0.0 };
    let rings: Vec<_> = area.rings().cloned().collect();
    for y in 0..size[1] {
        // Where the row crosses the rings, the inside lies between pairs.
        let at = centre(0, y)[1];
        let mut crossings: Vec<f64> = rings
            .iter()
            .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)))
            .filter(|(a, b)| (a[1] <= at) != (b[1] <= at))
            .map(|(a, b)| a[0] + (b[0] - a[0]) * (at - a[1]) / (b[1] - a[1]))
            .collect();
        crossings.sort_by(f64::total_cmp);
        for x in 0..size[0] {
            let before = crossings.partition_point(|&crossing| crossing < centre(x, y)[0]);
            let times = count[y * size[0] + x];
            if before % 2 == 1 {
                found.covered += f64::from(u8::from(times > 0));
                found.twice += f64::from(u8::from(times > 1));
            } else {
                found.outside += f64::from(u8::from(times > 0));
            }
        }
    }
    let total = area.size_mm2();
    let scale = pitch * pitch / total;
    found.covered *= scale;
    found.twice *= scale;
    found.outside *= scale;
    found.sum = skeletons.iter().map(Skeleton::area_mm2).sum::<f64>() / total;
    found
}

/// Distance to the outline and whether the point is inside, by all segments.
fn depth(area: &Area, point: Point) -> (f64, bool) {
    let segments = || area.rings().flat_map(|r| r.iter().zip(r.iter().cycle().skip(1)));
    let nearest = segments()
        .map(|(&a, &b)| distance(vector::nearest_on_segment([a, b], point), point))
        .fold(f64::INFINITY, f64::min);
    let crossings = segments()
        .filter(|(a, b)| (a[1] <= point[1]) != (b[1] <= point[1]))
        .filter(|(a, b)| a[0] + (b[0] - a[0]) * (point[1] - a[1]) / (b[1] - a[1]) > point[0])
        .count();
    (nearest, crossings % 2 == 1)
}

fn found(area: &Area) -> Vec<Skeleton> {
    skeletons(area, &SkeletonSettings::default())
}

/// What holds for each area: limits, finite points, middles inside, widths that fit.
fn check(area: &Area, found: &[Skeleton]) {
    for skeleton in found {
        assert!(skeleton.points.len() >= 2);
        assert_eq!(skeleton.points.len(), skeleton.widths_mm.len());
        assert!(skeleton.widths_mm.iter().all(|w| (0.2 - 1e-6..=0.8 + 1e-6).contains(w)));
        assert!(skeleton.length_mm() >= 0.2 - 1e-9);
        let mut excess = 0.0;
        for [(a, wa), (b, wb)] in skeleton.lines() {
            let steps = (distance(a, b) / 0.05).ceil();
            for i in 0..steps as usize {
                let t = (i as f64 + 0.5) / steps;
                let (depth, is_inside) = depth(area, lerp(a, b, t));
                assert!(is_inside || depth < 0.02, "{:?} {depth}", lerp(a, b, t));
                if 0.5 * (wa + (wb - wa) * t) > 1.05 * depth + 0.01 {
                    excess += distance(a, b) / steps;
                }
            }
        }
        // Straight ends, twice, and the ends of what a junction joins.
        let widest = skeleton.widths_mm.iter().copied().fold(0.0, f64::max);
        assert!(excess <= 2.0 * widest + 0.1 * skeleton.length_mm(), "{excess} {skeleton:?}");
    }
}

#[test]
fn strips_cover_walls() {
    for width in [0.25, 0.4, 0.6, 0.75] {
        for (name, area) in shapes(width) {
            // Turned, so that rows of the raster do not run along edges.
            let area = rotated(&area, 17.0);
            let found = found(&area);
            let found_coverage = coverage(&area, &found);
            println!("{width} {name} {} {found_coverage:.3?}", found.len());
            let Coverage { sum, covered, twice, outside } = found_coverage;
            assert!((0.94..1.03).contains(&sum), "{width} {name} {found_coverage:?}");
            assert!(covered > 0.935, "{width} {name} {found_coverage:?}");
            assert!(twice < 0.035 && outside < 0.012, "{width} {name} {found_coverage:?}");
            check(&area, &found);
        }
    }
}

#[test]
fn counts_of_lines() {
    let shapes = shapes(0.5);
    let count = |name: &str| {
        let (_, area) = shapes.iter().find(|shape| shape.0 == name).unwrap();
        let found = found(area);
        (found.len(), found.iter().filter(|skeleton| skeleton.is_closed).count())
    };
    for (name, expected) in [
        ("wall", (1, 0)),
        ("ring", (1, 1)),
        ("frame", (1, 1)),
        ("L", (1, 0)),
        ("T", (2, 0)),
        ("cross", (3, 0)),
        ("H", (3, 0)),
        ("round ends", (1, 0)),
        ("O", (1, 1)),
        ("S", (1, 0)),
        ("E", (2, 0)),
        ("Y", (2, 0)),
        ("A", (2, 0)),
    ] {
        assert_eq!(count(name), expected, "{name}");
    }
}

#[test]
fn a_wall_is_covered_from_end_to_end() {
    for width in [0.21, 0.3, 0.45, 0.79] {
        for length in [1.0, 1.7, 30.0] {
            let wall = stroke(&[[0.0, 0.0], [length, 0.0]], width);
            let found = found(&wall);
            assert_eq!(found.len(), 1, "{width} {length}");
            let gaps = length - found[0].length_mm();
            assert!((0.01..0.04).contains(&gaps), "both ends keep a distance: {gaps}");
            assert!(found[0].points.iter().all(|p| p[1].abs() < 0.005));
            assert!(found[0].widths_mm.iter().all(|w| (w - width).abs() < 0.005));
        }
    }
}

#[test]
fn spots_get_a_bead() {
    for side in [0.3, 0.5, 0.7] {
        let square = stroke(&[[0.0, 0.0], [side, 0.0]], side);
        for area in [&square, &rotated(&square, 45.0), &area(&[circle([0.0; 2], side / 2.0, 40)])] {
            let found = found(area);
            assert_eq!(found.len(), 1, "{side} {:?}", area.size_mm2());
            let ratio = found[0].area_mm2() / area.size_mm2();
            assert!((0.9..1.05).contains(&ratio), "{side} {ratio}");
        }
    }
}

#[test]
fn a_taper_ends_at_the_minimum_width() {
    // From 0 to 0.8 mm over 20 mm.
    let taper = area(&[vec![[0.0, 0.0], [20.0, -0.4], [20.0, 0.4]]]);
    let found = found(&taper);
    assert_eq!(found.len(), 1);
    let line = &found[0];
    let low = line.points.iter().map(|p| p[0]).fold(f64::INFINITY, f64::min);
    let high = line.points.iter().map(|p| p[0]).fold(0.0, f64::max);
    assert!((low - 5.0).abs() < 0.02 && (high - 20.0).abs() < 0.02, "{low} {high}");
    for (point, width) in std::iter::zip(&line.points, &line.widths_mm) {
        assert!((width - point[0] * 0.04).abs() < 0.025, "{point:?} {width}");
    }
    let printable = 0.5 * 15.0;
    assert!((line.area_mm2() / printable - 1.0).abs() < 0.02);
}

#[test]
fn widths_have_limits() {
    assert!(found(&stroke(&[[0.0, 0.0], [9.0, 0.0]], 0.19)).is_empty());
    assert!(found(&ring_wall(3.0, 0.15, 100)).is_empty());
    let wide = found(&stroke(&[[0.0, 0.0], [9.0, 0.0]], 1.5));
    assert_eq!(wide.len(), 1);
    assert!(wide[0].widths_mm.iter().all(|&w| w == 0.8));
    // An hourglass breaks in its waist.
    let waist = area(&[vec![
        [0.0, -0.3],
        [5.0, -0.05],
        [10.0, -0.3],
        [10.0, 0.3],
        [5.0, 0.05],
        [0.0, 0.3],
    ]]);
    assert_eq!(found(&waist).len(), 2);
    let settings = SkeletonSettings { min_width_mm: 0.05, ..SkeletonSettings::default() };
    assert_eq!(skeletons(&waist, &settings).len(), 1);
}

#[test]
fn a_star_has_a_line_into_each_tip() {
    for tips in [3, 5, 6, 8] {
        let star = star(tips, 4.0, 0.2);
        let found = found(&star);
        let ends = found.iter().flat_map(|s| [s.points[0], s.points[s.points.len() - 1]]);
        let far = ends.filter(|&end| distance(end, [0.0; 2]) > 2.0).count();
        assert_eq!(far, tips);
        check(&star, &found);
    }
}

#[test]
fn moves_have_one_width_each() {
    let taper = area(&[vec![[0.0, 0.0], [20.0, -0.4], [20.0, 0.4]]]);
    for area in [&taper, &ring_wall(3.0, 0.4, 100), &star(5, 4.0, 0.2)] {
        for skeleton in found(area) {
            let bead = skeleton.bead(3, Feature::InnerWall);
            assert_eq!(bead.tool, 3);
            assert!((bead.area_mm2() - skeleton.area_mm2()).abs() < 1e-9);
            assert!((bead.length_mm() - skeleton.length_mm()).abs() < 1e-9);
            assert_eq!(skeleton.is_closed, bead.end_mm() == bead.start_mm);
            for pair in bead.moves.windows(2) {
                let [a, b] = [pair[0].width_mm, pair[1].width_mm];
                assert!((a - b).abs() <= 0.12 * a.min(b), "{a} {b}");
            }
        }
    }
}

/// Random areas of thin parts: what overlapping strokes, rings and triangles leave.
fn random_area(rng: &mut Xoshiro256PlusPlus) -> Area {
    let mut number = |low: f64, high: f64| low + rng.random::<f64>() * (high - low);
    let kind = number(0.0, 4.0) as usize;
    let mut area = Area::default();
    for _ in 0..number(1.0, 6.0) as usize {
        let points: Vec<_> =
            (0..number(3.0, 9.0) as usize).map(|_| [number(0.0, 6.0), number(0.0, 6.0)]).collect();
        let next = match kind {
            0 => self::area(&[points]),
            1 => stroke(&points, number(0.1, 0.9)),
            // What rounded insets leave in corners and gaps.
            2 => {
                let block = Area::from_rings(&[points], FillRule::EvenOdd);
                block.difference(&block.opened(number(0.1, 0.6)))
            }
            _ => {
                let block = Area::from_rings(&[points], FillRule::EvenOdd);
                block.difference(&block.offset(-number(0.2, 0.8)))
            }
        };
        area = area.union(&next);
    }
    area
}

#[test]
fn random_areas() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
    for _ in 0..200 {
        let area = random_area(&mut rng);
        let found = found(&area);
        check(&area, &found);
        assert_eq!(found, self::found(&area));
        let sum: f64 = found.iter().map(Skeleton::area_mm2).sum();
        assert!(sum <= 1.1 * area.size_mm2() + 0.05, "{sum} {}", area.size_mm2());
    }
}

#[test]
fn position_and_scale_do_not_matter() {
    let double = SkeletonSettings {
        min_width_mm: 0.4,
        max_width_mm: 1.6,
        min_length_mm: 0.4,
        tolerance_mm: 0.01,
    };
    for (name, area) in shapes(0.45) {
        let base = found(&area);
        let moved = found(&mapped(&area, |[x, y]| [x + 200.0, y - 150.0]));
        let scaled = skeletons(&mapped(&area, |[x, y]| [2.0 * x, 2.0 * y]), &double);
        let sum = |found: &[Skeleton]| found.iter().map(Skeleton::area_mm2).sum::<f64>();
        for (other, factor) in [(&moved, 1.0), (&scaled, 4.0)] {
            assert_eq!(base.len(), other.len(), "{name}");
            let ratio = sum(other) / sum(&base) / factor;
            assert!((ratio - 1.0).abs() < 0.005, "{name} {ratio}");
        }
    }
}

#[test]
fn degenerate_areas() {
    let p = |x: f64, y: f64| [x, y];
    let sliver = |width: f64| vec![p(0., 0.), p(100., 0.), p(100., width), p(0., width)];
    let cases = [
        Area::default(),
        area(&[sliver(1e-4)]),
        area(&[sliver(1e-7)]),
        area(&[sliver(1e-4), sliver(0.5)]),
        area(&[circle(p(0., 0.), 5.0, 20_000)]),
        area(&[circle(p(0., 0.), 0.3, 20_000)]),
        area(&[circle(p(0., 0.), 0.01, 1000)]),
        // Needles, and squares that touch at a corner and along an edge.
        area(&[vec![p(0., 0.), p(50., 1e-3), p(50., 0.)]]),
        area(&[
            vec![p(0., 0.), p(50., 0.6), p(50., 0.)],
            vec![p(50., 0.), p(0., 0.), p(0., -1e-5)],
        ]),
        area(&[
            vec![p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)],
            vec![p(1., 1.), p(2., 1.), p(2., 2.), p(1., 2.)],
            vec![p(2., 0.), p(3., 0.), p(3., 2.), p(2., 2.)],
        ]),
        // A hole that touches the outline.
        Area::from_rings(
            &[
                vec![p(0., 0.), p(4., 0.), p(4., 4.), p(0., 4.)],
                vec![p(0., 2.), p(2., 1.), p(3.5, 2.), p(2., 3.)],
            ],
            FillRule::EvenOdd,
        ),
        // A comb with 500 teeth.
        area(&[(0..500)
            .flat_map(|i| {
                let x = f64::from(i) * 0.4;
                [p(x, 3.0), p(x + 0.2, 3.0 + 1e-6), p(x + 0.2, 0.1), p(x + 0.4, 0.1)]
            })
            .chain([p(200., 0.), p(0., 0.)])
            .rev()
            .collect()]),
        // Larger than any bed.
        area(&[vec![p(0., 0.), p(2e3, 0.), p(2e3, 0.5), p(0., 0.5)]]),
        area(&[vec![p(-500., 0.), p(500., 0.), p(0., 500.)]]),
    ];
    for (case, area) in cases.iter().enumerate() {
        let found = found(area);
        println!("{case}: {}", found.len());
        if area.rings().map(Vec::len).sum::<usize>() < 3000 && case < 12 {
            check(area, &found);
        }
    }
    let wall = stroke(&[[0.0, 0.0], [9.0, 0.0]], 0.5);
    for value in [f64::NAN, -1.0, 0.0, 1e9, f64::INFINITY] {
        let base = SkeletonSettings::default();
        for settings in [
            SkeletonSettings { min_width_mm: value, ..base },
            SkeletonSettings { max_width_mm: value, ..base },
            SkeletonSettings { min_length_mm: value, ..base },
            SkeletonSettings { tolerance_mm: value, ..base },
        ] {
            for skeleton in skeletons(&wall, &settings) {
                assert!(skeleton.points.iter().flatten().all(|x| x.is_finite()));
            }
        }
    }
}

#[test]
fn centrelines_do_not_touch_the_ends_of_walls() {
    // Positions in a file are rounded to 0.001 mm; a centreline on the outline has left the part.
    for width in [0.25, 0.3, 0.5, 0.7, 0.799_93, 0.8] {
        for length in [1.0, 7.3, 20.0] {
            let wall = vec![[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]];
            let found = skeletons(&area(&[wall]), &SkeletonSettings::default());
            assert_eq!(found.len(), 1, "{length} x {width}");
            for point in &found[0].points {
                let margin = point[0].min(length - point[0]);
                assert!(margin > 0.004, "{length} x {width}: {margin}");
            }
            assert!(found[0].length_mm() > length - 0.05, "{length} x {width}");
        }
    }
}
