//! The exact search of a whole region: its components one by one, then one path through all.

use std::collections::{BTreeMap, BTreeSet};

use beadwork_base::Control;
use beadwork_grid::{Cell, Crossings, Path, Region, Zones};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::component::{self, ComponentCover};
use super::outcome::{Outcome, SolveError};
use super::settings::Settings;
use super::terminal::{EndCells, Terminal};
use crate::bound::flow;
use crate::costs::CrossingCosts;
use crate::matching::{Board, Node};
use crate::{CostMatrix, Stop};

/// Covers a region by a path with as few pieces as possible and, among such paths, with crossings
/// of low cost, and proves lower bounds on both.
///
/// The same settings give the same outcome on every machine, unless the search is interrupted.
/// An interrupted search returns the best path so far; it always completes the first attempt at
/// each component, but skips the steps of it that only improve the path.
///
/// Works on the calling thread alone.
/// Progress counts cells: those of a component once its search has ended, and before that the share
/// of them that corresponds to the attempts used of [`Settings::attempts`].
/// Most components need one attempt, so their cells are mostly counted at once.
/// Where a start or end can lie in several components, each component is searched, and counted, up
/// to four times.
///
/// An attempt takes nearly linear time in the number of cells.
///
/// # Errors
/// If zones, costs or the layer below do not match the region, or no path can begin and end as
/// required.
pub fn solve(
    region: &Region,
    zones: &Zones,
    settings: &Settings<'_>,
    control: &Control<'_>,
) -> Result<Outcome, SolveError> {
    check(region, zones, settings)?;
    let uniform = CostMatrix::uniform(zones.count() as usize);
    let costs = settings.costs.unwrap_or(&uniform);
    let crossing_costs = CrossingCosts::new(costs);
    let boards = Board::of_components(region, zones, crossing_costs.reduced());
    let candidates = |terminal: Terminal| -> Vec<Vec<Node>> {
        let cells = terminal.cells(region);
        let on =
            |board: &Board| cells.iter().filter_map(|&cell| board.find(region, cell)).collect();
        boards.iter().map(on).collect()
    };
    let mut solver = Solver {
        boards: &boards,
        starts: candidates(settings.start),
        ends: candidates(settings.end),
        costs: &crossing_costs,
        settings,
        control,
        solved: BTreeMap::new(),
        cells_done: 0,
        cells_total: 0,
    };
    let choice = solver.choose_ends()?;
    let mut outcome = solver.join(region, zones, &choice);
    if outcome.is_optimal() {
        outcome.stop = Stop::Optimal;
    } else if outcome.stop == Stop::Optimal {
        outcome.stop = Stop::Done;
    }
    Ok(outcome)
}

/// Checks that the inputs belong together.
fn check(region: &Region, zones: &Zones, settings: &Settings<'_>) -> Result<(), SolveError> {
    if zones.ids().len() != region.grid_len() {
        return Err(SolveError::Zones { expected: region.grid_len(), got: zones.ids().len() });
    }
    if let Some(cell) = region.cells().find(|&cell| zones.id(cell) == Zones::OUTSIDE) {
        let (x, y) = region.xy(cell);
        return Err(SolveError::NoZone { x, y });
    }
    if let Some(costs) = settings.costs
        && costs.size() < zones.count() as usize
    {
        return Err(SolveError::Costs { expected: zones.count(), got: costs.size() });
    }
    if let Some([from, to]) = settings.costs.and_then(CostMatrix::first_forbidden) {
        return Err(SolveError::Forbidden { from, to });
    }
    if let Some(below) = settings.below {
        let (expected, got) = ([region.width(), region.height()], [below.width(), below.height()]);
        if got != expected {
            return Err(SolveError::Below { expected, got });
        }
    }
    for (end, terminal) in [("start", settings.start), ("end", settings.end)] {
        if let Terminal::Cell(cell) = terminal
            && !region.contains(cell)
        {
            return Err(SolveError::Outside { end, cell });
        }
    }
    match (settings.start, settings.end) {
        (Terminal::Cell(start), Terminal::Cell(end)) if start == end && region.cell_count() > 1 => {
            Err(SolveError::SameCell(start))
        }
        _ => Ok(()),
    }
}

/// What identifies the search of a component: its number, and whether the path begins and whether
/// it ends in it.
type Key = (usize, bool, bool);

