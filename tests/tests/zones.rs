//! `zones` on layouts and pictures, and `gen-data` on a folder of pictures.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use beadwork_tests::{beadwork, fail, misused, run, text};
use serde_json::Value;
use tempfile::tempdir;

/// A disc of two colours with a hole, its corners transparent.
fn disc(side: u32) -> Vec<u8> {
    let centre = f64::from(side) / 2.0;
    let pixel = |cell: u32| {
        let (x, y) = (f64::from(cell % side) + 0.5 - centre, f64::from(cell / side) + 0.5 - centre);
        let radius = x.hypot(y);
        let alpha = if radius < centre && radius > centre / 4.0 { 255 } else { 0 };
        if x + y < 0.0 { [200, 30, 30, alpha] } else { [30, 30, 200, alpha] }
    };
    (0..side * side).flat_map(pixel).collect()
}

fn write_png(path: &Path, side: u32, rgba: &[u8]) {
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), side, side);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(rgba).unwrap();
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&run(arguments)).unwrap()
}

#[test]
fn annealing_beats_the_zigzag() {
    let zigzag =
        json(&["zones", "--layout", "stripes", "--size", "30x30", "--method", "zigzag", "--json"]);
    assert_eq!(
        (&zigzag["initial"], &zigzag["crossings"], &zigzag["moves"]),
        (&60.into(), &60.into(), &0.into())
    );
    for preset in ["paper", "fast"] {
        let row = json(&[
            "zones", "--layout", "stripes", "--size", "30x30", "--preset", preset, "--json",
        ]);
        let keys =
            ["layout", "width", "height", "zones", "seed", "method", "piece_bound", "seconds"];
        assert!(keys.iter().all(|key| !row[key].is_null()), "{row}");
        assert_eq!(
            (&row["initial"], &row["bound"], &row["pieces"]),
            (&60.into(), &2.into(), &1.into())
        );
        assert!(row["crossings"].as_u64().unwrap() < 45, "{row}");
    }
}

#[test]
fn minimum_of_crossings_is_proven() {
    let row = json(&["zones", "--layout", "stripes", "--size", "30x30", "--json"]);
    let expected: [(&str, Value); 4] = [
        ("method", "exact".into()),
        ("crossings", 2.into()),
        ("bound", 2.into()),
        ("optimal", true.into()),
    ];
    for (key, value) in expected {
        assert_eq!(row[key], value, "{row}");
    }
    let output =
        run(&["zones", "--layout", "islands", "--size", "40x40", "--shape", "disc", "--seed", "2"]);
    assert!(output.contains("proven minimum"), "{output}");
    let folder = tempdir().unwrap();
    let stages = folder.path().join("stages.svg");
    run(&["zones", "--size", "16x12", "--stages", text(&stages)]);
    let drawing = fs::read_to_string(&stages).unwrap();
    assert!(
        ["ladders", "cheapest 2-matching", "the path"].iter().all(|step| drawing.contains(step))
    );
    let limited = json(&["zones", "--size", "60x60", "--zones", "40", "--time", "0", "--json"]);
    assert_eq!((&limited["attempts"], &limited["pieces"]), (&1.into(), &1.into()), "{limited}");
}

