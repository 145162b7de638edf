//! Times computed by hand, and the two passes of the planner compared with a slow search that
//! repairs violated limits one by one.

use beadwork_base::{CancelToken, Interrupted, Progress};
use proptest::prelude::*;

use super::*;

const LIMITS: MotionLimits =
    MotionLimits { acceleration_mm_s2: 1000.0, square_corner_mm_s: 5.0, max_speed_mm_s: 300.0 };

fn seconds(text: &str) -> f64 {
    text.parse::<Program>().unwrap().print_seconds(LIMITS, &Control::default()).unwrap()
}

fn near(text: &str, expected: f64) {
    let got = seconds(text);
    assert!((got - expected).abs() < 1e-9, "{text}: {got}, not {expected}");
}

#[test]
fn single_moves() {
    // Up to 100 mm/s in 0.1 s and 5 mm, 90 mm at that speed, and down again.
    near("G1 X100 F6000", 0.1 + 0.9 + 0.1);
    // Too short to reach it: up to √(1000 · 4) mm/s and down again.
    near("G1 X4 F6000", 2.0 * (4.0_f64 / 1000.0).sqrt());
    near("G1 X1 Y2 Z2 F6000", 2.0 * (3.0_f64 / 1000.0).sqrt());
    near("M204 T250\nG1 X4 F6000", 2.0 * (4.0_f64 / 250.0).sqrt());
    // Limited by the printer's maximum speed: 0.3 s and 45 mm up, and down again.
    near("G1 X1290 F60000", 0.3 + 4.0 + 0.3);
    near("", 0.0);
}

#[test]
fn moves_in_line_take_the_time_of_one() {
    near("G1 X30 F6000\nG1 X100", 1.1);
    near("G1 X30 Y30 F6000\nG1 X31 Y31\nG1 X60 Y60", seconds("G1 X60 Y60 F6000"));
    near("M83\nG1 X30 E1 F6000\nT1\nG1 X100 E2", seconds("G1 X30 F6000") + seconds("G1 X70 F6000"));
}

#[test]
fn a_right_angle_is_passed_at_the_square_corner_speed() {
    // From rest to 100 mm/s in 0.1 s and 5 mm, and down to 5 mm/s in 0.095 s and 4.9875 mm.
    let half = 0.1 + (100.0 - 5.0 - 4.9875) / 100.0 + 0.095;
    near("G1 X100 F6000\nG1 Y100", 2.0 * half);
    near("G1 X100 F6000\nG1 X0", 2.0 * 1.1);
}

#[test]
fn retractions_and_pauses_take_time() {
    near("M83\nG1 E-2 F1200\nG4 P250\nG1 E2 F600", 0.1 + 0.25 + 0.2);
    near("G1 X4 F6000\nG4\nG1 X8", 2.0 * seconds("G1 X4 F6000"));
}

#[test]
fn sharper_corners_are_slower() {
    let mut last = f64::INFINITY;
    for degrees in [0.0_f64, 10.0, 45.0, 90.0, 135.0, 170.0, 180.0] {
        let motion = |direction| PlannedMotion {
            length: 1.0,
            acceleration: 1000.0,
            cruise2: 1e4,
            junction2: 0.0,
            direction,
        };
        let turned = motion([degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0]);
        let junction = motion([1.0, 0.0, 0.0]).junction2_to(&turned, 5.0);
        assert!(junction < last || junction >= 1e4);
        last = junction;
    }
    assert!(last < 1e-9);
}

#[test]
fn a_cancelled_call_returns_an_error() {
    let program: Program = "G1 X1\nG1 X0\n".repeat(5_000).parse().unwrap();
    let cancel = CancelToken::new();
    let progress = |progress: Progress| {
        assert_eq!(progress.total, 10_000);
        if progress.done > 2_000 {
            cancel.cancel();
        }
        assert!(progress.done < 4_000);
    };
    let control =
        Control { cancel: Some(&cancel), progress: Some(&progress), ..Control::default() };
    let error = program.print_seconds(LIMITS, &control);
    assert_eq!(error, Err(TraceError::Interrupted(Interrupted::Cancelled)));
}

