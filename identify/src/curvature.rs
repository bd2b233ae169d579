//! Curvature of the residuals, which the Gauss-Newton model of a sum of squares leaves out: learned from the steps taken.

use crate::dense::{Matrix, definite_solved};
use crate::least_squares::Linearized;

/// Change of the gradient along a step over what the Jacobian makes of it, below which nothing is learned from the step.
const SMALLEST_RISE: f64 = 1e-6;

/// Estimate S of the second-order part of the Hessian, by the secant rule of NL2SOL \[Dennis1981\].
///
/// ```text
/// H = JᵀJ + Σ r_i ∇²r_i ≈ JᵀJ + S
/// y = g₊ - g,   y♯ = y - J₊ᵀJ₊ s,   g = Jᵀr
/// S₊ = τS + (d yᵀ + y dᵀ)/(yᵀs) - (sᵀd) y yᵀ/(yᵀs)²,   d = y♯ - τS s,   τ = min(1, |sᵀy♯|/|sᵀS s|)
/// ```
///
/// Where a model misses what it is fitted to, S is as large as the misfit: without it a search converges linearly, or turns from
/// one wall of a valley to the other.
#[derive(Debug, Clone)]
pub(crate) struct Curvature {
    /// S, square and symmetric.
    second_order: Matrix,
}

impl Curvature {
    /// None is known of so many coordinates.
    pub(crate) fn unknown(n: usize) -> Self {
        Self {
            second_order: Matrix::zeros(n, n),
        }
    }

    /// Learns from a step between two points.
    pub(crate) fn learn(&mut self, step: &[f64], before: &Linearized, after: &Linearized) {
        let n = step.len();
        let step = Matrix::from_column_slice(n, 1, step);
        let rise = after.gradient() - before.gradient();
        let along = &after.jacobian * &step;
        let first_order = after.jacobian.tr_mul(&along);
        let rise_along = rise.dot(&step);
        // Written so that NaN passes nothing.
        let is_told = rise_along > SMALLEST_RISE * along.norm_squared();
        if !is_told {
            return;
        }
        let wanted = &rise - first_order;
        let known = (&self.second_order * &step).dot(&step);
        let share = (wanted.dot(&step) / known).abs();
        if share < 1.0 {
            self.second_order *= share;
        }
        let off = wanted - &self.second_order * &step;
        let mixed = &off * rise.transpose() / rise_along;
        let twice = off.dot(&step) / rise_along.powi(2);
        self.second_order += &mixed + mixed.transpose() - &rise * rise.transpose() * twice;
    }

    /// The augmented model around a point.
    pub(crate) fn augmented(&self, local: &Linearized) -> Augmented {
        Augmented {
            hessian: local.jacobian.tr_mul(&local.jacobian) + &self.second_order,
            gradient: local.gradient(),
        }
    }
}

/// A sum of squares to second order around a point.
#[derive(Debug, Clone)]
pub(crate) struct Augmented {
    /// JᵀJ + S.
    hessian: Matrix,
    /// Jᵀr, a column.
    gradient: Matrix,
}

impl Augmented {
    /// Step of the free coordinates to its minimum, damped as Marquardt's with weights; `None` where it has none.
    pub(crate) fn step(&self, free: &[usize], weights: &[f64], damping: f64) -> Option<Vec<f64>> {
        let n = free.len();
        // In units of the weights, where all diagonals of JᵀJ are about 1.
        let scaled = Matrix::from_fn(n, n, |a, b| {
            let own = self.hessian[(free[a], free[b])] / (weights[free[a]] * weights[free[b]]);
            if a == b { own + damping } else { own }
        });
        let downhill = Matrix::from_fn(n, 1, |a, _| -self.gradient[free[a]] / weights[free[a]]);
        let step = definite_solved(scaled, &downhill)?;
        let unscaled = step.iter().zip(free).map(|(step, &j)| step / weights[j]);
        Some(unscaled.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals x + x²/2 and 3 + y - y²/5: along y the gradient rises at -2 and falls at 0.
    fn around(point: [f64; 2]) -> Linearized {
        let [x, y] = point;
        let residual = vec![x + 0.5 * x * x, 3.0 + y - 0.2 * y * y];
        Linearized {
            jacobian: Matrix::from_row_slice(2, 2, &[1.0 + x, 0.0, 0.0, 1.0 - 0.4 * y]),
            sum_of_squares: residual.iter().map(|r| r * r).sum(),
            residual,
        }
    }

    #[test]
    fn after_a_step_the_augmented_model_knows_how_the_gradient_changed() {
        let (before, after) = (around([0.3, -2.0]), around([0.1, -1.8]));
        let step = [-0.2, 0.2];
        let mut curvature = Curvature::unknown(2);
        curvature.learn(&step, &before, &after);
        let change = curvature.augmented(&after).hessian * Matrix::from_column_slice(2, 1, &step);
        let wanted = after.gradient() - before.gradient();
        assert!((change - wanted).amax() < 1e-12);
    }

    #[test]
    fn a_step_along_which_the_gradient_falls_teaches_nothing() {
        let (before, after) = (around([0.0, 0.0]), around([0.0, 0.1]));
        let mut curvature = Curvature::unknown(2);
        curvature.learn(&[0.0, 0.1], &before, &after);
        assert!(curvature.second_order.amax() <= 0.0);
    }

    #[test]
    fn there_is_no_step_to_the_minimum_of_a_model_that_has_none() {
        let gradient = around([0.1, 0.0]).gradient();
        let step = |diagonal: [f64; 2]| {
            let augmented = Augmented {
                hessian: Matrix::from_row_slice(2, 2, &[diagonal[0], 0.0, 0.0, diagonal[1]]),
                gradient: gradient.clone(),
            };
            augmented.step(&[0, 1], &[1.0, 1.0], 1e-9)
        };
        assert!(step([1.0, -0.1]).is_none());
        assert!(step([f64::NAN, 1.0]).is_none());
        let step = step([2.0, 4.0]).unwrap();
        assert!((step[0] + gradient[0] / 2.0).abs() < 1e-8);
        assert!((step[1] + gradient[1] / 4.0).abs() < 1e-8);
    }
}
