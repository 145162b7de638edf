//! Compares the fewest beads with an integer program, on layers too large for exhaustive search.
//!
//! Run it by hand, as it needs cmake and a C++ compiler to build HiGHS, and takes minutes:
//! ```text
//! cargo test --release -p beadwork-search --features integer-program --test link_program \
//!     -- --nocapture
//! ```

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
#![allow(clippy::print_stdout, reason = "the test is run by hand, to read its output")]

mod infill;

use beadwork_base::Control;
use beadwork_search::link::{End, Links, Rule, Settings, solve};
use good_lp::{
    Expression, Solution, SolverModel, Variable, constraint, highs, variable, variables,
};
use infill::{circle, gear, gear_like, lines, star};

/// The maximum number of links of at most one at each end, without conflicts and cycles: a binary
/// variable for each link, and a constraint for each cycle that a solution closed.
fn max_links(links: &Links) -> usize {
    let mut closed: Vec<Vec<bool>> = Vec::new();
    loop {
        let mut variables = variables!();
        let taken: Vec<Variable> =
            links.all().iter().map(|_| variables.add(variable().binary())).collect();
        let sum = |numbers: &mut dyn Iterator<Item = usize>| -> Expression {
            numbers.map(|number| taken[number]).sum()
        };
        let mut problem = variables.maximise(sum(&mut (0..taken.len()))).using(highs);
        problem.set_verbose(false);
        for index in 0..links.points().len() {
            let at = links.at(End::from_index(index));
            problem.add_constraint(constraint!(sum(&mut at.iter().map(|&n| n as usize)) <= 1));
        }
        for pair in links.conflicts() {
            problem.add_constraint(constraint!(sum(&mut pair.iter().map(|&n| n as usize)) <= 1));
        }
        for set in &closed {
            let is_inside =
                |&number: &usize| links.all()[number].ends.iter().all(|end| set[end.line as usize]);
            let count = set.iter().filter(|&&is_member| is_member).count();
            let inside = sum(&mut (0..taken.len()).filter(is_inside));
            problem.add_constraint(constraint!(inside <= count as f64 - 1.0));
        }
        let solution = problem.solve().unwrap();
        let chosen: Vec<usize> =
            (0..taken.len()).filter(|&number| solution.value(taken[number]) > 0.5).collect();
        let cycles = cycles(links, &chosen);
        if cycles.is_empty() {
            return chosen.len();
        }
        closed.extend(cycles);
    }
}

/// The lines of each cycle that links close.
fn cycles(links: &Links, chosen: &[usize]) -> Vec<Vec<bool>> {
    let mut other = vec![None; links.points().len()];
    for &number in chosen {
        let [a, b] = links.all()[number].ends;
        other[a.index()] = Some(b);
        other[b.index()] = Some(a);
    }
    let mut seen = vec![false; links.line_count()];
    let mut cycles = Vec::new();
    for line in 0..links.line_count() {
        let start = End::from_index(2 * line);
        let mut members = vec![false; links.line_count()];
        let mut end = start;
        let is_closed = loop {
            if std::mem::replace(&mut seen[end.line as usize], true) {
                break end == start && members[line];
            }
            members[end.line as usize] = true;
            match other[end.other().index()] {
                Some(next) => end = next,
                None => break false,
            }
        };
        if is_closed {
            cycles.push(members);
        }
    }
    cycles
}

#[test]
fn the_integer_program_finds_no_fewer_beads() {
    let mut regions = vec![gear_like(100), gear_like(500)];
    for (radius, spacing) in [(8.0, 0.5), (20.0, 0.5), (20.0, 2.5), (40.0, 2.5)] {
        let bore = circle([0.0; 2], 0.6 * radius, 80);
        regions.push((vec![gear([0.0; 2], radius, 20, 0.1 * radius), bore.clone()], spacing));
        regions.push((vec![star([0.0; 2], radius, 9, 0.45)], spacing));
        let hole = |x: f64| star([x * radius, 0.2 * radius], 0.3 * radius, 7, 0.6);
        regions.push((vec![circle([0.0; 2], radius, 70), hole(-0.4), hole(0.4)], spacing));
    }
    for (rings, spacing) in regions {
        for angle in [0.0, 0.4, 0.785, 1.3, 2.4] {
            let lines = lines(&rings, spacing, angle);
            let links = Rule::default().links(&lines, &rings, spacing).unwrap();
            let outcome = solve(&links, &Settings::default(), &Control::default());
            let best = lines.len() - max_links(&links);
            println!(
                "{} lines: bound {}, found {}, integer program {best}",
                lines.len(),
                outcome.bound,
                outcome.beads.len()
            );
            assert!(outcome.bound <= best);
            assert_eq!(outcome.beads.len(), best);
        }
    }
}
