//! The manifest of a dataset: lists its shards, and is written when all of them are complete.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::file::{self, FileError, write_atomic};
use crate::shard::ShardSummary;

/// Contents of a dataset, and the configuration it was made from.
///
/// It contains no times and no facts about a machine, so equal datasets have equal manifests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the manifest's format, [`Manifest::FORMAT_VERSION`].
    pub format_version: u32,
    /// Name of the records' schema: "trajectories".
    pub schema: String,
    /// Version of the crate that made the dataset.
    pub crate_version: String,
    /// Seed of the dataset.
    pub seed: u64,
    /// Resolved configuration of the dataset.
    pub config: serde_json::Value,
    /// Number of records in all shards.
    pub records: u64,
    /// Number of moves in all records.
    pub moves: u64,
    /// Number of records of each combination of instance, preset and start, by its name.
    pub strata: BTreeMap<String, u64>,
    /// The shards in the order of their records.
    pub shards: Vec<ShardEntry>,
}

/// One shard of a dataset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShardEntry {
    /// Name of its file in the dataset's folder.
    pub file: String,
    /// Number of its records.
    pub records: u64,
    /// Number of its first record in the dataset, from 0.
    pub first: u64,
    /// Number of its blocks.
    pub blocks: u32,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// Length of its blocks before compression, in bytes.
    pub raw_bytes: u64,
    /// SHA-256 of the file, in lower-case hexadecimal.
    pub sha256: String,
}

/// Why a manifest cannot be loaded.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ManifestError {
    /// The folder has no manifest: it holds no dataset, or an unfinished one.
    #[error(
        "'{folder}' holds no finished dataset: {name} is missing \
         (to finish an interrupted gen-data, run it again)",
        folder = folder.display(), name = Manifest::FILE
    )]
    Missing {
        /// The folder.
        folder: PathBuf,
    },
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The manifest has another format version.
    #[error(
        "'{path}' has format version {got}, this build reads version {expected}",
        path = path.display()
    )]
    Version {
        /// The manifest.
        path: PathBuf,
        /// The version this build reads.
        expected: u32,
        /// The version found.
        got: u64,
    },
    /// The file is not a manifest.
    #[error("'{path}' is not a manifest: {cause}", path = path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        cause: serde_json::Error,
    },
    /// Fields of the manifest contradict each other.
    #[error("'{path}' is inconsistent: {what}", path = path.display())]
    Inconsistent {
        /// The manifest.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
}

impl ShardEntry {
    /// The entry of a shard that was written or verified; `first` is the number of its first
    /// record.
    pub fn new(file: String, first: u64, summary: ShardSummary) -> Self {
        let ShardSummary { blocks, records, bytes, raw_bytes, sha256 } = summary;
        Self { file, records, first, blocks, bytes, raw_bytes, sha256 }
    }
}

/// Hash of a resolved configuration and a version of this crate: the first 8 bytes of the SHA-256
/// of the JSON text `[version, config]`, whose keys are sorted.
pub(crate) fn fingerprint(version: &str, config: &serde_json::Value) -> u64 {
    let text = serde_json::json!([version, config]).to_string();
    let digest = Sha256::digest(text.as_bytes());
    digest.iter().take(8).fold(0, |sum, &byte| sum << 8 | u64::from(byte))
}

/// The format version, which is parsed before all else: another version may have other fields.
#[derive(Deserialize)]
struct Versioned {
    format_version: u64,
}

impl Manifest {
    /// Version of the format that this build reads and writes.
    pub const FORMAT_VERSION: u32 = 1;

    /// Name of the manifest in a dataset's folder.
    pub const FILE: &str = "manifest.json";

    /// Loads the manifest of a dataset from its folder.
    pub fn load(folder: &Path) -> Result<Self, ManifestError> {
        let path = folder.join(Self::FILE);
        let json = file::read(&path).map_err(|error| match error.cause.kind() {
            io::ErrorKind::NotFound => ManifestError::Missing { folder: folder.to_owned() },
            _ => error.into(),
        })?;
        let malformed = |cause| ManifestError::Malformed { path: path.clone(), cause };
        let Versioned { format_version: got } = serde_json::from_slice(&json).map_err(malformed)?;
        if got != u64::from(Self::FORMAT_VERSION) {
            return Err(ManifestError::Version { expected: Self::FORMAT_VERSION, got, path });
        }
        let manifest: Self = serde_json::from_slice(&json).map_err(malformed)?;
        match manifest.inconsistency() {
            Some(what) => Err(ManifestError::Inconsistent { path, what }),
            None => Ok(manifest),
        }
    }