#[test]
fn ends_and_costs_are_respected() {
    let folder = tempdir().unwrap();
    let costs = folder.path().join("purge.csv");
    fs::write(&costs, "0, 5, 2\n3, 0, 2\n\n1 1 0\n").unwrap();
    let layer = ["zones", "--size", "20x20", "--json", "--costs", text(&costs)];
    let row = json(&[&layer[..], &["--start-at", "0,0", "--end-at", "right"]].concat());
    assert!(
        row["cost"].as_u64() >= row["bound"].as_u64()
            && row["cost"].as_u64() >= row["crossings"].as_u64()
    );
    assert!(fail(&["zones", "--size", "9x9", "--start-at", "9,0"]).contains("9,0"));
    assert!(
        fail(&["zones", "--size", "9x9", "--start-at", "3,3", "--end-at", "3,3"])
            .contains("start and end are both")
    );
    for (content, message) in [
        ("0 1", "row 1 has 2"),
        ("0 x\n1 0", "'x' in row 1"),
        ("0 1\n1 0", "3"),
        ("1", "row 0, column 0"),
    ] {
        fs::write(&costs, content).unwrap();
        let error = fail(&layer);
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn picture_is_planned_and_drawn() {
    let folder = tempdir().unwrap();
    let (picture, drawing) = (folder.path().join("disc.png"), folder.path().join("disc.svg"));
    write_png(&picture, 24, &disc(24));
    let row = json(&[
        "zones",
        "--image",
        text(&picture),
        "--preset",
        "fast",
        "--svg",
        text(&drawing),
        "--json",
    ]);
    assert_eq!((&row["layout"], &row["zones"]), (&"disc".into(), &2.into()));
    assert!(row["crossings"].as_u64() <= row["initial"].as_u64());
    assert!(row["pieces"].as_u64() >= row["piece_bound"].as_u64());
    let svg = fs::read_to_string(&drawing).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
}

#[test]
fn folder_of_pictures_becomes_a_dataset() {
    let folder = tempdir().unwrap();
    let (pictures, out) = (folder.path().join("in"), folder.path().join("out"));
    fs::create_dir(&pictures).unwrap();
    for side in [12, 20] {
        write_png(&pictures.join(format!("disc-{side}.png")), side, &disc(side));
    }
    fs::write(pictures.join("notes.txt"), "not a picture").unwrap();
    let make = [
        "gen-data",
        "--preset",
        "pictures",
        "--pictures",
        text(&pictures),
        "--count",
        "12",
        "--out",
        text(&out),
    ];
    run(&make);
    let shown = json(&["inspect", text(&out), "--verify", "--records", "1", "--json"]);
    assert_eq!((&shown["records"], &shown["strata"]["disc-20/fast"]), (&12.into(), &2.into()));
    assert_eq!(shown["config"]["pictures"][0]["name"], "disc-12");

    // Another picture under the same name makes another dataset.
    write_png(
        &pictures.join("disc-20.png"),
        20,
        &disc(20).iter().rev().copied().collect::<Vec<_>>(),
    );
    assert!(fail(&make).contains("another configuration"));
    fs::write(pictures.join("broken.png"), "text").unwrap();
    assert!(fail(&make).contains("picture 'broken.png'"));
    assert!(
        fail(&["gen-data", "--preset", "pictures", "--pictures", text(&out)])
            .contains("no PNG pictures")
    );
}

#[test]
fn bad_pictures_are_reported() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("bad.png");
    let message = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let error = fail(&["zones", "--image", text(&path)]);
        assert!(error.contains("bad.png"), "{error}");
        error
    };
    message(b"GIF89a, not a PNG");
    message(b"");
    let picture = |side: u32, rgba: &[u8]| {
        let file = folder.path().join("good.png");
        write_png(&file, side, rgba);
        fs::read(file).unwrap()
    };
    let whole = picture(20, &disc(20));
    message(&whole[..whole.len() / 2]);
    assert!(message(&picture(2, &[0; 16])).contains("no cells"));
    let colours: Vec<u8> = (0..256_u32).flat_map(|i| [i as u8, 1, 2, 255]).collect();
    assert!(message(&picture(16, &colours)).contains("255"));
    assert!(message(&picture(4097, &vec![255; 4097 * 4097 * 4])).contains("4096"));
    assert!(
        fail(&["zones", "--image", text(&folder.path().join("none.png"))]).contains("none.png")
    );
}

#[test]
fn impossible_requests_are_refused() {
    assert!(fail(&["zones", "--layout", "left_right", "--zones", "3"]).contains("3 zones"));
    assert!(fail(&["zones", "--layout", "islands", "--size", "9x9"]).contains("no room"));
    let folder = tempdir().unwrap();
    let picture = folder.path().join("disc.png");
    write_png(&picture, 24, &disc(24));
    assert!(
        fail(&["zones", "--image", text(&picture), "--start", "row_zigzag"])
            .contains("row_zigzag start jumps")
    );
}

