//! `gen-data` and `inspect`: the same bytes in every kind of run, clear errors, no partial files.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use beadwork_tests::{beadwork, binary, dataset, fail, one_error, run, text};
use tempfile::{TempDir, tempdir};

/// About two seconds of work for two threads, in many small shards.
const SLOW: &str = "count = 60\nper_shard = 2\nsizes = ['24x24', '30x30']\n\
    presets = ['fast', 'extra_long']\n\
                    layouts = [{ name = 'voronoi', zones = 5 }, { name = 'islands', side = 5 }]\n";

fn config(folder: &Path, toml: &str) -> String {
    let file = folder.join("config.toml");
    fs::write(&file, toml).unwrap();
    text(&file).to_owned()
}

/// A small finished dataset.
fn smoke() -> TempDir {
    let folder = tempdir().unwrap();
    run(&["gen-data", "--preset", "smoke", "--count", "40", "--out", text(folder.path())]);
    folder
}

#[test]
fn smoke_dataset_is_written_shown_and_verified() {
    let folder = tempdir().unwrap();
    let out = text(folder.path());
    let made: serde_json::Value =
        serde_json::from_str(&run(&["gen-data", "--preset", "smoke", "--out", out, "--json"]))
            .unwrap();
    assert_eq!((&made["made"], &made["complete"]), (&96.into(), &true.into()));
    let shown = run(&["inspect", out, "--verify", "--records", "2"]);
    assert!(
        shown.contains("96 trajectories in 3 shards") && shown.contains("verified: every byte"),
        "{shown}"
    );
    assert!(shown.contains("trajectory 1: ") && !shown.contains("trajectory 2: "), "{shown}");
    let json: serde_json::Value =
        serde_json::from_str(&run(&["inspect", out, "--verify", "--json"])).unwrap();
    assert_eq!((&json["records"], &json["moves"]), (&96.into(), &made["moves"]));
    let shard = run(&[
        "inspect",
        text(&folder.path().join("shard-00001.bws")),
        "--verify",
        "--records",
        "1",
    ]);
    assert!(shard.contains("32 trajectories") && shard.contains("trajectory 32: "), "{shard}");
    assert!(shown.contains("searches took "), "{shown}");
}

#[test]
fn threads_and_shard_ranges_do_not_change_a_byte() {
    let folder = tempdir().unwrap();
    let file = config(folder.path(), &SLOW.replace("count = 60", "count = 15"));
    let make = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        run(&[&["gen-data", "--config", &file, "--out", text(&out)], more].concat());
        out
    };
    let expected = dataset(&make("one", &["--threads", "1"]));
    assert_eq!(expected.len(), 8 + 1);
    assert_eq!(dataset(&make("two", &["--threads", "2"])), expected);
    make("sliced", &["--shard", "2/3"]);
    make("sliced", &["--shard", "3/3"]);
    let error = fail(&["inspect", text(&folder.path().join("sliced"))]);
    assert!(error.contains("holds no finished dataset"), "{error}");
    make("sliced", &["--shard", "1/3"]);
    assert_eq!(dataset(&folder.path().join("sliced")), expected);
}

