//! Recordings with fewer samples that tell about as much: few on which models are searched, and enough on which they are judged.

use std::borrow::Cow;
use std::iter;
use std::ops::Range;

use identify::{Fit, ForwardModel, IdentifyError, predict};
use recording::{Quantity, Recording, RecordingParts};

use crate::model::straight::straight_means;
use crate::model::turning::{TurningPoint, turning_points};

/// How many samples of all recordings together are enough, about, and their longest distance as a share of the time constant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Enough {
    pub(crate) samples: usize,
    longest: f64,
}

/// To search models by.
pub(crate) const SEARCHED: Enough = Enough {
    samples: 400,
    longest: 0.5,
};

/// To compare runs by.
pub(crate) const COMPARED: Enough = Enough {
    samples: 1_000,
    longest: 0.25,
};

/// To tell changes apart that answer runs almost alike: delays and lags differ within a step of what they are found by.
pub(crate) const TOLD_APART: Enough = Enough {
    samples: 10_000,
    longest: 0.05,
};

/// To end a fit on from which that to very many samples is begun: a hundredth of a time constant hides hardly anything, so that the way from one
/// end to the other is one step.
pub(crate) const NEARLY_ALL: Enough = Enough {
    samples: 20_000,
    longest: 0.01,
};

/// Samples over those of thinned recordings from which a fit goes by way of these: it costs a few simulations of them.
const MANY: usize = 4;

/// To judge models by, if there are at least twice as many: the search then takes no longer for more of them. Of a run of a quarter of an hour that
/// is one each 0.36 s, and each is the mean of those around it.
const JUDGED: Enough = Enough {
    samples: 2_500,
    longest: 0.25,
};

/// Fewest samples of a recording.
const FEWEST: usize = 50;

/// Swings of the temperature that count, K, the smallest first. The paper's loop starts anew wherever the temperature turns, however little,
/// so that the smallest count where they are few. Those smaller than the largest are left out where they are many: a drive that is noisy.
const SWINGS_K: [f64; 3] = [0.001, 0.016, 0.25];

/// Most turns of the temperature by smaller swings than the largest that counts, as a share of the samples that are kept.
const TURNS: f64 = 0.25;

/// Change of the drive over the changes before and after it from which it is a step, and no ramp.
const STEP: f64 = 3.0;

/// Most steps of the drive that are kept, as a share of the samples that are: a drive that steps more often chatters, or is noisy.
const STEPS: f64 = 0.25;

/// Each recording with every n-th sample, those where the drive steps and those where the temperature turns back: driven by the power
/// between that takes the rod to the same temperature, and with what a fitted baseline model leaves around each, the mean of as many
/// samples as it is straight over.
///
/// Between turns the loop knows temperatures and no time: on the same temperatures the baseline model shows the same, however long a step
/// is. Where the drive is constant from one sample to the next, a rod with another time constant shows the same, too. What bends is not averaged:
/// else another model, though it were the true one, would be off by what of its difference bends there.
///
/// # Errors
///
/// Any error of simulating the model.
pub(crate) fn coarse(
    model: &dyn ForwardModel,
    fit: &Fit,
    training: &[Recording],
) -> Result<Vec<Recording>, IdentifyError> {
    coarse_at(SEARCHED, model, (&fit.points(), fit.tau_s()), training)
}

/// Coarse recordings with so many samples by any model: `points` has one point for each recording, `tau_s` is the time constant of the rod, s.
///
/// # Errors
///
/// Any error of simulating the model.
pub(crate) fn coarse_at(
    enough: Enough,
    model: &dyn ForwardModel,
    (points, tau_s): (&[Vec<f64>], f64),
    recordings: &[Recording],
) -> Result<Vec<Recording>, IdentifyError> {
    let stride = enough.stride(tau_s, recordings);
    thinned(model, points, tau_s, recordings, stride)
}

