use core::f64::consts::PI;

use wiener::hysteresis::{Memory, Rule};

use crate::bracket::root;
use crate::complex::unwrapped;
use crate::describing::BiasedSine;
use crate::fraction_response::{FractionResponse, SampledCycle, TemperatureSine, crept_memory};
use crate::{AntiWindup, Approach, DriveLimits, LinearLoop, RodLoop};

/// Ratio of higher harmonics above which a prediction is called unreliable.
pub const RELIABLE_HARMONIC_RATIO: f64 = 0.3;

/// Amplitudes of the temperature tried, from [`SMALLEST_AMPLITUDE_K`] in equal ratios.
const N_AMPLITUDES: usize = 48;
/// Far below every loop's width: here a cycle sees the slope at a reversal.
const SMALLEST_AMPLITUDE_K: f64 = 1e-3;
/// To this the bias of the temperature is found, K.
const BIAS_TOLERANCE_K: f64 = 1e-9;
/// Rounds in which frequency, bias and the controller's gain are brought together.
const ROUNDS: usize = 8;
/// Share to which they are.
const ROUND_TOLERANCE: f64 = 1e-9;
/// Frequencies within this ratio at neighboring amplitudes belong to one curve.
const SAME_CURVE: f64 = 1.5;
/// Distance from -π at half of the sampling frequency, rad, that still counts as reaching it.
const ANGLE_TOLERANCE_RAD: f64 = 1e-3;

/// A limit cycle that harmonic balance predicts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedCycle {
    /// How the rod came there; under [`Rule::LastReversal`] cycles are the same for both, and counted once, as
    /// from below.
    pub approach: Approach,
    /// Amplitude of the output's first harmonic (mean to peak), in the output's unit.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Mean of the output, in its unit.
    pub mean_output: f64,
    /// Mean temperature T0, °C.
    pub bias_degc: f64,
    /// Amplitude of the temperature A, K.
    pub temperature_amplitude_k: f64,
    /// Higher harmonics over the first in what the controller sees: root of the squares of those that the drive leaves
    /// in the temperature, behind the lag, and those that the hysteresis adds.
    pub harmonic_ratio: f64,
    /// True if that ratio is at most [`RELIABLE_HARMONIC_RATIO`].
    pub reliable: bool,
    /// True if a cycle a little larger shrinks and one a little smaller grows: Loeb's criterion, along the curve on
    /// which the phase is balanced.
    pub stable: bool,
}

/// A loop whose temperature is a sine and whose means are balanced.
#[derive(Debug, Clone, Copy)]
struct Balance {
    temperature: TemperatureSine,
    fraction: FractionResponse,
    /// Drive before the limits.
    drive: BiasedSine,
    omega_rad_per_s: f64,
    /// |L N| at that frequency: 1 for a limit cycle.
    loop_gain: f64,
}

/// Harmonic balance of one loop under one approach.
struct HarmonicBalance<'a> {
    rod_loop: &'a RodLoop,
    memory: Memory<1>,
    cycle: SampledCycle,
    /// All that is linear, with a temperature that follows drive and output follows temperature 1 : 1.
    linear: LinearLoop,
    omegas: Vec<f64>,
    /// arg L at those, unwrapped.
    angles_rad: Vec<f64>,
}

