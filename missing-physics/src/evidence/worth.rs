//! Evidence for a model on data that it has not seen.

use crate::evidence::blocks::Block;
use crate::model::case::Case;

/// Evidence for a model on blocks that were left out of its fit.
#[derive(Debug, Clone)]
pub(crate) struct Evidence {
    /// Recorded - predicted where each sample was left out.
    pub(crate) residual: Vec<f64>,
    /// Logarithm of the density that the model gives to each block, nats; empty until the memory of the noise is known.
    pub(crate) nats: Vec<f64>,
    /// Sums of the squares of the residual in each block: of the output, and of a recorded temperature.
    pub(crate) squares: Vec<[f64; 2]>,
    /// Number of samples of the output.
    pub(crate) n_outputs: usize,
}

impl Evidence {
    pub(crate) fn of(case: &Case<'_>, residual: Vec<f64>, blocks: &[Block]) -> Self {
        Self {
            nats: Vec::new(),
            squares: blocks
                .iter()
                .map(|block| block.squares(&residual))
                .collect(),
            n_outputs: case.layout.n_outputs(),
            residual,
        }
    }

    /// Density of all blocks, nats.
    pub(crate) fn total(&self) -> f64 {
        self.nats.iter().sum()
    }

    /// Sums of the squares of both channels.
    pub(crate) fn squares(&self) -> [f64; 2] {
        [0, 1].map(|channel| self.squares.iter().map(|block| block[channel]).sum())
    }
}
