//! Parsing an emitted program returns it, and any other text is parsed or refused without a panic.

use beadwork_base::Threads;
use proptest::prelude::*;

use super::*;
use crate::command::VerbatimError;
use crate::program::CommentError;

fn number(text: &str) -> Number {
    text.parse().unwrap()
}

fn read(text: &str) -> Vec<(Option<Command>, Option<String>)> {
    text.parse::<Program>().unwrap().lines.into_iter().map(Line::into_parts).collect()
}

fn command(text: &str) -> Command {
    let mut lines = read(text);
    assert_eq!(lines.len(), 1, "{text:?}");
    lines.remove(0).0.unwrap()
}

#[test]
fn spellings_of_one_move() {
    let expected = Command::Move(LinearMove {
        x: Some(number("1")),
        y: Some(number("-2.5")),
        e: Some(number("0.01")),
        f: Some(number("1800")),
        ..LinearMove::default()
    });
    for text in [
        "G1 X1 Y-2.5 E.01 F1800",
        "G1X1Y-2.5E.01F1800",
        "g01 x1.0 y-2.50 e0.01 f1800\r",
        "N12 G1 X1 Y-2.5 E.01 F1800*71",
        "n3g1x1y-2.5e.01f1800 *5",
        "  G1  F1800\tE 0.01 X7 X+1 Y -2.5 ",
        "(a) G1 X1 (b (c) Y-2.5 E.01F1800(d",
        "\u{feff}G1 X1 Y-2.5 E.01 F1800 S255 P",
        "G 1 X1 Y-2.5 E.01 F1800",
        "N12G 01X1Y-2.5E.01F1800*71",
    ] {
        assert_eq!(command(text), expected, "{text}");
    }
}

#[test]
fn comments_are_kept() {
    let comments = |text| read(text).into_iter().map(|(_, comment)| comment).collect::<Vec<_>>();
    let some = |text: &str| Some(text.to_owned());
    assert_eq!(
        comments("; a;b \r\n;\nG1 X1;TYPE:Skirt\nM84"),
        [some(" a;b "), some(""), some("TYPE:Skirt"), None]
    );
    assert_eq!(
        comments("(one) G1 (two) X1\n(one);two\n(open"),
        [some("one two"), some("two"), some("open")]
    );
    assert_eq!(read("M117 a (b) ;c"), [(Some(Command::other("M117 a (b)").unwrap()), some("c"))]);
    let thumbnail = "; thumbnail begin 16x16 8\n; iVBORw0KGgo=\n; thumbnail end\n";
    assert_eq!(comments(thumbnail).len(), 3);
}

#[test]
fn blank_lines_are_kept() {
    assert_eq!(read("").len(), 0);
    assert_eq!(read("\n").len(), 1);
    assert_eq!(read("\r\n \n\nT0").len(), 4);
    assert_eq!(read("N5*3\n").len(), 1);
}