impl RodLoop {
    /// Limit cycles by harmonic balance of bias and first harmonic, in the order of their temperatures' amplitudes;
    /// empty if none is found.
    ///
    /// ```text
    /// T = T0 + A sin θ   e = r - gain ξ - offset   v = U0 + U1 sin(θ + φ)
    /// first harmonic     1 + L(e^(jωΔt)) N_P(U0, U1) gain N_ξ(T0, A) = 0,   U1 = |C| |gain| |N_ξ| A
    /// mean of heat       T0 - T_a = mean rise(U0, U1)
    /// mean of the rest   ki = 0: U0 = kp (r - y0);   ki > 0: the integral is still over a cycle
    /// ```
    ///
    /// with the describing functions N_P of limits and square ([`DriveLimits::saturated_sine_squared`]) and N_ξ of the
    /// hysteresis ([`fraction_response`](crate::fraction_response)) `[Gelb1968, chapters 3, 6]`, and L the linear rest
    /// with the hold, exact in z ([`LinearLoop`]).
    ///
    /// "Still" depends on what stops windup. Off: the mean error is 0. Back-calculation: ki times it makes up for the
    /// mean that the limits cut off. Clamping: the mean of the error *while it is integrated* is 0; in a loop
    /// that works like a relay this is little of the cycle, and its mean error is far from 0. For that mean the
    /// error counts as in phase with the drive, which a derivative or a large integral gain makes wrong.
    ///
    /// The cycle counts as seen at any phase of the samples. With less than some ten samples to a period it locks to
    /// them: [`RodLoop::chatter_orbits`] looks for those.
    #[must_use]
    pub fn predicted_cycles(&self) -> Vec<PredictedCycle> {
        let approaches: &[Approach] = match self.params().rule {
            Rule::LastReversal => &[Approach::FromBelow],
            Rule::Nested => &[Approach::FromBelow, Approach::FromAbove],
        };
        approaches
            .iter()
            .flat_map(|&approach| HarmonicBalance::new(self, approach).cycles(approach))
            .collect()
    }
}

impl<'a> HarmonicBalance<'a> {
    fn new(rod_loop: &'a RodLoop, approach: Approach) -> Self {
        let linear = rod_loop.linear(1.0);
        let omegas = linear.sweep();
        let mut before_rad = 0.0;
        let angles_rad = omegas
            .iter()
            .map(|&omega| {
                before_rad = unwrapped(linear.response(omega).angle_rad(), before_rad);
                before_rad
            })
            .collect();
        Self {
            rod_loop,
            memory: rod_loop.history(approach),
            cycle: SampledCycle::new(),
            linear,
            omegas,
            angles_rad,
        }
    }

    /// Follows each curve of balanced phase over the amplitudes, and finds where it passes a loop gain of 1.
    fn cycles(&self, approach: Approach) -> Vec<PredictedCycle> {
        let limits = self.rod_loop.limits();
        let largest_k = 0.5
            * (self.rod_loop.balance_degc(limits.upper) - self.rod_loop.balance_degc(limits.lower));
        let ratio = libm::pow(
            largest_k / SMALLEST_AMPLITUDE_K,
            1.0 / (N_AMPLITUDES - 1) as f64,
        );
        let mut cycles = Vec::new();
        let mut amplitude_k = SMALLEST_AMPLITUDE_K;
        let mut before = self.balances(amplitude_k);
        for _ in 1..N_AMPLITUDES {
            amplitude_k *= ratio;
            let after = self.balances(amplitude_k);
            for small in &before {
                let Some(large) = nearest(&after, small.omega_rad_per_s) else {
                    continue;
                };
                if (small.loop_gain - 1.0) * (large.loop_gain - 1.0) < 0.0 {
                    let found = self.refined(*small, large);
                    let stable = small.loop_gain > 1.0;
                    cycles.push(self.predicted(&found, approach, stable));
                }
            }
            before = after;
        }
        cycles
    }

    /// The balance with a loop gain of 1 between two.
    fn refined(&self, small: Balance, large: Balance) -> Balance {
        let mut found = large;
        let ends = [small, large].map(|balance| libm::log(balance.temperature.amplitude_k));
        let excess = |logarithm: f64| {
            let balances = self.balances(libm::exp(logarithm));
            match nearest(&balances, found.omega_rad_per_s) {
                Some(balance) => {
                    found = balance;
                    balance.loop_gain - 1.0
                }
                None => f64::NAN,
            }
        };
        let _amplitude = root(excess, ends, ROUND_TOLERANCE);
        found
    }

    /// All frequencies at which means and phase are balanced at an amplitude.
    fn balances(&self, amplitude_k: f64) -> Vec<Balance> {
        let middle = 0.5 * self.linear.nyquist_rad_per_s();
        let Some(first) = self.means(amplitude_k, middle) else {
            return Vec::new();
        };
        self.crossovers(first.fraction.first.angle_rad())
            .into_iter()
            .filter_map(|omega| self.brought_together(first, omega))
            .collect()
    }

