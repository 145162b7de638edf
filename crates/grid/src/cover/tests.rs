//! Compares covers and their bound with an exhaustive search on small regions, and runs them on
//! regions like those of parts.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{CancelToken, Progress};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::{Cell, Start, StartError};

/// The minimum number of paths that cover all cells, found by trying every set of links with at
/// most two at each cell.
fn fewest_pieces(region: &Region) -> u32 {
    let cells: Vec<Cell> = region.cells().collect();
    let index = |cell: Cell| cells.binary_search(&cell).unwrap();
    let links: Vec<(usize, usize)> = cells
        .iter()
        .flat_map(|&cell| {
            region
                .neighbours(cell)
                .filter(move |&other| other > cell)
                .map(move |other| (cell, other))
        })
        .map(|(a, b)| (index(a), index(b)))
        .collect();
    let mut max = 0;
    grow(&links, &mut vec![0; cells.len()], (0..cells.len()).collect(), 0, &mut max);
    cells.len() as u32 - max
}

/// Tries each link in turn, with and without it; a link between two cells of one path would close a
/// cycle and is left out.
fn grow(
    links: &[(usize, usize)],
    degree: &mut [u8],
    strand: Vec<usize>,
    taken: u32,
    max: &mut u32,
) {
    *max = taken.max(*max);
    let Some((&(a, b), rest)) = links.split_first() else { return };
    if taken + links.len() as u32 <= *max {
        return;
    }
    if degree[a] < 2 && degree[b] < 2 && strand[a] != strand[b] {
        let joined = strand
            .iter()
            .map(|&number| if number == strand[b] { strand[a] } else { number })
            .collect();
        degree[a] += 1;
        degree[b] += 1;
        grow(rest, degree, joined, taken + 1, max);
        degree[a] -= 1;
        degree[b] -= 1;
    }
    grow(rest, degree, strand, taken, max);
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

/// A region without a Hamiltonian path, so that `cover` does all its steps.
fn plus() -> Region {
    let inside = [false, true, false, true, true, true, false, true, false];
    Region::from_mask(3, 3, inside.to_vec()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn covers_of_small_regions_are_minimum(
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
    fn rotations_and_extensions_keep_every_cell(seed: u64, steps in 0_usize..300) {
        let region = mask(9, 8, |x, y| x.abs() > 1.0 || y.abs() > 1.0);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut all = Pieces::new(&region, region.cells().map(|cell| vec![cell]).collect());
        for _ in 0..steps {
            let piece = rng.random_range(0..all.pieces.len());
            let end = *all.pieces[piece].last().unwrap();
            let neighbours: Vec<Cell> = region.neighbours(end).collect();
            all.link(piece, neighbours[rng.random_range(0..neighbours.len())]);
            for (number, piece) in (0..).zip(&all.pieces) {
                prop_assert!(piece.windows(2).all(|step| region.adjacent(step[0], step[1])));
                for (index, &cell) in (0..).zip(piece) {
                    prop_assert_eq!(all.home[cell as usize], (number, index));
                }
            }
        }
        let pieces = all.pieces.len() as u32;
        prop_assert!(Path::in_pieces(&region, all.into_order()).unwrap().pieces() <= pieces);
    }
}

#[test]
fn the_bound_counts_components_and_colours() {
    assert_eq!(bound(&Region::rectangle(5, 5).unwrap()), 1);
    assert_eq!(bound(&plus()), 3);
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

#[test]
fn cancelled_calls_return_an_error() {
    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    assert_eq!(cover(&plus(), &control), Err(Interrupted::Cancelled));
    assert_eq!(piece_bound(&plus(), &control), Err(Interrupted::Cancelled));
    let error = Start::Cover.path(&plus(), &control);
    assert_eq!(error, Err(StartError::Interrupted(Interrupted::Cancelled)));
}

#[test]
fn random_search_ends_when_the_time_is_up() {
    // No cover has 0 pieces, so only the time limit ends the search.
    let region = mask(40, 40, |x, y| x.hypot(y) < 20.0);
    let polls = AtomicUsize::new(0);
    let time_is_up = || polls.fetch_add(1, Ordering::Relaxed) == 3;
    let control = Control { time_is_up: Some(&time_is_up), ..Control::default() };
    let mut pieces = Pieces::new(&region, region.cells().map(|cell| vec![cell]).collect());
    assert_eq!(pieces.wander(&region, 0, &control), Err(Interrupted::TimeUp));
    assert_eq!(polls.load(Ordering::Relaxed), 4);
}

#[test]
fn progress_rises_to_the_total() {
    let reports = Mutex::new(Vec::new());
    let observe = |progress: Progress| reports.lock().unwrap().push(progress);
    let control = Control { progress: Some(&observe), ..Control::default() };
    let region = mask(30, 30, |x, y| (5.0..15.0).contains(&x.hypot(y)));
    piece_bound(&region, &control).unwrap();
    let bound_reports = std::mem::take(&mut *reports.lock().unwrap());
    cover(&region, &control).unwrap();
    for reports in [bound_reports, reports.into_inner().unwrap()] {
        assert!(reports.is_sorted_by_key(|report| report.done));
        assert!(reports.iter().all(|report| report.total == reports[0].total));
        assert!(reports.last().is_some_and(|report| report.done == report.total));
    }
}
