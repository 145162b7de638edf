//! PPO: its parts against their definitions, tasks with known optima, interrupted runs.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use beadwork_base::{Control, Threads};
use beadwork_learn::Device;
use beadwork_learn::ppo::tasks::{Bandit, CartPole, Chain};
use beadwork_learn::ppo::{
    self, Batch, Categorical, End, Environment, EpisodeEnd, Event, Kept, NetworkConfig,
    Observation, Output, PerceptronConfig, Policy, Space, Step, TrainError, TrainingConfig,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::ThreadPoolBuilder;
use tch::{Kind, Tensor};
use tempfile::tempdir;

/// The advantage by its definition (Schulman et al. 2016, equation 16): the exponentially weighted
/// mean of the advantages of 1, 2, ... n steps, where n reaches to the end of the episode or of the
/// rollout.
fn advantage_by_definition(
    at: usize,
    (rewards, values, next_values, ended): (&[f64], &[f64], &[f64], &[bool]),
    environments: usize,
    (gamma, lambda): (f64, f64),
) -> f64 {
    let mut of_steps = Vec::new();
    let (mut sum, mut discount) = (0.0, 1.0);
    for index in (at..rewards.len()).step_by(environments) {
        sum += discount * rewards[index];
        discount *= gamma;
        of_steps.push(sum + discount * next_values[index] - values[at]);
        if ended[index] {
            break;
        }
    }
    let last = of_steps.len() - 1;
    let weight = |steps: usize| {
        let decay = lambda.powi(steps as i32);
        if steps == last { decay } else { (1.0 - lambda) * decay }
    };
    of_steps.iter().enumerate().map(|(steps, advantage)| weight(steps) * advantage).sum()
}

#[test]
fn advantages_equal_their_definition() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for case in 0..3000 {
        let (steps, environments) = (rng.random_range(1..=20), rng.random_range(1..=4));
        let count = steps * environments;
        let number = |rng: &mut ChaCha8Rng| rng.random_range(-3.0..3.0);
        let rewards: Vec<f64> = (0..count).map(|_| number(&mut rng)).collect();
        let values: Vec<f64> = (0..count).map(|_| number(&mut rng)).collect();
        let often = [0.0, 0.1, 0.5, 1.0][case % 4];
        let ended: Vec<bool> = (0..count).map(|_| rng.random_bool(often)).collect();
        // Of the episodes that ended, some terminated; the others have a value of their own.
        let mut next_values = values[environments.min(count)..].to_vec();
        next_values.resize_with(count, || number(&mut rng));
        for (next, _) in next_values.iter_mut().zip(&ended).filter(|(_, ended)| **ended) {
            *next = if rng.random() { 0.0 } else { number(&mut rng) };
        }
        let factor = |rng: &mut ChaCha8Rng| [0.0, 1.0, rng.random()][rng.random_range(0..3)];
        let factors = (factor(&mut rng), factor(&mut rng));
        let got = ppo::advantages(&rewards, &values, &next_values, &ended, environments, factors);
        for (at, got) in got.into_iter().enumerate() {
            let of = (&rewards[..], &values[..], &next_values[..], &ended[..]);
            let expected = advantage_by_definition(at, of, environments, factors);
            assert!((got - expected).abs() < 1e-9, "case {case}, {at}: {got} for {expected}");
        }
    }
}

/// Logits, masks, and everything else of a minibatch, as rows of numbers.
struct Rows {
    logits: Vec<Vec<f64>>,
    permitted: Vec<Vec<bool>>,
    actions: Vec<usize>,
    value: Vec<f64>,
    old_log_probabilities: Vec<f64>,
    old_values: Vec<f64>,
    advantages: Vec<f64>,
    returns: Vec<f64>,
}

