//! Covers and their bound against exhaustive search on small regions, and on shapes like parts.

use proptest::prelude::*;

use super::*;

/// The fewest paths that cover all cells, found by trying every set of links with at most two at
/// each cell.
fn fewest_pieces(region: &Region) -> u32 {
    let cells: Vec<Cell> = region.cells().collect();
    let place = |cell: Cell| cells.binary_search(&cell).unwrap();
    let links: Vec<(usize, usize)> = cells
        .iter()
        .flat_map(|&cell| {
            region
                .neighbours(cell)
                .filter(move |&other| other > cell)
                .map(move |other| (cell, other))
        })
        .map(|(a, b)| (place(a), place(b)))
        .collect();
    let mut most = 0;
    grow(&links, &mut vec![0; cells.len()], (0..cells.len()).collect(), 0, &mut most);
    cells.len() as u32 - most
}

/// Takes or leaves each link in turn; links within one path would close a cycle.
fn grow(
    links: &[(usize, usize)],
    degree: &mut [u8],
    strand: Vec<usize>,
    taken: u32,
    most: &mut u32,
) {
    *most = taken.max(*most);
    let Some((&(a, b), rest)) = links.split_first() else { return };
    if taken + links.len() as u32 <= *most {
        return;
    }
    if degree[a] < 2 && degree[b] < 2 && strand[a] != strand[b] {
        let joined =
            strand.iter().map(|&it| if it == strand[b] { strand[a] } else { it }).collect();
        degree[a] += 1;
        degree[b] += 1;
        grow(rest, degree, joined, taken + 1, most);
        degree[a] -= 1;
        degree[b] -= 1;
    }
    grow(rest, degree, strand, taken, most);
}

fn pieces(region: &Region) -> u32 {
    cover(region, &Control::default()).unwrap().pieces()
}

fn bound(region: &Region) -> u32 {
    piece_bound(region, &Control::default()).unwrap()
}

fn mask(width: u32, height: u32, inside: impl Fn(f64, f64) -> bool) -> Region {
    let centre = |at: u32, side: u32| f64::from(at) + 0.5 - f64::from(side) / 2.0;
    let cells = (0..width * height)
        .map(|cell| inside(centre(cell % width, width), centre(cell / width, height)));
    Region::from_mask(width, height, cells.collect()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn small_covers_are_the_smallest(
        width in 1_u32..6,
        inside in prop::collection::vec(prop::bool::weighted(0.8), 1..17),
    ) {
        let height = (inside.len() as u32).div_ceil(width);
        let mut inside = inside;
        inside.resize((width * height) as usize, false);
        let Ok(region) = Region::from_mask(width, height, inside) else { return Ok(()) };
        let fewest = fewest_pieces(&region);
        prop_assert!(bound(&region) <= fewest);
        prop_assert_eq!(pieces(&region), fewest);
    }

    #[test]
    fn rotation_alone_keeps_every_cell(seed: u64, steps in 0_usize..300) {
        let region = mask(9, 8, |x, y| x.abs() > 1.0 || y.abs() > 1.0);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut ends = Ends::new(&region, region.cells().map(|cell| vec![cell]).collect());
        for _ in 0..steps {
            let piece = rng.random_range(0..ends.pieces.len());
            let end = *ends.pieces[piece].last().unwrap();
            let neighbours: Vec<Cell> = region.neighbours(end).collect();
            ends.extend(piece, neighbours[rng.random_range(0..neighbours.len())]);
            for (number, piece) in (0..).zip(&ends.pieces) {
                prop_assert!(piece.windows(2).all(|step| region.adjacent(step[0], step[1])));
                prop_assert!((0..).zip(piece).all(|(index, &cell)| ends.home[cell as usize] == (number, index)));
            }
        }
        let pieces = ends.pieces.len() as u32;
        prop_assert!(Path::in_pieces(&region, ends.into_order()).unwrap().pieces() <= pieces);
    }
}

#[test]
fn the_bound_counts_components_and_colours() {
    assert_eq!(bound(&Region::rectangle(5, 5).unwrap()), 1);
    let plus = [false, true, false, true, true, true, false, true, false];
    assert_eq!(bound(&Region::from_mask(3, 3, plus.to_vec()).unwrap()), 3);
    let corners = [true, false, true, false, false, false, true, false, true];
    assert_eq!(bound(&Region::from_mask(3, 3, corners.to_vec()).unwrap()), 4);
}

#[test]
fn parts_need_few_pieces() {
    let shapes: [(&str, Region); 5] = [
        ("disc", mask(60, 60, |x, y| x.hypot(y) < 30.0)),
        ("ring", mask(60, 60, |x, y| (12.0..30.0).contains(&x.hypot(y)))),
        (
            "rotated square",
            mask(60, 60, |x, y| {
                (0.8 * x + 0.6 * y).abs() < 20.0 && (0.6 * x - 0.8 * y).abs() < 20.0
            }),
        ),
        ("star", mask(60, 60, |x, y| x.hypot(y) < 20.0 + 8.0 * (5.0 * y.atan2(x)).cos())),
        ("two discs", mask(90, 50, |x, y| (x.abs() - 22.0).hypot(y) < 21.0)),
    ];
    for (name, region) in shapes {
        let (pieces, bound) = (pieces(&region), bound(&region));
        assert!((bound..=bound + 1).contains(&pieces), "{name}: {pieces} pieces, bound {bound}");
    }
}

#[test]
fn thin_regions() {
    assert_eq!(pieces(&Region::rectangle(1, 9).unwrap()), 1);
    let column = Region::from_mask(1, 5, vec![true, true, false, true, true]).unwrap();
    assert_eq!((pieces(&column), bound(&column)), (2, 2));
    assert_eq!(pieces(&Region::from_mask(2, 2, vec![true, false, false, true]).unwrap()), 2);
}
