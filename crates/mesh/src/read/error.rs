//! What readers refuse.

use std::fmt;

use beadwork_base::Interrupted;
use thiserror::Error;

use crate::mesh::MeshError;

/// The size up to which files are read.
/// A small archive can unpack to any size, so these limits bound time and memory.
///
/// Construct it with `..ReadLimits::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadLimits {
    /// Maximum number of bytes to which the entries of an archive unpack, in total.
    pub unpacked_bytes: u64,
    /// Maximum number of triangles of all bodies.
    pub triangles: usize,
}

impl Default for ReadLimits {
    /// 1 GiB unpacked, 32 million triangles.
    /// Reading takes at most about ten times the unpacked bytes in memory, or 70 bytes for each
    /// triangle of painted facets, whose text is shorter than a triangle.
    fn default() -> Self {
        Self { unpacked_bytes: 1 << 30, triangles: 32_000_000 }
    }
}

/// Why a file cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file has no bytes.
    #[error("file is empty")]
    Empty,
    /// The file is not of the given format.
    #[error("not a valid {format} file: {reason}")]
    WrongFormat {
        /// Name of the format.
        format: &'static str,
        /// What distinguishes it.
        reason: &'static str,
    },
    /// The content is of another format than the name of the file says.
    #[error("not a valid {expected} file: content is {found}")]
    OtherFormat {
        /// Name of the expected format.
        expected: &'static str,
        /// What the content is, with an article.
        found: &'static str,
    },
    /// A binary STL file ends too early.
    #[error("header declares {declared} triangles, file holds {held}")]
    Truncated {
        /// Number of triangles in the header.
        declared: u64,
        /// Number of triangles that the rest of the file has space for.
        held: u64,
    },
    /// A line of a text file is wrong.
    #[error("line {line}: {message}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// An entry of an archive is wrong.
    #[error("{entry}{}: {message}", at_byte(*.byte))]
    Entry {
        /// Name of the entry.
        entry: String,
        /// Offset in the unpacked entry; `None` if the entry as a whole is meant.
        byte: Option<u64>,
        /// What is wrong.
        message: String,
    },
    /// An entry of an archive is missing.
    #[error("archive has no entry {0}")]
    MissingEntry(String),
    /// An archive or one of its entries cannot be unpacked.
    #[error("{entry} cannot be unpacked")]
    Archive {
        /// Name of the entry, or "archive".
        entry: String,
        /// Why.
        #[source]
        source: zip::result::ZipError,
    },
    /// The file exceeds the [`ReadLimits`], or has more materials than
    /// [`Model::MAX_MATERIALS`](crate::Model::MAX_MATERIALS).
    #[error("file has more than {limit} {what}")]
    TooLarge {
        /// The limit.
        limit: u64,
        /// What it limits, in the plural.
        what: &'static str,
    },
    /// The mesh of a body is invalid.
    #[error("body {body}: {error}")]
    Mesh {
        /// Name of the body, or its number if it has none.
        body: String,
        /// Why.
        error: MeshError,
    },
    /// The file contains nothing to print.
    #[error("file contains no triangles")]
    NoTriangles,
    /// The caller ended the call early.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl ReadError {
    pub(super) fn line(line: usize, message: impl fmt::Display) -> Self {
        Self::Line { line, message: message.to_string() }
    }

    /// An error that concerns an entry of an archive as a whole.
    pub(super) fn entry(entry: &str, message: String) -> Self {
        Self::Entry { entry: entry.to_owned(), byte: None, message }
    }

    pub(super) fn too_large(limit: usize, what: &'static str) -> Self {
        Self::TooLarge { limit: limit as u64, what }
    }
}

fn at_byte(byte: Option<u64>) -> String {
    byte.map_or_else(String::new, |byte| format!(", byte {byte}"))
}
