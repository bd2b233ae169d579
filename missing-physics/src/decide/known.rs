//! Inputs of the decision beside the population.

use std::ops::Range;

use crate::decide::rules::RuleId;
use crate::decide::trace::Traces;
use crate::{Candidate, CandidateSet};

/// Smallest error of a formula of a loop, as a share of what it shows.
const EXACT: f64 = 1e-3;

/// Error of a thermometer over the standard deviation of what it reads, up to which it may be its own: a thermocouple of class 1 is exact to
/// 1.5 K, and wires are cycled over some 100 K.
pub(crate) const OF_THERMOMETER: f64 = 0.015;

/// Inputs of the decision beside the population.
#[derive(Debug, Clone)]
pub(crate) struct Known {
    /// Places of each channel of each recording in a series.
    pub(crate) segments: Vec<Range<usize>>,
    /// Sum of squares of the output about its mean in each recording.
    pub(crate) output_squares: f64,
    /// Sum of squares of the recorded temperatures about their means, as they are scaled; 0 where none are recorded.
    pub(crate) temperature_squares: f64,
    /// Variance of the converter's rounding, in the square of the output's unit; 0 where no step is seen.
    pub(crate) rounding: f64,
    /// Mean square of the output that noise in the columns of drives may have left there, in the square of the output's unit.
    pub(crate) of_drive: f64,
    /// Candidates that may be found.
    pub(crate) catalogue: CandidateSet,
    /// Candidates that could not be tried, because an input that they need is missing.
    pub(crate) untried: CandidateSet,
    /// Share of what the size of the baseline model's residual varies by that the state of the rig predicts, if that is beyond chance.
    pub(crate) disturbed: f64,
    /// Oddness of the leading model's residual.
    pub(crate) left: Oddness,
    /// Oddness of the baseline model's residual.
    pub(crate) left_by_plain: Oddness,
    /// A drift of the zero, where the leading model has one, and its error over that of a mount that slips.
    pub(crate) slip: Option<(Candidate, f64)>,
    /// Mean squares that effects of the leading model explain of recordings that were not used, where that was asked.
    pub(crate) elsewhere: Vec<(Candidate, f64)>,
    pub(crate) seed: u64,
}

/// Features of a residual that no noise of a sensor has.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Oddness {
    /// Its tone, standard deviations.
    pub(crate) tone: f64,
    /// Its slow part over the noise between neighboring samples: of the output, and of a temperature that is missed by more than a thermometer's
    /// error, whichever is larger.
    pub(crate) slowness: f64,
}

impl Known {
    /// Root mean square from which on it matters what an effect shows, in the output's unit.
    pub(crate) fn least_that_matters(&self, n_outputs: usize) -> f64 {
        let exact = EXACT * self.output_deviation(n_outputs);
        exact.max(self.of_drive.sqrt())
    }

    /// Standard deviation of the output.
    pub(crate) fn output_deviation(&self, n_outputs: usize) -> f64 {
        (self.output_squares / n_outputs as f64).sqrt()
    }

    /// Mean square that an effect explains: of the training, or of recordings that were not used if it is exercised there alone.
    pub(crate) fn explained(&self, effect: Candidate, of_training: f64) -> f64 {
        let elsewhere = self.elsewhere.iter().filter(|(one, _)| *one == effect);
        elsewhere.fold(of_training, |largest, (_, gained)| largest.max(*gained))
    }

    /// Asks whether a mean square that is predicted is more than rounding, than noise of the drive leaves, and than any formula is exact to; or
    /// whether the squares that are predicted of recorded temperatures are more than a thermometer is exact to.
    pub(crate) fn is_material(
        &self,
        traces: &mut Traces,
        of: &str,
        (predicted, of_temperatures): (f64, f64),
        n_outputs: usize,
    ) -> bool {
        let least = self.least_that_matters(n_outputs).max(self.rounding.sqrt());
        let over = predicted.max(0.0).sqrt() / least;
        let of_thermometer = match self.temperature_squares {
            all if all > 0.0 => (of_temperatures.max(0.0) / all).sqrt() / OF_THERMOMETER,
            _ => 0.0,
        };
        traces.ask(RuleId::Matters, of, over.max(of_thermometer))
    }

    /// Number of names that were tried beside some.
    pub(crate) fn tried_beside(&self, names: CandidateSet) -> usize {
        let is_new = |one: &Candidate| !names.contains(*one) && !self.untried.contains(*one);
        self.catalogue.iter().filter(is_new).count()
    }
}
