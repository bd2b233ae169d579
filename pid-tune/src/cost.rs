use crate::error::{not_negative, positive};
use crate::step_response::{SETTLED, StepResponse};
use crate::{Reference, Snapshot, StepTerms, TuneError};

/// Terms of eq. 13 for one response of n samples.
///
/// ```text
/// MSE = Σ (r_k - y_k)²/n
/// Energy = ½ Σ u_k² Δt      [Sadeghi, eq. 14]
/// ```
///
/// with reference r, true output y and the drive u that acts: the saturated one, because what a controller wants
/// beyond its limits would be 100 A at first and decide everything.
///
/// # Differs from the source
///
/// Eq. 14 is printed as an integral from 1 to n over samples; it is the sum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Mean square error, in the output's unit squared; `NaN` without samples.
    pub mse: f64,
    /// Energy, in the drive's unit squared times s: A² s for a current; times the resistance it is half of the heat.
    /// The square of a duty or a power is no energy.
    pub energy: f64,
    /// Terms that only a step response has; `None` for other references, and for a step at the last sample or
    /// later.
    pub step: Option<StepTerms>,
}

/// Collects the terms of eq. 13 while `L` loops run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponseTerms<const L: usize = 1> {
    dt_s: f64,
    n_samples: usize,
    /// Σ (r - y)².
    squared_error: [f64; L],
    /// Σ u².
    squared_drive: [f64; L],
    step: Option<StepResponse<L>>,
}

impl<const L: usize> ResponseTerms<L> {
    /// For loops over a reference at a sample time, s.
    ///
    /// # Errors
    ///
    /// Those of [`Reference::checked`], [`TuneError::NotPositive`] for the sample time.
    pub fn new(reference: &Reference<'_>, dt_s: f64) -> Result<Self, TuneError> {
        positive("dt_s", dt_s)?;
        let step = match reference.checked()? {
            Reference::Step { to, at_s, .. } => Some(StepResponse::new(to, at_s)),
            _ => None,
        };
        Ok(Self {
            dt_s,
            n_samples: 0,
            squared_error: [0.0; L],
            squared_drive: [0.0; L],
            step,
        })
    }

    /// Adds a sample; one after another from the first on.
    #[inline(always)]
    pub fn add(&mut self, snapshot: &Snapshot<L>) {
        self.n_samples += 1;
        for l in 0..L {
            let error = snapshot.setpoint - snapshot.output[l];
            self.squared_error[l] += error * error;
            self.squared_drive[l] += snapshot.drive[l] * snapshot.drive[l];
        }
        if let Some(step) = &mut self.step {
            step.add(snapshot, self.dt_s);
        }
    }

    /// The terms of the samples so far, for each lane.
    #[must_use]
    pub fn terms(&self) -> [Terms; L] {
        core::array::from_fn(|l| Terms {
            mse: self.squared_error[l] / self.n_samples as f64,
            energy: 0.5 * self.squared_drive[l] * self.dt_s,
            step: self.step.and_then(|step| step.terms(l, self.dt_s)),
        })
    }
}

/// Weights w of eq. 13; each finite and ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CostWeights {
    /// Weight of [`Terms::mse`].
    pub mse: f64,
    /// Weight of [`Terms::energy`].
    pub energy: f64,
    /// Weight of [`StepTerms::rise_time_s`].
    pub rise_time: f64,
    /// Weight of [`StepTerms::settling_time_s`].
    pub settling_time: f64,
    /// Weight of [`StepTerms::overshoot`].
    pub overshoot: f64,
}

impl CostWeights {
    /// Checks the weights.
    ///
    /// # Errors
    ///
    /// [`TuneError::Negative`] unless finite and ≥ 0.
    pub fn checked(self) -> Result<Self, TuneError> {
        not_negative("mse", self.mse)?;
        not_negative("energy", self.energy)?;
        not_negative("rise_time", self.rise_time)?;
        not_negative("settling_time", self.settling_time)?;
        not_negative("overshoot", self.overshoot)?;
        Ok(self)
    }

    /// Weights with which each term of a response counts one: "balances the dimensions of the objectives", as
    /// the paper says of its own, which it does not print.
    ///
    /// An overshoot of less than the settling band, 2 %, counts as 2 %: without it, a response that happens to
    /// have none would leave overshoot without any weight. Another term that is 0, or not finite, gets weight
    /// 0, and so do those of a step that the response does not have.
    #[must_use]
    pub fn balancing(terms: &Terms) -> Self {
        let inverse = |term: f64| {
            let weight = 1.0 / term;
            if term > 0.0 && weight.is_finite() {
                weight
            } else {
                0.0
            }
        };
        let of_step =
            |term: fn(&StepTerms) -> f64| terms.step.as_ref().map_or(0.0, |s| inverse(term(s)));
        Self {
            mse: inverse(terms.mse),
            energy: inverse(terms.energy),
            rise_time: of_step(|step| step.rise_time_s),
            settling_time: of_step(|step| step.settling_time_s),
            overshoot: of_step(|step| step.overshoot.max(SETTLED)),
        }
    }

    /// The cost of a response; terms that it does not have count 0.
    ///
    /// ```text
    /// f = w · {MSE, Energy, RiseTime, T_s, OS}     [Sadeghi, eq. 13]
    /// ```
    #[must_use]
    pub fn cost(&self, terms: &Terms) -> f64 {
        let of_step = terms.step.map_or(0.0, |step| {
            self.rise_time * step.rise_time_s
                + self.settling_time * step.settling_time_s
                + self.overshoot * step.overshoot
        });
        self.mse * terms.mse + self.energy * terms.energy + of_step
    }
}
