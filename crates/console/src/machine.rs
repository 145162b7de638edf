//! What a measurement was made on.

use std::fs;
use std::process::Command;

use serde_json::{Value, json};

/// Processor, cores, version and commit, for the record beside measured figures.
pub fn facts() -> Value {
    json!({
        "processor": processor(),
        "cores": std::thread::available_parallelism().map_or(0, usize::from),
        "system": std::env::consts::OS,
        "version": env!("CARGO_PKG_VERSION"),
        "commit": commit(),
    })
}

/// The same on one line.
pub fn line() -> String {
    told(&facts())
}

/// Facts of a machine, perhaps noted earlier, on one line.
pub fn told(facts: &Value) -> String {
    let text = |key: &str| facts[key].as_str().unwrap_or("unknown").to_owned();
    format!(
        "{}, {} cores, {}, commit {}",
        text("processor"),
        facts["cores"],
        text("system"),
        text("commit")
    )
}

/// The number of threads asked for, where 0 stands for one a core.
pub fn threads(asked: usize) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    if asked == 0 { cores() } else { asked }
}

/// Peak memory of this process so far in bytes, where the system tells it.
pub fn peak_memory_bytes() -> Option<u64> {
    status_bytes("VmHWM:")
}

/// Memory of this process now in bytes, where the system tells it.
pub fn memory_bytes() -> Option<u64> {
    status_bytes("VmRSS:")
}

/// Lets the peak begin anew, where the system can do so.
pub fn forget_peak_memory() {
    // Without it a later peak is only counted if it is the highest of all, which the figures then
    // say too little of.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

fn status_bytes(field: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(field))?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib * 1024)
}

fn processor() -> Option<String> {
    let info = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = info.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn commit() -> Option<String> {
    let run = |args: &[&str]| {
        // The sources' repository, not the one that the user happens to be in.
        let git = ["-C", env!("CARGO_MANIFEST_DIR")];
        let output = Command::new("git")
            .args(git)
            .args(args)
            .output()
            .ok()
            .filter(|output| output.status.success())?;
        Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
    };
    let commit = run(&["rev-parse", "--short=12", "HEAD"])?;
    let changed = run(&["status", "--porcelain", "--untracked-files=no"])
        .is_some_and(|list| !list.is_empty());
    Some(if changed { format!("{commit} with changes") } else { commit })
}
