use std::ops::ControlFlow;

use pso::{Bound, Swarm, Termination};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use wiener::Fleet;

use crate::{BoundEnd, CostWeights, PidGains, Task, TaskError, Terms, TuneError, TunerConfig};

/// Ratio of costs up to which two swarms have ended alike.
pub(crate) const SAME: f64 = 1.01;

/// What a search shows of itself after each evaluation of its swarms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TuneProgress {
    /// Moves of each swarm so far; 0 after the starts.
    pub moves: u64,
    /// Responses so far.
    pub evaluations: u64,
    /// Best gains so far, and their cost; `None` while there is no finite cost.
    pub best: Option<(PidGains, f64)>,
}

/// The best controller that a search has found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Tuned {
    /// Its gains.
    pub gains: PidGains,
    /// Terms of its response.
    pub terms: Terms,
    /// Their cost.
    pub cost: f64,
    /// How many swarms ended within 1 % of this cost, this one among them: many that agree are evidence for
    /// the lowest minimum, one among many is a reason for more starts.
    pub agreeing: usize,
    /// Responses that were looked at.
    pub evaluations: u64,
    /// Those among them whose cost was `NaN`.
    pub rejected: u64,
    /// Seed of the search.
    pub seed: u64,
    /// Which of kp, ki and kd were found at an end of their ranges, to a thousandth of the scaled range.
    pub at_bound: [Option<BoundEnd>; 3],
    /// Why the search ended.
    pub termination: Termination,
}

/// Searches for the gains whose response to the task costs least, for one plant.
///
/// Same seed, same bits, for any number of threads; `progress` may end it early.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use pid_tune::{
///     AntiWindup, BoundEnd, ClosedLoop, ClosedLoopParams, CostWeights, DerivativeOf, Disturbances,
///     DriveLimits, Pace, PidGains, PidParams, Reference, Task, TunerConfig, tune,
/// };
/// use wiener::hysteresis::{LoopParams, Rule};
/// use wiener::thermal::{HeatBalanceParams, ThermalConstants};
/// use wiener::{Drive, Ensemble, Member, Start, WienerParams};
///
/// let closed_loop = ClosedLoop::new(ClosedLoopParams {
///     reference: Reference::Step { from: 0.0, to: 0.5, at_s: 0.0 }, // mm
///     n_samples: 300,
///     ambient_degc: 22.0,
///     feed_forward: None,
///     disturbances: Disturbances { quantization_step: 5.0 / 4096.0, ..Disturbances::default() },
/// })?;
/// let params = PidParams {
///     dt_s: 0.287,
///     limits: DriveLimits { lower: 0.0, upper: 3.0 }, // A
///     anti_windup: AntiWindup::Clamping,
///     derivative_of: DerivativeOf::Measurement,
///     derivative_filter_s: 0.0,
/// };
/// let rods = Ensemble { drive: Drive::Current, rule: Rule::Nested };
/// let task = Task::new(rods, closed_loop, params)?;
///
/// let heat = ThermalConstants { tau_s: 6.0, lambda_k_per_a2: 15.0 };
/// let rod = Member {
///     params: WienerParams {
///         heat: HeatBalanceParams::from_constants(heat),
///         limiting_loop: LoopParams { loop_center_degc: 55.0, ..LoopParams::default() },
///         zeta: 0.85,
///         gain: 5.0,     // mm
///         offset: -0.35,
///     },
///     start: Start::rest(22.0),
/// };
/// // What runs today sets the weights: each term of its response counts one. Gently, please.
/// let today = PidGains { kp: 200.0, ki: 0.01, kd: 0.0 };
/// let before = task.evaluate(&[(rod, today)])?[0];
/// let weights = Pace::new(0.3)?.weigh(&CostWeights::balancing(&before));
///
/// let config = TunerConfig { starts: 4, ..TunerConfig::for_task(&task, 5.0)? };
/// let tuned = tune(&task, rod, &weights, &config, |_| ControlFlow::Continue(()))?;
/// assert!(tuned.cost < 0.9 * weights.cost(&before));
/// // Worth installing: swarms agree on it, and no range was too short.
/// assert!(tuned.agreeing > 1 && !tuned.at_bound.contains(&Some(BoundEnd::Upper)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Settings that are not accepted: [`TuneError::Bounds`], [`TuneError::NoStarts`], [`TuneError::Swarm`],
/// [`TuneError::Negative`] for a weight, [`TuneError::NoWeight`]. [`TuneError::NoFiniteCost`]. Those of
/// [`Task::responses`].
pub fn tune<F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    member: F::Member,
    weights: &CostWeights,
    config: &TunerConfig,
    progress: impl FnMut(&TuneProgress) -> ControlFlow<()>,
) -> Result<Tuned, TaskError<F::Error>> {
    config.check()?;
    checked_weights(task, weights)?;
    let cost = |_, terms: &Terms| weights.cost(terms);
    let mut swarms = Swarms::new(config, config.starts)?;
    let termination = swarms.run(task, member, cost, progress)?;
    let Some((gains, cost)) = swarms.best() else {
        return Err(TuneError::NoFiniteCost.into());
    };
    let alike = |swarm: &&Swarm<_>| swarm.best_cost().is_some_and(|one| one <= SAME * cost);
    Ok(Tuned {
        gains,
        terms: evaluate_one(task, member, gains)?,
        cost,
        agreeing: swarms.swarms.iter().filter(alike).count(),
        evaluations: swarms.evaluations(),
        rejected: swarms.swarms.iter().map(Swarm::rejected_costs).sum(),
        seed: config.seed,
        at_bound: config.at_bound(&gains),
        termination,
    })
}

