//! Loss, optimiser, and training that is interrupted and resumed.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

mod common;

use std::fs;
use std::path::Path;

use beadwork_base::{CancelToken, Control, Interrupted, Progress};
use beadwork_dataset::Dataset;
use beadwork_learn::Device;
use beadwork_learn::adamw::{self, AdamW};
use beadwork_learn::fusion::evaluate::{Hits, evaluate};
use beadwork_learn::fusion::loss::{self, PositionLoss, fusion_loss};
use beadwork_learn::fusion::model::{Model, ModelError};
use beadwork_learn::fusion::samples::{Batch, Batches, Split, Targets};
use beadwork_learn::fusion::train::{End, Event, Run, TrainError, last_checkpoint, train};
use beadwork_learn::fusion::{Proposals, TrainingConfig};
use tch::{Kind, Tensor};
use tempfile::{TempDir, tempdir};

use self::common::{CHAINS, dataset, lock_generator, small};

/// The loss computed by a loop over cells, from its definition.
fn loss_by_definition(
    (scores, logits): (&[Vec<f64>], &[Vec<Vec<f64>>]),
    (positions, actions, negatives): (&[usize], &[usize], &[Vec<bool>]),
    width: usize,
    settings: &loss::Settings,
) -> f64 {
    let log_softmax = |logits: &[f64], at: usize| {
        let max = logits.iter().copied().fold(f64::MIN, f64::max);
        logits[at] - max - logits.iter().map(|logit| (logit - max).exp()).sum::<f64>().ln()
    };
    let entropy = |logits: &[f64], target: usize, smoothing: f64| {
        let all: f64 = (0..logits.len()).map(|at| -log_softmax(logits, at)).sum();
        (1.0 - smoothing) * -log_softmax(logits, target) + smoothing * all / logits.len() as f64
    };
    let (mut ranking, mut ranked, mut classification) = (0.0, 0, 0.0);
    let (mut action, mut neighbours, mut neighbour_count) = (0.0, 0.0, 0);
    for (example, &target) in positions.iter().enumerate() {
        let cells = scores[example].iter().zip(&negatives[example]);
        let mut others: Vec<f64> =
            cells.filter(|(_, is_negative)| **is_negative).map(|(&score, _)| score).collect();
        others.sort_by(|a, b| b.total_cmp(a));
        for other in others.iter().take(settings.hardest as usize) {
            ranking += (settings.margin - scores[example][target] + other).max(0.0);
            ranked += 1;
        }
        others.insert(0, scores[example][target]);
        classification -= log_softmax(&others, 0);
        let at = |cell: usize| -> Vec<f64> { logits[example].iter().map(|of| of[cell]).collect() };
        action += entropy(&at(target), actions[example], settings.smoothing);
        let (x, y, height) = (target % width, target / width, scores[example].len() / width);
        let sides = [
            (x > 0).then(|| target - 1),
            (x + 1 < width).then(|| target + 1),
            (y > 0).then(|| target - width),
            (y + 1 < height).then(|| target + width),
        ];
        for cell in sides.into_iter().flatten() {
            neighbours += entropy(&at(cell), actions[example], settings.neighbour_smoothing);
            neighbour_count += 1;
        }
    }
    let count = positions.len() as f64;
    let position = match settings.position {
        PositionLoss::Ranking => ranking / f64::from(ranked.max(1)),
        PositionLoss::Classification => classification / count,
    };
    position + action / count + settings.neighbours * neighbours / f64::from(neighbour_count.max(1))
}

