use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::neldermead::NelderMead;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wiener::Fleet;

use crate::tuner::{SAME, unrested};
use crate::{Goal, PidGains, Task, TaskError, Terms, TuneError, Tuned, TunerConfig};

/// Iterations of a simplex, at most: three coordinates take some hundred.
const ITERATIONS: u64 = 300;
/// Size of the first simplex, in shares of the ranges.
const SIMPLEX: f64 = 0.05;
/// Spread of a simplex' costs, as a share of the optimum's, at which it has ended.
const ENDED: f64 = 1e-9;
/// Shares between which the other start is drawn.
const INTERIOR: [f64; 2] = [0.1, 0.9];

/// Where a simplex ended, and what that says of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opinion {
    /// Gains that it started from.
    pub start: PidGains,
    /// Gains where it ended.
    pub gains: PidGains,
    /// Terms there.
    pub terms: Terms,
    /// Cost there.
    pub cost: f64,
    /// Cost there over the lowest of the search; `NaN` if both are 0.
    pub ratio: f64,
    /// Verdict on the search.
    pub verdict: Verdict,
    /// Responses that it looked at.
    pub evaluations: u64,
}

/// Verdict on a search, by where a simplex ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Both ended at the same cost, to 1 %.
    Agrees,
    /// The simplex ended higher: it was caught on the way, which says nothing against the search.
    EndedHigher,
    /// The simplex ended lower: the search did not find the lowest cost.
    EndedLower,
}

/// The opinions of somebody else's optimizer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondOpinion {
    /// From where the search ended.
    pub from_optimum: Opinion,
    /// From a random point in the middle eight tenths of each scaled range.
    pub from_elsewhere: Opinion,
}

/// Minimizes the cost of a search again, by argmin's simplex (Nelder and Mead): from where the search ended, and
/// from elsewhere. Nothing but the responses is ours. `members`, `goal` and `config` are those of the
/// search.
///
/// Times of rise and settling make the cost a landscape with cliffs: a simplex that starts elsewhere is often
/// caught.
///
/// # Errors
///
/// As [`tune`](crate::tune), and [`TuneError::SecondOpinion`] if argmin fails.
pub fn second_opinion<F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    members: &[F::Member],
    goal: &Goal<'_>,
    config: &TunerConfig,
    tuned: &Tuned,
) -> Result<SecondOpinion, TaskError<F::Error>> {
    goal.check(task)?;
    config.check()?;
    if members.is_empty() {
        return Err(TuneError::Empty { name: "members" }.into());
    }
    let problem = ShareCost {
        task,
        members,
        goal,
        lowest: tuned.lowest,
        config,
    };
    // Not the stream of the search.
    let mut generator = ChaCha8Rng::seed_from_u64(!config.seed);
    let elsewhere = [(); 3].map(|()| {
        let [lower, upper] = INTERIOR;
        lower + unit(&mut generator) * (upper - lower)
    });
    Ok(SecondOpinion {
        from_optimum: opinion(problem, config.shares(&tuned.gains), tuned)?,
        from_elsewhere: opinion(problem, elsewhere, tuned)?,
    })
}

/// Uniform in [0, 1), from the upper 53 bits of a word: in our own code, so that a release of `rand` moves
/// nothing.
fn unit(generator: &mut impl Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn opinion<F: Fleet<Member: Sync, Error: Send> + Sync>(
    problem: ShareCost<'_, F>,
    start: [f64; 3],
    tuned: &Tuned,
) -> Result<Opinion, TaskError<F::Error>> {
    let corners = (0..start.len()).map(|coordinate| {
        let mut corner = start.to_vec();
        let towards_middle = if start[coordinate] > 0.5 { -1.0 } else { 1.0 };
        corner[coordinate] += towards_middle * SIMPLEX;
        corner
    });
    let simplex = std::iter::once(start.to_vec()).chain(corners).collect();
    let solver = NelderMead::new(simplex)
        .with_sd_tolerance(ENDED * tuned.lowest)
        .map_err(failed)?;
    let end = Executor::new(problem, solver)
        .configure(|state| state.max_iters(ITERATIONS))
        .timer(false)
        .run()
        .map_err(failed)?;
    let (state, counts) = (end.state, end.problem.counts);
    let gains = problem.gains(&state.best_param.unwrap_or_else(|| start.to_vec()));
    let cost = problem.cost_of(gains)?;
    let terms = problem.task.response(problem.members[0], gains)?.terms;
    Ok(Opinion {
        start: problem.gains(&start),
        gains,
        terms,
        cost,
        ratio: cost / tuned.lowest,
        verdict: verdict(cost, tuned),
        evaluations: counts.get("cost_count").copied().unwrap_or(0),
    })
}

/// In products: both costs may be 0.
fn verdict(cost: f64, tuned: &Tuned) -> Verdict {
    if cost * SAME < tuned.lowest {
        Verdict::EndedLower
    } else if cost <= SAME * tuned.lowest {
        Verdict::Agrees
    } else {
        Verdict::EndedHigher
    }
}

fn failed(source: Error) -> TuneError {
    TuneError::SecondOpinion {
        said: source.to_string(),
    }
}

/// The cost over shares of the ranges; outside, that of the nearest point inside and more.
struct ShareCost<'a, F: Fleet> {
    task: &'a Task<'a, F>,
    members: &'a [F::Member],
    goal: &'a Goal<'a>,
    /// Cost of the search's end.
    lowest: f64,
    config: &'a TunerConfig,
}

impl<F: Fleet> Clone for ShareCost<'_, F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F: Fleet> Copy for ShareCost<'_, F> {}

impl<F: Fleet> ShareCost<'_, F> {
    fn gains(&self, shares: &[f64]) -> PidGains {
        let inside: Vec<f64> = shares.iter().map(|share| share.clamp(0.0, 1.0)).collect();
        self.config.gains(&inside)
    }
}

impl<F: Fleet<Member: Sync, Error: Send> + Sync> ShareCost<'_, F> {
    fn cost_of(&self, gains: PidGains) -> Result<f64, TaskError<F::Error>> {
        if let Some(cost) = self.goal.refused(&gains) {
            return Ok(cost);
        }
        let cases: Vec<_> = self.members.iter().map(|&member| (member, gains)).collect();
        let responses = self.task.responses(&cases)?;
        let endings = responses.iter().map(|response| &response.ending);
        if let Some(unrested) = self.goal.unrested(endings) {
            return Ok(unrested);
        }
        let cost = self.goal.cost_of_all(&responses);
        // What costs more than the search's end need not rest: it is no objection.
        if cost >= self.lowest {
            return Ok(cost);
        }
        let unrested = unrested(self.task, self.members, self.goal, &[gains], &[0])?;
        Ok(unrested.first().map_or(cost, |&(_, cost)| cost))
    }
}

impl<F: Fleet<Member: Sync, Error: Send> + Sync> CostFunction for ShareCost<'_, F> {
    type Param = Vec<f64>;
    type Output = f64;

    /// Never fails, as argmin's solver wants it: what has no cost costs ∞.
    fn cost(&self, shares: &Vec<f64>) -> Result<f64, Error> {
        let outside: f64 = shares
            .iter()
            .map(|share| (share - share.clamp(0.0, 1.0)).powi(2))
            .sum();
        let cost = self.cost_of(self.gains(shares)).unwrap_or(f64::INFINITY);
        let cost = cost * (1.0 + outside);
        Ok(if cost.is_nan() { f64::INFINITY } else { cost })
    }
}
