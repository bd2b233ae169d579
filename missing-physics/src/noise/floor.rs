//! Noise of the output before any model, and what it is like.

use recording::{NoiseConfig, NoiseFloor, Recording, noise_floor};

use crate::model::case::{Case, Node};
use crate::noise::kind::{Floor, NoiseClass};

/// A converter's step over the noise from which it is the step that counts.
const COARSE: f64 = 2.0;

/// Exponent of the spectrum at low frequencies from which noise has no level.
const STEEP: f64 = -0.7;

/// Residual over the measured noise up to which the residual tells what the noise is like.
const ALL_NOISE: f64 = 1.5;

/// Noise of all training recordings together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measured {
    /// Variance that gates count with: of holds and repeated cycles the smaller one, which is harder on us, or
    /// the white part where there are neither; with the rounding of coarse steps.
    pub(crate) gate: f64,
    /// Standard deviation that there is at least.
    pub(crate) lower: f64,
    /// About the largest; `None` where nothing tells.
    pub(crate) upper: Option<f64>,
    /// Standard deviation of rounding, where a converter's step is seen.
    pub(crate) rounding: Option<f64>,
}

/// Measures the noise; holds count from five time constants after their start.
pub(crate) fn measured(training: &[Recording], tau_s: f64) -> Measured {
    let settle_s = 5.0 * tau_s;
    let config = NoiseConfig {
        hold_s: settle_s,
        settle_s,
    };
    let floors: Vec<(f64, NoiseFloor)> = training
        .iter()
        .filter_map(|recording| Some((recording.len() as f64, noise_floor(recording, config)?)))
        .collect();
    // Variances, weighed by the samples of the recordings that have them.
    let pooled = |of: &dyn Fn(&NoiseFloor) -> Option<f64>| {
        let (mut total, mut sum) = (0.0, 0.0);
        for (n, floor) in &floors {
            if let Some(deviation) = of(floor) {
                total += n;
                sum += n * deviation * deviation;
            }
        }
        (total > 0.0).then(|| sum / total)
    };
    let rounding = pooled(&|floor| floor.rounding);
    let lower = pooled(&|floor| Some(floor.lower())).unwrap_or(0.0);
    let holds = pooled(&|floor| floor.holds.map(|holds| holds.standard_deviation));
    let repeats = pooled(&|floor| floor.repeats.map(|repeats| repeats.standard_deviation));
    let least = holds.into_iter().chain(repeats).reduce(f64::min);
    let white = pooled(&|floor| Some(floor.white())).unwrap_or(0.0);
    let least = least.unwrap_or(white).max(0.0);
    Measured {
        gate: gate(least, rounding),
        lower: lower.sqrt(),
        // Holds and cycles may be of other recordings than the least is.
        upper: pooled(&NoiseFloor::upper).map(|upper| upper.max(lower).sqrt()),
        rounding: rounding.map(f64::sqrt),
    }
}

/// Noise of samples on which models are judged, and of those that were recorded.
pub(crate) fn of_both([judged, recorded]: [&[Recording]; 2], tau_s: f64) -> [Measured; 2] {
    let recorded = measured(recorded, tau_s);
    [measured(judged, tau_s).with_step_of(&recorded), recorded]
}

/// Variance that gates count with, of the least that was measured and that of rounding.
fn gate(least: f64, rounding: Option<f64>) -> f64 {
    match rounding {
        // What stands still or repeats is rounded to the same step: that hides part of the rounding.
        Some(rounding) if 12.0 * rounding > COARSE * COARSE * least => least + rounding,
        Some(rounding) => least.max(rounding),
        None => least,
    }
}

impl Measured {
    /// The noise of means of samples, with the converter's step of these: what is slow is rounded alike, and means hide the step.
    fn with_step_of(self, recorded: &Self) -> Self {
        let rounding = recorded.rounding.map(|rounding| rounding.powi(2));
        Self {
            gate: gate(self.gate, rounding.filter(|_| self.rounding.is_none())),
            rounding: recorded.rounding,
            ..self
        }
    }

