//! Atomic writing of files: after a crash of the program or the machine, either the old or the new
//! file exists, never a part of one.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A file or folder cannot be read, written, locked, listed or removed.
/// The message names it and gives the cause, on one line.
#[derive(Debug, Error)]
#[error("cannot {action} '{path}': {cause}", path = path.display())]
pub struct FileError {
    /// The action that failed: "read", "write", "lock", "list" or "remove".
    pub action: &'static str,
    /// The file or folder.
    pub path: PathBuf,
    /// Why it failed.
    pub cause: io::Error,
}

impl FileError {
    pub(crate) fn new(action: &'static str, path: &Path, cause: io::Error) -> Self {
        Self { action, path: path.to_owned(), cause }
    }
}

/// Writes a file atomically, replacing an existing one.
///
/// `write` fills a temporary file, `.NAME.PROCESS.partial` in the same folder, which is renamed
/// once all of its bytes are on disk.
/// If `write` fails or panics, the temporary file is removed and an existing file stays as it is.
/// A killed process leaves the temporary file behind.
///
/// `write` reports errors that are not I/O errors with [`io::Error::other`].
pub fn write_atomic<T>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<T>,
) -> Result<T, FileError> {
    write_atomic_at(path, |partial| {
        let mut out = BufWriter::new(File::create(partial)?);
        let value = write(&mut out)?;
        out.into_inner().map_err(io::IntoInnerError::into_error)?;
        Ok(value)
    })
}

/// [`write_atomic`] for libraries that write to a path: `write` creates the temporary file at the
/// path that it is given.
pub fn write_atomic_at<T>(
    path: &Path,
    write: impl FnOnce(&Path) -> io::Result<T>,
) -> Result<T, FileError> {
    try_write(path, write).map_err(|cause| FileError::new("write", path, cause))
}

fn try_write<T>(path: &Path, write: impl FnOnce(&Path) -> io::Result<T>) -> io::Result<T> {
    let no_name = || io::Error::new(io::ErrorKind::InvalidInput, "the path names no file");
    let name = path.file_name().ok_or_else(no_name)?;
    let mut partial_name = OsString::from(".");
    partial_name.push(name);
    // Two processes that write the same file must not share a temporary file.
    partial_name.push(format!(".{}.partial", std::process::id()));
    let partial = Partial { path: path.with_file_name(partial_name) };
    let value = write(&partial.path)?;
    File::options().write(true).open(&partial.path)?.sync_all()?;
    fs::rename(&partial.path, path)?;
    sync_folder(path)?;
    Ok(value)
}

/// A temporary file; removed when dropped, unless it has been renamed.
struct Partial {
    path: PathBuf,
}

impl Drop for Partial {
    fn drop(&mut self) {
        // After a successful rename there is nothing to remove; after a failure, the first error is
        // the one to report.
        let _ = fs::remove_file(&self.path);
    }
}

/// Flushes the folder's entries to disk, so that a rename survives a power failure.
#[cfg(unix)]
fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

/// On other systems folders cannot be opened as files; renames depend on the file system.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Removes the temporary files of killed processes from a folder.
/// No other process may be writing there.
pub(crate) fn remove_partials(folder: &Path) -> Result<(), FileError> {
    let list_error = |cause| FileError::new("list", folder, cause);
    for entry in fs::read_dir(folder).map_err(list_error)? {
        let entry = entry.map_err(list_error)?;
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        if name.starts_with(b".") && name.ends_with(b".partial") {
            let path = entry.path();
            fs::remove_file(&path).map_err(|cause| FileError::new("remove", &path, cause))?;
        }
    }
    Ok(())
}

/// Reads a whole file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    fs::read(path).map_err(|cause| FileError::new("read", path, cause))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_complete_file_replaces_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for content in ["first, longer", "second"] {
            let given = write_atomic(&path, |out| {
                assert!(names(folder.path())[0].starts_with(".a.txt."));
                out.write_all(content.as_bytes())?;
                Ok(content.len())
            });
            assert_eq!(given.unwrap(), content.len());
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn errors_name_the_file_and_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomic(&path, |out| out.write_all(b"old")).unwrap();
        let full = |out: &mut BufWriter<File>| {
            out.write_all(&vec![0; 100_000])?;
            Err::<(), _>(io::Error::other("no space left"))
        };
        let error = write_atomic(&path, full).unwrap_err();
        assert_eq!(error.to_string(), format!("cannot write '{}': no space left", path.display()));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.txt"]);

        let missing = folder.path().join("none").join("b.txt");
        let error = write_atomic(&missing, |_| Ok(())).unwrap_err();
        assert_eq!(
            (error.path.as_path(), error.cause.kind()),
            (&*missing, io::ErrorKind::NotFound)
        );
        assert_eq!(
            write_atomic(Path::new("/"), |_| Ok(())).unwrap_err().to_string(),
            "cannot write '/': the path names no file"
        );
    }

    #[test]
    fn a_failed_rename_and_a_panic_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        assert_eq!(write_atomic(&taken, |_| Ok(())).unwrap_err().path, taken);
        let path = folder.path().join("a.txt");
        let panicked =
            std::panic::catch_unwind(|| write_atomic::<()>(&path, |_| panic!("on purpose")));
        assert!(panicked.is_err());
        assert_eq!(names(folder.path()), ["taken"]);
    }

    #[test]
    fn only_partial_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        for name in [".a.bws.12.partial", ".b.json.7.partial", "c.partial", ".d", "e.bws"] {
            fs::write(folder.path().join(name), name).unwrap();
        }
        remove_partials(folder.path()).unwrap();
        assert_eq!(names(folder.path()), [".d", "c.partial", "e.bws"]);
        let error = remove_partials(&folder.path().join("none")).unwrap_err();
        assert_eq!((error.action, error.cause.kind()), ("list", io::ErrorKind::NotFound));
    }
}
