//! Attempts at one connected part of a region.

use beadwork_grid::Path;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::ends::Ends;
use super::link::{force_cheapest, link};
use super::merge::{merge, merge_at_any_cost};
use super::strands::Strands;
use super::untangle::untangle;
use super::{Progress, Settings, Stage, StageObserver};
use crate::bound::connectivity::{self, Apart};
use crate::bound::cuts::Cuts;
use crate::bound::{segments, walk};
use crate::matching::{Board, Dir, Grain, Matching, Node, Paths, ZoneGraph};
use crate::random::below;
use crate::stop::Interrupt;
use crate::{Stop, ZoneCosts};

/// The best cover of one part.
pub(super) struct Part {
    /// Its cells, piece after piece.
    pub(super) order: Vec<Node>,
    /// Where in the order the last piece begins.
    pub(super) last_piece: usize,
    pub(super) pieces: u32,
    pub(super) piece_bound: u32,
    pub(super) cost: u64,
    pub(super) bound: u64,
    pub(super) attempts: u32,
    pub(super) stop: Stop,
}

/// Attempts in vain after which a number of pieces is given up.
const ATTEMPTS_AT_PIECES: u32 = 12;

/// Attempts before the bound is raised in small steps: most layers need no more attempts, and an
/// attempt takes less time.
const ATTEMPTS_BEFORE_STEPS: u32 = 3;

/// Attempts that begin with the path of the layer below, where there is one, before others forget
/// it.
const ATTEMPTS_FROM_BELOW: u32 = 4;

/// Exchanges that one attempt may make to join its last cycles, and how often it may pay for one
/// more link between.
const EXCHANGES: u64 = 100;
const LINKS_PAID: u32 = 5;

/// Covers a part: attempts until one is proven optimal, or until something stops it.
pub(super) fn solve(
    board: &Board,
    ends: &Ends,
    costs: &ZoneCosts,
    settings: &Settings<'_>,
    interrupt: Interrupt<'_>,
    rng: Xoshiro256PlusPlus,
) -> Part {
    if let [only] = board.cells[..] {
        let (order, stop) = (vec![only], Stop::Optimal);
        return Part {
            order,
            last_piece: 0,
            pieces: 1,
            piece_bound: 1,
            cost: 0,
            bound: 0,
            attempts: 0,
            stop,
        };
    }
    let target = 1 + u32::from(ends.apart);
    let mut search = Search {
        board,
        ends,
        costs,
        interrupt,
        stages: settings.stages,
        columns_first: settings.columns_first,
        below: settings.below,
        rng,
        graph: ZoneGraph::new(board),
        paths: Paths::new(board),
        reserved: [None; 2],
        target,
        piece_bound: target,
        bound: 0,
        bounds: Bounds::Due,
        best: None,
    };
    let mut attempts = 0;
    let mut at_target = 0;
    let stop = loop {
        let best = search.attempt(attempts);
        let progress = Progress {
            cells: board.cells.len() as u32,
            attempts: attempts + 1,
            pieces: best.pieces,
            cost: best.cost,
        };
        attempts += 1;
        at_target += 1;
        if let Some(observer) = settings.observer {
            observer(progress);
        }
        if search.is_met() {
            let optimal = search.target == search.piece_bound;
            break if optimal { Stop::Optimal } else { Stop::Done };
        }
        if attempts >= settings.attempts {
            break Stop::Done;
        }
        if let Some(stop) = interrupt.check() {
            break stop;
        }
        if search.reconsider_pieces(at_target) {
            at_target = 0;
        }
    };
    search.finish(attempts, stop)
}

/// A cover that was found.
struct Cover {
    order: Vec<Node>,
    last_piece: usize,
    pieces: u32,
    cost: u64,
}

/// Which bounds of the present number of pieces are known.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Bounds {
    /// None.
    Due,
    /// The flow's.
    Flow,
    /// Those of the graph of zone components too.
    Zones,
    /// And those from what no cheapest 2-matching links.
    Apart,
    /// All.
    All,
}

