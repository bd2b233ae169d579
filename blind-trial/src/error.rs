use std::io;
use std::path::PathBuf;

use identify::IdentifyError;
use recording::RecordingError;
use rig_files::RigFileError;
use truth_plant::TruthError;

use crate::CaseId;

/// Errors that stop a trial, or a case of it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrialError {
    /// No family of that name.
    #[error("no family {id:?}; there are: {known}")]
    UnknownFamily {
        /// Requested name.
        id: String,
        /// Names of all families.
        known: String,
    },
    /// The truth could not be simulated.
    #[error("{case}: the true plant")]
    Truth {
        /// Which case.
        case: CaseId,
        /// Why.
        #[source]
        source: TruthError,
    },
    /// The files of a case could not be read.
    #[error("{case}: the files of the case")]
    Files {
        /// Which case.
        case: CaseId,
        /// Why.
        #[source]
        source: Box<RecordingError>,
    },
    /// The rod file of a case could not be read.
    #[error("{case}: its rod file")]
    RodFile {
        /// Which case.
        case: CaseId,
        /// Why.
        #[source]
        source: Box<RigFileError>,
    },
    /// A case could not be diagnosed.
    #[error("{case}: the diagnosis")]
    Diagnosis {
        /// Which case.
        case: CaseId,
        /// Why.
        #[source]
        source: Box<IdentifyError>,
    },
    /// A case came to a fault of the program; what the fault is has been printed.
    #[error("{case}: a fault of the program, printed above")]
    Panicked {
        /// Which case.
        case: CaseId,
    },
    /// An effect in time cannot be put on it.
    #[error("{recording}: a static loop; effects are put on recordings in time")]
    NoTime {
        /// Name of the recording.
        recording: String,
    },
    /// A file cannot be read or written.
    #[error("{}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// Another run writes the same file.
    #[error("{}: another run is writing it{}", path.display(), owner.map(|id| format!(", process {id}")).unwrap_or_default())]
    InUse {
        /// Which.
        path: PathBuf,
        /// Its process, where the system tells.
        owner: Option<u32>,
    },
    /// A whole line of a file is not one of ours.
    #[error("{}:{line}: not a result", path.display())]
    Line {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
        /// Why.
        #[source]
        source: serde_json::Error,
    },
    /// A line has another content than was written.
    #[error("{}:{line}: was changed since it was written: its hash is that of another line", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
    },
    /// A line is there twice.
    #[error("{}:{line}: {key} is there twice", path.display())]
    Twice {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
        /// Key of the line.
        key: String,
    },
    /// A folder holds results of another trial.
    #[error("{}: holds a trial with {what} {found}, and this one has {expected}; take another folder", path.display())]
    OtherTrial {
        /// The folder's file.
        path: PathBuf,
        /// Property that differs.
        what: &'static str,
        /// Value in the folder.
        found: String,
        /// Requested value.
        expected: String,
    },
    /// An answer is not the one that was sealed.
    #[error("{case}: the answer is not the one that was sealed")]
    BrokenSeal {
        /// Which case.
        case: CaseId,
    },
    /// A case was diagnosed without its answer having been published in a seal.
    #[error("{case}: of no plan whose answers were sealed")]
    NotSealed {
        /// Which case.
        case: CaseId,
    },
    /// The answers of a plan are not those that were published.
    #[error("plan {plan}: its answers have the seal {found}, and {published} was published")]
    OtherAnswers {
        /// Which plan.
        plan: String,
        /// Seal of the answers now.
        found: String,
        /// Seal before the first diagnosis.
        published: String,
    },
}

impl TrialError {
    pub(crate) fn file(path: &std::path::Path, source: io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn diagnosis(case: CaseId) -> impl Fn(IdentifyError) -> Self {
        move |source| Self::Diagnosis {
            case,
            source: Box::new(source),
        }
    }
}
