//! How slow what is left is: noise of a sensor differs from sample to sample.

/// Samples after which a residual is compared with itself: outliers and white noise have nothing in common with what follows.
const LAG: usize = 2;

/// Median of |x| over the standard deviation of a normal x.
pub(crate) const MEDIAN: f64 = 0.674_489_750_196_081_7;

/// Deviation of what residuals have in common with themselves two samples later over that of noise between neighbors: 0 of white
/// noise and of outliers, ρ/√(1 - ρ) of noise of first order with correlation ρ. Noise between neighbors is no smaller than that of rounding, of
/// which this is the standard deviation: where it is 0 and most samples are equal, nothing is slow.
///
/// ```text
/// s² = Σ (r_k - r̄)(r_(k+2) - r̄)/n,   s_d = median |r_(k+1) - r_k|/(0.6745 √2)
/// ```
pub(crate) fn slowness<'a>(residuals: impl Iterator<Item = &'a [f64]>, rounding: f64) -> f64 {
    let (mut products, mut n) = (0.0, 0);
    let mut steps: Vec<f64> = Vec::new();
    for residual in residuals {
        let mean = residual.iter().sum::<f64>() / residual.len() as f64;
        let later = residual.iter().skip(LAG);
        let pairs = residual.iter().zip(later);
        products += pairs.map(|(r, s)| (r - mean) * (s - mean)).sum::<f64>();
        n += residual.len().saturating_sub(LAG);
        steps.extend(residual.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
    }
    steps.sort_by(f64::total_cmp);
    let median = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let between = (median / (MEDIAN * 2.0_f64.sqrt())).max(rounding);
    if between > 0.0 {
        (products / n as f64).max(0.0).sqrt() / between
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn noise_of_first_order_is_as_slow_as_its_memory_is_long() {
        for correlation in [0.0_f64, 0.8, 0.96] {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let mut at = 0.0;
            let noise: Vec<f64> = (0..200_000)
                .map(|_| {
                    let fresh: f64 = StandardNormal.sample(&mut rng);
                    at = correlation * at + fresh;
                    3.0 + at
                })
                .collect();
            let expected = correlation / (1.0 - correlation).sqrt();
            let found = slowness(noise.chunks(50_000), 0.0);
            assert!((found - expected).abs() < 0.1, "{found} {expected}");
        }
    }

    #[test]
    fn steps_of_a_converter_hide_nothing_slow() {
        // At rest most of the time, and off by ten steps at the beginning.
        let step = 0.1;
        let off = |k: usize| if k < 50 { 10.0 * step } else { 0.0 };
        let residual: Vec<f64> = (0..2_000).map(off).collect();
        let rounding = step / 12.0_f64.sqrt();
        let of = |rounding: f64| slowness(std::iter::once(residual.as_slice()), rounding);
        // √(50/2000) 10 steps over the noise of one.
        let expected = 10.0 * (50.0_f64 / 2_000.0).sqrt() * 12.0_f64.sqrt();
        assert!(
            (of(rounding) / expected - 1.0).abs() < 0.05,
            "{}",
            of(rounding)
        );
        assert!(of(0.0).abs() <= 0.0);
    }

    #[test]
    fn outliers_are_not_slow() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let noise: Vec<f64> = (0..50_000)
            .map(|k| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                if k % 37 == 0 { 50.0 * normal } else { normal }
            })
            .collect();
        let found = slowness(noise.chunks(10_000), 0.0);
        assert!(found < 1.0, "{found}");
    }
}
