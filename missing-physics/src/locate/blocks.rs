//! Which block of the cascade lacks something: the one whose local terms predict the residual best.

use identify::dense::Matrix;
use identify::{ResidualNoise, in_parallel};
use recording::order::falling;

use crate::EffectBlock;
use crate::locate::located::Located;
use crate::model::projection::{Span, norm};
use crate::model::series::Noise;
use crate::noise::whiten::Whitener;
use crate::pullback::local_terms::{LocalTerm, Variable, drifts_of, terms_of};
use crate::pullback::ridge::{Folded, folds};
use crate::pullback::scene::Scene;

/// Blocks in which a term may be missing.
pub(crate) const BLOCKS: [EffectBlock; 4] = [
    EffectBlock::Drive,
    EffectBlock::HeatBalance,
    EffectBlock::Transformation,
    EffectBlock::Displacement,
];

/// Penalties of columns of length 1, against noise of variance 1: from none to one that leaves no more than
/// noise would.
const PENALTIES: [f64; 5] = [1e-6, 1e-4, 1e-2, 1e-1, 1.0];

/// Least gain of a block over nothing, nats of data that it has not seen: with four blocks of a few models each,
/// noise gains as much in few files.
const SIGNIFICANT_NATS: f64 = 8.0;

/// Share r of what is explained that traces of first order are wrong by: 10 % of its amplitude.
const FIRST_ORDER: f64 = 0.01;

/// Share u of what no block describes that the blocks may be wrong by.
const NOT_DESCRIBED: f64 = 0.1;

/// Mean square that all terms together leave, over that of the noise, up to which they describe the residual
/// and what is left is noise.
const DESCRIBED: f64 = 2.0;

/// Largest factor by which memory lowers the number of independent samples.
const LONGEST_MEMORY: f64 = 100.0;

/// Local terms, and the residual, as a test sees them: whitened, and outside what the model absorbs.
pub(crate) struct Pulled {
    pub(crate) terms: Vec<LocalTerm>,
    /// Length of each whitened term before what the model absorbs was taken out; the columns of `folded` are
    /// in units of it.
    pub(crate) lengths: Vec<f64>,
    pub(crate) folded: Folded,
    pub(crate) n_samples: usize,
    /// Samples that tell as much as an independent one.
    pub(crate) samples_per_independent: f64,
}

impl Pulled {
    /// Whitens by the memory of what all terms together leave: that of the residual itself has the misfit
    /// for noise, and hides it. Where the terms do not describe the residual either, that memory is misfit
    /// too: then nothing is whitened, and fewer samples count.
    pub(crate) fn of(located: &Located<'_>, scene: &Scene) -> Self {
        let case = located.case;
        let mut terms = terms_of(case, scene);
        terms.extend(drifts_of(case, scene));
        let first = Self::whitened(located, terms, located.whitener);
        let noise = case.layout.noise(&first.left_by_all(located));
        let variance = located.floor * located.floor;
        if noise.output.variance <= DESCRIBED * variance {
            let whitener = Whitener::new(&case.layout, &noise);
            return Self::whitened(located, first.terms, &whitener);
        }
        let memory = memory(&noise.output);
        let white = |noise: &ResidualNoise, variance: f64| ResidualNoise {
            coefficients: Vec::new(),
            innovation_variance: variance,
            ..noise.clone()
        };
        let whitener = Whitener::new(
            &case.layout,
            &Noise {
                output: white(&noise.output, variance),
                temperature: white(&noise.temperature, noise.temperature.variance),
            },
        );
        Self {
            samples_per_independent: memory,
            ..Self::whitened(located, first.terms, &whitener)
        }
    }

    /// Remainder of the residual that all terms together leave.
    fn left_by_all(&self, located: &Located<'_>) -> Vec<f64> {
        let all: Vec<usize> = (0..self.terms.len()).collect();
        let (penalty, _) = self.best(&all);
        let coefficients = self.folded.coefficients(&all, &penalty);
        let mut left = located.node.residual.clone();
        for (j, coefficient) in coefficients.iter().enumerate() {
            let size = coefficient / self.lengths[j];
            for (left, column) in left.iter_mut().zip(&self.terms[j].column) {
                *left -= size * column;
            }
        }
        Span::of(located.fitted()).outside(&left)
    }

