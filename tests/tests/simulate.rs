//! `simulate` as a user runs it: temperatures, measures, pictures and errors.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::path::Path;

use beadwork_tests::{beadwork, fail, misused, run, text};
use serde_json::Value;

/// A plate of 12 x 8 x 1 mm, cut into 24 x 16 x 4 voxels.
fn plate(folder: &Path) -> String {
    let corner = |at: u32| {
        let side = |bit: u32, mm: u32| if at >> bit & 1 == 1 { mm } else { 0 };
        format!("v {} {} {}\n", side(0, 12), side(1, 8), side(2, 1))
    };
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 2 4 8 6\nf 4 3 7 8\nf 3 1 5 7\n";
    let file = folder.join("plate.obj");
    fs::write(&file, (0..8).map(corner).collect::<String>() + faces).unwrap();
    text(&file).to_owned()
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&run(&[&["simulate", "--json"], arguments].concat())).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

/// The document without the wall-clock time.
fn without_seconds(mut value: Value) -> Value {
    value.as_object_mut().unwrap().remove("seconds").unwrap();
    value
}

#[test]
fn layers_and_reward_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let plate = plate(folder.path());
    let value = json(&[&plate]);
    assert_eq!(value["part"], "plate");
    assert_eq!(value["pattern"], "contour-zigzag-x-0");
    assert_eq!(
        (&value["width"], &value["height"], &value["depth"]),
        (&24.into(), &16.into(), &4.into())
    );
    assert_eq!(value["voxels"], 24 * 16 * 4);
    let layers = value["layers"].as_array().unwrap();
    assert_eq!(layers.len(), 4);
    let mut reward = 0.0;
    for (number_of_layer, layer) in (1..).zip(layers) {
        assert_eq!(layer["layer"], number_of_layer);
        assert_eq!(layer["voxels"], 24 * 16 * number_of_layer);
        let [mean, min, max] = ["mean_c", "min_c", "max_c"].map(|key| number(&layer[key]));
        assert!(
            25.0 < min && min < mean && mean < 110.0 && mean < max && max <= 230.0 + 1e-3,
            "{layer}"
        );
        // 384 voxels of half a millimetre at 30 mm/s, and some travel.
        assert!((6.39..7.0).contains(&number(&layer["print_seconds"])), "{layer}");
        assert!(number(&layer["hot_spots"]) >= 1.0, "the voxel under the nozzle is hot: {layer}");
        let [ground, coldest] = ["ground_mean_c", "ground_min_c"].map(|key| &layer[key]);
        if number_of_layer == 1 {
            assert!(ground.is_null() && coldest.is_null(), "{layer}");
        } else {
            assert!(25.0 < number(coldest) && number(coldest) < number(ground), "{layer}");
            assert!(number(ground) < 110.0, "{layer}");
        }
        reward -= number(&layer["std_c"]);
    }
    assert!((number(&value["reward"]) - reward).abs() < 1e-9);
    assert!(number(&value["seconds"]) > 0.0 && value["end"].is_null());
    let seconds: f64 = layers.iter().map(|layer| number(&layer["print_seconds"])).sum();
    assert!((number(&value["print_seconds"]) - seconds).abs() < 1e-9);

    assert_eq!(without_seconds(json(&[&plate])), without_seconds(value.clone()), "the same again");
    let summary = run(&["simulate", &plate]);
    assert!(
        summary.contains("1536 voxels in 4 layers") && summary.contains("\nreward -"),
        "{summary}"
    );
    assert!(summary.contains("voxels above 105 °C") && !summary.contains("warpage"), "{summary}");
    assert!(value["time_above"].is_null() && value["warpage"].is_null());
}

