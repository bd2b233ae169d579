//! Swarm for the basin, least squares for the floor.

use std::ops::ControlFlow;

use pso::Bound;
use recording::Recording;
use recording::order::rising;

use crate::ended::{AS_LOW, is_one};
use crate::fit_config::{FitConfig, Loss};
use crate::fitted::{fitted_parameters, parameter_covariance};
use crate::identifiability::unfixed_directions;
use crate::least_squares::{Minimum, SumOfSquares, minimize};
use crate::problem::{Problem, Residuals};
use crate::reach::{NEAR, WithinReach, beyond_reach, held_within};
use crate::start::{Begun, Places, Start, ladder};
use crate::tasks::try_in_parallel;
use crate::uncertainty::covariance;
use crate::{
    EndedStart, FINEST_THERMOMETER_K, Fit, FittedParameter, ForwardModel, IdentifyError,
    TrainedRecording,
};

/// How far a fit is.
#[derive(Debug, Clone, PartialEq)]
pub struct FitProgress {
    /// Starts done.
    pub starts: u64,
    /// Starts to be made.
    pub of: u64,
    /// Lowest root mean square so far, in the output unit.
    pub lowest_rmse: f64,
    /// Where the last of them ended: for [`FitConfig::ended`], if the fit is interrupted.
    pub ended: EndedStart,
}

