//! CSV tables of a training run, which a resumed run continues.

use std::fmt::Display;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;

/// A table whose first column is the number of steps completed.
///
/// A line is in the file when `write` returns, so a table is never behind a checkpoint.
pub(super) struct Table {
    path: PathBuf,
    out: BufWriter<File>,
}

impl Table {
    /// Opens a table to append to, or a new one with its header.
    pub(super) fn open(path: PathBuf, header: &str, resume: bool) -> anyhow::Result<Self> {
        let open = || -> std::io::Result<File> {
            if !(resume && path.exists()) {
                fs::write(&path, header)?;
            }
            append(&path)
        };
        let out = open().with_context(|| format!("cannot write '{}'", path.display()))?;
        Ok(Self { out: BufWriter::new(out), path })
    }

    /// Writes a line.
    pub(super) fn write(&mut self, line: impl Display) -> std::io::Result<()> {
        writeln!(self.out, "{line}")?;
        self.out.flush()
    }

    /// Removes a partial last line and the lines of all steps after `steps`, which the resumed run
    /// repeats.
    pub(super) fn forget_after(&mut self, steps: u64) -> anyhow::Result<()> {
        let text = fs::read_to_string(&self.path)?;
        let made = |line: &&str| {
            line.split(',')
                .next()
                .and_then(|step| step.parse().ok())
                .is_none_or(|step: u64| step <= steps)
        };
        let text = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let kept: String = text.split_inclusive('\n').filter(made).collect();
        beadwork_dataset::write_atomic(&self.path, |out| out.write_all(kept.as_bytes()))?;
        self.out = BufWriter::new(append(&self.path)?);
        Ok(())
    }
}

fn append(path: &Path) -> std::io::Result<File> {
    OpenOptions::new().append(true).open(path)
}
