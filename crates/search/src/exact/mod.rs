//! Fewest pieces, then fewest crossings, with a proof.
//!
//! # Idea
//! A path through n cells in p pieces is a set of n - p links, at most two at each cell.
//! The cheapest set of so many links, a 2-matching, is a minimum cost flow, for the grid is
//! bipartite; it bounds the crossings from below.
//! It consists of paths and cycles, and where the bound is tight it only has to be made one path,
//! without a link more across zones:
//!
//! 1. ladders inside the zones, then the cheapest 2-matching by shortest alternating paths;
//! 2. links from groups of zones that nothing leaves, the cheapest first;
//! 3. cycles joined by switches, and what is left by exchanges along short alternating cycles.
//!
//! An attempt is made anew, with other ladders and other random choices, until the crossings meet
//! the bound.
//! If the first one does not, the bound is raised by what must be paid to hold everything together.
//!
//! # Example
//! ```
//! use beadwork_grid::{Layout, LayoutSpec, Region};
//! use beadwork_search::exact::{Settings, solve};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, 3)?;
//! let plan = solve(&region, &zones, &Settings::default())?;
//! assert_eq!((plan.pieces, plan.piece_bound), (1, 1));
//! assert!(plan.is_optimal(), "{} crossings, at least {}", plan.crossings, plan.bound);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ends;
mod link;
mod merge;
mod part;
mod strands;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod twin;
mod untangle;

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use beadwork_grid::{Cell, Crossings, Path, Region, Zones};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use thiserror::Error;

pub use ends::{Side, Terminal};

use crate::bound::flow;
use crate::matching::{Board, Node};
use crate::stop::Interrupt;
use crate::{Stop, ZoneCosts};
use ends::Ends;
use part::Part;

/// How to solve.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// Seed of the random choices.
    pub seed: u64,
    /// Most attempts at each connected part of the region; at least one is made.
    pub attempts: u32,
    /// What crossings cost; `None` for 1 each.
    pub costs: Option<&'a ZoneCosts>,
    /// Where the first piece has to begin.
    pub start: Terminal,
    /// Where the last piece has to end.
    pub end: Terminal,
    /// Whether the first attempt lays its ladders along the columns, not the rows: paths of layers
    /// in turn then cross each other.
    pub columns_first: bool,
    /// A path of the layer below, on a plane of the same size: the first attempts take over its
    /// links inside the zones, as far as both layers have the cells, and look for the rest only.
    pub below: Option<&'a Path>,
    /// Stops the search soon after it turns true.
    pub cancel: Option<&'a AtomicBool>,
    /// Asked now and then; the search stops soon after it gives true.
    /// The best plan so far is returned, or one made in haste.
    pub time_is_up: Option<&'a (dyn Fn() -> bool + Sync)>,
    /// Told after each attempt how far the search has come.
    pub observer: Option<&'a (dyn Fn(Progress) + Sync)>,
    /// Told of each stage of the first attempt at each part: for pictures.
    pub stages: Option<&'a StageObserver<'a>>,
}

/// Takes a stage and its links, each of two neighbours.
pub type StageObserver<'a> = dyn Fn(Stage, &[[Cell; 2]]) + Sync + 'a;

/// What an attempt has when one of its steps is done; in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Ladders inside the zones, and what fits beside them.
    Ladders,
    /// The cheapest 2-matching: the bound.
    Cheapest,
    /// The same with links from what would be left apart.
    Linked,
    /// Cycles joined by switches.
    Merged,
    /// The paths that are left when the last cycles are joined too.
    Settled,
}

impl Default for Settings<'_> {
    /// Seed 0, 50 attempts, crossings that cost 1, free ends, ladders along the rows, no layer
    /// below, nothing that stops it.
    fn default() -> Self {
        Self {
            seed: 0,
            attempts: 50,
            costs: None,
            start: Terminal::Any,
            end: Terminal::Any,
            columns_first: false,
            below: None,
            cancel: None,
            time_is_up: None,
            observer: None,
            stages: None,
        }
    }
}

/// How far a search has come with one connected part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Cells of the part.
    pub cells: u32,
    /// Attempts made at it.
    pub attempts: u32,
    /// Pieces of its best cover.
    pub pieces: u32,
    /// Cost of its best cover.
    pub cost: u64,
}

/// A path in few pieces and at little cost, and how good it is.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The path.
    pub path: Path,
    /// Its pieces.
    pub pieces: u32,
    /// Pieces of any path that begins and ends where asked, at least.
    /// Proven.
    pub piece_bound: u32,
    /// Its steps between two zones.
    pub crossings: u32,
    /// What they cost: their number, unless [`Settings::costs`] says otherwise.
    pub cost: u64,
    /// Cost of any path in so many pieces, at least.
    /// Proven.
    /// With costs that depend on the direction it holds for the cheaper direction of each pair of
    /// zones, so it may be out of reach.
    pub bound: u64,
    /// Why the search stopped.
    pub stop: Stop,
    /// Attempts made, over all connected parts.
    pub attempts: u32,
}

