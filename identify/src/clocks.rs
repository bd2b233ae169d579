//! Detection of outputs that come before the drive that causes them.

use recording::Recording;
use recording::order::rising;

use crate::least_squares::LeastSquaresConfig;
use crate::{Fit, ForwardModel, IdentifyError, ParameterVector, RefineConfig, Refined, refine};

/// Correlation of neighboring residuals below which nothing is left that another clock could explain.
const WHITE: f64 = 0.5;

/// Mean square with another clock over that without, from which on it is said: half of the error.
const HALF_THE_ERROR: f64 = 0.25;

/// Shifts that are tried, each twice the one before, from a sample on.
const DOUBLINGS: usize = 8;

/// Halvings of the way between the best shift and its neighbors.
const HALVINGS: usize = 4;

/// Iterations of a fit with another clock.
const ITERATIONS: usize = 30;

/// Recordings whose output comes before the drive: two clocks, or a filter that looks ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarlyOutput {
    /// By how much, s.
    pub by_s: f64,
    /// Root mean square of the fit with the output so much later, in the output unit.
    pub rmse: f64,
}

/// Detects an output that comes before its drive: a drive shifted to earlier times, by up to a time constant, at least
/// halves the root mean square error of the fit.
///
/// A dead time is physical; its opposite is not. The time constant and the loop's center hide it: they shift until the
/// error is small, and are then far off. `None` if no such shift is found, if the residuals are not correlated, and for
/// models without a time constant.
///
/// # Errors
///
/// Any error of the model.
pub fn early_output(
    model: &dyn ForwardModel,
    training: &[Recording],
    fit: &Fit,
) -> Result<Option<EarlyOutput>, IdentifyError> {
    let steps = training
        .iter()
        .filter_map(|one| one.sampling().usual_dt_s());
    let dt_s = steps.fold(f64::INFINITY, f64::min);
    let tau_s = fit.tau_s();
    if fit.noise.lag_1 < WHITE || !dt_s.is_finite() || tau_s < dt_s {
        return Ok(None);
    }
    let vector = ParameterVector::new(model.parameters(), training.len());
    let mut start = fit.coordinates(&vector);
    let mut fitted = |by_s: f64| -> Result<(f64, f64), IdentifyError> {
        let earlier: Vec<Recording> = training
            .iter()
            .map(|one| one.driven_earlier(by_s))
            .collect();
        let Refined {
            coordinates,
            mean_square,
            ..
        } = refined(model, &earlier, &start)?;
        // The next shift is near this one.
        start = coordinates;
        Ok((by_s, mean_square))
    };
    let mut tried = vec![(0.0, fit.train_rmse.powi(2))];
    for k in 0..DOUBLINGS {
        let by_s = dt_s * f64::from(1_u32 << k);
        if by_s > tau_s {
            break;
        }
        tried.push(fitted(by_s)?);
    }
    // Not worth a closer look.
    if tried[best_of(&tried)].1 > 2.0 * HALF_THE_ERROR * fit.train_rmse.powi(2) {
        return Ok(None);
    }
    for _ in 0..HALVINGS {
        rising(&mut tried, |one| one.0);
        let best = best_of(&tried);
        let below = best.checked_sub(1).map(|k| tried[k].0);
        let above = tried.get(best + 1).map(|one| one.0);
        for neighbor in [below, above].into_iter().flatten() {
            tried.push(fitted(0.5 * (tried[best].0 + neighbor))?);
        }
    }
    let (by_s, mean_square) = tried[best_of(&tried)];
    let is_early = by_s > 0.0 && mean_square <= HALF_THE_ERROR * fit.train_rmse.powi(2);
    Ok(is_early.then(|| EarlyOutput {
        by_s,
        rmse: mean_square.sqrt(),
    }))
}

fn best_of(tried: &[(f64, f64)]) -> usize {
    let order = (0..tried.len()).min_by(|a, b| tried[*a].1.total_cmp(&tried[*b].1));
    order.unwrap_or(0)
}

fn refined(
    model: &dyn ForwardModel,
    recordings: &[Recording],
    start: &[f64],
) -> Result<Refined, IdentifyError> {
    let config = RefineConfig {
        least_squares: LeastSquaresConfig {
            iterations: ITERATIONS,
            relative_offset: 1e-3,
            ..LeastSquaresConfig::default()
        },
        ..RefineConfig::default()
    };
    refine(model, recordings, &[start.to_vec()], &config)
}
