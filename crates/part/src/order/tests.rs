//! Orders of lines compared with those of a slow and simple implementation.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use beadwork_grid::{Cell, Region, RegionShape};
use proptest::prelude::*;

use super::*;
use crate::Pattern;

fn stride(k: u32) -> Stride {
    Stride::new(k).unwrap()
}

fn sequences(strides: impl Iterator<Item = u32> + Clone) -> Vec<Sequence> {
    let mut all = vec![Sequence::Sequential, Sequence::Golden, Sequence::BitReversed];
    all.extend(strides.clone().map(|k| Sequence::Interleaved(stride(k))));
    all.extend(strides.map(|k| Sequence::Scattered(stride(k))));
    all
}

/// Compares the fractional parts of i φ and j φ, φ = (√5 - 1) / 2, in integers.
fn compare_fractions(i: i128, j: i128) -> Ordering {
    // floor(i φ) = floor((floor(√(5 i²)) - i) / 2), as i φ is irrational for i > 0.
    let floor = |i: i128| ((5 * i * i).isqrt() - i).div_euclid(2);
    // i φ - j φ < floor(i φ) - floor(j φ) is d √5 < 2 f + d.
    let (d, f) = (i - j, floor(i) - floor(j));
    let right = 2 * f + d;
    (d.signum() * 5 * d * d).cmp(&(right.signum() * right * right))
}

fn slow_golden(n: usize) -> Vec<usize> {
    let rank = |i: usize| {
        (0..n).filter(|&j| compare_fractions(j as i128, i as i128) == Ordering::Less).count()
    };
    (0..n).map(rank).collect()
}

/// A sequence by its definition, in O(n²).
fn slow_sequence(sequence: Sequence, n: usize) -> Vec<usize> {
    let by_offset = |offsets: Vec<usize>| {
        let mut order = Vec::new();
        for offset in offsets.iter().copied() {
            order.extend((0..n).filter(|i| i % offsets.len() == offset));
        }
        order
    };
    match sequence {
        Sequence::Sequential => (0..n).collect(),
        Sequence::Interleaved(k) => by_offset((0..n.min(k.get() as usize)).collect()),
        Sequence::Scattered(k) => by_offset(slow_golden(n.min(k.get() as usize))),
        Sequence::Golden => slow_golden(n),
        Sequence::BitReversed => {
            // As many bits as the largest number has.
            let bits = (0..64).find(|&bits| n <= 1 << bits).unwrap();
            let text = |i: usize| {
                let digits = format!("{i:0bits$b}");
                digits.chars().rev().collect::<String>()
            };
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by_key(|&i| text(i));
            order
        }
    }
}

#[test]
fn sequences_are_those_of_the_slow_implementation() {
    for n in 0..=100 {
        for sequence in sequences((1..=20).chain([31, 64, 101, Stride::MAX])) {
            assert_eq!(sequence.order(n), slow_sequence(sequence, n), "{sequence} of {n}");
        }
    }
    for n in [610, 987, 1000] {
        assert_eq!(Sequence::Golden.order(n), slow_golden(n), "{n}");
    }
}

#[test]
fn sequences_of_few_things() {
    let order = |name: &str, n| name.parse::<Sequence>().unwrap().order(n);
    assert_eq!(order("golden", 7), [0, 4, 2, 6, 3, 1, 5]);
    assert_eq!(order("bit-reversed", 8), [0, 4, 2, 6, 1, 5, 3, 7]);
    assert_eq!(order("bit-reversed", 6), [0, 4, 2, 1, 5, 3]);
    assert_eq!(order("scattered-7", 14), [0, 7, 4, 11, 2, 9, 6, 13, 3, 10, 1, 8, 5, 12]);
    for sequence in sequences([1, 2, 7, Stride::MAX].into_iter()) {
        assert!(sequence.order(0).is_empty(), "{sequence}");
        assert_eq!(sequence.order(1), [0], "{sequence}");
    }
    for n in 0..50 {
        assert_eq!(order("interleaved-1", n), order("sequential", n));
        assert_eq!(order("scattered-1", n), order("sequential", n));
        assert_eq!(order("interleaved-50", n), order("sequential", n));
        assert_eq!(order("scattered-50", n), order("golden", n));
    }
}