#[test]
fn ten_kills_and_a_resume_equal_an_uninterrupted_run() {
    let folder = tempdir().unwrap();
    let file = config(folder.path(), SLOW);
    let (unbroken, broken) = (folder.path().join("unbroken"), folder.path().join("broken"));
    run(&["gen-data", "--config", &file, "--out", text(&unbroken)]);

    let mut state = u64::from(std::process::id());
    let mut kills = 0;
    let mut finished = 0;
    while kills < 10 {
        let mut child = beadwork();
        child
            .args(["gen-data", "--config", &file, "--out", text(&broken)])
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        let mut child = child.spawn().unwrap();
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        std::thread::sleep(Duration::from_millis(20 + (state >> 33) % 250));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            kills += 1;
        } else {
            // It was complete before the kill: remove a shard for the next one.
            finished += 1;
            assert!(finished < 10, "the work is too short to be interrupted");
            fs::remove_dir_all(&broken).unwrap();
        }
        child.wait().unwrap();
    }
    run(&["gen-data", "--config", &file, "--out", text(&broken)]);
    assert_eq!(dataset(&broken), dataset(&unbroken));
    run(&["inspect", text(&broken), "--verify"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_cleanly_and_the_run_resumes() {
    let folder = tempdir().unwrap();
    let file = config(folder.path(), SLOW);
    let out = folder.path().join("out");
    let mut command = beadwork();
    command
        .args(["gen-data", "--config", &file, "--out", text(&out)])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // The signal handler is installed before the first shard.
    while child.try_wait().unwrap().is_none() && !out.join("shard-00000.bws").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(
        Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success()
    );
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("the same command resumes the run"), "{stderr}");
    let left = dataset(&out);
    assert!(
        !left.contains_key("manifest.json") && left.keys().all(|name| name.starts_with("shard-")),
        "{:?}",
        left.keys()
    );
    run(&["gen-data", "--config", &file, "--out", text(&out)]);
    run(&["inspect", text(&out), "--verify"]);
}

#[test]
fn damaged_shards_are_reported() {
    let folder = smoke();
    let shard = folder.path().join("shard-00001.bws");
    let whole = fs::read(&shard).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 0x10;
    let mut version = whole.clone();
    version[8] = 9;
    let cases: [(&str, &[u8], &str); 4] = [
        ("truncated", &whole[..whole.len() - 7], "truncated"),
        ("flipped", &flipped, "damaged"),
        ("version", &version, "version"),
        ("foreign", b"some text, not a shard at all, and long enough to be one", "not a shard"),
    ];
    for (case, bytes, word) in cases {
        fs::write(&shard, bytes).unwrap();
        let error = fail(&["inspect", text(&shard), "--verify"]);
        assert!(error.contains("shard-00001.bws") && error.contains(word), "{case}: {error}");
        let error = fail(&["inspect", text(folder.path()), "--verify"]);
        assert!(error.contains("shard-00001.bws"), "{case}: {error}");
        let error =
            fail(&["gen-data", "--preset", "smoke", "--count", "40", "--out", text(folder.path())]);
        assert!(
            error.contains("shard-00001.bws") && error.contains("remove the file"),
            "{case}: {error}"
        );
    }
    fs::remove_file(&shard).unwrap();
    assert!(fail(&["inspect", text(folder.path())]).contains("shard-00001.bws"));
    run(&["gen-data", "--preset", "smoke", "--count", "40", "--out", text(folder.path())]);
    assert_eq!(fs::read(&shard).unwrap(), whole);
}

#[test]
fn missing_or_wrong_manifest_is_reported() {
    let folder = smoke();
    let manifest = folder.path().join("manifest.json");
    let whole = fs::read_to_string(&manifest).unwrap();
    for (change, word) in [
        (whole.replace("\"format_version\": 1", "\"format_version\": 7"), "version 7"),
        ("{".to_owned(), "is not a manifest"),
        (whole.replace("\"records\": 40", "\"records\": 41"), "is inconsistent"),
    ] {
        fs::write(&manifest, change).unwrap();
        let error = fail(&["inspect", text(folder.path())]);
        assert!(error.contains("manifest.json") && error.contains(word), "{error}");
    }
    fs::remove_file(&manifest).unwrap();
    let error = fail(&["inspect", text(folder.path())]);
    assert!(error.contains("manifest.json") && error.contains(text(folder.path())), "{error}");
    assert!(fail(&["inspect", text(&folder.path().join("none"))]).contains("none"));
}

#[test]
fn datasets_are_never_mixed() {
    let folder = smoke();
    let before = dataset(folder.path());
    let error = fail(&[
        "gen-data",
        "--preset",
        "smoke",
        "--count",
        "40",
        "--seed",
        "1",
        "--out",
        text(folder.path()),
    ]);
    assert!(error.contains("another configuration"), "{error}");
    assert_eq!(dataset(folder.path()), before);
}

#[test]
fn folder_that_cannot_be_created_is_reported() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "in the way").unwrap();
    let error = fail(&["gen-data", "--preset", "smoke", "--out", text(&file.join("out"))]);
    assert!(error.contains("file/out"), "{error}");
}

