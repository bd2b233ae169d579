//! Fewer samples, to find a basin by.

use recording::{Recording, Sampling};

use crate::least_squares::{LeastSquaresConfig, Minimum, minimize};
use crate::own_anew::own_anew;
use crate::problem::Problem;
use crate::{IdentifyError, ParameterVector};

/// Samples of all recordings together from which a basin is found as well as from more.
const ENOUGH: usize = 2_000;

/// Shortest time constant that is told, over the distance of samples: what the rod does within such a distance, and a mean over it hides, is 1 %
/// of what it does within a time constant.
const SHORTEST: f64 = 3.0;

/// The search on them is no longer than this: another one follows on all samples.
const NEAR: LeastSquaresConfig = LeastSquaresConfig {
    iterations: 40,
    relative_offset: 1e-3,
    least_gain: 1e-4,
};

/// Each recording with every so many rows, and the means of those around; `None` where there are no more than are needed, and
/// of static data, whose turns would be lost.
pub(crate) fn thinned(training: &[Recording]) -> Result<Option<Vec<Recording>>, IdentifyError> {
    let n: usize = training.iter().map(Recording::len).sum();
    let every = n / ENOUGH;
    let is_static = |one: &Recording| one.sampling() == Sampling::Untimed;
    if every < 2 || training.iter().any(is_static) {
        return Ok(None);
    }
    let few = training.iter().map(|one| match one.len() / every {
        0..=1 => Ok(one.clone()),
        _ => one.decimated(every),
    });
    Ok(Some(few.collect::<Result<_, _>>()?))
}

/// True if recordings have samples near enough to one another to tell a time constant, s.
#[must_use]
pub fn tell_time_constant(recordings: &[Recording], tau_s: f64) -> bool {
    let steps = recordings
        .iter()
        .filter_map(|one| one.sampling().usual_dt_s());
    tau_s > SHORTEST * steps.fold(0.0, f64::max)
}

/// Where a search on thinned recordings ends; `None` where its time constant is too short for what they have.
pub(crate) fn basin(
    few: &Problem<'_>,
    recordings: &[Recording],
    start: &[f64],
) -> Result<Option<Vec<f64>>, IdentifyError> {
    let end: Minimum = minimize(few, few.bounds(), start, &NEAR)?;
    let end = own_anew(few, end, &NEAR)?;
    let tau_s = tau_s(few.vector(), &end.point);
    let is_told = tau_s.is_none_or(|tau_s| tell_time_constant(recordings, tau_s));
    Ok(is_told.then_some(end.point))
}

fn tau_s(vector: &ParameterVector, point: &[f64]) -> Option<f64> {
    let mut infos = vector.infos().iter();
    let place = infos.position(|info| info.name == "tau_s")?;
    Some(vector.values(point, 0)[place])
}
