//! Starts of a fit: a swarm and a search on fewer samples find a basin, a search on all of them its floor.

use pso::{Bound, Stop, Swarm};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use recording::Recording;

use crate::ended::Basin;
use crate::fit_config::FitConfig;
use crate::least_squares::{LeastSquaresConfig, Minimum, SumOfSquares, minimize};
use crate::own_anew::own_anew;
use crate::problem::Problem;
use crate::tasks::try_in_parallel;
use crate::thinned::{are_near_time_constant, thinned};
use crate::{EndedStart, IdentifyError, ParameterVector};

/// Samples of all recordings together on which a basin is sought; on more of them if these do not tell the time constant.
const RUNGS: [usize; 2] = [500, 2_000];

/// The search on them is no longer than this: another one follows on all samples.
const NEAR: LeastSquaresConfig = LeastSquaresConfig {
    iterations: 40,
    relative_offset: 1e-3,
    least_gain: 1e-4,
};

/// Where a start begins.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Start<'a> {
    /// At a point.
    Point(&'a [f64]),
    /// At the best point of a swarm, which takes this stream of the seed.
    Swarm(u64),
}

/// A start before its search on all samples.
#[derive(Debug)]
pub(crate) enum Begun {
    /// That was made before.
    Ended(EndedStart),
    /// That begins at a point.
    At {
        point: Vec<f64>,
        /// Where the point is from, if a search on fewer samples led there.
        basin: Option<Basin>,
        rejected_costs: u64,
        simulations: u64,
    },
}

/// The recordings with fewer samples, the fewest first.
pub(crate) fn ladder(training: &[Recording]) -> Result<Vec<Vec<Recording>>, IdentifyError> {
    let rungs = RUNGS.iter().map(|&enough| thinned(training, enough));
    rungs.filter_map(Result::transpose).collect()
}

impl Start<'_> {
    /// Begins on a problem of its own: what one start has solved is nothing to the others, so that all of them
    /// count the same on any number of threads.
    pub(crate) fn begun(
        self,
        problem: &Problem<'_>,
        rungs: &[Problem<'_>],
        config: &FitConfig,
    ) -> Result<Begun, IdentifyError> {
        let stream = match self {
            Start::Point(point) if point.len() != problem.vector().len() => {
                return Err(IdentifyError::StartLength {
                    found: point.len(),
                    expected: problem.vector().len(),
                });
            }
            Start::Point(point) => {
                return Ok(Begun::At {
                    point: point.to_vec(),
                    basin: None,
                    rejected_costs: 0,
                    simulations: 0,
                });
            }
            Start::Swarm(stream) => stream,
        };
        let mut simulations = 0;
        for few in rungs {
            let own = few.apart();
            let (best, rejected_costs) = swarm_start(&own, config, stream)?;
            let basin = basin(&own, &best)?;
            // One of them takes as long as the share of the samples that it has.
            let share = own.n_samples() as f64 / problem.n_samples() as f64;
            simulations += (own.simulations() as f64 * share).ceil() as u64;
            if let Some(basin) = basin {
                return Ok(Begun::At {
                    point: basin.point.clone(),
                    basin: Some(basin),
                    rejected_costs,
                    simulations,
                });
            }
        }
        let own = problem.apart();
        let (point, rejected_costs) = swarm_start(&own, config, stream)?;
        Ok(Begun::At {
            point,
            basin: None,
            rejected_costs,
            simulations: simulations + own.simulations(),
        })
    }
}

/// Where starts so far began their search on all samples, each with its end.
#[derive(Debug, Default)]
pub(crate) struct Places {
    known: Vec<Place>,
}

#[derive(Debug)]
struct Place {
    basin: Option<Basin>,
    end: Option<Minimum>,
    /// Simulations of the search from there, until a start has them in its own.
    simulations: u64,
}

