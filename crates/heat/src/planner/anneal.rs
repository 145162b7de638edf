//! Simulated annealing of the order of a layer's lines.

use beadwork_base::Control;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// How the order of a layer's lines is annealed: first with the screen as cost, then the last lines
/// with the model.
///
/// Construct it with `..Annealing::default()`: fields may be added.
#[derive(Clone, Debug, PartialEq)]
pub struct Annealing {
    /// Independent runs per layer, at least 1; the model decides between their results.
    pub runs: usize,
    /// Orders to try on the screen in the whole part, once per run: the same number in each layer,
    /// from 20 to 1,000.
    pub trials: usize,
    /// Time before the end of a layer in which lines are permuted, s: earlier ones hardly matter
    /// for the temperatures at its end, but for those on the way.
    pub tail_s: f64,
    /// Orders to consider for the model in the whole part, once per run: the same number in each
    /// layer, at most 200; none if that is less than 40.
    /// It tries only those that take no more time than the order found on the screen.
    pub model_trials: usize,
    /// As [`Annealing::tail_s`], on the model, which deposits these lines for each order that is
    /// tried.
    pub model_tail_s: f64,
}

impl Default for Annealing {
    fn default() -> Self {
        Self { runs: 2, trials: 9000, tail_s: 15.0, model_trials: 1200, model_tail_s: 12.0 }
    }
}

impl Annealing {
    /// Trials of a run in each of a number of layers, on the screen.
    pub(super) fn trials_per_layer(&self, layers: usize) -> usize {
        (self.trials / layers.max(1)).clamp(20, 1000)
    }

    /// Trials of a run in each of a number of layers, on the model.
    pub(super) fn model_trials_per_layer(&self, layers: usize) -> usize {
        let trials = (self.model_trials / layers.max(1)).min(200);
        if trials < 40 { 0 } else { trials }
    }
}

/// Temperatures of a run at its start and its end, as shares of the cost of the first order.
pub(super) type Temperatures = [f64; 2];

/// What is annealed.
pub(super) struct Problem<'a, C> {
    /// The order to start from: numbers of lines.
    pub(super) start: &'a [usize],
    /// Number of lines at its end that may be permuted.
    pub(super) tail: usize,
    /// Orders to try.
    pub(super) trials: usize,
    pub(super) temperatures: Temperatures,
    /// Cost of an order.
    pub(super) cost: &'a C,
}

/// Returns the cheapest order of lines that a run finds.
///
/// An interrupted run returns the cheapest so far.
pub(super) fn anneal<C: Fn(&[usize]) -> f64>(
    problem: &Problem<'_, C>,
    seed: u64,
    control: &Control<'_>,
) -> Vec<usize> {
    let Problem { start, tail, trials, temperatures: [hot, cold], cost } = *problem;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut current = start.to_vec();
    let first = current.len() - tail;
    if tail < 2 {
        return current;
    }
    let mut current_cost = cost(&current);
    let (mut best, mut best_cost) = (current.clone(), current_cost);
    let mut next = current.clone();
    let scale = current_cost;
    for trial in 0..trials {
        if control.interrupted().is_some() {
            break;
        }
        let progress = trial as f64 / trials as f64;
        let share = hot * libm::pow(cold / hot, progress);
        next.copy_from_slice(&current);
        mutate(&mut next[first..], &mut rng);
        let next_cost = cost(&next);
        // A worse order is accepted with the probability exp(-difference / temperature).
        let accepted = -scale * share * libm::log(unit(&mut rng).max(f64::MIN_POSITIVE));
        if next_cost <= current_cost + accepted {
            std::mem::swap(&mut current, &mut next);
            current_cost = next_cost;
            if current_cost < best_cost {
                best_cost = current_cost;
                best.copy_from_slice(&current);
            }
        }
    }
    best
}

/// Changes an order of lines a little, more often near its end, on which the temperatures at the
/// end depend most.
fn mutate(order: &mut [usize], rng: &mut Xoshiro256PlusPlus) {
    let count = order.len();
    let mut position = || {
        let share = unit(rng);
        count - 1 - ((share * share * share) * count as f64) as usize
    };
    let (a, b) = (position(), position());
    let (first, last) = (a.min(b), a.max(b));
    match below(rng, 4) {
        0 => order[first..=last].rotate_left(1),
        1 => order[first..=last].rotate_right(1),
        2 => order.swap(a, b),
        _ => order[first..=last].reverse(),
    }
}

/// A random number in 0..1 with 53 bits.
fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A random number below `count`.
fn below(rng: &mut Xoshiro256PlusPlus, count: usize) -> usize {
    (((rng.next_u64() >> 32) * count as u64) >> 32) as usize
}
