//! Annealing without a pool: any two switches that together keep the path whole.
//!
//! The first switch is drawn among the unit cells near zone borders.
//! If it would close a cycle, the second is one that joins the cycle again: beside a random link of
//! it (or beside the first, which keeps the change of positions small).
//! So nearly every proposal that gets as far as a second switch is a move, and the moves reach
//! across the layer, where the paper's variants end at their window.

use beadwork_grid::{Cell, Path, Sides, Switch};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{Outcome, Run, Settings, Stop};
use crate::random::{below, scale};
use crate::{Cost, Move};

/// Parameters of the free annealer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Moves to propose.
    pub proposals: u64,
    /// Temperature at the beginning, in units of the cost; positive.
    pub hot: f64,
    /// Temperature at the end, positive; it falls geometrically.
    pub cold: f64,
    /// How far from a unit cell that changes the cost the first switch may lie, in cells.
    pub reach: u32,
    /// Share of the proposals, 0..=1, whose second switch touches the first; the others' lies
    /// anywhere on the cycle.
    pub nearby: f64,
    /// Moves that change no cost but more positions than this are proposed less often, in inverse
    /// proportion.
    /// They are most of the work otherwise, and worth no more than the others.
    pub span: u32,
}

impl Default for Free {
    fn default() -> Self {
        Self { proposals: 5_000_000, hot: 0.8, cold: 0.12, reach: 1, nearby: 0.3, span: 200 }
    }
}

/// Proposals between two looks at the temperature, the cancel token and the bound.
const BLOCK: u64 = 1024;

pub(super) fn run<C: Cost>(free: &Free, start: Path, cost: &C, settings: &Settings<'_>) -> Outcome {
    let mut run = Run::new(start, cost, settings);
    let corners = corners(&run.path, cost, free.reach);
    if corners.is_empty() {
        let stop = run.stop().unwrap_or(Stop::Done);
        return run.finish(stop, 0);
    }
    let touching = Touching::new(run.path.width());
    let nearby = (free.nearby * f64::from(1 << 16)) as u64;
    let mut proposals = 0;
    while proposals < free.proposals {
        let cooled = proposals as f64 / free.proposals as f64;
        let temperature = free.hot * libm::pow(free.cold / free.hot, cooled);
        let metropolis = Metropolis::new(temperature);
        run.observe(proposals, free.proposals, temperature);
        if let Some(stop) = run.stop() {
            return run.finish(stop, proposals);
        }
        let block = BLOCK.min(free.proposals - proposals);
        for _ in 0..block {
            let random = run.rng.next_u64();
            let corner = corners[scale(random, corners.len())];
            let Some(from) = run.path.sides(corner) else { continue };
            let first = Switch::new(corner, from);
            let second = if random & 0xFFFF < nearby {
                touching.draw(&run.path, first, &mut run.rng)
            } else {
                on_the_cycle(&run.path, first, &mut run.rng)
            };
            let Some(switches) = second.map(|second| [first, second]) else { continue };
            let change = cost.change(switches);
            let proposed =
                change != 0 || is_worth_its_span(&run.path, switches, free.span, &mut run.rng);
            if proposed && metropolis.takes(change, &mut run.rng) && run.path.apply(&switches) {
                run.accept(Move::Pair(switches), change);
            }
        }
        proposals += block;
    }
    run.complete(proposals)
}

/// The eight unit cells that touch another one.
struct Touching {
    /// Steps from corner to corner, modulo 2^32: four side by side, then four diagonal.
    steps: [u32; 8],
}

impl Touching {
    fn new(width: u32) -> Self {
        let forwards = [1, width, width + 1, width - 1];
        let [right, below, diagonal, other_diagonal] = forwards;
        let [left, above, back, other_back] = forwards.map(u32::wrapping_neg);
        Self { steps: [right, below, left, above, diagonal, other_diagonal, back, other_back] }
    }

    /// A second switch that touches the first, if a random one is allowed.
    #[inline]
    fn draw(&self, path: &Path, first: Switch, rng: &mut Xoshiro256PlusPlus) -> Option<Switch> {
        let random = below(rng, 8);
        let corner = first.corner().wrapping_add(self.steps[random]);
        // Side by side, the first switch changes a side of the second: what that takes out is the
        // other pair.
        let from = if random < 4 { first.from().other() } else { path.sides(corner)? };
        let second = Switch::new(corner, from);
        path.allows_pair(first, second).then_some(second)
    }
}

/// A second switch beside a random link of the cycle that the first would close, if it joins that
/// to the rest.
#[inline]
fn on_the_cycle(path: &Path, first: Switch, rng: &mut Xoshiro256PlusPlus) -> Option<Switch> {
    let cuts = path.cuts(first.corner(), first.from());
    if !cuts.closes {
        return None;
    }
    let place = cuts.first as usize + 1 + below(rng, (cuts.second - cuts.first - 1) as usize);
    let (a, b) = (path.order()[place], path.order()[place + 1]);
    let (along, back) =
        if a.abs_diff(b) == 1 { (Sides::Horizontal, path.width()) } else { (Sides::Vertical, 1) };
    let either_side = if rng.next_u64() >> 63 == 0 { 0 } else { back };
    let second = Switch::new(a.min(b).wrapping_sub(either_side), along);
    path.allows_pair(first, second).then_some(second)
}

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

/// The corners at which the first switch is drawn: within `reach` of a unit cell that changes the
/// cost.
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

/// Acceptance at one temperature: a table of thresholds for the small changes, which are nearly
/// all.
struct Metropolis {
    temperature: f64,
    thresholds: [u64; 16],
}

impl Metropolis {
    fn new(temperature: f64) -> Self {
        let mut thresholds = [u64::MAX; 16];
        for (change, threshold) in thresholds.iter_mut().enumerate().skip(1) {
            *threshold = chance(change as f64, temperature);
        }
        Self { temperature, thresholds }
    }

    #[inline]
    fn takes(&self, change: i64, rng: &mut Xoshiro256PlusPlus) -> bool {
        if change <= 0 {
            return true;
        }
        let threshold = match self.thresholds.get(change as usize) {
            Some(&threshold) => threshold,
            None => chance(change as f64, self.temperature),
        };
        rng.next_u64() < threshold
    }
}

/// The Metropolis probability of a rise of the cost, as a share of 2^64.
fn chance(change: f64, temperature: f64) -> u64 {
    (libm::exp(-change / temperature) * (1_u128 << 64) as f64) as u64
}
