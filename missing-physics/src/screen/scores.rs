//! Score tests: how much of a residual lies along the trace of each effect.

use identify::dense::{self, Matrix, symmetric_eigen};
use identify::in_parallel;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::model::projection::{Span, dot, norm};
use crate::model::tangent::Trace;
use crate::noise::whiten::Whitener;
use crate::{Candidate, Role};

/// Draws of the largest score under noise alone: 5 % of them lie above with a standard error of 0.3 %.
const DRAWS: usize = 5_000;

/// Share of a trace that must be left outside the span: below it the baseline does all that the effect
/// could, but for rounding.
const SMALLEST_TRACE: f64 = 1e-6;

/// Cosine of two traces from which they are one.
const SAME: f64 = 0.98;

/// Score of an effect.
#[derive(Debug, Clone)]
pub(crate) struct Score {
    pub(crate) effect: Candidate,
    /// Score in standard deviations, of whitened series; of several sizes, that of one which is as unlikely.
    pub(crate) whitened: f64,
    /// Score in standard deviations, of the series as they are, with the variance of correlated noise.
    pub(crate) plain: f64,
    /// Sizes to first order, from the series as they are, in the order of the effect's parameters.
    pub(crate) sizes: Vec<f64>,
    /// Standard errors of the sizes, from the whitened series.
    pub(crate) errors: Vec<f64>,
    /// Root mean square, per unit of the first size, that refitting the model does not hide.
    pub(crate) shown_per_unit: f64,
    /// Share of the trace that refitting the model hides, 0 to 1: of its square.
    pub(crate) absorbed: f64,
    /// Value of the partner at which it scores best.
    pub(crate) partner: Option<f64>,
    /// Size of the secant with which it does, as a share of the typical size.
    pub(crate) share: f64,
    /// Where it would show: the whitened trace of these sizes outside what the model absorbs, of length 1; zeros if it shows
    /// nowhere.
    pub(crate) direction: Vec<f64>,
}

/// Scores of all candidates.
#[derive(Debug)]
pub(crate) struct Scores {
    pub(crate) scores: Vec<Score>,
    /// Largest whitened score that noise alone exceeds in 5 % of files.
    pub(crate) critical: f64,
}

/// Model that the candidates are compared with.
#[derive(Debug)]
pub(crate) struct Ground<'a> {
    /// Recorded - model.
    pub(crate) residual: &'a [f64],
    /// Derivatives of the model by its free parameters.
    pub(crate) fitted: &'a [&'a Vec<f64>],
    pub(crate) whitener: &'a Whitener,
}

/// One test: a trace alone, or the traces of several sizes together.
#[derive(Debug)]
struct Tested<'a> {
    traces: Vec<&'a Trace>,
    /// Whitened and outside the span.
    white: Vec<Vec<f64>>,
}

/// Scores effects; `traces` holds those of each effect together.
pub(crate) fn scores(traces: &[Trace], ground: &Ground<'_>, seed: u64) -> Scores {
    let whitener = ground.whitener;
    let white: Vec<Vec<f64>> = ground
        .fitted
        .iter()
        .map(|column| whitener.whiten(column))
        .collect();
    let (plain_span, white_span) = (Span::of(ground.fitted.iter().copied()), Span::of(&white));
    let plain_residual = plain_span.outside(ground.residual);
    let white_residual = white_span.outside(&whitener.whiten(ground.residual));
    let all = in_parallel(&grouped(traces), |traces| {
        let outside = |trace: &&Trace| {
            let white = whitener.whiten(&trace.secant);
            let outside = white_span.outside(&white);
            if norm(&outside) > SMALLEST_TRACE * norm(&white) {
                outside
            } else {
                vec![0.0; white.len()]
            }
        };
        Tested {
            white: traces.iter().map(outside).collect(),
            traces: traces.clone(),
        }
    });
    let mut tests: Vec<Tested<'_>> = Vec::new();
    for test in all {
        if !tests.last().is_some_and(|last| last.is_the_same(&test)) {
            tests.push(test);
        }
    }
    let each = in_parallel(&tests, |test| {
        test.score(&plain_span, &plain_residual, &white_residual, whitener)
    });
    let mut scores: Vec<Score> = Vec::new();
    for score in each {
        match scores.last_mut() {
            // The next value of the partner, or the next secant, of the same effect.
            Some(best) if best.effect == score.effect => {
                if score.plain > best.plain {
                    *best = score;
                }
            }
            _ => scores.push(score),
        }
    }
    Scores {
        critical: critical(&tests, seed),
        scores,
    }
}

