//! The step of the set point that gains are judged by, with the noise and the feed-forward of its run.

use pid_tune::{ClosedLoop, InverseRun, Reference};
use workbench::{Bench, WorkbenchError};

use super::Job;

/// A step, and what it is run with.
pub(super) struct Step {
    reference: Reference<'static>,
    pub(super) n_samples: usize,
    noise: Vec<f64>,
    forward: Option<InverseRun>,
}

impl Step {
    /// The step of a call.
    pub(super) fn of(job: &Job<'_>) -> anyhow::Result<Self> {
        let reference = job.step()?;
        let n_samples = job.step_samples()?;
        Ok(Self {
            reference,
            n_samples,
            noise: job.bench.noise(n_samples),
            forward: job.forward(job.bench.rig, &reference, n_samples)?,
        })
    }

    /// The loop as it will run.
    pub(super) fn closed_loop(&self, bench: &Bench<'_>) -> Result<ClosedLoop<'_>, WorkbenchError> {
        bench.closed_loop(
            self.reference,
            self.n_samples,
            &self.noise,
            self.forward.as_ref(),
        )
    }

    /// The loop in which gains are found: without the feed-forward, since beside an exact inverse the best ones are none at
    /// all.
    pub(super) fn fed_back(&self, bench: &Bench<'_>) -> Result<ClosedLoop<'_>, WorkbenchError> {
        bench.closed_loop(self.reference, self.n_samples, &self.noise, None)
    }
}
