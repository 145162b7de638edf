//! Orders compared with those of a slow and simple implementation.

use std::collections::{BTreeMap, BTreeSet};

use beadwork_grid::{Cell, Region, RegionShape};
use proptest::prelude::*;

use super::*;

/// Family, axis and corner of a pattern, from its name.
fn parts_of_name(pattern: Pattern) -> (&'static str, &'static str, u8) {
    let (rest, corner) = pattern.name().rsplit_once('-').unwrap();
    let (family, axis) = match rest.rsplit_once('-') {
        Some((family, axis @ ("x" | "y"))) => (family, axis),
        _ => (rest, "x"),
    };
    (family, axis, corner.parse().unwrap())
}

fn named(name: &str) -> Pattern {
    name.parse().unwrap()
}

/// Coordinates of a cell as seen from the pattern's corner: along its axis and across.
fn seen(pattern: Pattern, region: &Region, cell: Cell) -> (i64, i64) {
    let (_, axis, corner) = parts_of_name(pattern);
    let (x, y) = region.xy(cell);
    let x = if corner & 1 == 0 { x } else { region.width() - 1 - x };
    let y = if corner & 2 == 0 { y } else { region.height() - 1 - y };
    if axis == "x" { (x.into(), y.into()) } else { (y.into(), x.into()) }
}

/// The cell at coordinates of [`seen`].
fn cell_at(pattern: Pattern, region: &Region, position: (i64, i64)) -> Option<Cell> {
    let cells = 0..region.grid_len() as Cell;
    cells.into_iter().find(|&cell| seen(pattern, region, cell) == position)
}

/// Lines, spirals and diagonals of the cells that are not taken.
fn slow_sweep(pattern: Pattern, region: &Region, taken: &BTreeSet<Cell>) -> Vec<Cell> {
    let (family, _, _) = parts_of_name(pattern);
    let mut cells: Vec<Cell> = (0..region.grid_len() as Cell).collect();
    let position = |cell: Cell| seen(pattern, region, cell);
    match family {
        "zigzag" | "contour-zigzag" => cells.sort_by_key(|&cell| {
            let (u, v) = position(cell);
            (v, if (v % 2 == 0) == (family == "zigzag") { u } else { -u })
        }),
        "raster" | "contour-raster" => {
            cells.sort_by_key(|&cell| (position(cell).1, position(cell).0));
        }
        "diagonal" => cells.sort_by_key(|&cell| {
            let (u, v) = position(cell);
            (u + v, if (u + v) % 2 == 1 { v } else { u })
        }),
        _ => cells = slow_spiral(pattern, region, family == "spiral-out"),
    }
    cells.retain(|&cell| region.contains(cell) && !taken.contains(&cell));
    cells
}

/// A walk that turns right at the border of the grid and at its own trail.
fn slow_spiral(pattern: Pattern, region: &Region, outward: bool) -> Vec<Cell> {
    let (mut position, mut heading) = ((0, 0), (1, 0));
    let mut trail = vec![cell_at(pattern, region, position).unwrap()];
    let mut turns = 0;
    while turns < 2 {
        let ahead = (position.0 + heading.0, position.1 + heading.1);
        if let Some(cell) = cell_at(pattern, region, ahead).filter(|cell| !trail.contains(cell)) {
            trail.push(cell);
            position = ahead;
            turns = 0;
        } else {
            heading = (-heading.1, heading.0);
            turns += 1;
        }
    }
    if outward {
        trail.reverse();
    }
    trail
}

