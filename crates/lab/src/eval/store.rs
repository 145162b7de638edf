//! Stores the results of the jobs of a long evaluation in a folder, so that an interrupted
//! evaluation resumes.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use anyhow::{Context, bail};
use beadwork_console::{cancel, machine, output, progress};
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// A folder with one file for the result of each finished job in `parts/`, and `run.json`, which
/// records what all results depend on: settings, build and machine.
pub(super) struct Store {
    folder: PathBuf,
    machine: Value,
    /// Number of results that were loaded rather than computed.
    loaded: AtomicU64,
}

impl Store {
    /// Opens a folder; creates it if it does not exist.
    ///
    /// # Errors
    /// If the folder belongs to an evaluation with other settings, by another build of this program
    /// or on another machine: its results must not be mixed with new ones.
    pub(super) fn open(folder: &Path, settings: &Value) -> anyhow::Result<Self> {
        let parts = folder.join("parts");
        fs::create_dir_all(&parts)
            .with_context(|| format!("cannot create '{}'", parts.display()))?;
        let facts = machine::facts();
        let key = json!({
            "settings": settings, "build": build()?,
            "processor": facts["processor"], "cores": facts["cores"],
        });
        let path = folder.join("run.json");
        let machine = match read(&path)? {
            Some(mut run) if run["key"] == key => run["machine"].take(),
            Some(_) => bail!(
                "'{0}' contains an evaluation with other settings, by another build or from \
                 another machine: choose another --out, or remove it: rm -r '{0}'",
                folder.display()
            ),
            None => {
                output::file(&path, format!("{}\n", json!({ "key": key, "machine": facts })))?;
                facts
            }
        };
        Ok(Self { folder: folder.to_owned(), machine, loaded: AtomicU64::new(0) })
    }

    /// Facts of the machine, as recorded when the evaluation was started.
    pub(super) fn machine(&self) -> &Value {
        &self.machine
    }

    /// The results of all jobs in their order, each with the seconds it took to compute.
    ///
    /// Jobs run in parallel.
    /// A job is not run if the folder already has a result under its `name`.
    /// Ctrl-C ends the call with an error; finished results stay in the folder.
    pub(super) fn results<J: Sync, T: Serialize + DeserializeOwned + Send>(
        &self,
        pool: &rayon::ThreadPool,
        jobs: &[J],
        name: impl Fn(&J) -> String + Sync,
        compute: impl Fn(&J) -> anyhow::Result<T> + Sync,
    ) -> anyhow::Result<Vec<(T, f64)>> {
        let bar = progress::resumed(jobs.len() as u64, self.count()?, "eval zones");
        let result = |job: &J| {
            self.result(&name(job), || {
                let result = compute(job);
                bar.inc(1);
                result
            })
        };
        // Threads take jobs one by one, because a single job takes seconds to minutes.
        let results = pool.install(|| jobs.par_iter().with_max_len(1).map(result).collect());
        bar.finish_and_clear();
        results
    }

    /// Number of results in the folder.
    fn count(&self) -> anyhow::Result<u64> {
        let parts = self.folder.join("parts");
        let entries =
            fs::read_dir(&parts).with_context(|| format!("cannot list '{}'", parts.display()))?;
        Ok(entries.count() as u64)
    }

    /// The result with this name and the seconds it took; loaded, or else computed and stored.
    fn result<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        compute: impl FnOnce() -> anyhow::Result<T>,
    ) -> anyhow::Result<(T, f64)> {
        let path = self.folder.join("parts").join(format!("{name}.json"));
        let damaged = || damaged(&path);
        if let Some(mut stored) = read(&path)? {
            self.loaded.fetch_add(1, Ordering::Relaxed);
            let seconds = stored["seconds"].as_f64().with_context(damaged)?;
            let result = serde_json::from_value(stored["part"].take()).with_context(damaged)?;
            return Ok((result, seconds));
        }
        self.check_cancelled()?;
        let begin = Instant::now();
        let result = compute();
        // A cancelled search returns the best path so far, which must not be stored as a result.
        self.check_cancelled()?;
        let (result, seconds) = (result?, begin.elapsed().as_secs_f64());
        output::file(&path, format!("{}\n", json!({ "seconds": seconds, "part": result })))?;
        Ok((result, seconds))
    }

    fn check_cancelled(&self) -> anyhow::Result<()> {
        if cancel::token()?.is_cancelled() {
            bail!("cancelled; the same command resumes from '{}'", self.folder.display());
        }
        Ok(())
    }

    /// Writes a file, such as a table, to the folder.
    pub(super) fn write(&self, name: &str, text: &str) -> anyhow::Result<()> {
        output::file(&self.folder.join(name), text)
    }

    /// Number of results so far that were loaded from earlier runs.
    pub(super) fn loaded(&self) -> u64 {
        self.loaded.load(Ordering::Relaxed)
    }
}

/// The JSON document in a file; `None` if there is no such file.
fn read(path: &Path) -> anyhow::Result<Option<Value>> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(serde_json::from_slice(&bytes).with_context(|| damaged(path))?)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).with_context(|| format!("cannot read '{}'", path.display())),
    }
}

fn damaged(path: &Path) -> String {
    format!("'{}' is damaged: remove it, and the same command computes it again", path.display())
}

/// Hash of this program's file, which identifies its build.
///
/// The commit does not: sources may have uncommitted changes, or not have been compiled since.
fn build() -> anyhow::Result<String> {
    let program = std::env::current_exe().context("cannot find this program's file")?;
    let bytes =
        fs::read(&program).with_context(|| format!("cannot read '{}'", program.display()))?;
    let mut hasher = DefaultHasher::new();
    hasher.write(&bytes);
    Ok(format!("{:016x}", hasher.finish()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use super::*;

    #[test]
    fn results_are_computed_once_and_for_one_key() {
        let folder = std::env::temp_dir().join(format!("beadwork-store-{}", std::process::id()));
        let store = Store::open(&folder, &json!(1)).unwrap();
        assert_eq!(store.result("a", || Ok(vec![1.1, 2.0 / 3.0])).unwrap().0, [1.1, 2.0 / 3.0]);
        assert_eq!(store.result("a", || Ok(vec![3.0])).unwrap().0, [1.1, 2.0 / 3.0]);
        assert_eq!((store.loaded(), store.count().unwrap()), (1, 1));
        assert!(store.result::<u32>("b", || bail!("disk full")).is_err());
        assert_eq!(store.result("b", || Ok(4)).unwrap().0, 4);
        let facts = store.machine().clone();
        assert_eq!(*Store::open(&folder, &json!(1)).unwrap().machine(), facts);

        let error = Store::open(&folder, &json!(2)).map(drop).unwrap_err();
        assert!(error.to_string().contains("other settings"), "{error}");
        fs::write(folder.join("parts/a.json"), "{").unwrap();
        let error = store.result("a", || Ok(5)).unwrap_err();
        assert!(error.to_string().contains("damaged"), "{error}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