#[test]
fn patterns_materials_methods_and_process_matter() {
    let folder = tempfile::tempdir().unwrap();
    let plate = plate(folder.path());
    let reward = |more: &[&str]| number(&json(&[&[plate.as_str()], more].concat())["reward"]);
    let usual = reward(&[]);
    let others: [&[&str]; 10] = [
        &["--pattern", "spiral-in-0"],
        &["--pattern", "lines-x-scattered-7-0"],
        &["--material", "pla"],
        &["--method", "naive"],
        &["--nozzle-c", "210"],
        &["--plate-c", "none"],
        &["--ambient-c", "60"],
        &["--convection", "30"],
        &["--print-mm-s", "60"],
        &["--surface-resistance"],
    ];
    for other in others {
        assert!((reward(other) - usual).abs() > 1e-6 * usual.abs(), "{other:?}");
    }
    // All methods follow the same equation.
    let exact = reward(&["--method", "reference"]);
    for method in [&["--method", "naive"][..], &["--accuracy", "standard"], &["--accuracy", "high"]]
    {
        assert!(
            (reward(method) / exact - 1.0).abs() < 0.1,
            "{method:?}: {} {exact}",
            reward(method)
        );
    }
    assert_eq!(json(&[&plate, "--travel-mm-s", "none"])["process"]["travel_mm_s"], Value::Null);

    let end = &json(&[&plate, "--end-seconds", "120"])["end"];
    let last = &json(&[&plate])["layers"][3];
    assert!(
        number(&end["std_c"]) < number(&last["std_c"]) && number(&end["max_c"]) < 90.0,
        "{end}"
    );
}

#[test]
fn measures_and_pictures_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let plate = plate(folder.path());
    let [csv, svg, cuts] = ["heat.csv", "heat.svg", "cuts"].map(|name| folder.path().join(name));
    let sections =
        ["--section", "x=6", "--section", "y=0", "--section", "z=1", "--section-out", text(&cuts)];
    run(&[&["simulate", &plate, "--csv", text(&csv), "--svg", text(&svg)], &sections[..]].concat());

    let csv = fs::read_to_string(csv).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    let header =
        "layer,voxels,mean_c,std_c,min_c,max_c,print_seconds,hot_spots,ground_mean_c,ground_min_c";
    assert_eq!(lines[0], header);
    assert_eq!(lines.len(), 5);
    let layers = json(&[&plate])["layers"].clone();
    for (line, layer) in lines[1..].iter().zip(layers.as_array().unwrap()) {
        for (name, value) in header.split(',').zip(line.split(',')) {
            let output = layer[name].as_f64();
            assert!(value.is_empty() == output.is_none(), "{name}: {value}");
            assert!(
                output.is_none_or(|output| (output - value.parse::<f64>().unwrap()).abs() < 1e-9),
                "{name}"
            );
        }
    }

    let svg = fs::read_to_string(svg).unwrap();
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    assert!(svg.contains("Standard deviation") && svg.contains("layer 4, complete"));
    assert_eq!(svg.matches("data:image/png;base64,").count(), 4);

    // 24 x 4, 24 x 4 and 24 x 16 voxels, and a scale.
    for (name, size) in [("x6", [8.0, 1.0]), ("y0", [12.0, 1.0]), ("z1", [12.0, 8.0])] {
        let drawing = fs::read_to_string(cuts.join(format!("section-{name}.svg"))).unwrap();
        assert!(drawing.starts_with("<svg") && drawing.matches("<image").count() == 1);
        let file = fs::File::open(cuts.join(format!("section-{name}.png"))).unwrap();
        let mut picture = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut pixels = vec![0; picture.output_buffer_size().unwrap()];
        let info = picture.next_frame(&mut pixels).unwrap();
        let [wide, high] = [info.width - 136, info.height.max(28) - 28].map(f64::from);
        assert!((850.0..=900.0).contains(&wide), "{name}: {wide}");
        assert!(
            (high - wide * size[1] / size[0]).abs() < 20.0 || high < 180.0,
            "{name}: {wide} x {high}"
        );
        let colours = pixels.chunks(4).collect::<std::collections::HashSet<_>>();
        assert!(colours.len() > 50, "{name}");
    }
    let single = folder.path().join("cut.PNG");
    run(&["simulate", &plate, "--section", "z=0.1", "--section-out", text(&single)]);
    assert!(fs::read(single).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn sampled_measures_are_reported_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let plate = plate(folder.path());
    let usual = json(&[&plate]);
    let sampled = json(&[&plate, "--time-above", "--warpage"]);
    // Samples cut long steps, which changes results by no more than the error of the method.
    assert!((number(&sampled["reward"]) / number(&usual["reward"]) - 1.0).abs() < 0.01);
    let [seconds, longest, mean] = [
        &sampled["print_seconds"],
        &sampled["time_above"]["longest_s"],
        &sampled["time_above"]["mean_s"],
    ]
    .map(number);
    assert_eq!(sampled["time_above"]["above_c"], sampled["glass_transition_c"]);
    assert!(0.0 < mean && mean < longest && longest < seconds, "{mean} {longest} {seconds}");
    let [lift, curvature] =
        ["corner_lift_mm", "curvature_1_m"].map(|key| number(&sampled["warpage"][key]));
    assert!(0.0 < lift && lift < 1.0 && curvature > 0.0, "{lift} {curvature}");

    let hotter = &json(&[&plate, "--time-above=150"])["time_above"];
    assert!(number(&hotter["above_c"]) > 149.0 && number(&hotter["mean_s"]) < mean, "{hotter}");
    let summary = run(&["simulate", &plate, "--time-above", "--warpage"]);
    assert!(
        summary.contains("above 105 °C: ")
            && summary.contains("for ranking plans, not a prediction")
    );
}

