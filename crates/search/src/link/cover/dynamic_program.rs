//! The dynamic program over the ends of a component.

use beadwork_base::{Control, Interrupted};

use super::schedule::{Schedule, Step};
use super::states::{
    CLOSED, FORBIDDEN, FREE, History, Label, MERGED, OPTIONAL, ROOT, States, is_free,
};

/// Number of states that others are compared with.
const REFERENCES: usize = 128;

/// What happens to states above the width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Surplus {
    /// The states that gave up the most ends are dropped.
    Drop,
    /// They are merged to states that allow more than each of them: the result is a bound.
    Merge,
}

/// A run of the dynamic program.
pub(super) struct Run<'a> {
    /// Maximum number of states after a step.
    pub(super) width: usize,
    pub(super) surplus: Surplus,
    /// Maximum number of ends that may be given up.
    pub(super) cap: u32,
    /// For each number of last steps, a lower bound on the ends given up in them.
    pub(super) bounds: &'a [u32],
    /// Maximum number of states to generate.
    pub(super) work: u64,
}

/// What a run found.
pub(super) struct Found {
    /// The links of the best cover within the cap, and the number of ends that it gives up.
    pub(super) cover: Option<(u32, Vec<u32>)>,
    /// For each number of first steps, a lower bound on the ends given up in them by a cover within
    /// the cap; more than the cap if there is no such cover.
    /// `None` if states were dropped.
    pub(super) bounds: Option<Vec<u32>>,
    /// Whether states were merged.
    pub(super) is_merged: bool,
    /// States generated.
    pub(super) work: u64,
    /// Reason why the run ended early without a result; `None` if it did not.
    pub(super) ended: Option<Ended>,
}

/// Reason why a run ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ended {
    /// It generated too many states.
    Work,
    Interrupted(Interrupted),
}

/// Memory that runs share.
#[derive(Default)]
pub(super) struct DynamicProgram {
    states: States,
    next: States,
    merged: States,
    history: History,
    order: Vec<u32>,
    references: Vec<u32>,
}

impl DynamicProgram {
    pub(super) fn run(
        &mut self,
        schedule: &Schedule,
        run: &Run<'_>,
        control: &Control<'_>,
    ) -> Found {
        for states in [&mut self.states, &mut self.next, &mut self.merged] {
            states.reset(schedule.slots);
        }
        self.history.clear();
        let stride = self.states.stride();
        let unit = 1 + stride as u64 / 32;
        let mut found = Found { cover: None, bounds: None, is_merged: false, work: 0, ended: None };
        let mut is_complete = true;
        let mut bounds = vec![0];
        self.states.insert(&vec![CLOSED; stride], Label { given_up: 0, free: 0, node: ROOT });
        let mut polled = 0;
        for (number, step) in schedule.steps.iter().enumerate() {
            let rest = run.bounds.get(schedule.steps.len() - number - 1).copied().unwrap_or(0);
            self.expand(step, run.cap.saturating_sub(rest), rest <= run.cap);
            found.work += unit * (self.next.len() as u64 + 1);
            let is_reduced = self.reduce(run);
            if is_reduced {
                match run.surplus {
                    Surplus::Drop => is_complete = false,
                    Surplus::Merge => found.is_merged = true,
                }
            }
            self.history.compact(&mut self.states);
            let minimum = self.states.labels.iter().map(|label| label.given_up).min();
            bounds.push(minimum.unwrap_or(run.cap + 1));
            if minimum.is_none() {
                break;
            }
            if found.work > run.work {
                found.ended = Some(Ended::Work);
                return found;
            }
            if found.work >= polled + 10_000 {
                polled = found.work;
                if let Some(interrupted) = control.interrupted() {
                    found.ended = Some(Ended::Interrupted(interrupted));
                    return found;
                }
            }
        }
        bounds.resize(schedule.steps.len() + 1, run.cap + 1);
        if let Some(label) = self.states.labels.first()
            && label.node != MERGED
        {
            found.cover = Some((label.given_up, self.history.links(label.node)));
        }
        found.bounds = is_complete.then_some(bounds);
        found
    }

