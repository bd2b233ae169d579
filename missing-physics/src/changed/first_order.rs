//! Effects that may have appeared, to first order.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use identify::IdentifyError;
use identify::dense::{Matrix, definite_inverse};
use rayon::prelude::*;
use recording::order::falling;

use crate::changed::joint::Runs;
use crate::changed::system::System;
use crate::model::case::{Case, Node};
use crate::model::projection::dot;
use crate::model::tangent::traces;
use crate::screen::scores::sizes_of;
use crate::{Belongs, Candidate, CandidateSet, Sign};

/// Sizes at which an effect is tried, as shares of its typical size: each stands for the sizes around it.
const SHARES: [f64; 6] = [0.02, 0.06, 0.18, 0.5, 1.5, 4.0];

/// The factor from one to the next.
const APART: f64 = 3.0;

/// The share at which an effect of several sizes is tried, and the standard deviation of each.
const OF_SEVERAL: f64 = 0.5;

/// One way in which an effect may be there, to first order.
#[derive(Debug, Clone)]
pub(crate) struct Way {
    /// Of each size, per typical size: in all runs, or in one where each has its own.
    columns: Vec<Vec<f64>>,
    size: Size,
    partner: Option<f64>,
    typical: f64,
}

#[derive(Debug, Clone, Copy)]
enum Size {
    /// Between two ends, or as far below nothing.
    Within([f64; 2], bool),
    /// Normal about nothing.
    About(f64),
}

/// All the ways in which an effect may be there.
#[derive(Debug, Clone)]
pub(crate) struct Alternative {
    pub(crate) effect: Candidate,
    ways: Vec<Way>,
}

/// How well a way does to first order.
#[derive(Debug, Clone)]
pub(crate) struct Tried {
    /// Logarithm of its density over that of no change, nats.
    pub(crate) nats: f64,
    /// Its likeliest sizes; one of several stands for all.
    pub(crate) size: f64,
    pub(crate) partner: Option<f64>,
}

pub(crate) fn alternatives(
    case: &Case<'_>,
    runs: &Runs,
    node: &Node,
    catalogue: CandidateSet,
) -> Result<Vec<Alternative>, IdentifyError> {
    let wanted: Vec<Candidate> = catalogue
        .iter()
        .filter(|&effect| !node.effects.contains(effect) && case.missing(effect).is_none())
        .collect();
    let effects = wanted
        .par_iter()
        .map(|&effect| {
            let n_sizes = sizes_of(effect).count();
            let is_single = n_sizes == 1;
            let shares: &[f64] = if is_single { &SHARES } else { &[OF_SEVERAL] };
            let parameters = effect.info().parameters;
            let shares: Vec<f64> = shares
                .iter()
                .copied()
                .filter(|share| share * parameters[0].typical <= parameters[0].bounds[1])
                .collect();
            let traces = traces(case, node, effect, &shares, None)?;
            let mut ways: Vec<Way> = Vec::new();
            if is_single {
                for trace in traces {
                    let at = trace.share * parameters[0].typical;
                    let root = APART.sqrt();
                    let two_sided = parameters[0].sign() != Sign::NonNegative;
                    ways.push(Way {
                        size: Size::Within([at / root, at * root], two_sided),
                        columns: vec![trace.secant],
                        partner: trace.partner,
                        typical: 1.0,
                    });
                }
            } else {
                for group in traces.chunk_by(|a, b| a.is_tested_with(b)) {
                    let scaled = group.iter().zip(sizes_of(effect)).map(|(trace, k)| {
                        let typical = parameters[k].typical;
                        trace
                            .secant
                            .iter()
                            .map(|value| value * typical)
                            .collect::<Vec<f64>>()
                    });
                    let mut columns: Vec<Vec<f64>> = scaled.collect();
                    if effect.info().belongs_to == Belongs::Recording {
                        columns = columns
                            .iter()
                            .flat_map(|column| {
                                (0..runs.len()).map(|run| runs.only_in(&[run], column))
                            })
                            .collect();
                    }
                    ways.push(Way {
                        columns,
                        size: Size::About(OF_SEVERAL),
                        partner: group[0].partner,
                        typical: parameters[0].typical,
                    });
                }
            }
            Ok(Alternative { effect, ways })
        })
        .collect::<Result<Vec<_>, IdentifyError>>()?;
    Ok(effects)
}