#[test]
fn offsets_in_golden_order_are_far_apart() {
    for k in 1..=Stride::MAX as usize {
        let (mut before, mut closest) = (BTreeSet::new(), k);
        for (index, offset) in Sequence::Golden.order(k).into_iter().enumerate() {
            // The nearest on both sides, across the end of the circle.
            let below = before.range(..offset).next_back().or(before.last());
            let above = before.range(offset..).next().or(before.first());
            for &other in below.into_iter().chain(above) {
                let distance = offset.abs_diff(other);
                closest = closest.min(distance).min(k - distance);
            }
            before.insert(offset);
            let first = index + 1;
            assert!(8 * closest * first >= 3 * k, "the first {first} of {k}: {closest}");
        }
    }
}

/// The cells of an order by its definition, with a search through all cells for each line.
fn slow_order(order: LineOrder, region: &Region) -> Vec<Cell> {
    let corner = order.corner as u8;
    // Distances from the corner along the lines and across.
    let seen = |cell: Cell| {
        let (x, y) = region.xy(cell);
        let x = if corner & 1 == 0 { x } else { region.width() - 1 - x };
        let y = if corner & 2 == 0 { y } else { region.height() - 1 - y };
        if order.axis == Axis::X { (x, y) } else { (y, x) }
    };
    let mut rows: BTreeMap<u32, BTreeMap<u32, Cell>> = BTreeMap::new();
    for cell in region.cells() {
        let (u, v) = seen(cell);
        rows.entry(v).or_default().insert(u, cell);
    }
    let rows: Vec<_> = rows.into_values().collect();
    let distance = |a: Cell, b: Cell| {
        let ((ax, ay), (bx, by)) = (seen(a), seen(b));
        f64::from(ax.abs_diff(bx)).hypot(f64::from(ay.abs_diff(by)))
    };
    let mut cells: Vec<Cell> = Vec::new();
    for row in slow_sequence(order.sequence, rows.len()) {
        let mut runs: Vec<Vec<Cell>> = Vec::new();
        for (&u, &cell) in &rows[row] {
            match u.checked_sub(1).filter(|u| rows[row].contains_key(u)) {
                Some(_) => runs.last_mut().unwrap().push(cell),
                None => runs.push(vec![cell]),
            }
        }
        let is_nearer = |to: Cell, than: Cell, cells: &[Cell]| {
            cells.last().is_some_and(|&nozzle| distance(nozzle, to) < distance(nozzle, than))
        };
        let (first, last) = (runs[0][0], *runs.last().unwrap().last().unwrap());
        if is_nearer(last, first, &cells) {
            runs.reverse();
        }
        for mut run in runs {
            if is_nearer(*run.last().unwrap(), run[0], &cells) {
                run.reverse();
            }
            cells.extend(run);
        }
    }
    cells
}

fn is_permutation(order: &[Cell], region: &Region) -> bool {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    sorted == region.cells().collect::<Vec<_>>()
}

fn any_sequence() -> impl Strategy<Value = Sequence> {
    prop_oneof![
        Just(Sequence::Sequential),
        Just(Sequence::Golden),
        Just(Sequence::BitReversed),
        (1..=12_u32).prop_map(|k| Sequence::Interleaved(stride(k))),
        (1..=12_u32).prop_map(|k| Sequence::Scattered(stride(k))),
        (1..=Stride::MAX).prop_map(|k| Sequence::Interleaved(stride(k))),
        (1..=Stride::MAX).prop_map(|k| Sequence::Scattered(stride(k))),
    ]
}