#[test]
fn invalid_arguments_are_reported() {
    let messages: [(&[&str], &str); 14] = [
        (&["zones", "--size", "0x3"], "0x3"),
        (&["zones", "--layout", "spots"], "'spots'"),
        (&["zones", "--image", "x.png", "--size", "3x3"], "--size"),
        (&["zones", "--method", "magic"], "magic"),
        (&["zones", "--method", "anneal", "--end-at", "left"], "--end-at is for --method exact"),
        (&["zones", "--preset", "window"], "with --method genetic it is a preset"),
        (&["zones", "--method", "anneal", "--attempts", "9"], "--attempts is for --method exact"),
        (&["zones", "--method", "zigzag", "--costs", "none.csv"], "--costs is for --method exact"),
        (&["zones", "--method", "genetic", "--preset", "long"], "unknown genetic preset 'long'"),
        (&["zones", "--plot", "x.svg"], "--plot is for --method genetic"),
        (&["zones", "--budget", "10"], "--budget is for --method fusion"),
        (&["zones", "--method", "anneal", "--model", "none"], "--model is for --method fusion"),
        (
            &["eval", "zones", "--method", "exact", "--threads", "2"],
            "--threads has no effect on --method exact",
        ),
        (&["eval", "zones", "--presets", "fast"], "--presets has no effect on eval zones"),
    ];
    for (arguments, message) in messages {
        let error = misused(arguments);
        assert!(error.contains(message), "{arguments:?}: {error}");
    }
}

#[test]
fn genetic_algorithm_reports_its_generations() {
    let folder = tempdir().unwrap();
    let plot = folder.path().join("generations.svg");
    let arguments = [
        "zones", "--layout", "islands", "--size", "30x30", "--method", "genetic", "--preset",
        "short", "--json",
    ];
    let row = json(&[&arguments[..], &["--threads", "2", "--plot", text(&plot)]].concat());
    let history = row["history"].as_array().unwrap();
    assert_eq!((row["method"].as_str(), history.len()), (Some("genetic"), 61));
    assert_eq!(row["seeded"], history[0]["best"]);
    assert_eq!(row["crossings"], history[60]["best"]);
    assert!(row["crossings"].as_u64() < row["seeded"].as_u64(), "{row}");
    assert!(fs::read_to_string(&plot).unwrap().contains("diversity"));

    let again = json(&[&arguments[..], &["--threads", "1"]].concat());
    assert_eq!((&again["history"], &again["moves"]), (&row["history"], &row["moves"]));
    let output = run(&arguments[..arguments.len() - 1]);
    assert!(output.contains("after 60 generations"), "{output}");
}

