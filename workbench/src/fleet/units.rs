//! The folder in which results of units are kept.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use recording::read_text;

use super::{FleetError, Unit};
use crate::WorkbenchError;

/// Name of the folder in that of the results.
const FOLDER: &str = "units";

/// Most bytes of a unit: far more than any document of a diagnosis has.
const MOST_BYTES: u64 = 1 << 28;

/// Kept results, a file each, named by the hash of its task.
#[derive(Debug, Clone)]
pub struct Units {
    folder: PathBuf,
}

/// Reasons why a file is no result of the unit it is named after.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UnitFault {
    /// The file cannot be read.
    #[error("{}: cannot be read", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is not JSON of a unit.
    #[error("{}:{}: no result of a unit", path.display(), source.line())]
    Document {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// The content is that of another unit.
    #[error("{}: holds the result of another unit, or of another version of the document", path.display())]
    Other {
        /// The file.
        path: PathBuf,
    },
}

impl Units {
    /// Those of a folder for results; both folders are made.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Make`].
    pub fn make(out: &Path) -> Result<Self, WorkbenchError> {
        let folder = out.join(FOLDER);
        fs::create_dir_all(&folder).map_err(|source| WorkbenchError::Make {
            path: folder.clone(),
            source,
        })?;
        Ok(Self { folder })
    }

    /// Those of a folder for results that need not be there.
    #[must_use]
    pub fn at(out: &Path) -> Self {
        let folder = out.join(FOLDER);
        Self { folder }
    }

    /// Those of another call, which must be there.
    ///
    /// # Errors
    ///
    /// [`FleetError::NoResults`].
    pub fn of(out: &Path) -> Result<Self, FleetError> {
        let folder = out.join(FOLDER);
        match fs::read_dir(&folder) {
            Ok(_) => Ok(Self { folder }),
            Err(source) => Err(FleetError::NoResults {
                path: folder,
                source,
            }),
        }
    }

    /// True for a folder of results: it has the file of a unit.
    pub(super) fn are_in(out: &Path) -> bool {
        let is_hash = |name: &str| name.len() == 64 && name.chars().all(|c| c.is_ascii_hexdigit());
        Self::of(out).is_ok_and(|units| {
            let names = units.names().unwrap_or_default();
            names.iter().any(|name| is_hash(name))
        })
    }

    /// Names of the units that have a file, in the order of their bytes.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Read`].
    pub fn names(&self) -> Result<Vec<String>, WorkbenchError> {
        let unreadable = |source| WorkbenchError::Read {
            path: self.folder.clone(),
            source,
        };
        let mut names = Vec::new();
        for entry in fs::read_dir(&self.folder).map_err(unreadable)? {
            let name = entry.map_err(unreadable)?.file_name();
            let name = name.to_str().and_then(|name| name.strip_suffix(".json"));
            names.extend(name.map(str::to_owned));
        }
        names.sort();
        Ok(names)
    }

    /// The result of a unit; `None` if it has no file.
    ///
    /// # Errors
    ///
    /// [`UnitFault`].
    pub fn read(&self, name: &str) -> Result<Option<Unit>, UnitFault> {
        let path = self.path(name);
        let text = match read_text(&path, MOST_BYTES) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(UnitFault::Unreadable { path, source }),
        };
        let unit: Unit = match serde_json::from_str(&text) {
            Ok(unit) => unit,
            Err(source) => return Err(UnitFault::Document { path, source }),
        };
        if unit.is_known() && unit.task.name() == name {
            Ok(Some(unit))
        } else {
            Err(UnitFault::Other { path })
        }
    }

    /// Keeps a result under its name, at once: it is written in a folder of the caller on the same disk, then renamed.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Write`].
    pub fn keep(&self, unit: &Unit, beside: &Path) -> Result<(), WorkbenchError> {
        let name = unit.task.name();
        let path = self.path(&name);
        let temporary = beside.join(format!("{name}.json"));
        let written = serde_json::to_string_pretty(unit)
            .map_err(io::Error::from)
            .and_then(|text| {
                let mut file = fs::File::create(&temporary)?;
                io::Write::write_all(&mut file, (text + "\n").as_bytes())?;
                file.sync_all()?;
                fs::rename(&temporary, &path)
            });
        written.map_err(|source| WorkbenchError::Write { path, source })
    }

    /// Takes in the results of another folder; a result goes before a failure. Returns notes on files that are no results, and on
    /// results of another build than that of the SHA-256 `program`, which count in no table of this one.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Read`], [`WorkbenchError::Write`].
    pub fn take(
        &self,
        other: &Self,
        beside: &Path,
        program: &str,
    ) -> Result<Vec<String>, WorkbenchError> {
        let mut notes = Vec::new();
        let mut n_of_others = 0;
        for name in other.names()? {
            let has_result = matches!(self.read(&name), Ok(Some(own)) if own.failure.is_none());
            if has_result {
                continue;
            }
            match other.read(&name) {
                Ok(Some(unit)) => {
                    n_of_others += usize::from(unit.task.program != program);
                    self.keep(&unit, beside)?;
                }
                Ok(None) => {}
                Err(fault) => notes.push(format!("{fault}; it does not count")),
            }
        }
        if n_of_others > 0 {
            notes.push(format!(
                "{}: results of another build of the program: {n_of_others}; they do not count here",
                other.folder.display()
            ));
        }
        Ok(notes)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name).with_extension("json")
    }
}
