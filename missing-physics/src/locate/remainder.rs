//! The missing term as a curve.

use identify::dense::{Matrix, symmetric_eigen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::locate::blocks::Pulled;
use crate::locate::located::Located;
use crate::model::projection::{Span, dot};
use crate::{Curve, EffectBlock, Shape};

/// Penalties of the curves' second differences, against the mean square sum of the terms.
const PENALTIES: [f64; 9] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0];

/// Penalty of the size beside that of the bend.
const SIZE: f64 = 1e-2;

/// Share of a direction's square that the model must leave, for the curve to show it: the rest may be
/// anything.
const SEEN: f64 = 1e-2;

/// Draws of the largest deviation of a curve.
const DRAWS: usize = 1_000;

/// Least gain of a curve over nothing, nats of data that it has not seen.
const SIGNIFICANT_NATS: f64 = 8.0;

/// The curves of a block on heating and on cooling that describe the residual best, without what the model
/// itself could do; `None` if they predict nothing.
pub(crate) fn shape(located: &Located<'_>, pulled: &Pulled, block: EffectBlock) -> Option<Shape> {
    let terms = pulled.of_block(block, |term| term.heating.is_some());
    if terms.is_empty() {
        return None;
    }
    let scale = pulled.folded.mean_square(&terms);
    let penalties = PENALTIES.map(|penalty| scale * penalty);
    let (penalty, left) = pulled
        .folded
        .best_penalty(&terms, &bends(pulled, &terms), penalties);
    let dispersion = pulled.dispersion(left);
    let gain = 0.5 * (pulled.folded.square() - left) / dispersion;
    let is_significant = gain > SIGNIFICANT_NATS;
    if !is_significant {
        return None;
    }
    let per_length = |(coefficient, &j): (f64, &usize)| coefficient / pulled.lengths[j];
    let visible = pulled.folded.visible(&terms, SEEN);
    let found = pulled.folded.coefficients(&terms, &penalty);
    let found = Matrix::from_fn(terms.len(), 1, |i, _| found[i]);
    let found = &visible * found;
    let found = (0..terms.len()).map(|i| found[(i, 0)]);
    let sizes: Vec<f64> = found.zip(&terms).map(per_length).collect();
    let covariance = pulled.folded.covariance(&terms, &penalty);
    let covariance = &visible * covariance * &visible;
    let halves = band(&covariance, dispersion, located.seed);
    let halves: Vec<f64> = halves.into_iter().zip(&terms).map(per_length).collect();
    let unit = Unit::of(located, block);
    let curve = |heating: bool| Curve {
        heating,
        points: (0..terms.len())
            .filter(|&i| pulled.terms[terms[i]].heating == Some(heating))
            .map(|i| {
                let knot = pulled.terms[terms[i]].knot;
                [knot, unit.per_term * sizes[i], unit.per_term * halves[i]]
            })
            .collect(),
    };
    Some(Shape {
        block,
        variable: unit.variable,
        value: unit.value,
        share: described(located, pulled, &terms, &sizes),
        curves: vec![curve(true), curve(false)],
    })
}

/// Variable and value of the curves, with their units.
struct Unit {
    variable: &'static str,
    value: String,
    /// Value of a term of size 1.
    per_term: f64,
}

impl Unit {
    fn of(located: &Located<'_>, block: EffectBlock) -> Self {
        let case = located.case;
        let heat = case.base.wiener_params(&located.node.points[0]).heat;
        let knows_heat = case.base.knows_temperature() && case.setting.mass_kg_per_m.is_some();
        let (variable, value, per_term) = match block {
            EffectBlock::Transformation => (
                "transformed fraction, 0 to 1",
                "shift of the loop, K".to_owned(),
                1.0,
            ),
            EffectBlock::Displacement | EffectBlock::Sensor => {
                let unit = &case.fit.output_unit;
                (
                    "place in the stroke, 0 to 1",
                    format!("displacement, {unit}"),
                    1.0,
                )
            }
            EffectBlock::Drive | EffectBlock::HeatBalance if knows_heat => (
                "temperature above ambient, K",
                "heat, W/m".to_owned(),
                heat.heat_capacity_j_per_m_k,
            ),
            EffectBlock::Drive | EffectBlock::HeatBalance => (
                "temperature above ambient, K",
                "heat over heat capacity, K/s".to_owned(),
                1.0,
            ),
        };
        Self {
            variable,
            value,
            per_term,
        }
    }
}

/// Penalty of second differences along each curve, of coefficients in units of their columns.
fn bends(pulled: &Pulled, terms: &[usize]) -> Matrix {
    let n = terms.len();
    let mean = terms.iter().map(|&j| pulled.lengths[j]).sum::<f64>() / n as f64;
    // A coefficient is the size times its length: back to sizes, in units of the mean length.
    let per = |i: usize| mean / pulled.lengths[terms[i]];
    let mut penalty = Matrix::zeros(n, n);
    for i in 0..n {
        penalty[(i, i)] += SIZE;
    }
    for i in 1..n.saturating_sub(1) {
        let branch = |i: usize| pulled.terms[terms[i]].heating;
        if branch(i - 1) != branch(i + 1) {
            continue;
        }
        let row = [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)];
        for (a, one) in row {
            for (b, other) in row {
                penalty[(a, b)] += one * per(a) * other * per(b);
            }
        }
    }
    penalty
}

/// Half widths within which all coefficients are at once in 95 % of draws.
fn band(covariance: &Matrix, dispersion: f64, seed: u64) -> Vec<f64> {
    let n = covariance.nrows();
    let deviations: Vec<f64> = (0..n)
        .map(|i| (dispersion * covariance[(i, i)].max(0.0)).sqrt())
        .collect();
    let Some(eigen) = symmetric_eigen(covariance) else {
        return vec![f64::INFINITY; n];
    };
    let scaled = eigen.scaled_vectors();
    let root: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|k| dispersion.sqrt() * scaled[(i, k)]).collect())
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut largest: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let normal: Vec<f64> = (0..n).map(|_| StandardNormal.sample(&mut rng)).collect();
            let relative = root.iter().zip(&deviations).map(|(row, deviation)| {
                let drawn = dot(row, &normal).abs();
                if *deviation > 0.0 {
                    drawn / deviation
                } else {
                    0.0
                }
            });
            relative.fold(0.0, f64::max)
        })
        .collect();
    largest.sort_by(f64::total_cmp);
    let quantile = largest
        .get(DRAWS * 95 / 100)
        .copied()
        .unwrap_or(f64::INFINITY);
    deviations
        .iter()
        .map(|deviation| quantile * deviation)
        .collect()
}

/// Share of the explainable error that terms of these sizes describe.
fn described(located: &Located<'_>, pulled: &Pulled, terms: &[usize], sizes: &[f64]) -> f64 {
    let mut left = located.node.residual.clone();
    for (&j, size) in terms.iter().zip(sizes) {
        for (left, column) in left.iter_mut().zip(&pulled.terms[j].column) {
            *left -= size * column;
        }
    }
    let left = Span::of(located.fitted()).outside(&left);
    let n_outputs = located.case.layout.n_outputs();
    let square = |series: &[f64]| dot(&series[..n_outputs], &series[..n_outputs]);
    let gained = square(&located.node.residual) - square(&left);
    (gained / located.explainable()).clamp(0.0, 1.0)
}