/// Groups traces into tests: several sizes of an effect together, each value of a partner and each secant by itself.
fn grouped(traces: &[Trace]) -> Vec<Vec<&Trace>> {
    let mut tests: Vec<Vec<&Trace>> = Vec::new();
    for trace in traces {
        match tests.last_mut() {
            Some(test) if test[0].is_tested_with(trace) => test.push(trace),
            _ => tests.push(vec![trace]),
        }
    }
    tests
}

impl Tested<'_> {
    fn one_sided(&self) -> bool {
        self.traces.len() == 1 && self.traces[0].one_sided
    }

    /// True if the other test is of the same effect and partner, with a secant that shows nothing else.
    fn is_the_same(&self, other: &Self) -> bool {
        let (one, another) = (self.traces[0], other.traces[0]);
        let mut pairs = self.white.iter().zip(&other.white);
        one.effect == another.effect
            && one.partner == another.partner
            && pairs.all(|(a, b)| dot(a, b) >= SAME * norm(a) * norm(b))
    }

    fn score(
        &self,
        plain_span: &Span,
        plain_residual: &[f64],
        white_residual: &[f64],
        whitener: &Whitener,
    ) -> Score {
        let plain: Vec<Vec<f64>> = self
            .traces
            .iter()
            .map(|trace| plain_span.outside(&trace.secant))
            .collect();
        let along: Vec<f64> = plain.iter().map(|one| dot(one, plain_residual)).collect();
        let carried: Vec<Vec<f64>> = plain.iter().map(|one| whitener.carried(one)).collect();
        let sizes = times(&inverse(&gram(&plain)), &along);
        let white_along: Vec<f64> = self
            .white
            .iter()
            .map(|one| dot(one, white_residual))
            .collect();
        let white_inverse = inverse(&gram(&self.white));
        let errors = (0..self.white.len())
            .map(|k| match white_inverse[(k, k)] {
                variance if variance > 0.0 => variance.sqrt(),
                _ => f64::INFINITY,
            })
            .collect();
        let (raw, left) =
            self.traces
                .iter()
                .zip(&plain)
                .fold((0.0, 0.0), |sums, (trace, plain)| {
                    let (raw, left): (f64, f64) = sums;
                    (
                        raw + dot(&trace.secant, &trace.secant),
                        left + dot(plain, plain),
                    )
                });
        let mut direction = vec![0.0; white_residual.len()];
        for (size, white) in sizes.iter().zip(&self.white) {
            for (sum, white) in direction.iter_mut().zip(white) {
                *sum += size * white;
            }
        }
        let length = norm(&direction);
        if length > 0.0 {
            direction.iter_mut().for_each(|value| *value /= length);
        }
        Score {
            effect: self.traces[0].effect,
            whitened: self.strength(&white_inverse, &white_along),
            plain: self.strength(&inverse(&gram(&carried)), &along),
            sizes,
            errors,
            shown_per_unit: norm(&plain[0]) / (plain[0].len() as f64).sqrt(),
            absorbed: if raw > 0.0 { 1.0 - left / raw } else { 0.0 },
            partner: self.traces[0].partner,
            share: self.traces[0].share,
            direction,
        }
    }

    /// The score of products b with covariance V, given its inverse: b/√V, or of several the square root of
    /// bᵀV⁻¹b as unlikely.
    fn strength(&self, inverse: &Matrix, along: &[f64]) -> f64 {
        if let [along] = along {
            let score = along * inverse[(0, 0)].max(0.0).sqrt();
            return if self.one_sided() { score } else { score.abs() };
        }
        as_one(dot(&times(inverse, along), along).max(0.0), along.len())
    }
}

