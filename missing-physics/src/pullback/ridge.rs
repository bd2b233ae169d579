//! Penalized least squares, judged by blocks that it has not seen.

use identify::in_parallel;
use std::ops::Range;

use identify::dense::{self, Matrix, symmetric_eigen};

use crate::model::projection::dot;
use crate::model::series::{Channel, Layout};

/// Blocks of time that are left out in turn, at least.
const N_FOLDS: usize = 10;

/// Products of columns and a target in each block of time, from which every fit follows.
#[derive(Debug, Clone)]
pub(crate) struct Folded {
    grams: Vec<Matrix>,
    alongs: Vec<Vec<f64>>,
    squares: Vec<f64>,
}

impl Folded {
    pub(crate) fn of(columns: &[Vec<f64>], target: &[f64], folds: &[Vec<Range<usize>>]) -> Self {
        let product = |a: &[f64], b: &[f64], fold: &[Range<usize>]| -> f64 {
            fold.iter()
                .map(|range| dot(&a[range.clone()], &b[range.clone()]))
                .sum()
        };
        let n = columns.len();
        let gram = |fold: &Vec<Range<usize>>| {
            let mut gram = Matrix::zeros(n, n);
            for i in 0..n {
                for j in 0..=i {
                    let entry = product(&columns[i], &columns[j], fold);
                    (gram[(i, j)], gram[(j, i)]) = (entry, entry);
                }
            }
            gram
        };
        let along = |fold: &Vec<Range<usize>>| {
            let products = columns.iter().map(|column| product(column, target, fold));
            products.collect()
        };
        Self {
            grams: in_parallel(folds, gram),
            alongs: folds.iter().map(along).collect(),
            squares: folds
                .iter()
                .map(|fold| product(target, target, fold))
                .collect(),
        }
    }

    /// Sum of squares of the target.
    pub(crate) fn square(&self) -> f64 {
        self.squares.iter().sum()
    }

    /// Mean of the squares' sums of the columns.
    pub(crate) fn mean_square(&self, columns: &[usize]) -> f64 {
        let whole = self.gram(columns, None);
        let trace: f64 = (0..columns.len()).map(|i| whole[(i, i)]).sum();
        trace / columns.len().max(1) as f64
    }

    /// Sum of squares of what some columns leave of each block, fitted to the others.
    pub(crate) fn held_out(&self, columns: &[usize], penalty: &Matrix) -> f64 {
        (0..self.grams.len())
            .map(|fold| {
                let own = self.fit(columns, penalty, Some(fold));
                let mut left = self.squares[fold];
                for (&i, a) in columns.iter().zip(&own) {
                    left -= 2.0 * a * self.alongs[fold][i];
                    for (&j, b) in columns.iter().zip(&own) {
                        left += a * b * self.grams[fold][(i, j)];
                    }
                }
                left
            })
            .sum()
    }

    /// Coefficients of some columns, fitted to all blocks.
    pub(crate) fn coefficients(&self, columns: &[usize], penalty: &Matrix) -> Vec<f64> {
        self.fit(columns, penalty, None)
    }

    /// Covariance of the coefficients for a target of variance 1, the penalty as a prior.
    pub(crate) fn covariance(&self, columns: &[usize], penalty: &Matrix) -> Matrix {
        dense::inverse(&(self.gram(columns, None) + penalty))
    }

    /// Projector on the coefficients of columns, of length 1 before the model's share was taken out, of whose
    /// squares at least a share is left.
    pub(crate) fn visible(&self, columns: &[usize], share: f64) -> Matrix {
        let n = columns.len();
        let Some(eigen) = symmetric_eigen(&self.gram(columns, None)) else {
            return Matrix::identity(n, n);
        };
        let (vectors, values) = (eigen.vectors, eigen.values);
        let seen: Vec<usize> = (0..n).filter(|&k| values[k] >= share).collect();
        Matrix::from_fn(n, n, |i, j| {
            let parts = seen.iter().map(|&k| vectors[(i, k)] * vectors[(j, k)]);
            parts.sum()
        })
    }

    /// The penalty among some, scaled over powers of ten, that predicts best, and the sum of squares it leaves.
    pub(crate) fn best_penalty(
        &self,
        columns: &[usize],
        penalty: &Matrix,
        scales: impl IntoIterator<Item = f64>,
    ) -> (Matrix, f64) {
        let mut best = (Matrix::zeros(columns.len(), columns.len()), f64::INFINITY);
        for scale in scales {
            let scaled =
                Matrix::from_fn(columns.len(), columns.len(), |i, j| scale * penalty[(i, j)]);
            let left = self.held_out(columns, &scaled);
            if left < best.1 {
                best = (scaled, left);
            }
        }
        best
    }

    fn fit(&self, columns: &[usize], penalty: &Matrix, without: Option<usize>) -> Vec<f64> {
        let along = Matrix::from_fn(columns.len(), 1, |i, _| {
            let folds = self.alongs.iter().enumerate();
            let others = folds.filter(|(fold, _)| Some(*fold) != without);
            others.map(|(_, along)| along[columns[i]]).sum()
        });
        let solution = dense::solved(&(self.gram(columns, without) + penalty), &along);
        (0..columns.len()).map(|i| solution[(i, 0)]).collect()
    }

    fn gram(&self, columns: &[usize], without: Option<usize>) -> Matrix {
        let mut gram = Matrix::zeros(columns.len(), columns.len());
        for (fold, own) in self.grams.iter().enumerate() {
            if Some(fold) == without {
                continue;
            }
            for (i, &from) in columns.iter().enumerate() {
                for (j, &to) in columns.iter().enumerate() {
                    gram[(i, j)] += own[(from, to)];
                }
            }
        }
        gram
    }
}

/// Blocks of contiguous samples of equal length, at least ten, none across recordings; both channels of a
/// recording together.
pub(crate) fn folds(layout: &Layout) -> Vec<Vec<Range<usize>>> {
    let n_outputs = layout.n_outputs().max(1);
    let mut folds = Vec::new();
    for segment in layout.of_channel(Channel::Output) {
        let n_samples = segment.range.len();
        let n_parts = (N_FOLDS * n_samples).div_ceil(n_outputs).max(1);
        let temperatures = layout
            .of_channel(Channel::Temperature)
            .find(|other| other.recording == segment.recording);
        for part in 0..n_parts {
            let own = part * n_samples / n_parts..(part + 1) * n_samples / n_parts;
            let starts = [Some(segment), temperatures].into_iter().flatten();
            let moved = starts.map(|segment| {
                let start = segment.range.start;
                start + own.start..start + own.end
            });
            folds.push(moved.collect());
        }
    }
    folds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_and_predicted() {
        let line: Vec<f64> = (0..100).map(|k| f64::from(k) - 50.0).collect();
        let wave: Vec<f64> = (0..100).map(|k| (0.7 * f64::from(k)).sin()).collect();
        let target: Vec<f64> = line.iter().map(|value| 2.0 * value).collect();
        let folds: Vec<Vec<Range<usize>>> = (0..10)
            .map(|fold| std::iter::once(10 * fold..10 * (fold + 1)).collect())
            .collect();
        let folded = Folded::of(&[line, wave], &target, &folds);
        let none = Matrix::zeros(2, 2);
        let found = folded.coefficients(&[0, 1], &none);
        assert!((found[0] - 2.0).abs() < 1e-12 && found[1].abs() < 1e-9);
        assert!(folded.held_out(&[0, 1], &none) < 1e-9 * folded.square());
        // The wave alone predicts nothing.
        assert!(folded.held_out(&[1], &Matrix::zeros(1, 1)) > 0.9 * folded.square());
    }
}