/// A limit on the size of files simulates a full disk: writing fails within a shard.
#[cfg(unix)]
#[test]
fn full_disk_leaves_no_partial_file() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("out");
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec '{}' gen-data --preset smoke --out '{}'",
        text(&binary()),
        text(&out)
    );
    let output = Command::new("sh").args(["-c", &script]).output().unwrap();
    let error = one_error(&output);
    assert!(error.contains("cannot write") && error.contains("shard-"), "{error}");
    assert!(dataset(&out).keys().all(|name| name.starts_with("shard-")), "nothing partial stays");
    run(&["gen-data", "--preset", "smoke", "--out", text(&out)]);
    run(&["inspect", text(&out), "--verify"]);
}

#[test]
fn wrong_configurations_are_refused() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("out");
    for (toml, word) in [
        ("count = 1\ncolour = 'red'", "colour"),
        ("count = 1\npresets = ['paper']", "config.toml': no instances"),
        ("count = 1\ncount = 2", "config.toml': line 2: "),
        (
            "count = 1\npresets = ['paper']\nlayouts = [{ name = 'islands' }]\nsizes = ['5x5']",
            "no room",
        ),
    ] {
        let file = config(folder.path(), toml);
        let error = fail(&["gen-data", "--config", &file, "--out", text(&out)]);
        assert!(error.contains(word), "{error}");
    }
    assert!(
        fail(&["gen-data", "--config", text(&folder.path().join("none.toml"))])
            .contains("none.toml")
    );
    assert!(!out.exists(), "nothing is made of a wrong configuration");
    let wrong_use: [&[&str]; 6] = [
        &["gen-data", "--preset", "smoke", "--pictures", "."],
        &["gen-data"],
        &["gen-data", "--preset", "none"],
        &["gen-data", "--preset", "smoke", "--shard", "3/2"],
        &["gen-data", "--preset", "smoke", "--count", "0"],
        &["fly"],
    ];
    for arguments in wrong_use {
        assert_eq!(
            beadwork().args(arguments).output().unwrap().status.code(),
            Some(2),
            "{arguments:?}"
        );
    }
}

#[test]
fn benchmark_of_the_factory_cleans_up() {
    let folder = tempdir().unwrap();
    let printed =
        run(&["bench", "dataset", "--count", "20", "--scratch", text(folder.path()), "--json"]);
    let facts: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(facts["trajectories"], 20);
    assert!(
        facts["speed_up"].as_f64().unwrap() > 0.0
            && facts["bytes_per_move"].as_f64().unwrap() > 0.0
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn solutions_of_the_genetic_algorithm_are_recorded() {
    let folder = tempdir().unwrap();
    let (config, out) = (folder.path().join("bred.toml"), folder.path().join("bred"));
    let text_of_config = "count = 3\nsource = 'genetic'\nsizes = ['12x10']\npresets = ['short']\n\
                          layouts = [{ name = 'voronoi' }]\n";
    fs::write(&config, text_of_config).unwrap();
    run(&["gen-data", "--config", text(&config), "--out", text(&out)]);
    let shown = run(&["inspect", text(&out), "--verify", "--records", "3"]);
    assert!(shown.contains("genetic_short"), "{shown}");
    fs::write(&config, text_of_config.replace("short", "long")).unwrap();
    assert!(
        fail(&["gen-data", "--config", text(&config)]).contains("unknown genetic preset 'long'")
    );
}
