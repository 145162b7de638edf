//! Networks end to end: a dataset, a training that is killed and resumed, walks and tables.

#![cfg(feature = "learn")]
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use beadwork_tests::{beadwork, fail, misused, run, text};
use serde_json::Value;
use tempfile::{TempDir, tempdir};

const CHAINS: &str = "\
count = 80
per_shard = 16
source = 'chains'
sizes = ['14x11', '10x20']
presets = ['plain', 'noisy']
starts = ['row_zigzag']
layouts = [{ name = 'voronoi' }, { name = 'islands', side = 3 }]
";

/// A folder with a dataset of chains, `data`.
fn dataset() -> TempDir {
    let folder = tempdir().unwrap();
    let config = folder.path().join("chains.toml");
    fs::write(&config, CHAINS).unwrap();
    let data = folder.path().join("data");
    run(&["gen-data", "--config", text(&config), "--out", text(&data)]);
    folder
}

fn train<'a>(data: &'a Path, out: &'a Path) -> [&'a str; 8] {
    ["train", "fusion", "--preset", "smoke", "--data", text(data), "--out", text(out)]
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&run(&[arguments, &["--json"]].concat())).unwrap()
}

#[test]
fn network_is_trained_and_walks() {
    let folder = dataset();
    let (data, out) = (folder.path().join("data"), folder.path().join("run"));
    let done = json(&train(&data, &out));
    assert_eq!((&done["end"], &done["steps"]), (&"done".into(), &20.into()), "{done}");
    let mut files: Vec<_> = fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.retain(|name| !name.starts_with("events.out.tfevents."));
    files.sort();
    assert_eq!(
        files,
        [
            "best.safetensors",
            "config.toml",
            "dataset.toml",
            "evaluations.csv",
            "last.checkpoint",
            "steps.csv",
        ]
    );
    let error = fail(&train(&data, &out));
    assert!(error.contains("--resume"), "{error}");
    let again = json(&[&train(&data, &out)[..], &["--resume"]].concat());
    assert_eq!(
        (&again["end"], &again["examples"]),
        (&"done".into(), &0.into()),
        "nothing is left to do"
    );

    let model = out.join("best.safetensors");
    fs::remove_file(out.join("last.checkpoint")).unwrap();
    for resume in [&[][..], &["--resume"]] {
        let before = fs::read(&model).unwrap();
        let error = fail(&[&train(&data, &out)[..], resume].concat());
        assert!(error.contains("would be overwritten"), "{error}");
        assert!(fs::read(&model).unwrap() == before);
    }

    let svg = folder.path().join("walk.svg");
    let words = ["zones", "--layout", "voronoi", "--method", "fusion", "--model", text(&out)];
    let walked = json(&[&words[..], &["--size", "14x11", "--svg", text(&svg)]].concat());
    assert_eq!(walked["method"], "fusion");
    assert!(walked["crossings"].as_u64() <= walked["initial"].as_u64(), "{walked}");
    assert!(walked["moves"].as_u64() <= walked["made"].as_u64(), "{walked}");
    assert_eq!(
        walked["reached"],
        walked["crossings"] == walked["target"],
        "the target is a lower bound"
    );
    assert!(fs::read_to_string(&svg).unwrap().starts_with("<svg"));
    let error = fail(&[&words[..], &["--size", "200x10"]].concat());
    assert!(error.contains("128 x 128") && error.contains("200 x 10"), "{error}");

    let model = text(&out);
    let table =
        ["eval", "fusion", "--model", model, "--sizes", "30x30", "--seeds", "1", "--runs", "2"];
    let output = json(&[&table[..], &["--budget", "40", "--data", text(&data)]].concat());
    assert_eq!(output["rows"].as_array().unwrap().len(), 2, "a seed of two layouts: {output}");
    // Four trajectories of each layout are in the test split; each contributes up to 20 moves.
    assert!(
        (4..=80).contains(&output["held_out"]["islands"]["examples"].as_u64().unwrap()),
        "{output}"
    );
    let error = fail(&["eval", "fusion", "--model", model, "--sizes", "30x30,200x10"]);
    assert!(error.contains("128 x 128") && error.contains("200 x 10"), "{error}");

    let config = folder.path().join("other.toml");
    fs::write(&config, format!("seed = 1\n{CHAINS}")).unwrap();
    let other = folder.path().join("other");
    run(&["gen-data", "--config", text(&config), "--out", text(&other)]);
    let words = [&table[..], &["--budget", "5", "--data", text(&other)]].concat();
    let output = beadwork().args(words).output().unwrap();
    let output = String::from_utf8(output.stderr).unwrap();
    assert!(output.contains("not the one the network was trained on"), "{output}");
}

