//! Offsets compared with distances of points, and crossings with pairs of lines.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::area::{Area, Ring};
use crate::crossings::meeting;
use crate::simplify::squared_to_line;
use crate::slice::FillRule;

const TOLERANCE_MM: f64 = 0.004;

fn polygon(centre: [f64; 2], radius: f64, corners: u32, spikes: f64) -> Ring {
    let corner = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(corners);
        let radius = if i.is_multiple_of(2) { radius } else { radius * spikes };
        [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
    };
    (0..corners).map(corner).collect()
}

/// Polygons, stars and rectangles, united with and cut out of each other.
fn random_area(generator: &mut Xoshiro256PlusPlus) -> Area {
    let mut area = Area::default();
    for _ in 0..generator.random_range(1..8) {
        let centre = [0, 1].map(|_| generator.random_range(0.0..12.0));
        let size = generator.random_range(0.1..5.0);
        let ring = match generator.random_range(0..3) {
            0 => polygon(centre, size, generator.random_range(3..80), 1.0),
            1 => polygon(centre, size, 2 * generator.random_range(2..20), 0.7),
            _ => {
                let [x, y] = centre;
                let height = generator.random_range(0.1..5.0);
                vec![[x, y], [x + size, y], [x + size, y + height], [x, y + height]]
            }
        };
        let piece = Area::from_rings(&[ring], FillRule::NonZero);
        let is_hole = generator.random_range(0..3) == 0;
        area = if is_hole { area.difference(&piece) } else { area.union(&piece) };
    }
    area.without_slivers(1e-4)
}

fn distance(components: &[Rings], point: [f64; 2]) -> f64 {
    let lines = components
        .iter()
        .flatten()
        .flat_map(|ring| ring.iter().zip(ring.iter().skip(1).chain(ring.first())));
    lines.map(|(&a, &b)| squared_to_line(point, a, b)).fold(f64::INFINITY, f64::min).sqrt()
}

fn is_inside(components: &[Rings], point: [f64; 2]) -> bool {
    components.iter().flatten().filter(|ring| contains(ring, point)).count() % 2 == 1
}

#[test]
fn offsets_have_their_distance() {
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut even = 0;
    for _ in 0..3_000 {
        let area = random_area(&mut generator);
        let components = area.components();
        let mm: f64 = generator.random_range(0.05..1.5);
        for by_mm in [mm, -mm] {
            let Offset { components: got, is_even } = offset(components, by_mm, TOLERANCE_MM);
            for &point in got.iter().flatten().flatten() {
                let distance = distance(components, point);
                let range = mm - 1e-4..mm + TOLERANCE_MM + 1e-4;
                assert!(range.contains(&distance), "{by_mm} {point:?} {distance} {components:?}");
            }
            for _ in 0..60 {
                let point = [0, 1].map(|_| generator.random_range(-2.0..19.0));
                let was_inside = is_inside(components, point);
                let depth = distance(components, point) * if was_inside { -1.0 } else { 1.0 };
                if (depth - by_mm).abs() > TOLERANCE_MM + 1e-4 {
                    let expected = depth < by_mm;
                    let got = is_inside(&got, point);
                    assert_eq!(got, expected, "{by_mm} {point:?} {depth} {components:?}");
                }
                if is_even && by_mm < 0.0 && was_inside && !is_inside(&got, point) {
                    let reach = distance(&got, point);
                    assert!(reach < EVEN_SPEED * mm + 1e-3, "{by_mm} {point:?} {components:?}");
                }
            }
            even += u32::from(is_even);
        }
    }
    assert!(even > 500, "{even}");
}

#[test]
fn degenerate_rings_have_clear_results() {
    let square = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
    let size = |rings: Rings, by_mm: f64| -> f64 {
        let components = offset(&[rings], by_mm, TOLERANCE_MM).components;
        components.iter().flatten().map(|ring| ring_size_mm2(ring)).sum()
    };
    assert!((size(vec![square.clone()], -1.0) - 4.0).abs() < 1e-9);
    // Repeated corners, and corners on lines.
    let mut repeated: Ring = square.iter().flat_map(|&corner| [corner, corner]).collect();
    repeated.insert(2, [2.0, 0.0]);
    assert!((size(vec![repeated], -1.0) - 4.0).abs() < 1e-9);
    // All edges vanish at once, or long before.
    for by_mm in [-2.0, -2.1, -50.0] {
        assert!(size(vec![square.clone()], by_mm).abs() < 1e-9);
        assert!(size(vec![polygon([0.0; 2], 2.0, 99, 1.0)], by_mm).abs() < 1e-9);
    }
    // Points, lines, and a ring that turns back.
    assert!(size(vec![vec![[1.0, 1.0]; 4]], 1.0).abs() < 1e-9);
    assert!(size(vec![vec![[0.0, 0.0], [1.0, 0.0]]], 1.0).abs() < 1e-9);
    let back = size(vec![vec![[0.0, 0.0], [2.0, 0.0], [3.0, 0.0], [1.0, 0.0]]], 1.0);
    assert!(back.is_finite());
    // A hole that grows beyond the outline, and one that closes.
    let hole: Ring = polygon([2.0, 2.0], 1.5, 40, 1.0).into_iter().rev().collect();
    assert!(size(vec![square.clone(), hole.clone()], -1.0).abs() < 1e-9);
    let closed = 16.0 + 4.0 * 4.0 * 1.6 + std::f64::consts::PI * 1.6 * 1.6;
    assert!((size(vec![square.clone(), hole], 1.6) - closed).abs() < 0.05);
    // An island that fills the hole around it.
    let ring: Ring = polygon([0.0; 2], 5.0, 90, 1.0).into_iter().rev().collect();
    let around = vec![polygon([0.0; 2], 9.0, 90, 1.0), ring];
    let island = vec![polygon([0.0; 2], 4.0, 90, 1.0)];
    let grown = offset(&[around, island], 3.0, TOLERANCE_MM).components;
    assert_eq!((grown.len(), grown[0].len()), (1, 1));
}

#[test]
fn meeting_components_are_found() {
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(4);
    let (mut met, mut apart) = (0, 0);
    for _ in 0..500 {
        let [one, other] = [0; 2].map(|_| random_area(&mut generator));
        let groups: Vec<&[Ring]> = one.components().iter().map(|rings| &rings[..]).collect();
        let rings: Vec<&Ring> = other.rings().collect();
        for (got, rings) in meeting(&groups, &rings).into_iter().zip(&groups) {
            let component = Area::from_rings(rings, FillRule::NonZero);
            let common = component.intersection(&other).size_mm2();
            assert!(got || common < 1e-4, "{common}");
            let near = component.offset(1e-3).intersection(&other);
            assert!(!got || !near.is_empty());
            met += u32::from(got);
            apart += u32::from(!got);
        }
    }
    assert!(met > 100 && apart > 100, "{met} {apart}");
}
