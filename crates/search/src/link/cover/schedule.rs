//! What a dynamic program does at each end, prepared once for an order of the ends.

use super::component::Component;

/// Maximum number of slots.
pub(super) const MAX_SLOTS: usize = 250;

/// The steps of a dynamic program over the ends of a component in an order.
///
/// An end is in the *frontier* from the step at which its line is first touched to its own step.
/// During this time it has a *slot*, the position of its byte in a state.
/// A link that others exclude has a slot for a flag between their steps and its own.
pub(super) struct Schedule {
    pub(super) steps: Vec<Step>,
    /// Number of slots.
    pub(super) slots: usize,
}

/// What happens at an end.
pub(super) struct Step {
    /// Slots of the ends of lines that enter the frontier.
    pub(super) entering: Vec<[u8; 2]>,
    /// Slot of the end, which leaves the frontier.
    pub(super) slot: u8,
    /// Links to ends whose steps come later.
    pub(super) options: Vec<Choice>,
    /// Slots of flags that are not needed after the step.
    pub(super) leaving: Vec<u8>,
}

/// A link to an end whose step comes later.
pub(super) struct Choice {
    /// Slot of the other end.
    pub(super) slot: u8,
    /// Index of the link in the component.
    pub(super) link: u32,
    /// Slot of the flag that forbids the link, if it has one.
    pub(super) flag: Option<u8>,
    /// Slots of the flags of links that this one excludes.
    pub(super) excludes: Vec<u8>,
}

impl Schedule {
    /// Prepares an order of all ends; `None` if it needs more than [`MAX_SLOTS`] slots.
    pub(super) fn new(component: &Component, order: &[u32]) -> Option<Self> {
        let mut rank = vec![0_u32; order.len()];
        for (step, &end) in order.iter().enumerate() {
            rank[end as usize] = step as u32;
        }
        let decided = |link: u32| {
            let [a, b] = component.links[link as usize].0;
            rank[a as usize].min(rank[b as usize])
        };
        let mut slots = Slots::default();
        let mut slot_of = vec![None; order.len()];
        let mut flag_of = vec![None; component.links.len()];
        let mut steps = Vec::with_capacity(order.len());
        for (step, &end) in order.iter().enumerate() {
            let later: Vec<(u32, u32)> = component
                .links_at(end)
                .filter(|&(_, other)| rank[other as usize] > step as u32)
                .collect();
            let mut entering = Vec::new();
            for line in later.iter().map(|(_, other)| other / 2).chain([end / 2]) {
                let [first, last] = [2 * line, 2 * line + 1].map(|end| end as usize);
                // If one end has a slot or had one, the other does or did too.
                let is_touched = slot_of[first].is_some() || slot_of[last].is_some();
                if !is_touched && rank[first].min(rank[last]) >= step as u32 {
                    let [a, b] = [slots.take()?, slots.take()?];
                    (slot_of[first], slot_of[last]) = (Some(a), Some(b));
                    entering.push([a, b]);
                }
            }
            let mut options = Vec::new();
            let mut leaving = Vec::new();
            for &(link, other) in &later {
                let mut excludes = Vec::new();
                for &excluded in component.conflicts_of.list(link as usize) {
                    if decided(excluded) > step as u32 {
                        let flag = match flag_of[excluded as usize] {
                            Some(flag) => flag,
                            None => slots.take()?,
                        };
                        flag_of[excluded as usize] = Some(flag);
                        excludes.push(flag);
                    }
                }
                let flag = flag_of[link as usize];
                leaving.extend(flag);
                options.push(Choice { slot: slot_of[other as usize]?, link, flag, excludes });
            }
            let slot = slot_of[end as usize]?;
            leaving.iter().for_each(|&flag| slots.release(flag));
            slots.release(slot);
            steps.push(Step { entering, slot, options, leaving });
        }
        Some(Self { steps, slots: slots.used })
    }
}

/// Slots that are in use and those that were.
#[derive(Default)]
struct Slots {
    used: usize,
    released: Vec<u8>,
}

impl Slots {
    fn take(&mut self) -> Option<u8> {
        self.released.pop().or_else(|| {
            self.used += 1;
            (self.used <= MAX_SLOTS).then(|| (self.used - 1) as u8)
        })
    }

    fn release(&mut self, slot: u8) {
        self.released.push(slot);
    }
}