impl Plan {
    /// Whether it is proven that no path has fewer pieces, or as few and a lower cost.
    pub fn is_optimal(&self) -> bool {
        self.pieces == self.piece_bound && self.cost == self.bound
    }
}

/// Why a region can't be solved as asked.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolveError {
    /// The zones were made for a plane of another size.
    #[error("{got} zones given for a plane of {expected} cells")]
    Zones {
        /// Cells of the plane.
        expected: usize,
        /// Zones given.
        got: usize,
    },
    /// A cell of the region has no zone.
    #[error("cell ({x}, {y}) belongs to the region but has no zone")]
    NoZone {
        /// Its column.
        x: u32,
        /// Its row.
        y: u32,
    },
    /// The costs are for fewer zones than there are.
    #[error("costs given for {got} zones, the region has {expected}")]
    Costs {
        /// Zones of the region.
        expected: u32,
        /// Zones that have costs.
        got: usize,
    },
    /// The path of the layer below is one on a plane of another size.
    #[error("the path of the layer below lies on {} x {} cells, the region on {} x {}", .got[0], .got[1], .expected[0], .expected[1])]
    Below {
        /// Width and height of the region's plane.
        expected: [u32; 2],
        /// Those of the path's.
        got: [u32; 2],
    },
    /// A cell at which the path has to begin or end is not one of the region's.
    #[error("the {end} cell {cell} lies outside the region")]
    Outside {
        /// "start" or "end".
        end: &'static str,
        /// The cell.
        cell: Cell,
    },
    /// The path has to begin and end at one cell, and there are others.
    #[error("the path can't both begin and end at cell {0}")]
    SameCell(Cell),
    /// The only cell at which the path may begin is the only one at which it may end, and there are
    /// others.
    #[error("the sides at which the path has to begin and end have only one cell between them")]
    NoTwoCells,
}

/// Covers a region in few pieces, and of such covers finds one of low cost, with proven bounds of
/// both.
///
/// The same seed and attempts give the same plan on every machine; what stops the search early does
/// not.
/// An attempt is nearly linear in the cells.
/// The attempts that a part needs to meet the bound are few: one on most parts.
pub fn solve(region: &Region, zones: &Zones, settings: &Settings<'_>) -> Result<Plan, SolveError> {
    check(region, zones, settings)?;
    let uniform = ZoneCosts::uniform(zones.count());
    let costs = settings.costs.unwrap_or(&uniform);
    let boards = Board::of_parts(region, zones, costs);
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
        costs,
        settings,
        interrupt: Interrupt { cancel: settings.cancel, time_is_up: settings.time_is_up },
        parts: BTreeMap::new(),
    };
    let choice = solver.choose_ends()?;
    let mut plan = solver.join(region, zones, &choice);
    if plan.is_optimal() {
        plan.stop = Stop::Optimal;
    } else if plan.stop == Stop::Optimal {
        plan.stop = Stop::Done;
    }
    Ok(plan)
}

