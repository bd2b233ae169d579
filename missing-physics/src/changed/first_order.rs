//! Effects that may have appeared, to first order: where searches of them start.

use identify::dense::{Matrix, symmetric_solved};
use identify::{IdentifyError, try_in_parallel};
use recording::order::falling;

use crate::changed::joint::Runs;
use crate::changed::system::System;
use crate::model::case::{Case, Node};
use crate::model::tangent::{Trace, traces};
use crate::screen::scores::sizes_of;
use crate::{Belongs, Candidate, CandidateSet, Sign};

/// Sizes at which an effect is tried, as shares of its typical size: each stands for the sizes around it.
const SHARES: [f64; 8] = [0.02, 0.06, 0.18, 0.5, 1.5, 4.0, 12.0, 36.0];

/// The factor from one to the next.
const APART: f64 = 3.0;

/// The share at which an effect of several sizes is tried, and the standard deviation of each.
const OF_SEVERAL: f64 = 0.5;

/// An effect, and the ways in which it may be there.
#[derive(Debug, Clone)]
pub(crate) struct Alternative {
    pub(crate) effect: Candidate,
    ways: Vec<Way>,
}

/// One way in which an effect may be there.
#[derive(Debug, Clone)]
struct Way {
    /// Of each size, in all runs, or in one where each has its own.
    columns: Vec<Vec<f64>>,
    size: Size,
    partner: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
enum Size {
    /// One, between two ends, or as far below nothing.
    Within { ends: [f64; 2], two_sided: bool },
    /// Several, normal about nothing; the columns are of typical sizes.
    About { typical: f64 },
}

/// How well a way does.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tried {
    /// Gain over no change, nats.
    nats: f64,
    /// Its likeliest size; of several the first.
    pub(crate) size: f64,
    pub(crate) partner: Option<f64>,
}

/// The effects of a catalogue that a node does not have and that can be computed.
pub(crate) fn alternatives(
    case: &Case<'_>,
    runs: &Runs,
    node: &Node,
    catalogue: CandidateSet,
) -> Result<Vec<Alternative>, IdentifyError> {
    let is_possible =
        |effect: &Candidate| !node.effects.contains(*effect) && case.missing(*effect).is_none();
    let wanted: Vec<Candidate> = catalogue.iter().filter(is_possible).collect();
    try_in_parallel(&wanted, |&effect| {
        let size = &effect.info().parameters[0];
        let shares: &[f64] = match sizes_of(effect).count() {
            1 => &SHARES,
            _ => &[OF_SEVERAL],
        };
        let shares = shares.iter().copied();
        let shares = shares.filter(|share| share * size.typical <= size.bounds[1]);
        let traces = traces(case, node, effect, &shares.collect::<Vec<f64>>(), None)?;
        let ways = traces.chunk_by(|a, b| a.is_tested_with(b));
        let ways = ways.map(|group| Way::of(effect, group, runs)).collect();
        Ok(Alternative { effect, ways })
    })
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
    /// `group` has the trace of each size.
    fn of(effect: Candidate, group: &[Trace], runs: &Runs) -> Self {
        let info = effect.info();
        let size = &info.parameters[0];
        let partner = group[0].partner;
        if let [only] = group {
            let [at, root] = [only.share * size.typical, APART.sqrt()];
            return Self {
                columns: vec![only.secant.clone()],
                size: Size::Within {
                    ends: [at / root, at * root],
                    two_sided: size.sign() != Sign::NonNegative,
                },
                partner,
            };
        }
        let of_typical = group.iter().zip(sizes_of(effect)).map(|(trace, k)| {
            let typical = info.parameters[k].typical;
            trace.secant.iter().map(|value| value * typical).collect()
        });
        let columns: Vec<Vec<f64>> = of_typical.collect();
        let each_its_own = info.belongs_to == Belongs::Recording;
        let of_runs = |column: &Vec<f64>| {
            let runs_of = |run| runs.only_in(&[run], column);
            (0..runs.len()).map(runs_of).collect::<Vec<_>>()
        };
        Self {
            columns: match each_its_own {
                true => columns.iter().flat_map(of_runs).collect(),
                false => columns,
            },
            size: Size::About {
                typical: size.typical,
            },
            partner,
        }
    }

    fn tried(&self, runs: &Runs, system: &System, changed: &[usize]) -> Tried {
        let only = self.columns.iter();
        let only = only.map(|column| runs.only_in(changed, column));
        let white: Vec<Vec<f64>> = only
            .filter(|column| column.iter().any(|value| value.abs() > 0.0))
            .map(|column| runs.white(&system.filters, &column))
            .collect();
        let outside = system.outside(&white);
        let (nats, size) = match self.size {
            _ if white.is_empty() => (0.0, 0.0),
            Size::Within { ends, two_sided } => {
                let (square, along) = (outside.squares[(0, 0)], outside.along[0]);
                let sign = if two_sided { along.signum() } else { 1.0 };
                let at = along * sign / square;
                let size = sign * at.clamp(ends[0], ends[1]);
                (size * along - 0.5 * size * size * square, size)
            }
            Size::About { typical } => {
                let m = white.len();
                let precision = Matrix::from_fn(m, m, |i, j| {
                    let of_prior = if i == j { OF_SEVERAL.powi(-2) } else { 0.0 };
                    of_prior + outside.squares[(i, j)]
                });
                let along = Matrix::from_fn(m, 1, |i, _| outside.along[i]);
                let sizes = symmetric_solved(&precision, &along);
                let gained = along.iter().zip(sizes.iter()).map(|(a, b)| a * b);
                (0.5 * gained.sum::<f64>(), typical * sizes[(0, 0)])
            }
        };
        // What shows nowhere has no size.
        let shows = nats.is_finite() && size.is_finite();
        Tried {
            nats: if shows { nats } else { 0.0 },
            size: if shows { size } else { 0.0 },
            partner: self.partner,
        }
    }
}
