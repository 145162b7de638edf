//! What each method of linking makes of the infill of a part.

use std::time::Instant;

use anyhow::bail;
use beadwork_base::Control;
use beadwork_search::join;
use beadwork_search::link::{self, Links, LinksError, Method, Rule};
use beadwork_search::plan::beads::{self, BeadPlan, Seam};
use serde::Serialize;

use super::cases::Case;

/// Number of lines of a region or a layer from which it counts as large.
const LARGE: usize = 100;

/// Number of lines of a region up to which nearest neighbour is started from all ends.
const MAX_REPETITIVE: usize = 300;

/// Spanning trees of the bound on travel, for each layer and tool.
const BOUND_ITERATIONS: u32 = 30;

/// A row of the table for each part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub(super) name: &'static str,
    method: Method,
    links_first: bool,
    rounds: u32,
    is_joined: bool,
}

/// The methods from the simplest to ours.
///
/// Those of the paper go to the nearest end, whether it may be linked or not; the others go to the
/// nearest end that may be linked, if there is one.
pub(super) const COLUMNS: [Column; 7] = [
    Column::NEAREST,
    Column::new("NN, linkable first", Method::Nearest, true),
    Column::BREAK_POINTS,
    Column::new("break points, linkable first", Method::BreakPoints, true),
    Column::new("repetitive NN", Method::Repetitive, true),
    Column::COVER,
    Column { name: "cover, joined", is_joined: true, ..Column::COVER },
];

impl Column {
    pub(super) const NEAREST: Self = Self::new("NN", Method::Nearest, false);
    pub(super) const BREAK_POINTS: Self = Self::new("break points", Method::BreakPoints, false);
    pub(super) const REPEATED: Self =
        Self { name: "break points, repeated", rounds: u32::MAX, ..Self::BREAK_POINTS };
    /// Nearest neighbour as in the paper, from all ends: the best that any choice of starts
    /// reaches.
    pub(super) const ALL_STARTS: Self = Self::new("all starts", Method::Repetitive, false);
    pub(super) const COVER: Self = Self::new("cover", Method::Cover, true);

    const fn new(name: &'static str, method: Method, links_first: bool) -> Self {
        Self { name, method, links_first, rounds: 1, is_joined: false }
    }

    fn link(self, seed: u64) -> link::Settings {
        let Self { method, links_first, rounds, .. } = self;
        link::Settings { method, links_first, rounds, seed, ..link::Settings::default() }
    }
}

/// Permitted links of all infill regions of a case.
pub(super) struct Regions {
    /// The regions of each layer.
    layers: Vec<Vec<Links>>,
    /// Time to find the links, summed over the layers, in s.
    pub(super) seconds: f64,
}

/// How many of them are proven to have the fewest beads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Proven {
    pub(super) proven: usize,
    pub(super) all: usize,
}

/// Linked infill of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Linked {
    pub(super) infill_beads: usize,
    /// Proven lower bound on their number.
    pub(super) infill_bound: usize,
    /// Infill regions of fewer than 100 lines, and of more.
    pub(super) regions: [Proven; 2],
    /// Layers with fewer than 100 infill lines, and with more.
    pub(super) layers: [Proven; 2],
    /// Time to link, summed over the regions, in s.
    pub(super) seconds: f64,
    /// Maximum time of one layer in s.
    pub(super) max_seconds: f64,
}

/// A method applied to a case.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) part: String,
    /// Infill density in per cent.
    pub(super) density: f64,
    pub(super) method: &'static str,
    #[serde(flatten)]
    pub(super) linked: Linked,
    /// Closed loops of the insets.
    pub(super) loops: usize,
    /// Skeletons in thin walls and gaps.
    pub(super) skeletons: usize,
    /// Beads of all kinds.
    pub(super) beads: usize,
    /// Breaks between two beads of a layer.
    pub(super) lifts: usize,
    /// Travel of all beads in mm, island by island with loops before infill; `None` if the method
    /// was replaced in large regions.
    pub(super) travel_mm: Option<f64>,
    /// Proven lower bound on the travel within layers of the same beads in that order; only for
    /// `cover`.
    pub(super) travel_bound_mm: Option<f64>,
}

impl Regions {
    pub(super) fn new(case: &Case, control: &Control<'_>) -> anyhow::Result<Self> {
        let layer = |number: usize| -> Result<_, LinksError> {
            let begin = Instant::now();
            let mut regions = Vec::new();
            for infill in case.layers[number].iter().flat_map(|island| &island.infill) {
                if !infill.lines.is_empty() {
                    let rings: Vec<_> = infill.region.rings().cloned().collect();
                    regions.push(Rule::default().links(
                        &infill.lines,
                        &rings,
                        infill.spacing_mm,
                    )?);
                }
            }
            Ok((regions, begin.elapsed().as_secs_f64()))
        };
        let layers = control.threads.map_numbers(case.layers.len(), layer);
        let layers = layers.into_iter().collect::<Result<Vec<_>, _>>()?;
        control.check()?;
        let seconds = layers.iter().map(|(_, seconds)| seconds).sum();
        Ok(Self { layers: layers.into_iter().map(|(regions, _)| regions).collect(), seconds })
    }

