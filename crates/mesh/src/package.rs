//! The archive of a 3MF file: its parts, unpacked piece by piece and never beyond a limit.

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Cursor, Read};

use zip::ZipArchive;
use zip::result::ZipError;

use super::model::{ReadError, ReadLimits};

/// An archive, and how much of it may still be unpacked.
pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// Names of the parts by what they are found by.
    names: HashMap<String, String>,
    left: u64,
    most: u64,
}

impl<'a> Package<'a> {
    pub(super) fn open(bytes: &'a [u8], limits: &ReadLimits) -> Result<Self, ReadError> {
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|source| match source {
            ZipError::InvalidArchive(_) => {
                ReadError::Kind("not a 3MF file, which is a ZIP archive")
            }
            source => ReadError::Archive { part: "the archive".into(), source },
        })?;
        let mut names = HashMap::new();
        for name in archive.file_names().flatten() {
            // Of two names that differ in case only, the first.
            names.entry(key(&name)).or_insert_with(|| name.into_owned());
        }
        Ok(Self { archive, names, left: limits.unpacked_bytes, most: limits.unpacked_bytes })
    }

    /// The part of that name, with or without a slash before it, in upper or lower case.
    pub(super) fn find(&self, part: &str) -> Option<&str> {
        self.names.get(&key(part)).map(String::as_str)
    }

    /// Unpacks a part while `read` reads it.
    /// What `read` makes of an error of the archive or the limit is replaced by that.
    pub(super) fn read<T>(
        &mut self,
        part: &str,
        read: impl FnOnce(&mut dyn BufRead) -> Result<T, ReadError>,
    ) -> Result<T, ReadError> {
        let name = self.names.get(&key(part)).ok_or_else(|| ReadError::NoPart(part.to_owned()))?;
        let file = self.archive.by_name(name);
        let file = file.map_err(|source| ReadError::Archive { part: part.to_owned(), source })?;
        let mut limited = Limited { inner: file, left: self.left, failure: None };
        let result = read(&mut BufReader::with_capacity(1 << 16, &mut limited));
        self.left = limited.left;
        match limited.failure {
            Some(Failure::Limit) => {
                Err(ReadError::TooLarge { most: self.most, what: "bytes unpacked" })
            }
            Some(Failure::Archive(error)) => {
                Err(ReadError::Archive { part: part.to_owned(), source: ZipError::Io(error) })
            }
            None => result,
        }
    }
}

fn key(part: &str) -> String {
    part.trim_start_matches('/').to_ascii_lowercase()
}

/// Stops at the limit, and remembers why, for an XML reader tells of no more than "an error of the
/// source".
struct Limited<R> {
    inner: R,
    left: u64,
    failure: Option<Failure>,
}

enum Failure {
    Limit,
    Archive(io::Error),
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.inner.read(buffer) {
            Ok(count) if count as u64 > self.left => {
                self.failure = Some(Failure::Limit);
                Err(io::Error::other("the limit is reached"))
            }
            Ok(count) => {
                self.left -= count as u64;
                Ok(count)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Err(error),
            Err(error) => {
                self.failure = Some(Failure::Archive(error));
                Err(io::Error::other("the archive is damaged"))
            }
        }
    }
}
