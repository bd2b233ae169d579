//! Swarm for the basin, least squares for the floor.

use std::ops::ControlFlow;

use pso::{Stop, Swarm, SwarmConfig};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use recording::Recording;

use crate::fitted::{fitted_parameters, parameter_covariance};
use crate::identifiability::unfixed_directions;
use crate::least_squares::{LeastSquaresConfig, Minimum, SumOfSquares, minimize};
use crate::moments::BATCH;
use crate::problem::{Problem, Residuals};
use crate::uncertainty::covariance;
use crate::{Fit, ForwardModel, IdentifyError, TrainedRecording};

/// What is made small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Loss {
    /// The mean square: the paper's cost.
    #[default]
    Squares,
    /// Huber's loss, by weights that are found anew until they stay: large residuals (a bumped table, a
    /// lost sample) count by their size instead of its square.
    Huber,
}

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitConfig {
    /// Swarm that finds the basin.
    pub swarm: SwarmConfig,
    /// Moves of each swarm.
    pub swarm_iterations: u64,
    /// Independent starts: a swarm and a least-squares search each. That several agree is the
    /// evidence that the minimum is the lowest. At least one is made, unless `from` gives some.
    pub starts: u64,
    /// Least-squares search from the best point of each swarm.
    pub least_squares: LeastSquaresConfig,
    /// What is made small.
    pub loss: Loss,
    /// Seed; start k takes stream k of it.
    pub seed: u64,
    /// Coordinates of earlier results, from [`SavedModel::coordinates`](crate::SavedModel::coordinates) say:
    /// a least-squares search from each is one more start.
    pub from: Vec<Vec<f64>>,
}

impl FitConfig {
    /// The search of Sadeghi, section 4, for comparison with the paper: one swarm of 50 particles and 150
    /// moves, and nothing after it. It proves no minimum, and the fit says so.
    #[must_use]
    pub fn sadeghi() -> Self {
        Self {
            swarm: SwarmConfig::sadeghi_identification(),
            swarm_iterations: 150,
            starts: 1,
            least_squares: LeastSquaresConfig {
                iterations: 0,
                ..LeastSquaresConfig::default()
            },
            ..Self::default()
        }
    }
}

impl Default for FitConfig {
    fn default() -> Self {
        Self {
            // As many particles as run side by side; more of them or longer found no lower floor.
            swarm: SwarmConfig {
                particles: BATCH,
                ..SwarmConfig::reliable()
            },
            swarm_iterations: 20,
            starts: 4,
            least_squares: LeastSquaresConfig::default(),
            loss: Loss::Squares,
            seed: 1,
            from: Vec::new(),
        }
    }
}

/// How far a fit is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitProgress {
    /// Starts done.
    pub starts: u64,
    /// Starts to be made.
    pub of: u64,
    /// Lowest root mean square so far, in the output unit.
    pub lowest_rmse: f64,
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
/// [`IdentifyError::NothingFree`], [`IdentifyError::TooManyParameters`],
/// [`IdentifyError::NoRecordings`], [`IdentifyError::StartLength`], [`IdentifyError::Swarm`] for settings that the swarm refuses, and
/// what the model refuses.
pub fn fit<M: ForwardModel>(
    model: &M,
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
    problem.weigh_temperature(equal_spreads(&problem, training));
    let n = problem.n_samples() as f64;
    let mut search = Search::default();
    for from in &config.from {
        if from.len() != problem.vector().len() {
            return Err(IdentifyError::StartLength {
                found: from.len(),
                expected: problem.vector().len(),
            });
        }
        search.descend(&problem, from, config)?;
    }
    let swarms = config.starts.max(u64::from(search.ends.is_empty()));
    let of = swarms + search.ends.len() as u64;
    for start in 0..swarms {
        let point = swarm_start(&problem, config, start, &mut search)?;
        search.descend(&problem, &point, config)?;
        let so_far = FitProgress {
            starts: search.ends.len() as u64,
            of,
            lowest_rmse: (search.lowest() / n).sqrt(),
        };
        if progress(&so_far).is_break() {
            break;
        }
    }
    if search.lowest().is_infinite() {
        return Err(IdentifyError::NothingFinite);
    }
    let starts = search.ends.len() as u64;
    let agreed = 1.01 * search.lowest() + problem.rounding();
    let agreeing_starts = search.ends.iter().filter(|&&end| end <= agreed).count() as u64;
    // Before weights change it: the outputs' own spread.
    let spread = problem.spread();
    reweigh(&mut problem, &mut search, config)?;
    let Some(minimum) = search.best else {
        unreachable!("at least one start is made");
    };
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
    Ok(Fit {
        parameters: fitted_parameters(&problem, &minimum.point, &solved, &covariance),
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
        unfixed: unfixed_directions(&problem, &minimum.point, &covariance.noise)?,
        noise: covariance.noise,
        termination: minimum.termination,
        agreeing_starts,
        starts,
        simulations: problem.simulations(),
        rejected_costs: search.rejected_costs,
        loss: config.loss,
        seed: config.seed,
        output_unit: training[0].output_unit().to_owned(),
        drive_quantity: training[0].drive_quantity(),
        drive_unit: training[0].drive_unit().to_owned(),
    })
}

