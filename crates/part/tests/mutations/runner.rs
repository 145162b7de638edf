//! Runs the cases of seeds, with a limit on time and memory.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::seed::Seed;
use crate::steps;

/// Number of cases without `BEADWORK_MUTATIONS`.
const CASES: u64 = 4_000;
/// Time after which a case counts as a hang.
const HANG: Duration = Duration::from_secs(20);
/// Maximum peak memory of the process in KiB.
const MAX_KIB: u64 = 1 << 20;
/// Number of tests that share the cases.
const TESTS: u64 = 5;

/// Ends the process if a case takes too long.
struct Watchdog(Arc<Mutex<Option<(String, Instant)>>>);

impl Watchdog {
    fn new() -> Self {
        let current: Arc<Mutex<Option<(String, Instant)>>> = Arc::default();
        let watched = Arc::downgrade(&current);
        std::thread::spawn(move || {
            while let Some(current) = watched.upgrade() {
                if let Some((case, begun)) = &*current.lock().unwrap()
                    && begun.elapsed() > HANG
                {
                    eprintln!("the case '{case}' hangs");
                    std::process::abort();
                }
                drop(current);
                std::thread::sleep(Duration::from_millis(200));
            }
        });
        Self(current)
    }

    fn set(&self, case: Option<String>) {
        *self.0.lock().unwrap() = case.map(|case| (case, Instant::now()));
    }
}

pub(crate) fn run(title: &str, seeds: &[Seed]) {
    let watchdog = Watchdog::new();
    let case = |seed: &Seed, number: u64| {
        let name = format!("{} {number}", seed.name);
        watchdog.set(Some(name.clone()));
        let begun = Instant::now();
        let Ok(whole) = catch_unwind(AssertUnwindSafe(|| steps::run(seed, number))) else {
            panic!("the case '{name}' fails");
        };
        watchdog.set(None);
        (begun.elapsed(), name, whole)
    };
    if let Ok(wanted) = std::env::var("BEADWORK_MUTATION_CASE") {
        let (name, number) = wanted.rsplit_once(' ').unwrap();
        if let Some(seed) = seeds.iter().find(|seed| seed.name == name) {
            let (time, ..) = case(seed, number.parse().unwrap());
            eprintln!("{title}: the case '{wanted}' passes, {time:.1?}");
        }
        return;
    }
    let all = std::env::var("BEADWORK_MUTATIONS").map_or(CASES, |count| count.parse().unwrap());
    let weights: f64 = seeds.iter().map(Seed::weight).sum();
    let begun = Instant::now();
    let (mut count, mut whole) = (0, 0);
    let mut slowest = (Duration::ZERO, String::new());
    for seed in seeds {
        let share = (all as f64 / TESTS as f64 * seed.weight() / weights).ceil() as u64;
        for number in 0..share {
            let (time, name, is_whole) = case(seed, number);
            slowest = slowest.max((time, name));
            whole += u64::from(is_whole);
        }
        count += share;
    }
    let peak = peak_kib();
    let (longest, name) = slowest;
    eprintln!(
        "{title}: {count} cases in {:.1?}, {whole} of them through all steps; \
         '{name}' took {longest:.1?}; peak {} MiB",
        begun.elapsed(),
        peak.unwrap_or(0) >> 10
    );
    assert!(peak.is_none_or(|kib| kib < MAX_KIB), "{peak:?} KiB");
}

/// Peak memory of the process in KiB, on systems that report it.
fn peak_kib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_ascii_whitespace().next()?.parse().ok()
}
