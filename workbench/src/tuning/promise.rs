//! A response that a controller promises, and whether a rig has kept it.

use pid_tune::{InverseRun, PidGains, Reference};

use super::Bench;
use crate::WorkbenchError;
use crate::rig::Rig;
use crate::track::{Followed, Track, track};

/// Share of the samples inside of the band from which a promise counts as kept.
const KEPT: f64 = 0.9;

/// The response of the identified rod along a reference, and the band in which those of rods as likely lie, in the
/// sensor's own sign.
#[derive(Debug, Clone)]
pub struct Promise {
    /// The identified rod.
    pub expected: Track,
    /// Lower edge of the band, widened by what the sensor does by itself.
    pub lower: Vec<f64>,
    /// Upper edge.
    pub upper: Vec<f64>,
    /// Rods in it.
    pub n_rods: usize,
    /// Drive to be added, and output to be aimed at, if there is a feed-forward.
    pub forward: Option<InverseRun>,
}

/// A recording beside its promise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kept {
    /// Share of its samples inside of the band.
    pub inside_share: f64,
    /// √ of the mean square of reference - recording.
    pub rmse: f64,
    /// That of the response that was expected.
    pub expected_rmse: f64,
    /// Time of the sample that is farthest outside, s, and how far, in the output's unit; `None` if all are inside.
    pub worst: Option<(f64, f64)>,
}

impl Kept {
    /// True if the rig did as promised.
    #[must_use]
    pub fn is_kept(&self) -> bool {
        self.inside_share >= KEPT
    }
}

impl Bench<'_> {
    /// Promises a response along a reference, a value a sample, from the identified rod and others, all at rest where
    /// the first stands.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn promise(
        &self,
        gains: PidGains,
        reference: &[f64],
        forward: Option<&InverseRun>,
        rods: &[Rig],
    ) -> Result<Promise, WorkbenchError> {
        let noise = self.noise(reference.len());
        let samples = Reference::Samples(reference);
        let closed_loop = self.closed_loop(samples, reference.len(), &noise, forward)?;
        let followed = Followed {
            name: "promise",
            controller: "tuned",
            closed_loop: &closed_loop,
            pid: self.pid,
            gains,
        };
        let expected = track(self.rig, &followed)?;
        let mut lower = expected.output.clone();
        let mut upper = expected.output.clone();
        for rod in rods {
            let output = track(rod, &followed)?.output;
            for (k, value) in output.into_iter().enumerate() {
                lower[k] = lower[k].min(value);
                upper[k] = upper[k].max(value);
            }
        }
        let jump = self.sensor.jump();
        lower.iter_mut().for_each(|value| *value -= jump);
        upper.iter_mut().for_each(|value| *value += jump);
        Ok(Promise {
            expected,
            lower,
            upper,
            n_rods: 1 + rods.len(),
            forward: forward.cloned(),
        })
    }
}

impl Promise {
    /// Compares what a rig did: outputs at times, s, from the reference's beginning.
    #[must_use]
    pub fn kept(&self, time_s: &[f64], measured: &[f64]) -> Kept {
        let times = &self.expected.time_s;
        let dt_s = times.get(1).map_or(1.0, |second| second - times[0]);
        let (mut n_inside, mut squares) = (0, 0.0);
        let mut worst: Option<(f64, f64)> = None;
        for (&at_s, &output) in time_s.iter().zip(measured) {
            let k = ((at_s - time_s[0]) / dt_s).round() as usize;
            let k = k.min(times.len() - 1);
            let outside = (self.lower[k] - output).max(output - self.upper[k]);
            if outside <= 0.0 {
                n_inside += 1;
            } else if worst.is_none_or(|(_, most)| outside > most) {
                worst = Some((at_s, outside));
            }
            squares += (self.expected.setpoint[k] - output).powi(2);
        }
        let n_samples = measured.len() as f64;
        Kept {
            inside_share: f64::from(n_inside) / n_samples,
            rmse: (squares / n_samples).sqrt(),
            expected_rmse: self.expected.rmse(),
            worst,
        }
    }

    /// Reference to run on the rig, and the output expected: a row a sample.
    #[must_use]
    pub fn csv(&self, output_unit: &str) -> String {
        use std::fmt::Write;
        let mut text = format!(
            "time_s,reference_{output_unit},expected_{output_unit},lower_{output_unit},upper_{output_unit},drive"
        );
        if self.forward.is_some() {
            let _ = write!(text, ",feed_forward,aim_{output_unit}");
        }
        text.push('\n');
        let Track {
            time_s,
            setpoint,
            output,
            drive,
            ..
        } = &self.expected;
        for k in 0..time_s.len() {
            // Writing to a string does not fail.
            let _ = write!(
                text,
                "{},{},{},{},{},{}",
                time_s[k], setpoint[k], output[k], self.lower[k], self.upper[k], drive[k]
            );
            if let Some(forward) = &self.forward {
                let _ = write!(text, ",{},{}", forward.drive[k], forward.output[k]);
            }
            text.push('\n');
        }
        text
    }
}
