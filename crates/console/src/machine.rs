//! The machine that a measurement ran on.

use std::fs;
use std::process::Command;

use serde_json::{Value, json};

/// Processor, cores, operating system, version and commit, recorded with measured figures.
pub fn facts() -> Value {
    json!({
        "processor": processor(),
        "cores": std::thread::available_parallelism().map_or(0, usize::from),
        "system": std::env::consts::OS,
        "version": env!("CARGO_PKG_VERSION"),
        "commit": commit(),
    })
}

/// The facts of this machine on one line.
pub fn line() -> String {
    one_line(&facts())
}

/// Formats the facts of a machine, possibly recorded by an earlier run, on one line.
pub fn one_line(facts: &Value) -> String {
    let text = |key: &str| facts[key].as_str().unwrap_or("unknown").to_owned();
    format!(
        "{}, {} cores, {}, commit {}",
        text("processor"),
        facts["cores"],
        text("system"),
        text("commit")
    )
}

/// Peak memory of this process so far, in bytes; `None` where the system does not report it.
pub fn peak_memory_bytes() -> Option<u64> {
    status_bytes("VmHWM:")
}

/// Current memory of this process, in bytes; `None` where the system does not report it.
pub fn memory_bytes() -> Option<u64> {
    status_bytes("VmRSS:")
}

/// Resets the peak that [`peak_memory_bytes`] returns, where the system supports it.
pub fn reset_peak_memory() {
    // Where this fails, later peaks are reported only if they exceed all earlier ones.
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
        // The repository of the sources, not that of the current directory.
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