impl Rows {
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let (count, width) = (rng.random_range(2..=12), rng.random_range(1..=9));
        let scale = [0.1, 1.0, 20.0][rng.random_range(0..3)];
        let logits = (0..count)
            .map(|_| (0..width).map(|_| rng.random_range(-scale..scale)).collect())
            .collect();
        let actions: Vec<usize> = (0..count).map(|_| rng.random_range(0..width)).collect();
        let permitted = actions
            .iter()
            .map(|&action| (0..width).map(|at| at == action || rng.random()).collect())
            .collect();
        let mut numbers =
            |low, high| (0..count).map(|_| rng.random_range(low..high)).collect::<Vec<f64>>();
        let (value, advantages) = (numbers(-2.0, 2.0), numbers(-2.0, 2.0));
        let (near, returns) = (numbers(-0.4, 0.4), numbers(-2.0, 2.0));
        let changes = numbers(-0.4, 0.4);
        let mut rows = Self {
            logits,
            permitted,
            actions,
            old_values: value.iter().zip(near).map(|(value, near)| value + near).collect(),
            value,
            old_log_probabilities: Vec::new(),
            advantages,
            returns,
        };
        let change = |(at, change)| rows.probabilities(at)[rows.actions[at]].ln() + change;
        rows.old_log_probabilities = changes.into_iter().enumerate().map(change).collect();
        rows
    }

    /// The softmax over the permitted actions of a row.
    fn probabilities(&self, row: usize) -> Vec<f64> {
        let terms = self.logits[row].iter().zip(&self.permitted[row]);
        let terms: Vec<f64> =
            terms.map(|(logit, permitted)| if *permitted { logit.exp() } else { 0.0 }).collect();
        let sum: f64 = terms.iter().sum();
        terms.iter().map(|term| term / sum).collect()
    }

    fn entropy(&self, row: usize) -> f64 {
        self.probabilities(row).iter().filter(|p| **p > 0.0).map(|p| -p * p.ln()).sum()
    }

    fn tensors(&self) -> (Output, Batch) {
        let single = |values: &[f64]| Tensor::from_slice(values).to_kind(Kind::Float);
        let count = self.actions.len() as i64;
        let actions: Vec<i64> = self.actions.iter().map(|&action| action as i64).collect();
        let output = Output {
            logits: single(&self.logits.concat()).view([count, -1]).set_requires_grad(true),
            value: single(&self.value),
        };
        let batch = Batch {
            observation: Vec::new(),
            permitted: Tensor::from_slice(&self.permitted.concat()).view([count, -1]),
            actions: Tensor::from_slice(&actions),
            log_probabilities: single(&self.old_log_probabilities),
            values: single(&self.old_values),
            advantages: single(&self.advantages),
            returns: single(&self.returns),
        };
        (output, batch)
    }

    /// Policy loss, value loss, entropy, divergence and share of clipped steps, by their
    /// definitions, and whether a ratio is so close to a limit that rounding decides.
    fn losses(&self, config: &TrainingConfig) -> ([f64; 5], bool) {
        let count = self.actions.len() as f64;
        let mean = self.advantages.iter().sum::<f64>() / count;
        let variance =
            self.advantages.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let (mut sums, mut is_close) = ([0.0; 5], false);
        for row in 0..self.actions.len() {
            let probability = self.probabilities(row)[self.actions[row]];
            let ratio = probability / self.old_log_probabilities[row].exp();
            let advantage = if config.normalise_advantages {
                (self.advantages[row] - mean) / (variance.sqrt() + 1e-8)
            } else {
                self.advantages[row]
            };
            let clipped = ratio.max(1.0 - config.clip).min(1.0 + config.clip);
            sums[0] -= (advantage * ratio).min(advantage * clipped);
            let error = (self.value[row] - self.returns[row]).powi(2);
            let change = self.value[row] - self.old_values[row];
            let near = self.old_values[row] + change.max(-config.clip).min(config.clip);
            let clipped_error = (near - self.returns[row]).powi(2);
            sums[1] += 0.5 * if config.clip_value { error.max(clipped_error) } else { error };
            sums[2] += self.entropy(row);
            sums[3] += ratio - 1.0 - ratio.ln();
            sums[4] += f64::from(u8::from((ratio - 1.0).abs() > config.clip));
            is_close |= ((ratio - 1.0).abs() - config.clip).abs() < 1e-4;
        }
        (sums.map(|sum| sum / count), is_close)
    }
}

