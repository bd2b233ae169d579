//! Means over as many samples of a series as it is straight over.

/// Standard deviations of the noise from which a bend is believed.
const BENDS: f64 = 2.0;

/// Share of the second differences that measure the noise: the largest may be steps, corners and wild samples.
const QUIET: f64 = 0.95;

/// Variance of the nearest share `QUIET` of a normal distribution, over that of all.
const OF_QUIET: f64 = 0.759;

/// A series at the samples `kept`, which rise: the mean of the samples around each, up to halfway to the next one that is kept, as far as no
/// bend is seen.
///
/// ```text
/// bend = mean of the 2n samples around the window - mean of its n;   sd = σ √(3/(2n))
/// ```
///
/// A window of n samples is as wide as that stays below two standard deviations. One that is curved alike over three times its width is
/// off by a fifth of the standard deviation of its mean at most, one with a corner in its middle by less than one.
pub(crate) fn straight_means(series: &[f64], kept: &[usize]) -> Vec<f64> {
    let sums = sums(series);
    let total = |from: usize, to: usize| sums[to] - sums[from];
    let variance = noise_variance(series);
    let is_straight = |k: usize, half: usize| {
        let outer = 3 * half + 1;
        if outer > k || k + outer >= series.len() {
            return false;
        }
        let n = (2 * half + 1) as f64;
        let own = total(k - half, k + half + 1);
        let around = total(k - outer, k + outer + 1) - own;
        let bend = around / (2.0 * n) - own / n;
        bend.powi(2) <= BENDS.powi(2) * variance * 1.5 / n
    };
    let mean = |j: usize| {
        let k = kept[j];
        let before = if j == 0 { 0 } else { k - kept[j - 1] };
        let after = kept.get(j + 1).map_or(0, |next| next - k);
        let mut half = before.min(after) / 2;
        while half > 0 && !is_straight(k, half) {
            half /= 2;
        }
        total(k - half, k + half + 1) / (2 * half + 1) as f64
    };
    (0..kept.len()).map(mean).collect()
}

/// Sums of the samples before each.
fn sums(series: &[f64]) -> Vec<f64> {
    let before = series.iter().scan(0.0, |sum, y| {
        *sum += y;
        Some(*sum)
    });
    std::iter::once(0.0).chain(before).collect()
}

/// Variance of the white noise of a series, from its second differences.
fn noise_variance(series: &[f64]) -> f64 {
    let second = series.windows(3).map(|y| y[0] - 2.0 * y[1] + y[2]);
    let mut squares: Vec<f64> = second.map(|one| one.powi(2)).collect();
    squares.sort_by(f64::total_cmp);
    squares.truncate((QUIET * squares.len() as f64).ceil() as usize);
    if squares.is_empty() {
        return 0.0;
    }
    squares.iter().sum::<f64>() / squares.len() as f64 / 6.0 / OF_QUIET
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const N: usize = 6001;
    const EVERY: usize = 12;

    fn kept() -> Vec<usize> {
        (0..N).step_by(EVERY).collect()
    }

    /// Distance of straight means from a truth at each kept sample, with uniform noise of variance 1.
    fn off(truth: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let noise = |random: &mut ChaCha8Rng| 12.0_f64.sqrt() * (random.random::<f64>() - 0.5);
        let series: Vec<f64> = (0..N)
            .map(|k| truth(k as f64) + noise(&mut random))
            .collect();
        let kept = kept();
        let means = straight_means(&series, &kept);
        let pairs = kept.iter().zip(means);
        pairs.map(|(&k, mean)| mean - truth(k as f64)).collect()
    }

    fn mean_square(values: &[f64]) -> f64 {
        values.iter().map(|one| one.powi(2)).sum::<f64>() / values.len() as f64
    }

    #[test]
    fn noise_about_a_line_is_averaged_over_its_window() {
        let off = off(|k| 0.03 * k);
        let inner = &off[1..off.len() - 1];
        // 13 samples each, but of the one in twenty that looks bent.
        let variance = 13.0 * mean_square(inner);
        assert!((0.9..1.4).contains(&variance), "{variance}");
    }

    #[test]
    fn what_bends_is_not_averaged() {
        // Corners of 40 in 500 samples, half of a standard deviation a sample, and a wave of 25 in 120.
        let corners = |k: f64| 0.08 * (k % 1000.0 - 500.0).abs();
        let wave = |k: f64| 25.0 * (k / 120.0 * std::f64::consts::TAU).sin();
        for (what, truth) in [
            ("corners", &corners as &dyn Fn(f64) -> f64),
            ("wave", &wave),
        ] {
            let off = off(truth);
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            assert!(mean.abs() < 0.1, "{what} {mean}");
            // A raw sample has 1.
            assert!(mean_square(&off) < 1.1, "{what} {}", mean_square(&off));
            // Nothing is off as a mean over the whole window would be.
            let worst = off.iter().fold(0.0_f64, |worst, one| worst.max(one.abs()));
            assert!(worst < 2.5, "{what} {worst}");
        }
    }

    #[test]
    fn a_series_without_noise_is_kept_as_it_is() {
        let series: Vec<f64> = (0..N).map(|k| (k as f64 / 300.0).sin()).collect();
        let kept = kept();
        for (&k, mean) in kept.iter().zip(straight_means(&series, &kept)) {
            assert!((mean - series[k]).abs() < 1e-4, "{k} {mean}");
        }
    }
}
