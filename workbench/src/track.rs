//! A rig that follows a reference, sample by sample.

use pid_tune::{ClosedLoop, PidGains, PidParams, Task};

use crate::WorkbenchError;
use crate::rig::Rig;

/// A response to a reference, in the sensor's own sign.
#[derive(Debug, Clone)]
pub struct Track {
    /// Name of the reference.
    pub name: String,
    /// Under which controller.
    pub controller: &'static str,
    /// Samples over which errors count: a sine's last period, else all.
    pub counted: std::ops::Range<usize>,
    /// RMSE of the recorded rig on the same reference, where there is one.
    pub recorded_rmse: Option<f64>,
    /// Times of the samples, s.
    pub time_s: Vec<f64>,
    /// Reference.
    pub setpoint: Vec<f64>,
    /// Output.
    pub output: Vec<f64>,
    /// Drive.
    pub drive: Vec<f64>,
    upper: f64,
}

impl Track {
    /// √ of the mean square of reference - output.
    #[must_use]
    pub fn rmse(&self) -> f64 {
        let errors = self.errors(self.counted.clone());
        let n = errors.len() as f64;
        (errors.map(|error| error * error).sum::<f64>() / n).sqrt()
    }

    /// Mean error over the last eighth; `None` if the reference does not hold there.
    #[must_use]
    pub fn steady_state_error(&self) -> Option<f64> {
        let n = self.output.len();
        let last = &self.setpoint[n - n.div_ceil(8)..];
        if last
            .iter()
            .any(|level| level.to_bits() != last[0].to_bits())
        {
            return None;
        }
        let errors = self.errors(n - n.div_ceil(8)..n);
        let count = errors.len() as f64;
        Some(errors.sum::<f64>() / count)
    }

    /// Share of all samples with the drive at a limit.
    #[must_use]
    pub fn saturated_share(&self) -> f64 {
        let at_limit = |drive: &&f64| **drive <= 0.0 || **drive >= self.upper;
        self.drive.iter().filter(at_limit).count() as f64 / self.drive.len() as f64
    }

    fn errors(&self, samples: std::ops::Range<usize>) -> impl ExactSizeIterator<Item = f64> {
        samples.map(|k| self.setpoint[k] - self.output[k])
    }
}

/// A reference and the controller that follows it.
#[derive(Debug, Clone, Copy)]
pub struct Followed<'a> {
    /// Name of the reference.
    pub name: &'a str,
    /// The name of the controller.
    pub controller: &'static str,
    /// The loop around the rig.
    pub closed_loop: &'a ClosedLoop<'a>,
    /// The controller but for its gains.
    pub pid: PidParams,
    /// Its gains.
    pub gains: PidGains,
}

/// Runs a rig from rest, its controller idle.
///
/// # Errors
///
/// [`WorkbenchError`] naming what is refused.
pub fn track(rig: &Rig, followed: &Followed<'_>) -> Result<Track, WorkbenchError> {
    let task = Task::new(rig.fleet, *followed.closed_loop, followed.pid)?;
    let n_samples = followed.closed_loop.params().n_samples;
    let mut track = Track {
        name: followed.name.to_owned(),
        controller: followed.controller,
        counted: 0..n_samples,
        recorded_rmse: None,
        time_s: Vec::with_capacity(n_samples),
        setpoint: Vec::with_capacity(n_samples),
        output: Vec::with_capacity(n_samples),
        drive: Vec::with_capacity(n_samples),
        upper: followed.pid.limits.upper,
    };
    task.show(rig.member, followed.gains, &mut |snapshot| {
        track.time_s.push(snapshot.time_s);
        track.setpoint.push(rig.signed(snapshot.setpoint));
        track.output.push(rig.signed(snapshot.output[0]));
        track.drive.push(snapshot.drive[0]);
    })?;
    Ok(track)
}