/// The components of a region, each solved at most once for each [`Key`].
struct Solver<'a> {
    boards: &'a [Board],
    /// For each component the cells at which the path may begin; all empty if it may begin
    /// anywhere.
    starts: Vec<Vec<Node>>,
    /// For each component the cells at which the path may end; all empty if it may end anywhere.
    ends: Vec<Vec<Node>>,
    costs: &'a CrossingCosts<'a>,
    settings: &'a Settings<'a>,
    control: &'a Control<'a>,
    solved: BTreeMap<Key, ComponentCover>,
    /// Cells of the solved components, for the progress.
    cells_done: usize,
    /// Cells of all components to solve.
    cells_total: usize,
}

impl Solver<'_> {
    /// Solves the components for each choice of the ones in which the path begins and ends, and
    /// returns the best choice.
    ///
    /// A terminal that is a side of the region may have cells in several components.
    /// The bounds returned hold for all choices: they are the minimum over them.
    fn choose_ends(&mut self) -> Result<Choice, SolveError> {
        let components_of = |terminal: Terminal, cells: &[Vec<Node>]| -> Vec<Option<usize>> {
            if terminal == Terminal::Any {
                return vec![None];
            }
            (0..cells.len()).filter(|&number| !cells[number].is_empty()).map(Some).collect()
        };
        let starts = components_of(self.settings.start, &self.starts);
        let ends = components_of(self.settings.end, &self.ends);
        let mut pairs: Vec<(Option<usize>, Option<usize>)> =
            starts.iter().flat_map(|&start| ends.iter().map(move |&end| (start, end))).collect();
        pairs.retain(|&(start, end)| self.is_possible(start, end));
        let numbers = 0..self.boards.len();
        let keys: BTreeSet<Key> = pairs
            .iter()
            .flat_map(|&(start, end)| numbers.clone().map(move |number| key(number, start, end)))
            .collect();
        self.cells_total = keys.iter().map(|&(number, ..)| self.boards[number].cells.len()).sum();

        let mut best: Option<Choice> = None;
        let (mut piece_bound, mut bound) = (u32::MAX, u64::MAX);
        for (start, end) in pairs {
            let mut choice = Choice { start, end, ..Choice::default() };
            for number in numbers.clone() {
                choice.add(self.component(number, start, end));
            }
            // The bound of each component holds for the pieces that were found for it.
            // If these are more than proven necessary, another cover with the same total number of
            // pieces may have the surplus pieces in another component, where they could save
            // crossings.
            // So the bound of each component allows it the whole surplus.
            let surplus = choice.pieces - choice.piece_bound;
            if surplus > 0 && self.boards.len() > 1 {
                let max_pieces =
                    |number: usize| self.solved[&key(number, start, end)].piece_bound + surplus;
                choice.bound = numbers
                    .clone()
                    .map(|number| flow::min_cost(&self.boards[number], max_pieces(number)))
                    .sum();
            }
            // Cutting a cover into more pieces costs nothing, so a bound for more pieces also holds
            // for fewer.
            // Therefore the minimum over all choices is a bound for the best one, whatever their
            // numbers of pieces.
            piece_bound = piece_bound.min(choice.piece_bound);
            bound = bound.min(choice.bound);
            if best
                .as_ref()
                .is_none_or(|best| (choice.pieces, choice.cost) < (best.pieces, best.cost))
            {
                best = Some(choice);
            }
        }
        best.map(|best| Choice { piece_bound, bound, ..best }).ok_or(SolveError::NoTwoCells)
    }

    /// Whether a path can begin and end in these components.
    ///
    /// Start and end cannot lie in the same component if both need the same cell of it, unless that
    /// cell is the whole region.
    fn is_possible(&self, start: Option<usize>, end: Option<usize>) -> bool {
        let Some(number) = start.filter(|_| start == end) else { return true };
        match self.boards[number].cells.len() {
            1 => self.boards.len() == 1,
            _ => self.starts[number].len() > 1 || self.starts[number] != self.ends[number],
        }
    }

    /// The best cover of one component, if the path begins and ends in the components given.
    fn component(
        &mut self,
        number: usize,
        start: Option<usize>,
        end: Option<usize>,
    ) -> &ComponentCover {
        let key @ (_, begins, stops) = key(number, start, end);
        let Self { boards, starts, ends, costs, settings, control, .. } = self;
        let (cells_done, cells_total) = (&mut self.cells_done, self.cells_total);
        self.solved.entry(key).or_insert_with(|| {
            let ends = EndCells {
                first: if begins { starts[number].clone() } else { Vec::new() },
                last: if stops { ends[number].clone() } else { Vec::new() },
                in_different_pieces: begins && stops && boards.len() > 1,
            };
            // Each component has its own random stream, so that the attempts at one do not change
            // the others.
            let stream = (number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed.wrapping_add(stream));
            let board = &boards[number];
            let cells = board.cells.len();
            let before = *cells_done;
            let report = |attempts: u32| {
                let max_attempts = settings.attempts.max(1) as usize;
                let share = cells * (attempts as usize).min(max_attempts) / max_attempts;
                control.report(before + share, cells_total);
            };
            let cover =
                component::solve(board, &ends, costs.reduced(), settings, control, report, rng);
            *cells_done += cells;
            control.report(*cells_done, cells_total);
            cover
        })
    }

    /// Joins the covers of all components to one path: the piece that holds the start comes first,
    /// the one that holds the end comes last.
    fn join(mut self, region: &Region, zones: &Zones, choice: &Choice) -> Outcome {
        let &Choice { start, end, piece_bound, bound, attempts, stop, .. } = choice;
        let mut numbers: Vec<usize> = (0..self.boards.len()).collect();
        numbers.sort_by_key(|&number| start != Some(number));
        let mut order: Vec<Cell> = Vec::with_capacity(region.cell_count() as usize);
        let mut last = Vec::new();
        for number in numbers {
            let board = &self.boards[number];
            let cover = self.component(number, start, end);
            let cells = |nodes: &[Node]| -> Vec<Cell> {
                nodes.iter().map(|&node| board.cell(node)).collect()
            };
            if end == Some(number) {
                let (before, last_piece) = cover.order.split_at(cover.last_piece);
                order.extend(cells(before));
                last = cells(last_piece);
            } else {
                order.extend(cells(&cover.order));
            }
        }
        order.append(&mut last);
        let path = Path::in_pieces(region, order).expect("the components hold every cell once");
        // Pieces, crossings and cost are those of the path: where one piece happens to end next to
        // the beginning of the following one, the path continues, and they are one piece.
        let crossings = Crossings::new(region, zones).count(&path);
        let costs = self.costs.original();
        let cost = |step: &[Cell]| costs.step(zones.id(step[0]), zones.id(step[1]));
        let cost = path.iter_pieces().flat_map(|piece| piece.windows(2)).map(cost).sum();
        let (cost, bound) = (costs.unscaled(cost), self.costs.bound(bound));
        Outcome { pieces: path.pieces(), piece_bound, crossings, cost, bound, stop, attempts, path }
    }
}

