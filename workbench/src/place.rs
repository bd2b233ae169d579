//! Where a result goes: a file that appears whole or not at all.

use std::ffi::{OsStr, OsString};
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::WorkbenchError;

/// A place for a result, opened before the work that makes it.
#[derive(Debug)]
pub enum Place {
    /// A file: written beside its place, in this folder, then renamed into it.
    File {
        /// The folder.
        folder: PathBuf,
        /// The file.
        place: PathBuf,
    },
    /// A device or a pipe: written to as it is.
    Special(PathBuf),
}

impl Place {
    /// Opens a place; it must not be one of the `inputs`.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::IsInput`], [`WorkbenchError::NoFolder`], [`WorkbenchError::Write`].
    pub fn open(path: &Path, inputs: &[&Path]) -> Result<Self, WorkbenchError> {
        let cannot = |source| WorkbenchError::Write {
            path: path.to_owned(),
            source,
        };
        // Through symbolic links, to what is really written.
        let place = whole(path);
        if inputs
            .iter()
            .any(|input| input.canonicalize().is_ok_and(|input| input == place))
        {
            let path = path.to_owned();
            return Err(WorkbenchError::IsInput { path });
        }
        if place.exists() && !place.is_file() {
            // Opened once now, so that a folder is refused before the work.
            append(&place).map_err(cannot)?;
            return Ok(Self::Special(place));
        }
        let folder = match place.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(WorkbenchError::NoFolder {
                path: path.to_owned(),
                action: "written",
                folder: folder.to_owned(),
            });
        }
        remove_left(folder, &place);
        // Not kept: a program that is interrupted would leave it behind.
        temporary_in(folder, &place).map_err(cannot)?;
        let folder = folder.to_owned();
        Ok(Self::File { folder, place })
    }

    /// The file, by its whole path.
    #[must_use]
    pub fn path(&self) -> &Path {
        let (Self::File { place: path, .. } | Self::Special(path)) = self;
        path
    }

    /// True for a file, which a second result would replace; a device or a pipe takes one after another.
    #[must_use]
    pub fn keeps_one_result(&self) -> bool {
        matches!(self, Self::File { .. })
    }

    /// Writes the result.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Write`].
    pub fn write(self, result: impl AsRef<[u8]>) -> Result<(), WorkbenchError> {
        let bytes = result.as_ref();
        let written = match &self {
            Self::File { folder, place } => replace(folder, place, bytes),
            Self::Special(place) => append(place).and_then(|mut file| file.write_all(bytes)),
        };
        let (Self::File { place: path, .. } | Self::Special(path)) = self;
        written.map_err(|source| WorkbenchError::Write { path, source })
    }
}

/// A path from the root, through symbolic links, of a file that need not be there.
fn whole(path: &Path) -> PathBuf {
    if let Ok(path) = path.canonicalize() {
        return path;
    }
    let Some(name) = path.file_name() else {
        return path.to_owned();
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    folder
        .canonicalize()
        .map_or_else(|_| path.to_owned(), |folder| folder.join(name))
}

fn append(place: &Path) -> io::Result<std::fs::File> {
    OpenOptions::new().append(true).open(place)
}

fn replace(folder: &Path, place: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut temporary = temporary_in(folder, place)?;
    // Held, so that another call does not take it for one that was left; a result is not lost for the want of it.
    let _ = temporary.as_file().lock();
    temporary.write_all(bytes)?;
    // On the disk before it has its name: after a power cut the old file is there, or the new one.
    temporary.as_file().sync_all()?;
    temporary.persist(place).map_err(|error| error.error)?;
    Ok(())
}

/// Beginning of the names of files that are not in their place yet.
fn beginning(place: &Path) -> OsString {
    let mut name = OsString::from(".");
    name.push(place.file_name().unwrap_or_default());
    name.push(".part-");
    name
}

/// Removes what calls left behind that were killed while they wrote. Of a call that is writing now it is locked; where there are
/// no locks it stays.
fn remove_left(folder: &Path, place: &Path) {
    let beginning = beginning(place);
    let is_ours = |name: &OsStr| {
        let name = name.as_encoded_bytes();
        name.starts_with(beginning.as_encoded_bytes())
    };
    for entry in folder.read_dir().into_iter().flatten().flatten() {
        let path = entry.path();
        let is_left = || {
            let file = OpenOptions::new().append(true).open(&path);
            file.is_ok_and(|file| file.try_lock().is_ok())
        };
        if is_ours(&entry.file_name()) && is_left() {
            // Another call may be removing it.
            let _ = std::fs::remove_file(&path);
        }
    }
}

fn temporary_in(folder: &Path, place: &Path) -> io::Result<NamedTempFile> {
    let temporary = as_any_file(Builder::new().prefix(&beginning(place))).tempfile_in(folder);
    // Without the name of a file that nobody has asked for.
    temporary.map_err(|error| io::Error::from(error.kind()))
}

/// With the permissions of any new file, from which the user's mask is taken.
#[cfg(unix)]
fn as_any_file<'b, 'p>(builder: &'b mut Builder<'p, 'static>) -> &'b mut Builder<'p, 'static> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(std::fs::Permissions::from_mode(0o666))
}

/// As the folder has it.
#[cfg(not(unix))]
fn as_any_file<'b, 'p>(builder: &'b mut Builder<'p, 'static>) -> &'b mut Builder<'p, 'static> {
    builder
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_call_left_is_removed_and_what_another_is_writing_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("out.json");
        let left = folder.path().join(".out.json.part-a");
        let held = folder.path().join(".out.json.part-b");
        let other = folder.path().join(".other.json.part-c");
        for path in [&left, &held, &other] {
            std::fs::write(path, "{").unwrap();
        }
        let lock = std::fs::File::open(&held).unwrap();
        lock.lock().unwrap();
        let opened = Place::open(&place, &[]).unwrap();
        assert!(!left.exists() && held.exists() && other.exists());
        opened.write("{}").unwrap();
        drop(lock);
        Place::open(&place, &[]).unwrap();
        assert!(!held.exists() && other.exists());
        assert_eq!(std::fs::read_to_string(place).unwrap(), "{}");
    }
}
