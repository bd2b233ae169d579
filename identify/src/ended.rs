//! Where a start of a fit ended: what an interrupted fit goes on from.

use pso::Bound;
use serde::{Deserialize, Serialize};

use crate::least_squares::Minimum;

/// Where one start of a fit ended. A fit that is given it does not make that start again, and ends with the same bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndedStart {
    /// Seed of the fit.
    pub(crate) seed: u64,
    /// Number of the start: the points that were given first, then the swarms.
    pub(crate) start: u64,
    pub(crate) minimum: Minimum,
    /// Where its search on fewer samples ended, if it had one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) basin: Option<Basin>,
    pub(crate) rejected_costs: u64,
    pub(crate) simulations: u64,
}

/// Where the search of a start on fewer samples ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Basin {
    /// Samples that it has seen.
    pub(crate) n_samples: usize,
    pub(crate) point: Vec<f64>,
    pub(crate) sum_of_squares: f64,
}

impl Basin {
    /// True if two searches on the same samples ended in one basin.
    pub(crate) fn is(&self, other: &Self, bounds: &[Bound]) -> bool {
        let sums = [self.sum_of_squares, other.sum_of_squares];
        let is_as_low = sums[0].max(sums[1]) <= AS_LOW * sums[0].min(sums[1]);
        self.n_samples == other.n_samples && is_as_low && is_one(&self.point, &other.point, bounds)
    }
}

/// Sum of squares over that of the lowest end up to which another one is as low.
pub(crate) const AS_LOW: f64 = 1.01;

/// True if two ends of searches are one place.
pub(crate) fn is_one(one: &[f64], other: &[f64], bounds: &[Bound]) -> bool {
    /// Share of a coordinate's range within which they are.
    const SAME: f64 = 0.05;
    let mut pairs = one.iter().zip(other).zip(bounds);
    pairs.all(|((a, b), bound)| (a - b).abs() <= SAME * (bound.upper - bound.lower))
}
