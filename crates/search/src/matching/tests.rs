//! 2-matchings are checked by their dual certificate: if no residual arc has a negative reduced
//! cost, they are optimal.

use beadwork_grid::{Layout, LayoutSpec, Region, RegionShape};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::CostMatrix;

fn boards() -> impl Iterator<Item = Board> {
    (0..200_u64).flat_map(|seed| {
        let side = 3 + (seed % 17) as u32;
        let region = match RegionShape::ALL.get(seed as usize % 9) {
            Some(shape) if side > 6 => shape.region(side, side + 1, seed).unwrap(),
            _ => Region::rectangle(side, side + 2).unwrap(),
        };
        let layout = [Layout::Voronoi, Layout::Checkerboard, Layout::Stripes][seed as usize % 3];
        let zones = LayoutSpec { layout, zones: 4, side: 2 }.zones(&region, seed).unwrap();
        let costs = if seed % 2 == 0 {
            CostMatrix::uniform(zones.count() as usize)
        } else {
            let count = zones.count() as usize;
            CostMatrix::from_fn(count, |a, b| ((a * count + b) * 7 % 5) as f64).unwrap()
        };
        Board::of_components(&region, &zones, &costs)
    })
}

/// Checks that links, room and capacity agree, and that the potentials prove the 2-matching to be
/// the cheapest of its size.
fn check(matching: &TwoMatching<'_>, context: &str) {
    let board = matching.board;
    let mut total_room = 0;
    for &node in &board.cells {
        let links = matching.links[node as usize];
        let room = matching.room[node as usize];
        assert_eq!(
            links.count_ones() + u32::from(room),
            u32::from(matching.capacity[node as usize]),
            "{context}"
        );
        total_room += u32::from(room);
        for dir in dirs(links) {
            assert!(
                matching.is_linked(board.neighbour(node, dir), opposite(dir)),
                "{context}: a link is stored at one end only"
            );
        }
        // A cell with links can have one less, a cell with room one more.
        let release_cost = matching.release_cost(node);
        assert!(!matching.has_links(node) || release_cost >= 0, "{context}: {release_cost}");
        assert!(room == 0 || release_cost <= 0, "{context}: {release_cost}");
        if Board::is_black(node) {
            for dir in dirs(board.neighbours[node as usize] & !matching.locked[node as usize]) {
                let reduced = matching.reduced_cost(node, dir);
                assert!(
                    if matching.is_linked(node, dir) { reduced <= 0 } else { reduced >= 0 },
                    "{context}: {reduced}"
                );
            }
        }
    }
    assert_eq!(total_room, matching.total_room, "{context}");
}

fn grown(board: &Board, seed: u64) -> TwoMatching<'_> {
    let layout = LadderLayout { along: seed as Dir % 2, odd: seed % 4 > 1 };
    let mut matching = TwoMatching::inside_zones(board, layout);
    matching.remove_links_inside(2, |count| seed as usize % count);
    matching.grow(2);
    matching
}

#[test]
fn grown_matchings_are_cheapest() {
    for (seed, board) in (0..).zip(boards()) {
        let matching = grown(&board, seed);
        check(&matching, &format!("board {seed}"));
        let others = grown(&board, seed + 1);
        assert_eq!(
            (matching.cost(), matching.total_room),
            (others.cost(), others.total_room),
            "optima do not depend on the ladders"
        );
    }
}

#[test]
fn matchings_stay_cheapest_when_links_are_inserted() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for (seed, board) in (0..).zip(boards()).filter(|(_, board)| board.cells.len() > 3) {
        let mut matching = grown(&board, seed);
        let mut paths = ShortestPaths::new(&board);
        for _ in 0..6 {
            let node = board.cells[(rng.next_u64() % board.cells.len() as u64) as usize];
            let free = board.neighbours[node as usize] & !matching.links[node as usize];
            let Some(dir) = dirs(free).next().filter(|_| Board::is_black(node)) else { continue };
            let before = (matching.links.clone(), matching.room.clone(), matching.cost());
            let Some(cost) = paths.insertion_cost(&matching, node, dir, 1000) else { continue };
            assert!(
                paths.insertion_cost(&matching, node, dir, cost).is_none(),
                "not below its own cost"
            );
            paths.insertion_cost(&matching, node, dir, 1000);
            paths.insert(&mut matching, node, dir);
            assert_eq!(matching.cost(), before.2 + i64::from(cost));
            if cost == 0 {
                paths.undo_insertion(&mut matching, node, dir);
                assert_eq!((&matching.links, &matching.room), (&before.0, &before.1));
                paths.insertion_cost(&matching, node, dir, 1000);
                paths.insert(&mut matching, node, dir);
            }
            matching.lock(node, dir);
            check(&matching, &format!("board {seed}"));
        }
    }
}

#[test]
fn reserved_ends_are_the_cheapest() {
    for (seed, board) in (0..).zip(boards()).filter(|(_, board)| board.cells.len() > 3) {
        let matching = grown(&board, seed);
        let mut paths = ShortestPaths::new(&board);
        let single: Vec<Option<i32>> = board
            .cells
            .iter()
            .map(|&cell| {
                let mut matching = matching.clone();
                let cost = paths.reserve_end(&mut matching, &[cell]).map(|(cost, _)| cost);
                check(&matching, &format!("board {seed}, cell {cell}"));
                assert_eq!(matching.capacity[cell as usize] == 1, cost.is_some());
                cost
            })
            .collect();
        let mut any = matching.clone();
        let min = paths.reserve_end(&mut any, &board.cells).map(|(cost, _)| cost);
        assert_eq!(min, single.into_iter().flatten().min(), "board {seed}");
    }
}

#[test]
fn restored_matchings_are_cheapest() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    for (seed, board) in (0..).zip(boards()) {
        let mut matching = grown(&board, seed);
        let total_room = matching.total_room;
        let mut paths = ShortestPaths::new(&board);
        for _ in 0..4 {
            let set: Vec<Node> =
                board.cells.iter().copied().filter(|_| rng.next_u64().is_multiple_of(3)).collect();
            matching.add_surcharge(&set, 1 + (rng.next_u64() % 3) as i32);
            paths.restore_optimum(&mut matching);
            check(&matching, &format!("board {seed}"));
            assert_eq!(matching.total_room, total_room);
        }
    }
}
