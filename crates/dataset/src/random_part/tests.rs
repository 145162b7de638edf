//! Tests of random parts, and of the operations on masks against slow twins.

use beadwork_grid::region_components;
use beadwork_part::slice::Voxels;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::mask::{Kernel, Mask, Rectangle};
use super::*;

/// Components of a layer.
fn components(part: &Voxels, z: usize) -> u32 {
    region_components(&part.region(z).unwrap()).count()
}

/// Number of groups of voxels that are connected through faces.
fn bodies(part: &Voxels) -> usize {
    let size = [part.frame.width, part.frame.height, part.depth as u32];
    let [width, height, depth] = size.map(|count| count as usize);
    let mut open = Vec::new();
    let mut seen = vec![false; width * height * depth];
    let mut count = 0;
    for first in 0..seen.len() {
        let position = |i: usize| [i % width, i / width % height, i / width / height];
        let filled = |[x, y, z]: [usize; 3]| part.material(x as u32, y as u32, z).is_some();
        if seen[first] || !filled(position(first)) {
            continue;
        }
        count += 1;
        seen[first] = true;
        open.push(first);
        while let Some(i) = open.pop() {
            for axis in 0..3 {
                for step in [1, usize::MAX] {
                    let mut at = position(i);
                    at[axis] = at[axis].wrapping_add(step);
                    if at[axis] >= size[axis] as usize || !filled(at) {
                        continue;
                    }
                    let other = (at[2] * height + at[1]) * width + at[0];
                    if !seen[other] {
                        seen[other] = true;
                        open.push(other);
                    }
                }
            }
        }
    }
    count
}

/// Whether some empty cells of a layer cannot be reached from its border.
fn has_hole(part: &Voxels, z: usize) -> bool {
    let (width, height) = (part.frame.width, part.frame.height);
    let empty = |x: u32, y: u32| part.material(x, y, z).is_none();
    let mut outside = vec![vec![false; width as usize]; height as usize];
    let mut changed = true;
    while changed {
        changed = false;
        for y in 0..height {
            for x in 0..width {
                let (column, row) = (x as usize, y as usize);
                let beside = x == 0
                    || y == 0
                    || x + 1 == width
                    || y + 1 == height
                    || outside[row - 1][column]
                    || outside[row + 1][column]
                    || outside[row][column - 1]
                    || outside[row][column + 1];
                if empty(x, y) && beside && !outside[row][column] {
                    outside[row][column] = true;
                    changed = true;
                }
            }
        }
    }
    (0..height).any(|y| (0..width).any(|x| empty(x, y) && !outside[y as usize][x as usize]))
}

/// Checks everything that the documentation guarantees.
fn check(part: &Voxels, settings: &Settings) {
    let name = format!("{settings:?}");
    let Settings { width, height, min_layers, max_layers, .. } = *settings;
    assert_eq!((part.frame.width, part.frame.height), (width, height));
    assert!((min_layers as usize..=max_layers as usize).contains(&part.depth), "{name}");
    for z in 0..part.depth {
        assert!(part.cells(z).next().is_some(), "{name}: layer {z} is empty");
        for y in 0..height {
            for x in (0..width).filter(|&x| z > 0 && part.material(x, y, z).is_some()) {
                let below = |x: u32, y: u32| part.material(x, y, z - 1).is_some();
                let supported = below(x, y)
                    || below(x + 1, y)
                    || below(x, y + 1)
                    || x > 0 && below(x - 1, y)
                    || y > 0 && below(x, y - 1);
                assert!(supported, "{name}: voxel {x} {y} {z}");
            }
        }
    }
    let layers = || 0..part.depth;
    let split = layers().filter(|&z| components(part, z) > 1).count();
    match settings.kind {
        Kind::Plain | Kind::Holes => assert_eq!(split, 0, "{name}"),
        Kind::Branches => assert!(split >= 3 && components(part, 0) == 1, "{name}"),
        Kind::Islands => assert!(split >= 3, "{name}"),
    }
    if settings.kind == Kind::Holes {
        assert!(layers().filter(|&z| has_hole(part, z)).count() >= 3, "{name}");
    }
    // Bodies do not merge, and all of them stand on the build plate.
    assert_eq!(bodies(part), components(part, 0) as usize, "{name}");
}

/// Settings of small parts, extreme ones among them.
fn random_settings(rng: &mut ChaCha8Rng) -> Settings {
    let (width, height) = (rng.random_range(8..=24), rng.random_range(8..=24));
    let min_layers = rng.random_range(1..=15);
    let max_side = rng.random_range(1..=width.min(height));
    let mut chance = || match rng.random_range(0..6) {
        0 => 0.0,
        1 => 1.0,
        _ => rng.random::<f64>(),
    };
    let (overhang_chance, growth) = (chance(), chance());
    Settings {
        kind: Kind::ALL[rng.random_range(0..4)],
        width,
        height,
        min_layers,
        max_layers: rng.random_range(min_layers.max(4)..=20),
        min_side: rng.random_range(1..=max_side),
        max_side,
        overhang_chance,
        growth,
        max_indentations: rng.random_range(1..=4),
        max_indentation_side: rng.random_range(1..=30),
        indentation_radius: rng.random_range(0..=3),
        overhang_radius: rng.random_range(0..=2),
        max_attempts: 20,
        ..Settings::default()
    }
}

