//! Generalized least squares: what is left of runs beside what laws and states could do.

use identify::dense::{self, Matrix};

use crate::changed::discrepancy::Filter;
use crate::model::projection::dot;

/// White columns of everything that may be adjusted, with priors, and the white residual.
#[derive(Debug)]
pub(crate) struct System {
    pub(crate) filters: Vec<(usize, Filter)>,
    columns: Vec<Vec<f64>>,
    /// Of each column; `None` for an offset.
    coordinates: Vec<Option<usize>>,
    residual: Vec<f64>,
    /// Precision of what may be adjusted, with ones on its diagonal, and the scale of each.
    precision: Matrix,
    scale: Vec<f64>,
    /// Inverse of the precision.
    covariance: Matrix,
    /// Products with the residual, priors counted.
    along: Matrix,
    ln_precision: f64,
    /// Of the square roots of the priors' precisions.
    ln_prior: f64,
    prior_squares: f64,
}

/// Adjustable columns, with their priors.
#[derive(Debug, Default)]
pub(crate) struct Adjusted {
    /// White columns.
    pub(crate) columns: Vec<Vec<f64>>,
    /// The coordinate of each; `None` for an offset.
    pub(crate) coordinates: Vec<Option<usize>>,
    /// The square root of a precision of each by itself.
    pub(crate) weak: Vec<f64>,
    /// Priors: columns and factors of each, and the value that they are to meet.
    pub(crate) priors: Vec<(Vec<(usize, f64)>, f64)>,
    /// Logarithm of the determinant of the square root of all these precisions.
    pub(crate) ln_prior: f64,
}

/// Products of some white series, outside of the adjustable columns, with one another and with the residual.
#[derive(Debug, Clone)]
pub(crate) struct Outside {
    /// Products of the series outside what may be adjusted.
    pub(crate) squares: Matrix,
    /// Of each with the residual.
    pub(crate) along: Vec<f64>,
}

impl System {
    pub(crate) fn new(
        filters: Vec<(usize, Filter)>,
        adjusted: Adjusted,
        residual: Vec<f64>,
    ) -> Self {
        let Adjusted {
            columns,
            coordinates,
            weak,
            priors,
            ln_prior,
        } = adjusted;
        let n = columns.len();
        let mut precision = Matrix::from_fn(n, n, |i, j| {
            if i >= j {
                dot(&columns[i], &columns[j])
            } else {
                0.0
            }
        });
        precision.fill_upper_triangle_with_lower_triangle();
        let mut along = Matrix::from_fn(n, 1, |i, _| dot(&columns[i], &residual));
        for (i, weak) in weak.iter().enumerate() {
            precision[(i, i)] += weak * weak;
        }
        let mut prior_squares = 0.0;
        for (of_row, value) in &priors {
            for &(i, a) in of_row {
                along[(i, 0)] += a * value;
                for &(j, b) in of_row {
                    precision[(i, j)] += a * b;
                }
            }
            prior_squares += value * value;
        }
        // On the scale of each column: their units are what they are.
        let scale: Vec<f64> = (0..n)
            .map(|i| 1.0 / precision[(i, i)].sqrt().max(f64::MIN_POSITIVE))
            .collect();
        let scaled = Matrix::from_fn(n, n, |i, j| {
            let one = precision[(i, j)] * scale[i] * scale[j];
            if i == j { one + 1e-10 } else { one }
        });
        let (inverse, ln_scaled) =
            dense::definite_inverse(&scaled).unwrap_or_else(|| (dense::inverse(&scaled), f64::NAN));
        let covariance = Matrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
        Self {
            ln_prior,
            ln_precision: ln_scaled - 2.0 * scale.iter().map(|one| one.ln()).sum::<f64>(),
            filters,
            columns,
            coordinates,
            residual,
            precision: scaled,
            scale,
            covariance,
            along,
            prior_squares,
        }
    }

    /// How far each coordinate is to be moved to meet the runs best, with the diagonal of the precision so much larger.
    pub(crate) fn step(&self, damping: f64) -> Vec<(usize, f64)> {
        let n = self.columns.len();
        let damped = Matrix::from_fn(n, n, |i, j| {
            let own = self.precision[(i, j)];
            if i == j { own * (1.0 + damping) } else { own }
        });
        let right = Matrix::from_fn(n, 1, |i, _| self.along[(i, 0)] * self.scale[i]);
        let by = dense::symmetric_solved(&damped, &right);
        let coordinates = self.coordinates.iter().enumerate();
        coordinates
            .filter_map(|(k, coordinate)| Some(((*coordinate)?, by[(k, 0)] * self.scale[k])))
            .collect()
    }

    /// Standard error of a coordinate.
    pub(crate) fn error(&self, coordinate: usize) -> Option<f64> {
        let place = self
            .coordinates
            .iter()
            .position(|one| *one == Some(coordinate))?;
        Some(self.covariance[(place, place)].max(0.0).sqrt())
    }

    /// Squares of what is left.
    pub(crate) fn squares(&self) -> f64 {
        let adjusted = (self.along.transpose() * &self.covariance * &self.along)[(0, 0)];
        dot(&self.residual, &self.residual) + self.prior_squares - adjusted
    }

    /// Logarithm of the density of the residual, but for a constant, everything that may be adjusted integrated out, where it leaves
    /// these squares.
    pub(crate) fn nats(&self, squares: f64) -> f64 {
        let determinants: f64 = self
            .filters
            .iter()
            .map(|(_, filter)| filter.ln_determinant)
            .sum();
        self.ln_prior - 0.5 * (determinants + self.ln_precision + squares)
    }

    /// White series outside what may be adjusted.
    pub(crate) fn outside(&self, white: &[Vec<f64>]) -> Outside {
        let m = white.len();
        let with = Matrix::from_fn(self.columns.len(), m, |i, k| {
            dot(&self.columns[i], &white[k])
        });
        let adjusted = &self.covariance * &with;
        let own = Matrix::from_fn(m, m, |i, j| dot(&white[i], &white[j]));
        let along = adjusted.transpose() * &self.along;
        Outside {
            squares: own - with.transpose() * adjusted,
            along: (0..m)
                .map(|k| dot(&white[k], &self.residual) - along[(k, 0)])
                .collect(),
        }
    }
}
