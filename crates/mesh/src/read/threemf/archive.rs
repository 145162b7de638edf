//! The ZIP archive of a 3MF file, unpacked entry by entry and never beyond a limit.

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Cursor, Read};

use beadwork_base::{Control, Interrupted};
use zip::ZipArchive;
use zip::result::ZipError;

use crate::read::error::{ReadError, ReadLimits};

/// Bytes that are unpacked between two checks for interruption.
const BUFFER: usize = 1 << 16;

/// An archive, and how much of it may still be unpacked.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Names of the entries by their normalized names.
    names: HashMap<String, String>,
    /// Bytes that may still be unpacked.
    remaining: u64,
    limit: u64,
    /// Bytes of the file whose content has been unpacked.
    position: u64,
    /// Length of the file.
    total: usize,
    control: &'a Control<'a>,
}

impl<'a> Archive<'a> {
    pub(super) fn open(
        bytes: &'a [u8],
        limits: &ReadLimits,
        control: &'a Control<'a>,
    ) -> Result<Self, ReadError> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|source| match source {
            ZipError::InvalidArchive(_) => {
                ReadError::WrongFormat { format: "3MF", reason: "not a ZIP archive" }
            }
            source => ReadError::Archive { entry: "archive".into(), source },
        })?;
        let mut names = HashMap::new();
        for name in zip.file_names().flatten() {
            // Of two names that differ only in case, the first counts.
            names.entry(normalized(&name)).or_insert_with(|| name.into_owned());
        }
        let limit = limits.unpacked_bytes;
        let total = bytes.len();
        Ok(Self { zip, names, remaining: limit, limit, position: 0, total, control })
    }

    /// Whether there is an entry with this name, however it is written.
    pub(super) fn contains(&self, entry: &str) -> bool {
        self.names.contains_key(&normalized(entry))
    }

    /// Unpacks an entry while `read` reads it.
    pub(super) fn read<T>(
        &mut self,
        entry: &str,
        read: impl FnOnce(&mut dyn BufRead) -> Result<T, ReadError>,
    ) -> Result<T, ReadError> {
        let name = self
            .names
            .get(&normalized(entry))
            .ok_or_else(|| ReadError::MissingEntry(entry.to_owned()))?;
        let archive_error = |source| ReadError::Archive { entry: entry.to_owned(), source };
        let file = self.zip.by_name(name).map_err(archive_error)?;
        let (packed, unpacked) = (file.compressed_size(), file.size());
        let mut source = Source {
            inner: file,
            remaining: self.remaining,
            done: 0,
            failure: None,
            control: self.control,
            progress: |done: u64| {
                // The position in the file is interpolated from the unpacked bytes.
                let share = done as f64 / unpacked.max(1) as f64 * packed as f64;
                let position = (self.position + share as u64).min(self.total as u64);
                self.control.report(position as usize, self.total);
            },
        };
        let result = read(&mut BufReader::with_capacity(BUFFER, &mut source));
        self.remaining = source.remaining;
        let failure = source.failure;
        self.position += packed;
        // `read` only sees that its source has failed.
        match failure {
            Some(Failure::Limit) => {
                Err(ReadError::TooLarge { limit: self.limit, what: "bytes when unpacked" })
            }
            Some(Failure::Interrupted(interrupted)) => Err(interrupted.into()),
            Some(Failure::Archive(error)) => Err(archive_error(ZipError::Io(error))),
            None => result,
        }
    }
}

/// A name for comparison: without a slash at its start, in lower case, with slashes between folders
/// (some programs write backslashes), and without percent-encoding, which references may have and
/// names of entries not.
fn normalized(entry: &str) -> String {
    let name = entry.trim_start_matches('/').replace('\\', "/").to_ascii_lowercase();
    let mut bytes = Vec::with_capacity(name.len());
    let mut rest = name.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        let digits =
            after.get(..2).filter(|_| byte == b'%').and_then(|it| std::str::from_utf8(it).ok());
        let decoded = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(decoded.unwrap_or(byte));
        rest = if decoded.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(bytes).unwrap_or(name)
}

/// Reads until the limit is reached or the call is interrupted, and keeps the reason: an XML reader
/// passes on nothing but an [`io::Error`].
struct Source<'a, R, P> {
    inner: R,
    remaining: u64,
    /// Bytes read.
    done: u64,
    failure: Option<Failure>,
    control: &'a Control<'a>,
    progress: P,
}

enum Failure {
    Limit,
    Interrupted(Interrupted),
    Archive(io::Error),
}

impl<R: Read, P: Fn(u64)> Source<'_, R, P> {
    fn fail(&mut self, failure: Failure) -> io::Result<usize> {
        self.failure = Some(failure);
        Err(io::Error::other("reading was ended"))
    }
}

impl<R: Read, P: Fn(u64)> Read for Source<'_, R, P> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if let Err(interrupted) = self.control.check() {
            return self.fail(Failure::Interrupted(interrupted));
        }
        match self.inner.read(buffer) {
            Ok(count) if count as u64 > self.remaining => self.fail(Failure::Limit),
            Ok(count) => {
                self.remaining -= count as u64;
                self.done += count as u64;
                (self.progress)(self.done);
                Ok(count)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Err(error),
            Err(error) => self.fail(Failure::Archive(error)),
        }
    }
}