struct Search<'a> {
    board: &'a Board,
    ends: &'a Ends,
    costs: &'a ZoneCosts,
    interrupt: Interrupt<'a>,
    /// To be told of the stages; `None` after the first attempt.
    stages: Option<&'a StageObserver<'a>>,
    columns_first: bool,
    /// The path of the layer below, to begin with; `None` once that was tried often enough.
    below: Option<&'a Path>,
    rng: Xoshiro256PlusPlus,
    /// What has to hang together: the zone components, or finer once it is known what the cheapest
    /// 2-matchings leave apart.
    graph: ZoneGraph,
    paths: Paths,
    /// The cells that the present attempt keeps for the beginning and the end.
    reserved: [Option<Node>; 2],
    /// The number of pieces tried for.
    target: u32,
    /// Pieces needed at least.
    piece_bound: u32,
    /// Lower bound of the cost of a cover in `target` pieces.
    bound: u64,
    bounds: Bounds,
    best: Option<Cover>,
}

impl Search<'_> {
    /// Makes a cover, keeps it if it is the best so far, and gives the best.
    fn attempt(&mut self, number: u32) -> &Cover {
        let turns = number + u32::from(self.columns_first);
        let grain = Grain { along: (turns % 2) as Dir, odd: (number / 2) % 2 == 1 };
        // Where directions differ, what a crossing costs at least gives a bound, but is a poor
        // guide to a path.
        let guide = (number > 1 && self.bounds != Bounds::Due && !self.costs.is_symmetric())
            .then(|| self.board.with_costs(self.costs.drawn(&mut self.rng)));
        let (relaxed, matching) = self.cheapest(guide.as_ref().unwrap_or(self.board), grain);
        if number + 1 >= ATTEMPTS_FROM_BELOW {
            self.below = None;
        }
        // What the bounds may need: not each cover meets the first of them.
        let relaxed = relaxed.unwrap_or_else(|| matching.clone());
        if let Some(cover) = self.complete(matching)
            && self
                .best
                .as_ref()
                .is_none_or(|best| (cover.pieces, cover.cost) < (best.pieces, best.cost))
        {
            self.best = Some(cover);
        }
        if self.bounds == Bounds::Flow && !self.is_met() {
            self.bound_by_zones();
        }
        // Where the zones say more than the flow, another attempt takes less time than what could
        // raise the flow above them.
        let is_flow_best = self.bound <= relaxed.cost() as u64;
        let is_due = self.bounds == Bounds::Zones && (number > 0 || is_flow_best);
        if is_due && guide.is_none() && !self.is_met() {
            self.bound_by_what_is_apart(&relaxed);
        }
        if self.bounds == Bounds::Apart
            && number >= ATTEMPTS_BEFORE_STEPS
            && guide.is_none()
            && !self.is_met()
        {
            self.raise_bound(Cuts::Stepwise, &relaxed);
            self.bounds = Bounds::All;
        }
        self.best.as_ref().expect("the first attempt gives a cover")
    }

    /// Whether the best cover has as many pieces as are tried for, and no other such cover costs
    /// less.
    fn is_met(&self) -> bool {
        self.best.as_ref().is_some_and(|best| best.pieces == self.target && best.cost <= self.bound)
    }

    /// The cheapest 2-matching for so many pieces that has room at the cells where the path must
    /// begin and end; and, if these could be chosen, one without that.
    ///
    /// Raises the number of pieces, and their bound, as far as the cells' colours and the ends
    /// demand.
    fn cheapest<'b>(
        &mut self,
        board: &'b Board,
        grain: Grain,
    ) -> (Option<Matching<'b>>, Matching<'b>) {
        let mut sides: Vec<(usize, &[Node])> = vec![(0, &self.ends.first), (1, &self.ends.last)];
        sides.retain(|(_, cells)| !cells.is_empty());
        // A given cell leaves no choice, so it goes first: what follows is then as cheap as can be.
        sides.sort_by_key(|(_, cells)| cells.len());
        let given = sides.iter().take_while(|(_, cells)| cells.len() == 1).count();
        let mut unproven = 0;
        'pieces: loop {
            let mut matching = self.grown(board, grain);
            let mut reserved = [None; 2];
            for &(end, cells) in &sides[..given] {
                let Some((_, cell)) = self.paths.reserve(&mut matching, cells) else {
                    self.try_for_one_more();
                    continue 'pieces;
                };
                reserved[end] = Some(cell);
            }
            let relaxed = (given < sides.len()).then(|| matching.clone());
            let mut flow = matching.cost();
            for (index, &(end, cells)) in sides[given..].iter().enumerate() {
                // Chosen alone, the second end may be cheaper than after the first one; only that
                // is a bound.
                let mut alone = relaxed.clone().expect("there are ends to choose");
                let chosen_alone = self.paths.reserve(&mut alone, cells);
                flow = flow.max(alone.cost());
                let chosen = if index == 0 {
                    matching = alone;
                    chosen_alone
                } else {
                    chosen_alone.and_then(|_| self.paths.reserve(&mut matching, cells))
                };
                let Some((_, cell)) = chosen else {
                    unproven += u32::from(chosen_alone.is_some());
                    self.try_for_one_more();
                    continue 'pieces;
                };
                reserved[end] = Some(cell);
            }
            self.reserved = reserved;
            if self.bounds == Bounds::Due && std::ptr::eq(board, self.board) {
                self.bounds = Bounds::Flow;
                self.bound = flow as u64;
                if self.best.is_none() {
                    self.piece_bound = self.target - unproven;
                }
            }
            return (relaxed, matching);
        }
    }

    /// Tries for one piece more from now on; bounds of fewer pieces are none of more.
    fn try_for_one_more(&mut self) {
        self.target += 1;
        if self.bounds != Bounds::Due {
            self.forget_bounds();
        }
    }

    /// The cheapest 2-matching for so many pieces, wherever they begin and end.
    fn grown<'b>(&mut self, board: &'b Board, grain: Grain) -> Matching<'b> {
        let mut matching = match self.below {
            Some(below) => Matching::as_below(board, below),
            None => Matching::inside_zones(board, grain),
        };
        let spare = 2 * self.target;
        matching.drop_links_inside(spare, |count| below(&mut self.rng, count));
        self.tell(Stage::Ladders, &matching);
        matching.grow(spare);
        self.target = self.target.max(matching.spare.div_ceil(2));
        matching
    }

    /// Bounds from the graph of zone components, in units of the cheapest crossing; and the flow's
    /// with costs whose directions are more alike.
    fn bound_by_zones(&mut self) {
        let need = vec![1; self.graph.count() as usize];
        let crossings = segments::cover(&need, self.target)
            .max(segments::scattering(&self.graph, &need, self.target))
            .max(walk::walk(&self.graph, self.target).unwrap_or(0));
        self.bound = self.bound.max(u64::from(crossings) * u64::from(self.board.least_cost()));
        self.bounds = Bounds::Zones;
        if !self.costs.is_symmetric() {
            let (levelled, spread) = self.costs.levelled();
            let board = self.board.with_costs(levelled);
            let cost = self.grown(&board, Grain::default()).cost()
                - i64::from(spread) * i64::from(self.target);
            self.bound = self.bound.max(cost.max(0) as u64);
        }
    }

    /// Bounds from what the cheapest 2-matchings leave apart, which attempts from now on link
    /// first.
    fn bound_by_what_is_apart(&mut self, relaxed: &Matching<'_>) {
        self.bounds = Bounds::Apart;
        let Some(apart) = Apart::new(relaxed, self.target) else { return };
        let enough = self.raise_bound(Cuts::NeverLeft, relaxed);
        if self.bound < enough {
            // To know what it costs to leave a component takes a search for each link along its
            // border; it is seldom more than 2.
            let flow = relaxed.cost() as u64;
            let extra = if enough <= flow + 2 {
                connectivity::connectivity(&apart, relaxed, self.target, &mut self.paths)
            } else {
                connectivity::LEAST
            };
            self.bound = self.bound.max(flow + u64::from(extra));
        }
        self.graph = apart.graph;
    }

    /// Raises the bound by cuts, towards the cost of the best cover, which it gives.
    fn raise_bound(&mut self, cuts: Cuts, relaxed: &Matching<'_>) -> u64 {
        let best = self.best.as_ref().filter(|best| best.pieces == self.target);
        let enough = best.map_or(u64::MAX, |best| best.cost);
        let bound = cuts.bound(relaxed, self.target, &mut self.paths, enough, self.interrupt);
        self.bound = self.bound.max(bound);
        enough
    }

    /// Makes a cover of a 2-matching; `None` if it would not be the best.
    fn complete(&mut self, mut matching: Matching<'_>) -> Option<Cover> {
        let known = self
            .best
            .as_ref()
            .filter(|best| best.pieces <= self.target && std::ptr::eq(matching.board, self.board));
        let limit = known.map_or(u64::MAX, |best| best.cost);
        self.tell(Stage::Cheapest, &matching);
        link(&mut matching, &self.graph, &mut self.paths, &mut self.rng, self.interrupt);
        if matching.cost() as u64 >= limit {
            return None;
        }
        let apart = self.ends_apart();
        self.tell(Stage::Linked, &matching);
        merge(&mut matching);
        self.tell(Stage::Merged, &matching);
        let mut strands = Strands::new(&matching, apart);
        untangle(&mut matching, &mut strands, &mut self.rng, EXCHANGES, self.interrupt);
        for _ in 0..LINKS_PAID {
            if strands.is_settled() || self.interrupt.check().is_some() {
                break;
            }
            let links = strands.links_to_settle(&matching);
            if !force_cheapest(&mut matching, &links, &mut self.paths, &mut self.rng) {
                break;
            }
            if matching.cost() as u64 >= limit {
                return None;
            }
            merge(&mut matching);
            strands = Strands::new(&matching, apart);
            untangle(&mut matching, &mut strands, &mut self.rng, EXCHANGES, self.interrupt);
        }
        if strands.cycles > 0 {
            merge_at_any_cost(&mut matching);
            strands = Strands::new(&matching, apart);
        }
        self.tell(Stage::Settled, &matching);
        self.stages = None;
        Some(self.cover(&matching, &strands))
    }

    fn tell(&self, stage: Stage, matching: &Matching<'_>) {
        let Some(stages) = self.stages else { return };
        let board = matching.board;
        let from = |&node: &Node| {
            let linked = (0..2).filter(move |&dir| matching.is_linked(node, dir));
            linked.map(move |dir| [node, board.step(node, dir)].map(|node| board.cell(node)))
        };
        stages(stage, &board.cells.iter().flat_map(from).collect::<Vec<_>>());
    }

    /// The cells where the path begins and ends, if other pieces lie between.
    fn ends_apart(&self) -> Option<[Node; 2]> {
        let [first, last] = self.reserved;
        (self.target > 1).then_some(())?;
        Some([first?, last?])
    }

    /// The pieces in order: the one that holds the start first, the one that holds the end last.
    fn cover(&self, matching: &Matching<'_>, strands: &Strands) -> Cover {
        let mut pieces = strands.pieces(matching);
        let [first, last] = self.reserved;
        order_pieces(&mut pieces, first, last, self.ends.apart);
        let cost = |piece: &[Node]| -> u64 {
            piece
                .windows(2)
                .map(|step| {
                    u64::from(self.costs.cost(self.board.zone(step[0]), self.board.zone(step[1])))
                })
                .sum()
        };
        let mut total = 0;
        for piece in &mut pieces {
            let forward = cost(piece);
            let is_fixed = first == Some(piece[0]) || last == Some(piece[piece.len() - 1]);
            piece.reverse();
            let backward = cost(piece);
            if is_fixed || forward <= backward {
                piece.reverse();
            }
            total += if is_fixed { forward } else { forward.min(backward) };
        }
        let cells = pieces.iter().map(Vec::len).sum::<usize>();
        let last_piece = cells - pieces.last().map_or(0, Vec::len);
        Cover { pieces: pieces.len() as u32, cost: total, last_piece, order: pieces.concat() }
    }

    /// After attempts in vain: shows that the pieces are too few, or gives them up.
    /// True if others are tried for from now on.
    fn reconsider_pieces(&mut self, attempts: u32) -> bool {
        let Some(found) = self.best.as_ref().map(|best| best.pieces) else { return false };
        if found <= self.target {
            return false;
        }
        if attempts == 2 && self.is_refuted() {
            self.target += 1;
            self.piece_bound = self.piece_bound.max(self.target);
        } else if attempts >= ATTEMPTS_AT_PIECES {
            self.target += 1;
        } else {
            return false;
        }
        self.forget_bounds();
        true
    }

    fn forget_bounds(&mut self) {
        self.bounds = Bounds::Due;
        self.bound = 0;
        self.graph = ZoneGraph::new(self.board);
    }

    /// Whether no cover has as few pieces as are tried for: if crossings cost nothing a cover would
    /// cost nothing, but closed sets of cells cost something even then.
    fn is_refuted(&mut self) -> bool {
        let free = self.board.without_zones();
        let mut matching = Matching::inside_zones(&free, Grain::default());
        matching.drop_links_inside(2 * self.target, |_| 0);
        matching.grow(2 * self.target);
        for cells in [&self.ends.first, &self.ends.last] {
            if let [_] = cells[..] {
                self.paths.reserve(&mut matching, cells);
            }
        }
        Cuts::Stepwise.bound(&matching, self.target, &mut self.paths, 1, self.interrupt) > 0
    }

    fn finish(mut self, attempts: u32, stop: Stop) -> Part {
        let pieces = self.best.as_ref().expect("an attempt was made").pieces;
        if pieces != self.target {
            // The bound must be one of the cover that is given.
            self.target = pieces;
            self.forget_bounds();
            self.cheapest(self.board, Grain::default());
            self.bound_by_zones();
        }
        let Cover { order, last_piece, pieces, cost } = self.best.expect("an attempt was made");
        let (piece_bound, bound) = (self.piece_bound, self.bound);
        Part { order, last_piece, pieces, piece_bound, cost, bound, attempts, stop }
    }
}

