//! `FusionNet` beside the same network in PyTorch, whose weights, inputs and outputs are in `data`
//! (`make_fusion.py`).

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use beadwork_learn::fusion::{Config, FusionNet, History, Precision, Proposals, Without};
use beadwork_learn::weights::{self, WeightsError};
use tch::nn::VarStore;
use tch::{Device, Kind, Tensor};

/// The sizes that the reference was made with.
const REFERENCE: Config =
    Config { width: 8, hidden: 16, history: 6, places: 128, canvas: 32, without: Without::Nothing };

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn network(config: Config) -> (VarStore, FusionNet) {
    tch::manual_seed(0);
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), config);
    (variables, network)
}

fn inputs() -> HashMap<String, Tensor> {
    Tensor::read_safetensors(data("fusion_io.safetensors")).unwrap().into_iter().collect()
}

fn history(inputs: &HashMap<String, Tensor>) -> History {
    let of = |name: &str| inputs[name].shallow_clone();
    History {
        action: of("action"),
        y: of("y"),
        x: of("x"),
        before: of("before"),
        after: of("after"),
        mask: of("mask"),
    }
}

fn largest_difference(a: &Tensor, b: &Tensor) -> f64 {
    assert_eq!(a.size(), b.size());
    (a - b).abs().max().double_value(&[])
}

#[test]
fn proposals_are_those_of_pytorch() {
    let (variables, network) = network(REFERENCE);
    weights::load(&variables, &data("fusion_weights.safetensors")).unwrap();
    let inputs = inputs();
    let Proposals { position, action } = tch::no_grad(|| {
        network.forward(&inputs["state"], &history(&inputs), Precision::Single, false)
    });
    let differences = [
        largest_difference(&position, &inputs["position"]),
        largest_difference(&action, &inputs["action_logits"]),
    ];
    assert!(differences.iter().all(|&difference| difference < 1e-4), "{differences:?}");
}

#[test]
fn what_comes_after_the_last_move_does_not_matter() {
    let (variables, network) = network(REFERENCE);
    weights::load(&variables, &data("fusion_weights.safetensors")).unwrap();
    let inputs = inputs();
    let state = &inputs["state"];
    let forward = |history: &History| {
        tch::no_grad(|| network.forward(state, history, Precision::Single, false).position)
    };
    let moves = history(&inputs);
    let gap: Tensor = 1.0 - &moves.mask;
    let other = History {
        action: &moves.action + gap.to_kind(Kind::Int64) * (5 - &moves.action),
        before: &moves.before + &gap,
        after: &moves.after - &gap,
        ..history(&inputs)
    };
    assert_eq!(forward(&moves), forward(&other));
}

#[test]
fn history_leaves_features_alone_before_training() {
    let (_variables, network) = network(REFERENCE);
    let inputs = inputs();
    let forward = |history: &History| {
        tch::no_grad(|| network.forward(&inputs["state"], history, Precision::Single, false).action)
    };
    let none = History { mask: inputs["mask"].zeros_like(), ..history(&inputs) };
    assert_eq!(forward(&history(&inputs)), forward(&none));
}

#[test]
fn what_is_left_out_does_not_matter() {
    let inputs = inputs();
    let moved = |without, part: &str| {
        let (variables, network) = network(Config { without, ..REFERENCE });
        weights::load(&variables, &data("fusion_weights.safetensors")).unwrap();
        let forward = || {
            let proposals =
                network.forward(&inputs["state"], &history(&inputs), Precision::Single, false);
            proposals.position.shallow_clone()
        };
        let before = tch::no_grad(forward);
        for (name, mut variable) in variables.variables() {
            if name.starts_with(part) {
                tch::no_grad(|| _ = variable.fill_(0.25));
            }
        }
        before != tch::no_grad(forward)
    };
    for (part, left_out) in
        [("history_encoder", Without::History), ("bottleneck_attn", Without::Attention)]
    {
        assert!(moved(Without::Nothing, part) && !moved(left_out, part), "{part}");
    }
}

