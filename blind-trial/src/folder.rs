use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use truth_plant::Traces;

use crate::answer::hex;
use crate::case::{Case, Recorded};
use crate::known::drive_column;
use crate::runs::Run;
use crate::{CaseId, TrialError};

/// Rod file: the known data of a rig.
const ROD: &str = "rod.toml";
/// The unseen recording.
const UNSEEN: &str = "held.csv";
/// The recording of a run that was recommended.
const NEXT: &str = "next.csv";

/// A case as its user has it: a folder with a rod file and the recordings, and nothing else.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Folder {
    pub(crate) case: CaseId,
    path: PathBuf,
    n_training: usize,
}

impl Folder {
    /// Writes a case.
    pub(crate) fn write(path: &Path, case: &Case, recorded: &Recorded) -> Result<Self, TrialError> {
        let folder = Self {
            case: case.id,
            path: path.to_owned(),
            n_training: case.runs.training.len(),
        };
        let largest_drive = case.runs.largest_drive();
        folder.put(ROD, &case.known.rod_file(&case.truth, largest_drive))?;
        let training = recorded.training.iter().zip(&case.runs.training);
        for (k, (traces, run)) in training.enumerate() {
            folder.put(&folder.training_name(k), &table(case, traces, run))?;
        }
        let unseen = table(case, &recorded.unseen, &case.runs.unseen);
        folder.put(UNSEEN, &unseen)?;
        Ok(folder)
    }

    /// Adds the recording of another run.
    pub(crate) fn add_next(
        &self,
        case: &Case,
        traces: &Traces,
        run: &Run,
    ) -> Result<(), TrialError> {
        self.put(NEXT, &table(case, traces, run))
    }

    pub(crate) fn rod(&self) -> PathBuf {
        self.path.join(ROD)
    }

    /// The training recordings.
    pub(crate) fn training(&self) -> Vec<PathBuf> {
        let names = (0..self.n_training).map(|k| self.training_name(k));
        names.map(|name| self.path.join(name)).collect()
    }

    pub(crate) fn unseen(&self) -> PathBuf {
        self.path.join(UNSEEN)
    }

    fn training_name(&self, k: usize) -> String {
        match self.n_training {
            1 => "train.csv".to_owned(),
            _ => format!("train_{}.csv", k + 1),
        }
    }

    pub(crate) fn next(&self) -> PathBuf {
        self.path.join(NEXT)
    }

    /// SHA-256 of the files that are diagnosed, one after the other.
    pub(crate) fn digest(&self) -> Result<String, TrialError> {
        let mut digest = Sha256::new();
        let recordings = self.training().into_iter().chain([self.unseen()]);
        for path in std::iter::once(self.rod()).chain(recordings) {
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
fn table(case: &Case, traces: &Traces, run: &Run) -> String {
    let mut text = format!("time_s,{},displacement_mm", drive_column(&case.truth.drive));
    if case.known.temperature {
        text += ",temperature_degc";
    }
    if case.known.ambient {
        text += ",ambient_degc";
    }
    text.push('\n');
    for k in 0..traces.drive.len() {
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "{:.3},{:.6},{:.6}",
            k as f64 * run.profile.dt_s,
            traces.drive[k],
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
