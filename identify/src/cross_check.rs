//! Cross-check of a fit: argmin's optimizers on its cost.

use std::borrow::Borrow;

use argmin::core::{CostFunction, Error, Executor, SyncAlias};
use argmin::solver::neldermead::NelderMead;
use argmin::solver::particleswarm::ParticleSwarm;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use recording::Recording;

use crate::fit::huber_weights;
use crate::least_squares::SumOfSquares;
use crate::moments::BATCH;
use crate::problem::Problem;
use crate::{Fit, ForwardModel, IdentifyError, Loss, Scope};

/// Moves of argmin's swarm.
const SWARM_MOVES: u64 = 60;
/// Iterations of argmin's simplex: a coordinate takes some fifty.
const SIMPLEX_ITERATIONS: u64 = 600;
/// Size of the first simplex, as a share of each range.
const SIMPLEX: f64 = 0.02;
/// Spread of the simplex' costs, as a share of the lowest, at which it has ended.
const ENDED: f64 = 1e-9;
/// Ratio of costs up to which two ends are the same floor.
const SAME: f64 = 1.01;

/// Where argmin ended on the same cost.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossCheck {
    /// Root mean square of recording - model where argmin ended, in the output unit.
    pub rmse: f64,
    /// Cost there over that of the fit.
    pub ratio: f64,
    /// Verdict on the fit, by that ratio.
    pub verdict: CrossVerdict,
    /// The shared parameters there: name, value, unit.
    pub shared: Vec<(&'static str, f64, String)>,
    /// Simulations of the whole training set.
    pub simulations: u64,
}

/// Verdict of argmin's result on a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrossVerdict {
    /// Both ended at the same floor.
    Agrees,
    /// Argmin ended higher: it was caught on the way, which says nothing against the fit.
    EndedHigher,
    /// Argmin ended lower: the fit is not the lowest minimum.
    EndedLower,
}

/// Minimizes the mean square of a fit by argmin: its particle swarm from its own start, then its simplex
/// (Nelder and Mead) from where that ended. Nothing but the simulations is ours.
///
/// The cost is that of the fit where it ended: recorded temperatures and samples keep the weights they had
/// there.
///
/// # Errors
///
/// Any error of the model, and [`IdentifyError::CrossCheck`] if argmin fails.
pub fn cross_check(
    model: &dyn ForwardModel,
    training: &[Recording],
    fit: &Fit,
) -> Result<CrossCheck, IdentifyError> {
    let (problem, fitted) = at_the_end(model, training, fit)?;
    let bounds = problem.bounds();
    // Ranges differ by orders of magnitude: argmin sees shares of them.
    let cost = UnitCost { problem: &problem };
    let dimensions = bounds.len();
    let ends = (vec![0.0; dimensions], vec![1.0; dimensions]);
    let swarm =
        ParticleSwarm::new(ends, BATCH).with_rng_generator(ChaCha8Rng::seed_from_u64(!fit.seed));
    let swarm = Executor::new(cost, swarm)
        .configure(|state| state.max_iters(SWARM_MOVES))
        .timer(false)
        .run()
        .map_err(failed)?;
    let start = match swarm.state.best_individual {
        Some(best) => best.position,
        None => vec![0.5; dimensions],
    };
    let corners = (0..dimensions).map(|j| {
        let mut corner = start.clone();
        corner[j] += if corner[j] > 0.5 { -SIMPLEX } else { SIMPLEX };
        corner
    });
    let simplex = std::iter::once(start.clone()).chain(corners).collect();
    let floor = problem.sums(&[cost.coordinates(&start)])?[0];
    let simplex = NelderMead::new(simplex)
        .with_sd_tolerance(ENDED * floor)
        .map_err(failed)?;
    let end = Executor::new(cost, simplex)
        .configure(|state| state.max_iters(SIMPLEX_ITERATIONS))
        .timer(false)
        .run()
        .map_err(failed)?;
    let point = cost.coordinates(end.state.best_param.as_ref().unwrap_or(&start));
    let sums = problem.sums(&[point.clone(), fitted])?;
    let ratio = (sums[0] + problem.rounding()) / (sums[1] + problem.rounding());
    let residuals = problem.residuals(&point, &problem.solve_one(&point)?)?;
    let squares: f64 = residuals
        .iter()
        .flat_map(|one| &one.values)
        .map(|value| value * value)
        .sum();
    let values = problem.vector().values(&point, 0);
    let shared = problem.vector().infos().iter().zip(values);
    Ok(CrossCheck {
        rmse: (squares / problem.n_samples() as f64).sqrt(),
        ratio,
        verdict: if ratio > SAME {
            CrossVerdict::EndedHigher
        } else if ratio < 1.0 / SAME {
            CrossVerdict::EndedLower
        } else {
            CrossVerdict::Agrees
        },
        shared: shared
            .filter(|(info, _)| info.scope == Scope::Shared)
            .map(|(info, value)| (info.name, value, info.unit.clone()))
            .collect(),
        simulations: problem.simulations(),
    })
}

/// The problem with the weights of a fit's last round, and the coordinates of that fit.
fn at_the_end<'a>(
    model: &'a dyn ForwardModel,
    training: &'a [Recording],
    fit: &Fit,
) -> Result<(Problem<'a>, Vec<f64>), IdentifyError> {
    let mut problem = Problem::new(model, training)?;
    let fitted = fit.coordinates(problem.vector());
    if let Some(per_k) = fit.output_per_k() {
        problem.weigh_temperature(per_k.powi(2));
    }
    if fit.loss == Loss::Huber {
        let residuals = problem.residuals(&fitted, &problem.solve_one(&fitted)?)?;
        problem.weigh_samples(huber_weights(&residuals));
    }
    Ok((problem, fitted))
}

fn failed(source: Error) -> IdentifyError {
    IdentifyError::CrossCheck {
        said: source.to_string(),
    }
}

/// The sum of squares over the unit cube; outside, that of the nearest point of it and more.
#[derive(Clone, Copy)]
struct UnitCost<'a> {
    problem: &'a Problem<'a>,
}

impl UnitCost<'_> {
    fn coordinates(&self, shares: &[f64]) -> Vec<f64> {
        shares
            .iter()
            .zip(self.problem.bounds())
            .map(|(share, bound)| bound.at(share.clamp(0.0, 1.0)))
            .collect()
    }

    fn costs(&self, points: &[&Vec<f64>]) -> Result<Vec<f64>, Error> {
        let inside: Vec<Vec<f64>> = points.iter().map(|point| self.coordinates(point)).collect();
        let sums = self.problem.sums(&inside)?;
        let outside = |point: &Vec<f64>| -> f64 {
            point.iter().map(|x| (x - x.clamp(0.0, 1.0)).powi(2)).sum()
        };
        let cost = |(sum, point): (&f64, &&Vec<f64>)| {
            let cost = sum * (1.0 + outside(point));
            if cost.is_nan() { f64::INFINITY } else { cost }
        };
        Ok(sums.iter().zip(points).map(cost).collect())
    }
}

impl CostFunction for UnitCost<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, point: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.costs(&[point])?[0])
    }

    /// All particles side by side.
    fn bulk_cost<P: Borrow<Vec<f64>> + SyncAlias>(&self, points: &[P]) -> Result<Vec<f64>, Error> {
        let points: Vec<&Vec<f64>> = points.iter().map(Borrow::borrow).collect();
        self.costs(&points)
    }
}
