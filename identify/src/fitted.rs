//! Result of a fit.

use recording::Quantity;
use serde::{Deserialize, Serialize};

use crate::moments::Solved;
use crate::problem::Problem;
use crate::uncertainty::Covariance;
use crate::{
    BeyondReach, Bounds, Enters, FINEST_THERMOMETER_K, Loss, ParameterInfo, ParameterVector,
    ResidualNoise, Scale, Scope, Termination, UnfixedDirection,
};

/// A parameter and what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedParameter {
    /// Definition of the parameter before the fit: name, unit, bounds, state.
    pub info: ParameterInfo,
    /// Its value, in its unit; one for each training recording if it is
    /// [`Scope::PerRecording`], else one.
    pub values: Vec<f64>,
    /// 95 % interval of each value; `None` if it is fixed, on a bound, or not fixed by the data.
    pub intervals: Vec<Option<Bounds>>,
    /// True if a value ended on a bound: the data pull it further, or say nothing of it.
    pub at_bound: bool,
}

impl FittedParameter {
    /// True if the parameter is shared and rests on a bound of its search that lies inside the admissible range.
    fn is_held_by_a_bound(&self) -> bool {
        /// Distance from a bound, as a share of the range.
        const NEAR: f64 = 1e-6;
        let Bounds { lower, upper } = self.info.bounds;
        let near = NEAR * (upper - lower);
        let held = |value: &f64| {
            (*value <= lower + near && lower > self.info.admissible.lower)
                || (*value >= upper - near && upper < self.info.admissible.upper)
        };
        self.at_bound && self.info.scope == Scope::Shared && self.values.iter().any(held)
    }
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
    /// Highest less lowest output, in the output unit.
    pub output_range: f64,
    /// Highest temperature of the model in it, °C: absurd, if what is said of the rod is wrong.
    pub peak_temperature_degc: f64,
}

/// Covariance of the estimates of the free parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterCovariance {
    /// Names, with the recording's number, from 0, for per-recording ones.
    pub names: Vec<String>,
    /// Scale of each entry: the parameter or its logarithm.
    pub scales: Vec<Scale>,
    /// Covariances, a row a name; infinite variances where the data do not fix a parameter.
    pub matrix: Vec<Vec<f64>>,
}

impl ParameterCovariance {
    /// Correlations, a row a name; `NaN` where the data do not fix a parameter.
    #[must_use]
    pub fn correlation(&self) -> Vec<Vec<f64>> {
        let entry = |i: usize, j: usize| {
            let product = self.matrix[i][i] * self.matrix[j][j];
            if product.is_finite() {
                self.matrix[i][j] / product.sqrt()
            } else {
                f64::NAN
            }
        };
        let n = self.names.len();
        (0..n)
            .map(|i| (0..n).map(|j| entry(i, j)).collect())
            .collect()
    }
}

/// An identified model.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The parameters, in the model's order.
    pub parameters: Vec<FittedParameter>,
    /// Root mean square of recording - model over all training samples, in the output unit.
    pub train_rmse: f64,
    /// Root mean square of recorded - simulated temperature, K, where temperatures were recorded.
    pub temperature_rmse_k: Option<f64>,
    /// 1 - RMSE / standard deviation of the output (each recording about its own mean).
    pub fit_fraction: f64,
    /// The training recordings one by one.
    pub recordings: Vec<TrainedRecording>,
    /// Noise model of the output's residuals.
    pub noise: ResidualNoise,
    /// Akaike's and Schwarz's criteria of the residuals' innovations, natural units: for comparing
    /// models on the same recordings, the lower the better.
    pub aic: f64,
    /// See `aic`.
    pub bic: f64,
    /// Covariance of the estimates.
    pub covariance: ParameterCovariance,
    /// Branches of the loop that lie beyond the temperatures reached: nothing tells where they are, so that center and half
    /// width have no interval.
    pub beyond_reach: Vec<BeyondReach>,
    /// Directions in which parameters can change together without showing.
    pub unfixed: Vec<UnfixedDirection>,
    /// Why the least-squares search of the best start ended.
    pub termination: Termination,
    /// Starts that ended within 1 % of the lowest mean square.
    pub agreeing_starts: u64,
    /// Starts made.
    pub starts: u64,
    /// Other minima where starts ended, up to 1.5 times the lowest mean square, the lowest first: of each the values of
    /// all parameters in every recording, as [`Fit::point`] has them.
    pub other_minima: Vec<Vec<Vec<f64>>>,
    /// Simulations of the whole training set.
    pub simulations: u64,
    /// Costs of the swarms that were no number; they counted as +∞.
    pub rejected_costs: u64,
    /// Loss function that was minimized.
    pub loss: Loss,
    /// Seed of the fit.
    pub seed: u64,
    /// Unit of the output.
    pub output_unit: String,
    /// Physical quantity of the drive.
    pub drive_quantity: Quantity,
    /// Its unit.
    pub drive_unit: String,
}

impl Fit {
    /// Factor that brings a temperature to the scale of the output by how well the fit meets both, (output unit)/K; `None` where none was
    /// recorded.
    #[must_use]
    pub fn output_per_k(&self) -> Option<f64> {
        let met = |rmse_k: f64| self.train_rmse / rmse_k.max(FINEST_THERMOMETER_K);
        self.temperature_rmse_k.map(met)
    }

