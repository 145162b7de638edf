//! Parts of a long evaluation, kept in a folder so that an interrupted one goes on where it stopped.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::{machine, output};

/// A folder with a file for each finished part.
pub(super) struct Store {
    folder: PathBuf,
    /// What all parts must have been made with: commit, version and settings.
    key: Value,
    /// Parts that lay there already.
    kept: u32,
}

impl Store {
    /// Opens a folder, making it if need be.
    pub(super) fn open(folder: &Path, settings: &Value) -> anyhow::Result<Self> {
        fs::create_dir_all(folder.join("parts"))
            .with_context(|| format!("cannot make '{}'", folder.display()))?;
        let facts = machine::facts();
        let key = json!({ "commit": facts["commit"], "version": facts["version"], "settings": settings });
        Ok(Self { folder: folder.to_owned(), key, kept: 0 })
    }

    /// The part of this name: as it lies there, or made now and kept.
    pub(super) fn part<T: Serialize + DeserializeOwned>(
        &mut self,
        name: &str,
        make: impl FnOnce() -> anyhow::Result<T>,
    ) -> anyhow::Result<T> {
        let path = self.folder.join("parts").join(format!("{name}.json"));
        let shown = path.display();
        match fs::read(&path) {
            Ok(bytes) => {
                let damaged = || format!("'{shown}' is damaged: remove it to have it made again");
                let mut kept: Value = serde_json::from_slice(&bytes).with_context(damaged)?;
                if kept["key"] != self.key {
                    bail!(
                        "'{shown}' was made with other settings or by another commit ({}): choose another --out, or remove the folder",
                        kept["key"]["commit"].as_str().unwrap_or("unknown")
                    );
                }
                self.kept += 1;
                serde_json::from_value(kept["part"].take()).with_context(damaged)
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                let part = make()?;
                output::file(&path, &format!("{}\n", json!({ "key": self.key, "part": part })))?;
                Ok(part)
            }
            Err(error) => Err(error).with_context(|| format!("cannot read '{shown}'")),
        }
    }

    /// Writes a result beside the parts.
    pub(super) fn result(&self, name: &str, text: &str) -> anyhow::Result<()> {
        output::file(&self.folder.join(name), text)
    }

    /// Parts that earlier runs had made.
    pub(super) fn kept(&self) -> u32 {
        self.kept
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use super::*;

    #[test]
    fn parts_are_made_once_and_for_one_key() {
        let folder = std::env::temp_dir().join(format!("beadwork-store-{}", std::process::id()));
        let mut store = Store::open(&folder, &json!(1)).unwrap();
        assert_eq!(store.part("a", || Ok(vec![1, 2])).unwrap(), [1, 2]);
        assert_eq!(store.part("a", || Ok(vec![3])).unwrap(), [1, 2]);
        assert_eq!(store.kept(), 1);
        assert!(store.part::<u32>("b", || bail!("stopped")).is_err());
        assert_eq!(store.part("b", || Ok(4)).unwrap(), 4);

        let error = Store::open(&folder, &json!(2)).unwrap().part("a", || Ok(5)).unwrap_err();
        assert!(error.to_string().contains("other settings"), "{error}");
        fs::write(folder.join("parts/a.json"), "{").unwrap();
        let error = store.part("a", || Ok(5)).unwrap_err();
        assert!(error.to_string().contains("damaged"), "{error}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
