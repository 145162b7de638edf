//! The fewest beads: a minimum path cover of the lines by links.
//!
//! A set of links makes beads of the lines if it has at most one link at each end, closes no cycle
//! of lines, and contains no conflict.
//! Each bead has two ends without a link, so the fewest beads leave the fewest ends without a link.
//! A maximum matching is not enough: it closes cycles.
//!
//! # Dynamic program
//! The ends of a component are visited in an order.
//! At each end without a link, the program either links it to an end that comes later, or *gives it
//! up*: it remains the end of a bead.
//! What the rest can do depends only on the *frontier*, the ends whose lines are touched and that
//! are not visited yet: which of them have a link, and which two are the ends of one *fragment*, as
//! a link between these would close a cycle.
//! Of partial covers with the same such *state*, the one that gave up the fewest ends is kept
//! (Simpath: Knuth, *The Art of Computer Programming*, volume 4A, section 7.1.4).
//!
//! Three things keep states few:
//! - *Orders* with a small frontier: a sweep across the lines meets few of them at a time.
//! - *Dominance*: a state is dropped if another can do without the links by which it is ahead, see
//!   [`States::is_within`](states::States::is_within).
//! - *Bounds*: a program in the opposite direction gives a lower bound on the ends given up in the
//!   rest; a state that cannot lead to fewer beads than the best known is dropped.
//!
//! # Files
//! - `component.rs`: connected components.
//! - `order.rs`: orders of ends.
//! - `schedule.rs`: what happens at each end of an order, and which byte of a state is whose.
//! - `states.rs`: sets of states, dominance, and the links of states.
//! - `dynamic_program.rs`: a run of the program.

mod component;
mod dynamic_program;
mod order;
mod schedule;
mod states;

use beadwork_base::{Control, Interrupted};

use self::component::Component;
use self::dynamic_program::{DynamicProgram, Ended, Run, Surplus};
use self::schedule::Schedule;
use crate::link::bead::{Bead, beads_of};
use crate::link::links::Links;
use crate::link::settings::{Settings, Work};

/// Width of the first runs.
const FIRST_WIDTH: usize = 64;

/// The beads of a cover, a lower bound on their number, and why the search stopped early.
pub(super) struct Cover {
    pub(super) beads: Vec<Bead>,
    pub(super) bound: usize,
    pub(super) interrupted: Option<Interrupted>,
}

/// Lower numbers of beads than those given, component by component.
pub(super) fn cover(
    links: &Links,
    start: &[Bead],
    settings: &Settings,
    work: &mut Work,
    control: &Control<'_>,
) -> Cover {
    let mut is_used = vec![false; links.all().len()];
    for &link in start.iter().flat_map(|bead| &bead.links) {
        is_used[link as usize] = true;
    }
    let components = Component::all(links);
    let mut dynamic_program = DynamicProgram::default();
    let mut bound = 0;
    let mut interrupted = None;
    let mut done = 0;
    for component in &components {
        let used = component.links.iter().filter(|(_, link)| is_used[*link as usize]).count();
        let mut search = Search {
            component,
            beads: component.end_count() / 2 - used,
            cover: None,
            bound: component.degree_bound(),
            work: 0,
            limit: u64::from(settings.states_per_line) * component.end_count() as u64 / 2,
        };
        if interrupted.is_none() && search.beads > search.bound {
            interrupted = control.interrupted();
        }
        if interrupted.is_none() && search.beads > search.bound {
            interrupted = search.run(&mut dynamic_program, settings, control).err();
        }
        if let Some(chosen) = &search.cover {
            component.links.iter().for_each(|&(_, link)| is_used[link as usize] = false);
            for &index in chosen {
                is_used[component.links[index as usize].1 as usize] = true;
            }
        }
        bound += search.bound;
        work.states += search.work;
        work.components += 1;
        work.proven_components += u32::from(search.beads <= search.bound);
        done += component.end_count() / 2;
        control.report(done, links.line_count());
    }
    let chosen = (0..links.all().len() as u32).filter(|&link| is_used[link as usize]);
    Cover { beads: beads_of(links, chosen), bound, interrupted }
}

/// The search in one component.
struct Search<'a> {
    component: &'a Component,
    /// Number of beads of the best cover known.
    beads: usize,
    /// Its links, if the search found it.
    cover: Option<Vec<u32>>,
    /// Lower bound on the number of beads.
    bound: usize,
    /// States generated, and their limit.
    work: u64,
    limit: u64,
}

impl Search<'_> {
    /// Runs dynamic programs of rising width in both directions, until the best cover is proven or
    /// the work is done.
    fn run(
        &mut self,
        dynamic_program: &mut DynamicProgram,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<(), Interrupted> {
        let mut order = order::order(self.component);
        let Some(forward) = Schedule::new(self.component, &order) else { return Ok(()) };
        order.reverse();
        let Some(backward) = Schedule::new(self.component, &order) else { return Ok(()) };
        let schedules = [&forward, &backward];
        // Lower bounds on the ends given up in first steps of each direction.
        let mut bounds = [Vec::new(), Vec::new()];
        let max_width = settings.max_width.max(1) as usize;
        let mut width = FIRST_WIDTH.min(max_width);
        let mut direction = 0;
        loop {
            let before = self.work;
            for surplus in [Surplus::Drop, Surplus::Merge] {
                let run = Run {
                    width,
                    surplus,
                    cap: 2 * self.beads as u32 - 2,
                    bounds: &bounds[1 - direction],
                    work: self.limit.saturating_sub(self.work),
                };
                let found = dynamic_program.run(schedules[direction], &run, control);
                self.work += found.work;
                match found.ended {
                    Some(Ended::Work) => return Ok(()),
                    Some(Ended::Interrupted(interrupted)) => return Err(interrupted),
                    None => {}
                }
                let cap = run.cap;
                if let Some(new) = found.bounds {
                    // The bounds hold for covers within the cap; no other cover is better than the
                    // best.
                    let total = new.last().copied().unwrap_or(0);
                    let beads = if total > cap { self.beads } else { total.div_ceil(2) as usize };
                    self.bound = self.bound.max(beads);
                    raise(&mut bounds[direction], new);
                }
                if let Some((given_up, links)) = found.cover {
                    self.beads = given_up as usize / 2;
                    self.cover = Some(links);
                }
                if self.beads <= self.bound {
                    return Ok(());
                }
                direction = 1 - direction;
            }
            direction = 1 - direction;
            // The next runs are several times as wide, but bounds spare them some states.
            let next = 2 * (self.work - before);
            if width == max_width || self.work + next > self.limit {
                return Ok(());
            }
            width = (4 * width).min(max_width);
        }
    }
}

/// Raises bounds to others where these are higher.
fn raise(bounds: &mut Vec<u32>, others: Vec<u32>) {
    if bounds.len() < others.len() {
        *bounds = others;
    } else {
        bounds.iter_mut().zip(others).for_each(|(bound, other)| *bound = other.max(*bound));
    }
}