/// Losses of all steps.
fn losses(out: &Path) -> Vec<String> {
    let steps = fs::read_to_string(out.join("steps.csv")).unwrap();
    steps.lines().map(|line| line.split(',').take(3).collect::<Vec<_>>().join(",")).collect()
}

#[test]
fn killed_training_resumes_with_the_same_losses() {
    let folder = dataset();
    let data = folder.path().join("data");
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    run(&train(&data, &whole));
    // The file has a header and 20 steps; evaluations with checkpoints follow step 10 and the last.
    for (resume, lines) in [(&[][..], 0), (&["--resume"], 4), (&["--resume"], 12)] {
        let mut training = beadwork().args(train(&data, &killed)).args(resume).spawn().unwrap();
        let lines_written =
            || fs::read_to_string(killed.join("steps.csv")).map_or(0, |text| text.lines().count());
        let begun = || killed.join("last.checkpoint").exists();
        while training.try_wait().unwrap().is_none() && !(begun() && lines_written() >= lines) {
            sleep(Duration::from_millis(1));
        }
        training.kill().unwrap();
        training.wait().unwrap();
    }
    run(&[&train(&data, &killed)[..], &["--resume"]].concat());
    assert_eq!(losses(&killed), losses(&whole));
    let weights = |out: &Path| fs::read(out.join("best.safetensors")).unwrap();
    assert!(weights(&killed) == weights(&whole));
}

#[test]
fn missing_models_and_bad_configurations_are_reported() {
    let folder = tempdir().unwrap();
    let nowhere = folder.path().join("nowhere");
    let error =
        fail(&["zones", "--size", "10x10", "--method", "fusion", "--model", text(&nowhere)]);
    assert!(error.contains("nowhere"), "{error}");
    let error = fail(&train(&nowhere, &folder.path().join("run")));
    assert!(error.contains("nowhere"), "{error}");
    assert!(!folder.path().join("run").exists());
    let config = folder.path().join("typo.toml");
    fs::write(&config, "widht = 32").unwrap();
    let error = beadwork().args(["train", "fusion", "--config", text(&config)]).output().unwrap();
    let error = String::from_utf8(error.stderr).unwrap();
    assert!(error.contains("typo.toml") && error.contains("widht"), "{error}");
    misused(&["train", "fusion"]);
    misused(&["train", "fusion", "--preset", "enormous"]);
}

#[test]
fn configurations_of_ablations_differ_only_in_the_omitted_part() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/train");
    let read = |name: &str| -> toml::Table {
        fs::read_to_string(folder.join(name).with_extension("toml")).unwrap().parse().unwrap()
    };
    let small = read("fusion-small");
    let mut full = read("ablations/full");
    assert_eq!(full.insert("steps".into(), small["steps"].clone()), Some(2000.into()));
    assert_eq!(full, small);
    for name in ["without-history", "without-attention", "classification"] {
        let mut other = read(&format!("ablations/{name}"));
        assert_eq!(other.insert("steps".into(), small["steps"].clone()), Some(2000.into()));
        let what = other.remove("ablation").or_else(|| other.remove("loss")).unwrap().to_string();
        assert!(what.contains(name.trim_start_matches("without-")), "{name}: {what}");
        assert_eq!(other, small, "{name}");
    }
}

