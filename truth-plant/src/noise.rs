use crate::error::{TruthError, within};
use crate::random::Random;

/// Octaves of correlation times in the 1/f noise: 1 to 2^13 samples.
const OCTAVES: usize = 14;

/// Kind of noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoiseKind {
    /// Normal and independent.
    White,
    /// First-order autoregressive.
    Ar1 {
        /// Correlation of neighbors, -0.999 to 0.999.
        correlation: f64,
    },
    /// Spectrum near 1/f over four decades: the sum of one AR(1) process an octave, of equal variances.
    OneOverF,
    /// Student's t with 3 degrees of freedom.
    HeavyTails,
    /// White, with outliers.
    Outliers {
        /// Share of the samples that are outliers, 0 to 0.2.
        share: f64,
        /// Their standard deviation over that of the rest, 1 to 100.
        factor: f64,
    },
}

/// Noise added to a channel. Coarse steps are those of the [`Converter`](crate::Converter).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Kind of the noise.
    pub kind: NoiseKind,
    /// Standard deviation in the channel's unit, 0 to 100; of the white part for outliers.
    pub deviation: f64,
}

impl Noise {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("deviation", self.deviation, 0.0..=100.0)?;
        match self.kind {
            NoiseKind::Ar1 { correlation } => within("correlation", correlation, -0.999..=0.999),
            NoiseKind::Outliers { share, factor } => {
                within("share", share, 0.0..=0.2)?;
                within("factor", factor, 1.0..=100.0)
            }
            _ => Ok(()),
        }
    }

    /// Its values in so many samples.
    pub(crate) fn series(&self, n_samples: usize, mut random: Random) -> Vec<f64> {
        let mut source = Source::new(self.kind, &mut random);
        let value = |_| self.deviation * source.next(&mut random);
        (0..n_samples).map(value).collect()
    }
}

/// A process of unit variance.
struct Source {
    kind: NoiseKind,
    /// Correlations and values of the AR(1) processes of which it is made.
    processes: Vec<(f64, f64)>,
}

impl Source {
    fn new(kind: NoiseKind, random: &mut Random) -> Self {
        let correlations: Vec<f64> = match kind {
            NoiseKind::Ar1 { correlation } => vec![correlation],
            NoiseKind::OneOverF => (0..OCTAVES)
                .map(|octave| (-1.0 / (1_u32 << octave) as f64).exp())
                .collect(),
            _ => Vec::new(),
        };
        let processes = correlations
            .into_iter()
            .map(|correlation| (correlation, random.normal()))
            .collect();
        Self { kind, processes }
    }

    fn next(&mut self, random: &mut Random) -> f64 {
        match self.kind {
            NoiseKind::White => random.normal(),
            NoiseKind::Ar1 { .. } | NoiseKind::OneOverF => {
                let scale = 1.0 / (self.processes.len() as f64).sqrt();
                let mut sum = 0.0;
                for (correlation, value) in &mut self.processes {
                    sum += *value;
                    let fresh = (1.0 - *correlation * *correlation).sqrt();
                    *value = *correlation * *value + fresh * random.normal();
                }
                scale * sum
            }
            NoiseKind::HeavyTails => {
                let chi2: f64 = (0..3).map(|_| random.normal().powi(2)).sum();
                // t = z/√(χ²/3) has variance 3.
                random.normal() / chi2.max(f64::MIN_POSITIVE).sqrt()
            }
            NoiseKind::Outliers { share, factor } => {
                let is_outlier = random.uniform() < share;
                random.normal() * if is_outlier { factor } else { 1.0 }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn series(kind: NoiseKind, n: usize) -> Vec<f64> {
        let noise = Noise {
            kind,
            deviation: 1.0,
        };
        noise.series(n, Random::new(5, Stream::DisplacementNoise))
    }

    fn mean_product(x: &[f64], lag: usize) -> f64 {
        let pairs = x.iter().zip(&x[lag..]).map(|(a, b)| a * b);
        pairs.sum::<f64>() / (x.len() - lag) as f64
    }

    #[test]
    fn white_has_unit_variance_and_no_memory() {
        let x = series(NoiseKind::White, 40_000);
        assert!((mean_product(&x, 0) - 1.0).abs() < 0.03);
        assert!(mean_product(&x, 1).abs() < 0.02);
    }

    #[test]
    fn ar1_has_its_correlation() {
        let x = series(NoiseKind::Ar1 { correlation: 0.9 }, 40_000);
        assert!((mean_product(&x, 1) / mean_product(&x, 0) - 0.9).abs() < 0.02);
    }

    /// Of 1/f noise every octave has the same share: block means over ever longer blocks hardly fade.
    #[test]
    fn one_over_f_fades_slowly() {
        let x = series(NoiseKind::OneOverF, 65_536);
        let deviation = |block: usize| {
            let means: Vec<f64> = x
                .chunks(block)
                .map(|chunk| chunk.iter().sum::<f64>() / block as f64)
                .collect();
            let center = means.iter().sum::<f64>() / means.len() as f64;
            let differences: Vec<f64> = means.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(center.abs() < 3.0);
            mean_product(&differences, 0)
        };
        let (short, long) = (deviation(4), deviation(512));
        assert!((0.4..2.5).contains(&(short / long)), "{short} {long}");
    }

    #[test]
    fn tails_are_heavy_and_outliers_are_there() {
        let far = |x: &[f64]| x.iter().filter(|x| x.abs() > 4.0).count();
        assert!(far(&series(NoiseKind::White, 20_000)) < 5);
        assert!(far(&series(NoiseKind::HeavyTails, 20_000)) > 40);
        let outliers = NoiseKind::Outliers {
            share: 0.01,
            factor: 10.0,
        };
        assert!(far(&series(outliers, 20_000)) > 60);
    }
}
