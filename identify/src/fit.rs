//! Swarm for the basin, least squares for the floor.

use pso::{Stop, Swarm, SwarmConfig};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use recording::Recording;

use crate::least_squares::{LeastSquaresConfig, Minimum, SumOfSquares, minimize};
use crate::problem::{Problem, Solved};
use crate::{
    Enters, ForwardModel, IdentifyError, ParameterInfo, ParameterState, Scope, Termination,
};

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitConfig {
    /// Swarm that finds the basin.
    pub swarm: SwarmConfig,
    /// Moves of each swarm.
    pub swarm_iterations: u64,
    /// Independent starts: a swarm and a least-squares search each. That several agree is the
    /// evidence that the minimum is the lowest.
    pub starts: u64,
    /// Least-squares search from the best point of each swarm.
    pub least_squares: LeastSquaresConfig,
    /// Seed; start k takes stream k of it.
    pub seed: u64,
}

impl Default for FitConfig {
    fn default() -> Self {
        Self {
            swarm: SwarmConfig::reliable(),
            swarm_iterations: 30,
            starts: 4,
            least_squares: LeastSquaresConfig::default(),
            seed: 1,
        }
    }
}

/// A parameter and what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedParameter {
    /// What was known of it.
    pub info: ParameterInfo,
    /// Its value, in its unit; one for each training recording if it is
    /// [`Scope::PerRecording`], else one.
    pub values: Vec<f64>,
    /// Whether a value ended on a bound: the data pull it further, or say nothing of it.
    pub at_bound: bool,
}

/// How well one training recording is met.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedRecording {
    /// Its name.
    pub name: String,
    /// Root mean square of recording - model, in the output unit.
    pub rmse: f64,
    /// Its number of samples.
    pub n_samples: usize,
}

/// An identified model.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The parameters, in the model's order.
    pub parameters: Vec<FittedParameter>,
    /// Root mean square of recording - model over all training samples, in the output unit.
    pub train_rmse: f64,
    /// 1 - RMSE / standard deviation of the output (each recording about its own mean).
    pub fit_fraction: f64,
    /// The training recordings one by one.
    pub recordings: Vec<TrainedRecording>,
    /// Why the least-squares search of the best start ended.
    pub termination: Termination,
    /// Starts that ended within 1 % of the lowest mean square.
    pub agreeing_starts: u64,
    /// Starts made.
    pub starts: u64,
    /// Simulations of the whole training set.
    pub simulations: u64,
}

impl Fit {
    /// Values of all parameters for a recording other than the training ones, in the model's order:
    /// the shared ones; per-recording ones are 0 for an offset and the first recording's otherwise.
    #[must_use]
    pub fn shared_values(&self) -> Vec<f64> {
        self.parameters
            .iter()
            .map(
                |parameter| match (parameter.info.scope, parameter.info.enters) {
                    (Scope::PerRecording, Enters::Offset) => 0.0,
                    _ => parameter.values[0],
                },
            )
            .collect()
    }

    /// The parameter of a name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&FittedParameter> {
        self.parameters
            .iter()
            .find(|parameter| parameter.info.name == name)
    }
}