    /// True if the result is a minimum, found by at least two starts (by all, if fewer were made).
    #[must_use]
    pub fn converged(&self) -> bool {
        self.termination.is_minimum() && self.agreeing_starts >= self.starts.min(2)
    }

    /// Shared parameters that rest on a bound of the search which is no end of what can be: the recordings pull them further, or
    /// say nothing of them.
    pub fn held_by_bounds(&self) -> impl Iterator<Item = &FittedParameter> {
        let parameters = self.parameters.iter();
        parameters.filter(|parameter| parameter.is_held_by_a_bound())
    }

    /// True if the search gives no reason to distrust the result: it has converged, no bound of the search holds it,
    /// and the loop lies within the temperatures reached.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.converged() && self.held_by_bounds().next().is_none() && self.beyond_reach.is_empty()
    }

    /// Values of all parameters in a training recording, in the model's order: what
    /// [`ForwardModel::simulate`](crate::ForwardModel::simulate) takes to show the output itself.
    ///
    /// # Panics
    ///
    /// If there is no such recording.
    #[must_use]
    pub fn point(&self, recording: usize) -> Vec<f64> {
        point(&self.parameters, recording)
    }

    /// Values of all parameters in every training recording, each as [`Fit::point`].
    #[must_use]
    pub fn points(&self) -> Vec<Vec<f64>> {
        let recordings = 0..self.recordings.len();
        recordings.map(|recording| self.point(recording)).collect()
    }

    /// Time constant of the rod, s; 0 of a model that has none.
    #[must_use]
    pub fn tau_s(&self) -> f64 {
        self.parameter("tau_s").map_or(0.0, |tau| tau.values[0])
    }

    /// Coordinates of the fit in a vector of its parameters.
    #[must_use]
    pub fn coordinates(&self, vector: &ParameterVector) -> Vec<f64> {
        vector.coordinates(|parameter, r| {
            let values = &self.parameters.get(parameter)?.values;
            values.get(r).or(values.first()).copied()
        })
    }

    /// The parameter of a name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&FittedParameter> {
        self.parameters
            .iter()
            .find(|parameter| parameter.info.name == name)
    }
}

/// Values of all parameters in a recording.
pub(crate) fn point(parameters: &[FittedParameter], recording: usize) -> Vec<f64> {
    let value = |parameter: &FittedParameter| match parameter.info.scope {
        Scope::Shared => parameter.values[0],
        Scope::PerRecording => parameter.values[recording],
    };
    parameters.iter().map(value).collect()
}

pub(crate) fn fitted_parameters(
    problem: &Problem<'_>,
    point: &[f64],
    solved: &Solved,
    covariance: &Covariance,
) -> Vec<FittedParameter> {
    let vector = problem.vector();
    let n_recordings = problem.n_recordings();
    (0..vector.infos().len())
        .map(|k| {
            let info = &vector.infos()[k];
            let n_values = match info.scope {
                Scope::Shared => 1,
                Scope::PerRecording => n_recordings,
            };
            let mut values = Vec::with_capacity(n_values);
            let mut intervals = Vec::with_capacity(n_values);
            let mut at_bound = false;
            for r in 0..n_values {
                values.push(match info.enters {
                    Enters::Gain => solved.gain,
                    Enters::Offset => solved.offsets[r],
                    Enters::Nonlinear => vector.values(point, r)[k],
                });
                let column = problem.column_of(k, r);
                let half = column
                    .and_then(|column| covariance.standard_error(column))
                    .map(|error| covariance.quantile * error);
                at_bound |= column.is_some_and(|column| !covariance.columns.contains(&column));
                intervals.push(half.map(|half| match vector.coordinate_of(k, r) {
                    Some(j) => info.interval_around(point[j], half),
                    None => Bounds {
                        lower: values[r] - half,
                        upper: values[r] + half,
                    },
                }));
            }
            FittedParameter {
                info: info.clone(),
                values,
                intervals,
                at_bound,
            }
        })
        .collect()
}

pub(crate) fn parameter_covariance(
    problem: &Problem<'_>,
    covariance: &Covariance,
) -> ParameterCovariance {
    let infos = problem.vector().infos();
    let (mut names, mut scales) = (Vec::new(), Vec::new());
    for &column in &covariance.columns {
        let found = infos.iter().enumerate().find_map(|(k, info)| {
            let r = (0..problem.n_recordings()).find(|&r| problem.column_of(k, r) == Some(column));
            r.map(|r| (info, r))
        });
        let Some((info, r)) = found else {
            unreachable!("every column stands for a parameter");
        };
        names.push(match info.scope {
            Scope::Shared => info.name.to_owned(),
            Scope::PerRecording => format!("{}[{r}]", info.name),
        });
        scales.push(info.scale);
    }
    let n = covariance.columns.len();
    let row = |i| (0..n).map(|j| covariance.matrix[(i, j)]).collect();
    ParameterCovariance {
        names,
        scales,
        matrix: (0..n).map(row).collect(),
    }
}
