//! How far a fit can be trusted: covariance of its parameters, corrected for residuals that are not
//! independent.

use crate::dense::{Matrix, singular};
use crate::factor::Triangle;
use crate::moments::Solved;
use crate::problem::{Channel, Problem, Residuals};
use crate::residual_noise::ResidualNoise;
use crate::{FINEST_THERMOMETER_K, IdentifyError};

/// Singular value of the scaled Jacobian, relative to the largest, below which a direction is not
/// fixed at all.
const SMALLEST_SINGULAR: f64 = 1e-10;

/// Covariance of the free parameters at a fit.
#[derive(Debug, Clone)]
pub(crate) struct Covariance {
    /// Which columns of the Jacobian it covers: linear ones first, coordinates on a bound left out.
    pub(crate) columns: Vec<usize>,
    /// In the columns' units; infinite where the data say nothing.
    pub(crate) matrix: Matrix,
    /// Triangular factor of all weighted rows and columns, by central differences: those of the linear parameters, then of the coordinates.
    pub(crate) sensitivities: Matrix,
    /// Noise model of the output's residuals.
    pub(crate) noise: ResidualNoise,
    /// Factor on a standard error for a 95 % interval.
    pub(crate) quantile: f64,
}

impl Covariance {
    /// Standard error of a column; `None` if it is not covered or not fixed.
    pub(crate) fn standard_error(&self, column: usize) -> Option<f64> {
        let k = self.columns.iter().position(|&covered| covered == column)?;
        let variance = self.matrix[(k, k)];
        (variance.is_finite() && variance >= 0.0).then(|| variance.sqrt())
    }
}

/// Covariance of a least-squares fit whose residuals are stationary but correlated.
///
/// ```text
/// cov = B (JᵀW Γ W J + σ² Eᵀ E) B,   B = (JᵀW J + Eᵀ E)⁻¹,   E rows of priors, of variance σ²
/// ```
///
/// Γ, the covariance of the residuals, is that of their autoregressive model: it is never formed, the
/// columns of W J pass through that model instead. The fit itself has taken tr(B JᵀWΓWJ) off the sum
/// of squares, which is given back.
pub(crate) fn covariance(
    problem: &Problem<'_>,
    point: &[f64],
    solved: &Solved,
    residuals: &[Residuals],
) -> Result<Covariance, IdentifyError> {
    let columns = covered_columns(problem, point);
    let segments = |of: fn(&Residuals) -> &[f64]| residuals.iter().map(of).collect::<Vec<_>>();
    let noises = [
        ResidualNoise::of(&segments(|one| &one.values)),
        ResidualNoise::of_at_least(&segments(|one| &one.temperatures_k), FINEST_THERMOMETER_K),
    ];
    let mut sensitivities = Triangle::new(problem.n_linear() + point.len());
    let mut meat = [Triangle::new(columns.len()), Triangle::new(columns.len())];
    for r in 0..problem.n_recordings() {
        let mut filters =
            [0, 1].map(|c: usize| Filter::new(&noises[c].coefficients, columns.len()));
        problem.rows(r, point, solved, &mut |row| {
            let weight = problem.weight(r, row);
            let root = weight.sqrt();
            sensitivities.push(|column| root * row.derivative(column));
            let c = channel(row.channel);
            filters[c].push(|k| weight * row.derivative(columns[k]));
            meat[c].push(|k| filters[c].latest(k));
        })?;
    }
    // A prior is a row of its own, which no other is correlated with.
    let (prior_rows, variance) = problem.prior_rows(solved);
    let root = variance.sqrt();
    let mut meat_of_prior = Triangle::new(columns.len());
    for row in prior_rows {
        let derivative = |column: usize| {
            let coordinate = column.checked_sub(problem.n_linear());
            coordinate.map_or(0.0, |coordinate| root * row.derivative(coordinate))
        };
        sensitivities.push(derivative);
        meat_of_prior.push(|k| derivative(columns[k]));
    }
    let sensitivities = sensitivities.r();
    let mut bread = Triangle::new(columns.len());
    for row in 0..sensitivities.nrows() {
        bread.push(|k| sensitivities[(row, columns[k])]);
    }
    let inverse = pseudo_inverse(&bread.r());
    let half = meat_of_prior.r() * &inverse.matrix * root;
    let mut matrix = half.transpose() * &half;
    for (noise, meat) in noises.iter().zip(meat) {
        // B S with SᵀS the meat: BᵀB keeps the sum positive.
        let half = meat.r() * &inverse.matrix * noise.innovation_variance.sqrt();
        matrix += half.transpose() * &half;
    }
    let [noise, _] = noises;
    let taken = taken_by_fit(&matrix, &inverse, &noise);
    matrix *= 1.0 + taken;
    for k in inverse.unfixed {
        matrix[(k, k)] = f64::INFINITY;
    }
    let freedom = (noise.n_effective - columns.len() as f64).max(1.0);
    Ok(Covariance {
        columns,
        matrix,
        sensitivities,
        quantile: student_95(freedom),
        noise,
    })
}

