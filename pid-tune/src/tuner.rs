use std::ops::ControlFlow;

use pso::{Bound, Stall, Swarm, Termination};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use wiener::Fleet;

use crate::{
    BoundEnd, Ending, Goal, PidGains, Response, Task, TaskError, Terms, TuneError, TunerConfig,
};

/// Ratio of costs up to which two swarms have ended alike.
pub(crate) const SAME: f64 = 1.01;

/// Swarms that agree on a cost before a search may end early.
const AGREED: usize = 3;
/// Ratio of costs of gains that are tried one after another.
const DEARER: f64 = 1.002;
/// Most of them.
const MOST_TRIED: usize = 200;

/// The plants that a controller is for.
#[derive(Debug, Clone, Copy)]
pub struct Plants<'a, M> {
    /// Those whose responses count; the first is reported.
    pub judged: &'a [M],
    /// Others on which the loop has to rest as well, of the gains that the search has found.
    pub resting: &'a [M],
}

impl<'a, M> Plants<'a, M> {
    /// Plants whose responses count, and no others.
    #[must_use]
    pub fn judged(judged: &'a [M]) -> Self {
        Self {
            judged,
            resting: &[],
        }
    }
}

/// State of a search after each evaluation of its swarms.
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
    /// Terms of the first plant's response.
    pub terms: Terms,
    /// How that response ended.
    pub ending: Ending,
    /// Its cost, over all plants that are judged.
    pub cost: f64,
    /// The lowest cost that was found: less than that of the gains where the cheapest do not rest on all plants.
    pub lowest: f64,
    /// Plants besides on which its loop rests; 0 if that was not asked for.
    pub rest_on: usize,
    /// How many swarms ended within 1 % of this cost, this one among them: many that agree are evidence for
    /// the lowest minimum, one among many is a reason for more starts.
    pub agreeing: usize,
    /// Controllers that were looked at.
    pub evaluations: u64,
    /// Those among them that missed what is required, and were not simulated.
    pub refused: u64,
    /// Those among them whose cost was `NaN`.
    pub rejected: u64,
    /// Seed of the search.
    pub seed: u64,
    /// Which of kp, ki and kd were found at an end of their ranges, to a thousandth of the scaled range.
    pub at_bound: [Option<BoundEnd>; 3],
    /// Why the search ended.
    pub termination: Termination,
}

