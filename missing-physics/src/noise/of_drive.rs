//! Error that noise in the column of a drive makes after it was smoothed.

use identify::{ForwardModel, IdentifyError, predict};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Quantity, Recording, smoothed};

/// Noises that are drawn: one more exceeds all of them in one of twenty cases.
const DRAWN: usize = 19;

/// Mean square of the error of a model's output that noise of its drives may have left, in the square of the output's unit: the most of
/// several noises like the one that was taken out. Each is added to the drive and smoothed as that was, and the model is simulated with
/// both. 0 where no drive was smoothed.
///
/// A level and a ramp keep a part of the noise that they were found in. The rod never saw it, and the error comes with the drive, so
/// that effects fit it. A refit of the parameters would take a part of it, too: this is an upper bound.
pub(crate) fn of_drive<'m>(
    model: &dyn ForwardModel,
    recordings: impl Iterator<Item = (&'m Recording, &'m [f64])>,
    seed: u64,
) -> Result<f64, IdentifyError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut squares = [0.0; DRAWN];
    let mut n_samples = 0;
    for (recording, point) in recordings {
        n_samples += recording.len();
        let sigma = recording.smoothed_noise();
        if sigma <= 0.0 {
            continue;
        }
        let smooth = predict(model, point, recording)?.output;
        for squares in &mut squares {
            let noisy = recording.drive().iter().map(|drive| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                let noisy = drive + sigma * normal;
                match recording.drive_quantity() {
                    Quantity::Duty => noisy.clamp(0.0, 1.0),
                    _ => noisy,
                }
            });
            let again = smoothed(recording.driven_by(noisy.collect())?);
            let other = predict(model, point, &again)?.output;
            let pairs = smooth.iter().zip(other);
            *squares += pairs.map(|(one, other)| (one - other).powi(2)).sum::<f64>();
        }
    }
    let most = squares.into_iter().fold(0.0, f64::max);
    Ok(most / n_samples.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::synthetic::Synthetic;
    use crate::{EffectSet, EffectValues};

    #[test]
    fn noise_that_was_smoothed_leaves_an_error_and_a_clean_drive_none() {
        let Synthetic {
            base,
            fit,
            mut training,
            ..
        } = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let left = |training: &[Recording]| {
            let points = fit.points();
            let pairs = training.iter().zip(points.iter().map(Vec::as_slice));
            of_drive(&base, pairs, 1).unwrap()
        };
        assert_eq!(left(&training).to_bits(), 0.0_f64.to_bits());
        let errors_mm: Vec<f64> = [0.01, 0.02]
            .into_iter()
            .map(|sigma| {
                let mut rng = ChaCha8Rng::seed_from_u64(3);
                let noisy = training[1].drive().iter().map(|drive| {
                    let normal: f64 = StandardNormal.sample(&mut rng);
                    drive + sigma * normal
                });
                training[1] = smoothed(training[1].driven_by(noisy.collect()).unwrap());
                let told = training[1].smoothed_noise();
                assert!((told / sigma - 1.0).abs() < 0.1, "{told}");
                left(&training).sqrt()
            })
            .collect();
        // Twice the noise leaves about twice the error, and a part of the stroke of 5 mm alone.
        let [half, whole] = errors_mm[..] else {
            unreachable!()
        };
        assert!(half > 0.001 && whole < 0.5, "{errors_mm:?}");
        assert!((1.3..3.0).contains(&(whole / half)), "{errors_mm:?}");
    }
}
