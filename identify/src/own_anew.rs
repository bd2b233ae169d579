//! Second search of each recording's own parameters, one recording at a time.

use crate::beginnings::beginnings;
use crate::least_squares::{LeastSquaresConfig, Minimum, SumOfSquares, minimize};
use crate::of_rig::OfRig;
use crate::problem::Problem;
use crate::{IdentifyError, Scope};

/// Times that all is sought together again after something was found.
const ROUNDS: usize = 4;

/// Sum of squares over that before, from which something else was found.
const LOWER: f64 = 0.99;

/// The search of one recording's own parameters ends where it tells whether it came lower: all are sought together after it.
const ALONE: LeastSquaresConfig = LeastSquaresConfig {
    iterations: 40,
    relative_offset: 1e-2,
    least_gain: 0.1 * (1.0 - LOWER),
};

/// The end of a search, or a lower one that is found by seeking the beginning of each recording anew for the rod of that end.
///
/// Beginnings have minima of their own, on either branch of the loop, so that of R recordings there are some 3^R together. Where the
/// rod is known each recording is by itself: 3 R searches of a few parameters see them all.
pub(crate) fn own_anew(
    problem: &Problem<'_>,
    end: Minimum,
    config: &LeastSquaresConfig,
) -> Result<Minimum, IdentifyError> {
    let mut lowest = end;
    for _ in 0..ROUNDS {
        let Some(point) = anew(problem, &lowest)? else {
            break;
        };
        let next = minimize(problem, problem.bounds(), &point, config)?;
        let is_lower = next.sum_of_squares < LOWER * lowest.sum_of_squares;
        if !is_lower {
            break;
        }
        lowest = next;
    }
    Ok(lowest)
}

/// The end with what was found lower for a recording alone; `None` if nothing was.
fn anew(problem: &Problem<'_>, end: &Minimum) -> Result<Option<Vec<f64>>, IdentifyError> {
    let solved = problem.solve_one(&end.point)?;
    let mut values: Vec<Vec<f64>> = (0..problem.n_recordings())
        .map(|r| problem.values(&end.point, &solved, r))
        .collect();
    let mut is_found = false;
    for (r, values) in values.iter_mut().enumerate() {
        let frozen = OfRig::at(problem.model(), values);
        let alone = problem.of_one(&frozen, r, &solved)?;
        let starts = beginnings(&alone)?;
        // Without a beginning that is open there is one minimum.
        if starts.len() < 2 {
            return Ok(None);
        }
        let known = |parameter: usize, _| Some(values[parameter]);
        let before = alone.sums(&[alone.vector().coordinates(known)])?[0];
        let ends = starts
            .iter()
            .map(|start| minimize(&alone, alone.bounds(), start, &ALONE))
            .collect::<Result<Vec<Minimum>, _>>()?;
        let lowest = ends
            .into_iter()
            .min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares));
        // Of one recording: it counts as a part of a simulation of all.
        problem.count(alone.simulations().div_ceil(problem.n_recordings() as u64));
        let Some(lowest) = lowest.filter(|one| one.sum_of_squares < LOWER * before) else {
            continue;
        };
        is_found = true;
        let found = alone.vector().values(&lowest.point, 0);
        let infos = problem.vector().infos();
        for ((value, found), info) in values.iter_mut().zip(found).zip(infos) {
            if info.scope == Scope::PerRecording {
                *value = found;
            }
        }
    }
    let point = problem
        .vector()
        .coordinates(|parameter, r| Some(values[r][parameter]));
    Ok(is_found.then_some(point))
}