/// Square root of the χ² of one degree that is as unlikely as one of `degrees` (Wilson and Hilferty's cube root
/// is normal: Biometrika 1931).
pub(crate) fn as_one(chi_squared: f64, degrees: usize) -> f64 {
    if degrees <= 1 {
        return chi_squared.max(0.0).sqrt();
    }
    let m = degrees as f64;
    let spread = |m: f64| 2.0 / (9.0 * m);
    let normal = ((chi_squared / m).cbrt() - (1.0 - spread(m))) / spread(m).sqrt();
    let root = 1.0 - spread(1.0) + normal * spread(1.0).sqrt();
    root.max(0.0).powi(3).sqrt()
}

fn gram(columns: &[Vec<f64>]) -> Matrix {
    Matrix::from_fn(columns.len(), columns.len(), |i, j| {
        dot(&columns[i], &columns[j])
    })
}

/// Inverse of a covariance, with a trace of damping for directions that nothing fixes; zeros for what has no
/// variance.
fn inverse(covariance: &Matrix) -> Matrix {
    let n = covariance.ncols();
    let scale: Vec<f64> = (0..n).map(|i| covariance[(i, i)].sqrt()).collect();
    let per = |i: usize| if scale[i] > 0.0 { 1.0 / scale[i] } else { 0.0 };
    let damped = Matrix::from_fn(n, n, |i, j| {
        let trace = if i == j { 1.0 + 1e-9 } else { 1.0 };
        let correlation = covariance[(i, j)] * per(i) * per(j);
        if i == j && scale[i] <= 0.0 {
            1.0
        } else {
            trace * correlation
        }
    });
    let inverse = dense::inverse(&damped);
    Matrix::from_fn(n, n, |i, j| inverse[(i, j)] * per(i) * per(j))
}

fn times(matrix: &Matrix, vector: &[f64]) -> Vec<f64> {
    (0..vector.len())
        .map(|i| (0..vector.len()).map(|j| matrix[(i, j)] * vector[j]).sum())
        .collect()
}

/// 95 % quantile of the largest score of noise alone, whose products with the traces are normal.
fn critical(tests: &[Tested<'_>], seed: u64) -> f64 {
    let columns: Vec<&Vec<f64>> = tests.iter().flat_map(|test| &test.white).collect();
    let n = columns.len();
    if n == 0 {
        return f64::INFINITY;
    }
    let lengths: Vec<f64> = columns.iter().map(|column| norm(column)).collect();
    let cosines = Matrix::from_fn(n, n, |i, j| {
        let product = lengths[i] * lengths[j];
        if product > 0.0 {
            dot(columns[i], columns[j]) / product
        } else {
            0.0
        }
    });
    let Some(eigen) = symmetric_eigen(&cosines) else {
        return f64::INFINITY;
    };
    let scaled = eigen.scaled_vectors();
    let root: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|k| scaled[(i, k)]).collect())
        .collect();
    // Inverse covariance of each test of several sizes.
    let mut first = 0;
    let blocks: Vec<(usize, Matrix)> = tests
        .iter()
        .map(|test| {
            let (at, m) = (first, test.white.len());
            first += m;
            let block = Matrix::from_fn(m, m, |i, j| cosines[(at + i, at + j)]);
            (at, inverse(&block))
        })
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut largest: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let normal: Vec<f64> = (0..n).map(|_| StandardNormal.sample(&mut rng)).collect();
            let drawn: Vec<f64> = root.iter().map(|row| dot(row, &normal)).collect();
            tests
                .iter()
                .zip(&blocks)
                .map(|(test, (at, block))| test.strength(block, &drawn[*at..at + test.white.len()]))
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    largest.sort_by(f64::total_cmp);
    largest
        .get(DRAWS * 95 / 100)
        .copied()
        .unwrap_or(f64::INFINITY)
}

