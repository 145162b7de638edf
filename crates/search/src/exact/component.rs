//! The search of one connected component: repeated attempts, until a cover meets the lower bound.
//!
//! # Attempts
//! A cover of n cells with p pieces has n - p links.
//! An attempt finds the cheapest 2-matching with n - `target` links, reserving room at the cells
//! where the path has to begin and end, and changes it into a cover ([`Completion`]).
//! Attempts differ in the ladders that they start from and in random choices.
//! The search ends when the best cover has `target` pieces and costs no more than the bound.
//!
//! # Number of pieces
//! `target` starts at the minimum, 1 or 2, and only rises.
//! It rises when no 2-matching has that many links, or none has room at the given ends.
//! Both prove that more pieces are needed, unless room was missing only because of the cells chosen
//! among several possible ends.
//! It also rises when attempts fail to find a cover with as few pieces: after the second one if a
//! lower bound proves that there is none, otherwise after [`ATTEMPTS_PER_TARGET`] attempts, without
//! a proof.
//! In the latter case `target` exceeds `piece_bound`, and the outcome is not optimal.
//!
//! # Lower bounds
//! Bounds on the cost are computed one after the other ([`BoundLevel`]), the fast ones first, and
//! only as long as the best cover costs more.
//! All hold for covers with `target` pieces, so they start over whenever `target` changes.

use beadwork_base::Control;
use beadwork_grid::Path;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::complete::{Completion, show_stage};
use super::cover::{Cover, CoverEnds};
use super::settings::{AttemptReport, Settings, Stage, StageObserver};
use super::terminal::EndCells;
use crate::bound::connectivity::{MIN_EXTRA_COST, Separation};
use crate::bound::cuts::Cuts;
use crate::bound::{segments, walk};
use crate::matching::{Board, ComponentGraph, Dir, LadderLayout, Node, ShortestPaths, TwoMatching};
use crate::random::below;
use crate::{CostMatrix, Stop};

/// The best cover of one component, and proven bounds.
pub(super) struct ComponentCover {
    /// The cells, piece after piece.
    pub(super) order: Vec<Node>,
    /// Index in `order` at which the last piece begins.
    pub(super) last_piece: usize,
    pub(super) pieces: u32,
    /// Lower bound on the pieces of any cover with these ends.
    pub(super) piece_bound: u32,
    pub(super) cost: u64,
    /// Lower bound on the cost of any cover with `pieces` pieces and these ends.
    pub(super) bound: u64,
    pub(super) attempts: u32,
    pub(super) stop: Stop,
}

/// Number of failed attempts after which the search allows one more piece.
const ATTEMPTS_PER_TARGET: u32 = 12;

/// Number of attempts made before the bound is raised by subgradient steps: on most layers fewer
/// attempts are enough, and an attempt takes less time than the steps.
const ATTEMPTS_BEFORE_SUBGRADIENT: u32 = 3;

/// Number of attempts that start from the path of the layer below, if there is one.
/// Later ones start from ladders, in case that path leads nowhere.
const ATTEMPTS_FROM_BELOW: u32 = 4;