    /// Fills `next` with the states after a step that give up at most `cap` ends.
    fn expand(&mut self, step: &Step, cap: u32, is_possible: bool) {
        let Self { states, next, history, .. } = self;
        next.clear();
        if !is_possible {
            return;
        }
        let slot = step.slot as usize;
        let mut bytes = vec![CLOSED; states.stride()];
        for index in 0..states.len() {
            let label = states.labels[index];
            if label.given_up > cap {
                continue;
            }
            let state = states.bytes_mut(index);
            for &[a, b] in &step.entering {
                state[a as usize] = b;
                state[b as usize] = a;
            }
            let state = states.bytes(index);
            let free = label.free + 2 * step.entering.len() as u32;
            let begin = |bytes: &mut [u8]| {
                bytes.copy_from_slice(state);
                bytes[slot] = CLOSED;
                step.leaving.iter().for_each(|&flag| bytes[flag as usize] = CLOSED);
            };
            let mate = state[slot];
            begin(&mut bytes);
            if mate == CLOSED {
                next.insert(&bytes, Label { free, ..label });
                continue;
            }
            for choice in &step.options {
                let other = choice.slot as usize;
                let is_forbidden =
                    choice.flag.is_some_and(|flag| state[flag as usize] == FORBIDDEN);
                if !is_free(state[other]) || mate == choice.slot || is_forbidden {
                    continue;
                }
                begin(&mut bytes);
                let others_mate = state[other];
                bytes[other] = CLOSED;
                // The fragments become one.
                if mate < OPTIONAL {
                    bytes[mate as usize] = if others_mate < OPTIONAL { others_mate } else { FREE };
                }
                if others_mate < OPTIONAL {
                    bytes[others_mate as usize] = if mate < OPTIONAL { mate } else { FREE };
                }
                choice.excludes.iter().for_each(|&flag| bytes[flag as usize] = FORBIDDEN);
                let node = history.push(label.node, choice.link);
                next.insert(&bytes, Label { free: free - 2, node, ..label });
            }
            let given_up = label.given_up + u32::from(mate != OPTIONAL);
            if given_up <= cap {
                begin(&mut bytes);
                if mate < OPTIONAL {
                    bytes[mate as usize] = FREE;
                }
                next.insert(&bytes, Label { given_up, free: free - 1, node: label.node });
            }
        }
    }

    /// Moves the states of `next` to `states`, without those that others dominate, and at most as
    /// many as the width allows.
    /// Returns whether states were dropped or merged for the width.
    fn reduce(&mut self, run: &Run<'_>) -> bool {
        let Self { states, next, merged, order, references, .. } = self;
        if next.len() <= 1 {
            std::mem::swap(states, next);
            return false;
        }
        states.clear();
        order.clear();
        order.extend(0..next.len() as u32);
        order.sort_unstable_by_key(|&index| {
            let label = next.labels[index as usize];
            (label.given_up, std::cmp::Reverse(label.free), index)
        });
        references.clear();
        order.retain(|&index| {
            let label = next.labels[index as usize];
            let bytes = next.bytes(index as usize);
            let is_dominated = references.iter().any(|&reference| {
                let other = next.labels[reference as usize];
                let limit = label.given_up - other.given_up;
                States::is_within(bytes, next.bytes(reference as usize), limit)
            });
            if !is_dominated && references.len() < REFERENCES {
                references.push(index);
            }
            !is_dominated
        });
        let is_wide = order.len() > run.width;
        let exact = match run.surplus {
            _ if !is_wide => order.len(),
            Surplus::Drop => run.width,
            Surplus::Merge => run.width / 2,
        };
        for &index in &order[..exact] {
            states.insert(next.bytes(index as usize), next.labels[index as usize]);
        }
        if !is_wide || run.surplus == Surplus::Drop {
            return is_wide;
        }
        merged.clear();
        let room = (run.width - exact).max(1);
        // One for each number of ends given up.
        let mut unions: Vec<(Vec<u8>, u32)> = Vec::new();
        for &index in &order[exact..] {
            let given_up = next.labels[index as usize].given_up;
            let bytes: Vec<u8> = next
                .bytes(index as usize)
                .iter()
                .map(|&byte| match byte {
                    OPTIONAL => OPTIONAL,
                    _ if is_free(byte) => FREE,
                    _ => CLOSED,
                })
                .collect();
            if merged.len() < room {
                merged.insert(&bytes, merged_label(&bytes, given_up));
            } else if let Some((union, _)) = unions.last_mut().filter(|last| last.1 == given_up) {
                for (byte, other) in union.iter_mut().zip(bytes) {
                    *byte = if *byte == other { other } else { OPTIONAL };
                }
            } else {
                unions.push((bytes, given_up));
            }
        }
        for index in 0..merged.len() {
            states.insert(merged.bytes(index), merged.labels[index]);
        }
        for (bytes, given_up) in unions {
            states.insert(&bytes, merged_label(&bytes, given_up));
        }
        true
    }
}

fn merged_label(bytes: &[u8], given_up: u32) -> Label {
    let free = bytes.iter().filter(|&&byte| is_free(byte)).count() as u32;
    Label { given_up, free, node: MERGED }
}
