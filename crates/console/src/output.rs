//! Writing results to stdout and to files.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use anyhow::Context;
use beadwork_dataset::write_atomic;
use serde::{Serialize, Serializer};
use serde_json::Value;

/// Writes text to stdout.
///
/// If the pipe is closed, returns an error that [`is_broken_pipe`] recognises; `print!` would
/// panic.
pub fn text(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// Writes one JSON document to stdout.
pub fn json(value: &Value) -> anyhow::Result<()> {
    text(&format!("{value:#}\n"))
}

/// Writes a JSON object to stdout, with an additional last entry whose value stays on one line.
///
/// This suits long arrays, such as paths, which would otherwise take a line for each number.
pub fn json_with(object: &Value, key: &str, value: &Value) -> anyhow::Result<()> {
    let object = format!("{object:#}");
    let entries = object.strip_suffix("\n}").context("the document is not an object")?;
    text(&format!("{entries},\n  \"{key}\": {value}\n}}\n"))
}

/// A number for JSON: an integer if it is whole, and null if it is not finite.
pub fn number(value: f64) -> Value {
    /// Up to this size a float holds every integer.
    const MAX_EXACT: f64 = (1_u64 << 53) as f64;

    if value.fract() == 0.0 && value.abs() <= MAX_EXACT {
        (value as i64).into()
    } else {
        value.into()
    }
}

/// Serializes a field as [`number`] does.
pub fn serialize_number<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    number(*value).serialize(serializer)
}

/// Serializes an optional field as [`number`] does.
#[allow(clippy::ref_option, reason = "the signature that serde calls")]
pub fn serialize_optional_number<S: Serializer>(
    value: &Option<f64>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    value.map(number).serialize(serializer)
}

/// Writes a file completely or not at all.
///
/// A terminal or a pipe is written to rather than replaced.
pub fn file(path: &Path, content: impl AsRef<[u8]>) -> anyhow::Result<()> {
    if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        return fs::write(path, content)
            .with_context(|| format!("cannot write '{}'", path.display()));
    }
    Ok(write_atomic(path, |out| out.write_all(content.as_ref()))?)
}

/// Whether the error only means that the reader of a pipe stopped reading.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<io::Error>();
    io.is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// Ends the process with a usage error (exit code 2), as clap does for invalid arguments.
pub fn usage_error(message: &str) -> ! {
    clap::Error::raw(clap::error::ErrorKind::ArgumentConflict, format!("{message}\n")).exit()
}
