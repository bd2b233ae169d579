//! Detection of one spoiled drive sample beside a step of the drive, where its neighbors do not tell what belongs there.

use std::ops::Range;

use recording::Recording;

use crate::{
    Fit, ForwardModel, IdentifyError, ParameterVector, RefineConfig, Refined, predict, refine,
};

/// Change from sample to sample, over the range of the drive, that is a step.
const A_STEP: f64 = 0.1;

/// Steps in a recording, over its samples, up to which these are steps of a drive, and no chatter.
const MOST_STEPS: f64 = 0.1;

/// Time constants after a step in which the rod answers it.
const ANSWER: f64 = 3.0;

/// Samples after a step that are looked at, at least: how a fast rod answers is seen in some.
const LEAST_SAMPLES: usize = 5;

/// Squares of the error behind any other step, over those behind this one, at most: what a model leaves out happens again.
const AT_OTHERS: f64 = 0.25;

/// Other steps that there must be, to see that it does not happen there.
const OTHERS: usize = 4;

/// Share of the squares of the error that a sample must account for: no other error has its course and its size.
const ACCOUNTS_FOR: f64 = 0.75;

/// A drive sample beside a step that does not fit the output: the drive of its neighbor does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OddStep {
    /// The recording, counted from 0.
    pub recording: usize,
    /// The sample, counted from 0.
    pub sample: usize,
    /// The drive that fits: that of the sample before or of the sample behind.
    pub drive: f64,
}

impl OddStep {
    /// The recording with the drive that fits, which says so among its [`Recording::adaptations`].
    #[must_use]
    pub fn put_right(&self, recording: &Recording) -> Recording {
        recording.driven_in(self.sample, self.drive)
    }
}

/// Detects a drive sample beside a step whose output says that the step came a sample earlier or later, or that the drive did not overshoot.
///
/// The model is fitted to everything but the answers to the steps around the largest error, from `fit`. One sample then accounts for that
/// error if, with the drive of the sample before or behind it, three quarters of its squares are gone, and if behind no
/// other step there is more than a quarter of them. A spoiled sample that stands far from both neighbors needs no model:
/// [`recording::mended`].
///
/// `None` where no such sample is found, for static data, and where there are fewer than four other steps.
///
/// # Errors
///
/// Any error of the model.
pub fn odd_step(
    model: &dyn ForwardModel,
    fit: &Fit,
    recordings: &[Recording],
) -> Result<Option<OddStep>, IdentifyError> {
    let spans = recordings.iter().enumerate().flat_map(|(recording, one)| {
        let spans = answers_in(one, fit.tau_s()).into_iter();
        spans.map(move |span| Answer { recording, span })
    });
    let answers: Vec<Answer> = spans.collect();
    let Some(worst) = standing_alone(model, &fit.points(), recordings, &answers)? else {
        return Ok(None);
    };
    let near: Vec<&Answer> = answers.iter().filter(|one| one.overlaps(worst)).collect();
    let Refined { points, .. } = fitted_elsewhere(model, fit, recordings, &near)?;
    let Some(worst) = standing_alone(model, &points, recordings, &answers)? else {
        return Ok(None);
    };
    let (recording, point) = (&recordings[worst.recording], &points[worst.recording]);
    let near = answers.iter().filter(|one| one.overlaps(worst));
    let samples = near.flat_map(|one| [one.span.start - 1, one.span.start]);
    let neighbors =
        samples.flat_map(|sample| [(sample, sample.wrapping_sub(1)), (sample, sample + 1)]);
    let mut least = (1.0 - ACCOUNTS_FOR) * squares(model, point, recording, worst)?;
    let mut best = None;
    for (sample, neighbor) in neighbors {
        let Some(&drive) = recording.drive().get(neighbor) else {
            continue;
        };
        let odd = OddStep {
            recording: worst.recording,
            sample,
            drive,
        };
        let left = squares(model, point, &odd.put_right(recording), worst)?;
        if left < least {
            (least, best) = (left, Some(odd));
        }
    }
    Ok(best)
}