#[test]
fn probes_record_their_history() {
    let folder = tempfile::tempdir().unwrap();
    let plate = plate(folder.path());
    let history = folder.path().join("history.csv");
    let out = ["--probe-out", text(&history)];
    let read = |more: &[&str]| -> (String, Vec<Vec<Option<f64>>>) {
        run(&[&["simulate", &plate], &out[..], more].concat());
        let content = fs::read_to_string(&history).unwrap();
        let (header, rows) = content.split_once('\n').unwrap();
        let row = |row: &str| row.split(',').map(|value| value.parse().ok()).collect();
        (header.to_owned(), rows.lines().map(row).collect())
    };

    // A corner at the bottom, and the centre of the top, which is deposited late.
    let probes = ["--probe", "0,0,0", "--probe", "6,4,1"];
    let (header, rows) = read(&[&probes[..], &["--end-seconds", "10"]].concat());
    assert_eq!(header, "seconds,x0_y0_z0_c,x6_y4_z1_c");
    let seconds: Vec<f64> = rows.iter().map(|row| row[0].unwrap()).collect();
    assert!((36..=39).contains(&rows.len()), "{seconds:?}");
    assert!(
        seconds.iter().zip(1..).take(35).all(|(s, due)| (s - f64::from(due)).abs() < 0.02),
        "{seconds:?}"
    );
    assert!(rows[0][1].is_some() && rows[0][2].is_none());
    let born = rows.iter().position(|row| row[2].is_some()).unwrap();
    assert!(seconds[born] > 19.0 && rows[born..].iter().all(|row| row[2].is_some()));
    // It cools after the print.
    let last: Vec<f64> = rows[rows.len() - 6..].iter().map(|row| row[2].unwrap()).collect();
    assert!(last.windows(2).all(|pair| pair[0] > pair[1]), "{last:?}");

    let (_, often) = read(&[&probes[..2], &["--probe-seconds", "0.25", "--warpage"]].concat());
    assert!((102..=104).contains(&often.len()), "{}", often.len());
}

