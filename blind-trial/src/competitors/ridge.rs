//! Ridge regression, its penalty chosen by blocks that it has not seen.

use std::ops::Range;

use identify::dense::{Matrix, gram, solved};

/// Blocks of time that are left out in turn.
const N_BLOCKS: usize = 8;

/// Penalties, as powers of ten of the number of samples.
const PENALTIES: std::ops::RangeInclusive<i32> = -8..=3;

/// Products of columns and target in a block of time.
#[derive(Debug, Clone)]
struct Products {
    gram: Matrix,
    along: Matrix,
    square: f64,
}

impl Products {
    fn of(columns: &[Vec<f64>], target: &[f64], block: Range<usize>) -> Self {
        let (n, start) = (block.len(), block.start);
        let n_columns = columns.len();
        // The target is the last column.
        let own = Matrix::from_fn(n, n_columns + 1, |k, j| {
            columns
                .get(j)
                .map_or(target[start + k], |column| column[start + k])
        });
        let products = gram(&own, 0..n);
        Self {
            gram: products.view((0, 0), (n_columns, n_columns)).into_owned(),
            along: products.view((0, n_columns), (n_columns, 1)).into_owned(),
            square: products[(n_columns, n_columns)],
        }
    }

    /// (X'X + λ I)⁻¹ X'y.
    fn coefficients(&self, penalty: f64) -> Matrix {
        let n = self.gram.nrows();
        let penalized = &self.gram + Matrix::identity(n, n) * penalty;
        solved(&penalized, &self.along)
    }

    fn without(&self, block: &Self) -> Self {
        Self {
            gram: &self.gram - &block.gram,
            along: &self.along - &block.along,
            square: self.square - block.square,
        }
    }

    /// ‖y - X a‖².
    fn left(&self, coefficients: &Matrix) -> f64 {
        let shown = &self.gram * coefficients - &self.along * 2.0;
        let moved = coefficients.transpose() * shown;
        self.square + moved[(0, 0)]
    }
}

/// Coefficients of columns that describe a target; zeros where nothing predicts blocks that were left out.
///
/// ```text
/// min ‖y - X a‖² + λ ‖a‖²
/// ```
///
/// Columns should be about zero and of mean square 1. λ leaves least of eight blocks, each described by the others.
pub(super) fn ridge(columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    let n = target.len();
    let blocks: Vec<Products> = (0..N_BLOCKS)
        .map(|b| Products::of(columns, target, b * n / N_BLOCKS..(b + 1) * n / N_BLOCKS))
        .collect();
    let whole = Products::of(columns, target, 0..n);
    let others: Vec<Products> = blocks.iter().map(|block| whole.without(block)).collect();
    let (mut penalty, mut least) = (None, whole.square);
    for power in PENALTIES {
        let tried = n as f64 * 10.0_f64.powi(power);
        let pairs = blocks.iter().zip(&others);
        let left: f64 = pairs
            .map(|(block, others)| block.left(&others.coefficients(tried)))
            .sum();
        if left < least {
            (penalty, least) = (Some(tried), left);
        }
    }
    match penalty {
        Some(penalty) => {
            let coefficients = whole.coefficients(penalty);
            (0..columns.len()).map(|j| coefficients[(j, 0)]).collect()
        }
        None => vec![0.0; columns.len()],
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn waves() -> Vec<Vec<f64>> {
        let wave = |j: usize| (0..800).map(move |k| 1.4 * ((j + 1) as f64 * 0.05 * k as f64).sin());
        (0..12).map(|j| wave(j).collect()).collect()
    }

    #[test]
    fn a_sum_of_columns_is_found() {
        let columns = waves();
        let target: Vec<f64> = (0..800)
            .map(|k| 2.0 * columns[1][k] - columns[4][k])
            .collect();
        let found = ridge(&columns, &target);
        for (j, found) in found.iter().enumerate() {
            let expected = match j {
                1 => 2.0,
                4 => -1.0,
                _ => 0.0,
            };
            assert!((found - expected).abs() < 1e-6, "{j}: {found}");
        }
    }

    #[test]
    fn noise_is_not_described() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let noise: Vec<f64> = (0..800).map(|_| random.random::<f64>() - 0.5).collect();
        let found = ridge(&waves(), &noise);
        assert!(found.iter().all(|a| a.abs() < 0.02), "{found:?}");
    }
}