/// Numbers of an effect's parameters that are sizes.
pub(crate) fn sizes_of(effect: Candidate) -> impl Iterator<Item = usize> {
    let parameters = effect.info().parameters;
    (0..parameters.len()).filter(|&k| parameters[k].role == Role::Size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EffectId;
    use crate::model::series::{Channel, Layout, Noise, Segment};
    use identify::ResidualNoise;

    const N: usize = 2000;

    fn wave(rate: f64) -> Vec<f64> {
        (0..N).map(|k| (rate * k as f64).sin()).collect()
    }

    fn noise(seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..N).map(|_| StandardNormal.sample(&mut rng)).collect()
    }

    /// Three effects of one size, two of them nearly alike, and one of two sizes.
    fn traces() -> Vec<Trace> {
        [
            (EffectId::LatentHeat, 0.013),
            (EffectId::Radiation, 0.0131),
            (EffectId::Backlash, 0.05),
            (EffectId::SensorNonlinearity, 0.2),
            (EffectId::SensorNonlinearity, 0.3),
        ]
        .into_iter()
        .map(|(effect, rate)| Trace {
            effect: effect.into(),
            partner: None,
            share: 1.0,
            one_sided: effect != EffectId::SensorNonlinearity,
            secant: wave(rate),
        })
        .collect()
    }

    fn scored(residual: &[f64], fitted: &[Vec<f64>], deviation: f64) -> Scores {
        let layout = Layout {
            segments: vec![Segment {
                recording: 0,
                channel: Channel::Output,
                range: 0..N,
            }],
            per_k: 0.0,
        };
        let white = ResidualNoise {
            innovation_variance: deviation * deviation,
            ..ResidualNoise::of(&[])
        };
        let noise = Noise {
            temperature: white.clone(),
            output: white,
        };
        let fitted: Vec<&Vec<f64>> = fitted.iter().collect();
        let ground = Ground {
            residual,
            fitted: &fitted,
            whitener: &Whitener::new(&layout, &noise),
        };
        scores(&traces(), &ground, 7)
    }

    #[test]
    fn the_effect_that_is_there_scores_what_it_should() {
        let trace = wave(0.05);
        let residual: Vec<f64> = noise(1)
            .iter()
            .zip(&trace)
            .map(|(e, s)| 0.1 * e + 0.02 * s)
            .collect();
        let found = scored(&residual, &[vec![1.0; N], wave(0.007)], 0.1);
        let expected = 0.02 * norm(&trace) / 0.1;
        let own = &found.scores[2];
        assert!((own.whitened - expected).abs() < 3.0 && own.whitened > found.critical);
        assert!((own.plain / own.whitened - 1.0).abs() < 1e-6);
        assert!((own.sizes[0] - 0.02).abs() < 3.0 * own.errors[0]);
        for other in [0, 1, 3] {
            assert!(found.scores[other].whitened < found.critical);
        }
        // Those nearly alike point the same way.
        let cosine = dot(&found.scores[0].direction, &found.scores[1].direction);
        assert!(cosine.abs() > 0.7, "{cosine}");
    }

    #[test]
    fn noise_alone_exceeds_the_critical_value_in_one_file_of_twenty() {
        let mut above = 0;
        for seed in 0..400 {
            let found = scored(&noise(1000 + seed), &[vec![1.0; N]], 1.0);
            let largest = found.scores.iter().map(|one| one.whitened);
            above += usize::from(largest.fold(f64::MIN, f64::max) > found.critical);
        }
        assert!((8..=34).contains(&above), "{above}");
    }

    #[test]
    fn what_the_model_can_do_is_absorbed() {
        let found = scored(&noise(1), &[wave(0.05), vec![1.0; N]], 1.0);
        assert!(found.scores[2].absorbed > 1.0 - 1e-12);
        assert!(found.scores[2].whitened.abs() < 1e-6);
    }

    #[test]
    fn several_degrees_count_as_one_that_is_as_unlikely() {
        // 95 % quantiles of χ² with 1, 2 and 4 degrees: 3.841, 5.991, 9.488.
        assert!((as_one(3.841, 1) - 1.96).abs() < 0.01);
        for (value, degrees) in [(5.991, 2), (9.488, 4)] {
            assert!((as_one(value, degrees) - 1.96).abs() < 0.05, "{degrees}");
        }
    }
}
