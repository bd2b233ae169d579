//! Series over all recordings: the outputs one after the other, then the recorded temperatures.

use std::ops::Range;

use identify::{FINEST_THERMOMETER_K, ForwardModel, IdentifyError, ResidualNoise, try_in_parallel};
use recording::Recording;

/// Channel that fills a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Channel {
    Output,
    Temperature,
}

/// The part of a series that one channel of one recording fills: none is continued by the next.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Segment {
    pub(crate) recording: usize,
    pub(crate) channel: Channel,
    pub(crate) range: Range<usize>,
}

/// Layout of a series: the place of each segment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    pub(crate) segments: Vec<Segment>,
    /// Factor that brings temperatures to the scale of the output, (output unit)/K.
    pub(crate) per_k: f64,
}

impl Layout {
    pub(crate) fn of(training: &[Recording], per_k: f64) -> Self {
        let outputs = (0..training.len()).map(|r| (r, Channel::Output));
        let temperatures = (0..training.len())
            .filter(|&r| training[r].temperature_degc().is_some())
            .map(|r| (r, Channel::Temperature));
        let mut start = 0;
        let segments = outputs
            .chain(temperatures)
            .map(|(recording, channel)| {
                let range = start..start + training[recording].len();
                start = range.end;
                Segment {
                    recording,
                    channel,
                    range,
                }
            })
            .collect();
        Self { segments, per_k }
    }

    pub(crate) fn len(&self) -> usize {
        self.segments.last().map_or(0, |last| last.range.end)
    }

    /// Number of samples of the output.
    pub(crate) fn n_outputs(&self) -> usize {
        self.of_channel(Channel::Output)
            .map(|one| one.range.len())
            .sum()
    }

    pub(crate) fn of_channel(&self, channel: Channel) -> impl Iterator<Item = &Segment> {
        self.segments
            .iter()
            .filter(move |one| one.channel == channel)
    }

    /// Recorded series.
    pub(crate) fn recorded(&self, training: &[Recording]) -> Vec<f64> {
        let mut series = Vec::with_capacity(self.len());
        for segment in &self.segments {
            let recording = &training[segment.recording];
            match segment.channel {
                Channel::Output => series.extend_from_slice(recording.output()),
                Channel::Temperature => {
                    let recorded = recording.temperature_degc().unwrap_or(&[]);
                    series.extend(recorded.iter().map(|degc| self.per_k * degc));
                }
            }
        }
        series
    }

    /// Series of a model, one a point; `points(r)` are those of recording r.
    pub(crate) fn shown(
        &self,
        model: &dyn ForwardModel,
        training: &[Recording],
        points: impl Fn(usize) -> Vec<Vec<f64>>,
    ) -> Result<Vec<Vec<f64>>, IdentifyError> {
        /// Points that a model takes at once.
        const BATCH: usize = 32;
        let of_each: Vec<Vec<Vec<f64>>> = (0..training.len()).map(points).collect();
        let mut series: Vec<Vec<f64>> = Vec::new();
        for points in &of_each {
            series.resize_with(points.len(), || vec![0.0; self.len()]);
        }
        let batches = of_each.iter().enumerate();
        let batches = batches.flat_map(|(r, points)| {
            let each = points.chunks(BATCH).enumerate();
            each.map(move |(k, batch)| (r, k * BATCH, batch))
        });
        let batches: Vec<(usize, usize, &[Vec<f64>])> = batches.collect();
        let simulated = try_in_parallel(&batches, |&(r, _, batch)| {
            self.simulated(model, batch, (r, &training[r]))
        })?;
        for ((r, first, _), segments) in batches.into_iter().zip(simulated) {
            for (segment, own) in self.of_recording(r).zip(segments) {
                for (series, own) in series[first..].iter_mut().zip(own) {
                    series[segment.range.clone()].copy_from_slice(&own);
                }
            }
        }
        Ok(series)
    }

    fn of_recording(&self, r: usize) -> impl Iterator<Item = &Segment> {
        self.segments.iter().filter(move |one| one.recording == r)
    }