#[test]
fn parts_of_random_settings_hold_to_the_guarantees() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut counts = [0; 4];
    for seed in 0..6000 {
        let settings = random_settings(&mut rng);
        match random_part(&settings, seed) {
            Ok(part) => {
                check(&part, &settings);
                counts[settings.kind as usize] += 1;
            }
            Err(error) => {
                let &Settings { kind, min_layers, .. } = &settings;
                assert_eq!(error, RandomPartError::Attempts { attempts: 20, kind, min_layers });
            }
        }
    }
    assert!(counts.iter().all(|&count| count > 200), "{counts:?}");
}

#[test]
fn parts_of_presets_hold_to_the_guarantees() {
    for kind in Kind::ALL {
        for seed in 0..100 {
            let settings = Settings { kind, ..Settings::default() };
            check(&random_part(&settings, seed).unwrap(), &settings);
        }
        for preset in Preset::ALL {
            let settings = Settings { kind, ..Settings::preset(preset) };
            for seed in 0..3 {
                check(&random_part(&settings, seed).unwrap(), &settings);
            }
        }
    }
}

/// The paper's 80 parts for training have 4,236 layers, 53 each.
#[test]
fn large_parts_are_as_long_as_those_of_the_paper() {
    let settings = Settings::preset(Preset::Grid128);
    let layers: usize = (0..40).map(|seed| random_part(&settings, seed).unwrap().depth).sum();
    assert!((45..65).contains(&(layers / 40)), "{layers}");
}

/// Datasets store seeds, so parts must not change.
#[test]
fn seeds_give_the_same_parts_as_ever() {
    let digest = |kind: Kind| {
        let settings = Settings { kind, ..Settings::default() };
        let part = random_part(&settings, 5).unwrap();
        let bytes: Vec<u8> = part.materials().iter().copied().collect();
        (part.depth, crc32fast::hash(&bytes))
    };
    let expected = [(23, 127_465_334), (19, 1_995_151_372), (32, 267_128_534), (32, 3_300_103_549)];
    assert_eq!(Kind::ALL.map(digest), expected);
    let of_seed = |seed| random_part(&Settings::default(), seed).unwrap();
    assert_eq!(of_seed(9), of_seed(9));
    assert_ne!(of_seed(9), of_seed(10));
}

#[test]
fn settings_out_of_range_are_refused() {
    let error = |settings: Settings| random_part(&settings, 0).unwrap_err().to_string();
    let default = Settings::default;
    let cases = [
        (Settings { width: 7, ..default() }, "width is 7, expected 8 to 4096"),
        (Settings { height: 5000, ..default() }, "height is 5000, expected 8 to 4096"),
        (Settings { min_layers: 0, ..default() }, "min_layers is 0, expected 1 to 4096"),
        (Settings { max_layers: 14, ..default() }, "max_layers is 14, expected 15 to 4096"),
        (
            Settings { kind: Kind::Holes, min_layers: 1, max_layers: 3, ..default() },
            "max_layers is 3, expected 4 to 4096",
        ),
        (Settings { max_side: 33, ..default() }, "max_side is 33, expected 12 to 32"),
        (Settings { min_side: 0, ..default() }, "min_side is 0, expected 1 to 32"),
        (Settings { growth: f64::NAN, ..default() }, "growth is NaN, expected 0 to 1"),
        (
            Settings { overhang_chance: -0.1, ..default() },
            "overhang_chance is -0.1, expected 0 to 1",
        ),
        (Settings { overhang_radius: 17, ..default() }, "overhang_radius is 17, expected 0 to 16"),
        (
            Settings { cell_mm: f64::INFINITY, ..default() },
            "cell_mm is inf, expected a finite length of more than 0",
        ),
    ];
    for (settings, expected) in cases {
        assert_eq!(error(settings), format!("random part: {expected}"));
    }
}

#[test]
fn parts_that_cannot_be_long_enough_are_an_error() {
    let settings = Settings {
        overhang_chance: 0.0,
        max_indentation_side: 4096,
        max_indentations: 1024,
        max_attempts: 1,
        min_layers: 4096,
        max_layers: 4096,
        ..Settings::default()
    };
    let error = random_part(&settings, 0).unwrap_err().to_string();
    let start = "random part: none of 1 attempts gave a part of kind 'plain' with at least 4096";
    assert!(error.starts_with(start), "{error}");
}