/// Fits a model to several recordings together.
///
/// The cost is the mean squared error over all samples (Sadeghi, section 4). Each start runs a short
/// swarm and polishes its best point by bounded least squares; the lowest end is the fit. `progress`
/// is told, after each start, how many are done and the lowest mean square so far.
///
/// Same seed and inputs, same bytes, on any number of threads.
///
/// # Errors
///
/// [`IdentifyError::NothingFree`], [`IdentifyError::TooManyParameters`],
/// [`IdentifyError::NoRecordings`], [`IdentifyError::Swarm`] for settings that the swarm refuses, and
/// what the model refuses.
pub fn fit<M: ForwardModel>(
    model: &M,
    training: &[Recording],
    config: &FitConfig,
    progress: &mut dyn FnMut(u64, f64),
) -> Result<Fit, IdentifyError> {
    if training.is_empty() {
        return Err(IdentifyError::NoRecordings);
    }
    let problem = Problem::new(model, training)?;
    let n = problem.n_samples() as f64;
    let mut best: Option<Minimum> = None;
    let mut ends = Vec::new();
    let mut simulations = 0;
    for start in 0..config.starts.max(1) {
        let (point, evaluations) = swarm_start(&problem, config, start)?;
        let minimum = minimize(&problem, problem.bounds(), &point, &config.least_squares)?;
        simulations += evaluations + minimum.iterations as u64 * (9 + 2 * point.len() as u64);
        ends.push(minimum.sum_of_squares);
        if best
            .as_ref()
            .is_none_or(|best| minimum.sum_of_squares < best.sum_of_squares)
        {
            best = Some(minimum);
        }
        progress(
            start + 1,
            ends.iter().copied().fold(f64::INFINITY, f64::min) / n,
        );
    }
    let Some(minimum) = best else {
        unreachable!("at least one start is made");
    };
    let mut solved = problem.solve(std::slice::from_ref(&minimum.point))?;
    let Some(solved) = solved.pop() else {
        unreachable!("one point gives one solution");
    };
    let lowest = minimum.sum_of_squares;
    let recordings = trained_recordings(&problem, training, &minimum.point, &solved)?;
    // Summed from the residuals: near an exact fit the search's own sum is rounding.
    let sum: f64 = recordings
        .iter()
        .map(|one| one.rmse * one.rmse * one.n_samples as f64)
        .sum();
    Ok(Fit {
        parameters: fitted_parameters(&problem, &minimum.point, &solved),
        train_rmse: (sum / n).sqrt(),
        fit_fraction: 1.0 - (sum / problem.spread()).sqrt(),
        recordings,
        termination: minimum.termination,
        agreeing_starts: ends.iter().filter(|&&end| end <= 1.01 * lowest).count() as u64,
        starts: ends.len() as u64,
        simulations,
    })
}

/// The best point of a short swarm, and the number of its evaluations.
fn swarm_start<M: ForwardModel>(
    problem: &Problem<'_, M>,
    config: &FitConfig,
    start: u64,
) -> Result<(Vec<f64>, u64), IdentifyError> {
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
    let point = match swarm.best_point() {
        Some(point) => point.to_vec(),
        // No cost was finite: the middle is as good as any.
        None => problem
            .bounds()
            .iter()
            .map(|bound| f64::midpoint(bound.lower, bound.upper))
            .collect(),
    };
    Ok((point, swarm.evaluations()))
}

fn fitted_parameters<M: ForwardModel>(
    problem: &Problem<'_, M>,
    point: &[f64],
    solved: &Solved,
) -> Vec<FittedParameter> {
    let vector = problem.vector();
    let by_recording: Vec<Vec<f64>> = (0..solved.offsets.len())
        .map(|r| vector.values(point, r))
        .collect();
    vector
        .infos()
        .iter()
        .enumerate()
        .map(|(k, info)| {
            let mut values: Vec<f64> = match info.enters {
                Enters::Gain => vec![solved.gain; by_recording.len()],
                Enters::Offset => solved.offsets.clone(),
                Enters::Nonlinear => by_recording.iter().map(|values| values[k]).collect(),
            };
            if info.scope == Scope::Shared {
                values.truncate(1);
            }
            // Searched on a transformed scale: a value within rounding of a bound is on it.
            let margin = 1e-9 * (info.bounds.upper - info.bounds.lower);
            let at_bound = info.state == ParameterState::Free
                && info.enters == Enters::Nonlinear
                && values.iter().any(|&value| {
                    value <= info.bounds.lower + margin || value >= info.bounds.upper - margin
                });
            FittedParameter {
                info: info.clone(),
                values,
                at_bound,
            }
        })
        .collect()
}

fn trained_recordings<M: ForwardModel>(
    problem: &Problem<'_, M>,
    training: &[Recording],
    point: &[f64],
    solved: &Solved,
) -> Result<Vec<TrainedRecording>, IdentifyError> {
    training
        .iter()
        .enumerate()
        .map(|(r, recording)| {
            let sum = problem.sum_of_squares_of(r, point, solved)?;
            Ok(TrainedRecording {
                name: recording.name().to_owned(),
                rmse: (sum / recording.len() as f64).sqrt(),
                n_samples: recording.len(),
            })
        })
        .collect()
}