#[test]
fn typed_and_verbatim_commands() {
    let hot = |tool, wait| Command::NozzleTemperature { celsius: number("215"), tool, wait };
    for (text, expected) in [
        ("G4 P500", Command::Dwell { seconds: None, milliseconds: Some(number("500")) }),
        ("G28", Command::Home { x: false, y: false, z: false }),
        ("G28 W X0 Y", Command::Home { x: true, y: true, z: false }),
        ("G92 E0 A1", Command::SetPosition { x: None, y: None, z: None, e: Some(Number::ZERO) }),
        ("G92", Command::SetPosition { x: None, y: None, z: None, e: None }),
        ("G10", Command::Retract),
        ("G11", Command::Unretract),
        ("T007", Command::Tool(7)),
        ("M104 S215", hot(None, Wait::No)),
        ("M109 T1 S215", hot(Some(1), Wait::Heating)),
        ("m109 r215 T2", hot(Some(2), Wait::HeatingOrCooling)),
        ("M190 S60", Command::BedTemperature { celsius: number("60"), wait: true }),
        ("M106", Command::Fan(Some(number("255")))),
        ("M106 S127.5", Command::Fan(Some(number("127.5")))),
        ("M107", Command::Fan(None)),
        (
            "M204 S800",
            Command::Acceleration {
                print: None,
                travel: None,
                retract: None,
                all: Some(number("800")),
            },
        ),
        (
            "M204 P800 R1500 T1000",
            Command::Acceleration {
                print: Some(number("800")),
                travel: Some(number("1000")),
                retract: Some(number("1500")),
                all: None,
            },
        ),
        (
            "set_velocity_limit accel=900",
            Command::VelocityLimit {
                velocity: None,
                acceleration: Some(number("900")),
                square_corner: None,
            },
        ),
        (
            "M73 P5 R12",
            Command::Progress { percent: Some(number("5")), minutes: Some(number("12")) },
        ),
    ] {
        assert_eq!(command(text), expected, "{text}");
    }
    for text in [
        "G10 P1 S200",
        "G92.1",
        "M109 S200 R200",
        "M104 R200",
        "M109 T1",
        "M106 P2 S255",
        "M104",
        "M104 S200 T256",
        "T255",
        "T256",
        "set_velocity_limit accel=900 ACCEL_TO_DECEL=x",
        "T0 X",
        "T0_PREPARE",
        "G90 G21 M83",
        "G1 X1 G91",
        "G1 X1 A7",
        "G2 X1 I1 P2",
        "G92 E0 G91",
        "X5 E1",
        "T1 S1 L0 D0",
    ] {
        assert_eq!(command(text), Command::other(text).unwrap(), "{text}");
    }
}

#[test]
fn broken_numbers_are_named_with_their_line() {
    let error = |text: &str| text.parse::<Program>().unwrap_err().to_string();
    assert_eq!(error("G28\n;\nG1 X1 Y1.2.3 Z1"), "line 3: 'Y1.2.3' is not a number");
    assert_eq!(error("G1 X Y2"), "line 1: 'X Y2' is not a number");
    assert_eq!(error("G1 X99999999999999999999"), "line 1: 'X99999999999999999999' is too large");
    assert_eq!(error("G1 X1e-5"), "line 1: 'X1e-5' is not a number");
    assert_eq!(error("G1 X1 E4.9e-1"), "line 1: 'E4.9e-1' is not a number");
    assert_eq!(error("M104 S{first}"), "line 1: 'S{first}' is not a number");
    assert_eq!(error("G1 X1 =2"), "line 1: '=2' is not a word of a command");
    assert_eq!(error("SET_VELOCITY_LIMIT ACCEL=fast"), "line 1: 'ACCEL=fast' is not a number");
    assert!(error(&format!("G1 X{}", "-".repeat(1000))).len() < 80);
}

#[test]
fn verbatim_commands_are_checked() {
    for text in [
        "M117 Hello (world)",
        "START_PRINT BED=80",
        "M106 P1 S255",
        "G29.1",
        "T?",
        "T1000",
        "é",
        "M204 X5",
        "T255",
        "SET_VELOCITY_LIMIT ACCEL=5 MINIMUM_CRUISE_RATIO=0.5",
    ] {
        assert_eq!(Verbatim::new(text).unwrap().as_str(), text);
    }
    for text in [
        "", " ", " M117", "M117 ", "M84;off", "M84\n", "G1 X1", "g1x1", "N5 M84", "(M84)", "G1 Xa",
        "M84\r",
    ] {
        assert_eq!(Verbatim::new(text), Err(VerbatimError(text.to_owned())), "{text}");
    }
}

#[test]
fn a_cancelled_call_returns_an_error() {
    let cancel = beadwork_base::CancelToken::new();
    let seen = std::sync::Mutex::new(Vec::new());
    let progress = |progress| {
        seen.lock().unwrap().push(progress);
        cancel.cancel();
    };
    let control =
        Control { cancel: Some(&cancel), progress: Some(&progress), ..Control::default() };
    let text = "G1 X1\n".repeat(100_000);
    let error = Program::parse(&text, &control);
    assert_eq!(error, Err(ParseError::Interrupted(Interrupted::Cancelled)));
    let seen = seen.into_inner().unwrap();
    assert!(seen.len() == 1 && seen[0].done < seen[0].total, "{seen:?}");
    assert_eq!(seen[0].total, text.len());
}

