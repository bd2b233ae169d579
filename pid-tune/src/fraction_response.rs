use core::f64::consts::PI;

use wiener::hysteresis::{Hysteresis, Memory, Proximity};

use crate::TuneError;
use crate::bracket::root;
use crate::complex::Complex;
use crate::error::{finite, positive};

/// Samples of one cycle; a multiple of 4, so that both extremes are among them.
const SAMPLES: usize = 96;

/// Most cycles before the operator counts as not periodic.
pub const MAX_SETTLING_CYCLES: usize = 1000;

/// Largest change of a fraction from cycle to cycle that counts as none.
const PERIODIC: f64 = 1e-10;

/// A sine of the temperature about a bias, T0 + A sin θ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TemperatureSine {
    /// T0, °C; finite.
    pub bias_degc: f64,
    /// A, K; finite and > 0.
    pub amplitude_k: f64,
}

/// Harmonics of the fraction while the temperature is a sine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FractionResponse {
    /// Mean over a cycle.
    pub mean: f64,
    /// First harmonic: the real part is in phase with the temperature, the imaginary part a quarter of a cycle
    /// ahead. Over A it is the describing function, 1/K; hysteresis lags, so that the imaginary part is ≤ 0.
    pub first: Complex,
    /// Root of the sum of squares of all higher harmonics, over the first.
    pub harmonic_ratio: f64,
    /// Cycles until two successive ones agreed.
    pub n_cycles: usize,
    /// True if two successive cycles agreed within [`MAX_SETTLING_CYCLES`].
    pub periodic: bool,
}

/// Dual-input describing function of a hysteresis, from the operator itself.
///
/// ```text
/// mean = (1/2π) ∮ ξ dθ,   first = (1/π) ∮ ξ (sin θ + j cos θ) dθ,   T = T0 + A sin θ     [Gelb1968, chapter 6]
/// ```
///
/// The operator starts from `memory`, goes up to T0 + A and cycles until its fractions repeat; then a cycle is
/// summed over 96 samples.
///
/// History counts. Under [`Rule::Nested`](wiener::hysteresis::Rule::Nested) a cycle that hangs from
/// the heating curve (a rod heated from rest) and one that hangs from the cooling curve have different means
/// at the same temperatures, and both stay; what a rod went through before its cycle must be in `memory`. Under
/// [`Rule::LastReversal`](wiener::hysteresis::Rule::LastReversal) cycles do not close at first: they creep,
/// the more slowly the smaller they are, to one that does not depend on history.
///
/// # Errors
///
/// [`TuneError::NotFinite`] for the bias, [`TuneError::NotPositive`] for the amplitude.
pub fn fraction_response<P: Proximity>(
    hysteresis: &Hysteresis<1, P>,
    memory: &Memory<1>,
    sine: TemperatureSine,
) -> Result<FractionResponse, TuneError> {
    finite("bias_degc", sine.bias_degc)?;
    positive("amplitude_k", sine.amplitude_k)?;
    Ok(SampledCycle::new().response(hysteresis, memory.clone(), sine))
}

/// The sine over one cycle, from its lowest point on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SampledCycle {
    sin_cos: [[f64; 2]; SAMPLES],
}

impl SampledCycle {
    pub(crate) fn new() -> Self {
        Self {
            sin_cos: core::array::from_fn(|k| {
                let angle = Complex::unit(2.0 * PI * (k + 1) as f64 / SAMPLES as f64);
                // sin(θ - π/2) and cos(θ - π/2).
                [-angle.re, angle.im]
            }),
        }
    }