#[test]
fn all_parameters_are_trained() {
    let (variables, network) = network(REFERENCE);
    let inputs = inputs();
    // Away from the start, where nothing of the history comes through.
    tch::no_grad(|| {
        variables.trainable_variables().iter_mut().for_each(|p| *p += 0.05 * p.randn_like())
    });
    let Proposals { position, action } =
        network.forward(&inputs["state"], &history(&inputs), Precision::Single, true);
    (position.square().mean(Kind::Float) + action.square().mean(Kind::Float)).backward();
    for (name, variable) in variables.variables() {
        let gradient = variable.grad();
        assert!(
            gradient.defined() && gradient.abs().sum(Kind::Float).double_value(&[]) > 0.0,
            "{name}"
        );
    }
}

#[test]
fn sizes_of_the_presets() {
    assert_eq!([30, 32, 33, 100].map(|grid| Config::small(grid).canvas), [32, 32, 48, 112]);
    let (variables, network) = network(Config::paper());
    let count: usize = variables.trainable_variables().iter().map(Tensor::numel).sum();
    assert_eq!((network.config(), count), (Config::paper(), 4_035_429));
}

#[test]
#[should_panic(expected = "12 channels are shared out among 8 groups")]
fn widths_have_to_suit_the_norms() {
    network(Config { width: 24, ..REFERENCE });
}

#[test]
#[should_panic(expected = "the canvas of 40 can be halved four times")]
fn canvases_are_halved_four_times() {
    network(Config { canvas: 40, ..REFERENCE });
}

#[test]
#[should_panic(expected = "[3, 9, 24, 32] is a batch of layers")]
fn images_are_halved_four_times() {
    let inputs = inputs();
    network(REFERENCE).1.forward(
        &inputs["state"].slice(2, 0, 24, 1),
        &history(&inputs),
        Precision::Single,
        false,
    );
}

#[test]
fn wrong_weights_are_named_and_change_nothing() {
    let folder = std::env::temp_dir().join(format!("beadwork-learn-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let good: Vec<(String, Tensor)> =
        Tensor::read_safetensors(data("fusion_weights.safetensors")).unwrap();
    let (variables, _network) = network(REFERENCE);
    let sums = |variables: &VarStore| -> HashSet<String> {
        let all = variables.variables().into_iter();
        all.map(|(name, p)| format!("{name} {}", p.sum(Kind::Double).double_value(&[]))).collect()
    };
    let before = sums(&variables);
    let refused = |name: &str, tensors: &[(&str, Tensor)]| {
        let path = folder.join(name);
        Tensor::write_safetensors(tensors, &path).unwrap();
        let error = weights::load(&variables, &path).unwrap_err();
        assert_eq!(sums(&variables), before, "{error}");
        error
    };
    let with = |change: &dyn Fn(&str, &Tensor) -> Option<Tensor>| -> Vec<(&str, Tensor)> {
        good.iter()
            .filter_map(|(name, tensor)| Some((name.as_str(), change(name, tensor)?)))
            .collect()
    };
    let missing =
        with(&|name, tensor| (name != "film_proj.0.bias").then(|| tensor.shallow_clone()));
    let error = refused("missing", &missing);
    assert!(
        matches!(&error, WeightsError::Missing { name, .. } if name == "film_proj.0.bias"),
        "{error}"
    );
    let shape = with(&|name, tensor| {
        Some(if name.starts_with("enc2.proj.0") {
            tensor.tile([2, 1, 1, 1])
        } else {
            tensor.shallow_clone()
        })
    });
    let error = refused("shape", &shape);
    assert!(
        matches!(&error, WeightsError::Shape { expected, got, .. } if expected[0] * 2 == got[0]),
        "{error}"
    );
    let mut unknown = with(&|_, tensor| Some(tensor.shallow_clone()));
    unknown.push(("enc5.proj.0.weight", Tensor::zeros([1], (Kind::Float, Device::Cpu))));
    let error = refused("unknown", &unknown);
    assert!(
        matches!(&error, WeightsError::Unknown { name, .. } if name == "enc5.proj.0.weight"),
        "{error}"
    );
    let whole = std::fs::read(data("fusion_weights.safetensors")).unwrap();
    for length in [0, 7, 1000, whole.len() - 1] {
        let path = folder.join("short");
        std::fs::write(&path, &whole[..length]).unwrap();
        let error = weights::load(&variables, &path).unwrap_err();
        assert!(matches!(error, WeightsError::Unreadable { .. }), "{error}");
        assert_eq!(sums(&variables), before);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