impl Alternative {
    /// Against no change of these runs: each way, the best first.
    pub(crate) fn tried(&self, runs: &Runs, system: &System, changed: &[usize]) -> Vec<Tried> {
        let ways = self.ways.iter();
        let mut tried: Vec<Tried> = ways.map(|way| way.tried(runs, system, changed)).collect();
        falling(&mut tried, |one| one.nats);
        tried
    }
}

impl Way {
    fn tried(&self, runs: &Runs, system: &System, changed: &[usize]) -> Tried {
        let none = Tried {
            nats: 0.0,
            size: 0.0,
            partner: self.partner,
        };
        let only = self.columns.iter();
        let only = only.map(|column| runs.only_in(changed, column));
        let white: Vec<Vec<f64>> = only
            .filter(|column| column.iter().any(|value| *value != 0.0))
            .map(|column| runs.white(&system.filters, &column))
            .collect();
        if white.is_empty() {
            return none;
        }
        let outside = system.outside(&white);
        let (nats, size) = match self.size {
            Size::Within(ends, two_sided) => {
                let q = outside.squares[(0, 0)];
                let raw = dot(&white[0], &white[0]);
                if q.is_nan() || q <= SHOWS * raw || raw <= 0.0 {
                    return none;
                }
                let at = outside.along[0] / q;
                let up = ln_within(q, at, ends);
                let (nats, sign) = if two_sided {
                    let down = ln_within(q, -at, ends);
                    let top = up.max(down);
                    let both = top + (0.5 * ((up - top).exp() + (down - top).exp())).ln();
                    (both, if up >= down { 1.0 } else { -1.0 })
                } else {
                    (up, 1.0)
                };
                (nats, sign * (sign * at).clamp(ends[0], ends[1]))
            }
            Size::About(deviation) => {
                let m = white.len();
                let precision = Matrix::from_fn(m, m, |i, j| {
                    let own = if i == j { 1.0 } else { 0.0 };
                    own + deviation * deviation * outside.squares[(i, j)]
                });
                let Some((inverse, ln_determinant)) = definite_inverse(&precision) else {
                    return none;
                };
                let along = Matrix::from_fn(m, 1, |i, _| deviation * outside.along[i]);
                let sizes = &inverse * &along;
                let nats = 0.5 * ((along.transpose() * &sizes)[(0, 0)] - ln_determinant);
                (nats, deviation * sizes[(0, 0)])
            }
        };
        Tried {
            nats,
            size: size * self.typical,
            ..none
        }
    }
}

/// Share of a series outside what may be adjusted below which that is rounding.
const SHOWS: f64 = 1e-8;

/// ln ∫ exp(q (A â - A²/2)) dA/w over a range of width w.
fn ln_within(q: f64, at: f64, [low, high]: [f64; 2]) -> f64 {
    let root = q.sqrt();
    let ends = [(low - at) * root, (high - at) * root];
    let mass = ln_normal(ends);
    0.5 * q * at * at + mass + 0.5 * (2.0 * PI).ln() - root.ln() - (high - low).ln()
}

/// Logarithm of what a standard normal has between two ends.
fn ln_normal([a, b]: [f64; 2]) -> f64 {
    if b <= 0.0 {
        return ln_normal([-b, -a]);
    }
    if a <= 0.0 {
        let outside = 0.5 * (libm::erfc(-a * FRAC_1_SQRT_2) + libm::erfc(b * FRAC_1_SQRT_2));
        return (1.0 - outside).max(f64::MIN_POSITIVE).ln();
    }
    if a < 25.0 {
        let mass = 0.5 * (libm::erfc(a * FRAC_1_SQRT_2) - libm::erfc(b * FRAC_1_SQRT_2));
        if mass > 0.0 {
            return mass.ln();
        }
    }
    -0.5 * a * a - (a * (2.0 * PI).sqrt()).ln()
}