/// Random masks with holes and islands, and common shapes.
fn any_region() -> impl Strategy<Value = Region> {
    let mask = (1..=12_u32, 1..=12_u32, 1..=10_u8).prop_flat_map(|(width, height, share)| {
        let cells = prop::collection::vec(0..10_u8, (width * height) as usize);
        cells.prop_map(move |cells| {
            let mut mask: Vec<bool> = cells.into_iter().map(|cell| cell < share).collect();
            mask[0] |= mask.iter().all(|&cell| !cell);
            Region::from_mask(width, height, mask).unwrap()
        })
    });
    let shape = (0..RegionShape::ALL.len(), 8..=20_u32, 8..=20_u32, any::<u64>());
    let shape = shape.prop_map(|(shape, width, height, seed)| {
        RegionShape::ALL[shape]
            .region(width, height, seed)
            .unwrap_or(Region::rectangle(width, height).unwrap())
    });
    prop_oneof![3 => mask, 1 => shape]
}

/// The image of a region, and a function from cells of the image back to those of the region.
fn image(
    region: &Region,
    [flip_x, flip_y, transpose]: [bool; 3],
) -> (Region, impl Fn(Cell) -> Cell) {
    let (width, height) = (region.width(), region.height());
    let (new_width, new_height) = if transpose { (height, width) } else { (width, height) };
    let back = move |cell: Cell| {
        let (x, y) = (cell % new_width, cell / new_width);
        let (x, y) = if transpose { (y, x) } else { (x, y) };
        let x = if flip_x { width - 1 - x } else { x };
        let y = if flip_y { height - 1 - y } else { y };
        y * width + x
    };
    let mask = (0..new_width * new_height).map(|cell| region.contains(back(cell))).collect();
    (Region::from_mask(new_width, new_height, mask).unwrap(), back)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_sequence_is_a_permutation(sequence in any_sequence(), n in 0..5000_usize) {
        let mut order = sequence.order(n);
        order.sort_unstable();
        prop_assert_eq!(order, (0..n).collect::<Vec<_>>());
    }

    #[test]
    fn orders_are_those_of_the_slow_implementation(
        region in any_region(),
        sequence in any_sequence(),
    ) {
        for order in LineOrder::all_of(sequence) {
            let cells = order.order(&region);
            prop_assert!(is_permutation(&cells, &region), "{}", order);
            prop_assert_eq!(cells, slow_order(order, &region), "{}", order);
        }
    }

    #[test]
    fn other_corners_and_axes_are_images(region in any_region(), sequence in any_sequence()) {
        let first = LineOrder::all_of(sequence)[0];
        for order in LineOrder::all_of(sequence) {
            let corner = order.corner as u8;
            let flips = [corner & 1 != 0, corner & 2 != 0, order.axis == Axis::Y];
            let (image, back) = image(&region, flips);
            let cells: Vec<Cell> = first.order(&image).into_iter().map(back).collect();
            prop_assert_eq!(cells, order.order(&region), "{}", order);
        }
    }

    #[test]
    fn lines_are_maximal_runs(region in any_region(), corner in 0..4_usize, axis in 0..2_usize) {
        let (axis, corner) = (Axis::ALL[axis], Corner::ALL[corner]);
        let lines = LineOrder { sequence: Sequence::Golden, axis, corner }.lines(&region);
        let across = |cell: Cell| {
            let (x, y) = region.xy(cell);
            if axis == Axis::X { y } else { x }
        };
        let is_joined = |a: Cell, b: Cell| region.adjacent(a, b) && across(a) == across(b);
        for line in lines.iter() {
            prop_assert!(line.windows(2).all(|pair| is_joined(pair[0], pair[1])));
        }
        let ends: Vec<Cell> =
            lines.iter().flat_map(|line| [line[0], line[line.len() - 1]]).collect();
        for (index, &a) in ends.iter().enumerate() {
            prop_assert!(ends.iter().skip(index + 1).all(|&b| index % 2 == 0 || !is_joined(a, b)));
        }
        let cells: Vec<Cell> = lines.iter().flatten().copied().collect();
        prop_assert!(is_permutation(&cells, &region));
        // The rows contain all lines, row by row.
        let rows = (0..lines.row_count()).map(|row| lines.row(row));
        prop_assert!(rows.clone().flatten().eq(0..lines.len()));
        for row in rows {
            let row: BTreeSet<u32> =
                row.flat_map(|line| lines.line(line)).map(|&cell| across(cell)).collect();
            prop_assert_eq!(row.len(), 1);
        }
    }

    #[test]
    fn any_permutation_of_lines_is_an_order(
        region in any_region(),
        keys in prop::collection::vec(any::<u64>(), 144..200),
        number in 0..8_usize,
        cut in any::<prop::sample::Index>(),
        from in any::<prop::sample::Index>(),
    ) {
        let order = LineOrder::all_of(Sequence::Sequential)[number];
        let lines = order.lines(&region);
        let mut permutation: Vec<usize> = (0..lines.len()).collect();
        permutation.sort_by_key(|&line| keys[line % keys.len()]);
        let from = Some(from.index(region.grid_len()) as Cell);
        for ends in [Ends::Fixed, Ends::Nearest { from: None }, Ends::Nearest { from }] {
            let cells = lines.order(&permutation, ends).unwrap();
            prop_assert!(is_permutation(&cells, &region));
            // Cells of a line stay together.
            let mut at = 0;
            let mut nozzle = match ends {
                Ends::Nearest { from } => from,
                Ends::Fixed => None,
            };
            for &line in &permutation {
                let line = lines.line(line);
                let printed = &cells[at..at + line.len()];
                let reversed: Vec<Cell> = line.iter().rev().copied().collect();
                prop_assert!(printed == line || printed == reversed);
                if ends == Ends::Fixed {
                    prop_assert_eq!(printed, line);
                }
                if let Some(nozzle) = nozzle {
                    let distance = |cell: Cell| {
                        let ((ax, ay), (bx, by)) = (region.xy(nozzle), region.xy(cell));
                        ax.abs_diff(bx).pow(2) + ay.abs_diff(by).pow(2)
                    };
                    let last = printed[printed.len() - 1];
                    prop_assert!(distance(printed[0]) <= distance(last));
                }
                at += line.len();
                nozzle = (ends != Ends::Fixed).then(|| cells[at - 1]);
            }
            // In two parts, the cells are the same.
            let (begin, end) = permutation.split_at(cut.index(permutation.len()));
            let mut parts = lines.flatten(begin, ends);
            let between = match (ends, parts.last()) {
                (Ends::Nearest { .. }, Some(&last)) => Ends::Nearest { from: Some(last) },
                _ => ends,
            };
            parts.extend(lines.flatten(end, between));
            prop_assert_eq!(parts, cells);
        }
    }

    #[test]
    fn rectangles_have_travel_across_lines_only(
        width in 1..30_u32,
        height in 1..30_u32,
        sequence in any_sequence(),
    ) {
        let region = Region::rectangle(width, height).unwrap();
        for order in LineOrder::all_of(sequence) {
            for step in order.order(&region).windows(2) {
                let ((ax, ay), (bx, by)) = (region.xy(step[0]), region.xy(step[1]));
                prop_assert!(ax == bx || ay == by, "{}", order);
            }
        }
    }

    #[test]
    fn names_parse(sequence in any_sequence(), text in "[a-z0-9-]{0,24}") {
        prop_assert_eq!(sequence.to_string().parse(), Ok(sequence));
        for order in LineOrder::all_of(sequence) {
            prop_assert_eq!(order.to_string().parse(), Ok(order));
            prop_assert_eq!(order.to_string().parse(), Ok(Order::from(order)));
        }
        // Whatever parses is the name of what it parses to.
        for name in [text.clone(), format!("lines-x-{text}-0"), format!("scattered-{text}")] {
            if let Ok(order) = name.parse::<Order>() {
                prop_assert_eq!(order.to_string(), name.clone());
            }
            if let Ok(sequence) = name.parse::<Sequence>() {
                prop_assert_eq!(sequence.to_string(), name);
            }
        }
    }
}