#[test]
fn masked_distributions_equal_their_definition() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for case in 0..2000 {
        let rows = Rows::random(&mut rng);
        let (output, batch) = rows.tensors();
        let policy = Categorical::new(&output.logits, &batch.permitted);
        let entropy = Vec::<f64>::try_from(policy.entropy().to_kind(Kind::Double)).unwrap();
        let chosen = policy.log_probability(&batch.actions);
        let chosen = Vec::<f64>::try_from(chosen.to_kind(Kind::Double)).unwrap();
        let probabilities = policy.probabilities().to_kind(Kind::Double);
        for row in 0..rows.actions.len() {
            let expected = rows.probabilities(row);
            let got = Vec::<f64>::try_from(probabilities.get(row as i64)).unwrap();
            for ((got, expected), permitted) in got.iter().zip(&expected).zip(&rows.permitted[row])
            {
                assert!((got - expected).abs() < 1e-5, "case {case}: {got} for {expected}");
                assert!(*permitted || got.to_bits() == 0, "case {case}");
            }
            assert!((entropy[row] - rows.entropy(row)).abs() < 1e-4, "case {case}");
            let expected = expected[rows.actions[row]].ln();
            assert!((chosen[row] - expected).abs() < 1e-4 * (1.0 - expected), "case {case}");
        }
        // No gradient reaches logits of actions that are not permitted.
        (policy.entropy().sum(Kind::Float) + chosen_sum(&policy, &batch)).backward();
        let gradient = output.logits.grad();
        assert!(bool::try_from(gradient.isfinite().all()).unwrap(), "case {case}");
        let masked = gradient.masked_select(&batch.permitted.logical_not());
        assert_eq!(masked.count_nonzero(0).int64_value(&[]), 0, "case {case}");
    }
}

fn chosen_sum(policy: &Categorical, batch: &Batch) -> Tensor {
    policy.log_probability(&batch.actions).sum(Kind::Float)
}

#[test]
fn losses_equal_their_definition() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for case in 0..2000 {
        let rows = Rows::random(&mut rng);
        let config = TrainingConfig {
            clip: [0.1, 0.2][case % 2],
            clip_value: rng.random(),
            normalise_advantages: rng.random(),
            entropy: 0.03,
            value: 0.7,
            ..TrainingConfig::default()
        };
        let (output, batch) = rows.tensors();
        let losses = ppo::losses(&output, &batch, &config);
        let (expected, is_close) = rows.losses(&config);
        let [policy, value, entropy, ..] = expected;
        let total = policy + 0.7 * value - 0.03 * entropy;
        let got = [
            &losses.policy,
            &losses.value,
            &losses.entropy,
            &losses.approximate_kl,
            &losses.clip_fraction,
            &losses.total,
        ];
        for (part, (got, expected)) in
            got.into_iter().zip(expected.into_iter().chain([total])).enumerate()
        {
            let got = got.double_value(&[]);
            let is_excused = part == 4 && is_close;
            assert!(
                (got - expected).abs() < 2e-4 || is_excused,
                "case {case}, part {part}: {got} for {expected}"
            );
        }
    }
}

/// A configuration for small tasks.
fn small() -> TrainingConfig {
    TrainingConfig {
        steps: 4096,
        environments: 4,
        rollout: 32,
        learning_rate: 5e-3,
        evaluate_every: 100,
        window: 20,
        threads: 1,
        network: NetworkConfig::Perceptron(PerceptronConfig { hidden: vec![16] }),
        ..TrainingConfig::default()
    }
}

