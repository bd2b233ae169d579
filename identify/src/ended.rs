//! Where a start of a fit ended: what an interrupted fit goes on from.

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
    pub(crate) rejected_costs: u64,
    pub(crate) simulations: u64,
}
