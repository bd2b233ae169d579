use std::borrow::Cow;

use recording::Recording;
use recording::order::rising;

use crate::least_squares::{LeastSquaresConfig, Minimum, minimize};
use crate::moments::Solved;
use crate::problem::Problem;
use crate::tasks::in_parallel;
use crate::{ForwardModel, IdentifyError, Prior, Termination};

/// Where a least-squares search ended, and nothing more: for those who compare many models.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// Coordinates of the end, as [`ParameterVector`](crate::ParameterVector) has them.
    pub coordinates: Vec<f64>,
    /// Values of all parameters in each recording, in the model's order: what [`predict`](crate::predict) takes.
    pub points: Vec<Vec<f64>>,
    /// Σ w (recording - model)² / Σ w over all samples of the output.
    pub mean_square: f64,
    /// Twice the negative logarithm of the likelihood of white noise, but for a constant of the data:
    /// Σ n ln(mean square) over output and temperature.
    pub deviance: f64,
    /// Why the search ended.
    pub termination: Termination,
    /// Simulations of the whole training set.
    pub simulations: u64,
}

/// How a refinement counts what it is fitted to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RefineConfig {
    /// The search.
    pub least_squares: LeastSquaresConfig,
    /// A value for each sample of the output of each recording, if not all count the same: a sample of weight 0
    /// is simulated and left out.
    pub weights: Option<Vec<Vec<f64>>>,
    /// Weight of recorded temperatures against the output, (output unit/K)²; 0 leaves them out.
    pub temperature_weight: f64,
    /// How the priors of parameters count.
    pub prior: Prior,
    /// Iterations after which only the two lowest of several starts go on; 0 takes each to its end.
    pub race_iterations: usize,
}

/// Starts that go on after a race.
const FOLLOWED: usize = 2;

/// Fits a model by least squares alone, from each of the given starts; the end of the lowest deviance counts, with a prior whose
/// error is profiled out of the highest posterior density, and of equal ends the first.
///
/// `starts` are coordinates as [`ParameterVector`](crate::ParameterVector) has them.
///
/// # Errors
///
/// [`IdentifyError::NoRecordings`], [`IdentifyError::StartLength`], [`IdentifyError::NothingFinite`], and what
/// the model refuses.
pub fn refine(
    model: &dyn ForwardModel,
    training: &[Recording],
    starts: &[Vec<f64>],
    config: &RefineConfig,
) -> Result<Refined, IdentifyError> {
    if training.is_empty() {
        return Err(IdentifyError::NoRecordings);
    }
    let mut problem = Problem::new(model, training)?;
    if let Some(weights) = &config.weights {
        problem.weigh_samples(weights.clone());
    }
    let total: f64 = match &config.weights {
        Some(weights) => weights.iter().flatten().sum(),
        None => problem.n_samples() as f64,
    };
    let n_temperatures = match config.temperature_weight {
        weight if weight > 0.0 => problem.n_temperatures() as f64,
        _ => 0.0,
    };
    problem.weigh_temperature(config.temperature_weight);
    if let Some(start) = starts
        .iter()
        .find(|start| start.len() != problem.vector().len())
    {
        return Err(IdentifyError::StartLength {
            found: start.len(),
            expected: problem.vector().len(),
        });
    }
    problem.set_prior(config.prior);
    let starts = raced(&problem, starts, config)?;
    let mut best: Option<(Minimum, Solved, [f64; 2])> = None;
    for (end, solved) in ends(&problem, &starts, &config.least_squares)? {
        let channels = [(total, solved.output), (n_temperatures, solved.temperature)];
        let deviance: f64 = channels
            .into_iter()
            .filter(|(n, _)| *n > 0.0)
            .map(|(n, squares)| n * (squares / n).ln())
            .sum();
        // What is profiled out counts as many samples as are effective.
        let of_prior = match config.prior {
            Prior::Profiled(n) => (total + n_temperatures) / n * problem.of_prior(&end.point),
            _ => 0.0,
        };
        let is_better = |(_, _, [least, of_least]): &(Minimum, Solved, [f64; 2])| {
            deviance + of_prior < least + of_least
        };
        if best.as_ref().is_none_or(is_better) {
            best = Some((end, solved, [deviance, of_prior]));
        }
    }
    let Some((best, solved, [deviance, _])) = best else {
        return Err(IdentifyError::NothingFinite);
    };
    let points = (0..training.len())
        .map(|r| problem.values(&best.point, &solved, r))
        .collect();
    Ok(Refined {
        points,
        mean_square: solved.output / total,
        deviance,
        termination: best.termination,
        simulations: problem.simulations(),
        coordinates: best.point,
    })
}

/// The starts that are worth their way: where the lowest stand after a few iterations.
fn raced<'a>(
    problem: &Problem<'_>,
    starts: &'a [Vec<f64>],
    config: &RefineConfig,
) -> Result<Cow<'a, [Vec<f64>]>, IdentifyError> {
    if config.race_iterations == 0 || starts.len() <= FOLLOWED {
        return Ok(Cow::Borrowed(starts));
    }
    let short = LeastSquaresConfig {
        iterations: config.race_iterations,
        ..config.least_squares
    };
    let mut ends = ends(problem, starts, &short)?;
    rising(&mut ends, |(end, _)| end.sum_of_squares);
    ends.truncate(FOLLOWED);
    let ends = ends.into_iter().map(|(end, _)| end.point);
    Ok(Cow::Owned(ends.collect()))
}

/// Where a search ends from each start that leads anywhere. Each has a problem of its own, so that what one has solved is nothing to the others.
pub(crate) fn ends(
    problem: &Problem<'_>,
    starts: &[Vec<f64>],
    config: &LeastSquaresConfig,
) -> Result<Vec<(Minimum, Solved)>, IdentifyError> {
    let ends = in_parallel(starts, |start| {
        let own = problem.apart();
        let end = minimize(&own, own.bounds(), start, config)?;
        let is_finite = end.sum_of_squares.is_finite();
        let solved = is_finite.then(|| own.solve_one(&end.point)).transpose()?;
        problem.count(own.simulations());
        Ok(solved.map(|solved| (end, solved)))
    });
    ends.into_iter().filter_map(Result::transpose).collect()
}
