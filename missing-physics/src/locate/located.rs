//! Where a model and its recordings part: in which regimes, when, how fast, and in which block.

use crate::model::case::{Case, Node};
use crate::model::tangent::Sensitivity;
use crate::noise::whiten::Whitener;

/// Standard errors of the noise's mean square by which that of the residual must exceed it.
const CLEAR: f64 = 2.0;

/// A model whose residual is to be located.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Located<'a> {
    pub(crate) case: &'a Case<'a>,
    pub(crate) node: &'a Node,
    pub(crate) sensitivities: &'a [Sensitivity],
    pub(crate) whitener: &'a Whitener,
    /// Standard deviation of the noise of the output.
    pub(crate) floor: f64,
    /// Seed of the surrogates.
    pub(crate) seed: u64,
}

impl<'a> Located<'a> {
    /// Columns that the model's free parameters can follow.
    pub(crate) fn fitted(&self) -> Vec<&'a Vec<f64>> {
        let free = self.sensitivities.iter().filter(|one| !one.held);
        free.map(|one| &one.column).collect()
    }

    /// Sum of the squares of the output's residual beyond the noise that a fit leaves.
    pub(crate) fn explainable(&self) -> f64 {
        let n_outputs = self.case.layout.n_outputs() as f64;
        let left = n_outputs - self.node.n_free() as f64;
        n_outputs * self.node.mean_square() - left.max(0.0) * self.floor.powi(2)
    }

    /// True if there is anything to explain.
    pub(crate) fn is_clear(&self) -> bool {
        let n_outputs = self.case.layout.n_outputs() as f64;
        let n_effective = self.node.noise.output.n_effective.max(1.0);
        let error = n_outputs * self.floor.powi(2) * (2.0 / n_effective).sqrt();
        self.explainable() > CLEAR * error
    }
}