/// Brings pieces into the order and the directions that the ends ask for; cuts one in two if it
/// holds both and must not.
fn order_pieces(pieces: &mut Vec<Vec<Node>>, first: Option<Node>, last: Option<Node>, apart: bool) {
    // The topmost, leftmost piece first, so that the lifts between them stay short.
    pieces.sort_unstable_by_key(|piece| piece.iter().min().copied());
    let holds = |piece: &Vec<Node>, node: Node| piece[0] == node || piece[piece.len() - 1] == node;
    if let Some(first) = first {
        let index =
            pieces.iter().position(|piece| holds(piece, first)).expect("it is an end of a piece");
        let mut piece = pieces.remove(index);
        if piece[0] != first {
            piece.reverse();
        }
        pieces.insert(0, piece);
    }
    if let Some(last) = last {
        let index =
            pieces.iter().position(|piece| holds(piece, last)).expect("it is an end of a piece");
        let mut piece = pieces.remove(index);
        let both = first.is_some_and(|first| holds(&piece, first));
        if both && (apart || !pieces.is_empty()) {
            if piece[0] == last {
                piece.reverse();
            }
            let rest = piece.split_off(piece.len() / 2);
            pieces.insert(0, piece);
            piece = rest;
        }
        if piece[piece.len() - 1] != last {
            piece.reverse();
        }
        pieces.push(piece);
    }
}
