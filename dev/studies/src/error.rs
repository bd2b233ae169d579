use std::io;
use std::path::PathBuf;

use identify::IdentifyError;

/// What stops a study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// No study of that name.
    #[error("no study {id:?}; there are: {known}")]
    UnknownStudy {
        /// What was asked for.
        id: String,
        /// What there is.
        known: String,
    },
    /// A case could not be diagnosed.
    #[error("{study}, case {case}")]
    Case {
        /// Name of the study.
        study: &'static str,
        /// Number of the case.
        case: u64,
        /// Why.
        #[source]
        source: Box<IdentifyError>,
    },
    /// A case came to a fault of the program; what the fault is has been printed.
    #[error("{study}, case {case}: a fault of the program, printed above")]
    Panicked {
        /// Name of the study.
        study: &'static str,
        /// Number of the case.
        case: u64,
    },
    /// The file of results cannot be read or written.
    #[error("{}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// Another run writes the same file.
    #[error("{}: another run is writing it", path.display())]
    InUse {
        /// Which.
        path: PathBuf,
    },
    /// A whole line of the file is not one of ours.
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
    /// A line is there twice.
    #[error("{}:{line}: {study}, case {case}, is there twice", path.display())]
    Twice {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
        /// Name of the study.
        study: &'static str,
        /// Number of the case.
        case: u64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_case_or_the_file() {
        let study = "single";
        let source = Box::new(IdentifyError::NoRecordings);
        let case = StudyError::Case {
            study,
            case: 3,
            source,
        };
        assert_eq!(case.to_string(), "single, case 3");
        let text = StudyError::Panicked { study, case: 3 }.to_string();
        assert_eq!(
            text,
            "single, case 3: a fault of the program, printed above"
        );
        let source = io::Error::from(io::ErrorKind::NotFound);
        let path = PathBuf::from("single.jsonl");
        let file = StudyError::File { path, source };
        assert_eq!(file.to_string(), "single.jsonl");
    }
}