#[test]
fn the_loss_equals_its_definition() {
    let _generator = lock_generator();
    tch::manual_seed(3);
    let (batch, height, width) = (4_usize, 5_usize, 6_usize);
    let cells = height * width;
    for round in 0..50 {
        let draw = |channels: i64| {
            Tensor::randn(
                [batch as i64, channels, height as i64, width as i64],
                (Kind::Double, Device::Cpu),
            )
        };
        let proposals = Proposals {
            position: draw(1).to_kind(Kind::Float),
            action: draw(12).to_kind(Kind::Float),
        };
        let scores: Vec<Vec<f64>> =
            Vec::try_from(proposals.position.view([batch as i64, -1]).to_kind(Kind::Double))
                .unwrap();
        let flat: Vec<f64> =
            Vec::try_from(proposals.action.contiguous().view([-1]).to_kind(Kind::Double)).unwrap();
        let logits: Vec<Vec<Vec<f64>>> = flat
            .chunks(12 * cells)
            .map(|of| of.chunks(cells).map(<[f64]>::to_vec).collect())
            .collect();
        let positions: Vec<usize> = (0..batch).map(|at| (round * 7 + at * 11) % cells).collect();
        let actions: Vec<usize> = (0..batch).map(|at| (round + at * 5) % 12).collect();
        let negatives: Vec<Vec<bool>> = (0..batch)
            .map(|at| {
                (0..cells)
                    .map(|cell| cell != positions[at] && (cell * 31 + round * at) % 3 == 0)
                    .collect()
            })
            .collect();
        let whole = |numbers: &[usize]| {
            Tensor::from_slice(&numbers.iter().map(|&n| n as i64).collect::<Vec<_>>())
        };
        let targets = Targets {
            position: whole(&positions),
            action: whole(&actions),
            negatives: Tensor::from_slice(&negatives.concat()).view([batch as i64, -1]),
        };
        for position in [PositionLoss::Ranking, PositionLoss::Classification] {
            for hardest in [1, 3, 1000] {
                let settings = loss::Settings { position, hardest, ..loss::Settings::default() };
                let expected = loss_by_definition(
                    (&scores, &logits),
                    (&positions, &actions, &negatives),
                    width,
                    &settings,
                );
                let got = fusion_loss(&proposals, &targets, &settings).double_value(&[]);
                assert!(
                    (got - expected).abs() < 1e-4,
                    "{position:?}, {hardest}: {got} for {expected}"
                );
            }
        }
        for (at, hits) in Hits::of_examples(&proposals, &targets).into_iter().enumerate() {
            let above = (0..cells)
                .filter(|&cell| {
                    negatives[at][cell] && scores[at][cell] >= scores[at][positions[at]]
                })
                .count();
            let likeliest = (0..12).max_by(|&a, &b| {
                logits[at][a][positions[at]].total_cmp(&logits[at][b][positions[at]])
            });
            let expected = [above < 1, above < 5, likeliest == Some(actions[at])].map(u64::from);
            assert_eq!([hits.top_1, hits.top_5, hits.action], expected);
        }
    }
}

#[test]
fn adamw_follows_its_equations() {
    let settings = adamw::Settings { weight_decay: 0.1, ..adamw::Settings::default() };
    let start = [0.5, -1.5, 2.0];
    let parameter = Tensor::from_slice(&start).set_requires_grad(true);
    let mut optimiser = AdamW::new(vec![parameter.shallow_clone()], settings);
    let (mut x, mut mean, mut square) = (start, [0.0; 3], [0.0; 3]);
    for step in 1..=20 {
        optimiser.zero_grad();
        // f is the sum of x^4 / 4; its gradient x^3 is scaled down to norm 2.
        (parameter.pow_tensor_scalar(4) / 4.0).sum(Kind::Double).backward();
        let norm = optimiser.step(0.05, 2.0);
        let gradient = x.map(|x: f64| x.powi(3));
        let expected_norm = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!((norm - expected_norm).abs() < 1e-4);
        let scale = (2.0 / expected_norm).min(1.0);
        for at in 0..3 {
            let g = gradient[at] * scale;
            mean[at] = 0.9 * mean[at] + 0.1 * g;
            square[at] = 0.999 * square[at] + 0.001 * g * g;
            let root = (square[at] / (1.0 - 0.999_f64.powi(step))).sqrt() + 1e-8;
            x[at] -= 0.05 * (0.1 * x[at] + mean[at] / (1.0 - 0.9_f64.powi(step)) / root);
        }
        let got = Vec::<f64>::try_from(&parameter).unwrap();
        assert!(got.iter().zip(x).all(|(got, x)| (got - x).abs() < 1e-5), "{got:?} {x:?}");
    }
    let before = Vec::<f64>::try_from(&parameter).unwrap();
    optimiser.zero_grad();
    (&parameter * f64::NAN).sum(Kind::Double).backward();
    assert!(!optimiser.step(0.05, 2.0).is_finite());
    assert_eq!(Vec::<f64>::try_from(&parameter).unwrap(), before);
}

/// Trains, cancels after a number of steps, and returns the losses of all steps.
fn run(
    dataset: &Dataset,
    config: &TrainingConfig,
    out: &Path,
    cancel_after: u64,
) -> (Result<End, TrainError>, Vec<f64>) {
    let cancel = CancelToken::new();
    let mut losses = Vec::new();
    let mut observer = |event: &Event| {
        if let Event::Step { step, loss, .. } = event {
            losses.push(*loss);
            if *step >= cancel_after {
                cancel.cancel();
            }
        }
    };
    let report = |Progress { total, .. }: Progress| assert_eq!(total as u64, config.steps);
    let control = Control { cancel: Some(&cancel), progress: Some(&report), ..Control::default() };
    let run = Run { device: Device::Cpu, out, observer: &mut observer };
    let end = train(dataset, config, run, &control);
    (end, losses)
}

