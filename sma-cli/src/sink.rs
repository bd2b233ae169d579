//! Where a result goes: a file that appears whole or not at all, or stdout.

use std::path::Path;

use serde_json::Value;
use workbench::{Place, WorkbenchError};

use crate::terminal::write_stdout;

/// A place for a result, opened before the work that makes it.
#[derive(Debug)]
pub(crate) enum Sink {
    /// "-".
    Stdout,
    /// Anything else.
    Place(Place),
}

impl Sink {
    /// Opens a place; it must not be one of the `inputs`.
    pub(crate) fn open(path: &Path, inputs: &[&Path]) -> Result<Self, WorkbenchError> {
        if path == Path::new("-") {
            return Ok(Self::Stdout);
        }
        Ok(Self::Place(Place::open(path, inputs)?))
    }

    /// Opens a place that may not be wanted.
    pub(crate) fn open_if(
        path: Option<&Path>,
        inputs: &[&Path],
    ) -> Result<Option<Self>, WorkbenchError> {
        path.map(|path| Self::open(path, inputs)).transpose()
    }

    /// Writes the result.
    pub(crate) fn write(self, text: &str) -> anyhow::Result<()> {
        match self {
            Self::Stdout => write_stdout(text)?,
            Self::Place(place) => place.write(text)?,
        }
        Ok(())
    }
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