fn random_mask(rng: &mut ChaCha8Rng) -> Mask {
    let (width, height) = (rng.random_range(1..=14), rng.random_range(1..=14));
    let mut mask = Mask::empty(width, height);
    if rng.random_bool(0.5) {
        let share = rng.random::<f64>();
        mask.cells.iter_mut().for_each(|cell| *cell = rng.random_bool(share));
    } else {
        for _ in 0..rng.random_range(0..4) {
            let corner = [(); 2].map(|()| rng.random_range(-3..14));
            let size = [(); 2].map(|()| rng.random_range(0..12));
            mask.set(Rectangle { corner, size }, rng.random_bool(0.8));
        }
    }
    mask
}

fn filled(mask: &Mask, x: i64, y: i64) -> bool {
    let inside = (0..mask.width as i64).contains(&x) && (0..mask.height as i64).contains(&y);
    inside && mask.cells[y as usize * mask.width + x as usize]
}

#[test]
fn openings_are_unions_of_kernels() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..3000 {
        let mask = random_mask(&mut rng);
        let radius = rng.random_range(0..4);
        let reach = i64::from(radius);
        let round = rng.random_bool(0.5);
        let kernel = if round { Kernel::ellipse(radius) } else { Kernel::square(radius) };
        let half = |dy: i64| f64::from(((reach * reach - dy * dy) as f64).sqrt().round() as i32);
        let offsets: Vec<_> = (-reach..=reach)
            .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
            .filter(|&(dx, dy)| !round || dx.abs() as f64 <= half(dy))
            .collect();
        let mut expected = Mask::empty(mask.width as u32, mask.height as u32);
        for y in 0..mask.height as i64 {
            for x in 0..mask.width as i64 {
                if offsets.iter().all(|&(dx, dy)| filled(&mask, x + dx, y + dy)) {
                    for &(dx, dy) in &offsets {
                        let (x, y) = ((x + dx) as usize, (y + dy) as usize);
                        expected.cells[y * mask.width + x] = true;
                    }
                }
            }
        }
        assert_eq!(mask.opened(&kernel), expected, "{kernel:?} {mask:?}");
    }
}

#[test]
fn ellipses_are_those_of_image_libraries() {
    let mut mask = Mask::empty(9, 9);
    mask.set(Rectangle { corner: [2, 2], size: [5, 5] }, true);
    let opened = mask.opened(&Kernel::ellipse(2));
    let rows: Vec<String> = (2..7)
        .map(|y| (2..7).map(|x| if filled(&opened, x, y) { '#' } else { '.' }).collect())
        .collect();
    assert_eq!(rows, ["..#..", "#####", "#####", "#####", "..#.."]);
}

#[test]
fn contours_touch_the_space_around_the_grid() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..3000 {
        let mask = random_mask(&mut rng);
        let (width, height) = (mask.width as i64, mask.height as i64);
        // The outside on a grid with an empty border, by repeated sweeps.
        let mut outside = std::collections::BTreeSet::from([(-1, -1)]);
        loop {
            let before = outside.len();
            for y in -1..=height {
                for x in -1..=width {
                    let near = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
                    if !filled(&mask, x, y) && near.iter().any(|cell| outside.contains(cell)) {
                        outside.insert((x, y));
                    }
                }
            }
            if outside.len() == before {
                break;
            }
        }
        let cells = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let number = |(x, y): (i64, i64)| (y * width + x) as usize;
        let near = |(x, y): (i64, i64)| [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
        let contour: Vec<_> = cells()
            .filter(|&(x, y)| filled(&mask, x, y))
            .filter(|&cell| near(cell).iter().any(|cell| outside.contains(cell)))
            .map(number)
            .collect();
        assert_eq!(mask.contour(), contour, "{mask:?}");
        let beside: Vec<_> = cells()
            .filter(|&(x, y)| !filled(&mask, x, y))
            .filter(|&cell| near(cell).iter().any(|&(x, y)| filled(&mask, x, y)))
            .map(number)
            .collect();
        assert_eq!(mask.beside(), beside, "{mask:?}");
        let hole = cells().any(|(x, y)| !filled(&mask, x, y) && !outside.contains(&(x, y)));
        assert_eq!(mask.has_hole(), hole, "{mask:?}");
    }
}

#[test]
fn only_supported_components_are_kept() {
    // Four components: of 1, 3, 2 and 3 cells.
    let row = |text: &str| -> Vec<bool> { text.chars().map(|c| c == '#').collect() };
    let mask = Mask { width: 12, height: 1, cells: row("#.###.##.###") };
    let below = |text: &str| Mask { cells: row(text), ..mask.clone() };
    let kept = |below_text: &str, only_largest: bool| {
        let mut kept = mask.clone();
        kept.keep_supported(&below(below_text), only_largest);
        kept.cells.iter().map(|&cell| if cell { '#' } else { '.' }).collect::<String>()
    };
    assert_eq!(mask.component_count(), 4);
    assert_eq!(kept("############", false), "#.###.##.###");
    assert_eq!(kept("############", true), "..###.......");
    assert_eq!(kept("#......#...#", false), "#.....##.###");
    assert_eq!(kept("#......#....", true), "......##....");
    assert_eq!(kept(".#...#......", true), "............");
}
