//! Where searches of how a recording began set out.

use recording::Recording;

use crate::least_squares::SumOfSquares;
use crate::problem::Problem;
use crate::wiener_model::STARTS;
use crate::{ForwardModel, IdentifyError};

/// Steps of the temperature at the start, from the surroundings to the highest that is reached from there.
const RISES: usize = 8;

/// Places between the limiting curves: on either, and in the middle.
const SHARES: [f64; 3] = [0.0, 0.5, 1.0];

/// Ways since the last reversal over the width of the loop.
const WAYS: [f64; 3] = [-1.0, 0.0, 1.0];

/// Coordinates from which a search of what belongs to a recording is begun, where nothing else of a model is free: of many ways in
/// which the recording may have begun those that lead nearest to it.
///
/// # Errors
///
/// Any error of the model.
pub fn beginnings_of(
    model: &dyn ForwardModel,
    recording: &Recording,
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    beginnings(&Problem::new(model, std::slice::from_ref(recording))?)
}

/// Where a search of what belongs to a recording is begun: of many ways in which it may have begun the nearest one for each place between
/// the limiting curves, since the minima on either side of the loop are several. In the middle of the bounds where it begins at rest;
/// nowhere, if nothing is sought.
pub(crate) fn beginnings(problem: &Problem<'_>) -> Result<Vec<Vec<f64>>, IdentifyError> {
    let vector = problem.vector();
    let middle = problem.middle();
    if middle.is_empty() {
        return Ok(Vec::new());
    }
    let at = |begun: [f64; 3]| {
        vector.coordinates(|parameter, _| {
            let name = vector.infos()[parameter].name;
            STARTS.iter().find_map(|start| {
                let place = start.iter().position(|one| name == one.0)?;
                Some(begun[place])
            })
        })
    };
    let cold = at([0.0, 1.0, 0.0]);
    let is_known = cold == at([1.0, 0.0, 1.0]);
    if is_known {
        return Ok(vec![middle]);
    }
    let [lowest, highest] = problem.reached_degc(std::slice::from_ref(&cold))?[0];
    let width_k = problem
        .branches_degc(&cold)
        .map_or(0.0, |[cooling, heating]| heating - cooling);
    let mut nearest = Vec::new();
    for share in SHARES {
        let rises = (0..=RISES).map(|step| (highest - lowest) * step as f64 / RISES as f64);
        let mut places: Vec<Vec<f64>> = Vec::new();
        for rise_k in rises {
            for way in WAYS {
                let place = at([rise_k, share, way * width_k]);
                if !places.contains(&place) {
                    places.push(place);
                }
            }
        }
        let sums = problem.sums(&places)?;
        let least = sums
            .into_iter()
            .zip(places)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.extend(least.map(|(_, place)| place));
    }
    nearest.dedup();
    Ok(nearest)
}