    /// Series that a model has in each segment of one recording, one a point.
    fn simulated(
        &self,
        model: &dyn ForwardModel,
        points: &[Vec<f64>],
        (r, recording): (usize, &Recording),
    ) -> Result<Vec<Vec<Vec<f64>>>, IdentifyError> {
        let empty = |_| Vec::with_capacity(recording.len());
        let segments = self.of_recording(r);
        let mut shown: Vec<Vec<Vec<f64>>> = segments
            .map(|_| points.iter().map(empty).collect())
            .collect();
        model.simulate(points, recording, &mut |block| {
            for (segment, series) in self.of_recording(r).zip(&mut shown) {
                let (values, per) = match segment.channel {
                    Channel::Output => (block.displacement, 1.0),
                    Channel::Temperature => (block.temperature_degc, self.per_k),
                };
                for (lane, series) in series.iter_mut().enumerate() {
                    let own = values.iter().skip(lane).step_by(block.stride);
                    series.extend(own.map(|value| per * value));
                }
            }
        })?;
        Ok(shown)
    }

    /// The noise of each channel, as autoregressive models of a residual.
    pub(crate) fn noise(&self, residual: &[f64]) -> Noise {
        Noise {
            output: self.noise_of(Channel::Output, residual),
            temperature: self.noise_of(Channel::Temperature, residual),
        }
    }

    /// That of one channel.
    pub(crate) fn noise_of(&self, channel: Channel, residual: &[f64]) -> ResidualNoise {
        let segments: Vec<&[f64]> = self
            .of_channel(channel)
            .map(|one| &residual[one.range.clone()])
            .collect();
        ResidualNoise::of_at_least(&segments, self.least_noise(channel))
    }

    /// Standard deviation of the noise that there is at least in a channel, in the output's unit.
    pub(crate) fn least_noise(&self, channel: Channel) -> f64 {
        match channel {
            Channel::Output => 0.0,
            Channel::Temperature => self.per_k * FINEST_THERMOMETER_K,
        }
    }
}

/// Noise of the two channels.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Noise {
    pub(crate) output: ResidualNoise,
    pub(crate) temperature: ResidualNoise,
}

impl Noise {
    pub(crate) fn of(&self, channel: Channel) -> &ResidualNoise {
        match channel {
            Channel::Output => &self.output,
            Channel::Temperature => &self.temperature,
        }
    }

    /// Logarithm of the likelihood of a residual that this is the noise of, but for a constant of the data.
    pub(crate) fn nats(&self) -> f64 {
        [&self.output, &self.temperature]
            .into_iter()
            .filter(|noise| noise.n_samples > 0 && noise.innovation_variance > 0.0)
            .map(|noise| -0.5 * noise.n_samples as f64 * noise.innovation_variance.ln())
            .sum()
    }

    /// Twice the negative logarithm of the likelihood of independent samples.
    pub(crate) fn deviance(&self) -> f64 {
        let own = |noise: &ResidualNoise| noise.n_samples as f64 * noise.variance.ln();
        [&self.output, &self.temperature]
            .into_iter()
            .filter(|noise| noise.n_samples > 0 && noise.variance > 0.0)
            .map(own)
            .sum()
    }

    /// Samples that would tell as much of the sizes if they were independent.
    pub(crate) fn n_effective(&self) -> f64 {
        [&self.output, &self.temperature]
            .into_iter()
            .filter(|noise| noise.n_samples > 0)
            .map(|noise| noise.n_effective)
            .sum()
    }

    /// [`Noise::nats`] from the sizes of the residuals alone, of as many independent samples as another noise has.
    pub(crate) fn nats_of_size(&self, other: &Self) -> f64 {
        [
            (&self.output, &other.output),
            (&self.temperature, &other.temperature),
        ]
        .into_iter()
        .filter(|(noise, _)| noise.n_samples > 0 && noise.variance > 0.0)
        .map(|(noise, other)| -0.5 * other.n_effective * noise.variance.ln())
        .sum()
    }
}
