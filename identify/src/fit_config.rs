//! Settings of a fit.

use pso::SwarmConfig;

use crate::least_squares::LeastSquaresConfig;
use crate::moments::BATCH;
use crate::{EndedStart, Prior};

/// Loss function that a fit minimizes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Loss {
    /// The mean square: the paper's cost.
    #[default]
    Squares,
    /// Huber's loss, by weights that are found anew until they stay: large residuals (a bumped table, a
    /// lost sample) count by their size instead of its square.
    Huber,
}

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitConfig {
    /// Swarm that finds the basin.
    pub swarm: SwarmConfig,
    /// Moves of each swarm.
    pub swarm_iterations: u64,
    /// Independent starts: a swarm and a least-squares search each. That several agree is the
    /// evidence that the minimum is the lowest. At least one is made, unless `from` gives some.
    pub starts: u64,
    /// True if eight starts that all agree are enough: no other is made then.
    pub until_agreed: bool,
    /// Least-squares search from the best point of each swarm.
    pub least_squares: LeastSquaresConfig,
    /// Loss function to minimize.
    pub loss: Loss,
    /// Weight of recorded temperatures against the output in the search from each start, (output unit/K)²; `None` for equal
    /// spreads. Where the fit ends, each is weighed by how well it is met.
    pub temperature_weight: Option<f64>,
    /// How the priors of parameters count.
    pub prior: Prior,
    /// Seed; start k takes stream k of it.
    pub seed: u64,
    /// Coordinates of earlier results, from [`SavedModel::coordinates`](crate::SavedModel::coordinates) say:
    /// a least-squares search from each is one more start.
    pub from: Vec<Vec<f64>>,
    /// Starts that an interrupted fit of the same model, recordings and settings has made: these are not made again. Those
    /// of another seed are passed over.
    pub ended: Vec<EndedStart>,
}

impl FitConfig {
    /// The search of Sadeghi, section 4, for comparison with the paper: one swarm of 50 particles and 150
    /// moves, and nothing after it. It proves no minimum, and the fit says so.
    #[must_use]
    pub fn sadeghi() -> Self {
        Self {
            swarm: SwarmConfig::sadeghi_identification(),
            swarm_iterations: 150,
            starts: 1,
            least_squares: LeastSquaresConfig {
                iterations: 0,
                ..LeastSquaresConfig::default()
            },
            ..Self::default()
        }
    }
}

impl Default for FitConfig {
    fn default() -> Self {
        Self {
            // As many particles as run side by side; more of them or longer found no lower floor.
            swarm: SwarmConfig {
                particles: BATCH,
                ..SwarmConfig::reliable()
            },
            swarm_iterations: 20,
            starts: 4,
            until_agreed: false,
            least_squares: LeastSquaresConfig::default(),
            loss: Loss::Squares,
            temperature_weight: None,
            prior: Prior::Nothing,
            seed: 1,
            from: Vec::new(),
            ended: Vec::new(),
        }
    }
}