/// Fits a model to several recordings together.
///
/// The cost is the mean squared error over all samples (Sadeghi, section 4). Each start runs a short
/// swarm and polishes its best point by bounded least squares; the lowest end is the fit. `progress` is
/// told after each start how far it is, and may end the search with the starts made so far.
///
/// Same seed and inputs, same bytes, on any number of threads.
///
/// # Errors
///
/// [`IdentifyError::NothingFree`], [`IdentifyError::NoRecordings`], [`IdentifyError::StartLength`], [`IdentifyError::Swarm`] for
/// settings that the swarm refuses, and what the model refuses.
pub fn fit(
    model: &dyn ForwardModel,
    training: &[Recording],
    config: &FitConfig,
    progress: &mut dyn FnMut(&FitProgress) -> ControlFlow<()>,
) -> Result<Fit, IdentifyError> {
    if training.is_empty() {
        return Err(IdentifyError::NoRecordings);
    }
    for recording in training {
        recording.check_identifiable()?;
    }
    let mut problem = Problem::new(model, training)?;
    if problem.vector().is_empty() {
        return Err(IdentifyError::NothingFree);
    }
    weigh(&mut problem, training, config);
    let swarms = config.starts.max(u64::from(config.from.is_empty()));
    let few = match (swarms, config.least_squares.iterations) {
        // Only swarms begin on them, and one that nothing follows, as in the paper, sees all.
        (0, _) | (_, 0) => Vec::new(),
        _ => ladder(training)?,
    };
    let rungs = few
        .iter()
        .map(|few| {
            let mut problem = Problem::new(model, few)?;
            weigh(&mut problem, few, config);
            Ok(problem)
        })
        .collect::<Result<Vec<_>, IdentifyError>>()?;
    let n = problem.n_samples() as f64;
    let mut search = Search::default();
    let mut places = Places::default();
    let points = config.from.iter().map(|point| Start::Point(point));
    let starts: Vec<(u64, Start<'_>)> = (0..)
        .zip(points.chain((0..swarms).map(Start::Swarm)))
        .collect();
    // Starts that take longer than others should not leave threads idle.
    'all: for group in starts.chunks(2 * rayon::current_num_threads()) {
        let begun = try_in_parallel(group, |&(number, start)| {
            let is_it = |ended: &&EndedStart| {
                (ended.seed, ended.start) == (config.seed, number)
                    && ended.minimum.point.len() == problem.vector().len()
            };
            // A file may have been changed, and have starts of a search on fewer samples: one whose cost is not that of its point is made
            // again.
            for known in config.ended.iter().filter(is_it) {
                if is_of(&problem, &known.minimum)? {
                    return Ok((number, Begun::Ended(known.clone())));
                }
            }
            Ok((number, start.begun(&problem, &rungs, config)?))
        })?;
        let ended = places.complete(&begun, &problem, config)?;
        for ((_, start), ended) in group.iter().zip(ended) {
            search.take(*start, &ended);
            let so_far = FitProgress {
                starts: search.ends.len() as u64,
                of: starts.len() as u64,
                lowest_rmse: (search.lowest() / n).sqrt(),
                ended,
            };
            let is_enough = config.until_agreed && search.has_one_minimum(problem.rounding());
            let is_over = progress(&so_far).is_break() || is_enough;
            if is_over && matches!(start, Start::Swarm(_)) {
                break 'all;
            }
        }
    }
    problem.count(search.simulations);
    if search.lowest().is_infinite() {
        return Err(IdentifyError::NothingFinite);
    }
    let starts = search.ends.len() as u64;
    let mut agreeing_starts = search.agreeing(problem.rounding()) as u64;
    // Before weights change it: the outputs' own spread.
    let spread = problem.spread();
    rising(&mut search.ends, |end| end.sum_of_squares);
    let held = held_within(&problem, &search.ends, &config.least_squares)?;
    let is_pressed = held.as_ref().is_some_and(|held| held.is_pressed);
    let mut minima = distinct(&search.ends, problem.bounds());
    let mut minimum = minima.remove(0);
    if let Some(held) = held {
        minima.insert(0, std::mem::replace(&mut minimum, held.minimum));
        agreeing_starts = held.agreeing;
    }
    let others: Vec<Vec<f64>> = minima.into_iter().map(|other| other.point).collect();
    let other_minima = problem
        .solve(&others)?
        .iter()
        .zip(&others)
        .map(|(solved, point)| {
            let recordings = 0..training.len();
            recordings
                .map(|r| problem.values(point, solved, r))
                .collect()
        })
        .collect();
    let minimum = reweighed(&mut problem, minimum, is_pressed, config)?;
    let beyond = beyond_reach(&problem, &minimum.point)?;
    let solved = problem.solve_one(&minimum.point)?;
    let residuals = problem.residuals(&minimum.point, &solved)?;
    let covariance = covariance(&problem, &minimum.point, &solved, &residuals)?;
    let sum: f64 = residuals
        .iter()
        .flat_map(|one| &one.values)
        .map(|value| value * value)
        .sum();
    let n_parameters = covariance.columns.len() as f64;
    // Twice the negative logarithm of the likelihood, but for a constant of the data.
    let deviance = n * covariance.noise.innovation_variance.ln();
    let n_temperatures = problem.n_temperatures();
    let mut parameters = fitted_parameters(&problem, &minimum.point, &solved, &covariance);
    if !beyond.is_empty() {
        leave_unfixed(&mut parameters);
    }
    Ok(Fit {
        parameters,
        beyond_reach: beyond,
        train_rmse: (sum / n).sqrt(),
        temperature_rmse_k: (n_temperatures > 0)
            .then(|| (solved.temperature / n_temperatures as f64).sqrt()),
        fit_fraction: 1.0 - (sum / spread).sqrt(),
        recordings: training
            .iter()
            .zip(&residuals)
            .map(|(recording, residuals)| TrainedRecording {
                name: recording.name().to_owned(),
                rmse: root_mean_square(&residuals.values),
                peak_temperature_degc: residuals.peak_temperature_degc,
                n_samples: recording.len(),
                output_range: range(recording.output()),
            })
            .collect(),
        aic: deviance + 2.0 * n_parameters,
        bic: deviance + n.ln() * n_parameters,
        covariance: parameter_covariance(&problem, &covariance),
        unfixed: unfixed_directions(&problem, &minimum.point, &covariance),
        noise: covariance.noise,
        termination: minimum.termination,
        agreeing_starts,
        starts,
        other_minima,
        simulations: problem.simulations(),
        rejected_costs: search.rejected_costs,
        loss: config.loss,
        seed: config.seed,
        output_unit: training[0].output_unit().to_owned(),
        drive_quantity: training[0].drive_quantity(),
        drive_unit: training[0].drive_unit().to_owned(),
    })
}

