//! Models on blocks that were left out of their fits, without and with a curve of any shape on top.

use std::borrow::Cow;

use identify::{ForwardModel, IdentifyError, ParameterVector, Prior, PriorRow, prior_rows};

use crate::evidence::audit::{Anonymous, SHIFTS, audit};
use crate::evidence::blocks::Block;
use crate::evidence::curve;
use crate::evidence::left_out::{Columns, LeftOut};
use crate::evidence::shifts::by_chance;
use crate::evidence::worth::Evidence;
use crate::model::case::{Case, Node, prior};
use crate::model::series::Channel;
use crate::model::tangent::Sensitivity;

/// A model on blocks that were left out of its fit.
pub(crate) fn weighed(
    case: &Case<'_>,
    node: &Node,
    sensitivities: &[Sensitivity],
    blocks: &[Block],
) -> Evidence {
    let fit = Linear::of(case, node, sensitivities);
    let predicted = fit.left_out(&[], blocks).predicted(0.0);
    Evidence::of(case, less(&node.residual, &predicted), blocks)
}

/// A model with a curve of any shape on top, and the part of its residual on unseen blocks that the curve predicts.
pub(crate) fn audited(
    case: &Case<'_>,
    node: &Node,
    named: &Evidence,
    sensitivities: &[Sensitivity],
    blocks: &[Block],
    seed: u64,
) -> Result<Anonymous, IdentifyError> {
    let curve = curve::of(case, node, sensitivities)?;
    let fit = Linear::of(case, node, sensitivities);
    let predicted = fit.left_out(&curve, blocks).best_predicted();
    let evidence = Evidence::of(case, less(&node.residual, &predicted), blocks);
    Ok(Anonymous {
        audit: audit(case, [named, &evidence], blocks, seed),
        evidence,
    })
}

/// A fit to first order: what its free parameters do, and what is left, with their priors in rows below, which belong to no block.
struct Linear<'a> {
    free: Vec<Cow<'a, [f64]>>,
    target: Cow<'a, [f64]>,
    n_priors: usize,
}

impl<'a> Linear<'a> {
    fn of(case: &Case<'_>, node: &'a Node, sensitivities: &'a [Sensitivity]) -> Self {
        let prior = prior(case.base, node.noise.n_effective());
        let rows = match prior {
            Prior::Nothing => Vec::new(),
            _ => {
                let n_recordings = case.training.len();
                prior_rows(&ParameterVector::new(node.model.parameters(), n_recordings))
            }
        };
        let squares: f64 = node.residual.iter().map(|r| r * r).sum();
        let root = prior.variance(squares).sqrt();
        let free = sensitivities.iter().filter(|one| !one.held);
        let below = |column: &'a [f64], of: &dyn Fn(&PriorRow) -> f64| match rows.is_empty() {
            true => Cow::Borrowed(column),
            false => {
                let own = rows.iter().map(|row| root * of(row));
                column.iter().copied().chain(own).collect()
            }
        };
        Self {
            free: free
                .map(|one| {
                    below(&one.column, &|row| {
                        one.coordinate.map_or(0.0, |j| row.derivative(j))
                    })
                })
                .collect(),
            target: below(&node.residual, &|row| -row.value(&node.coordinates)),
            n_priors: rows.len(),
        }
    }

    /// This fit without each block, and with a curve on top.
    fn left_out<'b>(&self, curve: &[Vec<f64>], blocks: &'b [Block]) -> LeftOut<'b> {
        let free: Vec<&[f64]> = self.free.iter().map(|column| &**column).collect();
        let curve = curve.iter().map(|column| match self.n_priors {
            0 => Cow::Borrowed(column.as_slice()),
            n => column
                .iter()
                .copied()
                .chain(std::iter::repeat_n(0.0, n))
                .collect(),
        });
        let curve: Vec<Cow<'_, [f64]>> = curve.collect();
        let curve: Vec<&[f64]> = curve.iter().map(|column| &**column).collect();
        let columns = Columns {
            free: &free,
            curve: &curve,
        };
        LeftOut::new(&columns, &self.target, blocks)
    }
}

fn less(residual: &[f64], predicted: &[f64]) -> Vec<f64> {
    let pairs = residual.iter().zip(predicted);
    pairs
        .map(|(residual, predicted)| residual - predicted)
        .collect()
}

/// Probability by chance from which the size of what is left knows of the rig.
const BY_CHANCE: f64 = 0.001;

/// Share of what the size of a residual varies by that the state of the rig predicts; 0 where noise which knows nothing of it
/// would meet that as well in one of a thousand.
pub(crate) fn disturbed(
    case: &Case<'_>,
    node: &Node,
    evidence: &Evidence,
    sensitivities: &[Sensitivity],
    blocks: &[Block],
    seed: u64,
) -> Result<f64, IdentifyError> {
    let curve = curve::of(case, node, sensitivities)?;
    let curve: Vec<&[f64]> = curve.iter().map(Vec::as_slice).collect();
    let mut pairs = Vec::new();
    let mut sizes = vec![0.0; evidence.residual.len()];
    let mut levels: Vec<Vec<f64>> = Vec::new();
    let outputs: Vec<_> = case.layout.of_channel(Channel::Output).collect();
    for segment in &outputs {
        let own = &evidence.residual[segment.range.clone()];
        let mean = own.iter().map(|e| e.abs()).sum::<f64>() / own.len() as f64;
        for (size, e) in sizes[segment.range.clone()].iter_mut().zip(own) {
            *size = e.abs() - mean;
        }
        let mut level = vec![0.0; sizes.len()];
        level[segment.range.clone()].fill(1.0);
        levels.push(level);
    }
    let free: Vec<&[f64]> = levels.iter().map(Vec::as_slice).collect();
    let columns = Columns {
        free: &free,
        curve: &curve,
    };
    let predicted = LeftOut::new(&columns, &sizes, blocks).best_predicted();
    for segment in &outputs {
        let own = |series: &[f64]| series[segment.range.clone()].to_vec();
        pairs.push((own(&sizes), own(&predicted)));
    }
    if by_chance(&pairs, SHIFTS, seed) > BY_CHANCE {
        return Ok(0.0);
    }
    let square = |series: &[f64]| series.iter().map(|one| one * one).sum::<f64>();
    let all: f64 = pairs.iter().map(|(sizes, _)| square(sizes)).sum();
    let left: f64 = pairs
        .iter()
        .map(|(sizes, predicted)| square(&less(sizes, predicted)))
        .sum();
    Ok((1.0 - left / all.max(f64::MIN_POSITIVE)).max(0.0))
}