/// Trains in a folder; `stop_after` interrupts the run after this number of steps.
fn run<E: Environment>(
    make: &dyn Fn() -> E,
    config: &TrainingConfig,
    out: &Path,
    threads: Threads<'_>,
    stop_after: u64,
) -> (Result<End, TrainError>, Vec<Event>) {
    let mut events = Vec::new();
    let steps = AtomicU64::new(0);
    let time_is_up = || steps.load(Ordering::Relaxed) >= stop_after;
    let progress = |progress: beadwork_base::Progress| {
        steps.store(progress.done as u64, Ordering::Relaxed);
    };
    let control = Control {
        time_is_up: Some(&time_is_up),
        progress: Some(&progress),
        ..Control::on(threads)
    };
    let mut observer = |event: &Event| events.push(event.clone());
    let run = ppo::Run { device: Device::Cpu, out, observer: &mut observer };
    let end = ppo::train(make, config, run, &control);
    (end, events)
}

/// The last policy of a run, and the run's events.
fn trained<E: Environment>(make: &dyn Fn() -> E, config: &TrainingConfig) -> (Policy, Vec<Event>) {
    let out = tempdir().unwrap();
    let (end, events) = run(make, config, out.path(), Threads::One, u64::MAX);
    assert_eq!(end.unwrap(), End::Done);
    (Policy::open(out.path(), Kept::Last, Device::Cpu).unwrap(), events)
}

/// The last update's mean return.
fn last_mean(events: &[Event]) -> f64 {
    let mean = events.iter().rev().find_map(|event| match event {
        Event::Updated(update) => update.mean_return,
        _ => None,
    });
    mean.unwrap()
}

#[test]
fn the_best_arm_of_a_bandit_is_found() {
    for seed in 0..3 {
        let config = TrainingConfig { seed, ..small() };
        let make = || Bandit::new(&[0.2, -1.0, 0.5, 1.0, 0.9]);
        let (policy, events) = trained(&make, &config);
        assert!(policy.probabilities(&make().reset(0))[3] > 0.9);
        assert!(last_mean(&events) > 0.95, "{}", last_mean(&events));

        // Without the best arm, the second is found; the arm itself would panic.
        let rewards = [Some(0.2), Some(-1.0), Some(0.5), None, Some(0.9)];
        let make = || Bandit { rewards: rewards.to_vec() };
        let (policy, _) = trained(&make, &config);
        let probabilities = policy.probabilities(&make().reset(0));
        assert!(probabilities[4] > 0.8 && probabilities[3].to_bits() == 0, "{probabilities:?}");
    }
}

/// A bandit whose rewards are shaped: each is 5 more than it counts for.
struct Shaped(Bandit);

impl Environment for Shaped {
    fn identity(&self) -> String {
        self.0.identity()
    }

    fn space(&self) -> Space {
        self.0.space()
    }

    fn reset(&mut self, seed: u64) -> Observation {
        self.0.reset(seed)
    }

    fn step(&mut self, action: usize) -> Step {
        let step = self.0.step(action);
        Step { reward: step.reward + 5.0, ..step }
    }

    fn score(&self, rewards: f64) -> f64 {
        rewards - 5.0
    }
}

#[test]
fn episodes_count_for_their_scores() {
    let config = TrainingConfig { evaluation_episodes: 2, ..small() };
    let (_, events) = trained(&|| Shaped(Bandit::new(&[0.25, 1.0, 0.5])), &config);
    let mut counted = 0;
    let mut check = |score: f64| {
        counted += 1;
        assert!([0.25, 0.5, 1.0].contains(&score), "{score}");
    };
    for event in &events {
        match event {
            Event::Episode { episode_return, .. } => check(*episode_return),
            Event::Evaluated { evaluation, .. } => {
                evaluation.returns.iter().for_each(|&score| check(score));
            }
            Event::Kept { mean_return, .. } => assert!(*mean_return <= 1.0),
            _ => {}
        }
    }
    assert!(counted > 100, "{counted}");
    assert!((last_mean(&events) - 1.0).abs() < 1e-12);
}

