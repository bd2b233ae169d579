use crate::bound::Bound;
use crate::error::positive;
use crate::{Boundary, ConstrictionParams, Inertia, Start, SwarmError, Topology, Weights};

/// Particles of the paper's swarms.
const SADEGHI_PARTICLES: usize = 50;

/// Settings of a swarm. `Default` is [`SwarmConfig::reliable`].
///
/// ```
/// use pso::{Start, SwarmConfig};
/// let warm = SwarmConfig {
///     particles: 24,
///     start: Start::Given(vec![vec![0.1, 0.2]]),
///     ..SwarmConfig::default()
/// };
/// assert!(warm.weights.is_order_2_stable());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SwarmConfig {
    /// Number of particles; >= 1.
    pub particles: usize,
    /// Weights of the velocity.
    pub weights: Weights,
    /// Largest speed of a coordinate as a fraction of its range; finite, > 0. `None`: no limit.
    ///
    /// With weights that are not order-2 stable ([`Weights::is_order_2_stable`]) it must be set, or
    /// the speeds grow until every step ends at a bound.
    pub velocity_limit: Option<f64>,
    /// Treatment of particles at the bounds.
    pub boundary: Boundary,
    /// Who informs whom.
    pub topology: Topology,
    /// Where the particles start.
    pub start: Start,
}

impl SwarmConfig {
    /// The setting to take unless there is a reason for another: 50 particles, weights of SPSO-2011
    /// ([`Weights::spso_2011`]), speed at most half the range [`Eberhart2000`](crate#references),
    /// velocity zeroed at the bound as in the standard swarms of 2006 and 2007
    /// [`Clerc2012`](crate#references), a ring in which each particle hears of ten neighbors on either
    /// side, Latin-hypercube starts.
    ///
    /// The ring is our own choice. On a fit of seven physical parameters in 150 iterations it ended
    /// within 1 % of the lowest cost with 100 of 100 seeds; with everybody informed 92 did, and 7
    /// ended at over 100 times that cost, caught by a local minimum; in the narrower ring of
    /// [`SwarmConfig::patient`] 92 did, and none ended so high
    /// (`cargo run --release -p benches --bin performance_table`). On the published functions in 30
    /// coordinates it ends below a swarm with everybody informed (`tests/all/functions.rs`).
    ///
    /// A swarm of fewer than 22 particles is reached around by this ring: everybody is informed.
    #[must_use]
    pub fn reliable() -> Self {
        Self {
            particles: SADEGHI_PARTICLES,
            weights: Weights::spso_2011(),
            velocity_limit: Some(0.5),
            boundary: Boundary::Absorb,
            topology: Topology::Ring { neighbors: 10 },
            start: Start::LatinHypercube,
        }
    }

    /// [`SwarmConfig::reliable`] with five neighbors on either side instead of ten, for long runs over
    /// many coordinates with many local minima: such a minimum catches the whole swarm less often.
    ///
    /// Five of 50 is our own choice. In 1000 moves over 30 coordinates it reaches the minimum of
    /// Ackley's function with 90 % of the seeds, `reliable` with 44 %; on functions of one valley it
    /// ends higher, and in 150 iterations it is the slower one (table in the crate's documentation).
    #[must_use]
    pub fn patient() -> Self {
        Self {
            topology: Topology::Ring { neighbors: 5 },
            ..Self::reliable()
        }
    }

    /// The identification setting of [`Sadeghi`](crate#references): 50 particles, w = 0.9,
    /// c1 = c2 = 2; the paper runs 150 iterations.
    ///
    /// The mean of such a swarm is stable (c1 + c2 = 4 < 4 (1 + w) = 7.6). Its variance is not (c1 + c2
    /// would have to be below 24 (1 − w²)/(7 − 5w) = 1.82 [`Poli2009`](crate#references)), and neither
    /// is the swarm without random numbers (3.8). It needs a velocity limit: the usual companion, 0.1
    /// of the range. It is the poorest of the presets, there to repeat the paper.
    ///
    /// The paper names neither limit nor boundary nor start: 0.1, absorb and uniform are ours.
    #[must_use]
    pub fn sadeghi_identification() -> Self {
        Self {
            particles: SADEGHI_PARTICLES,
            weights: Weights {
                inertia: Inertia::Constant(0.9),
                cognitive: 2.0,
                social: 2.0,
            },
            velocity_limit: Some(0.1),
            boundary: Boundary::Absorb,
            topology: Topology::Global,
            start: Start::Uniform,
        }
    }

    /// The controller-tuning setting of [`Sadeghi`](crate#references): 50 particles, constriction
    /// [`Clerc2002`](crate#references) with φ1 = φ2 = 2.05, hence w = 0.7298 and
    /// c1 = c2 = 1.4962; the paper runs 150 iterations.
    ///
    /// It is order-2 stable (c1 + c2 = 2.99 < 24 (1 − w²)/(7 − 5w) = 3.35) and needs no velocity limit.
    /// The paper names neither boundary nor start: absorb and uniform are ours.
    #[must_use]
    pub fn sadeghi_tuning() -> Self {
        let params = ConstrictionParams {
            phi_cognitive: 2.05,
            phi_social: 2.05,
        };
        let Ok(weights) = Weights::constriction(params) else {
            unreachable!("2.05 + 2.05 > 4");
        };
        Self {
            particles: SADEGHI_PARTICLES,
            weights,
            velocity_limit: None,
            boundary: Boundary::Absorb,
            topology: Topology::Global,
            start: Start::Uniform,
        }
    }

    pub(crate) fn check(&self, bounds: &[Bound]) -> Result<(), SwarmError> {
        if self.particles == 0 {
            return Err(SwarmError::ZeroCount { name: "particles" });
        }
        self.weights.check()?;
        if let Some(limit) = self.velocity_limit {
            positive("velocity_limit", limit)?;
        }
        self.topology.check()?;
        crate::bound::check(bounds)?;
        self.start.check(self.particles, bounds)
    }
}

impl Default for SwarmConfig {
    fn default() -> Self {
        Self::reliable()
    }
}
