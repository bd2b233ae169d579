use crate::{Bound, Progress, Report, Stop, Swarm, SwarmConfig, SwarmError};
use rand::Rng;
use std::ops::ControlFlow;

/// Minimizes a cost: the whole loop around [`Swarm`].
///
/// For checkpoints, or costs that are computed many at a time, use [`Swarm::run`] or
/// [`Swarm::ask`] and [`Swarm::tell`]; the bits are the same.
///
/// # Errors
///
/// Settings, bounds, starts or limits that are not accepted ([`SwarmError`]). Ending without a finite
/// cost is not an error: [`Report::best`] is then `None`.
///
/// # Examples
///
/// ```
/// use pso::{Bound, Stall, Stop, SwarmConfig, Termination, minimize};
/// use rand::SeedableRng;
/// use rand_chacha::ChaCha8Rng;
/// use std::ops::ControlFlow;
///
/// // Stop early where a longer search buys nothing, but say so.
/// let stop = Stop {
///     stall: Some(Stall { iterations: 30, relative_improvement: 1e-3 }),
///     ..Stop::default()
/// };
/// let report = minimize(
///     SwarmConfig::default(),
///     &[Bound { lower: 0.0, upper: 4.0 }],
///     &stop,
///     ChaCha8Rng::seed_from_u64(7),
///     |x| 1.0 + (x[0] - 3.0).abs(),
///     |_| ControlFlow::Continue(()),
/// )?;
/// assert_eq!(report.termination, Termination::Stall);
/// assert!(report.best.is_some_and(|best| (best.point[0] - 3.0).abs() < 1e-3));
/// # Ok::<(), pso::SwarmError>(())
/// ```
pub fn minimize<R: Rng>(
    config: SwarmConfig,
    bounds: &[Bound],
    stop: &Stop,
    generator: R,
    mut cost: impl FnMut(&[f64]) -> f64,
    observer: impl FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Report, SwarmError> {
    let mut swarm = Swarm::new(config, bounds, generator)?;
    let termination = swarm.run(
        stop,
        |points| points.iter().map(|point| cost(point)).collect(),
        observer,
    )?;
    Ok(swarm.report(termination))
}

/// [`minimize`] with the costs of an iteration on the threads of the current rayon pool.
///
/// The result has the bits of `minimize` for any number of threads: random numbers are drawn between
/// the evaluations, and costs are gathered in the order of the particles.
///
/// # Errors
///
/// As [`minimize`].
#[cfg(feature = "rayon")]
pub fn minimize_parallel<R: Rng>(
    config: SwarmConfig,
    bounds: &[Bound],
    stop: &Stop,
    generator: R,
    cost: impl Fn(&[f64]) -> f64 + Sync,
    observer: impl FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Report, SwarmError> {
    use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

    let mut swarm = Swarm::new(config, bounds, generator)?;
    let termination = swarm.run(
        stop,
        |points| points.par_iter().map(|point| cost(point)).collect(),
        observer,
    )?;
    Ok(swarm.report(termination))
}
