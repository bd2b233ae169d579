use crate::error::{TruthError, within};
use crate::random::{Random, Stream};
use std::f64::consts::PI;

/// The temperature of the surroundings moves, and a sensor reads it.
///
/// ```text
/// T_amb(t) = T_0 + r t + A (sin(2π t/p + φ) - sin φ) + W(t)        W a random walk
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmbientDrift {
    /// Steady part r, K/s; -0.1 to 0.1.
    pub rate_k_per_s: f64,
    /// Amplitude of the slow wave A, K; 0 to 20. Typical: 2.
    pub wave_amplitude_k: f64,
    /// Its period p, s; at least 10: a day, or an air conditioner.
    pub wave_period_s: f64,
    /// Its phase φ, rad; -7 to 7.
    pub wave_phase_rad: f64,
    /// Random walk, K/√s; 0 to 1. Typical: 0.05.
    pub random_walk_k_per_root_s: f64,
}

/// The sensor of the surroundings' temperature: the recorded ambient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmbientSensor {
    /// Offset, K; -10 to 10.
    pub offset_k: f64,
    /// White noise, K; 0 to 5.
    pub noise_k: f64,
    /// True if it sees the drift; if false, it shows the start (the thermometer on the wall).
    pub sees_drift: bool,
}

/// Gusts: the convective coefficient is multiplied by the exponential of a coloured process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draughts {
    /// Standard deviation of the logarithm, 0 to 1. Typical: 0.2.
    pub deviation: f64,
    /// Correlation time, s; at least 0.01. Typical: 5.
    pub correlation_s: f64,
}

impl AmbientDrift {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("rate_k_per_s", self.rate_k_per_s, -0.1..=0.1)?;
        within("wave_amplitude_k", self.wave_amplitude_k, 0.0..=20.0)?;
        within("wave_period_s", self.wave_period_s, 10.0..=1e6)?;
        within("wave_phase_rad", self.wave_phase_rad, -7.0..=7.0)?;
        within(
            "random_walk_k_per_root_s",
            self.random_walk_k_per_root_s,
            0.0..=1.0,
        )
    }
}

impl AmbientSensor {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("offset_k", self.offset_k, -10.0..=10.0)?;
        within("noise_k", self.noise_k, 0.0..=5.0)
    }
}

impl Draughts {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("deviation", self.deviation, 0.0..=1.0)?;
        within("correlation_s", self.correlation_s, 0.01..=1e5)
    }
}

/// The surroundings at the sample times; straight between them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Weather {
    /// One more than samples.
    pub(crate) ambient_degc: Vec<f64>,
    /// Factor of convection, one more than samples.
    pub(crate) draught: Vec<f64>,
}

impl Weather {
    pub(crate) fn new(
        start_degc: f64,
        drift: Option<AmbientDrift>,
        draughts: Option<Draughts>,
        (n_samples, dt_s, seed): (usize, f64, u64),
    ) -> Self {
        let mut ambient_degc = vec![start_degc; n_samples + 1];
        if let Some(drift) = drift {
            let mut random = Random::new(seed, Stream::Ambient);
            let mut walk_k = 0.0;
            for (k, ambient) in ambient_degc.iter_mut().enumerate() {
                let time_s = k as f64 * dt_s;
                let phase = 2.0 * PI * time_s / drift.wave_period_s + drift.wave_phase_rad;
                let wave = phase.sin() - drift.wave_phase_rad.sin();
                *ambient += drift.rate_k_per_s * time_s + drift.wave_amplitude_k * wave + walk_k;
                walk_k += drift.random_walk_k_per_root_s * dt_s.sqrt() * random.normal();
            }
        }
        let mut draught = vec![1.0; n_samples + 1];
        if let Some(draughts) = draughts {
            let mut random = Random::new(seed, Stream::Draught);
            let kept = (-dt_s / draughts.correlation_s).exp();
            let mut gust = random.normal();
            for factor in &mut draught {
                *factor = (draughts.deviation * gust).exp();
                gust = kept * gust + (1.0 - kept * kept).sqrt() * random.normal();
            }
        }
        Self {
            ambient_degc,
            draught,
        }
    }

    /// The recorded ambient, one value a sample.
    pub(crate) fn read(&self, sensor: Option<AmbientSensor>, seed: u64) -> Vec<f64> {
        let n_samples = self.ambient_degc.len() - 1;
        let mut read = self.ambient_degc[..n_samples].to_vec();
        if let Some(sensor) = sensor {
            let mut random = Random::new(seed, Stream::AmbientNoise);
            for degc in &mut read {
                if !sensor.sees_drift {
                    *degc = self.ambient_degc[0];
                }
                *degc += sensor.offset_k + sensor.noise_k * random.normal();
            }
        }
        read
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gusts_have_their_deviation_and_correlation() {
        let draughts = Draughts {
            deviation: 0.3,
            correlation_s: 2.0,
        };
        let weather = Weather::new(20.0, None, Some(draughts), (40_000, 0.5, 3));
        let gusts: Vec<f64> = weather.draught.iter().map(|factor| factor.ln()).collect();
        let product = |lag: usize| {
            let pairs = gusts.iter().zip(&gusts[lag..]).map(|(a, b)| a * b);
            pairs.sum::<f64>() / (gusts.len() - lag) as f64
        };
        assert!((product(0).sqrt() / 0.3 - 1.0).abs() < 0.05);
        assert!((product(4) / product(0) - (-1.0_f64).exp()).abs() < 0.05);
    }

    #[test]
    fn the_walk_spreads_with_the_root_of_time() {
        let drift = AmbientDrift {
            rate_k_per_s: 0.0,
            wave_amplitude_k: 0.0,
            wave_period_s: 100.0,
            wave_phase_rad: 0.0,
            random_walk_k_per_root_s: 0.1,
        };
        let ends = (0..400).map(|seed| {
            let weather = Weather::new(20.0, Some(drift), None, (400, 0.25, seed));
            weather.ambient_degc[400] - 20.0
        });
        let square: f64 = ends.map(|end| end * end).sum::<f64>() / 400.0;
        // 100 s: 1 K.
        assert!((square.sqrt() - 1.0).abs() < 0.15, "{square}");
    }

    #[test]
    fn a_thermometer_on_the_wall_shows_the_start() {
        let drift = AmbientDrift {
            rate_k_per_s: 0.01,
            wave_amplitude_k: 1.0,
            wave_period_s: 50.0,
            wave_phase_rad: 0.4,
            random_walk_k_per_root_s: 0.0,
        };
        let weather = Weather::new(20.0, Some(drift), None, (100, 1.0, 1));
        assert!((weather.ambient_degc[50] - 20.5).abs() < 1e-9);
        let wall = AmbientSensor {
            offset_k: 0.5,
            noise_k: 0.0,
            sees_drift: false,
        };
        let read = weather.read(Some(wall), 1);
        assert!(read.iter().all(|degc| (degc - 20.5).abs() < 1e-12));
        assert!((weather.read(None, 1)[99] - weather.ambient_degc[99]).abs() < 1e-12);
    }
}