    /// Links all regions; those too large for starts from all ends get starts at break points.
    pub(super) fn link(
        &self,
        column: Column,
        seed: u64,
        control: &Control<'_>,
    ) -> anyhow::Result<Linked> {
        let quiet = control.on_one_thread().without_progress();
        let layer = |regions: &Vec<Links>| {
            let mut linked = Linked::default();
            let mut layer_lines = 0;
            let begin = Instant::now();
            for links in regions {
                let lines = links.line_count();
                let mut settings = column.link(seed);
                if settings.method == Method::Repetitive && lines > MAX_REPETITIVE {
                    settings.method = Method::BreakPoints;
                }
                let outcome = link::solve(links, &settings, &quiet);
                linked.infill_beads += outcome.beads.len();
                linked.infill_bound += outcome.bound;
                linked.regions[usize::from(lines >= LARGE)].add(outcome.is_optimal());
                layer_lines += lines;
            }
            linked.seconds = begin.elapsed().as_secs_f64();
            linked.max_seconds = linked.seconds;
            if layer_lines > 0 {
                let is_proven = linked.infill_beads <= linked.infill_bound;
                linked.layers[usize::from(layer_lines >= LARGE)].add(is_proven);
            }
            linked
        };
        let mut total = Linked::default();
        for layer in control.threads.map(&self.layers, layer) {
            total.add(&layer);
        }
        control.check()?;
        Ok(total)
    }

    fn are_small(&self) -> bool {
        self.layers.iter().flatten().all(|links| links.line_count() <= MAX_REPETITIVE)
    }
}

impl Proven {
    fn add(&mut self, is_proven: bool) {
        self.all += 1;
        self.proven += usize::from(is_proven);
    }
}

impl Linked {
    fn add(&mut self, other: &Self) {
        self.infill_beads += other.infill_beads;
        self.infill_bound += other.infill_bound;
        for (sums, others) in
            [(&mut self.regions, &other.regions), (&mut self.layers, &other.layers)]
        {
            for (sum, other) in sums.iter_mut().zip(others) {
                sum.proven += other.proven;
                sum.all += other.all;
            }
        }
        self.seconds += other.seconds;
        self.max_seconds = self.max_seconds.max(other.max_seconds);
    }
}

/// Applies one method to a case.
pub(super) fn row(
    case: &Case,
    regions: &Regions,
    column: Column,
    seed: u64,
    control: &Control<'_>,
) -> anyhow::Result<Row> {
    let mut linked = regions.link(column, seed, control)?;
    // The planner does not replace the method in large regions.
    let is_replaced = column.method == Method::Repetitive && !regions.are_small();
    let planned =
        if is_replaced { Column { method: Method::BreakPoints, ..column } } else { column };
    let plan = plan(case, planned, seed, control)?;
    let total = plan.total();
    if column.is_joined {
        linked.infill_beads = total.infill;
    }
    Ok(Row {
        part: case.name.clone(),
        density: 100.0 * case.toolpath.density,
        method: column.name,
        linked,
        loops: total.loops,
        skeletons: total.skeletons,
        beads: total.beads + linked.infill_beads - total.infill,
        lifts: plan.lifts() + linked.infill_beads - total.infill,
        travel_mm: (!is_replaced).then_some(plan.travel_mm),
        travel_bound_mm: plan.travel_bound_mm,
    })
}

/// The beads of a case in printing order.
pub(super) fn plan(
    case: &Case,
    column: Column,
    seed: u64,
    control: &Control<'_>,
) -> anyhow::Result<BeadPlan> {
    let is_bounded = column.method == Method::Cover && !column.is_joined;
    let settings = beads::Settings {
        link: column.link(seed),
        join: column.is_joined.then(join::Settings::default),
        seam: Seam::Nearest,
        bound_iterations: if is_bounded { BOUND_ITERATIONS } else { 0 },
        seed,
        ..beads::Settings::default()
    };
    let plan = beads::solve(&case.layers, &case.toolpath, &case.costs(), &settings, control)?;
    if let Some(interrupted) = control.interrupted() {
        bail!(interrupted);
    }
    Ok(plan)
}

#[cfg(test)]
mod tests {
    use super::super::cases::Source;
    use super::super::shapes::Shape;
    use super::*;

    /// No method of more effort has more beads, and none goes below a bound.
    #[test]
    fn methods_agree_with_each_other() {
        let control = Control::default();
        for shape in [Shape::Disc, Shape::Pacman, Shape::FiveHoles, Shape::Pillars] {
            let source = Source::shape(shape, &control).unwrap();
            let case = Case::new(&source, 20.0, &control).unwrap();
            let regions = Regions::new(&case, &control).unwrap();
            let rows: Vec<Row> = COLUMNS
                .iter()
                .map(|&column| row(&case, &regions, column, 3, &control).unwrap())
                .collect();
            let [nearest, nearest_linked, breaks, breaks_linked, repetitive, cover, joined] =
                &rows[..]
            else {
                panic!("a row for each column");
            };
            let infill = |row: &Row| row.linked.infill_beads;
            assert!(infill(breaks) <= infill(nearest));
            assert!(infill(breaks_linked) <= infill(nearest_linked));
            assert!(infill(repetitive) <= infill(breaks_linked));
            assert!(infill(cover) <= infill(repetitive));
            assert_eq!(infill(cover), cover.linked.infill_bound, "{shape:?}");
            assert!(
                rows.iter().all(|row| infill(cover) <= infill(row) || row.method == joined.method)
            );
            assert!(joined.beads < cover.beads);
            for row in &rows {
                let all = row.loops + row.skeletons + infill(row);
                assert!(row.beads == all || row.method == joined.method);
                // Both layers have beads.
                assert_eq!(row.lifts + 2, row.beads);
            }
            assert!(cover.travel_bound_mm.unwrap() <= cover.travel_mm.unwrap());
        }
    }
}