#[test]
fn closed_pipe_is_not_an_error() {
    let mut child = beadwork()
        .args(["zones", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn table_of_proofs_is_printed() {
    let folder = tempdir().unwrap();
    let plot = folder.path().join("growth.svg");
    let json = json(&[
        "eval",
        "zones",
        "--method",
        "exact",
        "--seeds",
        "1",
        "--smoke",
        "--plot",
        text(&plot),
        "--json",
    ]);
    let cases = json["cases"].as_array().unwrap();
    assert!(cases.len() >= 40 && cases.iter().all(|case| case["pieces_met"].is_u64()), "{json}");
    assert!(fs::read_to_string(&plot).unwrap().starts_with("<svg"));
}

#[test]
fn tables_have_all_cells() {
    let table =
        run(&["eval", "zones", "--method", "anneal", "--seeds", "1", "--presets", "paper,short"]);
    for word in ["Table 5", "Table 3", "30x100", "left_right", "voronoi"] {
        assert!(table.contains(word), "{word} in {table}");
    }
    let json = json(&["eval", "zones", "--method", "zigzag", "--seeds", "1", "--json"]);
    assert_eq!(json["cells"].as_array().unwrap().len(), 24);
    assert_eq!(json["cells"][0]["mean_percent"], 0.0);
}

#[test]
fn table_of_all_methods_resumes_without_repeating_work() {
    let folder = tempdir().unwrap();
    let evaluation = ["eval", "zones", "--smoke", "--out", text(folder.path())];
    let table = run(&evaluation);
    for word in ["Table 1", "Table 3", "Table 5", "genetic `short`", "30x30", "gaps"] {
        assert!(table.contains(word), "{word} in {table}");
    }
    for name in ["convergence.svg", "heat_map.svg"] {
        assert!(
            fs::read_to_string(folder.path().join(name)).unwrap().starts_with("<svg"),
            "{name}"
        );
    }
    let part = folder.path().join("parts/voronoi-30x30-0.json");
    let made = fs::read(&part).unwrap();
    fs::remove_file(&part).unwrap();
    let again = json(&[&evaluation[..], &["--json"]].concat());
    assert_eq!((&again["kept"], again["cells"].as_array().unwrap().len()), (&3.into(), 4));
    // Methods are rows: the zigzag, six annealers, the genetic algorithm and the exact search.
    assert_eq!(again["rows"].as_array().unwrap().len(), 4 * 9);
    let keys = [
        "layout",
        "width",
        "height",
        "zones",
        "seed",
        "method",
        "initial",
        "crossings",
        "bound",
        "pieces",
        "piece_bound",
        "moves",
        "seconds",
        "instance_seed",
    ];
    let rows = |bytes: &[u8]| -> Vec<Value> {
        let mut part: Value = serde_json::from_slice(bytes).unwrap();
        part["part"].as_array_mut().unwrap().drain(..).collect()
    };
    for (old, new) in rows(&made).iter().zip(rows(&fs::read(&part).unwrap())) {
        assert!(keys.iter().all(|key| !new[key].is_null()), "{new}");
        for key in ["method", "preset", "crossings", "moves", "history"] {
            assert_eq!(old[key], new[key], "the same seeds give the same searches");
        }
    }
    for other in [["--seeds", "2"], ["--threads", "7"]] {
        assert!(fail(&[&evaluation[..], &other].concat()).contains("rm -r"));
    }
    fs::write(&part, "{").unwrap();
    assert!(fail(&evaluation).contains("is damaged"));

    // Threads change the times and nothing else.
    let alone = tempdir().unwrap();
    let alone = json(&[
        "eval",
        "zones",
        "--smoke",
        "--threads",
        "1",
        "--json",
        "--out",
        text(alone.path()),
    ]);
    let found = |document: &Value| -> Vec<Value> {
        let rows = document["rows"].as_array().unwrap().iter();
        rows.map(|row| {
            serde_json::json!([row["method"], row["preset"], row["crossings"], row["history"]])
        })
        .collect()
    };
    assert_eq!(found(&alone), found(&again));
}

#[cfg(unix)]
#[test]
fn a_stopped_evaluation_goes_on() {
    let folder = tempdir().unwrap();
    let evaluation = [
        "eval",
        "zones",
        "--method",
        "genetic",
        "--smoke",
        "--seeds",
        "40",
        "--out",
        text(folder.path()),
    ];
    let mut child =
        beadwork().args(evaluation).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let parts = folder.path().join("parts");
    let done =
        || fs::read_dir(&parts).map_or(0, |parts| parts.filter(|part| !is_partial(part)).count());
    while child.try_wait().unwrap().is_none() && done() < 3 {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(
        Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success()
    );
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("the same command resumes"), "{stderr}");
    let made = done();
    assert!((3..160).contains(&made), "{made} parts");

    let document = json(&[&evaluation[..], &["--json"]].concat());
    assert_eq!(done(), 160);
    let cells = document["cells"].as_array().unwrap();
    assert!(cells.iter().all(|cell| cell["runs"].as_array().unwrap().len() == 40));
    assert_eq!(json(&[&evaluation[..], &["--json"]].concat()), document);
}

#[cfg(unix)]
fn is_partial(part: &std::io::Result<fs::DirEntry>) -> bool {
    part.as_ref().is_ok_and(|part| !part.file_name().to_string_lossy().ends_with(".json"))
}

#[test]
fn crossovers_are_compared() {
    let folder = tempdir().unwrap();
    let table =
        run(&["eval", "zones", "--method", "genetic", "--smoke", "--out", text(folder.path())]);
    for word in [
        "one-point: additional",
        "two-point: further",
        "window, mutation: further",
        "| all | all |",
    ] {
        assert!(table.contains(word), "{word} in {table}");
    }
}

#[test]
fn path_is_written_and_part_of_the_document() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("path.csv");
    let arguments = ["zones", "--layout", "stripes", "--size", "9x7", "--json", "--path"];
    let row: Value =
        serde_json::from_str(&run(&[&arguments[..], &[text(&file)]].concat())).unwrap();
    let pieces = row["path"].as_array().unwrap();
    assert_eq!(pieces.len() as u64, row["pieces"].as_u64().unwrap());
    let csv = fs::read_to_string(&file).unwrap();
    assert_eq!(csv.lines().next(), Some("piece,x,y"));
    assert_eq!(csv.lines().count(), 1 + 9 * 7);
    let cells: Vec<String> = pieces
        .iter()
        .enumerate()
        .flat_map(|(number, piece)| {
            let cells = piece.as_array().unwrap();
            cells.iter().map(move |xy| format!("{number},{},{}", xy[0], xy[1]))
        })
        .collect();
    assert_eq!(csv.lines().skip(1).collect::<Vec<_>>(), cells);
}
