//! Optima are judged by their certificate: no residual step of negative reduced cost means that
//! nothing is cheaper.

use beadwork_grid::{Layout, LayoutSpec, Region, RegionShape};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::board::{back, dirs};
use super::*;
use crate::ZoneCosts;

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
            ZoneCosts::uniform(zones.count())
        } else {
            let count = zones.count() as usize;
            let cost =
                |pair: usize| if pair / count == pair % count { 0 } else { (pair * 7 % 5) as u32 };
            ZoneCosts::new(zones.count(), (0..count * count).map(cost).collect()).unwrap()
        };
        Board::of_components(&region, &zones, &costs)
    })
}

/// Degrees, room and both ends of each link agree, and the potentials prove that nothing of its
/// size is cheaper.
fn judge(matching: &Matching<'_>, what: &str) {
    let board = matching.board;
    let mut spare = 0;
    for &node in &board.cells {
        let links = matching.links[node as usize];
        let room = matching.room[node as usize];
        assert_eq!(
            links.count_ones() + u32::from(room),
            u32::from(matching.capacity[node as usize]),
            "{what}"
        );
        spare += u32::from(room);
        for dir in dirs(links) {
            assert!(
                matching.is_linked(board.step(node, dir), back(dir)),
                "{what}: a link has one end"
            );
        }
        let potential = matching.potential[node as usize];
        // What a cell draws or drains it may give back, and with room it may draw or drain more.
        let (back, more) = if Board::is_black(node) {
            (potential - matching.source, matching.source - potential)
        } else {
            (matching.sink - potential, potential - matching.sink)
        };
        assert!(matching.capacity[node as usize] == room || back >= 0, "{what}: {back}");
        assert!(room == 0 || more >= 0, "{what}: {more}");
        if Board::is_black(node) {
            for dir in dirs(board.neighbours[node as usize] & !matching.locked[node as usize]) {
                let reduced = matching.reduced(node, dir);
                assert!(
                    if matching.is_linked(node, dir) { reduced <= 0 } else { reduced >= 0 },
                    "{what}: {reduced}"
                );
            }
        }
    }
    assert_eq!(spare, matching.spare, "{what}");
}

fn grown(board: &Board, seed: u64) -> Matching<'_> {
    let grain = Grain { along: seed as Dir % 2, odd: seed % 4 > 1 };
    let mut matching = Matching::inside_zones(board, grain);
    matching.drop_links_inside(2, |count| seed as usize % count);
    matching.grow(2);
    matching
}

#[test]
fn grown_matchings_are_cheapest() {
    for (seed, board) in (0..).zip(boards()) {
        let matching = grown(&board, seed);
        judge(&matching, &format!("board {seed}"));
        let others = grown(&board, seed + 1);
        assert_eq!(
            (matching.cost(), matching.spare),
            (others.cost(), others.spare),
            "whatever they begin with"
        );
    }
}

#[test]
fn links_put_in_keep_the_rest_cheapest() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for (seed, board) in (0..).zip(boards()).filter(|(_, board)| board.cells.len() > 3) {
        let mut matching = grown(&board, seed);
        let mut paths = Paths::new(&board);
        for _ in 0..6 {
            let node = board.cells[(rng.next_u64() % board.cells.len() as u64) as usize];
            let free = board.neighbours[node as usize] & !matching.links[node as usize];
            let Some(dir) = dirs(free).next().filter(|_| Board::is_black(node)) else { continue };
            let before = (matching.links.clone(), matching.room.clone(), matching.cost());
            let Some(cost) = paths.cost_of_link(&matching, node, dir, 1000) else { continue };
            assert!(
                paths.cost_of_link(&matching, node, dir, cost).is_none(),
                "not below its own cost"
            );
            paths.cost_of_link(&matching, node, dir, 1000);
            paths.put_in(&mut matching, node, dir);
            assert_eq!(matching.cost(), before.2 + i64::from(cost));
            if cost == 0 {
                paths.undo(&mut matching, node, dir);
                assert_eq!((&matching.links, &matching.room), (&before.0, &before.1));
                paths.cost_of_link(&matching, node, dir, 1000);
                paths.put_in(&mut matching, node, dir);
            }
            matching.lock(node, dir);
            judge(&matching, &format!("board {seed}"));
        }
    }
}

#[test]
fn reserved_room_is_the_cheapest() {
    for (seed, board) in (0..).zip(boards()).filter(|(_, board)| board.cells.len() > 3) {
        let matching = grown(&board, seed);
        let mut paths = Paths::new(&board);
        let single: Vec<Option<i32>> = board
            .cells
            .iter()
            .map(|&cell| {
                let mut matching = matching.clone();
                let cost = paths.reserve(&mut matching, &[cell]).map(|(cost, _)| cost);
                judge(&matching, &format!("board {seed}, cell {cell}"));
                assert_eq!(matching.capacity[cell as usize] == 1, cost.is_some());
                cost
            })
            .collect();
        let mut any = matching.clone();
        let least = paths.reserve(&mut any, &board.cells).map(|(cost, _)| cost);
        assert_eq!(least, single.into_iter().flatten().min(), "board {seed}");
    }
}

#[test]
fn repaired_matchings_are_cheapest() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    for (seed, board) in (0..).zip(boards()) {
        let mut matching = grown(&board, seed);
        let spare = matching.spare;
        let mut paths = Paths::new(&board);
        for _ in 0..4 {
            let set: Vec<Node> =
                board.cells.iter().copied().filter(|_| rng.next_u64().is_multiple_of(3)).collect();
            matching.raise_inside(&set, 1 + (rng.next_u64() % 3) as i32);
            paths.repair(&mut matching);
            judge(&matching, &format!("board {seed}"));
            assert_eq!(matching.spare, spare);
        }
    }
}
