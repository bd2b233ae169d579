//! Predictions of blocks from a regression on all others.

use std::ops::Range;

use identify::dense::{Matrix, gram, symmetric_solved};
use identify::in_parallel;

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

/// Products of the columns and of the target beside them, of all data and of what goes with each block.
#[derive(Debug)]
pub(crate) struct LeftOut<'a> {
    blocks: &'a [Block],
    /// The columns, and the target as the last.
    columns: Matrix,
    n_free: usize,
    gram: Matrix,
    removed: Vec<Matrix>,
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
        let (n, n_columns) = (target.len(), all.len());
        let columns_and_target = Matrix::from_fn(n, n_columns + 1, |k, j| {
            if j < n_columns {
                per[j] * all[j][k]
            } else {
                target[k]
            }
        });
        // What is left out with one block may be left out with its neighbor too: no product is summed twice.
        let parts = parts(n, blocks);
        let products = in_parallel(&parts, |part| gram(&columns_and_target, part.clone()));
        let sum = |is_in: &dyn Fn(&Range<usize>) -> bool| {
            let own = parts.iter().zip(&products).filter(|(part, _)| is_in(part));
            own.fold(
                Matrix::zeros(n_columns + 1, n_columns + 1),
                |mut sum, (_, product)| {
                    sum += product;
                    sum
                },
            )
        };
        let removed = blocks.iter().map(|block| {
            sum(&|part| {
                let mut removed = block.removed.iter();
                removed.any(|rows| rows.start <= part.start && part.end <= rows.end)
            })
        });
        Self {
            blocks,
            n_free: columns.free.len(),
            removed: removed.collect(),
            gram: sum(&|_| true),
            columns: columns_and_target,
        }
    }

    /// Predictions of each block from all others, with this penalty on the curve.
    pub(crate) fn predicted(&self, penalty: f64) -> Vec<f64> {
        let mut predicted = vec![0.0; self.columns.nrows()];
        for (block, removed) in self.blocks.iter().zip(&self.removed) {
            let own = self.coefficients(penalty, removed);
            for rows in block.scored() {
                let columns = self
                    .columns
                    .view((rows.start, 0), (rows.len(), own.nrows()));
                let shown = columns * &own;
                for (place, k) in rows.clone().enumerate() {
                    predicted[k] = shown[(place, 0)];
                }
            }
        }
        predicted
    }

    /// Predictions of each block from all others, with the penalty that predicts best.
    pub(crate) fn best_predicted(&self) -> Vec<f64> {
        let target = self.columns.column(self.columns.ncols() - 1);
        let left = |predicted: &[f64]| -> f64 {
            let pairs = target.iter().zip(predicted);
            pairs.map(|(target, shown)| (target - shown).powi(2)).sum()
        };
        let tried = in_parallel(&PENALTIES, |&penalty| {
            let predicted = self.predicted(penalty);
            (left(&predicted), predicted)
        });
        let best = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, predicted)| predicted).unwrap_or_default()
    }

    fn coefficients(&self, penalty: f64, removed: &Matrix) -> Matrix {
        let n = self.gram.ncols() - 1;
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
            self.gram[(i, j)] - removed[(i, j)] + anchor + own
        });
        let along = Matrix::from_fn(n, 1, |i, _| self.gram[(i, n)] - removed[(i, n)]);
        symmetric_solved(&penalized, &along)
    }
}

/// Stretches of all `n` rows between the ends of what is left out with blocks.
fn parts(n: usize, blocks: &[Block]) -> Vec<Range<usize>> {
    let removed = blocks.iter().flat_map(|block| &block.removed);
    let ends = removed.flat_map(|rows| [rows.start, rows.end]);
    let mut cuts: Vec<usize> = ends.chain([0, n]).collect();
    cuts.sort_unstable();
    cuts.dedup();
    cuts.windows(2).map(|pair| pair[0]..pair[1]).collect()
}