#[test]
fn long_texts_are_read_in_blocks_on_all_threads() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let controls = [Threads::One, Threads::Pool(&pool)].map(Control::on);
    for line in ["G1 X1.5 Y-2 ; a comment", "M117 ä", "", "G1 X1\r"] {
        // The last block may end in the middle of a line, or with an empty one.
        for text in [format!("{line}\n").repeat(60_000), "G28\n".repeat(90_001) + line] {
            let [one, pool] = controls.map(|control| Program::parse(&text, &control).unwrap());
            assert_eq!(one, pool);
            let lines: Vec<Line> = text.lines().map(one_line).collect();
            assert_eq!(one.lines, lines);
        }
    }
    for bad in [0, 7, 50_000, 119_999] {
        let mut lines = vec!["G1 X1 Y2"; 120_000];
        lines[bad] = "G1 X1..2";
        lines[119_999] = "G1 Y-";
        for control in controls {
            let error = Program::parse(&lines.join("\n"), &control).unwrap_err();
            assert!(matches!(error, ParseError::Word { line, .. } if line == bad + 1), "{error}");
        }
    }
}

fn one_line(text: &str) -> Line {
    text.parse::<Program>().unwrap().lines.pop().unwrap_or_default()
}

#[test]
fn bytes_that_are_not_utf8_are_replaced() {
    let program =
        Program::from_bytes(b"M117 caf\xe9\nG1 X1 ; \xff\n", &Control::default()).unwrap();
    assert_eq!(program.lines[0].command(), Some(&Command::other("M117 caf\u{fffd}").unwrap()));
    assert_eq!(program.lines[1].comment(), Some(" \u{fffd}"));
}

fn some_number() -> impl Strategy<Value = Number> {
    prop_oneof![
        any::<i64>().prop_map(Number::from_millionths),
        (-300_000_000_i64..300_000_000).prop_map(Number::from_millionths),
        (-300_i32..300).prop_map(Number::whole),
    ]
}

fn word_or_none() -> impl Strategy<Value = Option<Number>> {
    prop::option::of(some_number())
}

fn other() -> impl Strategy<Value = Command> {
    let text = prop_oneof![
        "[A-Z_]{1,8}( [A-Z]{1,4}=[-0-9a-z.{}()]{0,5}){0,3}",
        "[GMTN][0-9]{1,3}[ A-Z0-9.(]{0,12}",
        "[^;\n]{1,16}",
    ];
    text.prop_filter_map("typed, blank or broken", |text| Command::other(&text).ok())
}

fn commands() -> impl Strategy<Value = Command> {
    let w = word_or_none;
    let moves = (any::<bool>(), w(), w(), w(), w(), w())
        .prop_map(|(rapid, x, y, z, e, f)| Command::Move(LinearMove { rapid, x, y, z, e, f }));
    let arcs = (any::<bool>(), [w(), w(), w()], [w(), w(), w()], w(), w()).prop_map(
        |(clockwise, [x, y, z], [i, j, r], e, f)| {
            Command::Arc(Box::new(Arc { clockwise, x, y, z, i, j, r, e, f }))
        },
    );
    let wait = prop::sample::select(vec![Wait::No, Wait::Heating, Wait::HeatingOrCooling]);
    let plain = prop::sample::select(vec![
        Command::AbsolutePositioning,
        Command::RelativePositioning,
        Command::AbsoluteExtrusion,
        Command::RelativeExtrusion,
        Command::Retract,
        Command::Unretract,
        Command::Fan(None),
    ]);
    let dwells =
        (w(), w()).prop_map(|(seconds, milliseconds)| Command::Dwell { seconds, milliseconds });
    let nozzles = (some_number(), prop::option::of(any::<u8>()), wait)
        .prop_map(|(celsius, tool, wait)| Command::NozzleTemperature { celsius, tool, wait });
    let beds = (some_number(), any::<bool>())
        .prop_map(|(celsius, wait)| Command::BedTemperature { celsius, wait });
    let accelerations = [w(), w(), w(), w()].prop_map(|[print, travel, retract, all]| {
        Command::Acceleration { print, travel, retract, all }
    });
    let velocity_limits = [w(), w(), w()].prop_map(|[velocity, acceleration, square_corner]| {
        Command::VelocityLimit { velocity, acceleration, square_corner }
    });
    let jerks = [w(), w(), w(), w(), w()].prop_map(|[x, y, z, e, junction_deviation]| {
        Command::Jerk { x, y, z, e, junction_deviation }
    });
    prop_oneof![
        4 => moves,
        2 => arcs,
        2 => plain,
        1 => dwells,
        1 => any::<[bool; 3]>().prop_map(|[x, y, z]| Command::Home { x, y, z }),
        1 => [w(), w(), w(), w()].prop_map(|[x, y, z, e]| Command::SetPosition { x, y, z, e }),
        1 => (0..u8::MAX).prop_map(Command::Tool),
        1 => nozzles,
        1 => beds,
        1 => some_number().prop_map(|speed| Command::Fan(Some(speed))),
        1 => accelerations,
        1 => velocity_limits,
        1 => jerks,
        1 => (w(), w()).prop_map(|(percent, minutes)| Command::Progress { percent, minutes }),
        4 => other(),
    ]
}