    /// Balances the means with the controller's gain at the frequency that they lead to.
    fn brought_together(&self, first: Balance, omega_rad_per_s: f64) -> Option<Balance> {
        let mut omega = omega_rad_per_s;
        let mut balance = first;
        for _ in 0..ROUNDS {
            let gain_before = self
                .linear
                .controller_response(balance.omega_rad_per_s)
                .magnitude();
            let gain = self.linear.controller_response(omega).magnitude();
            if (gain - gain_before).abs() <= ROUND_TOLERANCE * gain {
                break;
            }
            balance = self.means(first.temperature.amplitude_k, omega)?;
            let crossovers = self.crossovers(balance.fraction.first.angle_rad());
            balance.omega_rad_per_s = omega;
            omega = crossovers
                .into_iter()
                .filter(|&other| near(other, omega))
                .min_by(|a, b| (a - omega).abs().total_cmp(&(b - omega).abs()))?;
        }
        balance.omega_rad_per_s = omega;
        let rise = self.rod_loop.rise(balance.drive);
        let slope = self.rod_loop.params().rod.gain * balance.fraction.first.magnitude()
            / balance.temperature.amplitude_k;
        balance.loop_gain = self.linear.response(omega).magnitude() * slope.abs() * rise.first
            / balance.drive.amplitude;
        Some(balance)
    }

    /// Frequencies at which the angle of L, with that of the hysteresis, is an odd multiple of π.
    fn crossovers(&self, hysteresis_rad: f64) -> Vec<f64> {
        let sign_rad = if self.rod_loop.params().rod.gain < 0.0 {
            PI
        } else {
            0.0
        };
        let extra_rad = hysteresis_rad + sign_rad + PI;
        let turns = |angle_rad: f64| libm::floor((angle_rad + extra_rad) / (2.0 * PI)) as i64;
        let mut crossovers = Vec::new();
        for k in 1..self.omegas.len() {
            let [before, after] = [turns(self.angles_rad[k - 1]), turns(self.angles_rad[k])];
            if before == after {
                continue;
            }
            let target_rad = 2.0 * PI * before.max(after) as f64 - extra_rad;
            let off_rad = |omega: f64| {
                let angle_rad = self.linear.response(omega).angle_rad();
                unwrapped(angle_rad, self.angles_rad[k]) - target_rad
            };
            let ends = [self.omegas[k - 1], self.omegas[k]];
            crossovers.extend(root(off_rad, ends, 1e-12 * self.omegas[k]));
        }
        if let (Some(&angle_rad), Some(&omega)) = (self.angles_rad.last(), self.omegas.last())
            && crossovers.is_empty()
            && unwrapped(angle_rad + extra_rad, 0.0).abs() < ANGLE_TOLERANCE_RAD
        {
            crossovers.push(omega);
        }
        crossovers
    }

    /// Balances the means at an amplitude; `None` where the drive cannot.
    fn means(&self, amplitude_k: f64, omega_rad_per_s: f64) -> Option<Balance> {
        let limits = self.rod_loop.limits();
        let gain = self.linear.controller_response(omega_rad_per_s).magnitude();
        let at = |bias_degc: f64| {
            let temperature = TemperatureSine {
                bias_degc,
                amplitude_k,
            };
            let fraction = self.fraction(temperature);
            let amplitude =
                gain * self.rod_loop.params().rod.gain.abs() * fraction.first.magnitude();
            let bias = self.drive_bias(bias_degc, amplitude);
            Balance {
                temperature,
                fraction,
                drive: BiasedSine { bias, amplitude },
                omega_rad_per_s,
                loop_gain: f64::NAN,
            }
        };
        let ends = [limits.lower, limits.upper].map(|drive| self.rod_loop.balance_degc(drive));
        let bias_degc = root(
            |bias_degc| self.drift(&at(bias_degc)),
            ends,
            BIAS_TOLERANCE_K,
        )?;
        let balance = at(bias_degc);
        (balance.drive.amplitude > 0.0).then_some(balance)
    }

    fn fraction(&self, temperature: TemperatureSine) -> FractionResponse {
        let hysteresis = self.rod_loop.plant().hysteresis();
        let memory = match self.rod_loop.params().rule {
            Rule::LastReversal => crept_memory(hysteresis, temperature),
            Rule::Nested => self.memory.clone(),
        };
        self.cycle.response(hysteresis, memory, temperature)
    }