/// Covers one component: makes attempts until a cover is proven optimal, the attempts are used up,
/// or the search is interrupted.
///
/// `report` is called after each attempt with the number of attempts so far.
pub(super) fn solve(
    board: &Board,
    ends: &EndCells,
    costs: &CostMatrix,
    settings: &Settings<'_>,
    control: &Control<'_>,
    report: impl Fn(u32),
    rng: Xoshiro256PlusPlus,
) -> ComponentCover {
    if let [only] = board.cells[..] {
        return ComponentCover {
            order: vec![only],
            last_piece: 0,
            pieces: 1,
            piece_bound: 1,
            cost: 0,
            bound: 0,
            attempts: 0,
            stop: Stop::Optimal,
        };
    }
    let target = 1 + u32::from(ends.in_different_pieces);
    let mut search = ComponentSearch {
        board,
        ends,
        costs,
        control,
        stages: settings.observers.stage,
        columns_first: settings.columns_first,
        below: settings.below,
        rng,
        graph: ComponentGraph::of_zones(board),
        paths: ShortestPaths::new(board),
        reserved: [None; 2],
        target,
        piece_bound: target,
        bound: 0,
        bound_level: BoundLevel::None,
        best: None,
    };
    let mut attempts = 0;
    let mut attempts_at_target = 0;
    let stop = loop {
        let best = search.attempt(attempts);
        let (pieces, cost) = (best.pieces, costs.unscaled(best.cost));
        attempts += 1;
        attempts_at_target += 1;
        if let Some(observer) = settings.observers.attempt {
            observer(AttemptReport { cells: board.cells.len() as u32, attempts, pieces, cost });
        }
        report(attempts);
        if search.is_bound_met() {
            let is_optimal = search.target == search.piece_bound;
            break if is_optimal { Stop::Optimal } else { Stop::Done };
        }
        if attempts >= settings.attempts {
            break Stop::Done;
        }
        if let Some(interrupted) = control.interrupted() {
            break interrupted.into();
        }
        if search.reconsider_target(attempts_at_target) {
            attempts_at_target = 0;
        }
    };
    search.finish(attempts, stop)
}

/// The bounds that have been computed for the present number of pieces; each level includes those
/// before.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum BoundLevel {
    /// No bound yet.
    None,
    /// The cost of the cheapest 2-matching (minimum-cost flow).
    Flow,
    /// Counts in the graph of zone components: segments, scattering, shortest walks.
    Zones,
    /// The cost of connecting components that no cheapest 2-matching connects, and cuts on the sets
    /// of cells that all of them close.
    Connectivity,
    /// Cuts on further sets, weighted by subgradient steps.
    Subgradient,
}

/// The state of the search of one component.
struct ComponentSearch<'a> {
    board: &'a Board,
    ends: &'a EndCells,
    costs: &'a CostMatrix,
    control: &'a Control<'a>,
    /// Observes the stages of the first attempt; `None` after it.
    stages: Option<&'a StageObserver<'a>>,
    columns_first: bool,
    /// The path of the layer below to start from; `None` after [`ATTEMPTS_FROM_BELOW`].
    below: Option<&'a Path>,
    rng: Xoshiro256PlusPlus,
    /// The groups of cells that attempts have to connect: the zone components, or smaller groups
    /// once the connectivity bound shows where the cheapest 2-matchings are unconnected.
    graph: ComponentGraph,
    paths: ShortestPaths,
    /// The cells at which the present attempt reserves room for the start and the end.
    reserved: [Option<Node>; 2],
    /// The number of pieces that attempts try for.
    target: u32,
    /// Proven lower bound on the pieces of any cover with these ends.
    piece_bound: u32,
    /// Proven lower bound on the cost of a cover with `target` pieces.
    bound: u64,
    bound_level: BoundLevel,
    best: Option<Cover>,
}