    /// Writes the manifest to a dataset's folder: indented JSON, fields in the order of this
    /// struct.
    pub fn store(&self, folder: &Path) -> Result<(), FileError> {
        write_atomic(&folder.join(Self::FILE), |out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            out.write_all(b"\n")
        })
    }

    /// Hash of the resolved configuration and the crate's version.
    /// Every shard of the dataset has the same one in its header.
    pub fn fingerprint(&self) -> u64 {
        fingerprint(&self.crate_version, &self.config)
    }

    /// The first inconsistency between fields, if there is one.
    fn inconsistency(&self) -> Option<String> {
        let mut next = self.shards.first().map_or(0, |shard| shard.first);
        let mut records = 0;
        for shard in &self.shards {
            // A name with a folder in it could point outside the dataset's folder.
            if Path::new(&shard.file).file_name() != Some(shard.file.as_ref()) {
                return Some(format!("'{}' is not a plain file name", shard.file));
            }
            if shard.first != next {
                return Some(format!(
                    "'{}' starts at record {}, expected {next}",
                    shard.file, shard.first
                ));
            }
            let Some(end) = shard.first.checked_add(shard.records) else {
                return Some(format!("'{}' has too many records", shard.file));
            };
            next = end;
            records += shard.records;
        }
        let in_strata = self.strata.values().sum();
        let counts = [("shards", records), ("strata", in_strata)];
        let (what, count) = counts.into_iter().find(|&(_, count)| count != self.records)?;
        Some(format!("{what} hold {count} records in all, expected {}", self.records))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::json;

    use super::*;

    fn manifest() -> Manifest {
        let shard = |number: u64, first: u64, records: u64| ShardEntry {
            file: format!("shard-{number:05}.bws"),
            records,
            first,
            blocks: 2,
            bytes: 1000 + number,
            raw_bytes: 3000,
            sha256: "0f".repeat(32),
        };
        Manifest {
            format_version: 1,
            schema: "trajectories".to_owned(),
            crate_version: "0.1.0".to_owned(),
            seed: u64::MAX,
            config: json!({"size": [30, 30], "alpha": 0.25}),
            records: 12,
            moves: 3456,
            strata: [("stripes".to_owned(), 5), ("islands".to_owned(), 7)].into(),
            shards: vec![shard(0, 0, 10), shard(1, 10, 2)],
        }
    }

    /// Stores the manifest with one value replaced, and returns the error of loading it.
    fn load_changed(pointer: &str, value: serde_json::Value) -> String {
        let folder = tempfile::tempdir().unwrap();
        let mut json = serde_json::to_value(manifest()).unwrap();
        match json.pointer_mut(pointer) {
            Some(field) => *field = value,
            None => json[pointer] = value,
        }
        let path = folder.path().join(Manifest::FILE);
        fs::write(&path, json.to_string()).unwrap();
        let message = Manifest::load(folder.path()).unwrap_err().to_string();
        message.strip_prefix(&format!("'{}' ", path.display())).unwrap().to_owned()
    }

    #[test]
    fn golden_text() {
        let folder = tempfile::tempdir().unwrap();
        manifest().store(folder.path()).unwrap();
        assert_eq!(Manifest::load(folder.path()).unwrap(), manifest());
        let text = fs::read_to_string(folder.path().join("manifest.json")).unwrap();
        let (before, shards) = text.split_once("  \"shards\": [\n").unwrap();
        let golden = r#"{
  "format_version": 1,
  "schema": "trajectories",
  "crate_version": "0.1.0",
  "seed": 18446744073709551615,
  "config": {
    "alpha": 0.25,
    "size": [
      30,
      30
    ]
  },
  "records": 12,
  "moves": 3456,
  "strata": {
    "islands": 7,
    "stripes": 5
  },
"#;
        assert_eq!(before, golden);
        let first = r#"    {
      "file": "shard-00000.bws",
      "records": 10,
      "first": 0,
      "blocks": 2,
      "bytes": 1000,
      "raw_bytes": 3000,
      "sha256": "#;
        assert!(shards.starts_with(first), "{shards}");
        assert!(text.ends_with("    }\n  ]\n}\n"));
    }

    #[test]
    fn a_folder_without_a_manifest_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let error = Manifest::load(folder.path()).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "'{}' holds no finished dataset: manifest.json is missing \
                 (to finish an interrupted gen-data, run it again)",
                folder.path().display()
            )
        );
    }

    #[test]
    fn other_versions_and_fields_are_refused() {
        // A later version may have any fields; the message must name its version.
        let later = json!({"format_version": 2, "parts": []});
        assert_eq!(load_changed("", later), "has format version 2, this build reads version 1");
        let unknown = load_changed("colour", json!("red"));
        assert!(unknown.starts_with("is not a manifest: unknown field `colour`"), "{unknown}");
        let unversioned = load_changed("", json!({"seed": 1}));
        assert!(
            unversioned.starts_with("is not a manifest: missing field `format_version`"),
            "{unversioned}"
        );
    }

    #[test]
    fn inconsistencies_are_found() {
        let cases = [
            ("/records", json!(13), "shards hold 12 records in all, expected 13"),
            ("/strata/islands", json!(8), "strata hold 13 records in all, expected 12"),
            ("/shards/1/first", json!(11), "'shard-00001.bws' starts at record 11, expected 10"),
            ("/shards/1/records", json!(u64::MAX), "'shard-00001.bws' has too many records"),
            ("/shards/0/file", json!("../a.bws"), "'../a.bws' is not a plain file name"),
            ("/shards/0/file", json!(""), "'' is not a plain file name"),
        ];
        for (pointer, value, what) in cases {
            assert_eq!(load_changed(pointer, value), format!("is inconsistent: {what}"));
        }
    }
}