#[test]
fn a_resumed_run_has_the_same_losses() {
    let _generator = lock_generator();
    let (_folder, dataset) = dataset(CHAINS);
    let (whole, parts) = (tempdir().unwrap(), tempdir().unwrap());
    let training = small();
    let (end, losses) = run(&dataset, &training, whole.path(), u64::MAX);
    assert_eq!((end.unwrap(), losses.len()), (End::Done, 12));
    let mut joined = Vec::new();
    for (stop_at, expected) in [(4, End::Cancelled), (9, End::Cancelled), (u64::MAX, End::Done)] {
        let (end, losses) = run(&dataset, &training, parts.path(), stop_at);
        assert_eq!(end.unwrap(), expected);
        joined.extend(losses);
    }
    assert_eq!(joined, losses);
    let bytes = |folder: &TempDir| fs::read(Model::weights_file(folder.path())).unwrap();
    assert_eq!(bytes(&whole), bytes(&parts));
    let model = Model::open(whole.path(), Device::Cpu).unwrap();
    assert_eq!(model.config, training);
    assert_eq!(model.origin.dataset, format!("{:016x}", dataset.manifest().fingerprint()));

    let samples = training.held_out(2);
    let batches: Vec<Batch> =
        Batches::new(&dataset, Split::Test, &samples, 0).collect::<Result<_, _>>().unwrap();
    let evaluate = |control: &Control<'_>| {
        evaluate(&model.network, &batches, &model.config, Device::Cpu, control)
    };
    let evaluation = evaluate(&Control::default()).unwrap();
    let examples: usize = batches.iter().map(Batch::len).sum();
    assert_eq!(evaluation.all.count as usize, examples);
    let is_up = || true;
    let interrupted = evaluate(&Control { time_is_up: Some(&is_up), ..Control::default() });
    assert_eq!(interrupted, Err(Interrupted::TimeUp));
}

/// Checkpoints of version 0.1.0 name the keys of the configuration differently.
#[test]
fn a_run_of_an_earlier_version_can_be_resumed() {
    let _generator = lock_generator();
    let (_folder, dataset) = dataset(CHAINS);
    let out = tempdir().unwrap();
    let training = small();
    let (_, first) = run(&dataset, &training, out.path(), 4);
    let checkpoint = last_checkpoint(out.path());
    let mut tensors: Vec<(String, Tensor)> = Tensor::read_safetensors(&checkpoint).unwrap();
    let configuration = tensors.iter_mut().find(|(name, _)| name == "run.configuration").unwrap();
    let mut text = String::from_utf8(Vec::try_from(&configuration.1).unwrap()).unwrap();
    for (new, old) in [
        ("ablation = \"none\"", "without = \"nothing\""),
        ("negatives = ", "rivals = "),
        ("final_learning_rate_ratio = ", "final_rate = "),
        ("learning_rate = ", "rate = "),
        ("warmup_steps = ", "warm_up = "),
        ("max_grad_norm = ", "clip = "),
    ] {
        assert_eq!(text.matches(new).count(), 1, "{new}");
        text = text.replace(new, old);
    }
    configuration.1 = Tensor::from_slice(text.as_bytes());
    Tensor::write_safetensors(&tensors, &checkpoint).unwrap();
    let (end, rest) = run(&dataset, &training, out.path(), u64::MAX);
    assert_eq!((end.unwrap(), first.len() + rest.len()), (End::Done, 12));
}

#[test]
fn the_committed_model_opens() {
    let _generator = lock_generator();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/fusion-small");
    let model = Model::open(&folder, Device::Cpu).unwrap();
    assert_eq!(model.config, TrainingConfig { steps: 8000, ..TrainingConfig::default() });
    assert_eq!(model.origin.dataset, "f34550eae97522d5");
}

#[test]
fn a_run_that_stopped_early_cannot_be_resumed() {
    let _generator = lock_generator();
    let (_folder, dataset) = dataset(CHAINS);
    let out = tempdir().unwrap();
    // The steps are too small to change weights in half precision.
    let training = TrainingConfig {
        learning_rate: 1e-30,
        evaluate_every: 1,
        patience: 2,
        steps: 9,
        ..small()
    };
    let (end, losses) = run(&dataset, &training, out.path(), u64::MAX);
    assert_eq!(end.unwrap(), End::Early);
    assert!((3..9).contains(&losses.len()), "{losses:?}");
    let before = fs::read(last_checkpoint(out.path())).unwrap();
    let (end, losses) = run(&dataset, &training, out.path(), u64::MAX);
    assert_eq!((end.unwrap(), losses.len()), (End::Early, 0));
    assert!(fs::read(last_checkpoint(out.path())).unwrap() == before);
}

