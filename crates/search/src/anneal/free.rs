//! Annealing with any two switches that together keep the number of pieces.
//!
//! A *switch* exchanges two parallel links of a unit cell (2 x 2 cells) for the other two.
//! Where the path passes the two links in opposite directions, as in neighbouring rows of a zigzag,
//! a switch splits it into a path and a cycle.
//! So a move consists of two switches, of which the second repairs what the first breaks.
//!
//! The first switch is drawn among the unit cells near zone borders, where costs can change.
//! If it would close a cycle, the second switch must join that cycle to the rest again.
//! It is drawn next to a random link of the cycle, or next to the first switch, where the move
//! usually rewrites only a short part of the path and is therefore cheap.
//! So most proposals with a second switch are valid moves, and the two switches may lie far apart,
//! whereas the paper's variants stay inside one window.

use beadwork_grid::{Cell, Path, Sides, Switch};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::method::Free;
use super::run::Run;
use super::settings::Outcome;
use crate::random::{below, scale};
use crate::{Cost, Move, Stop};

/// Number of proposals between two updates of the temperature, which also check whether to stop.
const BLOCK: u64 = 1024;

pub(super) fn anneal<C: Cost>(free: &Free, mut run: Run<'_>, cost: &C) -> Outcome {
    let corners = corners(&run.path, cost, free.reach);
    if corners.is_empty() {
        let stop = run.should_stop().unwrap_or(Stop::Done);
        return run.finish(stop, 0);
    }
    let touching = Touching::new(run.path.width());
    // The probability in 1/65536, to be compared with the lowest 16 bits of a random number.
    let nearby = (free.nearby * f64::from(1 << 16)) as u64;
    let mut proposals = 0;
    while proposals < free.proposals {
        let elapsed = proposals as f64 / free.proposals as f64;
        let temperature = free.hot * libm::pow(free.cold / free.hot, elapsed);
        let metropolis = Metropolis::new(temperature);
        run.report(proposals, free.proposals, temperature);
        if let Some(stop) = run.should_stop() {
            return run.finish(stop, proposals);
        }
        let block = BLOCK.min(free.proposals - proposals);
        for _ in 0..block {
            // The upper half of the bits selects the corner, the lowest 16 the kind of move.
            let random = run.rng.next_u64();
            let corner = corners[scale(random, corners.len())];
            let Some(from) = run.path.sides(corner) else { continue };
            let first = Switch::new(corner, from);
            let second = if random & 0xFFFF < nearby {
                touching.draw(&run.path, first, &mut run.rng)
            } else {
                draw_on_cycle(&run.path, first, &mut run.rng)
            };
            let Some(switches) = second.map(|second| [first, second]) else { continue };
            let change = cost.change(switches);
            let is_proposed =
                change != 0 || is_worth_its_span(&run.path, switches, free.span, &mut run.rng);
            if is_proposed && metropolis.accepts(change, &mut run.rng) && run.path.apply(&switches)
            {
                run.accept(Move::Pair(switches), change);
            }
        }
        proposals += block;
    }
    run.complete(proposals)
}

/// The eight unit cells that touch a given one.
struct Touching {
    /// Offsets of their corners from the given corner, modulo 2^32: first the four unit cells that
    /// share a side with it, then the four that share a corner.
    offsets: [u32; 8],
}

impl Touching {
    fn new(width: u32) -> Self {
        let forwards = [1, width, width + 1, width - 1];
        let [right, below, diagonal, other_diagonal] = forwards;
        let [left, above, back, other_back] = forwards.map(u32::wrapping_neg);
        Self { offsets: [right, below, left, above, diagonal, other_diagonal, back, other_back] }
    }

    /// Draws a second switch that touches the first; `None` if the drawn one is not allowed.
    #[inline]
    fn draw(&self, path: &Path, first: Switch, rng: &mut Xoshiro256PlusPlus) -> Option<Switch> {
        let drawn = below(rng, 8);
        let corner = first.corner().wrapping_add(self.offsets[drawn]);
        // The second switch must fit the links as the first one leaves them.
        // The first adds the `other` sides of its unit cell and removes the `from` sides.
        // If the shared side is one that it adds, the second switch can only remove the pair with
        // that side; if it is one that it removes, the second can only remove the pair without it.
        // Both are the `other` pair.
        let from = if drawn < 4 { first.from().other() } else { path.sides(corner)? };
        let second = Switch::new(corner, from);
        path.allows_pair(first, second).then_some(second)
    }
}

