//! Predictions of blocks from a regression on all others.

use identify::dense::{Matrix, symmetric_solved, transposed_product};

use crate::evidence::blocks::Block;

/// Share of all data that what a block alone determines is worth: the offset of a recording that is left out as a whole
/// stays where all data had it.
const ANCHOR: f64 = 0.1;

/// Penalties of the curve, for columns of length 1.
const PENALTIES: [f64; 6] = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// Columns of a regression, each a series over the layout.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns<'a> {
    /// Columns of the model's free parameters, which are fitted anew without each block.
    pub(crate) free: &'a [&'a [f64]],
    /// A curve of any shape, penalized.
    pub(crate) curve: &'a [&'a [f64]],
}

/// Products of the columns, of all data and of what goes with each block.
#[derive(Debug)]
pub(crate) struct LeftOut<'a> {
    blocks: &'a [Block],
    columns: Matrix,
    n_free: usize,
    gram: Matrix,
    along: Matrix,
    removed: Vec<(Matrix, Matrix)>,
    target: Matrix,
}

impl<'a> LeftOut<'a> {
    pub(crate) fn new(columns: &Columns<'_>, target: &[f64], blocks: &'a [Block]) -> Self {
        let all: Vec<&[f64]> = columns.free.iter().chain(columns.curve).copied().collect();
        let per: Vec<f64> = all
            .iter()
            .map(|column| {
                let length = column.iter().map(|value| value * value).sum::<f64>().sqrt();
                if length > 0.0 { 1.0 / length } else { 0.0 }
            })
            .collect();
        let n = target.len();
        let matrix = Matrix::from_fn(n, all.len(), |k, j| per[j] * all[j][k]);
        let target = Matrix::from_fn(n, 1, |k, _| target[k]);
        let products = |rows: &std::ops::Range<usize>| {
            (
                transposed_product(&matrix, &matrix, rows.clone()),
                transposed_product(&matrix, &target, rows.clone()),
            )
        };
        let removed = blocks.iter().map(|block| {
            let mut sums = (
                Matrix::zeros(all.len(), all.len()),
                Matrix::zeros(all.len(), 1),
            );
            for (gram, along) in block.removed.iter().map(&products) {
                sums = (sums.0 + gram, sums.1 + along);
            }
            sums
        });
        let removed = removed.collect();
        let (gram, along) = products(&(0..n));
        Self {
            blocks,
            n_free: columns.free.len(),
            gram,
            along,
            removed,
            target,
            columns: matrix,
        }
    }

    /// Predictions of each block from all others, with this penalty on the curve.
    pub(crate) fn predicted(&self, penalty: f64) -> Vec<f64> {
        let mut predicted = vec![0.0; self.columns.nrows()];
        for (block, removed) in self.blocks.iter().zip(&self.removed) {
            let own = self.coefficients(penalty, removed);
            for rows in block.scored() {
                let shown = self.columns.rows(rows.start, rows.len()) * &own;
                for (place, k) in rows.clone().enumerate() {
                    predicted[k] = shown[(place, 0)];
                }
            }
        }
        predicted
    }

    /// Predictions of each block from all others, with the penalty that predicts best.
    pub(crate) fn best_predicted(&self) -> Vec<f64> {
        let left = |predicted: &Vec<f64>| -> f64 {
            let pairs = predicted.iter().enumerate();
            pairs
                .map(|(k, shown)| (self.target[(k, 0)] - shown).powi(2))
                .sum()
        };
        let tried = PENALTIES.iter().map(|&penalty| self.predicted(penalty));
        let best = tried
            .map(|one| (left(&one), one))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, predicted)| predicted).unwrap_or_default()
    }

    fn coefficients(&self, penalty: f64, (gram, along): &(Matrix, Matrix)) -> Matrix {
        let n = self.gram.ncols();
        let is_free = |i: usize| i < self.n_free;
        let penalized = Matrix::from_fn(n, n, |i, j| {
            let anchor = if is_free(i) && is_free(j) {
                ANCHOR * self.gram[(i, j)]
            } else {
                0.0
            };
            // A trace of damping: columns may be zero, or say the same.
            let own = match (i == j, is_free(i)) {
                (false, _) => 0.0,
                (true, true) => 1e-12,
                (true, false) => penalty,
            };
            self.gram[(i, j)] - gram[(i, j)] + anchor + own
        });
        symmetric_solved(&penalized, &(&self.along - along))
    }
}
