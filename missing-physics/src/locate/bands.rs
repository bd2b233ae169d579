//! Bands of frequency: how fast the error changes.

use std::f64::consts::PI;

use identify::ResidualNoise;

use crate::Band;
use crate::locate::located::Located;
use crate::pullback::scene::{Passage, Scene};

/// Bands between one period in the longest recording and half the finest sampling.
const N_BANDS: usize = 5;

/// Shares of the explainable error by frequency, from slow to fast.
///
/// Periodogram of each recording less the spectrum of noise at the floor with the memory of the residual.
pub(crate) fn bands(located: &Located<'_>, scene: &Scene) -> Vec<Band> {
    let edges_hz = edges_hz(scene);
    if edges_hz.is_empty() {
        return Vec::new();
    }
    let mut energies = [0.0; N_BANDS];
    for passage in &scene.passages {
        let power = periodogram(&located.node.residual[passage.range.clone()]);
        let dt_s = median_dt_s(passage);
        let n = power.len();
        let shape = spectrum(&located.node.noise.output, n);
        let per = passage.len() as f64 * located.floor.powi(2) / shape.iter().sum::<f64>();
        for k in 1..=n / 2 {
            let hz = k as f64 / (n as f64 * dt_s);
            let inner = &edges_hz[1..N_BANDS];
            let band = inner.partition_point(|edge| *edge <= hz);
            // Frequencies beyond half the sampling mirror those below it.
            let twice = if 2 * k == n { 1.0 } else { 2.0 };
            energies[band] += twice * (power[k] - per * shape[k]);
        }
    }
    let positive = energies.iter().map(|energy: &f64| energy.max(0.0));
    let whole: f64 = positive.clone().sum();
    let share = |energy: f64| if whole > 0.0 { energy / whole } else { 0.0 };
    positive
        .zip(edges_hz.windows(2))
        .map(|(energy, edges)| Band {
            hz: [edges[0], edges[1]],
            share: share(energy),
        })
        .collect()
}

/// Ends of the bands, Hz, equal ratios apart.
fn edges_hz(scene: &Scene) -> Vec<f64> {
    let longest_s = scene.passages.iter().map(|passage| {
        let last = passage.len() - 1;
        passage.time_s[last] - passage.time_s[0] + passage.dt_s[last]
    });
    let lowest = 1.0 / longest_s.fold(0.0, f64::max);
    let highest = scene
        .passages
        .iter()
        .map(|passage| 0.5 / median_dt_s(passage));
    let ratio = highest.fold(0.0, f64::max) / lowest;
    if !(ratio > 1.0 && ratio.is_finite()) {
        return Vec::new();
    }
    (0..=N_BANDS)
        .map(|j| lowest * ratio.powf(j as f64 / N_BANDS as f64))
        .collect()
}

fn median_dt_s(passage: &Passage) -> f64 {
    let mut dt_s = passage.dt_s.clone();
    dt_s.sort_by(f64::total_cmp);
    dt_s[dt_s.len() / 2]
}

/// |DFT|²/n of a series without its mean, padded with zeros to n, the next power of two: it sums to the sum
/// of squares.
fn periodogram(series: &[f64]) -> Vec<f64> {
    let mean = series.iter().sum::<f64>() / series.len() as f64;
    let mut real: Vec<f64> = series.iter().map(|value| value - mean).collect();
    let n = series.len().next_power_of_two();
    real.resize(n, 0.0);
    let mut imaginary = vec![0.0; n];
    transform(&mut real, &mut imaginary);
    let pairs = real.iter().zip(&imaginary);
    pairs
        .map(|(re, im)| (re * re + im * im) / n as f64)
        .collect()
}

/// Discrete Fourier transform in place, of a power of two of values (Cooley and Tukey's, radix 2).
fn transform(real: &mut [f64], imaginary: &mut [f64]) {
    let n = real.len();
    if n < 2 {
        return;
    }
    let parts = |values: &[f64], odd: usize| -> Vec<f64> {
        values.iter().skip(odd).step_by(2).copied().collect()
    };
    let (mut even_re, mut even_im) = (parts(real, 0), parts(imaginary, 0));
    let (mut odd_re, mut odd_im) = (parts(real, 1), parts(imaginary, 1));
    transform(&mut even_re, &mut even_im);
    transform(&mut odd_re, &mut odd_im);
    for k in 0..n / 2 {
        let angle = -2.0 * PI * k as f64 / n as f64;
        let (cos, sin) = (libm::cos(angle), libm::sin(angle));
        let re = cos * odd_re[k] - sin * odd_im[k];
        let im = cos * odd_im[k] + sin * odd_re[k];
        (real[k], imaginary[k]) = (even_re[k] + re, even_im[k] + im);
        (real[k + n / 2], imaginary[k + n / 2]) = (even_re[k] - re, even_im[k] - im);
    }
}

/// Spectrum of an autoregressive model at n frequencies, but for a factor: 1/|1 - Σ a_i e^(-iωi)|².
fn spectrum(noise: &ResidualNoise, n: usize) -> Vec<f64> {
    (0..n)
        .map(|k| {
            let omega = 2.0 * PI * k as f64 / n as f64;
            let (mut re, mut im) = (1.0, 0.0);
            for (i, a) in noise.coefficients.iter().enumerate() {
                let angle = omega * (i + 1) as f64;
                re -= a * libm::cos(angle);
                im += a * libm::sin(angle);
            }
            1.0 / (re * re + im * im).max(f64::MIN_POSITIVE)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_stands_at_its_frequency() {
        let n = 256;
        let series: Vec<f64> = (0..n)
            .map(|k| (2.0 * PI * 12.0 * k as f64 / n as f64).sin())
            .collect();
        let power = periodogram(&series);
        assert!((power[12] - n as f64 / 4.0).abs() < 1e-9);
        assert!((power[n - 12] - n as f64 / 4.0).abs() < 1e-9);
        assert!((power.iter().sum::<f64>() - n as f64 / 2.0).abs() < 1e-9);
    }

    #[test]
    fn padding_keeps_the_sum_of_squares() {
        let series: Vec<f64> = (0..300).map(|k| (0.37 * k as f64).sin()).collect();
        let mean = series.iter().sum::<f64>() / 300.0;
        let squares: f64 = series.iter().map(|value| (value - mean).powi(2)).sum();
        assert!((periodogram(&series).iter().sum::<f64>() / squares - 1.0).abs() < 1e-12);
    }
}