/// True if a minimum that was kept has the cost of its point, to rounding, and lies within the bounds.
fn is_of(problem: &Problem<'_>, minimum: &Minimum) -> Result<bool, IdentifyError> {
    let inside = |(value, bound): (&f64, &Bound)| (bound.lower..=bound.upper).contains(value);
    if !minimum.point.iter().zip(problem.bounds()).all(inside) {
        return Ok(false);
    }
    let own = problem.apart();
    let sums = own.sums(std::slice::from_ref(&minimum.point))?;
    let away = (sums[0] - minimum.sum_of_squares).abs();
    Ok(away <= KEPT * sums[0].abs() + own.rounding())
}

/// Share by which the cost of a start that was kept may differ from that of its point.
const KEPT: f64 = 1e-6;

/// Twice the logarithm of odds, and so a difference of Schwarz's criterion, that is very strong evidence [KassRaftery1995].
pub(crate) const VERY_STRONG: f64 = 10.0;

/// The least-squares searches so far.
#[derive(Debug, Default)]
struct Search {
    /// Where each start ended.
    ends: Vec<Minimum>,
    /// Those of them that began with a swarm.
    swarms: usize,
    rejected_costs: u64,
    simulations: u64,
}

/// Starts that all end at one minimum after which another is not to be expected.
///
/// Of w minima that n independent starts have found, w (n - 1)/(n - w - 2) are to be expected in all [BoenderRinnooyKan1987]. That rounds to one
/// from n = 8 on.
const ALL_AT_ONE: usize = 8;

impl Search {
    fn take(&mut self, start: Start<'_>, ended: &EndedStart) {
        self.swarms += usize::from(matches!(start, Start::Swarm(_)));
        self.rejected_costs += ended.rejected_costs;
        self.simulations += ended.simulations;
        self.ends.push(ended.minimum.clone());
    }

    /// Starts that end as low as the lowest, where sums of squares are told to `rounding`.
    fn agreeing(&self, rounding: f64) -> usize {
        let agreed = AS_LOW * self.lowest() + rounding;
        let ends = self.ends.iter();
        ends.filter(|end| end.sum_of_squares <= agreed).count()
    }

    /// True if so many swarms led to one minimum that another is not to be expected.
    fn has_one_minimum(&self, rounding: f64) -> bool {
        self.swarms >= ALL_AT_ONE && self.agreeing(rounding) == self.ends.len()
    }

    fn lowest(&self) -> f64 {
        let ends = self.ends.iter().map(|end| end.sum_of_squares);
        ends.fold(f64::INFINITY, f64::min)
    }
}

/// Minima that are not one another's, of ends in the order of their height: the lowest, and what is near it in height
/// but not in place.
pub(crate) fn distinct(ends: &[Minimum], bounds: &[Bound]) -> Vec<Minimum> {
    let mut minima: Vec<Minimum> = Vec::new();
    for end in ends {
        let is_near = minima
            .first()
            .is_none_or(|lowest| end.sum_of_squares <= NEAR * lowest.sum_of_squares);
        if is_near
            && !minima
                .iter()
                .any(|known| is_one(&known.point, &end.point, bounds))
        {
            minima.push(end.clone());
        }
    }
    minima
}

/// Takes the intervals off what the place of a branch tells that no recording has seen.
fn leave_unfixed(parameters: &mut [FittedParameter]) {
    let placed = ["loop_center", "loop_half_width"];
    for parameter in parameters {
        if placed
            .iter()
            .any(|name| parameter.info.name.starts_with(name))
        {
            parameter.intervals.fill(None);
        }
    }
}

