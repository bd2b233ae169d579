//! Evidence drawn from an answer while the comparison behind it is still there.

use identify::{ForwardModel, IdentifyError, Limits, ParameterState, Scope, Validated, predict};
use recording::Recording;

use crate::ExtendedModel;
use crate::changed::apart::next_run;
use crate::changed::change::Changed;
use crate::changed::comparison::{Comparison, Ended};
use crate::changed::evidence::{ChangeEvidence, StateSpread, TracedRun};
use crate::changed::joint::Joint;

/// An answer while the comparison it rests on is still there.
#[derive(Debug)]
pub(crate) struct Answered<'a> {
    /// Laws of the reference.
    pub(crate) model: &'a ExtendedModel,
    /// Runs of the reference.
    pub(crate) runs: &'a [Recording],
    /// Values of all parameters in each of them, the laws from the others; empty if there is one run.
    pub(crate) left_out_points: &'a [Vec<f64>],
    /// Limits of the rig, for the next run.
    pub(crate) limits: &'a Limits,
    /// Runs that were asked about.
    pub(crate) today: &'a [Recording],
    pub(crate) asked: &'a Comparison<'a>,
    pub(crate) found: &'a [Ended],
    /// Today's runs, each in its own state: without a change, and with the likeliest.
    pub(crate) validated: [&'a [Validated]; 2],
    pub(crate) with: &'a Joint,
    pub(crate) finding: Option<&'a Changed>,
    pub(crate) enlarged: f64,
}

impl Answered<'_> {
    pub(crate) fn evidence(&self) -> Result<ChangeEvidence, IdentifyError> {
        Ok(ChangeEvidence {
            since: self.since()?,
            left_out: self.left_out()?,
            states: self.states(),
            enlarged: self.enlarged,
            next: self.finding.map_or(Ok(None), |finding| {
                next_run(self.asked, self.found, finding, self.limits)
            })?,
        })
    }

    /// Of a run by its place among all.
    fn deviations(&self, run: usize) -> Vec<[f64; 2]> {
        self.asked.runs.deviations(run, &self.asked.discrepancy)
    }

    fn since(&self) -> Result<Vec<TracedRun>, IdentifyError> {
        let n_reference = self.runs.len();
        let [before, after] = self.validated;
        let runs = self.today.iter().enumerate();
        runs.map(|(k, run)| {
            let changed = || predict(&self.with.version, &after[k].point, run);
            let changed = (!self.found.is_empty()).then(changed).transpose()?;
            Ok(TracedRun {
                name: run.name().to_owned(),
                unchanged_output: predict(self.model, &before[k].point, run)?.output,
                changed_output: changed.map(|changed| changed.output),
                deviation_over_time_s: self.deviations(n_reference + k),
            })
        })
        .collect()
    }

    fn left_out(&self) -> Result<Vec<TracedRun>, IdentifyError> {
        let runs = self.runs.iter().zip(self.left_out_points).enumerate();
        runs.map(|(k, (run, point))| {
            Ok(TracedRun {
                name: run.name().to_owned(),
                unchanged_output: predict(self.model, point, run)?.output,
                changed_output: None,
                deviation_over_time_s: self.deviations(k),
            })
        })
        .collect()
    }

    fn states(&self) -> Vec<StateSpread> {
        let infos = self.model.parameters().iter().enumerate();
        let own = infos.filter(|(_, info)| {
            info.scope == Scope::PerRecording && info.state == ParameterState::Free
        });
        own.map(|(place, info)| StateSpread {
            parameter: info.name,
            unit: info.unit.clone(),
            prior_deviation: info.ordinary.map(|ordinary| ordinary.deviation),
            of_reference: self.left_out_points.iter().map(|p| p[place]).collect(),
            since: self.validated[0].iter().map(|v| v.point[place]).collect(),
        })
        .collect()
    }
}