#[test]
fn sequential_lines_are_zigzags() {
    let region = Region::rectangle(7, 5).unwrap();
    for order in LineOrder::all_of(Sequence::Sequential) {
        let zigzag: Pattern = format!("zigzag-{}-{}", order.axis, order.corner).parse().unwrap();
        assert_eq!(order.order(&region), zigzag.order(&region), "{order}");
    }
}

#[test]
fn orders_begin_in_their_corner() {
    let region = Region::rectangle(7, 5).unwrap();
    for sequence in sequences(1..=9) {
        for order in LineOrder::all_of(sequence) {
            assert_eq!(order.order(&region)[0], [0, 6, 28, 34][order.corner as usize], "{order}");
        }
    }
}

#[test]
fn rows_without_cells_are_not_counted() {
    // Two islands with empty rows around and between them.
    let mut mask = vec![false; 4 * 9];
    for row in [1, 2, 6, 7] {
        mask[4 * row + 1..4 * row + 3].fill(true);
    }
    let region = Region::from_mask(4, 9, mask).unwrap();
    let order: LineOrder = "lines-x-interleaved-2-0".parse().unwrap();
    assert_eq!(order.order(&region), [5, 6, 26, 25, 9, 10, 30, 29]);
    assert_eq!(order.lines(&region).row_count(), 4);
}

