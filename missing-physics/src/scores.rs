//! How much of what is left each trace could explain, before anything is refitted.

use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::projection::{Span, dot, norm};
use crate::whiten::Whitener;

/// Length of a trace outside the baseline's span, relative to all of it, below which it is rounding.
const SMALLEST_TRACE: f64 = 1e-6;

/// Draws of the largest score under the null hypothesis.
const DRAWS: usize = 10_000;

/// The residual and all that could have made it, to first order; each series runs over all samples of all
/// recordings.
#[derive(Debug)]
pub(crate) struct Tangent {
    /// Recording - model.
    pub(crate) residual: Vec<f64>,
    /// Sensitivities of the fitted parameters.
    pub(crate) fitted: Vec<Vec<f64>>,
    /// Secants of the candidates, output per unit of size.
    pub(crate) candidates: Vec<Candidate>,
}

/// A candidate's trace.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    /// Its secant.
    pub(crate) secant: Vec<f64>,
    /// Whether only positive sizes mean anything.
    pub(crate) one_sided: bool,
}

/// What screening says of a candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Score {
    /// Score in standard deviations, of whitened series.
    pub(crate) whitened: f64,
    /// The same of the series as they are, with the variance of correlated noise.
    pub(crate) plain: f64,
    /// Size to first order, from the series as they are.
    pub(crate) size: f64,
    /// Standard error of the size.
    pub(crate) error: f64,
    /// Share of the trace that refitting the baseline hides, 0 to 1: of its square.
    pub(crate) absorbed: f64,
}

/// Scores of all candidates.
#[derive(Debug)]
pub(crate) struct Scores {
    pub(crate) scores: Vec<Score>,
    /// Largest whitened score that noise alone exceeds in 5 % of files.
    pub(crate) critical: f64,
}

/// Scores candidates against noise that the whitener makes white with standard deviation `noise`.
pub(crate) fn scores(tangent: &Tangent, whitener: &Whitener, noise: f64, seed: u64) -> Scores {
    let white: Vec<Vec<f64>> = tangent
        .fitted
        .iter()
        .map(|column| whitener.whiten(column))
        .collect();
    let (plain_span, white_span) = (Span::of(&tangent.fitted), Span::of(&white));
    let plain_residual = plain_span.outside(&tangent.residual);
    let white_residual = white_span.outside(&whitener.whiten(&tangent.residual));
    let traces: Vec<Vec<f64>> = tangent
        .candidates
        .iter()
        .map(|candidate| {
            let white = whitener.whiten(&candidate.secant);
            let trace = white_span.outside(&white);
            if norm(&trace) > SMALLEST_TRACE * norm(&white) {
                trace
            } else {
                vec![0.0; white.len()]
            }
        })
        .collect();
    let scores = tangent
        .candidates
        .iter()
        .zip(&traces)
        .map(|(candidate, trace)| {
            let plain = plain_span.outside(&candidate.secant);
            let length = norm(&plain);
            let deviation = noise * whitener.carried(&plain).sqrt();
            let along = dot(&plain, &plain_residual);
            let raw = norm(&candidate.secant);
            Score {
                whitened: ratio(dot(trace, &white_residual), noise * norm(trace)),
                plain: ratio(along, deviation),
                size: ratio(along, length * length),
                error: if length > 0.0 {
                    deviation / (length * length)
                } else {
                    f64::INFINITY
                },
                absorbed: if raw > 0.0 {
                    1.0 - ratio(length, raw).powi(2)
                } else {
                    0.0
                },
            }
        })
        .collect();
    let n = traces.len();
    let lengths: Vec<f64> = traces.iter().map(|trace| norm(trace)).collect();
    let cosines = Mat::from_fn(n, n, |i, j| {
        ratio(dot(&traces[i], &traces[j]), lengths[i] * lengths[j])
    });
    let one_sided: Vec<bool> = tangent.candidates.iter().map(|one| one.one_sided).collect();
    Scores {
        critical: critical(&cosines, &one_sided, seed),
        scores,
    }
}

/// 0 where there is nothing to divide by: a trace that is not there scores nothing.
fn ratio(above: f64, below: f64) -> f64 {
    if below > 0.0 { above / below } else { 0.0 }
}

/// 95 % quantile of the largest of scores that are normal with these correlations.
fn critical(cosines: &Mat<f64>, one_sided: &[bool], seed: u64) -> f64 {
    let n = one_sided.len();
    let Ok(eigen) = cosines.self_adjoint_eigen(faer::Side::Lower) else {
        return f64::INFINITY;
    };
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let root = Mat::from_fn(n, n, |i, k| vectors[(i, k)] * values[k].max(0.0).sqrt());
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut largest: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let normal: Vec<f64> = (0..n).map(|_| StandardNormal.sample(&mut rng)).collect();
            (0..n)
                .map(|i| {
                    let score: f64 = (0..n).map(|k| root[(i, k)] * normal[k]).sum();
                    if one_sided[i] { score } else { score.abs() }
                })
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    largest.sort_by(f64::total_cmp);
    largest
        .get(DRAWS * 95 / 100)
        .copied()
        .unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(rate: f64) -> Vec<f64> {
        (0..2000).map(|k| (rate * f64::from(k)).sin()).collect()
    }

    fn noise(seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..2000).map(|_| StandardNormal.sample(&mut rng)).collect()
    }

    fn candidates() -> Vec<Candidate> {
        [0.013, 0.0131, 0.05, 0.2]
            .iter()
            .map(|&rate| Candidate {
                secant: wave(rate),
                one_sided: true,
            })
            .collect()
    }

    #[test]
    fn the_candidate_that_is_there_scores_what_it_should() {
        let trace = wave(0.05);
        let residual = noise(1)
            .iter()
            .zip(&trace)
            .map(|(e, s)| 0.1 * e + 0.02 * s)
            .collect();
        let tangent = Tangent {
            residual,
            fitted: vec![vec![1.0; 2000], wave(0.007)],
            candidates: candidates(),
        };
        let screening = super::scores(&tangent, &Whitener::new(&[], &[2000]), 0.1, 1);
        let expected = 0.02 * norm(&trace) / 0.1;
        assert!((screening.scores[2].whitened - expected).abs() < 3.0);
        assert!(screening.scores[2].whitened > screening.critical);
        for other in [0, 1, 3] {
            assert!(screening.scores[other].whitened < screening.critical);
        }
        assert!((screening.scores[2].size - 0.02).abs() < 3.0 * screening.scores[2].error);
    }

    #[test]
    fn noise_alone_exceeds_the_critical_value_in_one_file_of_twenty() {
        let mut above = 0;
        for seed in 0..400 {
            let tangent = Tangent {
                residual: noise(1000 + seed),
                fitted: vec![vec![1.0; 2000]],
                candidates: candidates(),
            };
            let screening = super::scores(&tangent, &Whitener::new(&[], &[2000]), 1.0, 7);
            let largest = screening.scores.iter().map(|one| one.whitened);
            above += usize::from(largest.fold(f64::MIN, f64::max) > screening.critical);
        }
        assert!((8..=34).contains(&above), "{above}");
    }

    #[test]
    fn what_the_baseline_can_do_is_absorbed() {
        let tangent = Tangent {
            residual: noise(1),
            fitted: vec![wave(0.05), vec![1.0; 2000]],
            candidates: candidates(),
        };
        let screening = super::scores(&tangent, &Whitener::new(&[0.5], &[2000]), 1.0, 1);
        assert!(screening.scores[2].absorbed > 1.0 - 1e-12);
        assert!(screening.scores[2].whitened.abs() < 1e-6);
    }
}