/// Searches for the gains whose response to the task costs least, for one plant or for several at once, the first of
/// which is the one that is reported.
///
/// Same seed, same bits, for any number of threads; `progress` may end it early.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use pid_tune::{
///     AntiWindup, BoundEnd, ClosedLoop, ClosedLoopParams, CostWeights, DerivativeOf, Disturbances,
///     DriveLimits, Goal, Pace, PidGains, PidParams, Plants, Reference, Task, TunerConfig, tune,
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
///     aim: None,
///     disturbances: Disturbances { quantization_step: 5.0 / 4096.0, ..Disturbances::default() },
/// })?;
/// let params = PidParams {
///     dt_s: 0.287,
///     limits: DriveLimits { lower: 0.0, upper: 3.0 }, // A
///     anti_windup: AntiWindup::Clamping,
///     derivative_of: DerivativeOf::Measurement,
///     derivative_filter_s: 0.0,
///     setpoint_weight: 1.0,
///     gain_schedule: None,
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
/// let tuned = tune(&task, &Plants::judged(&[rod]), &Goal::of(weights), &config, |_| ControlFlow::Continue(()))?;
/// assert!(tuned.cost < 0.9 * weights.cost(&before));
/// // Worth installing: swarms agree on it, and no range was too short.
/// assert!(tuned.agreeing > 1 && !tuned.at_bound.contains(&Some(BoundEnd::Upper)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Settings that are not accepted: [`TuneError::Bounds`], [`TuneError::NoStarts`], [`TuneError::Swarm`],
/// [`TuneError::Negative`] for a weight, [`TuneError::NoWeight`], [`TuneError::Empty`] without plants.
/// [`TuneError::NoFiniteCost`], [`TuneError::Unmet`], [`TuneError::NoRest`]. Those of [`Task::responses`].
pub fn tune<F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    plants: &Plants<'_, F::Member>,
    goal: &Goal<'_>,
    config: &TunerConfig,
    progress: impl FnMut(&TuneProgress) -> ControlFlow<()>,
) -> Result<Tuned, TaskError<F::Error>> {
    config.check()?;
    goal.check(task)?;
    let members = plants.judged;
    let Some(&nominal) = members.first() else {
        return Err(TuneError::Empty { name: "members" }.into());
    };
    let cost = |_, responses: &[Response]| goal.cost_of_all(responses);
    let mut swarms = Swarms::new(config, config.starts)?;
    let termination = swarms.run(task, members, goal, cost, progress)?;
    let (gains, lowest) = match swarms.best() {
        None => return Err(TuneError::NoFiniteCost.into()),
        Some((gains, cost)) => match Goal::fault(cost) {
            Some(fault) => return Err(fault.into()),
            None => (gains, cost),
        },
    };
    let agreeing = swarms.agreeing(lowest);
    let kept = core::mem::take(&mut swarms.kept);
    let has_to_rest = goal.rest.is_some() && !plants.resting.is_empty();
    let (cost, gains) = if has_to_rest {
        resting(task, plants.resting, goal, kept)?.ok_or(TuneError::NoRest)?
    } else {
        (lowest, gains)
    };
    let response = task.response(nominal, gains)?;
    Ok(Tuned {
        gains,
        terms: response.terms,
        ending: response.ending,
        cost,
        lowest,
        rest_on: if has_to_rest { plants.resting.len() } else { 0 },
        agreeing,
        evaluations: swarms.evaluations(),
        rejected: swarms.swarms.iter().map(Swarm::rejected_costs).sum(),
        refused: swarms.refused,
        seed: config.seed,
        at_bound: config.at_bound(&gains),
        termination,
    })
}

/// Of all gains that a swarm kept on its way, the cheapest whose loops rest on every one of some plants; `None` if there are
/// none.
///
/// Gains are tried one after another, each dearer than the last by at least [`DEARER`].
fn resting<F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    plants: &[F::Member],
    goal: &Goal<'_>,
    mut kept: Vec<(f64, PidGains)>,
) -> Result<Option<(f64, PidGains)>, TaskError<F::Error>> {
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut dearer = f64::NEG_INFINITY;
    kept.retain(|&(cost, _)| {
        let is_next = cost >= dearer;
        if is_next {
            dearer = DEARER * cost;
        }
        is_next
    });
    for &(cost, gains) in kept.iter().take(MOST_TRIED) {
        let cases: Vec<_> = plants.iter().map(|&plant| (plant, gains)).collect();
        let responses = task.responses(&cases)?;
        let endings = responses.iter().map(|response| &response.ending);
        if goal.unrested(endings).is_none()
            && unrested(task, plants, goal, &[gains], &[0])?.is_empty()
        {
            return Ok(Some((cost, gains)));
        }
    }
    Ok(None)
}

/// Costs of those candidates, by their numbers among the gains, whose loop does not rest from every side.
pub(crate) fn unrested<F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    members: &[F::Member],
    goal: &Goal<'_>,
    gains: &[PidGains],
    candidates: &[usize],
) -> Result<Vec<(usize, f64)>, TaskError<F::Error>> {
    let mut unrested = Vec::new();
    let Some(test) = &goal.rest else {
        return Ok(unrested);
    };
    let cases: Vec<_> = candidates
        .iter()
        .flat_map(|&k| members.iter().map(move |&member| (member, gains[k])))
        .collect();
    for &closed_loop in test.loops {
        let responses = task.responses_around(closed_loop, &cases)?;
        for (&k, responses) in candidates.iter().zip(responses.chunks_exact(members.len())) {
            let endings = responses.iter().map(|response| &response.ending);
            unrested.extend(goal.unrested(endings).map(|cost| (k, cost)));
        }
    }
    Ok(unrested)
}

