//! Evidence for an answer about changes: traces of the runs, states of the runs, and the run that would tell more.

use crate::next::run::NextExperiment;

/// One run beside predictions of it, its own state known.
#[derive(Debug, Clone, PartialEq)]
pub struct TracedRun {
    /// Name of the run.
    pub name: String,
    /// Output under the laws without a change, one value a sample, in the unit of the output. Of a run of the reference: under laws
    /// from the other runs of the reference.
    pub unchanged_output: Vec<f64>,
    /// Output with the likeliest change, as many values; `None` of a run of the reference, and where no change was considered.
    pub changed_output: Option<Vec<f64>>,
    /// Standard deviation of the discrepancy that the runs are judged against: time in s, deviation in the unit of the output. At fewer
    /// times than the run has samples.
    pub deviation_over_time_s: Vec<[f64; 2]>,
}

/// One quantity of which each run has its own value, over the runs.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpread {
    /// Name of the parameter.
    pub parameter: &'static str,
    /// Unit of all values; "1" for a share.
    pub unit: String,
    /// Standard deviation of the prior about 0, in `unit`; `None` without a prior.
    pub prior_deviation: Option<f64>,
    /// Values in the runs of the reference, in their order, in `unit`: each under laws from the others. Empty if there is one run.
    pub of_reference: Vec<f64>,
    /// Values in the runs that were asked about, under the laws without a change, in `unit`.
    pub since: Vec<f64>,
}

impl StateSpread {
    /// Mean over the runs of the reference, in `unit`; `None` without values.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        let n = self.of_reference.len();
        (n > 0).then(|| self.of_reference.iter().sum::<f64>() / n as f64)
    }

    /// Standard deviation over the runs of the reference, n - 1 in its denominator, in `unit`; `None` of one run.
    #[must_use]
    pub fn deviation(&self) -> Option<f64> {
        let n = self.of_reference.len();
        let mean = self.mean()?;
        let squares = self.of_reference.iter().map(|one| (one - mean).powi(2));
        (n > 1).then(|| (squares.sum::<f64>() / (n - 1) as f64).sqrt())
    }
}

/// Evidence for a [`Change`](crate::Change).
#[derive(Debug, Clone, PartialEq)]
pub struct ChangeEvidence {
    /// Runs that were asked about, in their order.
    pub since: Vec<TracedRun>,
    /// Runs of the reference, each met by laws from the others; empty if the reference is one run.
    pub left_out: Vec<TracedRun>,
    /// Spread of the runs' own values.
    pub states: Vec<StateSpread>,
    /// Factor by which the variances of the discrepancy were enlarged, >= 1.
    pub enlarged: f64,
    /// Proposal of a run that would tell the alternatives of the finding apart; `None` unless it is an
    /// effect that has appeared, with another among its alternatives, and a run can be foreseen.
    pub next: Option<NextExperiment>,
}

#[cfg(test)]
mod tests {
    use super::StateSpread;

    #[test]
    fn a_spread_of_one_run_is_not_known() {
        let spread = |of_reference: &[f64]| StateSpread {
            parameter: "run_gain",
            unit: "1".to_owned(),
            prior_deviation: Some(0.01),
            of_reference: of_reference.to_vec(),
            since: vec![],
        };
        let of_three = spread(&[0.01, 0.03, 0.02]);
        assert!((of_three.mean().unwrap() - 0.02).abs() < 1e-12);
        assert!((of_three.deviation().unwrap() - 0.01).abs() < 1e-12);
        assert_eq!(spread(&[0.01]).deviation(), None);
        assert_eq!(spread(&[]).mean(), None);
    }
}
