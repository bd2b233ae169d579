//! The rigs of a fleet, and which files each consists of.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::{FleetError, folder, manifest};

/// Rigs in the order of their result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fleet {
    /// The rigs.
    pub rigs: Vec<Listed>,
    /// Files that were left out, a sentence each.
    pub left_out: Vec<String>,
}

/// A rig of a fleet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Name of the rig: its path within the folder, or its name in the manifest.
    pub name: String,
    /// Its files, or the reason why they do not make a rig.
    pub files: Result<RigFiles, String>,
    /// True if the reason is a folder that cannot be read now: it may hold a rig.
    pub is_unread: bool,
}

/// Files of a rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigFiles {
    /// The rod file.
    pub rod: PathBuf,
    /// Recordings that decide; one at least.
    pub train: Vec<PathBuf>,
    /// Unseen recordings.
    pub validate: Vec<PathBuf>,
}

impl Fleet {
    /// Finds the rigs of a folder, but for what lies in `without`, or reads those of a manifest (`.csv`, `.toml`).
    ///
    /// In a folder with `train*.csv` these are the training recordings of one rig, and `validate*.csv`, `held*.csv` and
    /// `unseen*.csv` its unseen ones. In any other folder each `*.csv` is a rig of its own. The rod file is `rod.toml` in the
    /// same folder, or else in the nearest one above, up to the folder that was given. Names that begin with a dot do not
    /// count. Rigs are ordered by the bytes of their names.
    ///
    /// # Errors
    ///
    /// [`FleetError`]. A rig that lacks a file is listed with the reason.
    pub fn read(place: &Path, without: &[&Path]) -> Result<Self, FleetError> {
        let is_named = |ending: &str| {
            let extension = place.extension().and_then(OsStr::to_str);
            extension.is_some_and(|own| own.eq_ignore_ascii_case(ending))
        };
        if place.is_dir() {
            folder::read(place, without)
        } else if is_named("csv") {
            manifest::read_csv(place)
        } else if is_named("toml") {
            manifest::read_toml(place)
        } else if place.exists() {
            let path = place.to_owned();
            Err(FleetError::NotManifest { path })
        } else {
            Err(FleetError::Unreadable {
                path: place.to_owned(),
                source: std::io::ErrorKind::NotFound.into(),
            })
        }
    }
}

impl RigFiles {
    /// All files.
    pub fn all(&self) -> impl Iterator<Item = &Path> {
        let recordings = self.train.iter().chain(&self.validate);
        std::iter::once(&self.rod)
            .chain(recordings)
            .map(PathBuf::as_path)
    }
}