#[test]
fn a_chain_is_followed_past_a_near_reward_to_the_far_one() {
    for seed in 0..3 {
        let config = TrainingConfig { seed, steps: 12_800, ..small() };
        let make = || Chain::new(8);
        let (policy, events) = trained(&make, &config);
        for state in 1..7 {
            let at = |other| f32::from(u8::from(other == state));
            let observation = Observation::vector((0..8).map(at).collect(), 2);
            assert_eq!(policy.act(&observation), 1, "seed {seed}, state {state}");
        }
        assert!(last_mean(&events) > 0.95, "seed {seed}: {}", last_mean(&events));
    }
}

/// A reward of 1 in each step, and an end after four steps that the agent does not see.
#[derive(Clone, Debug)]
struct Endless {
    end: EpisodeEnd,
    steps: u32,
}

impl Environment for Endless {
    fn identity(&self) -> String {
        format!("task = \"endless, {:?}\"", self.end)
    }

    fn space(&self) -> Space {
        Space::vector(1, 2)
    }

    fn reset(&mut self, _: u64) -> Observation {
        self.steps = 0;
        Observation::vector(vec![1.0], 2)
    }

    fn step(&mut self, _: usize) -> Step {
        self.steps += 1;
        let end = (self.steps == 4).then_some(self.end);
        Step { observation: Observation::vector(vec![1.0], 2), reward: 1.0, end }
    }
}

#[test]
fn truncated_episodes_are_continued_by_the_critic() {
    let value = |end| {
        let config = TrainingConfig {
            gamma: 0.8,
            gae_lambda: 0.5,
            clip_value: false,
            anneal_learning_rate: false,
            steps: 20_000,
            ..small()
        };
        let (policy, _) = trained(&|| Endless { end, steps: 0 }, &config);
        let observation = [Tensor::from_slice(&[1.0_f32]).view([1, 1])];
        policy.network.forward(&observation).value.double_value(&[0])
    };
    // Without an end, 1 / (1 - gamma) = 5.
    let truncated = value(EpisodeEnd::Truncated);
    assert!((truncated - 5.0).abs() < 0.1, "{truncated}");
    // With four steps to the end, the critic, which does not see their number, learns a mean of at
    // most 1 + 0.8 + 0.8² + 0.8³.
    let terminated = value(EpisodeEnd::Terminated);
    assert!(terminated < 2.9, "{terminated}");
}

#[test]
fn a_pole_is_balanced() {
    let config = TrainingConfig {
        steps: 40_960,
        learning_rate: 1e-3,
        threads: 1,
        ..TrainingConfig::cart_pole()
    };
    let (policy, events) = trained(&CartPole::default, &config);
    assert!(last_mean(&events) > 150.0, "{}", last_mean(&events));
    let seeds: Vec<u64> = (1000..1010).collect();
    let make = &CartPole::default;
    let network = policy.network.as_ref();
    let evaluation =
        ppo::evaluate(make, network, &seeds, Device::Cpu, &Control::default()).unwrap();
    assert!(evaluation.mean() > 400.0, "{:?}", evaluation.returns);
}

/// The files of a run, by name.
fn files(out: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(out)
        .unwrap()
        .map(|entry| {
            let entry = entry.unwrap();
            (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap())
        })
        .collect();
    files.sort();
    files
}

/// A configuration whose runs have evaluations, improvements and truncated episodes.
fn varied() -> TrainingConfig {
    TrainingConfig {
        steps: 2560,
        stagger: 9,
        evaluation_episodes: 3,
        evaluate_every: 30,
        ..small()
    }
}

/// Episodes of ten steps without rewards.
struct TenSteps(usize);

impl Environment for TenSteps {
    fn identity(&self) -> String {
        "task = \"ten steps\"".into()
    }

    fn space(&self) -> Space {
        Space::vector(1, 2)
    }