#[test]
fn fields_out_of_their_ranges_are_refused() {
    let error = |line: &str| TrainingConfig::from_toml(line).unwrap_err().to_string();
    for field in [
        "hidden",
        "history",
        "steps",
        "batch",
        "per_trajectory",
        "evaluate_every",
        "valid_per_trajectory",
        "patience",
        "loss.hardest",
    ] {
        let message = format!("{field} is 0: expected at least 1");
        assert_eq!(error(&format!("{field} = 0")), message);
    }
    for width in [-16, 0, 1, 3, 6, 12, 24] {
        assert!(error(&format!("width = {width}")).contains("a multiple of 16"));
    }
    for field in ["learning_rate", "max_grad_norm"] {
        assert!(error(&format!("{field} = 0.0")).ends_with("expected a positive number"));
        assert!(error(&format!("{field} = nan")).ends_with("expected a positive number"));
    }
    for field in ["smoothing", "neighbour_smoothing"] {
        assert!(error(&format!("loss.{field} = 1.5")).ends_with("expected a number from 0 to 1"));
    }
    for field in ["balance", "final_learning_rate_ratio"] {
        assert!(error(&format!("{field} = -0.5")).ends_with("expected a number from 0 to 1"));
    }
    for field in ["weight_decay", "loss.margin", "loss.neighbours"] {
        assert!(error(&format!("{field} = -0.5")).ends_with("expected 0 or a positive number"));
    }
    for width in [2, 4, 8, 16, 48] {
        TrainingConfig { width, ..TrainingConfig::default() }.check().unwrap();
    }
}

#[test]
fn errors_leave_checkpoints_unchanged() {
    let _generator = lock_generator();
    let (_folder, dataset) = dataset(CHAINS);
    let out = tempdir().unwrap();
    let training = small();
    run(&dataset, &training, out.path(), u64::MAX).0.unwrap();
    let checkpoint = last_checkpoint(out.path());
    let before = fs::read(&checkpoint).unwrap();
    let fail = |training: &TrainingConfig, out: &Path| {
        run(&dataset, training, out, u64::MAX).0.unwrap_err().to_string()
    };

    let other_rate = TrainingConfig { learning_rate: 1e-3, ..training.clone() };
    let error = fail(&other_rate, out.path());
    assert!(
        error.contains("it has 'learning_rate = 0.0004', this run has 'learning_rate = 0.001'"),
        "{error}"
    );
    let (_other_folder, other) = self::dataset(&format!("seed = 1\n{CHAINS}"));
    let error = run(&other, &training, out.path(), u64::MAX).0.unwrap_err().to_string();
    assert!(error.contains("it has 'dataset = "), "{error}");
    let error = fail(&TrainingConfig { width: 24, ..training.clone() }, out.path());
    assert!(error.contains("width is 24"), "{error}");
    assert_eq!(fs::read(&checkpoint).unwrap(), before);

    // Steps so large that the weights overflow.
    let wild = tempdir().unwrap();
    let training =
        TrainingConfig { learning_rate: 1e30, warmup_steps: 0, evaluate_every: 1, ..training };
    let error = fail(&training, wild.path());
    assert!(error.contains("is not finite at step"), "{error}");
    let saved = fs::read(last_checkpoint(wild.path())).unwrap();
    assert!(!saved.is_empty());
    let error = fail(&training, wild.path());
    assert!(error.contains("is not finite at step"), "{error}");
    assert_eq!(fs::read(last_checkpoint(wild.path())).unwrap(), saved);

    fs::write(&checkpoint, &before[..before.len() / 2]).unwrap();
    let error = fail(&small(), out.path());
    assert!(error.contains("is not a readable safetensors file"), "{error}");
    fs::write(&checkpoint, fs::read(Model::weights_file(out.path())).unwrap()).unwrap();
    let error = fail(&small(), out.path());
    assert!(
        error.contains("is not a checkpoint: tensor 'run.configuration' is missing"),
        "{error}"
    );
}

#[test]
fn an_incomplete_model_is_refused() {
    let _generator = lock_generator();
    let folder = tempdir().unwrap();
    let open = || Model::open(folder.path(), Device::Cpu).unwrap_err();
    assert!(matches!(open(), ModelError::Unreadable { .. }));
    let config = Model::config_file(folder.path());
    fs::write(&config, "wide = 3\n").unwrap();
    assert!(open().to_string().contains("wide"), "{}", open());
    fs::write(&config, "width = -3\n").unwrap();
    assert!(open().to_string().contains("width is -3"), "{}", open());
    fs::write(&config, "width = 4\nhidden = 8\n").unwrap();
    assert!(open().to_string().contains("dataset.toml"), "{}", open());
    let origin = Model::origin_file(folder.path());
    fs::write(&origin, "dataset = 'ab'\ntrajectories = 'many'\nmoves = 3\n").unwrap();
    assert!(open().to_string().contains("line 2"), "{}", open());
    fs::write(&origin, "dataset = 'ab'\ntrajectories = 2\nmoves = 3\n").unwrap();
    assert!(matches!(open(), ModelError::Weights(_)));
}
