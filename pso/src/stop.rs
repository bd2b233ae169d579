use crate::SwarmError;
use crate::error::not_negative;
use std::fmt;
use std::time::Duration;

/// When a run ends: at the first of these that holds. All `None`: only the observer ends it.
///
/// Limits count from the start of the swarm, not of the call: a run to 100 and then to 200 iterations
/// is the run to 200. Only `time` counts from the call.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Moves of the swarm. The starts are evaluated before the first: 50 particles and 150 iterations
    /// are 50 + 50 × 150 = 7,550 evaluations. 0 evaluates the starts only.
    pub iterations: Option<u64>,
    /// Evaluations, never exceeded; >= number of particles.
    pub evaluations: Option<u64>,
    /// Cost that is good enough; finite.
    pub target: Option<f64>,
    /// No progress.
    pub stall: Option<Stall>,
    /// Time since the call, looked at after each iteration; > 0. The one limit that ends a run
    /// elsewhere on another machine.
    pub time: Option<Duration>,
}

impl Default for Stop {
    /// 150 iterations, as in [`Sadeghi`](crate#references), and nothing else.
    fn default() -> Self {
        Self {
            iterations: Some(150),
            evaluations: None,
            target: None,
            stall: None,
            time: None,
        }
    }
}

/// No progress: over the last `iterations` the best cost fell by no more than
/// `relative_improvement` times its magnitude before them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stall {
    /// Window; >= 1.
    pub iterations: u64,
    /// Fraction of the cost; finite, >= 0. With 0 any improvement counts.
    pub relative_improvement: f64,
}

impl Stall {
    /// True if `history`, the best cost after each evaluation of the swarm, has stalled.
    #[must_use]
    pub fn holds(self, history: &[f64]) -> bool {
        let window = usize::try_from(self.iterations).unwrap_or(usize::MAX);
        let Some(before) = history
            .len()
            .checked_sub(1)
            .and_then(|last| last.checked_sub(window))
        else {
            return false;
        };
        let (before, now) = (history[before], history[history.len() - 1]);
        let improved = if before.is_finite() {
            before - now > self.relative_improvement * before.abs()
        } else {
            // From +∞ every finite cost is progress; −∞ cannot be improved.
            now < before
        };
        !improved
    }
}

impl Stop {
    pub(crate) fn check(&self, particles: usize) -> Result<(), SwarmError> {
        if let Some(evaluations) = self.evaluations
            && evaluations < particles as u64
        {
            return Err(SwarmError::EvaluationsTooFew {
                evaluations,
                particles,
            });
        }
        if let Some(target) = self.target
            && !target.is_finite()
        {
            return Err(SwarmError::NotFinite {
                name: "stop.target",
                value: target,
            });
        }
        if let Some(stall) = self.stall {
            if stall.iterations == 0 {
                return Err(SwarmError::ZeroCount {
                    name: "stop.stall.iterations",
                });
            }
            not_negative(
                "stop.stall.relative_improvement",
                stall.relative_improvement,
            )?;
        }
        if self.time == Some(Duration::ZERO) {
            return Err(SwarmError::ZeroTime { name: "stop.time" });
        }
        Ok(())
    }
}

/// Why a run ended. Where several hold after the same iteration, the first in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
#[must_use]
pub enum Termination {
    /// The target cost was reached.
    Target,
    /// The best cost no longer fell.
    Stall,
    /// All iterations were made.
    Iterations,
    /// Another iteration would have exceeded the evaluations.
    Evaluations,
    /// The time was up.
    Time,
    /// The observer broke off.
    Observer,
}

impl fmt::Display for Termination {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Target => "target cost reached",
            Self::Stall => "no further improvement",
            Self::Iterations => "iteration limit reached",
            Self::Evaluations => "evaluation limit reached",
            Self::Time => "time limit reached",
            Self::Observer => "stopped by the observer",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stall_compares_the_ends_of_the_window() {
        let stall = Stall {
            iterations: 2,
            relative_improvement: 0.1,
        };
        assert!(!stall.holds(&[]));
        assert!(!stall.holds(&[1.0, 1.0]));
        assert!(stall.holds(&[1.0, 1.0, 1.0]));
        assert!(stall.holds(&[1.0, 0.96, 0.92]));
        assert!(!stall.holds(&[1.0, 0.96, 0.88]));
        assert!(!stall.holds(&[-1.0, -1.0, -1.2]));
        assert!(!stall.holds(&[f64::INFINITY, f64::INFINITY, 5.0]));
        assert!(stall.holds(&[f64::INFINITY; 3]));
        assert!(stall.holds(&[f64::NEG_INFINITY; 3]));
        assert!(!stall.holds(&[1.0, 1.0, f64::NEG_INFINITY]));
        let endless = Stall {
            iterations: u64::MAX,
            relative_improvement: 0.1,
        };
        assert!(!endless.holds(&[1.0; 3]));
    }
}
