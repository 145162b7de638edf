//! What the network is trained for, and training that goes on after a stop.

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

mod common;

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use beadwork_dataset::Dataset;
use beadwork_learn::Device;
use beadwork_learn::adamw::{AdamW, AdamWSettings};
use beadwork_learn::fusion::Proposals;
use beadwork_learn::fusion::loss::{Hits, LossSettings, PositionLoss, loss};
use beadwork_learn::fusion::model::{Model, ModelError};
use beadwork_learn::fusion::samples::Targets;
use beadwork_learn::fusion::train::{
    End, Event, Run, TrainError, Training, last_checkpoint, train,
};
use tch::{Kind, Tensor};
use tempfile::{TempDir, tempdir};

use self::common::{CHAINS, alone, dataset, small};

/// The loss as a loop over cells.
fn loss_by_definition(
    (scores, logits): (&[Vec<f64>], &[Vec<Vec<f64>>]),
    (positions, actions, rivals): (&[usize], &[usize], &[Vec<bool>]),
    width: usize,
    settings: &LossSettings,
) -> f64 {
    let log_softmax = |logits: &[f64], at: usize| {
        let most = logits.iter().copied().fold(f64::MIN, f64::max);
        logits[at] - most - logits.iter().map(|logit| (logit - most).exp()).sum::<f64>().ln()
    };
    let entropy = |logits: &[f64], truth: usize, smoothing: f64| {
        let all: f64 = (0..logits.len()).map(|at| -log_softmax(logits, at)).sum();
        (1.0 - smoothing) * -log_softmax(logits, truth) + smoothing * all / logits.len() as f64
    };
    let (mut ranking, mut ranked, mut classification) = (0.0, 0, 0.0);
    let (mut action, mut neighbours, mut neighbour_count) = (0.0, 0.0, 0);
    for (example, &truth) in positions.iter().enumerate() {
        let of_rivals = scores[example].iter().zip(&rivals[example]).filter(|(_, rival)| **rival);
        let mut others: Vec<f64> = of_rivals.map(|(&score, _)| score).collect();
        others.sort_by(|a, b| b.total_cmp(a));
        for other in others.iter().take(settings.hardest as usize) {
            ranking += (settings.margin - scores[example][truth] + other).max(0.0);
            ranked += 1;
        }
        others.insert(0, scores[example][truth]);
        classification -= log_softmax(&others, 0);
        let at = |cell: usize| -> Vec<f64> { logits[example].iter().map(|of| of[cell]).collect() };
        action += entropy(&at(truth), actions[example], settings.smoothing);
        let (x, y, height) = (truth % width, truth / width, scores[example].len() / width);
        let sides = [
            (x > 0).then(|| truth - 1),
            (x + 1 < width).then(|| truth + 1),
            (y > 0).then(|| truth - width),
            (y + 1 < height).then(|| truth + width),
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
fn the_loss_is_the_one_of_a_loop_over_cells() {
    let _alone = alone();
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
        let rivals: Vec<Vec<bool>> = (0..batch)
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
            rivals: Tensor::from_slice(&rivals.concat()).view([batch as i64, -1]),
        };
        for position in [PositionLoss::Ranking, PositionLoss::Classification] {
            for hardest in [1, 3, 1000] {
                let settings = LossSettings { position, hardest, ..LossSettings::default() };
                let expected = loss_by_definition(
                    (&scores, &logits),
                    (&positions, &actions, &rivals),
                    width,
                    &settings,
                );
                let got = loss(&proposals, &targets, &settings).double_value(&[]);
                assert!(
                    (got - expected).abs() < 1e-4,
                    "{position:?}, {hardest}: {got} for {expected}"
                );
            }
        }
        for (at, hits) in Hits::each(&proposals, &targets).into_iter().enumerate() {
            let above = (0..cells)
                .filter(|&cell| rivals[at][cell] && scores[at][cell] >= scores[at][positions[at]])
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
fn adamw_steps_as_its_equations_say() {
    let settings = AdamWSettings { weight_decay: 0.1, ..AdamWSettings::default() };
    let start = [0.5, -1.5, 2.0];
    let parameter = Tensor::from_slice(&start).set_requires_grad(true);
    let mut optimiser = AdamW::new(vec![parameter.shallow_clone()], settings);
    let (mut x, mut mean, mut square) = (start, [0.0; 3], [0.0; 3]);
    for step in 1..=20 {
        optimiser.zero_grad();
        // f = sum of x^4 / 4, whose gradient x^3 is clipped to length 2.
        (parameter.pow_tensor_scalar(4) / 4.0).sum(Kind::Double).backward();
        let length = optimiser.step(0.05, 2.0);
        let gradient = x.map(|x: f64| x.powi(3));
        let expected_length = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!((length - expected_length).abs() < 1e-4);
        let shorter = (2.0 / expected_length).min(1.0);
        for at in 0..3 {
            let g = gradient[at] * shorter;
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

/// Trains with a limit of steps after which it is cancelled, and notes the losses.
fn run(
    dataset: &Dataset,
    training: &Training,
    out: &Path,
    cancel_after: u64,
) -> (Result<End, TrainError>, Vec<f64>) {
    let cancel = AtomicBool::new(false);
    let mut losses = Vec::new();
    let mut observer = |event: &Event| {
        if let Event::Step { step, loss, .. } = event {
            losses.push(*loss);
            cancel.store(*step >= cancel_after, Ordering::Relaxed);
        }
    };
    let end = train(
        dataset,
        training,
        Run { device: Device::Cpu, out, cancel: &cancel, observer: &mut observer },
    );
    (end, losses)
}

#[test]
fn a_run_that_was_stopped_goes_on_with_the_same_losses() {
    let _alone = alone();
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
    assert_eq!(model.training, training);
    assert_eq!(model.origin.dataset, format!("{:016x}", dataset.manifest().fingerprint()));
}

#[test]
fn a_run_that_stopped_early_has_ended() {
    let _alone = alone();
    let (_folder, dataset) = dataset(CHAINS);
    let out = tempdir().unwrap();
    // So short steps that half precision sees no change.
    let training = Training { rate: 1e-30, evaluate_every: 1, patience: 2, steps: 9, ..small() };
    let (end, losses) = run(&dataset, &training, out.path(), u64::MAX);
    assert_eq!(end.unwrap(), End::Early);
    assert!((3..9).contains(&losses.len()), "{losses:?}");
    let before = fs::read(last_checkpoint(out.path())).unwrap();
    let (end, losses) = run(&dataset, &training, out.path(), u64::MAX);
    assert_eq!((end.unwrap(), losses.len()), (End::Early, 0));
    assert!(fs::read(last_checkpoint(out.path())).unwrap() == before);
}

#[test]
fn fields_out_of_their_ranges_are_named() {
    let wrong = |line: &str| {
        let training: Training = toml::from_str(line).unwrap();
        training.check().unwrap_err().to_string()
    };
    for field in ["hidden", "history", "steps", "batch", "per_trajectory", "evaluate_every"] {
        assert_eq!(wrong(&format!("{field} = 0")), format!("'{field}' is 0, it must be positive"));
    }
    for field in ["valid_per_trajectory", "patience"] {
        assert_eq!(wrong(&format!("{field} = 0")), format!("'{field}' is 0, it must be positive"));
    }
    for width in [-16, 0, 1, 3, 6, 12, 24] {
        assert!(wrong(&format!("width = {width}")).contains("a multiple of 16"));
    }
    for field in ["rate", "clip"] {
        assert!(wrong(&format!("{field} = 0.0")).ends_with("must be positive"));
        assert!(wrong(&format!("{field} = nan")).ends_with("must be positive"));
    }
    for field in ["smoothing", "neighbour_smoothing"] {
        assert!(wrong(&format!("loss.{field} = 1.5")).ends_with("must be between 0 and 1"));
    }
    for field in ["balance", "final_rate"] {
        assert!(wrong(&format!("{field} = -0.5")).ends_with("must be between 0 and 1"));
    }
    for field in ["weight_decay", "loss.margin", "loss.neighbours"] {
        assert!(wrong(&format!("{field} = -0.5")).ends_with("must be 0 or more"));
    }
    assert!(wrong("loss.hardest = 0").contains("'loss.hardest' is 0"));
    for width in [2, 4, 8, 16, 48] {
        Training { width, ..Training::default() }.check().unwrap();
    }
}

#[test]
fn what_can_not_be_trained_is_told_and_leaves_checkpoints_as_they_are() {
    let _alone = alone();
    let (_folder, dataset) = dataset(CHAINS);
    let out = tempdir().unwrap();
    let training = small();
    run(&dataset, &training, out.path(), u64::MAX).0.unwrap();
    let checkpoint = last_checkpoint(out.path());
    let before = fs::read(&checkpoint).unwrap();
    let fail = |training: &Training, out: &Path| {
        run(&dataset, training, out, u64::MAX).0.unwrap_err().to_string()
    };

    let error = fail(&Training { rate: 1e-3, ..training.clone() }, out.path());
    assert!(error.contains("'rate = 0.0004' where this one has 'rate = 0.001'"), "{error}");
    let (_other_folder, other) = self::dataset(&format!("seed = 1\n{CHAINS}"));
    let error = run(&other, &training, out.path(), u64::MAX).0.unwrap_err().to_string();
    assert!(error.contains("with 'dataset = "), "{error}");
    let error = fail(&Training { width: 24, ..training.clone() }, out.path());
    assert!(error.contains("'width' is 24"), "{error}");
    assert_eq!(fs::read(&checkpoint).unwrap(), before);

    // Steps so long that the weights overflow.
    let wild = tempdir().unwrap();
    let training = Training { rate: 1e30, warm_up: 0, evaluate_every: 1, ..training };
    let error = fail(&training, wild.path());
    assert!(error.contains("is no number"), "{error}");
    let saved = fs::read(last_checkpoint(wild.path())).unwrap();
    assert!(!saved.is_empty());
    let error = fail(&training, wild.path());
    assert!(error.contains("is no number"), "{error}");
    assert_eq!(fs::read(last_checkpoint(wild.path())).unwrap(), saved);

    fs::write(&checkpoint, &before[..before.len() / 2]).unwrap();
    let error = fail(&small(), out.path());
    assert!(error.contains("is no file of weights"), "{error}");
    fs::write(&checkpoint, fs::read(Model::weights_file(out.path())).unwrap()).unwrap();
    let error = fail(&small(), out.path());
    assert!(error.contains("is no checkpoint: it has no 'run.configuration'"), "{error}");
}

#[test]
fn a_folder_that_holds_no_model_is_told() {
    let _alone = alone();
    let folder = tempdir().unwrap();
    let open = || Model::open(folder.path(), Device::Cpu).unwrap_err();
    assert!(matches!(open(), ModelError::Unreadable { .. }));
    let config = Model::config_file(folder.path());
    fs::write(&config, "wide = 3\n").unwrap();
    assert!(open().to_string().contains("wide"), "{}", open());
    fs::write(&config, "width = -3\n").unwrap();
    assert!(open().to_string().contains("'width' is -3"), "{}", open());
    fs::write(&config, "width = 4\nhidden = 8\n").unwrap();
    assert!(open().to_string().contains("dataset.toml"), "{}", open());
    let origin = Model::origin_file(folder.path());
    fs::write(&origin, "dataset = 'ab'\ntrajectories = 'many'\nmoves = 3\n").unwrap();
    assert!(open().to_string().contains("line 2"), "{}", open());
    fs::write(&origin, "dataset = 'ab'\ntrajectories = 2\nmoves = 3\n").unwrap();
    assert!(matches!(open(), ModelError::Weights(_)));
}
