//! Where a result goes: a file that appears whole or not at all, or stdout.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;
use workbench::figure::Gallery;
use workbench::{Place, WorkbenchError};

use crate::terminal::write_stdout;

/// Places for the results of one call: none of them an input, none of them that of another result.
#[derive(Debug)]
pub(crate) struct Outputs<'a> {
    inputs: &'a [&'a Path],
    taken: Vec<PathBuf>,
}

impl<'a> Outputs<'a> {
    /// No places yet, for a call with inputs.
    pub(crate) fn beside(inputs: &'a [&'a Path]) -> Self {
        Self {
            inputs,
            taken: Vec::new(),
        }
    }

    /// Opens a place, before the work that makes the result.
    pub(crate) fn open(&mut self, path: &Path) -> Result<Sink, WorkbenchError> {
        if path == Path::new("-") {
            self.take(path, path)?;
            return Ok(Sink::Stdout);
        }
        let place = Place::open(path, self.inputs)?;
        if place.keeps_one_result() {
            self.take(path, place.path())?;
        }
        Ok(Sink::Place(place))
    }

    /// Opens a place that may not be wanted.
    pub(crate) fn open_if(&mut self, path: Option<&Path>) -> Result<Option<Sink>, WorkbenchError> {
        path.map(|path| self.open(path)).transpose()
    }

    /// Opens a folder for figures that may not be wanted.
    pub(crate) fn gallery_if(
        &mut self,
        folder: Option<&Path>,
    ) -> Result<Option<Gallery>, WorkbenchError> {
        folder
            .map(|folder| Gallery::at(folder, self.inputs))
            .transpose()
    }

    /// Keeps a place for what the call writes by itself while it runs: the file of `--resume`.
    pub(crate) fn reserve_if(&mut self, path: Option<&Path>) -> Result<(), WorkbenchError> {
        let Some(path) = path else {
            return Ok(());
        };
        let place = Place::open(path, self.inputs)?;
        self.take(path, place.path())
    }

    fn take(&mut self, path: &Path, place: &Path) -> Result<(), WorkbenchError> {
        if self.taken.iter().any(|taken| taken == place) {
            let path = path.to_owned();
            return Err(WorkbenchError::Taken { path });
        }
        self.taken.push(place.to_owned());
        Ok(())
    }
}

/// Results that are written one after another. One that cannot be written does not keep the others from being written.
#[derive(Debug, Default)]
pub(crate) struct Delivery(Option<anyhow::Error>);

impl Delivery {
    /// Writes one more.
    pub(crate) fn of(&mut self, write: impl FnOnce() -> anyhow::Result<()>) {
        if let Err(error) = write() {
            self.0.get_or_insert(error);
        }
    }

    /// The first fault, if there was one.
    pub(crate) fn end(self) -> anyhow::Result<()> {
        self.0.map_or(Ok(()), Err)
    }
}

/// A place for a result, opened before the work that makes it.
#[derive(Debug)]
pub(crate) enum Sink {
    /// "-".
    Stdout,
    /// Anything else.
    Place(Place),
}

impl Sink {
    /// Writes the result.
    pub(crate) fn write(self, text: &str) -> anyhow::Result<()> {
        match self {
            Self::Stdout => write_stdout(text)?,
            Self::Place(place) => place.write(text)?,
        }
        Ok(())
    }

    /// Writes a result that need not be text: as it is, also to stdout if that is no terminal.
    pub(crate) fn write_bytes(self, bytes: &[u8]) -> anyhow::Result<()> {
        match (self, std::str::from_utf8(bytes)) {
            (Self::Stdout, Ok(text)) => write_stdout(text)?,
            (Self::Stdout, Err(_)) => {
                io::stdout().write_all(bytes)?;
                io::stdout().flush()?;
            }
            (Self::Place(place), _) => place.write(bytes)?,
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
