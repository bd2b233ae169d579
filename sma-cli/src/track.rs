//! A rig that follows a reference, sample by sample.

use pid_tune::{ClosedLoop, Pid, PidGains, PidParams, Snapshot};
use wiener::Plant;

use crate::rig::Rig;

/// A response to a reference, in the sensor's own sign.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    /// What is followed.
    pub(crate) name: String,
    /// Under which controller.
    pub(crate) controller: &'static str,
    /// Samples over which errors count: a sine's last period, else all.
    pub(crate) counted: std::ops::Range<usize>,
    /// RMSE of the recorded rig on the same reference, where there is one.
    pub(crate) recorded_rmse: Option<f64>,
    pub(crate) time_s: Vec<f64>,
    pub(crate) setpoint: Vec<f64>,
    pub(crate) output: Vec<f64>,
    pub(crate) drive: Vec<f64>,
    upper: f64,
}

impl Track {
    /// √ of the mean square of reference - output.
    pub(crate) fn rmse(&self) -> f64 {
        let errors = self.errors(self.counted.clone());
        let n = errors.len() as f64;
        (errors.map(|error| error * error).sum::<f64>() / n).sqrt()
    }

    /// Mean error over the last eighth; `None` if the reference does not hold there.
    pub(crate) fn steady_state_error(&self) -> Option<f64> {
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
    pub(crate) fn saturated_share(&self) -> f64 {
        let at_limit = |drive: &&f64| **drive <= 0.0 || **drive >= self.upper;
        self.drive.iter().filter(at_limit).count() as f64 / self.drive.len() as f64
    }

    fn errors(&self, samples: std::ops::Range<usize>) -> impl ExactSizeIterator<Item = f64> {
        samples.map(|k| self.setpoint[k] - self.output[k])
    }
}

/// What is followed, by which controller.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Followed<'a> {
    pub(crate) name: &'a str,
    pub(crate) controller: &'static str,
    pub(crate) closed_loop: &'a ClosedLoop<'a>,
    pub(crate) pid: PidParams,
    pub(crate) gains: PidGains,
}

/// Runs a rig from rest, its controller idle.
pub(crate) fn track(rig: &Rig, followed: &Followed<'_>) -> anyhow::Result<Track> {
    let plant = rig.plant()?;
    let mut state = plant.rest(rig.ambient_degc);
    let pid = Pid::new(followed.pid, &[followed.gains])?;
    let mut pid_state = pid.rest(plant.output(&state).displacement)?;
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
    let keep = |snapshot: &Snapshot| {
        track.time_s.push(snapshot.time_s);
        track.setpoint.push(rig.signed(snapshot.setpoint));
        track.output.push(rig.signed(snapshot.output[0]));
        track.drive.push(snapshot.drive[0]);
    };
    followed
        .closed_loop
        .run(&plant, &mut state, &pid, &mut pid_state, keep);
    Ok(track)
}
