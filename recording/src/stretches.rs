//! A noisy series as stretches of levels and lines.

use std::ops::Range;

/// Longest stretch, in samples: the mean of more is no better for what it is needed, and the search would take its square.
const LONGEST: usize = 400;

/// A stretch in which a series is a level or a line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) samples: Range<usize>,
    mean: f64,
    /// Change a sample; 0 of a level.
    slope: f64,
}

impl Stretch {
    /// True if the series is held.
    pub(crate) fn is_level(&self) -> bool {
        self.slope.abs() <= 0.0
    }

    /// The value in the middle of the stretch.
    pub(crate) fn middle(&self) -> f64 {
        self.mean
    }

    /// The value at a sample.
    pub(crate) fn at(&self, k: usize) -> f64 {
        let center = 0.5 * (self.samples.start + self.samples.end - 1) as f64;
        self.mean + self.slope * (k as f64 - center)
    }
}

/// The stretches of a series with independent noise of standard deviation `sigma`, > 0.
///
/// ```text
/// least of Σ over stretches [ Σ (x_k - level or line)²/σ² + ln n (1 for a level, 2 for a line, and 1 for where it begins) ]
/// ```
///
/// the BIC [Schwarz1978], found exactly by dynamic programming. A step of some σ stays where it is, to the sample, and so does a single sample that is far away.
pub(crate) fn stretches(values: &[f64], sigma: f64) -> Vec<Stretch> {
    let price = (values.len() as f64).ln();
    // Of the first `end` samples: the lowest cost, and the stretch with which it ends.
    let mut lowest = vec![0.0; values.len() + 1];
    let mut last: Vec<Stretch> = Vec::with_capacity(values.len());
    for end in 1..=values.len() {
        let mut best = (f64::INFINITY, 0, 0.0, 0.0);
        let mut sums = Sums::about(values[end - 1]);
        for start in (end.saturating_sub(LONGEST)..end).rev() {
            sums.add(values[start]);
            let (of_level, of_line) = sums.left();
            let level = lowest[start] + of_level / (sigma * sigma) + 2.0 * price;
            let line = lowest[start] + of_line / (sigma * sigma) + 3.0 * price;
            if level.min(line) < best.0 {
                let slope = if line < level { sums.slope() } else { 0.0 };
                best = (level.min(line), start, sums.mean(), slope);
            }
        }
        let (cost, start, mean, slope) = best;
        lowest[end] = cost;
        last.push(Stretch {
            samples: start..end,
            mean,
            slope,
        });
    }
    let mut found = Vec::new();
    let mut end = values.len();
    while end > 0 {
        let stretch = last[end - 1].clone();
        end = stretch.samples.start;
        found.push(stretch);
    }
    found.reverse();
    found
}

/// Sums over samples, added from the last to the first, of what they are from one near them.
struct Sums {
    about: f64,
    n: f64,
    y: f64,
    yy: f64,
    /// With the number of the sample, counted from the last.
    xy: f64,
}

impl Sums {
    fn about(about: f64) -> Self {
        Self {
            about,
            n: 0.0,
            y: 0.0,
            yy: 0.0,
            xy: 0.0,
        }
    }

    fn add(&mut self, value: f64) {
        let y = value - self.about;
        self.y += y;
        self.yy += y * y;
        self.xy += self.n * y;
        self.n += 1.0;
    }

    fn mean(&self) -> f64 {
        self.about + self.y / self.n
    }

    /// Σ (x - mean of x)² of 0 … n - 1.
    fn spread_of_x(&self) -> f64 {
        self.n * (self.n * self.n - 1.0) / 12.0
    }

    fn product(&self) -> f64 {
        self.xy - 0.5 * (self.n - 1.0) * self.y
    }

    /// Change a sample, forward in time.
    fn slope(&self) -> f64 {
        -self.product() / self.spread_of_x()
    }

    /// Squares that a level leaves, and a line.
    fn left(&self) -> (f64, f64) {
        let of_level = (self.yy - self.y * self.y / self.n).max(0.0);
        if self.n < 3.0 {
            return (of_level, f64::INFINITY);
        }
        let taken = self.product().powi(2) / self.spread_of_x();
        (of_level, (of_level - taken).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of a small generator, about as normal ones.
    fn noise(n: usize) -> Vec<f64> {
        let mut state = 5_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..n)
            .map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0)
            .collect()
    }

    #[test]
    fn noise_alone_is_one_level_and_steps_stay_where_they_are() {
        let mut values = noise(390);
        let whole = stretches(&values, 1.0);
        assert_eq!((whole.len(), whole[0].is_level()), (1, true));
        values[130..].iter_mut().for_each(|value| *value += 8.0);
        values[300] += 20.0;
        let found = stretches(&values, 1.0);
        let samples: Vec<Range<usize>> = found.iter().map(|one| one.samples.clone()).collect();
        assert_eq!(samples, [0..130, 130..300, 300..301, 301..390]);
        assert!(found.iter().all(Stretch::is_level));
        assert!((found[1].middle() - 8.0).abs() < 0.3);
    }

    #[test]
    fn a_ramp_is_a_line_and_a_sine_keeps_its_shape() {
        let noise = noise(360);
        let ramp: Vec<f64> = noise
            .iter()
            .enumerate()
            .map(|(k, e)| 0.2 * k as f64 + e)
            .collect();
        let found = stretches(&ramp, 1.0);
        assert_eq!(found.len(), 1);
        assert!((found[0].at(0)).abs() < 0.5 && (found[0].at(359) - 71.8).abs() < 0.5);
        let truth = |k: usize| 20.0 * (0.05 * k as f64).sin();
        let sine: Vec<f64> = noise
            .iter()
            .enumerate()
            .map(|(k, e)| truth(k) + e)
            .collect();
        let squares: f64 = stretches(&sine, 1.0)
            .iter()
            .flat_map(|one| one.samples.clone().map(|k| (one.at(k) - truth(k)).powi(2)))
            .sum();
        // Less than the noise that was there, 1.
        let left = (squares / 360.0).sqrt();
        assert!(left < 0.7, "{left}");
    }
}
