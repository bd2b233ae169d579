use crate::error::not_negative;
use crate::{CostWeights, Ending, PidGains, Response, RestTest, Screen, Task, TuneError};

/// Cost beside which that of every response is small: of gains that miss what is required.
const UNMET: f64 = 1e100;
/// Cost of gains that meet the requirements, and do not rest.
const UNRESTED: f64 = 1e50;

/// Cost and requirements of a search.
#[derive(Debug, Clone, Copy)]
pub struct Goal<'a> {
    /// Weights of eq. 13.
    pub weights: CostWeights,
    /// Weight of the way that the drive goes in the last eighth of a run, in its unit per second: what a drive at rest
    /// costs in wear and in wire; ≥ 0.
    pub wear: f64,
    /// Requirements; `None` asks for nothing, as in the paper.
    pub screen: Option<&'a Screen>,
    /// Runs that have to end at rest; `None` asks for nothing.
    pub rest: Option<RestTest<'a>>,
    /// How the costs of several plants are combined.
    pub across: Across,
}

/// How the costs of one controller on several plants are combined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Across {
    /// The largest.
    Worst,
    /// Their mean.
    Mean,
}

impl Goal<'_> {
    /// The paper's: eq. 13 and nothing else.
    #[must_use]
    pub fn of(weights: CostWeights) -> Self {
        Self {
            weights,
            wear: 0.0,
            screen: None,
            rest: None,
            across: Across::Worst,
        }
    }

    /// Cost of one response.
    #[must_use]
    pub fn cost(&self, response: &Response) -> f64 {
        self.weights.cost(&response.terms) + self.wear * response.ending.travel_per_s
    }

    /// Cost of one controller on several plants; `NaN` if one of them is.
    pub(crate) fn cost_of_all(&self, responses: &[Response]) -> f64 {
        let costs = || responses.iter().map(|response| self.cost(response));
        match self.across {
            Across::Worst => costs().fold(f64::NEG_INFINITY, |worst, cost| {
                if worst.is_nan() || cost.is_nan() {
                    f64::NAN
                } else {
                    worst.max(cost)
                }
            }),
            Across::Mean => costs().sum::<f64>() / responses.len() as f64,
        }
    }

    /// Cost of gains that need not be simulated, since they miss what is required.
    pub(crate) fn refused(&self, gains: &PidGains) -> Option<f64> {
        let shortfall = self.screen?.shortfall(gains);
        (shortfall > 0.0).then_some(UNMET * (1.0 + shortfall))
    }

    /// Cost of gains whose loop does not rest in one of these endings.
    pub(crate) fn unrested<'e>(
        &self,
        mut endings: impl Iterator<Item = &'e Ending>,
    ) -> Option<f64> {
        let test = self.rest.as_ref()?;
        let unrest = endings.find_map(|ending| test.unrest(ending))?;
        Some(UNRESTED * (1.0 + unrest))
    }

    /// Fault of gains of a cost: none, or that they miss what is required, or do not rest.
    pub(crate) fn fault(cost: f64) -> Option<TuneError> {
        if cost >= UNMET {
            Some(TuneError::Unmet)
        } else if cost >= UNRESTED {
            Some(TuneError::NoRest)
        } else {
            None
        }
    }

    /// Accepts weights of which one counts for the task.
    pub(crate) fn check<F>(&self, task: &Task<'_, F>) -> Result<(), TuneError> {
        let CostWeights {
            mse,
            energy,
            rise_time,
            settling_time,
            overshoot,
        } = self.weights.checked()?;
        not_negative("wear", self.wear)?;
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
}