#[test]
fn probes_need_a_voxel_of_the_part() {
    let folder = tempfile::tempdir().unwrap();
    let history = folder.path().join("history.csv");
    let refused = |probe: &str| {
        let arguments =
            ["simulate", "example:u-shape", "--probe", probe, "--probe-out", text(&history)];
        let error = fail(&arguments);
        assert!(!history.exists(), "{probe}");
        error
    };
    assert!(refused("22,5,1").ends_with("probe 22,5,1: the part has no voxel there"));
    assert!(
        refused("22,-1,1")
            .contains("probe 22,-1,1 lies outside of the part, which is 45 x 25 x 3 mm")
    );

    let misuse = |more: &[&str]| misused(&[&["simulate", "example:u-shape"], more].concat());
    assert!(misuse(&["--probe", "1,2", "--probe-out", "x"]).contains("as in 30,5,1.2"));
    assert!(misuse(&["--probe", "1,2,3"]).contains("--probe-out"));
    assert!(misuse(&["--probe-out", "x"]).contains("--probe"));
    assert!(misuse(&["--probe-seconds", "2"]).contains("--probe"));
    let out = ["--probe", "1,2,3", "--probe-out", "x"];
    assert!(misuse(&[&out[..], &["--probe-seconds", "0"]].concat()).contains("expected 0.001"));
    assert!(misuse(&[&out[..], &["--csv", "x"]].concat()).contains("named for two results"));
    assert!(
        misuse(&["--time-above=warm"]).contains("expected a temperature in °C or glass-transition")
    );
}

#[test]
fn a_planned_program_is_simulated_with_its_part_and_without() {
    let folder = tempfile::tempdir().unwrap();
    let gcode = folder.path().join("logo.gcode");
    let example = "example:logo-plate";
    let plan = run(&["plan", example, "--objective", "tools", "--json", "--out", text(&gcode)]);
    let plan: Value = serde_json::from_str(&plan).unwrap();

    let with_part = json(&[example, "--gcode", text(&gcode)]);
    assert_eq!(with_part["voxels"], plan["cells"]);
    assert_eq!((&with_part["pattern"], &with_part["voxels_left_out"]), (&Value::Null, &0.into()));
    let seconds = [&with_part["print_seconds"], &plan["print_seconds"]].map(number);
    assert!((seconds[0] - seconds[1]).abs() < 1e-6, "{seconds:?}");
    let without = json(&["--gcode", text(&gcode)]);
    assert_eq!(without["part"], "logo");
    assert_eq!(without["layers"], with_part["layers"]);

    // Temperatures come from the program unless flags override them.
    let hot = fs::read_to_string(&gcode)
        .unwrap()
        .replace("M109 S230", "M109 S215")
        .replace("M190 S80", "M190 S60");
    fs::write(&gcode, hot).unwrap();
    let process = &json(&["--gcode", text(&gcode)])["process"];
    assert_eq!((&process["nozzle_c"], &process["plate_c"]), (&215.0.into(), &60.0.into()));
    let process =
        &json(&["--gcode", text(&gcode), "--nozzle-c", "240", "--plate-c", "none"])["process"];
    assert_eq!((&process["nozzle_c"], &process["plate_c"]), (&240.0.into(), &Value::Null));

    // Another part, cells of another size, and half a program.
    let error = fail(&["simulate", "example:u-shape", "--gcode", text(&gcode)]);
    assert!(error.contains("the program leaves out") && error.contains("in layer 9"), "{error}");
    let error = fail(&["simulate", example, "--bead", "0.4", "--gcode", text(&gcode)]);
    assert!(error.ends_with("try --bead 0.5"), "{error}");
    let half = folder.path().join("half.gcode");
    let program = fs::read_to_string(&gcode).unwrap();
    let end = program.match_indices(";LAYER_CHANGE").nth(4).unwrap().0;
    fs::write(&half, &program[..end]).unwrap();
    let error = fail(&["simulate", example, "--gcode", text(&half)]);
    assert!(error.contains("leaves out 38400 of 76800 voxels"), "{error}");
    let arguments = ["simulate", "--json", example, "--gcode", text(&half), "--left-out", "0.5"];
    let output = beadwork().args(arguments).output().unwrap();
    assert!(String::from_utf8_lossy(&output.stderr).contains("leaves out 38400 voxels of 76800"));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&value["voxels"], &value["voxels_left_out"]), (&38_400.into(), &38_400.into()));
    assert_eq!(value["layers"].as_array().unwrap().len(), 4);
}