/// Accepts weights of which one counts for the task.
pub(crate) fn checked_weights<F>(
    task: &Task<'_, F>,
    weights: &CostWeights,
) -> Result<(), TuneError> {
    let CostWeights {
        mse,
        energy,
        rise_time,
        settling_time,
        overshoot,
    } = weights.checked()?;
    let of_step = if task.is_step() {
        rise_time.max(settling_time).max(overshoot)
    } else {
        0.0
    };
    if mse.max(energy).max(of_step) > 0.0 {
        Ok(())
    } else {
        Err(TuneError::NoWeight)
    }
}

/// The terms of one plant under one controller.
pub(crate) fn evaluate_one<F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    member: F::Member,
    gains: PidGains,
) -> Result<Terms, TaskError<F::Error>> {
    let Some(terms) = task.evaluate(&[(member, gains)])?.pop() else {
        unreachable!("one case has one response");
    };
    Ok(terms)
}

/// Several swarms over gains that do not know of one another but are evaluated together.
#[derive(Debug)]
pub(crate) struct Swarms<'a> {
    config: &'a TunerConfig,
    swarms: Vec<Swarm<ChaCha8Rng>>,
}

impl<'a> Swarms<'a> {
    /// Of settings that are checked.
    pub(crate) fn new(config: &'a TunerConfig, n_swarms: usize) -> Result<Self, TuneError> {
        let shares = Bound {
            lower: 0.0,
            upper: 1.0,
        };
        let swarms = (0..n_swarms).map(|stream| {
            let mut generator = ChaCha8Rng::seed_from_u64(config.seed);
            generator.set_stream(stream as u64);
            Swarm::new(config.swarm.clone(), &[shares; 3], generator).map_err(TuneError::Swarm)
        });
        Ok(Self {
            config,
            swarms: swarms.collect::<Result<_, _>>()?,
        })
    }

    /// Moves them to the end; `cost` sees every response once, with the number of its swarm.
    pub(crate) fn run<F: Fleet<Member: Sync, Error: Send> + Sync>(
        &mut self,
        task: &Task<'_, F>,
        member: F::Member,
        mut cost: impl FnMut(Seen, &Terms) -> f64,
        mut progress: impl FnMut(&TuneProgress) -> ControlFlow<()>,
    ) -> Result<Termination, TaskError<F::Error>> {
        for moves in 0..=self.config.moves {
            let asked = self.swarms.iter().flat_map(|swarm| swarm.ask());
            let cases: Vec<_> = asked.map(|at| (member, self.config.gains(at))).collect();
            let terms = task.evaluate(&cases)?;
            let n_particles = self.config.swarm.particles;
            for (number, swarm) in self.swarms.iter_mut().enumerate() {
                let own = number * n_particles..(number + 1) * n_particles;
                let seen = cases[own.clone()].iter().zip(&terms[own]);
                let costs: Vec<f64> = seen
                    .map(|(&(_, gains), terms)| cost(Seen { number, gains }, terms))
                    .collect();
                swarm.tell(&costs).map_err(TuneError::Swarm)?;
            }
            let wish = progress(&TuneProgress {
                moves,
                evaluations: self.evaluations(),
                best: self.best(),
            });
            if wish.is_break() && moves < self.config.moves {
                return Ok(Termination::Observer);
            }
        }
        Ok(Termination::Iterations)
    }

    /// Best gains of all and their cost; of equal costs, the first swarm's.
    fn best(&self) -> Option<(PidGains, f64)> {
        let ends = self
            .swarms
            .iter()
            .filter_map(|swarm| swarm.best_point().zip(swarm.best_cost()));
        let (shares, cost) = ends.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((self.config.gains(shares), cost))
    }

    fn evaluations(&self) -> u64 {
        self.swarms.iter().map(Swarm::evaluations).sum()
    }
}

/// Whose response it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    /// Number of the swarm.
    pub(crate) number: usize,
    /// The controller.
    pub(crate) gains: PidGains,
}
