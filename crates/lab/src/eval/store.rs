//! Parts of a long evaluation, kept in a folder so that an interrupted one goes on where it
//! stopped.

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

/// A folder with a file for each finished part, and one that says what all of them were made with.
pub(super) struct Store {
    folder: PathBuf,
    machine: Value,
    /// Parts that lay there already.
    kept: AtomicU64,
}

impl Store {
    /// Opens a folder, making it if need be.
    /// One of other settings, of another build of this program or of another machine is refused,
    /// for its parts would not go together with new ones.
    pub(super) fn open(folder: &Path, settings: &Value) -> anyhow::Result<Self> {
        let parts = folder.join("parts");
        fs::create_dir_all(&parts).with_context(|| format!("cannot make '{}'", parts.display()))?;
        let facts = machine::facts();
        let key = json!({
            "settings": settings, "build": build()?, "processor": facts["processor"], "cores": facts["cores"],
        });
        let path = folder.join("run.json");
        let machine = match read(&path)? {
            Some(mut run) if run["key"] == key => run["machine"].take(),
            Some(_) => bail!(
                "'{0}' holds an evaluation with other settings, by another build or from another machine: choose another --out, or remove \
                 it: rm -r '{0}'",
                folder.display()
            ),
            None => {
                output::file(&path, format!("{}\n", json!({ "key": key, "machine": facts })))?;
                facts
            }
        };
        Ok(Self { folder: folder.to_owned(), machine, kept: AtomicU64::new(0) })
    }

    /// What the first part was made on.
    pub(super) fn machine(&self) -> &Value {
        &self.machine
    }

    /// The parts of all jobs in their order, each as it lies there or made now, and the seconds
    /// that it took then.
    pub(super) fn parts<J: Sync, T: Serialize + DeserializeOwned + Send>(
        &self,
        pool: &rayon::ThreadPool,
        jobs: &[J],
        name: impl Fn(&J) -> String + Sync,
        make: impl Fn(&J) -> anyhow::Result<T> + Sync,
    ) -> anyhow::Result<Vec<(T, f64)>> {
        let bar = progress::resumed(jobs.len() as u64, self.count()?, "eval zones");
        let part = |job: &J| {
            self.part(&name(job), || {
                let made = make(job);
                bar.inc(1);
                made
            })
        };
        let parts = pool.install(|| jobs.par_iter().with_max_len(1).map(part).collect());
        bar.finish_and_clear();
        parts
    }

    /// How many parts are there.
    fn count(&self) -> anyhow::Result<u64> {
        let parts = self.folder.join("parts");
        let entries =
            fs::read_dir(&parts).with_context(|| format!("cannot list '{}'", parts.display()))?;
        Ok(entries.count() as u64)
    }

    /// The part of this name, as it lies there or made now, and the seconds that it took then.
    ///
    /// What is made after the cancel token was set is not kept: the searches give up early.
    fn part<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        make: impl FnOnce() -> anyhow::Result<T>,
    ) -> anyhow::Result<(T, f64)> {
        let path = self.folder.join("parts").join(format!("{name}.json"));
        let damaged = || damaged(&path);
        if let Some(mut kept) = read(&path)? {
            self.kept.fetch_add(1, Ordering::Relaxed);
            let seconds = kept["seconds"].as_f64().with_context(damaged)?;
            return Ok((
                serde_json::from_value(kept["part"].take()).with_context(damaged)?,
                seconds,
            ));
        }
        let stopped = || -> anyhow::Result<()> {
            if cancel::token()?.as_flag().load(Ordering::Relaxed) {
                bail!("stopped; the same command goes on from '{}'", self.folder.display());
            }
            Ok(())
        };
        stopped()?;
        let begin = Instant::now();
        let part = make();
        stopped()?;
        let (part, seconds) = (part?, begin.elapsed().as_secs_f64());
        output::file(&path, format!("{}\n", json!({ "seconds": seconds, "part": part })))?;
        Ok((part, seconds))
    }

    /// Writes a result beside the parts.
    pub(super) fn result(&self, name: &str, text: &str) -> anyhow::Result<()> {
        output::file(&self.folder.join(name), text)
    }

    /// Parts that earlier runs had made.
    pub(super) fn kept(&self) -> u64 {
        self.kept.load(Ordering::Relaxed)
    }
}

/// The document in a file; `None` where there is no file.
fn read(path: &Path) -> anyhow::Result<Option<Value>> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(serde_json::from_slice(&bytes).with_context(|| damaged(path))?)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).with_context(|| format!("cannot read '{}'", path.display())),
    }
}

fn damaged(path: &Path) -> String {
    format!("'{}' is damaged: remove it to have it made again", path.display())
}

/// A number that tells builds of this program apart: the commit does not, for sources may have been
/// changed or not built anew.
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
    fn parts_are_made_once_and_for_one_key() {
        let folder = std::env::temp_dir().join(format!("beadwork-store-{}", std::process::id()));
        let store = Store::open(&folder, &json!(1)).unwrap();
        assert_eq!(store.part("a", || Ok(vec![1.1, 2.0 / 3.0])).unwrap().0, [1.1, 2.0 / 3.0]);
        assert_eq!(store.part("a", || Ok(vec![3.0])).unwrap().0, [1.1, 2.0 / 3.0]);
        assert_eq!((store.kept(), store.count().unwrap()), (1, 1));
        assert!(store.part::<u32>("b", || bail!("no room")).is_err());
        assert_eq!(store.part("b", || Ok(4)).unwrap().0, 4);
        let facts = store.machine().clone();
        assert_eq!(*Store::open(&folder, &json!(1)).unwrap().machine(), facts);

        let error = Store::open(&folder, &json!(2)).map(drop).unwrap_err();
        assert!(error.to_string().contains("other settings"), "{error}");
        fs::write(folder.join("parts/a.json"), "{").unwrap();
        let error = store.part("a", || Ok(5)).unwrap_err();
        assert!(error.to_string().contains("damaged"), "{error}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
