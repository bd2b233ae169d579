use core::f64::consts::PI;

use crate::TuneError;
use crate::complex::Complex;
use crate::error::{positive, some_finite};
use crate::open_loop::frequencies;

/// How the output of a plant answers a small change of its drive, which is held from sample to sample.
///
/// ```text
/// P(z) = Σ p_k z^(-k),   p_k = (s_k - s_(k-1))/δ
/// ```
///
/// with the output's change s_k, k samples after a change δ of the drive that stays: exact for what is sampled, whatever
/// the plant is, as long as the change is small and goes one way.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantResponse {
    dt_s: f64,
    /// p, from k = 1.
    pulse: Vec<f64>,
    /// The rest of it, where the answer was cut before it was done.
    tail: Option<Tail>,
    /// Frequencies, rad/s, and P there.
    swept: Vec<(f64, Complex)>,
}

/// End of an answer that dies out like a lag: increments that shrink by one factor from sample to sample.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tail {
    /// The first of them.
    first: f64,
    /// The factor, above 0 and below 1.
    retained: f64,
}

impl Tail {
    /// By the last eighth of an answer and the one before; `None` where it stands, or does not die out.
    fn of(step_response: &[f64]) -> Option<Self> {
        let n = step_response.len();
        let eighth = n / 8;
        let at = |eighths: usize| step_response[n - 1 - eighths * eighth];
        let [end, before, earlier] = [at(0), at(1), at(2)];
        let (last, former) = (end - before, before - earlier);
        let ratio = last / former;
        if eighth == 0 || last.abs() <= DONE * end.abs() || !(ratio > 0.0 && ratio < 1.0) {
            return None;
        }
        let retained = libm::pow(ratio, 1.0 / eighth as f64);
        // All that follows is last (ratio + ratio² + ...).
        let left = last * ratio / (1.0 - ratio);
        Some(Self {
            first: left * (1.0 - retained),
            retained,
        })
    }

    /// Sum of all increments.
    fn sum(self) -> f64 {
        self.first / (1.0 - self.retained)
    }
}

/// Share of an answer by which it may still grow over its last eighth, where it counts as done.
const DONE: f64 = 1e-3;

/// A lag of first order with dead time: what rules of thumb for gains ask for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstOrder {
    /// Output per drive in the end.
    pub gain: f64,
    /// Time constant, s.
    pub tau_s: f64,
    /// Time from a change of the drive to the first answer, s; half of the hold is part of it.
    pub dead_time_s: f64,
}

impl PlantResponse {
    /// From the output's changes per change of the drive, 1, 2, ... samples after it, until nothing moves any more. An answer
    /// that still moves at its end is taken to die out as it does over its last quarter.
    /// `dead_time_samples` stand before them.
    ///
    /// # Errors
    ///
    /// [`TuneError::NotPositive`] for the sample time, [`TuneError::Empty`] without changes, [`TuneError::NotFiniteAt`]
    /// for one of them.
    pub fn new(
        dt_s: f64,
        dead_time_samples: usize,
        step_response: &[f64],
    ) -> Result<Self, TuneError> {
        positive("dt_s", dt_s)?;
        some_finite("step_response", step_response)?;
        let mut pulse = vec![0.0; dead_time_samples];
        let mut before = 0.0;
        for &answer in step_response {
            pulse.push(answer - before);
            before = answer;
        }
        let lasts_s = step_response.len() as f64 * dt_s;
        let mut response = Self {
            dt_s,
            pulse,
            tail: Tail::of(step_response),
            swept: Vec::new(),
        };
        response.swept = frequencies(1.0 / lasts_s, PI / dt_s)
            .into_iter()
            .map(|omega| (omega, response.at(omega)))
            .collect();
        Ok(response)
    }

    /// P at a frequency, rad/s.
    #[must_use]
    pub fn at(&self, omega_rad_per_s: f64) -> Complex {
        let back = Complex::unit(-omega_rad_per_s * self.dt_s);
        // Horner's scheme, from the end: the tail, then the last sample.
        let mut sum = self.tail.map_or(Complex::real(0.0), |tail| {
            let kept = Complex::ONE + back * -tail.retained;
            back * tail.first / kept
        });
        for &pulse in self.pulse.iter().rev() {
            sum = (sum + Complex::real(pulse)) * back;
        }
        sum
    }

    /// Frequencies, rad/s, rising to half of the sampling frequency, and P there.
    #[must_use]
    pub fn swept(&self) -> impl ExactSizeIterator<Item = (f64, Complex)> {
        self.swept.iter().copied()
    }

    /// Output per drive in the end.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.pulse.iter().sum::<f64>() + self.tail.map_or(0.0, Tail::sum)
    }

    /// The lag with dead time that is nearest by two points, where 28 and 63 % of the way are done
    /// `[Smith1985]`:
    ///
    /// ```text
    /// τ = 1.5 (t_63 - t_28),   θ = t_63 - τ + Δt/2
    /// ```
    ///
    /// `None` if the output does not rise with the drive.
    #[must_use]
    pub fn first_order(&self) -> Option<FirstOrder> {
        let gain = self.gain();
        if gain <= 0.0 {
            return None;
        }
        let reaches = |share: f64| {
            let mut risen = 0.0;
            for (k, &pulse) in self.pulse.iter().enumerate() {
                let next = risen + pulse;
                if next >= share * gain {
                    let part = (share * gain - risen) / pulse;
                    return Some(self.dt_s * (k as f64 + part));
                }
                risen = next;
            }
            // 1 - ρ^k of the tail's sum is done after k samples of it.
            let tail = self.tail?;
            let left = 1.0 - (share * gain - risen) / tail.sum();
            let samples = libm::log(left) / libm::log(tail.retained);
            samples
                .is_finite()
                .then_some(self.dt_s * (self.pulse.len() as f64 + samples))
        };
        let [early_s, late_s] = [reaches(0.283)?, reaches(0.632)?];
        let tau_s = 1.5 * (late_s - early_s);
        Some(FirstOrder {
            gain,
            tau_s,
            dead_time_s: (late_s - tau_s).max(0.0) + 0.5 * self.dt_s,
        })
    }
}