/// The outlines from directed edges between the corner points of cells, joined at their ends with
/// the sharpest left turn.
fn slow_outlines(pattern: Pattern, region: &Region) -> Vec<Cell> {
    let inside: BTreeSet<(i64, i64)> =
        region.cells().map(|cell| seen(pattern, region, cell)).collect();
    // An edge from a corner point in a direction, the region on the left.
    let mut edges: BTreeSet<((i64, i64), (i64, i64))> = BTreeSet::new();
    for &(u, v) in &inside {
        let sides = [
            ((u, v - 1), ((u + 1, v), (-1, 0))),
            ((u - 1, v), ((u, v), (0, 1))),
            ((u, v + 1), ((u, v + 1), (1, 0))),
            ((u + 1, v), ((u + 1, v + 1), (0, -1))),
        ];
        edges.extend(
            sides.into_iter().filter(|(other, _)| !inside.contains(other)).map(|(_, edge)| edge),
        );
    }
    let left = |(du, dv): (i64, i64)| (dv, -du);
    let right = |(du, dv): (i64, i64)| (-dv, du);
    // The cell on the left of an edge.
    let cell = |(u, v): (i64, i64), heading: (i64, i64)| match heading {
        (-1, 0) => (u - 1, v),
        (0, 1) => (u, v),
        (1, 0) => (u, v - 1),
        _ => (u - 1, v - 1),
    };
    let mut loops: BTreeMap<_, Vec<Vec<(i64, i64)>>> = BTreeMap::new();
    // Row by row, because a cell that is visited twice belongs to the outline found first.
    let mut firsts: Vec<_> = edges.iter().copied().collect();
    firsts.sort_by_key(|&(point, heading)| {
        let (u, v) = cell(point, heading);
        let number = [(1, 0), (0, 1), (-1, 0), (0, -1)].iter().position(|&one| one == heading);
        (v, u, number)
    });
    for first in firsts {
        if !edges.contains(&first) {
            continue;
        }
        let (mut point, mut heading) = first;
        let mut cells = Vec::new();
        while edges.remove(&(point, heading)) {
            let here = cell(point, heading);
            cells.push(here);
            point = (point.0 + heading.0, point.1 + heading.1);
            let turns = [left(heading), heading, right(heading)];
            let turned = turns
                .into_iter()
                .find(|&way| edges.contains(&(point, way)) || (point, way) == first);
            if turned == Some(right(heading)) {
                cells.push((here.0 + heading.0, here.1 + heading.1));
            }
            heading = turned.expect("edges close in loops");
        }
        let distance = |&(u, v): &(i64, i64)| (u * u + v * v, v);
        let closest = cells.iter().map(distance).min().unwrap();
        let start = cells.iter().position(|position| distance(position) == closest).unwrap();
        cells.rotate_left(start);
        loops.entry(closest).or_default().push(cells);
    }
    let mut order: Vec<Cell> = Vec::new();
    for position in loops.into_values().flatten().flatten() {
        let cell = cell_at(pattern, region, position).unwrap();
        if !order.contains(&cell) {
            order.push(cell);
        }
    }
    order
}

fn slow(pattern: Pattern, region: &Region) -> Vec<Cell> {
    let mut order = Vec::new();
    if pattern.name().starts_with("contour") {
        order = slow_outlines(pattern, region);
    }
    let taken = order.iter().copied().collect();
    order.extend(slow_sweep(pattern, region, &taken));
    order
}

/// The cells with one of their eight neighbours outside, by definition.
fn edge_cells(region: &Region) -> BTreeSet<Cell> {
    let is_edge = |&cell: &Cell| {
        let (x, y) = region.xy(cell);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        let mut around =
            around.map(|(dx, dy)| (x.checked_add_signed(dx), y.checked_add_signed(dy)));
        around.any(|neighbour| {
            let (Some(x), Some(y)) = neighbour else { return true };
            x >= region.width() || y >= region.height() || !region.contains(region.cell(x, y))
        })
    };
    region.cells().filter(is_edge).collect()
}

fn check(region: &Region) {
    let cells: Vec<Cell> = region.cells().collect();
    let edge = edge_cells(region);
    for pattern in Pattern::ALL {
        let order = pattern.order(region);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, cells, "{pattern} leaves out or repeats cells");
        if pattern.name().starts_with("contour") {
            let first: BTreeSet<Cell> = order[..edge.len()].iter().copied().collect();
            assert_eq!(first, edge, "{pattern}");
        }
    }
}

/// A region from rows of text, with '#' for its cells.
fn drawn(rows: &[&str]) -> Region {
    let mask = rows.iter().flat_map(|row| row.bytes().map(|cell| cell == b'#')).collect();
    Region::from_mask(rows[0].len() as u32, rows.len() as u32, mask).unwrap()
}

fn mirrored(region: &Region, x: bool, y: bool) -> Region {
    let (width, height) = (region.width(), region.height());
    let mask = (0..height).flat_map(|row| (0..width).map(move |column| (column, row))).map(
        |(column, row)| {
            let column = if x { width - 1 - column } else { column };
            let row = if y { height - 1 - row } else { row };
            region.contains(region.cell(column, row))
        },
    );
    Region::from_mask(width, height, mask.collect()).unwrap()
}

