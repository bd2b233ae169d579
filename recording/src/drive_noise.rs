//! Noise in the column of a drive.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use crate::Recording;
use crate::holds::HOLD_TOLERANCE;
use crate::order::rising;
use crate::ordered::{Ordered, usual_size};
use crate::quantity::Quantity;
use crate::sampling::Sampling;
use crate::stretches::{Stretch, stretches};
use crate::warning::quantity;

/// Share of the drive's range below which noise is harmless: it stays within what counts as held, four deviations either way.
const LEAST: f64 = HOLD_TOLERANCE / 8.0;

/// Share of the range above which what is left may be the drive itself: a random one is its own noise.
const MOST: f64 = 0.1;

/// Fewest samples of which anything is said.
const FEWEST: usize = 100;

/// Most samples that are looked at.
const LONGEST: usize = 1_000_000;

/// Correlation of the bends of independent numbers with the next and the one after: `(x_(k-1) - 2 x_k + x_(k+1))/2` has -4/6 and
/// 1/6. A smooth curve has 1, a chatter from sample to sample -1.
const OF_INDEPENDENT: [f64; 2] = [-2.0 / 3.0, 1.0 / 6.0];

/// How far from these the correlations of noise may be, beside their scatter.
const NEAR_INDEPENDENT: f64 = 0.12;

/// Their scatter, times the root of the number of bends: as far as nine of ten are.
const SCATTER: f64 = 1.5;

/// Fewest samples at rest from which the noise is known to be there without a drive, too.
const FEWEST_AT_REST: usize = 10;

/// Noise at rest over that elsewhere, at least, where it is of the sensor: that of a supply goes with what it gives.
const AS_AT_REST: f64 = 0.5;

/// Share of the range up to which the drive rests.
const NEAR_REST: f64 = 0.05;

/// Noise in the column of a drive: independent from sample to sample, about a level that is held or moves slowly.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveNoise {
    /// Standard deviation, in the unit of the drive.
    pub standard_deviation: f64,
    /// That over the drive's range.
    pub share_of_range: f64,
    /// Unit of the drive.
    pub unit: String,
    /// True if the noise is as large at rest, where nothing drives the rod: it is then sensor noise, which the rod did not
    /// see.
    pub is_of_the_sensor: bool,
}

impl fmt::Display for DriveNoise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the drive is noisy by ")?;
        quantity(f, self.standard_deviation, &self.unit)?;
        write!(
            f,
            " (standard deviation, {:.1} % of its range)",
            100.0 * self.share_of_range
        )
    }
}

impl DriveNoise {
    /// Description of the values that replace the noisy drive.
    pub(crate) fn replacement(&self) -> &'static str {
        "held levels are replaced by their means, ramps by lines"
    }
}

/// The noise in the column of a drive, if there is one that hides where the drive is held.
///
/// It is told from a drive by three things. What neighboring samples differ by is as independent numbers have it, which neither a
/// curve nor a chatter has. It is small against the range, which a random drive is not. And the noise of a *sensor* is there at rest,
/// too, which neither that of a supply nor a controller's is.
#[must_use]
pub fn drive_noise(recording: &Recording) -> Option<DriveNoise> {
    Some(smooth(recording)?.0)
}

/// The noise and, if it is the sensor's, the drive without it.
pub(crate) fn smooth(recording: &Recording) -> Option<(DriveNoise, Option<Vec<f64>>)> {
    let drive = recording.drive();
    let is_driven = recording.drive_quantity() != Quantity::Temperature
        && recording.sampling() != Sampling::Untimed;
    if !is_driven || !(FEWEST..=LONGEST).contains(&drive.len()) {
        return None;
    }
    let range = Ordered::new(drive).range();
    let bends: Vec<f64> = drive
        .windows(3)
        .map(|three| three[1] - 0.5 * (three[0] + three[2]))
        .collect();
    let bend = usual_size(bends.iter().copied());
    // Each has one sample and half of two others.
    let sigma = bend / 1.5_f64.sqrt();
    if !(sigma > LEAST * range && sigma < MOST * range && is_independent(&bends)) {
        return None;
    }
    let found = stretches(drive, sigma);
    let at_rest = at_rest(drive, &found, range);
    let is_of_the_sensor = at_rest.is_some_and(|at_rest| at_rest > AS_AT_REST * sigma);
    let noise = DriveNoise {
        standard_deviation: sigma,
        share_of_range: sigma / range,
        unit: recording.drive_unit().to_owned(),
        is_of_the_sensor,
    };
    let lowest = drive.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = drive.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smooth = is_of_the_sensor.then(|| {
        let levels = Levels::of(&found, sigma);
        let at = found.iter().flat_map(|stretch| {
            let level = levels.of_stretch(stretch);
            let samples = stretch.samples.clone();
            samples.map(move |k| level.unwrap_or_else(|| stretch.at(k)))
        });
        at.map(|value| value.clamp(lowest, highest)).collect()
    });
    Some((noise, smooth))
}

