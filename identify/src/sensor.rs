//! Step and noise of a sensor.

use recording::{NoiseConfig, Recording, noise_floor};
use serde::de::{Error, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};

/// Step and noise of the sensor of the output while nothing moves: estimated from a recording, without a model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// Step of its converter, in the output's unit; 0 where none is seen.
    #[serde(deserialize_with = "not_negative")]
    pub step: f64,
    /// Standard deviation of its noise beside rounding, in the output's unit.
    #[serde(deserialize_with = "not_negative")]
    pub noise: f64,
    /// Time in which the correlation of the noise falls to 1/e, s; 0 for white noise.
    #[serde(deserialize_with = "not_negative")]
    pub correlation_s: f64,
}

/// Least noise of a thermometer that counts, K: none on a rod is read finer.
///
/// Temperatures that are met more closely come from a simulation. Weighed by that, they alone would decide every fit.
pub const FINEST_THERMOMETER_K: f64 = 0.01;

/// Correlations of neighboring samples that are those of colored noise: below, noise counts as white; above, as a drift.
const COLORED: std::ops::Range<f64> = 0.2..0.9;

impl Sensor {
    /// No step and no noise.
    pub const IDEAL: Self = Self {
        step: 0.0,
        noise: 0.0,
        correlation_s: 0.0,
    };

    /// That of a recording; `None` where too little of it tells.
    #[must_use]
    pub fn of(recording: &Recording) -> Option<Self> {
        let floor = noise_floor(recording, NoiseConfig::default())?;
        let rounding = floor.rounding.unwrap_or(0.0);
        let dt_s = recording.sampling().usual_dt_s().unwrap_or(0.0);
        // Differences of neighbors see the white part alone. Where holds tell a memory, they tell its size as well; one of
        // nearly 1 is a drift, which is no noise of the sensor.
        let colored = floor
            .holds
            .filter(|holds| COLORED.contains(&holds.lag1_autocorrelation));
        let deviation = colored.map_or(floor.white(), |holds| holds.standard_deviation);
        Some(Self {
            step: rounding * 12.0_f64.sqrt(),
            noise: (deviation.powi(2) - rounding.powi(2)).max(0.0).sqrt(),
            correlation_s: colored.map_or(0.0, |holds| -dt_s / holds.lag1_autocorrelation.ln()),
        })
    }

    /// By how much it jumps from sample to sample while nothing moves, in the output's unit: its step, or twice the
    /// standard deviation of its noise, whichever is more.
    #[must_use]
    pub fn jump(&self) -> f64 {
        self.step.max(2.0 * self.noise)
    }
}

pub(crate) fn not_negative<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let value = f64::deserialize(from)?;
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        let found = Unexpected::Float(value);
        Err(D::Error::invalid_value(found, &"a finite number >= 0"))
    }
}

pub(crate) fn positive_if_any<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    match Option::<f64>::deserialize(from)? {
        Some(value) if !(value > 0.0 && value.is_finite()) => {
            let found = Unexpected::Float(value);
            Err(D::Error::invalid_value(found, &"a finite number > 0"))
        }
        value => Ok(value),
    }
}