impl Places {
    /// Completes starts that follow those so far. A basin is searched on all samples once, from where the first of all starts found it.
    pub(crate) fn complete(
        &mut self,
        begun: &[(u64, Begun)],
        problem: &Problem<'_>,
        config: &FitConfig,
    ) -> Result<Vec<EndedStart>, IdentifyError> {
        let mut places = Vec::new();
        let mut open: Vec<(usize, &[f64])> = Vec::new();
        for (_, begun) in begun {
            let place = self.of(begun, problem.bounds());
            if let Begun::At { point, .. } = begun
                && self.known[place].end.is_none()
                && !open.iter().any(|&(other, _)| other == place)
            {
                open.push((place, point));
            }
            places.push(place);
        }
        let ends = try_in_parallel(&open, |&(place, point)| {
            let own = problem.apart();
            let mut end = minimize(&own, own.bounds(), point, &config.least_squares)?;
            // Of a basin that was done on fewer samples.
            if self.known[place].basin.is_none() {
                end = own_anew(&own, end, &config.least_squares)?;
            }
            Ok((end, own.simulations()))
        })?;
        for (&(place, _), (end, simulations)) in open.iter().zip(ends) {
            self.known[place].end = Some(end);
            self.known[place].simulations = simulations;
        }
        let ended = begun.iter().zip(places).map(|((start, begun), place)| {
            let (basin, rejected_costs, simulations) = match begun {
                Begun::Ended(ended) => return ended.clone(),
                Begun::At {
                    basin,
                    rejected_costs,
                    simulations,
                    ..
                } => (basin.clone(), *rejected_costs, *simulations),
            };
            let place = &mut self.known[place];
            let Some(minimum) = place.end.clone() else {
                unreachable!("a place without an end was searched");
            };
            EndedStart {
                seed: config.seed,
                start: *start,
                minimum,
                basin,
                rejected_costs,
                simulations: simulations + std::mem::take(&mut place.simulations),
            }
        });
        Ok(ended.collect())
    }

    /// The number of the place where a start begins its search on all samples: a new one, if none is known in its basin.
    fn of(&mut self, begun: &Begun, bounds: &[Bound]) -> usize {
        let (basin, end) = match begun {
            Begun::Ended(ended) => (&ended.basin, Some(&ended.minimum)),
            Begun::At { basin, .. } => (basin, None),
        };
        let is_it = |place: &Place| match (basin, &place.basin) {
            (Some(one), Some(other)) => one.is(other, bounds),
            _ => false,
        };
        self.known.iter().position(is_it).unwrap_or_else(|| {
            self.known.push(Place {
                basin: basin.clone(),
                end: end.cloned(),
                simulations: 0,
            });
            self.known.len() - 1
        })
    }
}

/// Where a search on fewer samples ends; `None` where its time constant is too short for what they have.
fn basin(few: &Problem<'_>, start: &[f64]) -> Result<Option<Basin>, IdentifyError> {
    let end = minimize(few, few.bounds(), start, &NEAR)?;
    let end = own_anew(few, end, &NEAR)?;
    let tau_s = tau_s(few.vector(), &end.point);
    let is_told = tau_s.is_none_or(|tau_s| are_near_time_constant(few.recordings(), tau_s));
    Ok(is_told.then(|| Basin {
        n_samples: few.n_samples(),
        point: end.point,
        sum_of_squares: end.sum_of_squares,
    }))
}

fn tau_s(vector: &ParameterVector, point: &[f64]) -> Option<f64> {
    let mut infos = vector.infos().iter();
    let place = infos.position(|info| info.name == "tau_s")?;
    Some(vector.values(point, 0)[place])
}

/// The best point of a short swarm, and how many costs were no numbers.
fn swarm_start(
    problem: &Problem<'_>,
    config: &FitConfig,
    stream: u64,
) -> Result<(Vec<f64>, u64), IdentifyError> {
    let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
    rng.set_stream(stream);
    let mut swarm = Swarm::new(config.swarm.clone(), problem.bounds(), rng)?;
    let stop = Stop {
        iterations: Some(config.swarm_iterations),
        ..Stop::default()
    };
    while swarm.finished(&stop)?.is_none() {
        let costs = problem.sums(swarm.ask())?;
        swarm.tell(&costs)?;
    }
    // Where no cost was finite the middle is as good as any.
    let best = swarm.best_point().map(<[f64]>::to_vec);
    Ok((
        best.unwrap_or_else(|| problem.middle()),
        swarm.rejected_costs(),
    ))
}
