use identify::IdentifyError;

use crate::CaseId;

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
    #[error("{case}")]
    Case {
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Study;

    #[test]
    fn errors_name_the_case() {
        let case = CaseId {
            study: Study::Single,
            case: 3,
        };
        let source = Box::new(IdentifyError::NoRecordings);
        let text = StudyError::Case { case, source }.to_string();
        assert_eq!(text, "single, case 3");
        let text = StudyError::Panicked { case }.to_string();
        assert_eq!(
            text,
            "single, case 3: a fault of the program, printed above"
        );
    }
}
