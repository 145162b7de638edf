//! Compares the exact search with an integer program, on layers too large for brute force.
//!
//! Run it by hand, as it needs cmake, a C++ compiler and libclang to build HiGHS, and takes
//! minutes:
//! ```text
//! cargo test --release -p beadwork-search --features integer-program --test integer_program \
//!     -- --nocapture
//! ```

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
#![allow(clippy::print_stdout, reason = "the test is run by hand, to read its output")]

use std::collections::BTreeMap;

use beadwork_base::Control;
use beadwork_grid::{Cell, Layout, LayoutSpec, Region, RegionShape, Zones, verify};
use beadwork_search::exact::{Settings, solve};
use good_lp::{
    Expression, Solution, SolverModel, Variable, constraint, highs, variable, variables,
};

/// The integer program of a layer: a binary variable for each link, at most two links at each cell.
struct Program<'a> {
    region: &'a Region,
    zones: &'a Zones,
    links: Vec<[Cell; 2]>,
    /// Sets of cells that solutions so far closed by cycles: each must contain fewer links than
    /// cells.
    closed: Vec<Vec<Cell>>,
}

impl<'a> Program<'a> {
    fn new(region: &'a Region, zones: &'a Zones) -> Self {
        let neighbours = |cell: Cell| region.neighbours(cell).filter(move |&other| other > cell);
        let links = region
            .cells()
            .flat_map(|cell| neighbours(cell).map(move |other| [cell, other]))
            .collect();
        Self { region, zones, links, closed: Vec::new() }
    }

    /// The minimum number of crossings of `count` links without the cycles found so far, and the
    /// links; `None` if there is no such set of links.
    fn solve(&self, count: u32) -> Option<(u32, Vec<[Cell; 2]>)> {
        let mut variables = variables!();
        let taken: Vec<Variable> =
            self.links.iter().map(|_| variables.add(variable().binary())).collect();
        let is_crossing = |&[a, b]: &[Cell; 2]| self.zones.id(a) != self.zones.id(b);
        let count_of = |choose: &dyn Fn(&[Cell; 2]) -> bool| -> Expression {
            self.links
                .iter()
                .zip(&taken)
                .filter(|(link, _)| choose(link))
                .map(|(_, &taken)| taken)
                .sum()
        };
        let mut problem = variables.minimise(count_of(&is_crossing)).using(highs);
        problem.set_verbose(false);
        problem = problem.with(constraint!(count_of(&|_| true) == f64::from(count)));
        for cell in self.region.cells() {
            problem = problem.with(constraint!(count_of(&|link| link.contains(&cell)) <= 2));
        }
        for set in &self.closed {
            let inside = count_of(&|[a, b]| set.contains(a) && set.contains(b));
            problem = problem.with(constraint!(inside <= set.len() as f64 - 1.0));
        }
        let solution = problem.solve().ok()?;
        let chosen: Vec<[Cell; 2]> = self
            .links
            .iter()
            .zip(&taken)
            .filter(|(_, taken)| solution.value(**taken) > 0.5)
            .map(|(link, _)| *link)
            .collect();
        Some((chosen.iter().filter(|link| is_crossing(link)).count() as u32, chosen))
    }

    /// Forbids the cycles of a solution.
    /// Returns whether it has any.
    fn forbid_cycles(&mut self, links: &[[Cell; 2]]) -> bool {
        let mut linked: BTreeMap<Cell, Vec<Cell>> = BTreeMap::new();
        for &[a, b] in links {
            linked.entry(a).or_default().push(b);
            linked.entry(b).or_default().push(a);
        }
        let mut seen: Vec<Cell> = Vec::new();
        let before = self.closed.len();
        for &first in linked.keys() {
            if seen.contains(&first) {
                continue;
            }
            let mut strand = vec![first];
            let mut index = 0;
            while let Some(cell) = strand.get(index) {
                let next: Vec<Cell> =
                    linked[cell].iter().copied().filter(|other| !strand.contains(other)).collect();
                strand.extend(next);
                index += 1;
            }
            if strand.iter().all(|cell| linked[cell].len() == 2) {
                self.closed.push(strand.clone());
            }
            seen.extend(strand);
        }
        self.closed.len() > before
    }

    /// The minimum number of crossings of a cover with `pieces` pieces, or a lower bound on it that
    /// is at least `enough`; and the number of rounds it took.
    fn min_crossings(&mut self, pieces: u32, enough: u32) -> (u32, usize) {
        for round in 1.. {
            let (crossings, links) =
                self.solve(self.region.cell_count() - pieces).expect("there is a cover");
            if crossings >= enough || !self.forbid_cycles(&links) {
                return (crossings, round);
            }
        }
        unreachable!("the number of cycles is finite")
    }
}

#[test]
fn the_integer_program_finds_no_better_cover() {
    let mut proven = 0;
    let mut count = 0;
    for number in 0..36_u64 {
        let side = 12 + (number % 9) as u32;
        let region = match RegionShape::ALL.get(number as usize % 12) {
            Some(shape) if number >= 12 => shape.region(side, side, number).unwrap(),
            _ => Region::rectangle(side, side).unwrap(),
        };
        let layout = [Layout::Voronoi, Layout::Islands, Layout::Voronoi, Layout::Checkerboard]
            [number as usize % 4];
        let zones = LayoutSpec { layout, zones: 3 + (number % 4) as u8, side: 3 }
            .zones(&region, number)
            .unwrap();
        let outcome = solve(&region, &zones, &Settings::default(), &Control::default()).unwrap();
        assert_eq!(verify(&region, outcome.path.order()), Ok(outcome.pieces));
        let (best, rounds) =
            Program::new(&region, &zones).min_crossings(outcome.pieces, outcome.crossings);
        println!(
            "{number}: {layout} {side}x{side}, {} cells in {} pieces: bound {}, found {}, \
             integer program {best} after {rounds} rounds",
            region.cell_count(),
            outcome.pieces,
            outcome.bound,
            outcome.crossings,
        );
        assert_eq!(best, outcome.crossings, "the search missed a better cover");
        assert!(outcome.bound <= f64::from(best));
        proven += u32::from(outcome.is_optimal());
        count += 1;
    }
    println!("{proven} of {count} were proven by the exact search itself");
}