impl ComponentSearch<'_> {
    /// Makes a cover, keeps it if it is the best so far, raises the bound if it is not met, and
    /// returns the best cover.
    fn attempt(&mut self, number: u32) -> &Cover {
        // Successive attempts alternate between rows and columns, and every second pair shifts the
        // ladders by one row or column.
        let turns = number + u32::from(self.columns_first);
        let layout = LadderLayout { along: (turns % 2) as Dir, odd: (number / 2) % 2 == 1 };
        // The board charges the cheaper direction of each pair of zones, which gives a bound.
        // Where the costs of the two directions differ much, it is a poor guide, so later attempts
        // draw random costs between them.
        let guide =
            (number > 1 && self.bound_level != BoundLevel::None && !self.costs.is_symmetric())
                .then(|| self.board.with_costs(self.costs.between_directions(&mut self.rng)));
        let (relaxed, mut matching) =
            self.cheapest_matching(guide.as_ref().unwrap_or(self.board), layout);
        if number + 1 >= ATTEMPTS_FROM_BELOW {
            self.below = None;
        }
        // The completion changes the matching, but the bounds below start from it.
        let relaxed = relaxed.unwrap_or_else(|| matching.clone());
        if let Some(cover) = self.complete(&mut matching)
            && self
                .best
                .as_ref()
                .is_none_or(|best| (cover.pieces, cover.cost) < (best.pieces, best.cost))
        {
            self.best = Some(cover);
        }
        self.stages = None;
        if self.bound_level == BoundLevel::Flow && !self.is_bound_met() {
            self.bound_by_zones();
        }
        // The remaining bounds raise the flow bound step by step.
        // Where the zone counts exceed it, another attempt takes less time than raising it above
        // them.
        let is_flow_best = self.bound <= relaxed.cost() as u64;
        let is_due = self.bound_level == BoundLevel::Zones && (number > 0 || is_flow_best);
        if is_due && guide.is_none() && !self.is_bound_met() {
            self.bound_by_connectivity(&relaxed);
        }
        if self.bound_level == BoundLevel::Connectivity
            && number >= ATTEMPTS_BEFORE_SUBGRADIENT
            && guide.is_none()
            && !self.is_bound_met()
        {
            self.raise_bound(Cuts::Subgradient, &relaxed);
            self.bound_level = BoundLevel::Subgradient;
        }
        self.best.as_ref().expect("the first attempt gives a cover")
    }

    /// Whether the best cover has `target` pieces and costs no more than the bound.
    fn is_bound_met(&self) -> bool {
        self.best.as_ref().is_some_and(|best| best.pieces == self.target && best.cost <= self.bound)
    }

    /// The cheapest 2-matching for `target` pieces that has room at one cell for the start and one
    /// for the end, where these are restricted.
    /// It is the second of the results.
    /// The first is the cheapest 2-matching without room at ends that can be chosen among several
    /// cells, from which the bounds start; `None` if there are no such ends.
    ///
    /// Raises `target` until there is such a 2-matching.
    /// Sets the flow bound if no bound is known yet and the board is the component's own.
    ///
    /// The cells chosen for the start and the end may not be the best pair: the end with fewer
    /// cells takes its cheapest one first, then the other end takes its own.
    /// So the bound uses each end alone, which is at most the cost of any pair.
    fn cheapest_matching<'b>(
        &mut self,
        board: &'b Board,
        layout: LadderLayout,
    ) -> (Option<TwoMatching<'b>>, TwoMatching<'b>) {
        let mut sides: Vec<(usize, &[Node])> = vec![(0, &self.ends.first), (1, &self.ends.last)];
        sides.retain(|(_, cells)| !cells.is_empty());
        // An end with a single cell leaves no choice.
        // It goes first, so that the choice for the other one takes it into account.
        sides.sort_by_key(|(_, cells)| cells.len());
        let single = sides.iter().take_while(|(_, cells)| cells.len() == 1).count();
        // Pieces added because of the cells chosen for the ends: they do not raise the proven
        // minimum.
        let mut unproven_pieces = 0;
        'pieces: loop {
            let mut matching = self.grow_matching(board, layout);
            let mut reserved = [None; 2];
            for &(end, cells) in &sides[..single] {
                let Some((_, cell)) = self.paths.reserve_end(&mut matching, cells) else {
                    self.allow_one_more_piece();
                    continue 'pieces;
                };
                reserved[end] = Some(cell);
            }
            let relaxed = (single < sides.len()).then(|| matching.clone());
            let mut flow = matching.cost();
            for (index, &(end, cells)) in sides[single..].iter().enumerate() {
                let mut alone = relaxed.clone().expect("there are ends to choose");
                let chosen_alone = self.paths.reserve_end(&mut alone, cells);
                flow = flow.max(alone.cost());
                let chosen = if index == 0 {
                    matching = alone;
                    chosen_alone
                } else {
                    chosen_alone.and_then(|_| self.paths.reserve_end(&mut matching, cells))
                };
                let Some((_, cell)) = chosen else {
                    unproven_pieces += u32::from(chosen_alone.is_some());
                    self.allow_one_more_piece();
                    continue 'pieces;
                };
                reserved[end] = Some(cell);
            }
            self.reserved = reserved;
            if self.bound_level == BoundLevel::None && std::ptr::eq(board, self.board) {
                self.bound_level = BoundLevel::Flow;
                self.bound = flow as u64;
                if self.best.is_none() {
                    self.piece_bound = self.target - unproven_pieces;
                }
            }
            return (relaxed, matching);
        }
    }

    /// Raises `target` by one; bounds for fewer pieces do not hold for more.
    fn allow_one_more_piece(&mut self) {
        self.target += 1;
        if self.bound_level != BoundLevel::None {
            self.forget_bounds();
        }
    }

    /// The cheapest 2-matching for `target` pieces, wherever they begin and end.
    ///
    /// Each piece has two ends with room for a link, so the total room is 2 `target`.
    /// Raises `target` if a maximum 2-matching leaves more room.
    fn grow_matching<'b>(&mut self, board: &'b Board, layout: LadderLayout) -> TwoMatching<'b> {
        let mut matching = match self.below {
            Some(below) => TwoMatching::as_below(board, below),
            None => TwoMatching::inside_zones(board, layout),
        };
        let total_room = 2 * self.target;
        matching.remove_links_inside(total_room, |count| below(&mut self.rng, count));
        show_stage(self.stages, Stage::Ladders, &matching);
        matching.grow(total_room);
        self.target = self.target.max(matching.total_room.div_ceil(2));
        matching
    }

    /// Raises the bound by counting in the graph of zone components, in units of the cheapest
    /// crossing.
    /// Where costs depend on the direction, the flow also uses costs that are shifted so that the
    /// two directions differ less ([`CostMatrix::shifted_by_potentials`]).
    fn bound_by_zones(&mut self) {
        let min_segments = vec![1; self.graph.count() as usize];
        let crossings = segments::count(&min_segments, self.target)
            .max(segments::scattering(&self.graph, &min_segments, self.target))
            .max(walk::min_steps(&self.graph, self.target).unwrap_or(0));
        self.bound =
            self.bound.max(u64::from(crossings) * u64::from(self.board.min_crossing_cost()));
        self.bound_level = BoundLevel::Zones;
        if !self.costs.is_symmetric() {
            let (shifted, error) = self.costs.shifted_by_potentials();
            let board = self.board.with_costs(shifted);
            let cost = self.grow_matching(&board, LadderLayout::default()).cost()
                - i64::from(error) * i64::from(self.target);
            self.bound = self.bound.max(cost.max(0) as u64);
        }
    }

    /// Raises the bound if the links of all cheapest 2-matchings together leave cells unconnected.
    /// Later attempts connect these groups of cells first.
    fn bound_by_connectivity(&mut self, relaxed: &TwoMatching<'_>) {
        self.bound_level = BoundLevel::Connectivity;
        let Some(separation) = Separation::find(relaxed, self.target) else { return };
        let enough = self.raise_bound(Cuts::ClosedInAll, relaxed);
        if self.bound < enough {
            // The exact cost of leaving a group takes a search for each link along its border.
            // It rarely exceeds 2, so it is only computed where 2 would be enough.
            let flow = relaxed.cost() as u64;
            let extra = if enough <= flow + 2 {
                separation.extra_cost(relaxed, self.target, &mut self.paths)
            } else {
                MIN_EXTRA_COST
            };
            self.bound = self.bound.max(flow + u64::from(extra));
        }
        self.graph = separation.graph;
    }

    /// Raises the bound by cuts, which stop at the cost of the best cover with `target` pieces.
    /// Returns that cost; `u64::MAX` if there is no such cover.
    fn raise_bound(&mut self, cuts: Cuts, relaxed: &TwoMatching<'_>) -> u64 {
        let best = self.best.as_ref().filter(|best| best.pieces == self.target);
        let enough = best.map_or(u64::MAX, |best| best.cost);
        let bound = cuts.bound(relaxed, self.target, &mut self.paths, enough, self.control);
        self.bound = self.bound.max(bound);
        enough
    }

    /// Changes a 2-matching into a cover; `None` if it would not be better than the best one.
    fn complete(&mut self, matching: &mut TwoMatching<'_>) -> Option<Cover> {
        // Costs on a guide board are not those of the cover, so they can't rule it out.
        let comparable = self
            .best
            .as_ref()
            .filter(|best| best.pieces <= self.target && std::ptr::eq(matching.board, self.board));
        let [first, last] = self.reserved;
        let completion = Completion {
            graph: &self.graph,
            // With a single piece both ends are on it, as they have to be.
            separate_ends: first.zip(last).filter(|_| self.target > 1).map(<[Node; 2]>::from),
            cost_limit: comparable.map_or(u64::MAX, |best| best.cost),
            paths: &mut self.paths,
            rng: &mut self.rng,
            control: self.control,
            stages: self.stages,
        };
        let strands = completion.run(matching)?;
        let in_different_pieces = self.ends.in_different_pieces;
        let ends = CoverEnds { first, last, in_different_pieces };
        Some(Cover::new(matching, &strands, self.board, self.costs, ends))
    }

    /// Raises `target` if it is proven that no cover has `target` pieces, or if enough attempts
    /// have failed to find one.
    /// Returns whether it did.
    fn reconsider_target(&mut self, attempts_at_target: u32) -> bool {
        let Some(found) = self.best.as_ref().map(|best| best.pieces) else { return false };
        if found <= self.target {
            return false;
        }
        if attempts_at_target == 2 && self.is_target_refuted() {
            self.target += 1;
            self.piece_bound = self.piece_bound.max(self.target);
        } else if attempts_at_target >= ATTEMPTS_PER_TARGET {
            self.target += 1;
        } else {
            return false;
        }
        self.forget_bounds();
        true
    }

    fn forget_bounds(&mut self) {
        self.bound_level = BoundLevel::None;
        self.bound = 0;
        self.graph = ComponentGraph::of_zones(self.board);
    }

    /// Whether it is proven that no cover has `target` pieces.
    ///
    /// On a board where crossings are free, every cover costs 0. Cuts charge 2-matchings for the
    /// sets of cells that they close, and their bound holds for covers.
    /// So a bound above 0 proves that no cover with `target` pieces exists.
    fn is_target_refuted(&mut self) -> bool {
        let free = self.board.without_zones();
        let mut matching = TwoMatching::inside_zones(&free, LadderLayout::default());
        matching.remove_links_inside(2 * self.target, |_| 0);
        matching.grow(2 * self.target);
        for cells in [&self.ends.first, &self.ends.last] {
            if let [_] = cells[..] {
                self.paths.reserve_end(&mut matching, cells);
            }
        }
        Cuts::Subgradient.bound(&matching, self.target, &mut self.paths, 1, self.control) > 0
    }

    /// The best cover, with bounds for its own number of pieces.
    fn finish(mut self, attempts: u32, stop: Stop) -> ComponentCover {
        let pieces = self.best.as_ref().expect("an attempt was made").pieces;
        if pieces != self.target {
            self.target = pieces;
            self.forget_bounds();
            self.cheapest_matching(self.board, LadderLayout::default());
            self.bound_by_zones();
        }
        let Cover { order, last_piece, pieces, cost } = self.best.expect("an attempt was made");
        let (piece_bound, bound) = (self.piece_bound, self.bound);
        ComponentCover { order, last_piece, pieces, piece_bound, cost, bound, attempts, stop }
    }
}