#[test]
fn policy_is_trained_for_a_part_and_continued() {
    let folder = tempdir().unwrap();
    let config = folder.path().join("ppo.toml");
    let text_of = "steps = 96\nenvironments = 4\nrollout = 8\nevaluate_every = 4\nwindow = 6\n\
                   [network]\nkind = \"fields\"\nvolume = [4]\nimage = [4]\nunits = 8\n";
    fs::write(&config, text_of).unwrap();
    let (config, out) = (text(&config), folder.path().join("run"));
    let part = ["train", "ppo", "example:u-shape", "--scale", "0.25", "--max-time", "1.05"];
    let words = |steps: &'static str| [&part[..], &["--config", config, "--steps", steps]].concat();
    let train = [&words("96")[..], &["--out", text(&out)]].concat();
    let done = json(&train);
    assert_eq!((&done["end"], &done["steps"]), (&"done".into(), &96.into()), "{done}");
    let plan = &done["plan"];
    let layers = plan["orders"].as_array().unwrap().len() as u64;
    assert_eq!(done["episodes"], 4 * (24 / layers), "{done}");
    let (reward, conventional) = (&plan["reward"], done["conventional_reward"].as_f64().unwrap());
    let gain = 100.0 * (reward.as_f64().unwrap() / conventional - 1.0);
    assert!((gain + plan["gain_percent"].as_f64().unwrap()).abs() < 1e-6, "{done}");
    let rows = |name: &str| fs::read_to_string(out.join(name)).unwrap().lines().count() as u64;
    assert_eq!(rows("updates.csv"), 1 + 3);
    assert_eq!(rows("episodes.csv"), 1 + done["episodes"].as_u64().unwrap());
    assert!(rows("evaluations.csv") >= 2);

    // Nothing is left to do, and nothing is overwritten.
    let tables = ["updates.csv", "episodes.csv", "evaluations.csv"].map(|name| out.join(name));
    let before = tables.each_ref().map(|table| fs::read(table).unwrap());
    let again = json(&[&train[..], &["--resume"]].concat());
    assert_eq!(again["plan"], done["plan"]);
    assert!(tables.each_ref().map(|table| fs::read(table).unwrap()) == before);
    let error = fail(&train);
    assert!(error.contains("--resume"), "{error}");
    let error = fail(&[&words("128")[..], &["--out", text(&out), "--resume"]].concat());
    assert!(error.contains("it has 'steps = 96', this run has 'steps = 128'"), "{error}");
    let error = fail(&[&words("8")[..], &["--out", text(&folder.path().join("other"))]].concat());
    assert!(error.contains("steps is 8"), "{error}");
}

#[test]
fn policy_is_trained_on_random_parts_and_plans_a_part() {
    let folder = tempdir().unwrap();
    let config = folder.path().join("ppo.toml");
    let text_of = "steps = 32\nenvironments = 4\nrollout = 8\nevaluation_episodes = 2\n\
                   [network]\nkind = \"fields\"\nvolume = [4]\nimage = [4]\nunits = 8\n";
    fs::write(&config, text_of).unwrap();
    let out = folder.path().join("general");
    let train = ["train", "ppo", "random:grid32", "--config", text(&config), "--out", text(&out)];
    let done = json(&train);
    assert_eq!((&done["end"], &done["part"]), (&"done".into(), &"random:grid32".into()), "{done}");
    assert!(done["gain_percent"].is_number(), "{done}");
    let error = fail(&["train", "ppo", "random:tiny", "--preset", "general"]);
    assert!(error.contains("unknown preset 'tiny'"), "{error}");

    let plan = ["plan", "example:u-shape", "--scale", "0.3", "--objective", "heat"];
    let plan = [&plan[..], &["--planner", "ppo", "--policy", text(&out)]].concat();
    for limit in ["1", "1.02", "1.5"] {
        let heat = json(&[&plan[..], &["--max-time", limit]].concat())["heat"].clone();
        assert_eq!((&heat["planner"], &heat["objective"]), (&"ppo".into(), &"reward=1".into()));
        let seconds = |key: &str| heat[key].as_f64().unwrap();
        let ratio = seconds("print_seconds") / seconds("conventional_print_seconds");
        assert!(ratio <= limit.parse::<f64>().unwrap() + 1e-9, "{heat}");
        assert!(heat["gain_percent"].is_number() && heat["no_travel_gain_percent"].is_number());
    }
    let refined = json(&[&plan[..], &["--refine"]].concat())["heat"].clone();
    let ratio = refined["print_seconds"].as_f64().unwrap()
        / refined["conventional_print_seconds"].as_f64().unwrap();
    assert!(ratio <= 1.02 + 1e-9, "{refined}");
    let error = fail(&[&plan[..], &["--max-time", "0.9"]].concat());
    assert!(error.contains("--max-time cannot be met"), "{error}");
    let error = misused(&[&plan[..], &["--even", "peak"]].concat());
    assert!(error.contains("--even does not go together with --planner ppo"), "{error}");
    let error = fail(&["plan", "example:u-shape", "--objective", "heat", "--planner", "ppo"]);
    assert!(error.contains("no policy in 'models/ppo-small'"), "{error}");
}
