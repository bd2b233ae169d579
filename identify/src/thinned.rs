//! Fewer samples, to find a basin by.

use recording::{Recording, Sampling};

use crate::IdentifyError;

/// Fewest samples of a recording.
const FEWEST: usize = 50;

/// Shortest time constant that is told, over the distance of samples: what the rod does within such a distance, and a mean over it hides, is 1 %
/// of what it does within a time constant.
const SHORTEST: f64 = 3.0;

/// Recordings with about so many samples together, each the mean of those around it; `None` where there are not many more than that, and
/// of static data, whose turns would be lost.
///
/// # Errors
///
/// As [`Recording::decimated`].
pub fn thinned(
    recordings: &[Recording],
    enough: usize,
) -> Result<Option<Vec<Recording>>, IdentifyError> {
    let n: usize = recordings.iter().map(Recording::len).sum();
    let is_static = |one: &Recording| one.sampling() == Sampling::Untimed;
    if n < 2 * enough || recordings.iter().any(is_static) {
        return Ok(None);
    }
    let few = recordings.iter().map(|one| {
        let every = (n / enough).min(one.len() / FEWEST);
        Ok(match every {
            0..=1 => one.clone(),
            _ => one.decimated(every)?,
        })
    });
    Ok(Some(few.collect::<Result<_, IdentifyError>>()?))
}

/// True if recordings have samples near enough to one another to tell a time constant, s.
#[must_use]
pub fn tell_time_constant(recordings: &[Recording], tau_s: f64) -> bool {
    tau_s > SHORTEST * longest_step_s(recordings.iter())
}

/// True if a time constant, s, that was found on recordings is near that of more samples: within a shorter one than a step nothing is seen
/// of the way to where the rod is at its end.
pub(crate) fn are_near_time_constant<'r>(
    recordings: impl Iterator<Item = &'r Recording>,
    tau_s: f64,
) -> bool {
    tau_s > longest_step_s(recordings)
}

/// The longest of the usual steps of recordings, s.
fn longest_step_s<'r>(recordings: impl Iterator<Item = &'r Recording>) -> f64 {
    let steps = recordings.filter_map(|one| one.sampling().usual_dt_s());
    steps.fold(0.0, f64::max)
}