    /// The response to a sine that was checked.
    pub(crate) fn response<P: Proximity>(
        &self,
        hysteresis: &Hysteresis<1, P>,
        mut memory: Memory<1>,
        sine: TemperatureSine,
    ) -> FractionResponse {
        let TemperatureSine {
            bias_degc,
            amplitude_k,
        } = sine;
        let ends_degc = [bias_degc + amplitude_k, bias_degc - amplitude_k];
        // A branch does not depend on the points visited on the way: its ends are enough.
        let mut cycle = || ends_degc.map(|end_degc| hysteresis.commit(&mut memory, [end_degc])[0]);
        let mut ends = cycle();
        let mut n_cycles = 1;
        let mut periodic = false;
        while !periodic && n_cycles < MAX_SETTLING_CYCLES {
            let next = cycle();
            periodic = (next[0] - ends[0]).abs().max((next[1] - ends[1]).abs()) <= PERIODIC;
            ends = next;
            n_cycles += 1;
        }
        let mut sum = 0.0;
        let mut first = Complex::real(0.0);
        // About the middle, so that the square loses no digits.
        let middle = 0.5 * (ends[0] + ends[1]);
        let mut square = 0.0;
        for [sin, cos] in self.sin_cos {
            let [fraction] = hysteresis.commit(&mut memory, [bias_degc + amplitude_k * sin]);
            let fraction = fraction - middle;
            sum += fraction;
            square += fraction * fraction;
            first.re += fraction * sin;
            first.im += fraction * cos;
        }
        let per_sample = 1.0 / SAMPLES as f64;
        let mean = sum * per_sample;
        let first = first * (2.0 * per_sample);
        let variance = square * per_sample - mean * mean;
        let first_square = first.re * first.re + first.im * first.im;
        FractionResponse {
            mean: middle + mean,
            first,
            harmonic_ratio: (2.0 * variance / first_square - 1.0).max(0.0).sqrt(),
            n_cycles,
            periodic,
        }
    }

    /// Square of the higher harmonics of a function of the sine over that of the first, each harmonic k weighted
    /// by the square of `weight(k)`.
    pub(crate) fn harmonic_ratio(
        &self,
        function: impl Fn(f64) -> f64,
        weight: impl Fn(f64) -> f64,
    ) -> f64 {
        let values: Vec<f64> = self.sin_cos.iter().map(|[sin, _]| function(*sin)).collect();
        let harmonic = |order: usize| {
            let mut sum = Complex::real(0.0);
            for (k, value) in values.iter().enumerate() {
                let turn = 2.0 * PI * (order * (k + 1) % SAMPLES) as f64 / SAMPLES as f64;
                sum = sum + Complex::unit(turn) * *value;
            }
            sum.magnitude()
        };
        let first = harmonic(1) * weight(1.0);
        let square: f64 = (2..=HIGHEST_HARMONIC)
            .map(|order| harmonic(order) * weight(order as f64))
            .map(|harmonic| harmonic * harmonic)
            .sum();
        square.sqrt() / first
    }
}

/// Harmonics of the drive that are looked at: behind the lag the next are below 1/12 of their share in the drive.
const HIGHEST_HARMONIC: usize = 12;

/// Memory of the cycle to which [`Rule::LastReversal`](wiener::hysteresis::Rule::LastReversal) creeps between
/// two temperatures, at its lower end.
///
/// Only the last reversal counts, so that the fraction at the lower end is all there is to find: the one that
/// comes back after a cycle.
pub(crate) fn crept_memory<P: Proximity>(
    hysteresis: &Hysteresis<1, P>,
    sine: TemperatureSine,
) -> Memory<1> {
    let lower_degc = [sine.bias_degc - sine.amplitude_k];
    let upper_degc = [sine.bias_degc + sine.amplitude_k];
    let start = |share: f64| hysteresis.between_limiting_curves(lower_degc, [share]);
    let creep = |share: f64| {
        let mut memory = start(share);
        let [before] = hysteresis.peek(&memory, lower_degc).fraction;
        let _upper = hysteresis.commit(&mut memory, upper_degc);
        let [after] = hysteresis.commit(&mut memory, lower_degc);
        after - before
    };
    start(root(creep, [0.0, 1.0], 1e-9).unwrap_or(0.5))
}