/// Samples of the training on which models are judged, and those of the recordings that were not used: as they were recorded, or thinned
/// as coarse ones, but less, where the training has more than that takes. Means of as many samples have as much noise in both.
///
/// # Errors
///
/// Any error of simulating the model.
pub(crate) fn judged<'r>(
    model: &dyn ForwardModel,
    fit: &Fit,
    [training, unseen]: [&'r [Recording]; 2],
) -> Result<[Cow<'r, [Recording]>; 2], IdentifyError> {
    let tau_s = fit.tau_s();
    let stride = JUDGED.stride(tau_s, training);
    if stride < 2 {
        return Ok([training, unseen].map(Cow::Borrowed));
    }
    let unlike = vec![fit.point(0); unseen.len()];
    let of_unseen = stride.min(JUDGED.longest(tau_s, unseen));
    Ok([
        Cow::Owned(thinned(model, &fit.points(), tau_s, training, stride)?),
        Cow::Owned(thinned(model, &unlike, tau_s, unseen, of_unseen)?),
    ])
}

/// Samples of all recordings together.
fn samples(recordings: &[Recording]) -> usize {
    recordings.iter().map(Recording::len).sum()
}

fn thinned(
    model: &dyn ForwardModel,
    points: &[Vec<f64>],
    tau_s: f64,
    recordings: &[Recording],
    stride: usize,
) -> Result<Vec<Recording>, IdentifyError> {
    let recordings = recordings.iter().enumerate();
    recordings
        .map(|(r, recording)| {
            let every = stride.min(recording.len() / FEWEST);
            if every < 2 {
                return Ok(recording.clone());
            }
            of_every(every, model, (&points[r], tau_s), recording)
        })
        .collect()
}

impl Enough {
    /// True if thinned recordings have few samples beside all.
    pub(crate) fn are_few(self, thinned: &[Recording], all: &[Recording]) -> bool {
        MANY * samples(thinned) <= samples(all)
    }

    /// Samples from one that is kept to the next.
    fn stride(self, tau_s: f64, recordings: &[Recording]) -> usize {
        (samples(recordings) / self.samples).min(self.longest(tau_s, recordings))
    }

    /// Most samples from one that is kept to the next.
    fn longest(self, tau_s: f64, recordings: &[Recording]) -> usize {
        let of_each = recordings.iter().map(|recording| {
            let time_s = recording.time_s();
            let dt_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
            (self.longest * tau_s / dt_s) as usize
        });
        of_each.fold(usize::MAX, usize::min)
    }
}

fn of_every(
    every: usize,
    model: &dyn ForwardModel,
    (point, tau_s): (&[f64], f64),
    recording: &Recording,
) -> Result<Recording, IdentifyError> {
    let n = recording.len();
    let fine = predict(model, point, recording)?;
    let mut kept = turns(&fine.temperature_degc, n / every);
    kept.extend((0..n).step_by(every));
    kept.extend(steps(recording.drive(), n / every));
    kept.push(n - 1);
    kept.sort_unstable();
    kept.dedup();
    // From one kept sample to the next.
    let between: Vec<Range<usize>> = (0..kept.len())
        .map(|j| kept[j]..kept.get(j + 1).copied().unwrap_or(n))
        .collect();
    let time_s = recording.time_s();
    let lasts_s = |k: usize| time_s.get(k + 1).map_or(1.0, |next_s| next_s - time_s[k]);
    let quantity = recording.drive_quantity();
    let drive = between.iter().map(|range| {
        let end_s = time_s[range.end.min(n - 1)];
        // What comes late is less cooled away by the end.
        let counts = |k: usize| {
            let since_s = |k: usize| end_s - time_s.get(k).copied().unwrap_or(end_s);
            let left = |since_s: f64| (-since_s / tau_s).exp();
            left(since_s(k + 1)) - left(since_s(k))
        };
        match quantity {
            _ if range.len() == 1 => recording.drive()[range.start],
            // Heat goes with their squares.
            Quantity::Current | Quantity::Voltage => {
                mean(range, counts, |k| recording.drive()[k].powi(2)).sqrt()
            }
            _ => mean(range, counts, |k| recording.drive()[k]),
        }
    });
    let between_mean = |series: &[f64]| -> Vec<f64> {
        let means = between
            .iter()
            .map(|range| mean(range, lasts_s, |k| series[k]));
        means.collect()
    };
    let mut parts = RecordingParts {
        name: recording.name().to_owned(),
        time_s: Some(kept.iter().map(|&k| time_s[k]).collect()),
        drive_quantity: quantity,
        drive: drive.collect(),
        output_unit: recording.output_unit().to_owned(),
        output: vec![0.0; kept.len()],
        ambient_degc: recording.ambient_degc().map(between_mean),
        stress_pa: recording.stress_pa().map(between_mean),
        temperature_degc: recording.temperature_degc().map(|_| vec![0.0; kept.len()]),
        ..RecordingParts::default()
    };
    let shown = predict(model, point, &Recording::new(parts.clone())?)?;
    let carried = |recorded: &[f64], fine: &[f64], shown: &[f64]| -> Vec<f64> {
        let left: Vec<f64> = recorded.iter().zip(fine).map(|(y, m)| y - m).collect();
        let means = straight_means(&left, &kept).into_iter();
        means.zip(shown).map(|(left, shown)| shown + left).collect()
    };
    parts.output = carried(recording.output(), &fine.output, &shown.output);
    if let Some(recorded) = recording.temperature_degc() {
        let carried = carried(recorded, &fine.temperature_degc, &shown.temperature_degc);
        parts.temperature_degc = Some(carried);
    }
    Ok(Recording::new(parts)?)
}

