//! `FusionNet` compared with the same network in PyTorch, whose weights, inputs and outputs are in
//! `data` (made by `make_fusion.py`).

#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use beadwork_learn::fusion::{Ablation, Config, FusionNet, History, Precision, Proposals, parity};
use beadwork_learn::weights::{self, WeightsError};
use tch::nn::VarStore;
use tch::{Device, Kind, Tensor};

/// The sizes of the reference network.
const REFERENCE: Config = Config {
    width: 8,
    hidden: 16,
    history: 6,
    max_side: 128,
    canvas: 32,
    ablation: Ablation::None,
};

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
fn proposals_equal_those_of_pytorch() {
    let (variables, network) = network(REFERENCE);
    weights::load(&variables, &data("fusion_weights.safetensors")).unwrap();
    let inputs = inputs();
    let Proposals { position, action } =
        network.infer(&inputs["state"], &history(&inputs), Precision::Single);
    let differences = [
        largest_difference(&position, &inputs["position"]),
        largest_difference(&action, &inputs["action_logits"]),
    ];
    assert!(differences.iter().all(|&difference| difference < 1e-4), "{differences:?}");
}

#[test]
fn parity_derives_the_sizes_and_finds_no_difference() {
    let (weights, io) = (data("fusion_weights.safetensors"), data("fusion_io.safetensors"));
    let parity = parity::compare(&weights, &io).unwrap();
    assert_eq!(parity.config, REFERENCE);
    assert!(parity.position < 1e-4 && parity.action < 1e-4, "{parity:?}");
    let error = parity::compare(&weights, &weights).unwrap_err().to_string();
    assert!(error.contains("no tensor 'mask' with 2 axes"), "{error}");
}

#[test]
fn history_padding_does_not_matter() {
    let (variables, network) = network(REFERENCE);
    weights::load(&variables, &data("fusion_weights.safetensors")).unwrap();
    let inputs = inputs();
    let state = &inputs["state"];
    let forward = |history: &History| network.infer(state, history, Precision::Single).position;
    let moves = history(&inputs);
    let padding: Tensor = 1.0 - &moves.mask;
    let other = History {
        action: &moves.action + padding.to_kind(Kind::Int64) * (5 - &moves.action),
        before: &moves.before + &padding,
        after: &moves.after - &padding,
        ..history(&inputs)
    };
    assert_eq!(forward(&moves), forward(&other));
}

#[test]
fn history_has_no_effect_before_training() {
    let (_variables, network) = network(REFERENCE);
    let inputs = inputs();
    let forward =
        |history: &History| network.infer(&inputs["state"], history, Precision::Single).action;
    let none = History { mask: inputs["mask"].zeros_like(), ..history(&inputs) };
    assert_eq!(forward(&history(&inputs)), forward(&none));
}

#[test]
fn parameters_of_an_ablated_part_have_no_effect() {
    let inputs = inputs();
    let has_effect = |ablation, part: &str| {
        let (variables, network) = network(Config { ablation, ..REFERENCE });
        weights::load(&variables, &data("fusion_weights.safetensors")).unwrap();
        let forward =
            || network.infer(&inputs["state"], &history(&inputs), Precision::Single).position;
        let before = forward();
        for (name, mut variable) in variables.variables() {
            if name.starts_with(part) {
                tch::no_grad(|| _ = variable.fill_(0.25));
            }
        }
        before != forward()
    };
    for (part, ablation) in
        [("history_encoder", Ablation::History), ("bottleneck_attn", Ablation::Attention)]
    {
        assert!(has_effect(Ablation::None, part) && !has_effect(ablation, part), "{part}");
    }
}

#[test]
fn all_parameters_are_trained() {
    let (variables, network) = network(REFERENCE);
    let inputs = inputs();
    // Perturb the initial parameters, with which the history has no effect.
    tch::no_grad(|| {
        variables.trainable_variables().iter_mut().for_each(|p| *p += 0.05 * p.randn_like());
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
#[should_panic(expected = "12 channels cannot form 8 equal groups")]
fn widths_that_norms_cannot_divide_are_refused() {
    network(Config { width: 24, ..REFERENCE });
}

#[test]
#[should_panic(expected = "canvas is 40: expected a positive multiple of 16")]
fn a_canvas_that_is_not_a_multiple_of_16_is_refused() {
    network(Config { canvas: 40, ..REFERENCE });
}

#[test]
#[should_panic(expected = "image has shape [3, 9, 24, 32]")]
fn an_image_that_is_not_a_multiple_of_16_is_refused() {
    let inputs = inputs();
    network(REFERENCE).1.forward(
        &inputs["state"].slice(2, 0, 24, 1),
        &history(&inputs),
        Precision::Single,
        false,
    );
}

#[test]
fn wrong_weights_are_refused_and_change_nothing() {
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