/// Answer of a rod to a step of its drive.
#[derive(Debug)]
struct Answer {
    recording: usize,
    /// Samples from the step on.
    span: Range<usize>,
}

impl Answer {
    fn overlaps(&self, other: &Self) -> bool {
        self.recording == other.recording
            && self.span.start < other.span.end
            && other.span.start < self.span.end
    }
}

/// Spans in which a rod answers the steps of its drive; none if that only ever steps, or for static data.
fn answers_in(recording: &Recording, tau_s: f64) -> Vec<Range<usize>> {
    let Some(dt_s) = recording.sampling().usual_dt_s() else {
        return Vec::new();
    };
    let drive = recording.drive();
    let lowest = drive.iter().copied().fold(f64::INFINITY, f64::min);
    let large = A_STEP * (recording.largest_drive() - lowest);
    let length = ((ANSWER * tau_s / dt_s) as usize).max(LEAST_SAMPLES);
    let is_step = |k: &usize| (drive[*k] - drive[*k - 1]).abs() > large;
    let steps: Vec<usize> = (1..drive.len()).filter(is_step).collect();
    if steps.len() as f64 > MOST_STEPS * drive.len() as f64 {
        return Vec::new();
    }
    let spans = steps.into_iter().map(|k| k..(k + length).min(drive.len()));
    spans.collect()
}

/// The answer with the largest error, if all that do not overlap it have far less.
fn standing_alone<'a>(
    model: &dyn ForwardModel,
    points: &[Vec<f64>],
    recordings: &[Recording],
    answers: &'a [Answer],
) -> Result<Option<&'a Answer>, IdentifyError> {
    let mut errors = vec![Vec::new(); recordings.len()];
    let mut worst = None;
    let mut most = 0.0;
    let mut squares = Vec::with_capacity(answers.len());
    for answer in answers {
        let of_recording = &mut errors[answer.recording];
        if of_recording.is_empty() {
            let r = answer.recording;
            *of_recording = square_errors(model, &points[r], &recordings[r])?;
        }
        let own: f64 = of_recording[answer.span.clone()].iter().sum();
        if own > most {
            (most, worst) = (own, Some(answer));
        }
        squares.push(own);
    }
    let Some(worst) = worst else {
        return Ok(None);
    };
    let pairs = answers.iter().zip(&squares);
    let others: Vec<f64> = pairs
        .filter(|(other, _)| !other.overlaps(worst))
        .map(|(_, squares)| *squares)
        .collect();
    let is_alone = others.len() >= OTHERS && others.iter().all(|other| *other <= AT_OTHERS * most);
    Ok(is_alone.then_some(worst))
}

/// The model fitted to everything but some answers.
fn fitted_elsewhere(
    model: &dyn ForwardModel,
    fit: &Fit,
    recordings: &[Recording],
    without: &[&Answer],
) -> Result<Refined, IdentifyError> {
    let weights = recordings.iter().map(|one| vec![1.0; one.len()]);
    let mut weights: Vec<Vec<f64>> = weights.collect();
    for answer in without {
        weights[answer.recording][answer.span.clone()].fill(0.0);
    }
    let vector = ParameterVector::new(model.parameters(), recordings.len());
    let config = RefineConfig {
        weights: Some(weights),
        ..RefineConfig::default()
    };
    refine(model, recordings, &[fit.coordinates(&vector)], &config)
}

/// Squares of the error of the output, a sample each.
fn square_errors(
    model: &dyn ForwardModel,
    point: &[f64],
    recording: &Recording,
) -> Result<Vec<f64>, IdentifyError> {
    let prediction = predict(model, point, recording)?;
    let pairs = recording.output().iter().zip(prediction.output);
    Ok(pairs.map(|(y, model)| (y - model).powi(2)).collect())
}

/// Sum of these over an answer.
fn squares(
    model: &dyn ForwardModel,
    point: &[f64],
    recording: &Recording,
    answer: &Answer,
) -> Result<f64, IdentifyError> {
    let of_all = square_errors(model, point, recording)?;
    Ok(of_all[answer.span.clone()].iter().sum())
}