    fn whitened(located: &Located<'_>, terms: Vec<LocalTerm>, whitener: &Whitener) -> Self {
        let fitted: Vec<Vec<f64>> = located
            .fitted()
            .into_iter()
            .map(|column| whitener.whiten(column))
            .collect();
        let span = Span::of(&fitted);
        let columns = in_parallel(&terms, |term| {
            let white = whitener.whiten(&term.column);
            let length = norm(&white).max(f64::MIN_POSITIVE);
            let mut outside = span.outside(&white);
            outside.iter_mut().for_each(|value| *value /= length);
            (length, outside)
        });
        let (lengths, columns): (Vec<f64>, Vec<Vec<f64>>) = columns.into_iter().unzip();
        let target = span.outside(&whitener.whiten(&located.node.residual));
        let folds = folds(&located.case.layout);
        Self {
            folded: Folded::of(&columns, &target, &folds),
            lengths,
            terms,
            n_samples: target.len(),
            samples_per_independent: 1.0,
        }
    }

    /// Mean square of what is left, that of noise being 1, as far as the samples are independent.
    pub(crate) fn dispersion(&self, left: f64) -> f64 {
        (left / self.n_samples as f64).max(1.0) * self.samples_per_independent
    }

    /// The penalty with which some terms predict best, and the sum of squares that they leave.
    fn best(&self, terms: &[usize]) -> (Matrix, f64) {
        let penalty = Matrix::identity(terms.len(), terms.len());
        self.folded.best_penalty(terms, &penalty, PENALTIES)
    }

    /// The terms of a block for which a condition holds.
    pub(crate) fn of_block(
        &self,
        block: EffectBlock,
        holds: impl Fn(&LocalTerm) -> bool,
    ) -> Vec<usize> {
        let terms = self.terms.iter().enumerate();
        let own = terms.filter(|(_, term)| term.block == block && holds(term));
        own.map(|(j, _)| j).collect()
    }

    /// Models of a block: its curves, its drifts, its other terms and every one of them by itself, and all
    /// together.
    fn models(&self, block: EffectBlock) -> Vec<Vec<usize>> {
        let is_curve = |term: &LocalTerm| term.heating.is_some();
        let is_drift = |term: &LocalTerm| term.variable == Variable::Time;
        let single = self.of_block(block, |term| !is_curve(term) && !is_drift(term));
        let mut models: Vec<Vec<usize>> = single.into_iter().map(|j| vec![j]).collect();
        models.push(self.of_block(block, |term| term.variable == Variable::Other));
        models.push(self.of_block(block, is_curve));
        models.push(self.of_block(block, is_drift));
        models.push(self.of_block(block, |_| true));
        models.retain(|model| !model.is_empty());
        models
    }

    /// Sum of squares that the best model of a block leaves of blocks of time that it has not seen.
    fn left_by(&self, block: EffectBlock) -> f64 {
        let models = self.models(block);
        let left = in_parallel(&models, |model| self.best(model).1);
        left.into_iter().fold(self.folded.square(), f64::min)
    }
}

/// Probability of every block, the likeliest first; none if no block predicts anything.
///
/// ```text
/// P ∝ exp(-S/(2 φ)),   φ = max(n max(1, S_best/N), r (S_0 - S_best), u (S_best - N))
/// ```
///
/// with the sum of squares S that the block leaves of data held out in turn, S_0 with nothing, and the number n
/// of samples that tell as much as an independent one. The dispersion φ keeps a block sober that is the best
/// and leaves more than noise, and ties blocks that a term of first order cannot tell apart, however little
/// noise there is.
pub(crate) fn blocks(pulled: &Pulled) -> Vec<(EffectBlock, f64)> {
    let left = BLOCKS.map(|block| pulled.left_by(block));
    let best = left.iter().copied().fold(f64::INFINITY, f64::min);
    let (nothing, n_samples) = (pulled.folded.square(), pulled.n_samples as f64);
    let noise = (best / n_samples).max(1.0);
    let is_significant = 0.5 * (nothing - best) / noise > SIGNIFICANT_NATS;
    if !is_significant {
        return Vec::new();
    }
    let dispersion = pulled
        .dispersion(best)
        .max(FIRST_ORDER * (nothing - best))
        .max(NOT_DESCRIBED * (best - n_samples));
    let nats = |left: f64| -0.5 * left / dispersion;
    let weights = left.map(|left| (nats(left) - nats(best)).exp());
    let whole: f64 = weights.iter().sum();
    let mut blocks: Vec<(EffectBlock, f64)> = BLOCKS
        .into_iter()
        .zip(weights)
        .map(|(block, weight)| (block, weight / whole))
        .collect();
    falling(&mut blocks, |block| block.1);
    blocks
}

/// Spectral density of autoregressive noise at frequency 0 over that of white noise of its variance: so many
/// samples tell as much of a slow course as an independent one.
fn memory(noise: &ResidualNoise) -> f64 {
    let recalled: f64 = noise.coefficients.iter().sum();
    let density = noise.innovation_variance / ((1.0 - recalled).powi(2) * noise.variance);
    if density.is_finite() {
        density.clamp(1.0, LONGEST_MEMORY)
    } else {
        LONGEST_MEMORY
    }
}
