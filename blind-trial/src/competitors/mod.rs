//! Competitors on the files of a case: methods in use, run on the same recordings and the same plain fit.

mod black_box;
mod forward;
mod ridge;
mod seen;
mod whiteness;

use identify::IdentifyError;
use missing_physics::{Diagnosis, Stage};
use serde::{Deserialize, Serialize};

use crate::verdict::Opened;
use crate::{CaseId, TrialError};

pub use forward::Forward;
pub use whiteness::Whiteness;

/// Results of the competitors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Competitors {
    /// Residual analysis, which names nothing.
    pub whiteness: Whiteness,
    /// Effects by forward selection.
    pub forward: Forward,
    /// Error on the unseen recording of the baseline model corrected by a black box, mm: root mean square of
    ///
    /// ```text
    /// y - f(θ) - g(x),   x what the baseline model shows, g a polynomial fitted to the training residual
    /// ```
    ///
    /// `None` without an unseen recording.
    pub black_box_unseen_mm: Option<f64>,
}

/// Runs all of them.
///
/// They see the training recordings, and the unseen ones for their errors only. Those that choose from a catalogue choose
/// from that of `files.config`. Same inputs, same bytes, on any number of threads.
pub(crate) fn compete(
    case: CaseId,
    files: &Opened,
    diagnosis: &Diagnosis,
) -> Result<Competitors, TrialError> {
    competed(files, &diagnosis.baseline).map_err(TrialError::diagnosis(case))
}

fn competed(files: &Opened, plain: &Stage) -> Result<Competitors, IdentifyError> {
    let training = seen::training(files, plain)?;
    Ok(Competitors {
        whiteness: whiteness::whiteness(&training),
        forward: forward::forward(files, &plain.fit)?,
        black_box_unseen_mm: black_box::unseen_mm(files, plain, &training)?,
    })
}

#[cfg(test)]
mod synthetic;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Family;

    #[test]
    fn same_files_same_bytes_on_any_number_of_threads() {
        let (files, plain) = synthetic::opened(Family::Single, 7);
        let said = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let competed = || competed(&files, &plain).unwrap();
            serde_json::to_string(&pool.build().unwrap().install(competed)).unwrap()
        };
        let one = said(1);
        assert_eq!(one, said(3));
        let read: Competitors = serde_json::from_str(&one).unwrap();
        assert_eq!(serde_json::to_string(&read).unwrap(), one);
    }
}