    /// Variance that there is at most.
    pub(crate) fn highest(&self) -> f64 {
        self.upper.unwrap_or(self.lower).powi(2).max(self.gate)
    }

    /// The floor as it is reported, with the residual of the best model to tell what it is like.
    pub(crate) fn floor(&self, case: &Case<'_>, best: &Node) -> Floor {
        Floor {
            lower: self.lower,
            upper: self.upper,
            class: self.class(case, best),
            of_drive: 0.0,
        }
    }

    /// True if the converter's steps are coarse beside an error of this mean square.
    pub(crate) fn is_coarse(&self, mean_square: f64) -> bool {
        let step = 12_f64.sqrt() * self.rounding.unwrap_or(0.0);
        step > COARSE * mean_square.sqrt()
    }

    fn class(&self, case: &Case<'_>, best: &Node) -> NoiseClass {
        let residual = best.mean_square().sqrt();
        if self.is_coarse(best.mean_square()) {
            return NoiseClass::Quantized;
        }
        let noise = self.upper.unwrap_or(self.lower);
        // The lowest frequencies alone say too little: noise that grows towards them has a memory at once.
        if best.noise.output.coefficients.is_empty() {
            NoiseClass::White
        } else if residual < ALL_NOISE * noise && low_exponent(case, best) < STEEP {
            NoiseClass::OneOverF
        } else {
            NoiseClass::Colored
        }
    }
}

/// Exponent of the residual's spectrum at its lowest frequencies, by the slope of the logarithm of the
/// periodogram, over all recordings together.
fn low_exponent(case: &Case<'_>, node: &Node) -> f64 {
    /// Harmonics of the recording: more than a decade, and few enough to be low.
    const HARMONICS: usize = 32;
    let mut sums = [0.0; 4];
    let mut n = 0.0;
    for r in 0..case.training.len() {
        let residual = &node.residual[case.layout.segments[r].range.clone()];
        for k in 2..=HARMONICS {
            let step = 2.0 * std::f64::consts::PI * k as f64 / residual.len() as f64;
            let (mut real, mut imaginary) = (0.0, 0.0);
            for (t, value) in residual.iter().enumerate() {
                let (sin, cos) = (step * t as f64).sin_cos();
                real += value * cos;
                imaginary += value * sin;
            }
            let power = (real * real + imaginary * imaginary).max(f64::MIN_POSITIVE);
            let (x, y) = ((k as f64).ln(), power.ln());
            n += 1.0;
            for (sum, value) in sums.iter_mut().zip([x, y, x * x, x * y]) {
                *sum += value;
            }
        }
    }
    let [x, y, xx, xy] = sums;
    let spread = xx - x * x / n;
    if spread > 0.0 {
        (xy - x * y / n) / spread
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use recording::RecordingParts;

    /// A recording of so many seconds, at rest for a share of them, then with a drive and an output that go to and fro.
    fn recording(n: usize, at_rest: f64, noise_mm: f64) -> Recording {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let still = (at_rest * n as f64) as usize;
        let level = |k: usize| 1.0 - (0.05 * k.saturating_sub(still) as f64).cos();
        let output = (0..n).map(|k| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            level(k) + noise_mm * normal
        });
        Recording::new(RecordingParts {
            output: output.collect(),
            time_s: Some((0..n).map(|k| k as f64).collect()),
            drive: (0..n).map(level).collect(),
            output_unit: "mm".to_owned(),
            ..RecordingParts::default()
        })
        .unwrap()
    }

    #[test]
    fn the_largest_noise_is_no_less_than_the_least_where_one_quiet_recording_alone_has_rests() {
        let quiet = recording(400, 0.5, 0.002);
        let loud = recording(2000, 0.0, 0.03);
        let alone = measured(std::slice::from_ref(&quiet), 5.0);
        assert!(alone.upper.unwrap() < 0.005, "{alone:?}");
        let both = measured(&[quiet, loud], 5.0);
        assert!((0.02..0.03).contains(&both.lower), "{both:?}");
        assert!(both.upper.unwrap() >= both.lower, "{both:?}");
    }
}
