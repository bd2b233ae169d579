use crate::{Stop, Swarm, SwarmError, Termination};
use rand::Rng;
use std::ops::ControlFlow;
use std::time::Instant;

/// Progress of a run, as an observer sees it after each evaluation of the swarm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// Moves so far; 0 after the starts.
    pub iterations: u64,
    /// Evaluations so far.
    pub evaluations: u64,
    /// Lowest cost so far, `None` while all were +∞ or NaN.
    pub best_cost: Option<f64>,
    /// Its point.
    pub best_point: Option<&'a [f64]>,
    /// Costs so far that were NaN.
    pub rejected_costs: u64,
}

/// The lowest cost and its point.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// Point, one number for each bound.
    pub point: Vec<f64>,
    /// Its cost, below +∞.
    pub cost: f64,
}

/// Result of a run.
///
/// The seed is not in it: the generator was passed in, and only the caller knows what it was made
/// from. Write it beside the report.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Best of all evaluations; `None` if all costs were +∞ or NaN.
    pub best: Option<Best>,
    /// Why the run ended.
    pub termination: Termination,
    /// Moves of the swarm; the evaluation of the starts is not one.
    pub iterations: u64,
    /// Evaluations: (1 + iterations) × particles.
    pub evaluations: u64,
    /// Costs that were NaN; they counted as +∞.
    pub rejected_costs: u64,
}

impl<R: Rng> Swarm<R> {
    /// Runs until `stop` or the observer ends it, with costs of a whole iteration at a time.
    ///
    /// `evaluate` gets the points of all particles and returns their costs in the same order. The
    /// observer is called after each evaluation of the swarm, the starts included;
    /// [`ControlFlow::Break`] ends the run unless a limit has done so, and another call goes on.
    /// Calls with limits of 1, 2, …, N iterations give the bits of one call with N.
    ///
    /// # Errors
    ///
    /// A limit that [`Stop`] does not accept; not one cost for each particle.
    pub fn run(
        &mut self,
        stop: &Stop,
        mut evaluate: impl FnMut(&[Vec<f64>]) -> Vec<f64>,
        mut observer: impl FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Termination, SwarmError> {
        let begin = Instant::now();
        let mut ended = self.finished(stop)?;
        while ended.is_none() {
            let costs = evaluate(self.ask());
            self.tell(&costs)?;
            let wish = observer(&self.progress());
            ended = self.finished(stop)?;
            if ended.is_none() && stop.time.is_some_and(|limit| begin.elapsed() >= limit) {
                ended = Some(Termination::Time);
            }
            if ended.is_none() && wish.is_break() {
                ended = Some(Termination::Observer);
            }
        }
        let Some(termination) = ended else {
            unreachable!("the loop ends with a reason");
        };
        Ok(termination)
    }

    /// The state of the search, as an observer sees it.
    #[must_use]
    pub fn progress(&self) -> Progress<'_> {
        Progress {
            iterations: self.iterations(),
            evaluations: self.evaluations(),
            best_cost: self.best_cost(),
            best_point: self.best_point(),
            rejected_costs: self.rejected_costs(),
        }
    }

    /// The state of the search as a result, with the reason that [`Swarm::run`] gave.
    #[must_use]
    pub fn report(&self, termination: Termination) -> Report {
        let best = self.best_point().zip(self.best_cost());
        Report {
            best: best.map(|(point, cost)| Best {
                point: point.to_vec(),
                cost,
            }),
            termination,
            iterations: self.iterations(),
            evaluations: self.evaluations(),
            rejected_costs: self.rejected_costs(),
        }
    }
}