/// Draws a second switch next to a random link of the cycle that the first one would close; `None`
/// if the first closes no cycle, or the second one does not join the cycle to the rest.
#[inline]
fn draw_on_cycle(path: &Path, first: Switch, rng: &mut Xoshiro256PlusPlus) -> Option<Switch> {
    let cuts = path.cuts(first.corner(), first.from());
    if !cuts.closes {
        return None;
    }
    // The cycle consists of the positions between the two links that the first switch removes.
    let position = cuts.first as usize + 1 + below(rng, (cuts.second - cuts.first - 1) as usize);
    let (a, b) = (path.order()[position], path.order()[position + 1]);
    let (along, back) =
        if a.abs_diff(b) == 1 { (Sides::Horizontal, path.width()) } else { (Sides::Vertical, 1) };
    // A link is a side of two unit cells: one of them begins at its first cell, the other one row
    // or column before.
    let offset = if rng.next_u64() >> 63 == 0 { 0 } else { back };
    let second = Switch::new(a.min(b).wrapping_sub(offset), along);
    path.allows_pair(first, second).then_some(second)
}

/// Whether to propose a move that does not change the cost: always if it changes at most `span`
/// positions, otherwise with a probability in inverse proportion to their number.
#[inline]
fn is_worth_its_span(
    path: &Path,
    switches: [Switch; 2],
    span: u32,
    rng: &mut Xoshiro256PlusPlus,
) -> bool {
    let [one, two] = switches.map(|switch| path.cuts(switch.corner(), switch.from()));
    let length = one.second.max(two.second) - one.first.min(two.first);
    length <= span || below(rng, length as usize) < span as usize
}

/// The corners at which the first switch is drawn: those within `reach` of a unit cell that can
/// change the cost, row by row.
fn corners<C: Cost>(path: &Path, cost: &C, reach: u32) -> Vec<Cell> {
    let (columns, rows) = (path.width().saturating_sub(1), path.height().saturating_sub(1));
    let mut near = vec![false; (columns * rows) as usize];
    for y in 0..rows {
        for x in 0..columns {
            if !cost.is_sensitive(y * path.width() + x, path.width()) {
                continue;
            }
            for row in y.saturating_sub(reach)..rows.min(y.saturating_add(reach).saturating_add(1))
            {
                for column in
                    x.saturating_sub(reach)..columns.min(x.saturating_add(reach).saturating_add(1))
                {
                    near[(row * columns + column) as usize] = true;
                }
            }
        }
    }
    let corners = (0..).zip(&near).filter(|&(_, &near)| near);
    corners
        .map(|(corner, _): (u32, _)| corner / columns * path.width() + corner % columns)
        .collect()
}

/// The Metropolis criterion at one temperature.
struct Metropolis {
    temperature: f64,
    /// Acceptance probabilities of the changes below 16, as shares of 2^64; nearly all changes are
    /// that small.
    thresholds: [u64; 16],
}

impl Metropolis {
    fn new(temperature: f64) -> Self {
        let mut thresholds = [u64::MAX; 16];
        for (change, threshold) in thresholds.iter_mut().enumerate().skip(1) {
            *threshold = probability(change as f64, temperature);
        }
        Self { temperature, thresholds }
    }

    #[inline]
    fn accepts(&self, change: i64, rng: &mut Xoshiro256PlusPlus) -> bool {
        if change <= 0 {
            return true;
        }
        let threshold = match self.thresholds.get(change as usize) {
            Some(&threshold) => threshold,
            None => probability(change as f64, self.temperature),
        };
        rng.next_u64() < threshold
    }
}

/// Probability of accepting a rise of the cost, as a share of 2^64.
fn probability(change: f64, temperature: f64) -> u64 {
    (libm::exp(-change / temperature) * (1_u128 << 64) as f64) as u64
}
