//! Which parameters the data cannot tell apart.

use std::fmt;

use crate::Scale;
use crate::dense::{Matrix, singular};
use crate::problem::Problem;
use crate::uncertainty::Covariance;

/// Relative standard deviation along a direction from which it counts as not fixed: the parameters
/// could as well be half as large again.
const UNFIXED: f64 = 0.5;

/// Part in a direction, relative to the largest, below which a parameter is not named.
const NAMED: f64 = 0.3;

/// Parameters that can change together without showing.
#[derive(Debug, Clone, PartialEq)]
pub struct UnfixedDirection {
    /// Parameters and their relative change, the largest 1 or -1.
    pub changes: Vec<(&'static str, f64)>,
    /// Relative standard deviation along the direction: infinite if nothing shows at all.
    pub deviation: f64,
}

impl fmt::Display for UnfixedDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.changes.iter().map(|change| change.0).collect();
        let has = |name: &str| names.iter().any(|found| found.starts_with(name));
        let scale = ["loop_center", "loop_half_width", "loop_spread"];
        if (has("lambda") || has("rise_k")) && scale.iter().all(|name| has(name)) {
            return write!(
                f,
                "{}, loop center above ambient, half width and spread scale together: give R and m·Cp, or \
                 record the temperature",
                names
                    .iter()
                    .find(|name| !name.starts_with("loop"))
                    .unwrap_or(&"the rise")
            );
        }
        match names.as_slice() {
            [only] => write!(
                f,
                "{only} hardly shows: fix it in [model], or drive the rod so that it matters"
            ),
            _ => {
                let changes: Vec<String> = self
                    .changes
                    .iter()
                    .map(|(name, change)| {
                        format!("{name} {}", if *change > 0.0 { "up" } else { "down" })
                    })
                    .collect();
                write!(
                    f,
                    "{} together hardly show: fix one of them in [model], or record a drive that tells them apart",
                    changes.join(", ")
                )
            }
        }
    }
}

/// Singular directions of the scaled sensitivities along which the fit is not fixed.
///
/// The coordinates are relative: the logarithm of a parameter, or its distance from its lower bound
/// (for the loop's center that is ambient).
pub(crate) fn unfixed_directions(
    problem: &Problem<'_>,
    point: &[f64],
    covariance: &Covariance,
) -> Vec<UnfixedDirection> {
    let noise = &covariance.noise;
    let vector = problem.vector();
    let (linear, n) = (problem.n_linear(), point.len());
    let size = |j: usize| {
        let info = &vector.infos()[vector.parameter(j)];
        match info.scale {
            Scale::Logarithmic => 1.0,
            Scale::Linear => point[j] - problem.bounds()[j].lower,
        }
    };
    // Below the rows of the linear parameters: without what these can take up.
    let own = |row: usize, j: usize| covariance.sensitivities[(linear + row, linear + j)];
    let scaled = Matrix::from_fn(n, n, |row, j| own(row, j) * size(j));
    let Some(found) = singular(&scaled) else {
        return Vec::new();
    };
    // Slow changes meet the slow part of the residuals: their variance, times how few count.
    let slow = noise.variance * noise.n_samples as f64 / noise.n_effective.max(1.0);
    let directions = (0..n).filter_map(|i| {
        let deviation = slow.sqrt() / found.values[i];
        (deviation > UNFIXED || !deviation.is_finite()).then(|| {
            let part = |j: usize| found.directions[(i, j)];
            let largest = (0..n)
                .map(part)
                .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
            let changes = (0..n)
                .map(|j| (vector.infos()[vector.parameter(j)].name, part(j) / largest))
                .filter(|change| change.1.abs() >= NAMED)
                .collect();
            UnfixedDirection { changes, deviation }
        })
    });
    directions.collect()
}