#[test]
fn lists_that_are_not_permutations_are_refused() {
    let region = Region::rectangle(2, 3).unwrap();
    let lines = LineOrder::all_of(Sequence::Golden)[0].lines(&region);
    let error = |list: &[usize]| lines.order(list, Ends::Fixed).unwrap_err();
    assert_eq!(error(&[]), PermutationError::Count { expected: 3, got: 0 });
    assert_eq!(error(&[0, 1, 2, 0]), PermutationError::Count { expected: 3, got: 4 });
    assert_eq!(error(&[0, 3, 1]), PermutationError::Range { line: 3, lines: 3 });
    assert_eq!(error(&[0, 2, 2]), PermutationError::Repeated(2));
    assert_eq!(error(&[0, 1]).to_string(), "permutation has 2 numbers, the layer has 3 lines");
    assert_eq!(
        error(&[0, 3, 1]).to_string(),
        "permutation contains line 3, expected numbers below 3"
    );
}

#[test]
fn errors_say_what_is_allowed() {
    let sequence = |name: &str| name.parse::<Sequence>().unwrap_err().to_string();
    for name in ["scattered", "scattered-", "scattered-0", "scattered-4097", "scattered-x"] {
        assert_eq!(
            sequence(name),
            format!(
                "invalid sequence '{name}': expected scattered-K with a stride K from 1 to 4096, \
                 such as scattered-7"
            )
        );
    }
    for name in ["interleaved-07", "interleaved-+7", "interleaved--7", "interleaved-7 "] {
        assert!(sequence(name).starts_with("invalid sequence 'interleaved-"), "{name}");
    }
    for name in ["", "Golden", "golden-3", "random"] {
        assert!(sequence(name).starts_with(&format!("unknown sequence '{name}': expected ")));
    }
    assert_eq!(Stride::new(0).unwrap_err().to_string(), "invalid stride 0: expected 1 to 4096");
    assert_eq!(Stride::new(4097), Err(InvalidStride(4097)));

    let order = |name: &str| name.parse::<Order>().unwrap_err().to_string();
    for name in ["lines", "lines-", "lines-x", "lines-z-golden-0", "lines-x-golden-4", "lines-x-0"]
    {
        assert!(order(name).starts_with(&format!("unknown order of lines '{name}': ")), "{name}");
    }
    assert_eq!(
        order("lines-x-scattered-3"),
        "order of lines 'lines-x-scattered-3': invalid sequence 'scattered': expected scattered-K \
         with a stride K from 1 to 4096, such as scattered-7"
    );
    assert!(order("knots").starts_with("unknown pattern 'knots': expected a name like zigzag-x-0"));
    assert!(order("knots").ends_with(", or lines such as lines-x-scattered-7-0"));
}

#[test]
fn patterns_are_orders() {
    let region = Region::rectangle(7, 5).unwrap();
    for pattern in Pattern::ALL {
        let order: Order = pattern.name().parse().unwrap();
        assert_eq!(order, Order::Pattern(pattern));
        assert_eq!(order.to_string(), pattern.name());
        assert_eq!(order.order(&region), pattern.order(&region));
    }
    assert_eq!(Order::CONVENTIONAL.to_string(), "contour-zigzag-x-0");
}