    /// U0 whose mean heat holds a temperature.
    fn drive_bias(&self, bias_degc: f64, amplitude: f64) -> f64 {
        let DriveLimits { lower, upper } = self.rod_loop.limits();
        let ends = [lower - amplitude, upper + amplitude];
        let ambient_degc = self.rod_loop.params().ambient_degc;
        let excess_k = |bias: f64| {
            ambient_degc + self.rod_loop.rise(BiasedSine { bias, amplitude }).mean - bias_degc
        };
        let tolerance = 1e-13 * (ends[1] - ends[0]);
        // The ends are those of the drive: rounding alone can put the temperature beyond them.
        root(excess_k, ends, tolerance).unwrap_or(if excess_k(ends[0]) > 0.0 {
            ends[0]
        } else {
            ends[1]
        })
    }

    /// Imbalance that would move the bias of the controller if the cycle went on, in the drive's unit: 0 in
    /// balance, > 0 if it would heat more.
    fn drift(&self, balance: &Balance) -> f64 {
        let params = self.rod_loop.params();
        let kp = params.gains.kp;
        let ki = params.gains.ki;
        let error = params.setpoint - self.rod_loop.output_at(balance.fraction.mean);
        if ki > 0.0 {
            let limits = params.controller.limits;
            match params.controller.anti_windup {
                AntiWindup::Off => error,
                AntiWindup::Clamping => {
                    let swing = params.rod.gain.abs() * balance.fraction.first.magnitude();
                    integrated_mean(
                        BiasedSine {
                            bias: error,
                            amplitude: swing,
                        },
                        balance.drive,
                        limits,
                    )
                }
                AntiWindup::BackCalculation { tracking_s } => {
                    let cut = limits.sine_response(balance.drive).mean - balance.drive.bias;
                    ki * error + cut / tracking_s
                }
            }
        } else {
            kp * error - balance.drive.bias
        }
    }

    fn predicted(&self, balance: &Balance, approach: Approach, stable: bool) -> PredictedCycle {
        let limits = self.rod_loop.limits();
        let lag = balance.omega_rad_per_s * self.rod_loop.tau_s();
        let BiasedSine { bias, amplitude } = balance.drive;
        let of_drive = self.cycle.harmonic_ratio(
            |sin| {
                let drive = (bias + amplitude * sin).max(limits.lower).min(limits.upper);
                self.rod_loop.balance_degc(drive)
            },
            |order| 1.0 / libm::hypot(1.0, order * lag),
        );
        let harmonic_ratio = libm::hypot(of_drive, balance.fraction.harmonic_ratio);
        PredictedCycle {
            approach,
            amplitude: self.rod_loop.params().rod.gain.abs() * balance.fraction.first.magnitude(),
            frequency_hz: balance.omega_rad_per_s / (2.0 * PI),
            mean_output: self.rod_loop.output_at(balance.fraction.mean),
            bias_degc: balance.temperature.bias_degc,
            temperature_amplitude_k: balance.temperature.amplitude_k,
            harmonic_ratio,
            reliable: harmonic_ratio <= RELIABLE_HARMONIC_RATIO,
            stable,
        }
    }
}

/// Mean of the error over what clamping integrates: all but where error and excess of the drive have one sign.
fn integrated_mean(error: BiasedSine, drive: BiasedSine, limits: DriveLimits) -> f64 {
    let angle_rad = |sine: BiasedSine, level: f64| libm::asin(sine.sine_at(level));
    let error_rad = angle_rad(error, 0.0);
    let from_rad = error_rad.min(angle_rad(drive, limits.lower));
    let to_rad = error_rad.max(angle_rad(drive, limits.upper));
    (error.bias * (to_rad - from_rad) + error.amplitude * (libm::cos(from_rad) - libm::cos(to_rad)))
        / PI
}

fn near(omega: f64, other: f64) -> bool {
    omega.max(other) < SAME_CURVE * omega.min(other)
}

fn nearest(balances: &[Balance], omega_rad_per_s: f64) -> Option<Balance> {
    let distance = |balance: &&Balance| (balance.omega_rad_per_s - omega_rad_per_s).abs();
    balances
        .iter()
        .filter(|balance| near(balance.omega_rad_per_s, omega_rad_per_s))
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .copied()
}