/// Lowers one speed after the other to what its neighbours allow, until none changes.
fn slow_speeds2(chain: &[PlannedMotion]) -> Vec<f64> {
    let mut speeds: Vec<f64> = chain.iter().map(|motion| motion.junction2).chain([0.0]).collect();
    loop {
        let mut changed = false;
        for at in 0..speeds.len() {
            let left = (at > 0)
                .then(|| speeds[at - 1] + 2.0 * chain[at - 1].acceleration * chain[at - 1].length);
            let right = chain
                .get(at)
                .map(|motion| speeds[at + 1] + 2.0 * motion.acceleration * motion.length);
            let allowed = left.into_iter().chain(right).fold(speeds[at], f64::min);
            changed |= allowed < speeds[at];
            speeds[at] = allowed;
        }
        if !changed {
            return speeds;
        }
    }
}

/// Time of a motion, integrated in small steps: as fast as the speeds at both ends and the
/// requested speed allow.
fn slow_seconds(motion: &PlannedMotion, begin2: f64, end2: f64) -> f64 {
    const STEPS: u32 = 20_000;
    let step = motion.length / f64::from(STEPS);
    let speed = |at: f64| {
        let up = begin2 + 2.0 * motion.acceleration * at;
        let down = end2 + 2.0 * motion.acceleration * (motion.length - at);
        up.min(down).min(motion.cruise2).sqrt()
    };
    (0..STEPS).map(|at| step / speed((f64::from(at) + 0.5) * step)).sum()
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 500,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn a_bounded_queue_gives_the_same_time(
        moves in prop::collection::vec((-20_i32..20, -20_i32..20, 600_u32..6000), 1..80),
        max_queue in 6_usize..12,
    ) {
        // From any of these speeds the nozzle brakes within a few mm, so later moves cannot change
        // the speeds of those that have left the queue.
        let line = |(x, y, feed): (i32, i32, u32)| {
            format!("G1 X{} Y{y} F{feed}", if x == 0 { 1 } else { x })
        };
        let moves: Vec<String> = moves.into_iter().map(line).collect();
        let program = format!("M204 S3000\nG91\n{}", moves.join("\n")).parse::<Program>().unwrap();
        let mut stopwatch = Stopwatch { max_queue, ..Stopwatch::new(LIMITS) };
        for event in program.trace() {
            stopwatch.add(&event.unwrap());
            prop_assert!(stopwatch.queue.len() < max_queue);
        }
        let bounded = stopwatch.seconds();
        let all = program.print_seconds(LIMITS, &Control::default()).unwrap();
        prop_assert!((bounded - all).abs() <= 1e-9 * all, "{bounded}, not {all}");
    }

    #[test]
    fn two_passes_find_the_maximum_speeds(
        motions in prop::collection::vec(
            (0.01..50.0, 100.0..3000.0, 1.0..200.0_f64, 0.0..1.0_f64),
            1..30,
        ),
    ) {
        let mut before = 0.0_f64;
        let planned = |(length, acceleration, cruise, share): (f64, f64, f64, f64)| {
            let junction = share * cruise.min(before);
            before = cruise;
            let (cruise2, junction2) = (cruise * cruise, junction * junction);
            PlannedMotion { length, acceleration, cruise2, junction2, direction: [1.0, 0.0, 0.0] }
        };
        let chain: Vec<PlannedMotion> = motions.into_iter().map(planned).collect();
        let (fast, slow) = (corner_speeds2(&chain, 0.0), slow_speeds2(&chain));
        for (a, b) in fast.iter().zip(&slow) {
            prop_assert!((a - b).abs() <= 1e-9 * a.max(1.0));
        }
        for (motion, ends) in chain.iter().zip(fast.windows(2)).take(3) {
            let exact = motion.profile(ends[0], ends[1]).seconds();
            let slow = slow_seconds(motion, ends[0], ends[1]);
            prop_assert!((exact - slow).abs() <= 0.01 * exact, "{motion:?}: {exact}, {slow}");
        }
    }
}
