//! Intervals grouped into steps.

use crate::interval::Interval;

/// Minimum share of a step that is filled up with a part of a pause.
const MIN_FILLED: f64 = 0.05;

/// Divides intervals into groups that fit into a step.
pub(super) struct Groups<'a> {
    later: std::slice::Iter<'a, Interval>,
    /// The first interval, or part of one, that is in no group yet.
    next: Option<Interval>,
    group: Vec<Interval>,
    max_s: f64,
}

impl<'a> Groups<'a> {
    /// Groups that last at most `max_s`, s.
    pub(super) fn new(intervals: &'a [Interval], max_s: f64) -> Self {
        let mut later = intervals.iter();
        let next = later.next().copied();
        Self { later, next, group: Vec::new(), max_s }
    }

    /// The next group: as many intervals as fit into a step and may share it, or a single one.
    ///
    /// Only a single one may be longer than a step.
    /// A pause is cut where the step is full, so that the step has its full length.
    pub(super) fn next(&mut self, may_share: impl Fn(&Interval) -> bool) -> Option<&[Interval]> {
        self.group.clear();
        let mut seconds = 0.0;
        while let Some(interval) = self.next {
            if !self.group.is_empty() {
                if !may_share(&interval) {
                    break;
                }
                if seconds + interval.seconds > self.max_s {
                    let room = self.max_s - seconds;
                    if interval.held.is_none() && room > MIN_FILLED * self.max_s {
                        let (now, rest) = interval.cut(room);
                        self.group.push(now);
                        self.next = Some(rest);
                    }
                    break;
                }
            }
            seconds += interval.seconds;
            self.group.push(interval);
            self.next = self.later.next().copied();
            if seconds > self.max_s || !may_share(&interval) {
                break;
            }
        }
        (!self.group.is_empty()).then_some(&self.group[..])
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn groups_keep_all_time_and_all_births_in_order() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
        let mut cut = 0;
        for _ in 0..3000 {
            let intervals: Vec<_> = (1..random.random_range(1..40))
                .map(|i| {
                    let born = random.random_bool(0.6);
                    let longest = if random.random_bool(0.1) { 3.0 } else { 0.4 };
                    Interval {
                        held: born.then_some([i, 1, 1]),
                        born,
                        seconds: random.random_range(1e-9..longest),
                        completes: Some(i),
                    }
                })
                .collect();
            let limit = if random.random_bool(0.5) { f64::INFINITY } else { 0.2 };
            let may_share =
                |interval: &Interval| interval.held.is_none() || interval.seconds <= limit;
            let mut groups = Groups::new(&intervals, 1.0);
            let mut all: Vec<Interval> = Vec::new();
            while let Some(group) = groups.next(may_share) {
                let seconds: f64 = group.iter().map(|interval| interval.seconds).sum();
                assert!(group.len() == 1 || seconds <= 1.0 + 1e-12);
                assert!(group.len() == 1 || group.iter().all(may_share));
                for &interval in group {
                    match all.last_mut() {
                        // The first part of a pause that was cut.
                        Some(last) if last.completes.is_none() => {
                            assert!(interval.held.is_none() && last.held.is_none());
                            last.seconds += interval.seconds;
                            last.completes = interval.completes;
                            cut += 1;
                        }
                        _ => all.push(interval),
                    }
                }
            }
            assert_eq!(all.len(), intervals.len());
            for (one, other) in all.iter().zip(&intervals) {
                assert_eq!((one.held, one.completes), (other.held, other.completes));
                assert!((one.seconds - other.seconds).abs() < 1e-12);
            }
        }
        assert!(cut > 1000, "{cut}");
    }
}