/// Weighs temperatures by how well they are met, and outliers by Huber, until the point stays, or until a round gains too little to go on
/// for. The loop of one that is pressed is held within reach, at a cost that goes with the sum of squares so weighed.
fn reweighed(
    problem: &mut Problem<'_>,
    mut minimum: Minimum,
    is_pressed: bool,
    config: &FitConfig,
) -> Result<Minimum, IdentifyError> {
    /// Weights converge linearly; with many outliers it takes tens of rounds, each from close by.
    const ROUNDS: usize = 60;
    let temperatures = problem.n_temperatures();
    if temperatures == 0 && config.loss == Loss::Squares {
        return Ok(minimum);
    }
    for _ in 0..ROUNDS {
        let before = minimum.point;
        let solved = problem.solve_one(&before)?;
        if temperatures > 0 {
            let output = solved.output / problem.n_samples() as f64;
            let square_k2 = solved.temperature / temperatures as f64;
            problem.weigh_temperature(output / square_k2.max(FINEST_THERMOMETER_K.powi(2)));
        }
        if config.loss == Loss::Huber {
            problem.weigh_samples(huber_weights(&problem.residuals(&before, &solved)?));
        }
        let held = if is_pressed {
            let lowest = problem.sums(std::slice::from_ref(&before))?[0];
            WithinReach::held(problem, lowest)
        } else {
            WithinReach::free(problem)
        };
        minimum = minimize(&held, problem.bounds(), &before, &config.least_squares)?;
        let least_gain = config.least_squares.least_gain;
        if least_gain > 0.0 {
            let sum_before = held.sums(std::slice::from_ref(&before))?[0];
            if sum_before - minimum.sum_of_squares < least_gain * sum_before {
                break;
            }
        }
        let mut moves = before.iter().zip(&minimum.point).zip(problem.bounds());
        if moves.all(|((a, b), bound)| (a - b).abs() <= 1e-7 * (bound.upper - bound.lower)) {
            break;
        }
    }
    Ok(minimum)
}

/// Weights of Huber's loss: 1 up to 1.345 robust standard deviations (95 % efficiency on normal noise,
/// Huber1981 in REFERENCES.md), and falling as 1/|residual| beyond.
pub(crate) fn huber_weights(residuals: &[Residuals]) -> Vec<Vec<f64>> {
    const KNEE: f64 = 1.345;
    /// Standard deviation over median absolute deviation of a normal distribution.
    const NORMAL: f64 = 1.4826;
    let mut sizes: Vec<f64> = residuals
        .iter()
        .flat_map(|one| &one.values)
        .map(|value| value.abs())
        .collect();
    sizes.sort_by(f64::total_cmp);
    let scale = NORMAL * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    let weight = |residual: &f64| {
        if scale > 0.0 {
            (KNEE * scale / residual.abs()).min(1.0)
        } else {
            1.0
        }
    };
    residuals
        .iter()
        .map(|one| one.values.iter().map(weight).collect())
        .collect()
}

/// Weighs temperatures and priors as a search begins.
fn weigh(problem: &mut Problem<'_>, training: &[Recording], config: &FitConfig) {
    let weight = config.temperature_weight;
    problem.weigh_temperature(weight.unwrap_or_else(|| equal_spreads(problem, training)));
    problem.set_prior(config.prior);
}

/// Weight of temperatures before it is known how well they can be met: that of equal spreads.
fn equal_spreads(problem: &Problem<'_>, training: &[Recording]) -> f64 {
    let n = problem.n_temperatures();
    if n == 0 {
        return 0.0;
    }
    let spread: f64 = training
        .iter()
        .filter_map(Recording::temperature_degc)
        .map(squares_about_own_mean)
        .sum();
    let output = problem.spread() / problem.n_samples() as f64;
    if spread > 0.0 {
        output / (spread / n as f64)
    } else {
        0.0
    }
}

pub(crate) fn range(values: &[f64]) -> f64 {
    let ends = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |ends, &value| {
            (value.min(ends.0), value.max(ends.1))
        });
    ends.1 - ends.0
}

pub(crate) fn squares_about_own_mean(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| (value - mean).powi(2)).sum()
}

pub(crate) fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}