fn check(region: &Region, zones: &Zones, settings: &Settings<'_>) -> Result<(), SolveError> {
    if zones.ids().len() != region.grid_len() {
        return Err(SolveError::Zones { expected: region.grid_len(), got: zones.ids().len() });
    }
    if let Some(cell) = region.cells().find(|&cell| zones.id(cell) == Zones::OUTSIDE) {
        let (x, y) = region.xy(cell);
        return Err(SolveError::NoZone { x, y });
    }
    if let Some(costs) = settings.costs
        && costs.zones() < zones.count() as usize
    {
        return Err(SolveError::Costs { expected: zones.count(), got: costs.zones() });
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

/// The connected parts of a region, each solved at most once for each way in which it may hold the
/// ends.
struct Solver<'a> {
    boards: &'a [Board],
    /// For each part the cells at which the path may begin; empty for all parts if any will do.
    starts: Vec<Vec<Node>>,
    ends: Vec<Vec<Node>>,
    costs: &'a ZoneCosts,
    settings: &'a Settings<'a>,
    interrupt: Interrupt<'a>,
    /// By number of the part, and whether the path begins and ends there.
    parts: BTreeMap<(usize, bool, bool), Part>,
}

impl Solver<'_> {
    /// The parts in which the path begins and ends: those that make the best plan.
    fn choose_ends(&mut self) -> Result<Choice, SolveError> {
        let choices = |terminal: Terminal, cells: &[Vec<Node>]| -> Vec<Option<usize>> {
            if terminal == Terminal::Any {
                return vec![None];
            }
            (0..cells.len()).filter(|&part| !cells[part].is_empty()).map(Some).collect()
        };
        let starts = choices(self.settings.start, &self.starts);
        let ends = choices(self.settings.end, &self.ends);
        let mut best: Option<Choice> = None;
        let (mut piece_bound, mut bound) = (u32::MAX, u64::MAX);
        for (start, end) in
            starts.iter().flat_map(|&start| ends.iter().map(move |&end| (start, end)))
        {
            if !self.is_possible(start, end) {
                continue;
            }
            let mut choice = Choice { start, end, ..Choice::default() };
            for number in 0..self.boards.len() {
                choice.add(self.part(number, start, end));
            }
            // With more pieces than needed, another part may have those too many.
            let surplus = choice.pieces - choice.piece_bound;
            if surplus > 0 && self.boards.len() > 1 {
                let most =
                    |number: usize| self.parts[&key(number, start, end)].piece_bound + surplus;
                choice.bound = (0..self.boards.len())
                    .map(|number| flow::cost_in(&self.boards[number], most(number)))
                    .sum();
            }
            // A cover can be cut into more pieces at no cost, so a bound for more pieces holds for
            // fewer too.
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

    /// A part can't hold both ends if both must be at one cell, unless that is all there is.
    fn is_possible(&self, start: Option<usize>, end: Option<usize>) -> bool {
        let Some(part) = start.filter(|_| start == end) else { return true };
        match self.boards[part].cells.len() {
            1 => self.boards.len() == 1,
            _ => self.starts[part].len() > 1 || self.starts[part] != self.ends[part],
        }
    }

    fn part(&mut self, number: usize, start: Option<usize>, end: Option<usize>) -> &Part {
        let key @ (_, begins, stops) = key(number, start, end);
        let Self { boards, starts, ends, costs, settings, interrupt, parts } = self;
        parts.entry(key).or_insert_with(|| {
            let ends = Ends {
                first: if begins { starts[number].clone() } else { Vec::new() },
                last: if stops { ends[number].clone() } else { Vec::new() },
                apart: begins && stops && boards.len() > 1,
            };
            // A stream of its own for each part, so that one part's attempts don't change
            // another's.
            let stream = (number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed.wrapping_add(stream));
            part::solve(&boards[number], &ends, costs, settings, *interrupt, rng)
        })
    }

    /// The plan of all parts: the piece with the start first, the one with the end last.
    fn join(mut self, region: &Region, zones: &Zones, choice: &Choice) -> Plan {
        let &Choice { start, end, piece_bound, bound, attempts, stop, .. } = choice;
        let mut numbers: Vec<usize> = (0..self.boards.len()).collect();
        numbers.sort_by_key(|&part| start != Some(part));
        let mut order: Vec<Cell> = Vec::with_capacity(region.cell_count() as usize);
        let mut last = Vec::new();
        for number in numbers {
            let board = &self.boards[number];
            let part = self.part(number, start, end);
            let cells = |nodes: &[Node]| -> Vec<Cell> {
                nodes.iter().map(|&node| board.cell(node)).collect()
            };
            let (begin, rest) =
                part.order.split_at(if end == Some(number) { part.last_piece } else { 0 });
            if end == Some(number) {
                order.extend(cells(begin));
                last = cells(rest);
            } else {
                order.extend(cells(rest));
            }
        }
        order.append(&mut last);
        let path = Path::in_pieces(region, order).expect("the parts hold every cell once");
        // Counted anew: where one piece happens to end beside the next one they are one.
        let crossings = Crossings::new(region, zones).count(&path);
        let cost = |step: &[Cell]| u64::from(self.costs.cost(zones.id(step[0]), zones.id(step[1])));
        let cost = path.iter_pieces().flat_map(|piece| piece.windows(2)).map(cost).sum();
        Plan { pieces: path.pieces(), piece_bound, crossings, cost, bound, stop, attempts, path }
    }
}

/// A part, and whether the path begins and ends in it.
fn key(number: usize, start: Option<usize>, end: Option<usize>) -> (usize, bool, bool) {
    (number, start == Some(number), end == Some(number))
}

/// The parts that hold the ends, and what the plan comes to.
#[derive(Clone, Copy)]
struct Choice {
    start: Option<usize>,
    end: Option<usize>,
    pieces: u32,
    piece_bound: u32,
    cost: u64,
    bound: u64,
    attempts: u32,
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
    fn add(&mut self, part: &Part) {
        self.pieces += part.pieces;
        self.piece_bound += part.piece_bound;
        self.cost += part.cost;
        self.bound += part.bound;
        self.attempts += part.attempts;
        if part.stop != Stop::Optimal && matches!(self.stop, Stop::Optimal | Stop::Done) {
            self.stop = part.stop;
        }
    }
}