/// Linear columns, and the coordinates that no bound holds.
fn covered_columns(problem: &Problem<'_>, point: &[f64]) -> Vec<usize> {
    let linear = problem.n_linear();
    let free = (0..point.len()).filter(|&j| {
        let bound = &problem.bounds()[j];
        let margin = 1e-9 * (bound.upper - bound.lower);
        point[j] > bound.lower + margin && point[j] < bound.upper - margin
    });
    (0..linear).chain(free.map(|j| linear + j)).collect()
}

fn channel(channel: Channel) -> usize {
    match channel {
        Channel::Output => 0,
        Channel::Temperature => 1,
    }
}

/// Recursive filter 1/(1 - Σ a_i z⁻ⁱ) over several columns at once.
pub(crate) struct Filter {
    coefficients: Vec<f64>,
    /// The last outputs, newest first; one more than the order.
    history: Vec<Vec<f64>>,
}

impl Filter {
    pub(crate) fn new(coefficients: &[f64], columns: usize) -> Self {
        Self {
            coefficients: coefficients.to_vec(),
            history: vec![vec![0.0; columns]; coefficients.len() + 1],
        }
    }

    pub(crate) fn push(&mut self, input: impl Fn(usize) -> f64) {
        self.history.rotate_right(1);
        for k in 0..self.history[0].len() {
            let recalled: f64 = self
                .coefficients
                .iter()
                .zip(&self.history[1..])
                .map(|(coefficient, past)| coefficient * past[k])
                .sum();
            self.history[0][k] = input(k) + recalled;
        }
    }

    pub(crate) fn latest(&self, column: usize) -> f64 {
        self.history[0][column]
    }
}

/// (RᵀR)⁻¹ over the directions that the data fix.
struct Inverse {
    matrix: Matrix,
    /// RᵀR.
    information: Matrix,
    /// Columns with a part in a direction that the data do not fix.
    unfixed: Vec<usize>,
}

fn pseudo_inverse(r: &Matrix) -> Inverse {
    let n = r.ncols();
    let information = r.transpose() * r;
    let scales: Vec<f64> = (0..n)
        .map(|k| {
            Some(r.column(k).norm())
                .filter(|&norm| norm > 0.0)
                .unwrap_or(1.0)
        })
        .collect();
    let scaled = Matrix::from_fn(n, n, |row, k| r[(row, k)] / scales[k]);
    let nothing = Inverse {
        matrix: Matrix::zeros(n, n),
        information: information.clone(),
        unfixed: (0..n).collect(),
    };
    let Some(found) = singular(&scaled) else {
        return nothing;
    };
    let (values, directions) = (found.values, found.directions);
    let largest = values.iter().copied().fold(0.0, f64::max);
    let fixed = |i: usize| values[i] > SMALLEST_SINGULAR * largest;
    let matrix = Matrix::from_fn(n, n, |row, column| {
        let sum: f64 = (0..n)
            .filter(|&i| fixed(i))
            .map(|i| directions[(i, row)] * directions[(i, column)] / (values[i] * values[i]))
            .sum();
        sum / (scales[row] * scales[column])
    });
    let unfixed = (0..n)
        .filter(|&k| (0..n).any(|i| !fixed(i) && directions[(i, k)].abs() > 1e-3))
        .collect();
    Inverse {
        matrix,
        information,
        unfixed,
    }
}

/// Share of the residuals' variance that the fit has taken: tr(P Γ)/(N γ_0).
fn taken_by_fit(covariance: &Matrix, inverse: &Inverse, noise: &ResidualNoise) -> f64 {
    let n = covariance.ncols();
    let trace: f64 = (0..n)
        .map(|i| {
            (0..n)
                .map(|j| inverse.information[(i, j)] * covariance[(j, i)])
                .sum::<f64>()
        })
        .sum();
    let total = noise.variance * noise.n_samples as f64;
    // A fit of few samples takes nearly all; beyond that the correction means nothing.
    if total > 0.0 {
        (trace / total).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// 97.5 % quantile of Student's distribution: two terms of its expansion in 1/ν around that of the
/// normal distribution, 1.96; ν ≥ 1. Within 1 % for ν ≥ 5.
pub(crate) fn student_95(freedom: f64) -> f64 {
    const Z: f64 = 1.959_963_984_540_054;
    let (cube, fifth) = (Z.powi(3), Z.powi(5));
    Z + (cube + Z) / (4.0 * freedom)
        + (5.0 * fifth + 16.0 * cube + 3.0 * Z) / (96.0 * freedom * freedom)
}
