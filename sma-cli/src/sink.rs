//! Where a result goes: a file that appears whole or not at all, or stdout.

use std::fs::{OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde_json::Value;
use tempfile::{Builder, NamedTempFile};

use crate::terminal::write_stdout;

/// Permissions that the user's mask is taken from, as any new file has.
const ANY_FILE: u32 = 0o666;

/// A place for a result, opened before the work that makes it.
#[derive(Debug)]
pub(crate) enum Sink {
    /// "-".
    Stdout,
    /// A file: written beside its place, in this folder, then renamed into it.
    File { folder: PathBuf, place: PathBuf },
    /// What is no regular file (a device, a pipe): written to as it is.
    Special(PathBuf),
}

impl Sink {
    /// Opens a place; it must not be one of the `inputs`.
    pub(crate) fn open(path: &Path, inputs: &[&Path]) -> anyhow::Result<Self> {
        if path == Path::new("-") {
            return Ok(Self::Stdout);
        }
        let cannot = || format!("{}: cannot be written", path.display());
        // Through symbolic links, to what is really written.
        let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if inputs
            .iter()
            .any(|input| input.canonicalize().is_ok_and(|input| input == place))
        {
            bail!(
                "{}: is an input of this command; give another file for the result",
                path.display()
            );
        }
        if place.exists() && !place.is_file() {
            // Opened once now, so that a folder is refused before the work.
            OpenOptions::new()
                .append(true)
                .open(&place)
                .with_context(cannot)?;
            return Ok(Self::Special(place));
        }
        let folder = match place.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            bail!(
                "{}: cannot be written: there is no folder {}",
                path.display(),
                folder.display()
            );
        }
        // Not kept: a program that is interrupted would leave it behind.
        temporary_in(folder).with_context(cannot)?;
        let folder = folder.to_owned();
        Ok(Self::File { folder, place })
    }

    /// Opens a place that may not be wanted.
    pub(crate) fn open_if(path: Option<&Path>, inputs: &[&Path]) -> anyhow::Result<Option<Self>> {
        path.map(|path| Self::open(path, inputs)).transpose()
    }

    /// Writes the result.
    pub(crate) fn write(self, text: &str) -> anyhow::Result<()> {
        match self {
            Self::Stdout => write_stdout(text)?,
            Self::File { folder, place } => {
                let cannot = || format!("{}: cannot be written", place.display());
                let mut temporary = temporary_in(&folder).with_context(cannot)?;
                temporary.write_all(text.as_bytes()).with_context(cannot)?;
                temporary
                    .persist(&place)
                    .map_err(|error| error.error)
                    .with_context(cannot)?;
            }
            Self::Special(place) => {
                let cannot = || format!("{}: cannot be written", place.display());
                let mut file = OpenOptions::new()
                    .append(true)
                    .open(&place)
                    .with_context(cannot)?;
                file.write_all(text.as_bytes()).with_context(cannot)?;
            }
        }
        Ok(())
    }
}

fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    let temporary = Builder::new()
        .permissions(Permissions::from_mode(ANY_FILE))
        .tempfile_in(folder);
    // Without the name of a file that nobody has asked for.
    temporary.map_err(|error| io::Error::from(error.kind()))
}

/// Gives the result to people on stdout and to programs where they want it; both on stdout is the latter.
pub(crate) fn deliver(text: &str, json: &Value, place: Option<Sink>) -> anyhow::Result<()> {
    let json = || Ok::<_, serde_json::Error>(serde_json::to_string_pretty(json)? + "\n");
    match place {
        Some(Sink::Stdout) => write_stdout(&json()?)?,
        Some(file) => {
            write_stdout(text)?;
            file.write(&json()?)?;
        }
        None => write_stdout(text)?,
    }
    Ok(())
}
