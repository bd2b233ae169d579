use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use truth_plant::{DriveProfile, Traces};

use crate::answer::hex;
use crate::case::{Case, Recorded};
use crate::known::drive_column;
use crate::{CaseId, TrialError};

/// What is known of a rig.
const ROD: &str = "rod.toml";
/// The recordings.
const RECORDINGS: [&str; 2] = ["train.csv", "held.csv"];
/// The recording of a run that was recommended.
const NEXT: &str = "next.csv";

/// A case as its user has it: a folder with a rod file and two recordings, and nothing else.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Folder {
    pub(crate) case: CaseId,
    path: PathBuf,
}

impl Folder {
    /// Writes a case.
    pub(crate) fn write(path: &Path, case: &Case, recorded: &Recorded) -> Result<Self, TrialError> {
        let folder = Self {
            case: case.id,
            path: path.to_owned(),
        };
        let largest_drive = case.drives[0].drive.iter().copied().fold(0.0, f64::max);
        let traces = [&recorded.train, &recorded.held];
        folder.put(ROD, &case.known.rod_file(&case.truth, largest_drive))?;
        for ((name, traces), profile) in RECORDINGS.iter().zip(traces).zip(&case.drives) {
            folder.put(name, &table(case, traces, profile))?;
        }
        Ok(folder)
    }

    /// Adds the recording of another run.
    pub(crate) fn add_next(
        &self,
        case: &Case,
        traces: &Traces,
        profile: &DriveProfile,
    ) -> Result<(), TrialError> {
        self.put(NEXT, &table(case, traces, profile))
    }

    pub(crate) fn rod(&self) -> PathBuf {
        self.path.join(ROD)
    }

    /// The training recording and the unseen one.
    pub(crate) fn recordings(&self) -> [PathBuf; 2] {
        RECORDINGS.map(|name| self.path.join(name))
    }

    pub(crate) fn next(&self) -> PathBuf {
        self.path.join(NEXT)
    }

    /// SHA-256 of the files that are diagnosed, one after the other.
    pub(crate) fn digest(&self) -> Result<String, TrialError> {
        let mut digest = Sha256::new();
        for path in std::iter::once(self.rod()).chain(self.recordings()) {
            let bytes = fs::read(&path).map_err(|source| TrialError::file(&path, source))?;
            digest.update(bytes);
        }
        Ok(hex(&digest.finalize()))
    }

    fn put(&self, name: &str, text: &str) -> Result<(), TrialError> {
        let path = self.path.join(name);
        fs::write(&path, text).map_err(|source| TrialError::file(&path, source))
    }
}

/// A recording as CSV.
fn table(case: &Case, traces: &Traces, profile: &DriveProfile) -> String {
    let mut text = format!("time_s,{},displacement_mm", drive_column(&case.truth.drive));
    if case.known.temperature {
        text += ",temperature_degc";
    }
    if case.known.ambient {
        text += ",ambient_degc";
    }
    text.push('\n');
    for k in 0..profile.drive.len() {
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "{:.3},{:.6},{:.6}",
            k as f64 * profile.dt_s,
            profile.drive[k],
            traces.displacement_mm[k]
        );
        if case.known.temperature {
            let _ = write!(text, ",{:.3}", traces.thermocouple_degc[k]);
        }
        if case.known.ambient {
            let _ = write!(text, ",{:.3}", traces.ambient_degc[k]);
        }
        text.push('\n');
    }
    text
}