/// The least-squares searches so far.
#[derive(Debug, Default)]
struct Search {
    best: Option<Minimum>,
    /// Where each start ended.
    ends: Vec<f64>,
    rejected_costs: u64,
}

impl Search {
    fn descend<M: ForwardModel>(
        &mut self,
        problem: &Problem<'_, M>,
        point: &[f64],
        config: &FitConfig,
    ) -> Result<(), IdentifyError> {
        let minimum = minimize(problem, problem.bounds(), point, &config.least_squares)?;
        self.ends.push(minimum.sum_of_squares);
        if self
            .best
            .as_ref()
            .is_none_or(|best| minimum.sum_of_squares < best.sum_of_squares)
        {
            self.best = Some(minimum);
        }
        Ok(())
    }

    fn lowest(&self) -> f64 {
        self.ends.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Weighs temperatures by how well they are met, and outliers by Huber, until the point stays.
fn reweigh<M: ForwardModel>(
    problem: &mut Problem<'_, M>,
    search: &mut Search,
    config: &FitConfig,
) -> Result<(), IdentifyError> {
    /// Weights converge linearly; with many outliers it takes tens of rounds, each from close by.
    const ROUNDS: usize = 60;
    let temperatures = problem.n_temperatures();
    if temperatures == 0 && config.loss == Loss::Squares {
        return Ok(());
    }
    for _ in 0..ROUNDS {
        let Some(before) = search.best.take() else {
            return Ok(());
        };
        let solved = problem.solve_one(&before.point)?;
        if temperatures > 0 && solved.temperature > 0.0 {
            let output = solved.output / problem.n_samples() as f64;
            problem.weigh_temperature(output / (solved.temperature / temperatures as f64));
        }
        if config.loss == Loss::Huber {
            problem.weigh_samples(huber_weights(&problem.residuals(&before.point, &solved)?));
        }
        search.descend(problem, &before.point, config)?;
        let still = search.best.as_ref().is_some_and(|after| {
            let moves = before.point.iter().zip(&after.point).zip(problem.bounds());
            moves
                .into_iter()
                .all(|((a, b), bound)| (a - b).abs() <= 1e-7 * (bound.upper - bound.lower))
        });
        if still {
            break;
        }
    }
    Ok(())
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

/// Weight of temperatures before it is known how well they can be met: that of equal spreads.
fn equal_spreads<M: ForwardModel>(problem: &Problem<'_, M>, training: &[Recording]) -> f64 {
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

/// The best point of a short swarm.
fn swarm_start<M: ForwardModel>(
    problem: &Problem<'_, M>,
    config: &FitConfig,
    start: u64,
    search: &mut Search,
) -> Result<Vec<f64>, IdentifyError> {
    let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
    rng.set_stream(start);
    let mut swarm = Swarm::new(config.swarm.clone(), problem.bounds(), rng)?;
    let stop = Stop {
        iterations: Some(config.swarm_iterations),
        ..Stop::default()
    };
    while swarm.finished(&stop)?.is_none() {
        let costs = problem.sums(swarm.ask())?;
        swarm.tell(&costs)?;
    }
    search.rejected_costs += swarm.rejected_costs();
    Ok(match swarm.best_point() {
        Some(point) => point.to_vec(),
        // No cost was finite: the middle is as good as any.
        None => problem.middle(),
    })
}
