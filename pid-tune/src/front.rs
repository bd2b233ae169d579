use std::ops::ControlFlow;

use wiener::Fleet;

use crate::error::positive;
use crate::tuner::{Seen, Swarms, unrested};
use crate::{Goal, PidGains, Response, Task, TaskError, Terms, TuneError, TunerConfig};

/// Decades by which the weights of accuracy and energy are shifted against one another, each by as much: one
/// swarm for each.
const SHIFTS: [f64; 7] = [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5];

/// One controller of a front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrontPoint {
    /// Its gains.
    pub gains: PidGains,
    /// Terms of its response.
    pub terms: Terms,
}

/// Pareto front of mean square error and energy: the controllers of which none is better than another in both.
/// Sorted: the error rises from point to point, the energy falls.
///
/// Seven swarms (`starts` is not used) search with the two weights in ratios of 10⁻³ to 10³ of those given. The front
/// is that of all responses they looked at. It therefore has the points of its hollows too, where no weighted sum has
/// its minimum. Of controllers with equal terms it has the one seen first.
///
/// Of several plants the first counts. Gains that miss the requirements of `goal` are not on the front.
///
/// If the bounds allow it, the front ends at zero energy. Its bits are the same for any number of threads.
///
/// # Errors
///
/// [`TuneError::NotPositive`] unless the weights of `mse` and `energy` are > 0 (the others are not used), else
/// as [`tune`](crate::tune).
pub fn front<F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    members: &[F::Member],
    goal: &Goal<'_>,
    config: &TunerConfig,
) -> Result<Vec<FrontPoint>, TaskError<F::Error>> {
    config.check()?;
    let weights = goal.weights;
    positive("mse", weights.mse)?;
    positive("energy", weights.energy)?;
    let accuracies = SHIFTS.map(libm::exp10);
    let mut front = Vec::new();
    let cost = |seen: Seen, responses: &[Response]| {
        let Some(Response { terms, .. }) = responses.first() else {
            return f64::NAN;
        };
        let accuracy = accuracies[seen.number];
        front.push(FrontPoint {
            gains: seen.gains,
            terms: *terms,
        });
        weights.mse * accuracy * terms.mse + weights.energy / accuracy * terms.energy
    };
    // Swarms that look for different things do not agree.
    let config = &TunerConfig {
        stall: None,
        ..config.clone()
    };
    let mut swarms = Swarms::new(config, SHIFTS.len())?;
    let _to_the_end = swarms.run(task, members, goal, cost, |_| ControlFlow::Continue(()))?;
    keep_front(&mut front);
    if goal.rest.is_some() {
        let gains: Vec<PidGains> = front.iter().map(|point| point.gains).collect();
        let all: Vec<usize> = (0..gains.len()).collect();
        let mut rests = vec![true; gains.len()];
        for (k, _) in unrested(task, members, goal, &gains, &all)? {
            rests[k] = false;
        }
        let mut rests = rests.into_iter();
        front.retain(|_| rests.next().unwrap_or(false));
    }
    if front.is_empty() {
        return Err(TuneError::NoFiniteCost.into());
    }
    Ok(front)
}

/// Leaves the points that no other point is at least as good as in both terms, sorted.
fn keep_front(points: &mut Vec<FrontPoint>) {
    points.retain(|point| point.terms.mse.is_finite() && point.terms.energy.is_finite());
    // Stable: of equal points the first stays.
    points.sort_by(|a, b| {
        let by_error = a.terms.mse.total_cmp(&b.terms.mse);
        by_error.then(a.terms.energy.total_cmp(&b.terms.energy))
    });
    let mut least_energy = f64::INFINITY;
    points.retain(|point| {
        let keeps = point.terms.energy < least_energy;
        least_energy = least_energy.min(point.terms.energy);
        keeps
    });
}
