//! `eval beads` for shapes and parts: tables of methods.

use std::fmt::Write;

use beadwork_base::{Control, Threads};
use beadwork_console::{control, machine, output, progress};
use beadwork_search::link::Rule;
use serde_json::json;

use super::cases::{Case, Source};
use super::methods::{self, COLUMNS, Proven, Regions, Row};
use super::shapes::Shape;
use super::{BeadsArgs, drawing, neighbours, shapes_table, starts, surface};

/// All rows of all tables.
#[derive(Default)]
struct Tables {
    shapes: Vec<shapes_table::Row>,
    starts: Vec<starts::Row>,
    neighbours: Vec<neighbours::Row>,
    methods: Vec<Row>,
    surfaces: Vec<surface::Row>,
    /// Time to find the permitted links, summed over layers, in s.
    link_seconds: f64,
}

/// Measures the parts that are named, or the shapes, and prints the tables.
pub(super) fn run(args: &BeadsArgs) -> anyhow::Result<()> {
    let pool = control::pool(args.threads)?;
    let control = control::cancellable(Threads::Pool(&pool))?;
    let shapes = if args.parts.is_empty() { &Shape::ALL[..] } else { &[] };
    let cases = (shapes.len() + args.parts.len()) * args.density.len();
    let bar = progress::bar((cases * COLUMNS.len()) as u64, "eval beads");
    let mut tables = Tables::default();
    for &shape in shapes {
        let source = Source::shape(shape, &control)?;
        tables.shapes.push(shapes_table::row(shape, &source, &control)?);
        for (number, &density) in args.density.iter().enumerate() {
            let case = Case::new(&source, density, &control)?;
            let regions = tables.add(&case, args.seed, &control)?;
            tables.starts.push(starts::row(shape, &case, &regions, &control)?);
            if let Some(folder) = args.svg.as_ref().filter(|_| number == 0) {
                drawing::draw(shape, &case, args.seed, folder, &control)?;
            }
            bar.inc(COLUMNS.len() as u64);
        }
    }
    if !shapes.is_empty() {
        tables.neighbours = neighbours::rows(&control)?;
    }
    for path in &args.parts {
        let source = Source::part(path, &pool)?;
        for (number, &density) in args.density.iter().enumerate() {
            let case = Case::new(&source, density, &control)?;
            if number == 0 {
                tables.surfaces.push(surface::row(&case, &control)?);
            }
            tables.add(&case, args.seed, &control)?;
            bar.inc(COLUMNS.len() as u64);
        }
    }
    bar.finish_and_clear();
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(),
            "seed": args.seed,
            "starts": starts::STARTS,
            "link_seconds": tables.link_seconds,
            "shapes": tables.shapes,
            "random_starts": tables.starts,
            "neighbours": tables.neighbours,
            "methods": tables.methods,
            "surfaces": tables.surfaces,
        }));
    }
    output::text(&tables.text(args.seed)?)
}

impl Tables {
    /// Applies all methods to a case; returns its links.
    fn add(&mut self, case: &Case, seed: u64, control: &Control<'_>) -> anyhow::Result<Regions> {
        let regions = Regions::new(case, control)?;
        self.link_seconds += regions.seconds;
        for column in COLUMNS {
            self.methods.push(methods::row(case, &regions, column, seed, control)?);
        }
        Ok(regions)
    }

    fn text(&self, seed: u64) -> Result<String, std::fmt::Error> {
        let mut text = format!("{}\n\n", machine::line());
        if !self.shapes.is_empty() {
            shapes_table::table(&mut text, &self.shapes)?;
            starts::table(&mut text, &self.starts)?;
            neighbours::table(&mut text, &self.neighbours)?;
        }
        if !self.surfaces.is_empty() {
            surface::table(&mut text, &self.surfaces)?;
        }
        let Rule { straight, boundary, .. } = Rule::default();
        writeln!(
            text,
            "Seed {seed}; 2 insets, lines at 45 and 135 degrees, no solid layers; links of at most \
             {straight} spacings straight, {boundary} along the boundary.\n\
             Seconds are sums over the regions of one thread each; finding the links took {:.2} s \
             besides.\n",
            self.link_seconds
        )?;
        writeln!(
            text,
            "| part | density, % | method | infill beads | bound | all beads | skeletons | lifts \
             | travel, m | travel bound, m | seconds | slowest layer, ms \
             | proven: regions of < 100 lines | >= 100 | layers of < 100 lines | >= 100 |"
        )?;
        writeln!(text, "|{}", "---|".repeat(16))?;
        for row in &self.methods {
            line(&mut text, row)?;
        }
        Ok(text)
    }
}

fn line(text: &mut String, row: &Row) -> std::fmt::Result {
    let metres = |mm: Option<f64>| mm.map_or("-".to_owned(), |mm| format!("{:.2}", mm / 1000.0));
    let linked = &row.linked;
    write!(
        text,
        "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.3} | {:.1} |",
        row.part,
        row.density,
        row.method,
        linked.infill_beads,
        linked.infill_bound,
        row.beads,
        row.skeletons,
        row.lifts,
        metres(row.travel_mm),
        metres(row.travel_bound_mm),
        linked.seconds,
        1000.0 * linked.max_seconds
    )?;
    for Proven { proven, all } in linked.regions.iter().chain(&linked.layers) {
        write!(text, " {proven} of {all} |")?;
    }
    writeln!(text)
}
