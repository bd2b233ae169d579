//! The density that a model gives to recordings: noise with a memory and heavy tails.

use identify::ResidualNoise;

use crate::evidence::blocks::Block;
use crate::model::series::{Channel, Layout, Segment};

/// Degrees of freedom of Student's t that are tried for the innovations: the last is all but normal.
const DEGREES: [f64; 4] = [2.0, 4.0, 8.0, 200.0];

/// Steps of the scale's iteration.
const STEPS: usize = 30;

/// Square of a residual over the least from which most of it is no noise.
const MISFIT: f64 = 2.0;

/// Memory of the noise of each channel: an autoregressive model.
///
/// If a model misfits, the past of its residual predicts that residual well: a memory fitted to it would absorb the misfit.
/// So if most of a residual is misfit, its memory is that of the least residual that any model without a drift leaves.
/// Models with a drift are excluded: a drift absorbs noise that grows toward low frequencies, so that such noise cannot be
/// learned from their residuals. A model that leaves hardly more than the least has a memory of its own: otherwise the model
/// with the least residual would have an advantage, since the memory was fitted to it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Memory {
    channels: [ResidualNoise; 2],
}

impl Memory {
    /// That of the least residual of the output, and of the recorded temperatures.
    pub(crate) fn of(layout: &Layout, residuals: [&[f64]; 2]) -> Self {
        let [output, temperature] = residuals;
        Self {
            channels: [
                layout.noise_of(Channel::Output, output),
                layout.noise_of(Channel::Temperature, temperature),
            ],
        }
    }

    /// Logarithm of the density of a residual in each block, nats: an autoregressive model of it, with innovations of
    /// Student's t.
    pub(crate) fn by_block(&self, layout: &Layout, residual: &[f64], blocks: &[Block]) -> Vec<f64> {
        let mut nats = vec![0.0; residual.len()];
        let channels = [Channel::Output, Channel::Temperature];
        for (channel, noise) in channels.into_iter().zip(&self.channels) {
            if noise.n_samples == 0 || noise.innovation_variance <= 0.0 {
                continue;
            }
            let own = layout.noise_of(channel, residual);
            let is_noise = own.innovation_variance > 0.0 && own.variance < MISFIT * noise.variance;
            let noise = if is_noise { &own } else { noise };
            let segments: Vec<&Segment> = layout.of_channel(channel).collect();
            let innovations: Vec<Vec<f64>> = segments
                .iter()
                .map(|one| innovations(&residual[one.range.clone()], noise))
                .collect();
            let tails = Tails::of(&innovations.concat(), layout.least_noise(channel));
            for (segment, own) in segments.iter().zip(&innovations) {
                let shown = nats[segment.range.clone()].iter_mut().zip(own);
                shown.for_each(|(nats, innovation)| *nats = tails.nats(*innovation));
            }
        }
        let of = |block: &Block| {
            block
                .scored()
                .map(|rows| nats[rows.clone()].iter().sum::<f64>())
                .sum()
        };
        blocks.iter().map(of).collect()
    }
}

/// Innovations: the part of each sample that its past does not predict. The first samples, which have no past, are scaled to
/// the same spread.
fn innovations(part: &[f64], noise: &ResidualNoise) -> Vec<f64> {
    let a = &noise.coefficients;
    let share = (noise.innovation_variance / noise.variance).sqrt();
    (0..part.len())
        .map(|k| {
            if k < a.len() {
                return share * part[k];
            }
            let past = part[..k].iter().rev();
            part[k] - a.iter().zip(past).map(|(a, past)| a * past).sum::<f64>()
        })
        .collect()
}

/// Student's t of some scale.
#[derive(Debug, Clone, Copy)]
struct Tails {
    degrees: f64,
    scale: f64,
    constant: f64,
}

impl Tails {
    /// The likeliest of at least a scale.
    fn of(innovations: &[f64], least: f64) -> Self {
        let square = innovations.iter().map(|one| one * one).sum::<f64>();
        let deviation = (square / innovations.len().max(1) as f64).sqrt();
        let least = least.max(f64::MIN_POSITIVE.sqrt());
        let deviation = deviation.max(least);
        let fitted = DEGREES.map(|degrees| {
            let tails = Self::with(degrees, innovations, deviation, least);
            let sum: f64 = innovations.iter().map(|one| tails.nats(*one)).sum();
            (sum, tails)
        });
        let best = fitted.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(|| Self::new(DEGREES[3], deviation), |(_, tails)| tails)
    }

    /// The scale by expectation and maximization.
    fn with(degrees: f64, innovations: &[f64], deviation: f64, least: f64) -> Self {
        let mut square = deviation * deviation;
        for _ in 0..STEPS {
            let weighted: f64 = innovations
                .iter()
                .map(|one| one * one * (degrees + 1.0) / (degrees + one * one / square))
                .sum();
            let next = weighted / innovations.len() as f64;
            let is_settled = (next / square - 1.0).abs() < 1e-6;
            square = next.max(least * least);
            if is_settled {
                break;
            }
        }
        Self::new(degrees, square.sqrt())
    }

    fn new(degrees: f64, scale: f64) -> Self {
        let constant = libm::lgamma(0.5 * (degrees + 1.0))
            - libm::lgamma(0.5 * degrees)
            - 0.5 * (degrees * std::f64::consts::PI).ln()
            - scale.ln();
        Self {
            degrees,
            scale,
            constant,
        }
    }

    fn nats(&self, innovation: f64) -> f64 {
        let square = (innovation / self.scale).powi(2);
        self.constant - 0.5 * (self.degrees + 1.0) * libm::log1p(square / self.degrees)
    }
}