    fn reset(&mut self, _: u64) -> Observation {
        self.0 = 0;
        Observation::vector(vec![0.0], 2)
    }

    fn step(&mut self, _: usize) -> Step {
        self.0 += 1;
        let end = (self.0 == 10).then_some(EpisodeEnd::Terminated);
        Step { observation: Observation::vector(vec![0.0], 2), reward: 0.0, end }
    }
}

#[test]
fn staggered_environments_are_at_different_steps() {
    let ends = |stagger: u32| {
        let config =
            TrainingConfig { steps: 320, environments: 8, rollout: 10, stagger, ..small() };
        let (_, events) = trained(&|| TenSteps(0), &config);
        let ended = |event: &Event| match event {
            Event::Episode { steps, length, .. } => {
                assert_eq!(*length, 10);
                Some(*steps)
            }
            _ => None,
        };
        let mut ends: Vec<u64> = events.iter().filter_map(ended).collect();
        // Each of the eight environments ends four episodes in forty steps, or more if it began
        // later.
        assert!(ends.len() >= 32);
        ends.dedup();
        ends
    };
    assert_eq!(ends(0), [80, 160, 240, 320]);
    assert!(ends(25).len() > 12);
}

#[test]
fn threads_change_nothing() {
    let pool = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let results = [Threads::One, Threads::Pool(&pool), Threads::Pool(&pool)].map(|threads| {
        let out = tempdir().unwrap();
        let (end, events) = run(&CartPole::default, &varied(), out.path(), threads, u64::MAX);
        assert_eq!(end.unwrap(), End::Done);
        (files(out.path()), events)
    });
    assert!(results[0] == results[1] && results[0] == results[2]);
    let names: Vec<&str> = results[0].0.iter().map(|(name, _)| name.as_str()).collect();
    let expected = "best.safetensors config.toml greedy.safetensors last.checkpoint \
                    last.safetensors space.toml";
    assert_eq!(names.join(" "), expected);
}

#[test]
fn an_interrupted_run_ends_with_the_same_bytes() {
    let make = || Chain::new(8);
    for config in [varied(), TrainingConfig { target_kl: Some(1e-3), seed: 7, ..varied() }] {
        let whole = tempdir().unwrap();
        let (end, all) = run(&make, &config, whole.path(), Threads::One, u64::MAX);
        assert_eq!(end.unwrap(), End::Done);

        let out = tempdir().unwrap();
        let mut repeated = Vec::new();
        for stop_after in [0, 4, 100, 500, 516, 1400, 2500, u64::MAX] {
            let (end, events) = run(&make, &config, out.path(), Threads::One, stop_after);
            let done = stop_after == u64::MAX;
            assert_eq!(end.unwrap(), if done { End::Done } else { End::TimeUp });
            let Event::Started { steps, episodes } = events[0] else { panic!("{events:?}") };
            assert!(steps <= stop_after && (steps > 0 || episodes == 0));
            // Events of steps that are repeated are the same as before.
            repeated.retain(|event| steps_of(event) <= steps);
            repeated.extend(events.into_iter().skip(1));
        }
        assert_eq!(repeated[..], all[1..]);
        assert!(files(out.path()) == files(whole.path()));

        // A run that is complete stays as it is.
        let (end, events) = run(&make, &config, out.path(), Threads::One, u64::MAX);
        assert_eq!((end.unwrap(), events.len()), (End::Done, 1));
        assert!(files(out.path()) == files(whole.path()));
    }
}

fn steps_of(event: &Event) -> u64 {
    match event {
        Event::Started { steps, .. }
        | Event::Episode { steps, .. }
        | Event::Kept { steps, .. }
        | Event::Evaluated { steps, .. } => *steps,
        Event::Updated(update) => update.steps,
    }
}