fn comments() -> impl Strategy<Value = String> {
    prop_oneof!["[ -~]{0,20}", "[^\n]{0,8}", "TYPE:[A-Za-z ]{0,9}"]
}

fn programs() -> impl Strategy<Value = Program> {
    let line = (prop::option::of(commands()), prop::option::of(comments()));
    let line = line.prop_filter_map("a carriage return at its end", |(command, comment)| {
        Line::new(command, comment).map_err(|CommentError(_)| ()).ok()
    });
    prop::collection::vec(line, 0..12).prop_map(|lines| Program { lines })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 6_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn parsing_an_emitted_program_returns_it(program in programs()) {
        let text = program.emit();
        prop_assert_eq!(text.parse(), Ok(program.clone()), "{}", text);
        // In a file, a carriage return ends a line, and a zero byte or a format's magic is refused.
        let is_plain = !text.contains(['\0', '\r']);
        match Program::from_bytes(text.as_bytes(), &Control::default()) {
            Err(ParseError::Encoding(_)) => {}
            read if is_plain => prop_assert_eq!(read, Ok(program)),
            _ => {}
        }
    }

    #[test]
    fn damaged_programs_do_not_panic(
        program in programs(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![
            any::<u8>(),
            prop::sample::select(b"GMTNXYZEF0129.-+ ();*=\n\r\t".to_vec()),
        ]), 0..12),
        cut: prop::sample::Index,
        inserts: bool,
    ) {
        let mut bytes = program.emit().into_bytes();
        bytes.push(b'\n');
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            if inserts { bytes.insert(at, byte) } else { bytes[at] = byte }
        }
        bytes.truncate(cut.index(4 * bytes.len()));
        if let Ok(read) = Program::from_bytes(&bytes, &Control::default()) {
            prop_assert!(read.lines.len() <= bytes.len());
            let parts = read.lines.iter().map(|line| {
                let verbatim = match line.command() {
                    Some(Command::Other(text)) => text.as_str().len(),
                    _ => 0,
                };
                verbatim + line.comment().map_or(0, str::len)
            });
            // A byte that is not UTF-8 takes three when replaced.
            prop_assert!(parts.sum::<usize>() <= 3 * bytes.len());
            // A program read from damaged text is emitted and parsed like any other.
            prop_assert_eq!(read.emit().parse(), Ok(read));
        }
    }

    #[test]
    fn any_bytes_are_parsed_or_refused(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        text in "[GMTN0-9XYZ(). *;\n\r-]{0,80}",
    ) {
        for bytes in [&bytes[..], text.as_bytes()] {
            if let Ok(read) = Program::from_bytes(bytes, &Control::default()) {
                prop_assert_eq!(read.emit().parse(), Ok(read));
            }
        }
    }
}
