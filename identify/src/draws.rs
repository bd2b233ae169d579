//! Models as likely as the identified one: parameters drawn from the covariance of their estimates.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::dense::{Matrix, symmetric_eigen};
use crate::fitted::point;
use crate::{Fit, FittedParameter, ParameterCovariance, SavedModel, Scale, Scope};

/// Points drawn around an identified model.
#[derive(Debug, Clone, PartialEq)]
pub struct Draws {
    /// Values of all parameters in the first training recording, in the order of [`SavedModel::parameters`]; a
    /// point a draw.
    pub points: Vec<Vec<f64>>,
    /// Parameters that the data do not fix: they stay as they are in all draws.
    pub left_out: Vec<&'static str>,
}

impl SavedModel {
    /// Draws from the normal distribution that the covariance describes, on the scales of the search, cut at
    /// the bounds of the search: parameters that are correlated move together.
    ///
    /// Same seed, same draws.
    #[must_use]
    pub fn draws(&self, n: usize, seed: u64) -> Draws {
        draws(&self.parameters, &self.covariance, n, seed)
    }
}

impl Fit {
    /// Draws parameters of a fit that was not saved; see [`SavedModel::draws`].
    #[must_use]
    pub fn draws(&self, n: usize, seed: u64) -> Draws {
        draws(&self.parameters, &self.covariance, n, seed)
    }
}

fn draws(
    parameters: &[FittedParameter],
    covariance: &ParameterCovariance,
    n: usize,
    seed: u64,
) -> Draws {
    let infos: Vec<_> = parameters.iter().map(|one| &one.info).collect();
    let estimate = point(parameters, 0);
    // Which row of the covariance is which parameter; those of later recordings are not drawn.
    let mut rows = Vec::new();
    let mut left_out = Vec::new();
    for (k, info) in infos.iter().enumerate() {
        let name = match info.scope {
            Scope::Shared => info.name.to_owned(),
            Scope::PerRecording => format!("{}[0]", info.name),
        };
        let mut names = covariance.names.iter();
        let Some(row) = names.position(|other| *other == name) else {
            continue;
        };
        if covariance.matrix[row][row].is_finite() {
            rows.push((k, row));
        } else {
            left_out.push(info.name);
        }
    }
    let root = square_root(rows.len(), |i, j| covariance.matrix[rows[i].1][rows[j].1]);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let points = (0..n)
        .map(|_| {
            let normal: Vec<f64> = rows
                .iter()
                .map(|_| StandardNormal.sample(&mut rng))
                .collect();
            let mut drawn = estimate.clone();
            for (i, &(k, _)) in rows.iter().enumerate() {
                let moved: f64 = (0..rows.len()).map(|j| root[(i, j)] * normal[j]).sum();
                let info = &infos[k];
                let value = match info.scale {
                    Scale::Linear => estimate[k] + moved,
                    Scale::Logarithmic => estimate[k] * moved.exp(),
                };
                drawn[k] = value.clamp(info.bounds.lower, info.bounds.upper);
            }
            drawn
        })
        .collect();
    Draws { points, left_out }
}

/// The symmetric square root of a covariance: it stands rounding below zero, which Cholesky's does not.
fn square_root(n: usize, covariance: impl Fn(usize, usize) -> f64) -> Matrix {
    // Scaled to correlations: the parameters' units differ by orders of magnitude.
    let deviation: Vec<f64> = (0..n).map(|i| covariance(i, i).max(0.0).sqrt()).collect();
    let correlation = Matrix::from_fn(n, n, |i, j| {
        let product = deviation[i] * deviation[j];
        if product > 0.0 {
            covariance(i, j) / product
        } else {
            0.0
        }
    });
    let Some(eigen) = symmetric_eigen(&correlation) else {
        return Matrix::from_fn(n, n, |i, j| if i == j { deviation[i] } else { 0.0 });
    };
    let scaled = eigen.scaled_vectors();
    Matrix::from_fn(n, n, |i, j| {
        let root: f64 = (0..n).map(|k| scaled[(i, k)] * eigen.vectors[(j, k)]).sum();
        deviation[i] * root
    })
}