#[test]
fn a_killed_run_resumes_from_its_last_checkpoint() {
    let make = || Chain::new(8);
    let (whole, out) = (tempdir().unwrap(), tempdir().unwrap());
    run(&make, &varied(), whole.path(), Threads::One, u64::MAX).0.unwrap();
    // An observer that panics stands for a process that is killed.
    let mut updates = 0;
    let mut observer = |event: &Event| {
        if let Event::Updated(_) = event {
            updates += 1;
            assert!(updates < 13, "killed");
        }
    };
    let killed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        let run = ppo::Run { device: Device::Cpu, out: out.path(), observer: &mut observer };
        ppo::train(&make, &varied(), run, &Control::default())
    }));
    assert!(killed.is_err());
    run(&make, &varied(), out.path(), Threads::One, u64::MAX).0.unwrap();
    assert!(files(out.path()) == files(whole.path()));
}

#[test]
fn checkpoints_of_other_runs_are_refused() {
    let out = tempdir().unwrap();
    run(&|| Chain::new(8), &small(), out.path(), Threads::One, 200).0.unwrap();
    let before = files(out.path());
    let error = |make: &dyn Fn() -> Chain, config: &TrainingConfig| {
        run(make, config, out.path(), Threads::One, u64::MAX).0.unwrap_err().to_string()
    };
    let other = TrainingConfig { gamma: 0.9, ..small() };
    let message = error(&|| Chain::new(8), &other);
    assert!(message.contains("it has 'gamma = 0.99', this run has 'gamma = 0.9'"), "{message}");
    let message = error(&|| Chain::new(9), &small());
    assert!(message.contains("it has 'length = 8', this run has 'length = 9'"), "{message}");
    assert!(files(out.path()) == before);
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let out = tempdir().unwrap();
    for reward in [f64::NAN, f64::INFINITY] {
        let make = || Bandit::new(&[0.0, reward]);
        let (end, _) = run(&make, &small(), out.path(), Threads::One, u64::MAX);
        let message = end.unwrap_err().to_string();
        assert!(message.contains("is not finite in update 1"), "{message}");
        fs::remove_file(ppo::last_checkpoint(out.path())).unwrap();
    }
}

#[test]
fn fields_out_of_their_ranges_are_refused() {
    let error = |line: &str| TrainingConfig::from_toml(line).unwrap_err().to_string();
    let counts = ["environments", "rollout", "epochs", "minibatches", "evaluate_every", "window"];
    for field in counts.into_iter().chain(["evaluation_episodes"]) {
        assert!(error(&format!("{field} = 0")).starts_with(&format!("{field} is 0: expected")));
    }
    for field in
        ["learning_rate", "adam_epsilon", "clip", "max_grad_norm", "reward_scale", "target_kl"]
    {
        for value in ["0.0", "nan", "-1.0", "inf"] {
            let message = error(&format!("{field} = {value}"));
            assert!(message.ends_with("expected a positive number"), "{message}");
        }
    }
    for field in ["gamma", "gae_lambda"] {
        assert!(error(&format!("{field} = 1.5")).ends_with("expected a number from 0 to 1"));
    }
    for field in ["entropy", "value"] {
        assert!(error(&format!("{field} = -0.5")).ends_with("expected 0 or a positive number"));
    }
    assert!(error("minibatches = 3").contains("a divisor of environments times rollout"));
    assert!(error("minibatches = 1024").contains("at least two steps in a minibatch"));
    assert!(error("steps = 1023").contains("at least environments times rollout"));
    assert!(error("steps = 1024\nclipping = 0.2").contains("unknown field `clipping`"));
    let network = "[network]\nkind = \"perceptron\"\n";
    assert!(error(&format!("{network}hidden = [64, 0]")).starts_with("network.hidden is 0"));
    assert!(error(&format!("{network}width = 3")).contains("unknown field `width`"));
    assert!(error("[network]\nkind = \"forest\"").contains("forest"));
    for config in [TrainingConfig::default(), TrainingConfig::cart_pole(), small()] {
        assert_eq!(TrainingConfig::from_toml(&config.resolved()).unwrap(), config);
    }
}