/// Samples at which a temperature turns back: a loop remembers them. It begins low.
fn turns(temperature_degc: &[f64], n_kept: usize) -> Vec<usize> {
    let by = |swing_k: f64| {
        let points = turning_points(temperature_degc, swing_k);
        let begins_low = |first: &TurningPoint| !first.is_top;
        let since = usize::from(points.first().is_some_and(begins_low));
        points[since..]
            .iter()
            .map(|point| point.at)
            .collect::<Vec<_>>()
    };
    let [smaller @ .., largest] = SWINGS_K.map(by);
    let most = largest.len() + (TURNS * n_kept as f64) as usize;
    let is_affordable = |turns: &Vec<usize>| turns.len() <= most;
    smaller.into_iter().find(is_affordable).unwrap_or(largest)
}

/// Where a drive steps, if it does so seldom among so many samples that are kept.
fn steps(drive: &[f64], n_kept: usize) -> Vec<usize> {
    // That of each sample from the one before; at both ends there is none.
    let inner = drive.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let changes: Vec<f64> = iter::once(0.0).chain(inner).chain([0.0]).collect();
    let is_step = |&k: &usize| changes[k] > STEP * changes[k - 1].max(changes[k + 1]);
    let most = (STEPS * n_kept as f64) as usize;
    let steps: Vec<usize> = (1..drive.len()).filter(is_step).take(most + 1).collect();
    if steps.len() > most {
        Vec::new()
    } else {
        steps
    }
}

