//! Real recordings with an effect put on them: what acts behind the rod needs no model of the rod.

use std::fmt;

use recording::{Recording, RecordingParts};
use serde::{Deserialize, Serialize};
use sma_effects::EffectId;

use crate::TrialError;

/// Effect that is put on a recorded output.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Injected {
    /// Which effect.
    pub effect: Behind,
    /// Its size, in the unit of the effect's parameter.
    pub size: f64,
}

/// Effects that act behind the rod.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Behind {
    /// The output follows with a time constant, s.
    OutputLag,
    /// The output is late, s. A delay of the drive is the same to who sees only drive and output.
    DeadTime,
    /// The output plays, share of the stroke.
    Backlash,
    /// The zero moves over the run by a half wave, share of the stroke.
    SensorDrift,
    /// The sensor is bowed, share of the stroke.
    SensorNonlinearity,
}

impl Behind {
    /// Its name in the catalogue.
    #[must_use]
    pub fn effect(self) -> EffectId {
        match self {
            Self::OutputLag => EffectId::OutputLag,
            Self::DeadTime => EffectId::DeadTime,
            Self::Backlash => EffectId::Backlash,
            Self::SensorDrift => EffectId::SensorDrift,
            Self::SensorNonlinearity => EffectId::SensorNonlinearity,
        }
    }
}

impl fmt::Display for Injected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.effect.effect().id(), self.size)
    }
}

impl Injected {
    /// Every effect, small and large.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let sizes = [
            (Behind::OutputLag, [0.5, 2.0]),
            (Behind::DeadTime, [0.3, 0.9]),
            (Behind::Backlash, [0.01, 0.04]),
            (Behind::SensorDrift, [0.02, 0.08]),
            (Behind::SensorNonlinearity, [0.01, 0.04]),
        ];
        let of_both = |(effect, sizes): (Behind, [f64; 2])| sizes.map(|size| Self { effect, size });
        sizes.into_iter().flat_map(of_both).collect()
    }

    /// The recording as the rig with the effect would have given it; `stroke` is that of all recordings, in the output's
    /// unit, from its lowest reading.
    ///
    /// # Errors
    ///
    /// [`TrialError::NoTime`] for the recording of a static loop.
    pub fn on(
        &self,
        recording: &Recording,
        [lowest, stroke]: [f64; 2],
    ) -> Result<Recording, TrialError> {
        let (time_s, output) = (recording.time_s(), recording.output());
        let n = output.len();
        if time_s.len() != n {
            return Err(TrialError::NoTime {
                recording: recording.name().to_owned(),
            });
        }
        let moved = match self.effect {
            Behind::OutputLag => lagged(time_s, output, self.size),
            Behind::DeadTime => late(time_s, output, self.size),
            Behind::Backlash => played(output, 0.5 * self.size * stroke),
            Behind::SensorDrift => {
                let whole_s = time_s[n - 1] - time_s[0];
                let wave = |t: f64| (std::f64::consts::PI * (t - time_s[0]) / whole_s).sin();
                let pairs = time_s.iter().zip(output);
                pairs
                    .map(|(&t, y)| y + self.size * stroke * wave(t))
                    .collect()
            }
            Behind::SensorNonlinearity => {
                let bowed = |y: &f64| {
                    let share = (y - lowest) / stroke;
                    y + 4.0 * self.size * stroke * share * (1.0 - share)
                };
                output.iter().map(bowed).collect()
            }
        };
        let parts = RecordingParts {
            name: recording.name().to_owned(),
            time_s: Some(time_s.to_vec()),
            drive_quantity: recording.drive_quantity(),
            drive: recording.drive().to_vec(),
            output_unit: recording.output_unit().to_owned(),
            output: moved,
            ambient_degc: recording.ambient_degc().map(<[f64]>::to_vec),
            ..RecordingParts::default()
        };
        match Recording::new(parts) {
            Ok(recording) => Ok(recording),
            Err(error) => unreachable!("as many finite samples as there were: {error}"),
        }
    }
}

/// Lowest reading and range of all recordings, in the output's unit: what [`Injected::on`] takes.
#[must_use]
pub fn stroke(recordings: &[Recording]) -> [f64; 2] {
    let outputs = recordings.iter().flat_map(Recording::output);
    let [low, high] = outputs.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &y| {
        [low.min(y), high.max(y)]
    });
    [low, high - low]
}

/// θ dy'/dt + y' = y, y straight between samples, from rest.
fn lagged(time_s: &[f64], output: &[f64], lag_s: f64) -> Vec<f64> {
    let mut lagged = vec![output[0]];
    for k in 1..output.len() {
        let dt_s = time_s[k] - time_s[k - 1];
        let slope = (output[k] - output[k - 1]) / dt_s;
        let kept = (-dt_s / lag_s).exp();
        // Behind a ramp it stays θ times the slope.
        let end = output[k] - lag_s * slope;
        let start = output[k - 1] - lag_s * slope;
        lagged.push(end + (lagged[k - 1] - start) * kept);
    }
    lagged
}

/// The output some time ago, straight between samples; at rest before the first.
fn late(time_s: &[f64], output: &[f64], delay_s: f64) -> Vec<f64> {
    let at = |now_s: f64| {
        let after = time_s.partition_point(|&t| t <= now_s);
        match after {
            0 => output[0],
            after if after == output.len() => output[after - 1],
            after => {
                let (from_s, to_s) = (time_s[after - 1], time_s[after]);
                let share = (now_s - from_s) / (to_s - from_s);
                output[after - 1] + share * (output[after] - output[after - 1])
            }
        }
    };
    time_s.iter().map(|&t| at(t - delay_s)).collect()
}

/// Play of half a width around its input, which came from above.
fn played(output: &[f64], half_width: f64) -> Vec<f64> {
    let mut at = output[0] + half_width;
    let follow = |&y: &f64| {
        at = at.clamp(y - half_width, y + half_width);
        at
    };
    output.iter().map(follow).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_follows_a_ramp_by_its_time_constant_and_a_step_by_its_share() {
        let time_s: Vec<f64> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
        let ramp = lagged(&time_s, &time_s, 2.0);
        assert!((ramp[399] - (time_s[399] - 2.0)).abs() < 1e-6);
        let mut step = vec![0.0; 400];
        step[1..].fill(1.0);
        let after = lagged(&time_s, &step, 2.0)[21];
        // The step is a ramp of one sample.
        assert!((after - (1.0 - (-1.0_f64).exp())).abs() < 0.01, "{after}");
    }

    #[test]
    fn a_delay_shifts_and_a_play_waits() {
        let time_s: Vec<f64> = (0..50).map(|k| 0.1 * f64::from(k)).collect();
        let shifted = late(&time_s, &time_s, 0.25);
        assert!((shifted[30] - 2.75).abs() < 1e-12 && shifted[1].abs() < 1e-12);
        let played = played(&[0.0, 1.0, 2.0, 1.5, 1.0, 0.0], 0.5);
        assert_eq!(played, [0.5, 0.5, 1.5, 1.5, 1.5, 0.5]);
    }

    #[test]
    fn every_effect_has_two_sizes_and_a_name() {
        let all = Injected::all();
        assert_eq!(all.len(), 10);
        assert_eq!(all[3].to_string(), "dead-time 0.9");
    }
}
