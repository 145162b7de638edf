//! Times of searches, in files beside the shards.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::file::{FileError, write_atomic};

/// Reads how many milliseconds each search of a shard took, in the order of its records.
/// `None` if the file of times is missing or malformed.
pub fn search_times(shard: &Path) -> Option<Vec<f64>> {
    let text = fs::read_to_string(times_file(shard)).ok()?;
    text.lines().skip(1).map(|line| line.split_once(',')?.1.parse().ok()).collect()
}

/// Writes the times of the trajectories `first`, `first + 1`, and so on.
pub(super) fn write_search_times(
    shard: &Path,
    first: u64,
    milliseconds: &[f64],
) -> Result<(), FileError> {
    write_atomic(&times_file(shard), |out| {
        writeln!(out, "trajectory,milliseconds")?;
        for (index, milliseconds) in (first..).zip(milliseconds) {
            writeln!(out, "{index},{milliseconds:.3}")?;
        }
        Ok(())
    })
}

fn times_file(shard: &Path) -> PathBuf {
    shard.with_extension("ms.csv")
}