#[test]
fn bad_input_is_reported_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.svg");
    let refused = |more: &[&str]| {
        let error = fail(&[&["simulate", "example:u-shape", "--svg", text(&out)], more].concat());
        assert!(!out.exists(), "{more:?}");
        error
    };
    assert!(refused(&["--print-mm-s", "0"]).ends_with("print_mm_s is 0: it must be more than 0"));
    assert!(refused(&["--convection", "-1"]).contains("convection_w_m2k is -1"));
    assert!(refused(&["--nozzle-c", "nan"]).contains("extrusion_c is NaN"));
    assert!(
        refused(&["--layer", "0"]).ends_with("the layer height is 0 mm: it must be more than 0")
    );
    assert!(refused(&["--method", "naive", "--print-mm-s", "1"]).contains("maximum stable step"));
    let section = ["--section", "x=46", "--section-out", text(folder.path())];
    assert!(
        refused(&section).ends_with("section x=46 lies outside of the part, which ends at 45 mm")
    );
    assert!(refused(&["--csv", text(folder.path())]).ends_with("is a folder"));

    let file = folder.path().join("part.gcode");
    let program = |content: &[u8]| {
        fs::write(&file, content).unwrap();
        fail(&["simulate", "--gcode", text(&file)])
    };
    assert!(program(b"G1 X1 F600\n").contains("no bead width and layer height"));
    let header = "; extrusion_width = 0.5\n; layer_height = 0.25\n";
    assert!(program(header.as_bytes()).ends_with("contains no G-code command"));
    let home = format!("{header}G28\n");
    assert!(program(home.as_bytes()).ends_with("the program extrudes no bead of a part"));
    assert!(program(format!("{header}G20\n").as_bytes()).contains("line 3: inches"));
    let high = format!("{header}M83\nG1 Z1 F600\nG1 X5 E1\n");
    assert!(program(high.as_bytes()).contains("layer 1 is empty"));
    assert!(
        fail(&["simulate", "--gcode", "/no/such.gcode"]).contains("cannot read '/no/such.gcode'")
    );

    let misuse = |more: &[&str]| misused(&[&["simulate", "example:u-shape"], more].concat());
    assert!(misused(&["simulate"]).contains("PART"));
    assert!(misuse(&["--pattern", "knots"]).contains("unknown pattern 'knots'"));
    assert!(misuse(&["--pattern", "lines-x-scattered-0"]).contains("a stride K from 1 to 4096"));
    assert!(misuse(&["--pattern", "zigzag-x-0", "--gcode", "x"]).contains("cannot be used with"));
    assert!(misuse(&["--print-mm-s", "20", "--gcode", "x"]).contains("cannot be used with"));
    assert!(misuse(&["--left-out", "0.1"]).contains("--gcode"));
    assert!(misuse(&["--left-out", "2", "--gcode", "x"]).contains("from 0 to 1"));
    assert!(misuse(&["--end-seconds", "-1"]).contains("expected 0 to 1,000,000 seconds"));
    assert!(
        misuse(&["--section", "w=1", "--section-out", "x"]).contains("expected an axis and mm")
    );
    assert!(misuse(&["--section", "x=1"]).contains("--section-out"));
    assert!(
        misuse(&["--section", "x=1", "--section-out", "a.gif"]).contains("expected a .png file")
    );
    let two = ["--section", "x=1", "--section", "y=1", "--section-out", "a.png"];
    assert!(misuse(&two).contains("must be a folder"));
    assert!(misuse(&["--csv", "same", "--svg", "same"]).contains("named for two results"));
    assert!(
        misuse(&["--method", "naive", "--accuracy", "high"])
            .contains("--accuracy requires --method fast")
    );
}