fn key(number: usize, start: Option<usize>, end: Option<usize>) -> Key {
    (number, start == Some(number), end == Some(number))
}

/// A choice of the components in which the path begins and ends, and sums over the covers that it
/// leads to.
#[derive(Clone, Copy)]
struct Choice {
    /// The component in which the path begins; `None` if it may begin anywhere.
    start: Option<usize>,
    /// The component in which the path ends; `None` if it may end anywhere.
    end: Option<usize>,
    pieces: u32,
    piece_bound: u32,
    cost: u64,
    bound: u64,
    attempts: u32,
    /// The first reason, in the order of the components, why a search was interrupted; otherwise
    /// [`Stop::Done`] if one of them ended without a proof.
    stop: Stop,
}

impl Default for Choice {
    fn default() -> Self {
        let (start, end) = (None, None);
        Self {
            start,
            end,
            pieces: 0,
            piece_bound: 0,
            cost: 0,
            bound: 0,
            attempts: 0,
            stop: Stop::Optimal,
        }
    }
}

impl Choice {
    fn add(&mut self, cover: &ComponentCover) {
        self.pieces += cover.pieces;
        self.piece_bound += cover.piece_bound;
        self.cost += cover.cost;
        self.bound += cover.bound;
        self.attempts += cover.attempts;
        if cover.stop != Stop::Optimal && matches!(self.stop, Stop::Optimal | Stop::Done) {
            self.stop = cover.stop;
        }
    }
}