fn transposed(region: &Region) -> Region {
    let (width, height) = (region.width(), region.height());
    let mask = (0..width).flat_map(|x| (0..height).map(move |y| (x, y)));
    let mask = mask.map(|(x, y)| region.contains(region.cell(x, y))).collect();
    Region::from_mask(height, width, mask).unwrap()
}

fn any_region() -> impl Strategy<Value = Region> {
    let mask = (1..=9_u32, 1..=9_u32, 1..=10_u8).prop_flat_map(|(width, height, share)| {
        let cells = prop::collection::vec(0..10_u8, (width * height) as usize);
        cells.prop_map(move |cells| {
            let mut mask: Vec<bool> = cells.into_iter().map(|cell| cell < share).collect();
            mask[0] |= mask.iter().all(|&cell| !cell);
            Region::from_mask(width, height, mask).unwrap()
        })
    });
    let shape = (0..RegionShape::ALL.len(), 8..=14_u32, 8..=14_u32, any::<u64>());
    let shape = shape.prop_map(|(shape, width, height, seed)| {
        RegionShape::ALL[shape]
            .region(width, height, seed)
            .unwrap_or(Region::rectangle(width, height).unwrap())
    });
    prop_oneof![3 => mask, 1 => shape]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_order_visits_each_cell_once(region in any_region()) {
        check(&region);
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 150,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn orders_are_those_of_the_slow_implementation(region in any_region()) {
        for pattern in Pattern::ALL {
            prop_assert_eq!(pattern.order(&region), slow(pattern, &region), "{}", pattern);
        }
    }

    #[test]
    fn other_corners_and_axes_are_mirror_images(region in any_region()) {
        for pattern in Pattern::ALL {
            let (family, _, corner) = parts_of_name(pattern);
            if family == "diagonal" && corner == 1 {
                continue;
            }
            for other in Pattern::ALL.into_iter().filter(|&other| parts_of_name(other).0 == family)
            {
                let flips = corner ^ parts_of_name(other).2;
                let (flip_x, flip_y) = (flips & 1 != 0, flips & 2 != 0);
                if parts_of_name(other).1 != parts_of_name(pattern).1 {
                    continue;
                }
                let image = mirrored(&region, flip_x, flip_y);
                let back = |cell: Cell| {
                    let (x, y) = image.xy(cell);
                    let x = if flip_x { image.width() - 1 - x } else { x };
                    let y = if flip_y { image.height() - 1 - y } else { y };
                    region.cell(x, y)
                };
                let order: Vec<Cell> = other.order(&image).into_iter().map(back).collect();
                prop_assert_eq!(&order, &pattern.order(&region), "{} and {}", pattern, other);
            }
        }
        let image = transposed(&region);
        for (name, other) in [
            ("zigzag-x-0", "zigzag-y-0"),
            ("raster-x-3", "raster-y-3"),
            ("contour-zigzag-x-0", "contour-zigzag-y-0"),
            ("contour-raster-x-0", "contour-raster-y-0"),
        ] {
            let back = |cell| {
                let (x, y) = image.xy(cell);
                region.cell(y, x)
            };
            let order: Vec<Cell> = named(other).order(&image).into_iter().map(back).collect();
            prop_assert_eq!(order, named(name).order(&region), "{} and {}", name, other);
        }
    }
}

#[test]
fn common_shapes_are_covered_once() {
    for shape in RegionShape::ALL {
        for seed in 0..20 {
            check(&shape.region(40, 30, seed).unwrap());
        }
    }
    check(&Region::rectangle(1, 1).unwrap());
    check(&Region::rectangle(1, 300).unwrap());
    check(&Region::rectangle(300, 2).unwrap());
}

#[test]
fn all_orders_differ() {
    for (width, height) in [(5, 4), (4, 5), (6, 6), (7, 9)] {
        let region = Region::rectangle(width, height).unwrap();
        let orders: BTreeSet<Vec<Cell>> =
            Pattern::ALL.into_iter().map(|one| one.order(&region)).collect();
        assert_eq!(orders.len(), Pattern::COUNT, "{width} x {height}");
    }
}

#[test]
fn orders_begin_or_end_in_their_corner() {
    let region = Region::rectangle(7, 5).unwrap();
    let corners = [0, 6, 28, 34];
    for pattern in Pattern::ALL {
        let (family, _, corner) = parts_of_name(pattern);
        let order = pattern.order(&region);
        let end = if family == "spiral-out" { order[order.len() - 1] } else { order[0] };
        assert_eq!(end, corners[usize::from(corner)], "{pattern}");
    }
}

#[test]
fn outlines_are_walked_around() {
    // The outer outline comes first, then that of the hole; the inner corner of the notch belongs
    // to the outline.
    let ring = drawn(&["#####", "#####", "##.##", "#####", "#####"]);
    let order = Pattern::CONVENTIONAL.order(&ring);
    let expected =
        [0, 5, 10, 15, 20, 21, 22, 23, 24, 19, 14, 9, 4, 3, 2, 1, 6, 7, 8, 13, 18, 17, 16, 11];
    assert_eq!(order, expected);
    let notch = drawn(&["####", "####", "##..", "##.."]);
    let order = Pattern::CONVENTIONAL.order(&notch);
    assert_eq!(order, [0, 4, 8, 12, 13, 9, 5, 6, 7, 3, 2, 1]);
}

#[test]
fn closed_walks_take_unit_steps() {
    let wide = drawn(&[
        "...####..",
        "..######.",
        ".########",
        ".########",
        "..#######",
        "..####...",
        "..####...",
    ]);
    for pattern in Pattern::ALL.into_iter().filter(|pattern| pattern.name().starts_with("contour"))
    {
        let order = pattern.order(&wide);
        let outline = &order[..edge_cells(&wide).len()];
        assert!(
            outline.windows(2).all(|step| wide.adjacent(step[0], step[1])),
            "{pattern}: {outline:?}"
        );
        assert!(wide.adjacent(outline[0], outline[outline.len() - 1]), "{pattern}");
    }
}

#[test]
fn the_outline_of_a_rectangle_continues_in_the_zigzag() {
    let region = Region::rectangle(8, 7).unwrap();
    for pattern in
        Pattern::ALL.into_iter().filter(|pattern| parts_of_name(*pattern).0 == "contour-zigzag")
    {
        assert!(
            pattern.order(&region).windows(2).all(|step| region.adjacent(step[0], step[1])),
            "{pattern}"
        );
    }
}

#[test]
fn thin_and_touching_components() {
    let line = drawn(&["####"]);
    assert_eq!(Pattern::CONVENTIONAL.order(&line), [0, 1, 2, 3]);
    assert_eq!(named("contour-raster-x-3").order(&line), [3, 2, 1, 0]);
    // Two components that touch at a corner have one outline each.
    let pair = drawn(&["##..", "##..", "..##", "..##"]);
    assert_eq!(Pattern::CONVENTIONAL.order(&pair), [0, 4, 5, 1, 10, 14, 15, 11]);
    // A wall one cell wide: the outline of the hole has no cells left.
    let wall = drawn(&["###", "#.#", "###"]);
    assert_eq!(Pattern::CONVENTIONAL.order(&wall), [0, 3, 6, 7, 8, 5, 2, 1]);
}

#[test]
fn names_and_numbers() {
    for (number, pattern) in Pattern::ALL.into_iter().enumerate() {
        assert_eq!(pattern.number(), number);
        assert_eq!(Pattern::from_number(number), Some(pattern));
        assert_eq!(pattern.to_string().parse(), Ok(pattern));
    }
    assert_eq!(Pattern::from_number(Pattern::COUNT), None);
    assert_eq!(Pattern::CONVENTIONAL, named("contour-zigzag-x-0"));
    let error = "zigzag-z-0".parse::<Pattern>().unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("unknown pattern 'zigzag-z-0': expected a name like zigzag-x-0,")
    );
    // Datasets and trained models contain the numbers.
    for (name, number) in [
        ("zigzag-x-0", 0),
        ("zigzag-y-0", 4),
        ("raster-x-0", 8),
        ("raster-y-3", 15),
        ("spiral-in-0", 16),
        ("spiral-out-0", 20),
        ("contour-zigzag-x-0", 24),
        ("contour-raster-x-0", 32),
        ("contour-raster-x-3", 33),
        ("contour-raster-y-0", 34),
        ("diagonal-0", 36),
        ("diagonal-1", 37),
    ] {
        assert_eq!(named(name).number(), number, "{name}");
    }
}
