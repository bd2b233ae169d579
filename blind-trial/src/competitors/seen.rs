//! Output of the baseline model for a recording, and its residual.

use identify::{IdentifyError, Prediction, predict};
use missing_physics::Stage;
use recording::Recording;

use crate::verdict::Opened;

/// A recording as the baseline model sees it.
#[derive(Debug)]
pub(super) struct Seen<'a> {
    pub(super) recording: &'a Recording,
    /// Output and temperature of the model.
    pub(super) shown: Prediction,
    /// Recorded - shown output, mm.
    pub(super) residual: Vec<f64>,
}

impl<'a> Seen<'a> {
    fn new(files: &Opened, point: &[f64], recording: &'a Recording) -> Result<Self, IdentifyError> {
        let shown = predict(&files.base, point, recording)?;
        let pairs = recording.output().iter().zip(&shown.output);
        Ok(Self {
            residual: pairs.map(|(recorded, shown)| recorded - shown).collect(),
            recording,
            shown,
        })
    }
}

/// The training recordings where the fit ended.
pub(super) fn training<'a>(
    files: &'a Opened,
    plain: &Stage,
) -> Result<Vec<Seen<'a>>, IdentifyError> {
    let recordings = files.training.iter().enumerate();
    recordings
        .map(|(r, recording)| Seen::new(files, &plain.fit.point(r), recording))
        .collect()
}

/// The unseen recordings as they were validated: each with its own offset.
pub(super) fn unseen<'a>(files: &'a Opened, plain: &Stage) -> Result<Vec<Seen<'a>>, IdentifyError> {
    let pairs = files.unseen.iter().zip(&plain.validated);
    pairs
        .map(|(recording, validated)| Seen::new(files, &validated.point, recording))
        .collect()
}