/// Several swarms over gains that do not know of one another but are evaluated together.
#[derive(Debug)]
pub(crate) struct Swarms<'a> {
    config: &'a TunerConfig,
    swarms: Vec<Swarm<ChaCha8Rng>>,
    /// Gains so far that missed what is required.
    refused: u64,
    /// Costs and gains that were the best of a particle when it came there.
    kept: Vec<(f64, PidGains)>,
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
            refused: 0,
            kept: Vec::new(),
        })
    }

    /// Moves them to the end; `cost` sees the responses of all plants to each controller once, with the number of its
    /// swarm. Gains that miss what is required are not simulated.
    pub(crate) fn run<F: Fleet<Member: Sync, Error: Send> + Sync>(
        &mut self,
        task: &Task<'_, F>,
        members: &[F::Member],
        goal: &Goal<'_>,
        mut cost: impl FnMut(Seen, &[Response]) -> f64,
        mut progress: impl FnMut(&TuneProgress) -> ControlFlow<()>,
    ) -> Result<Termination, TaskError<F::Error>> {
        let mut history = Vec::new();
        for moves in 0..=self.config.moves {
            let asked = self.swarms.iter().flat_map(|swarm| swarm.ask());
            let gains: Vec<PidGains> = asked.map(|at| self.config.gains(at)).collect();
            let refused: Vec<Option<f64>> =
                gains.par_iter().map(|gains| goal.refused(gains)).collect();
            let accepted = gains.iter().zip(&refused);
            let cases: Vec<_> = accepted
                .filter(|(_, refused)| refused.is_none())
                .flat_map(|(&gains, _)| members.iter().map(move |&member| (member, gains)))
                .collect();
            let responses = task.responses(&cases)?;
            self.refused += refused.iter().flatten().count() as u64;
            let mut of_accepted = responses.chunks_exact(members.len());
            let n_particles = self.config.swarm.particles;
            let mut costs = Vec::with_capacity(gains.len());
            // Gains that would change a swarm have to rest; of others nobody asks.
            let mut candidates = Vec::new();
            for (k, (&gains, refused)) in gains.iter().zip(refused).enumerate() {
                let number = k / n_particles;
                costs.push(refused.unwrap_or_else(|| {
                    let responses = of_accepted.next().unwrap_or_default();
                    let cost = cost(Seen { number, gains }, responses);
                    let endings = responses.iter().map(|response| &response.ending);
                    if cost < self.swarms[number].best_costs()[k % n_particles] {
                        if let Some(unrested) = goal.unrested(endings) {
                            return unrested;
                        }
                        candidates.push(k);
                    }
                    cost
                }));
            }
            for (k, unrested) in unrested(task, members, goal, &gains, &candidates)? {
                costs[k] = unrested;
            }
            let is_sound = |k: &&usize| Goal::fault(costs[**k]).is_none();
            let sound = candidates.iter().filter(is_sound);
            self.kept.extend(sound.map(|&k| (costs[k], gains[k])));
            for (swarm, costs) in self.swarms.iter_mut().zip(costs.chunks_exact(n_particles)) {
                swarm.tell(costs).map_err(TuneError::Swarm)?;
            }
            let best = self.best().filter(|&(_, cost)| Goal::fault(cost).is_none());
            let wish = progress(&TuneProgress {
                moves,
                evaluations: self.evaluations(),
                best,
            });
            if wish.is_break() && moves < self.config.moves {
                return Ok(Termination::Observer);
            }
            history.push(best.map_or(f64::INFINITY, |(_, cost)| cost));
            let has_stalled = |stall: &Stall| stall.holds(&history);
            if best.is_some_and(|(_, cost)| self.agreeing(cost) >= AGREED)
                && self.config.stall.as_ref().is_some_and(has_stalled)
            {
                return Ok(Termination::Stall);
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

    /// Number of swarms that have come to a cost, to 1 %.
    fn agreeing(&self, cost: f64) -> usize {
        let alike = |swarm: &&Swarm<_>| swarm.best_cost().is_some_and(|one| one <= SAME * cost);
        self.swarms.iter().filter(alike).count()
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
