//! Worth of models against one another: likelihood, the price of parameters, and odds.

use crate::CandidateSet;
use crate::model::case::Node;
use crate::search::odds::MISFIT;
use crate::search::roads::Search;

/// Odds against each other effect, in units of log-likelihood: 20 to 1.
const ODDS: f64 = 3.0;

impl Search<'_> {
    /// The model that leaves least.
    pub(crate) fn nearest(&self) -> &Node {
        let nodes = self.nodes();
        let nearest = nodes.min_by(|a, b| a.mean_square().total_cmp(&b.mean_square()));
        nearest.unwrap_or_else(|| self.baseline())
    }

    /// Mean square of what that leaves, over that of the noise; at least 1.
    fn dispersion(&self) -> f64 {
        let least = self.nearest().mean_square();
        if self.noise() > 0.0 {
            (least / self.noise()).max(1.0)
        } else {
            1.0
        }
    }

    /// True if every model misfits: the least residual exceeds the noise by so much that likelihoods and linear views
    /// are not to be believed as they are.
    pub(crate) fn is_misfit(&self) -> bool {
        self.dispersion() > MISFIT
    }

    /// Log-likelihood of a model, and the number of samples that it is of.
    ///
    /// If every model misfits, an autoregressive noise model absorbs the very mismatch that models differ by. Then only
    /// the size of the residual counts, with as many samples as are independent in the residual of the baseline. Beside
    /// a drift the autoregressive noise model stays: the residual of a smooth drift against a real one is noise with a
    /// memory.
    fn evidence(&self, node: &Node) -> (f64, f64) {
        let dispersion = self.dispersion();
        if dispersion <= MISFIT || self.beside_drifts {
            let n = self.case.layout.len() as f64 / dispersion;
            return (node.noise.nats() / dispersion, n);
        }
        let plain = &self.baseline().noise;
        (node.noise.nats_of_size(plain), plain.n_effective())
    }

    /// Logarithm of the credibility of a model: its likelihood, Schwarz's price of its parameters, and the odds
    /// against effects that not every rod has.
    pub(crate) fn credit(&self, effects: CandidateSet) -> f64 {
        self.worth(effects) - ODDS * n_odd(effects) as f64
    }

    /// Log-likelihood of a model with Schwarz's price of its parameters.
    pub(crate) fn worth(&self, effects: CandidateSet) -> f64 {
        let Some(node) = self.get(effects) else {
            return f64::NEG_INFINITY;
        };
        let (nats, n) = self.evidence(node);
        nats - 0.5 * node.n_free() as f64 * n.max(1.0).ln()
    }

    /// By how much a model is behind another, both with their parameters counted.
    pub(crate) fn behind(&self, effects: CandidateSet, ahead: CandidateSet) -> f64 {
        self.worth(ahead) - self.worth(effects)
    }
}

/// Number of effects that not every rod has.
fn n_odd(effects: CandidateSet) -> usize {
    effects
        .iter()
        .filter(|effect| !effect.info().in_every_rod())
        .count()
}
