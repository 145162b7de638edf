//! Compares the fewest beads with an integer program, on layers too large for exhaustive search.
//!
//! Run it by hand, as it needs cmake, a C++ compiler and libclang to build HiGHS, and takes
//! minutes:
//! ```text
//! cargo test --release -p beadwork-search --features integer-program --test link_program \
//!     -- --nocapture
//! ```
//!
//! It prints a table for the parts of `../shared/parts`, if that folder exists.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
#![allow(clippy::print_stdout, reason = "the test is run by hand, to read its output")]

mod infill;

use std::path::Path;

use beadwork_base::Control;
use beadwork_mesh::{Format, MaterialRule, Model, Placement, ReadLimits, RepairSettings};
use beadwork_part::slice::{self, Cut};
use beadwork_part::toolpath::{self, islands};
use beadwork_search::link::{End, Links, Method, Rule, Settings, solve};
use good_lp::{
    Expression, Solution, SolverModel, Variable, constraint, highs, variable, variables,
};
use infill::{circle, gear, gear_like, lines, star};

/// Number of infill lines from which a layer counts as large.
const LARGE: usize = 100;

/// The maximum number of links of at most one at each end, without conflicts and cycles: a binary
/// variable for each link, and a constraint for each cycle that a solution closed.
fn max_links(links: &Links) -> usize {
    if links.all().is_empty() {
        return 0;
    }
    let mut closed: Vec<Vec<bool>> = Vec::new();
    loop {
        let mut variables = variables!();
        let taken: Vec<Variable> =
            links.all().iter().map(|_| variables.add(variable().binary())).collect();
        let sum = |numbers: &mut dyn Iterator<Item = usize>| -> Expression {
            numbers.map(|number| taken[number]).sum()
        };
        let problem = variables.maximise(sum(&mut (0..taken.len()))).using(highs);
        // Without a tolerance, or large layers might lose a link.
        let mut problem = problem.set_mip_rel_gap(0.0).unwrap().set_threads(1);
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

/// Infill of the layers of a part from `../shared/parts`, rotated about x: the permitted links of
/// each region of each layer, without layers that have no infill.
///
/// Infill of the given density between two insets, in `solid` solid layers at the top and at the
/// bottom.
fn part_layers(path: &Path, turn: f64, density: f64, solid: u32) -> Vec<Vec<Links>> {
    let control = Control::default();
    let bytes = std::fs::read(path).unwrap();
    let mut model = Model::read(Format::ThreeMf, &bytes, &ReadLimits::default(), &control).unwrap();
    for body in &mut model.bodies {
        body.repair(&RepairSettings::default(), &control).unwrap();
    }
    model.assign_materials(MaterialRule::Stated);
    let placement = Placement { rotation_degrees: [turn, 0.0, 0.0], ..Placement::default() };
    placement.apply(&mut model).unwrap();
    let settings = slice::Settings::default();
    let areas = Cut::new(&model, &settings, &control).unwrap().areas(&settings, &control).unwrap();
    let settings = toolpath::Settings {
        density,
        top_layers: solid,
        bottom_layers: solid,
        ..toolpath::Settings::default()
    };
    let layers = islands(&areas, &settings, &control).unwrap();
    let links = |infill: &toolpath::Infill| {
        let rings: Vec<_> = infill.region.rings().cloned().collect();
        Rule::default().links(&infill.lines, &rings, infill.spacing_mm).unwrap()
    };
    let regions = |islands: &Vec<toolpath::Island>| -> Vec<Links> {
        let infill = islands.iter().flat_map(|island| &island.infill);
        infill.filter(|infill| !infill.lines.is_empty()).map(links).collect()
    };
    layers.iter().map(regions).filter(|regions| !regions.is_empty()).collect()
}

/// Layers of one size in one part.
#[derive(Clone, Copy, Debug, Default)]
struct Class {
    layers: usize,
    /// Layers in which cover has no more beads than the integer program.
    optimal: usize,
    /// Layers in which the bound of cover equals its beads.
    proven: usize,
}

/// What cover and other methods make of a part, beside the integer program.
#[derive(Clone, Copy, Debug, Default)]
struct Totals {
    /// Layers of fewer lines than [`LARGE`], and of more.
    classes: [Class; 2],
    lines: usize,
    max_lines: usize,
    /// Beads of cover.
    cover: usize,
    bound: usize,
    repetitive: usize,
    /// Beads of the integer program.
    best: usize,
}

impl Totals {
    /// Adds a layer; `known` holds regions that were solved before, as parts repeat layers.
    fn add(&mut self, layer: &[Links], known: &mut Vec<(Links, usize)>) {
        let (mut found, mut bound, mut best, mut count) = (0, 0, 0, 0);
        for links in layer {
            let outcome = solve(links, &Settings::default(), &Control::default());
            let settings = Settings { method: Method::Repetitive, ..Settings::default() };
            let repetitive = solve(links, &settings, &Control::default()).beads.len();
            let fewest = match known.iter().find(|(other, _)| other == links) {
                Some(&(_, fewest)) => fewest,
                None => links.line_count() - max_links(links),
            };
            known.push((links.clone(), fewest));
            assert!(outcome.bound <= fewest && fewest <= outcome.beads.len());
            assert!(outcome.beads.len() <= repetitive);
            found += outcome.beads.len();
            bound += outcome.bound;
            best += fewest;
            count += links.line_count();
            self.repetitive += repetitive;
        }
        let class = &mut self.classes[usize::from(count >= LARGE)];
        class.layers += 1;
        class.optimal += usize::from(found == best);
        class.proven += usize::from(found == bound);
        self.lines += count;
        self.max_lines = self.max_lines.max(count);
        self.cover += found;
        self.bound += bound;
        self.best += best;
    }
}

/// The figures that cover shall reach on parts: optimal on 97 % of the layers of fewer than 100
/// lines, on 85 % of the others, and within 1 % over each part.
#[test]
fn real_parts_have_the_beads_of_the_integer_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/parts");
    if !folder.exists() {
        println!("skipped: no real parts in {}", folder.display());
        return;
    }
    let parts = [
        ("torus", 0.0),
        ("Bearing", 0.0),
        ("heartgears", 0.0),
        ("yin_yang", 90.0),
        ("8_extruders", 0.0),
    ];
    println!(
        "| part | density, % | solid layers | lines (at most in a layer) | layers of < {LARGE} \
         lines | optimal | proven | >= {LARGE} | optimal | proven | integer program | cover \
         | deviation, % | bound | repetitive NN |"
    );
    println!("|{}", "---|".repeat(15));
    let mut sums = [Class::default(); 2];
    for (name, turn) in parts {
        for (density, solid) in [(0.2, 0), (0.2, 3), (1.0, 0)] {
            let layers = part_layers(&folder.join(format!("{name}.3mf")), turn, density, solid);
            let mut totals = Totals::default();
            let mut known = Vec::new();
            for layer in &layers {
                totals.add(layer, &mut known);
            }
            let Totals { classes, lines, max_lines, cover, bound, repetitive, best } = totals;
            let deviation = 100.0 * (cover as f64 / best as f64 - 1.0);
            print!("| {name} | {} | {solid} | {lines} ({max_lines}) |", 100.0 * density);
            for (class, sum) in classes.iter().zip(&mut sums) {
                let Class { layers, optimal, proven } = class;
                print!(" {layers} | {optimal} | {proven} |");
                sum.layers += layers;
                sum.optimal += optimal;
                sum.proven += proven;
            }
            println!(" {best} | {cover} | {deviation:.2} | {bound} | {repetitive} |");
            assert!(deviation <= 1.0, "{name}");
        }
    }
    println!("all parts: {sums:?}");
    for (class, share) in sums.iter().zip([0.97, 0.85]) {
        assert!(class.optimal as f64 >= share * class.layers as f64);
    }
}