/// True if neighboring bends correlate as those of independent numbers do. The correlation is that of a normal distribution whose neighbors have
/// equal signs as often: bends at steps, which may be as large as noise makes them, count no more than others.
///
/// ```text
/// ρ = sin(π/2 · mean of sign(b_k b_(k+lag)))
/// ```
fn is_independent(bends: &[f64]) -> bool {
    let correlation = |lag: usize| {
        let pairs = bends.iter().zip(&bends[lag..]);
        let products = pairs.map(|(a, b)| a * b).filter(|product| *product != 0.0);
        let (n, signs) = products.fold((0.0, 0.0), |(n, signs), product| {
            (n + 1.0, signs + product.signum())
        });
        (FRAC_PI_2 * signs / n).sin()
    };
    let near = NEAR_INDEPENDENT + SCATTER / (bends.len() as f64).sqrt();
    let mut lags = OF_INDEPENDENT.iter().enumerate();
    lags.all(|(k, expected)| (correlation(k + 1) - expected).abs() < near)
}

/// Standard deviation within the stretches where the drive rests; `None` if they are short.
fn at_rest(drive: &[f64], stretches: &[Stretch], range: f64) -> Option<f64> {
    let held = || stretches.iter().filter(|stretch| stretch.is_level());
    let size = |stretch: &Stretch| stretch.middle().abs();
    let lowest = held().map(size).fold(f64::INFINITY, f64::min);
    let resting = held().filter(|stretch| size(stretch) <= lowest + NEAR_REST * range);
    // The mean of a stretch is of its own samples.
    let (mut n, mut squares) = (0, 0.0);
    for stretch in resting.filter(|stretch| stretch.samples.len() > 1) {
        n += stretch.samples.len() - 1;
        let samples = stretch.samples.clone();
        squares += samples
            .map(|k| (drive[k] - stretch.middle()).powi(2))
            .sum::<f64>();
    }
    (n >= FEWEST_AT_REST).then(|| (squares / n as f64).sqrt())
}

/// Levels to which a drive comes back: what is held at one of them is held at the same.
struct Levels(Vec<Level>);

struct Level {
    lowest: f64,
    highest: f64,
    mean: f64,
    n_samples: f64,
}

impl Levels {
    /// Means that three standard errors do not tell apart are one, and one that they do not tell from 0 is no drive.
    fn of(stretches: &[Stretch], sigma: f64) -> Self {
        let held = stretches.iter().filter(|stretch| stretch.is_level());
        let mut means: Vec<(f64, f64)> = held
            .map(|stretch| (stretch.middle(), stretch.samples.len() as f64))
            .collect();
        rising(&mut means, |one| one.0);
        let mut levels: Vec<Level> = Vec::new();
        for (mean, n_samples) in means {
            match levels.last_mut() {
                Some(level)
                    if mean - level.mean
                        < 3.0 * sigma * (1.0 / n_samples + 1.0 / level.n_samples).sqrt() =>
                {
                    let all = level.n_samples + n_samples;
                    level.mean += (mean - level.mean) * n_samples / all;
                    level.n_samples = all;
                    level.highest = mean;
                }
                _ => levels.push(Level {
                    lowest: mean,
                    highest: mean,
                    mean,
                    n_samples,
                }),
            }
        }
        for level in &mut levels {
            if level.mean.abs() < 3.0 * sigma / level.n_samples.sqrt() {
                level.mean = 0.0;
            }
        }
        Self(levels)
    }

    fn of_stretch(&self, stretch: &Stretch) -> Option<f64> {
        let mean = stretch.middle();
        let holds = |level: &&Level| (level.lowest..=level.highest).contains(&mean);
        let level = self.0.iter().find(holds).filter(|_| stretch.is_level());
        level.map(|level| level.mean)
    }
}