/// Mean over some samples, each counted as `weight` says.
fn mean(range: &Range<usize>, weight: impl Fn(usize) -> f64, value: impl Fn(usize) -> f64) -> f64 {
    let total: f64 = range.clone().map(&weight).sum();
    range.clone().map(|k| weight(k) * value(k)).sum::<f64>() / total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::case::Case;
    use crate::model::synthetic::Synthetic;
    use crate::{EffectSet, EffectValues, Setting};

    #[test]
    fn a_rod_with_another_time_constant_shows_the_same_at_few_samples_of_a_drive_that_steps() {
        let synthetic = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let fine = synthetic.case();
        let recording = &fine.training[0];
        // In the middle between two that are kept.
        let drive: Vec<f64> = (0..recording.len())
            .map(|k| if (k + 3) / 60 % 2 == 0 { 1.0 } else { 0.2 } * recording.largest_drive())
            .collect();
        let stepped = recording.driven_by(drive).unwrap();
        let at = |rate: f64| {
            let mut point = fine.fit.point(0);
            let k = fine
                .fit
                .parameters
                .iter()
                .position(|one| one.info.name == "tau_s");
            point[k.unwrap()] *= rate;
            point
        };
        let few = of_every(6, fine.base, (&at(1.0), fine.fit.tau_s()), &stepped).unwrap();
        assert!(few.len() < stepped.len() / 4);
        let [on_all, on_few] =
            [&stepped, &few].map(|one| predict(fine.base, &at(1.3), one).unwrap());
        for (j, time_s) in few.time_s().iter().enumerate() {
            let k = stepped.time_s().partition_point(|one| one < time_s);
            let off_k = on_few.temperature_degc[j] - on_all.temperature_degc[k];
            assert!(off_k.abs() < 1e-9, "{j} {off_k}");
        }
    }

    #[test]
    fn a_loop_that_starts_anew_at_every_turn_shows_the_same_at_few_samples() {
        let synthetic = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let fine = synthetic.case();
        let recording = &fine.training[0];
        let (point, tau_s) = (fine.fit.point(0), fine.fit.tau_s());
        // Now and then the drive falls for a moment, in inner loops, too: the temperature turns by less than a quarter of a kelvin, twice.
        let n = recording.len();
        let dips = |(k, drive): (usize, &f64)| if k % 53 == 0 { 0.8 * drive } else { *drive };
        let drive = recording.drive().iter().enumerate().map(dips).collect();
        let dipping = recording.driven_by(drive).unwrap();
        let on_all = predict(fine.base, &point, &dipping).unwrap();
        let [few, many] =
            [0.25, 0.001].map(|swing_k| turning_points(&on_all.temperature_degc, swing_k).len());
        assert!(many > few + 5, "{few} {many}");
        let few = of_every(20, fine.base, (&point, tau_s), &dipping).unwrap();
        assert!(few.len() < n / 4);
        let on_few = predict(fine.base, &point, &few).unwrap();
        for (j, time_s) in few.time_s().iter().enumerate() {
            let k = dipping.time_s().partition_point(|one| one < time_s);
            let off_mm = on_few.output[j] - on_all.output[k];
            assert!(off_mm.abs() < 1e-3, "{j} {off_mm}");
        }
    }

    #[test]
    fn what_the_plain_model_leaves_is_the_mean_of_what_it_left() {
        let synthetic = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let fine = synthetic.case();
        let before = fine.baseline().unwrap();
        let recording = &fine.training[0];
        let point = fine.fit.point(0);
        let tau_s = fine.fit.tau_s();
        let few = of_every(5, fine.base, (&point, tau_s), recording).unwrap();
        // The rod is taken to the same temperatures.
        let [on_all, on_few] =
            [recording, &few].map(|one| predict(fine.base, &point, one).unwrap());
        for (j, time_s) in few.time_s().iter().enumerate() {
            let k = recording.time_s().partition_point(|one| one < time_s);
            let off_k = on_few.temperature_degc[j] - on_all.temperature_degc[k];
            assert!(off_k.abs() < 1e-9, "{j} {off_k}");
        }
        let few = [few];
        let coarse = Case::new(fine.base, fine.fit, &few, Setting::default());
        let after = coarse.baseline().unwrap();
        assert_eq!(after.residual.len(), few[0].len());
        assert!(few[0].len() < recording.len() / 4);
        // Between two that are five apart it is the mean of five, but for the one in twenty that looks bent.
        let time_s = few[0].time_s();
        let dt_s = recording.time_s()[5] - recording.time_s()[0];
        let is_amid = |j: &usize| {
            let [before_s, after_s] = [time_s[*j] - time_s[j - 1], time_s[j + 1] - time_s[*j]];
            (before_s - dt_s).abs().max((after_s - dt_s).abs()) < 1e-9
        };
        let amid: Vec<usize> = (1..few[0].len() - 1).filter(is_amid).collect();
        let is_mean = |j: &&usize| {
            let at = |seconds: &f64| (seconds - time_s[**j]).abs() < 1e-9;
            let k = recording.time_s().iter().position(at).unwrap();
            let mean = before.residual[k - 2..k + 3].iter().sum::<f64>() / 5.0;
            (after.residual[**j] - mean).abs() < 1e-12
        };
        assert!(amid.len() > few[0].len() / 2);
        assert!(amid.iter().filter(is_mean).count() > amid.len() * 4 / 5);
        let [first, last] = [few[0].time_s()[0], few[0].time_s()[few[0].len() - 1]];
        assert_eq!(first.to_bits(), recording.time_s()[0].to_bits());
        let end_s = recording.time_s()[recording.len() - 1];
        assert_eq!(last.to_bits(), end_s.to_bits());
    }
}
