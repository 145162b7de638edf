//! The exact search against an integer program, on layers too large to try everything.
//!
//! By hand:
//! `cargo test --release -p beadwork-search --features integer-program --test integer_program -- --nocapture`.
//! It needs cmake and a C++ compiler to build HiGHS, and takes minutes.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]
#![allow(clippy::print_stdout, reason = "it is run by hand, to be read")]

use std::collections::BTreeMap;

use beadwork_base::Control;
use beadwork_grid::{Cell, Layout, LayoutSpec, Region, RegionShape, Zones, verify};
use beadwork_search::exact::{Settings, solve};
use good_lp::{
    Expression, Solution, SolverModel, Variable, constraint, highs, variable, variables,
};

/// A layer with a variable for each link.
struct Program<'a> {
    region: &'a Region,
    zones: &'a Zones,
    links: Vec<[Cell; 2]>,
    /// Sets of cells in which not all links that a cycle needs may lie.
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

    /// The fewest crossings of so many links, at most two at each cell, without the cycles found so
    /// far; and the links.
    fn solve(&self, count: u32) -> Option<(u32, Vec<[Cell; 2]>)> {
        let mut variables = variables!();
        let taken: Vec<Variable> =
            self.links.iter().map(|_| variables.add(variable().binary())).collect();
        let is_crossing = |&[a, b]: &[Cell; 2]| self.zones.id(a) != self.zones.id(b);
        let of = |choose: &dyn Fn(&[Cell; 2]) -> bool| -> Expression {
            self.links
                .iter()
                .zip(&taken)
                .filter(|(link, _)| choose(link))
                .map(|(_, &taken)| taken)
                .sum()
        };
        let mut problem = variables.minimise(of(&is_crossing)).using(highs);
        problem.set_verbose(false);
        problem = problem.with(constraint!(of(&|_| true) == f64::from(count)));
        for cell in self.region.cells() {
            problem = problem.with(constraint!(of(&|link| link.contains(&cell)) <= 2));
        }
        for set in &self.closed {
            let inside = of(&|[a, b]| set.contains(a) && set.contains(b));
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

    /// Forbids the cycles of a solution; false if it has none.
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

    /// The fewest crossings of a cover in so many pieces, or that there are not fewer than asked.
    fn fewest(&mut self, pieces: u32, enough: u32) -> (u32, usize) {
        for round in 1.. {
            let (crossings, links) =
                self.solve(self.region.cell_count() - pieces).expect("there is a cover");
            if crossings >= enough || !self.forbid_cycles(&links) {
                return (crossings, round);
            }
        }
        unreachable!("there are only so many cycles")
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
        let plan = solve(&region, &zones, &Settings::default(), &Control::default()).unwrap();
        assert_eq!(verify(&region, plan.path.order()), Ok(plan.pieces));
        let (best, rounds) = Program::new(&region, &zones).fewest(plan.pieces, plan.crossings);
        println!(
            "{number}: {layout} {side}x{side}, {} cells in {} pieces: bound {}, found {}, integer program {best} after {rounds} rounds",
            region.cell_count(),
            plan.pieces,
            plan.bound,
            plan.crossings,
        );
        assert_eq!(best, plan.crossings, "the search missed a better cover");
        assert!(plan.bound <= u64::from(best));
        proven += u32::from(plan.is_optimal());
        count += 1;
    }
    println!("{proven} of {count} were proven without it");
}
