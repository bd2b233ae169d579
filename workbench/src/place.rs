//! Where a result goes: a file that appears whole or not at all.

use std::fs::{OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::WorkbenchError;

/// Permissions that the user's mask is taken from, as any new file has.
const ANY_FILE: u32 = 0o666;

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
        // Not kept: a program that is interrupted would leave it behind.
        temporary_in(folder).map_err(cannot)?;
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
    let mut temporary = temporary_in(folder)?;
    temporary.write_all(bytes)?;
    // On the disk before it has its name: after a power cut the old file is there, or the new one.
    temporary.as_file().sync_all()?;
    temporary.persist(place).map_err(|error| error.error)?;
    Ok(())
}

fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    let temporary = Builder::new()
        .permissions(Permissions::from_mode(ANY_FILE))
        .tempfile_in(folder);
    // Without the name of a file that nobody has asked for.
    temporary.map_err(|error| io::Error::from(error.kind()))
}
