//! Dense linear algebra of small matrices, compiled here once for all crates that depend on this one.

use std::ops::Range;

use nalgebra::DMatrix;
use wiener::widest_vectors;

/// A matrix, column after column.
pub type Matrix = DMatrix<f64>;

/// Partial sums of an inner product: enough for the widest vectors, and as many everywhere, so that the bits are equal.
const SUMS: usize = 16;

/// Iterations a row until a decomposition is given up: a few are usual.
const ITERATIONS_A_ROW: usize = 100;

/// Eigenvalues and eigenvectors of a symmetric matrix.
#[derive(Debug, Clone)]
pub struct SymmetricEigen {
    /// In ascending order.
    pub values: Vec<f64>,
    /// Column k belongs to value k.
    pub vectors: Matrix,
}

impl SymmetricEigen {
    /// Columns of length √λ (0 where rounding left λ below zero): R with R Rᵀ the matrix.
    #[must_use]
    pub fn scaled_vectors(&self) -> Matrix {
        let n = self.values.len();
        Matrix::from_fn(n, n, |i, k| {
            self.vectors[(i, k)] * self.values[k].max(0.0).sqrt()
        })
    }
}

/// Eigenvalues and eigenvectors of a symmetric matrix, of which the lower triangle is read; `None` if the iteration did not
/// converge, as on a matrix with NaN.
#[must_use]
pub fn symmetric_eigen(matrix: &Matrix) -> Option<SymmetricEigen> {
    let n = matrix.nrows();
    if n == 0 {
        return Some(SymmetricEigen {
            values: Vec::new(),
            vectors: matrix.clone(),
        });
    }
    let eigen = nalgebra::SymmetricEigen::try_new(matrix.clone(), f64::EPSILON, iterations(n))?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    Some(SymmetricEigen {
        values: order.iter().map(|&k| eigen.eigenvalues[k]).collect(),
        vectors: Matrix::from_fn(n, n, |i, k| eigen.eigenvectors[(i, order[k])]),
    })
}

/// Singular values, and the directions of columns that belong to them.
#[derive(Debug, Clone)]
pub(crate) struct Singular {
    /// In descending order.
    pub(crate) values: Vec<f64>,
    /// Row k belongs to value k.
    pub(crate) directions: Matrix,
}

/// The singular values of a square matrix; `None` if the iteration did not converge, as on a matrix with NaN.
pub(crate) fn singular(matrix: &Matrix) -> Option<Singular> {
    let n = matrix.nrows();
    if n == 0 {
        return Some(Singular {
            values: Vec::new(),
            directions: matrix.clone(),
        });
    }
    let svd = nalgebra::SVD::try_new(matrix.clone(), false, true, f64::EPSILON, iterations(n))?;
    Some(Singular {
        values: svd.singular_values.iter().copied().collect(),
        directions: svd.v_t?,
    })
}

/// Most iterations of a decomposition of n rows.
fn iterations(n: usize) -> usize {
    ITERATIONS_A_ROW * n
}

/// Rows of which all products of columns are summed before more are read: about what a second-level cache holds.
const ROWS_AT_ONCE: usize = 256;

/// Columns on either side whose products are summed together: their sums are as many as fit in registers.
const LEFT: usize = 2;
const RIGHT: usize = 4;

/// Partial sums of each product of [`gram`].
const STRANDS: usize = 8;

/// Product of a matrix, transposed, and itself, over some of its rows.
///
/// # Panics
///
/// If it has fewer rows.
#[must_use]
pub fn gram(matrix: &Matrix, rows: Range<usize>) -> Matrix {
    let n = matrix.ncols();
    let mut product = Matrix::zeros(n, n);
    widest_vectors(
        #[inline(always)]
        || {
            for start in rows.clone().step_by(ROWS_AT_ONCE) {
                let end = (start + ROWS_AT_ONCE).min(rows.end);
                // Beside the last column stands itself: what is too much is not written.
                let column = |k: usize| {
                    let first = k.min(n - 1) * matrix.nrows();
                    &matrix.as_slice()[first + start..first + end]
                };
                for i in (0..n).step_by(LEFT) {
                    let left: [&[f64]; LEFT] = std::array::from_fn(|a| column(i + a));
                    for j in (0..(i + LEFT).min(n)).step_by(RIGHT) {
                        let right: [&[f64]; RIGHT] = std::array::from_fn(|b| column(j + b));
                        let sums = products(&left, &right);
                        for (a, sums) in sums.iter().enumerate().take(n - i) {
                            for (b, sum) in sums.iter().enumerate().take(n - j) {
                                product[(i + a, j + b)] += sum;
                            }
                        }
                    }
                }
            }
        },
    );
    product.fill_upper_triangle_with_lower_triangle();
    product
}

/// Inner products of each series of one side with each of the other, all of one length.
#[inline(always)]
fn products(left: &[&[f64]; LEFT], right: &[&[f64]; RIGHT]) -> [[f64; RIGHT]; LEFT] {
    let mut sums = [[[0.0; STRANDS]; RIGHT]; LEFT];
    let (left, right) = (left.map(in_strands), right.map(in_strands));
    for k in 0..left[0].0.len() {
        let right: [[f64; STRANDS]; RIGHT] = std::array::from_fn(|b| right[b].0[k]);
        for a in 0..LEFT {
            let left = left[a].0[k];
            for b in 0..RIGHT {
                for l in 0..STRANDS {
                    sums[a][b][l] += left[l] * right[b][l];
                }
            }
        }
    }
    std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let rest = left[a].1.iter().zip(right[b].1);
            let rest: f64 = rest.map(|(left, right)| left * right).sum();
            sums[a][b].iter().sum::<f64>() + rest
        })
    })
}

/// A series as pieces of so many values, and the rest.
#[inline(always)]
fn in_strands(series: &[f64]) -> (&[[f64; STRANDS]], &[f64]) {
    series.as_chunks()
}

/// Inner product of two series of one length.
#[inline(always)]
pub(crate) fn dot(one: &[f64], other: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (ones, others) = (one.chunks_exact(SUMS), other.chunks_exact(SUMS));
    let (rest, other_rest) = (ones.remainder(), others.remainder());
    for (one, other) in ones.zip(others) {
        for k in 0..SUMS {
            sums[k] += one[k] * other[k];
        }
    }
    for (k, (one, other)) in rest.iter().zip(other_rest).enumerate() {
        sums[k] += one * other;
    }
    sums.iter().sum()
}

/// Solution of a square system for each column on the right, by LU with row exchanges; NaN if it has none.
#[must_use]
pub fn solved(matrix: &Matrix, right: &Matrix) -> Matrix {
    let solution = matrix.clone().lu().solve(right);
    solution.unwrap_or_else(|| Matrix::repeat(right.nrows(), right.ncols(), f64::NAN))
}

/// Solution of a symmetric system for each column on the right: by Cholesky's factor if the matrix is positive
/// definite, else by LU as [`solved`].
#[must_use]
pub fn symmetric_solved(matrix: &Matrix, right: &Matrix) -> Matrix {
    definite_solved(matrix.clone(), right).unwrap_or_else(|| solved(matrix, right))
}

/// Solution of a positive definite system for each column on the right, by Cholesky's factor; `None` if it is not.
pub(crate) fn definite_solved(matrix: Matrix, right: &Matrix) -> Option<Matrix> {
    Some(matrix.cholesky()?.solve(right))
}

/// Inverse of a positive definite matrix, and the logarithm of its determinant, by Cholesky's factor; `None` if it is not.
#[must_use]
pub fn definite_inverse(matrix: &Matrix) -> Option<(Matrix, f64)> {
    let factor = matrix.clone().cholesky()?;
    let roots = factor.l_dirty().diagonal();
    let ln_root: f64 = roots.iter().map(|root| root.ln()).sum();
    Some((factor.inverse(), 2.0 * ln_root))
}

/// Inverse of a square matrix, by LU with row exchanges; NaN if it has none.
#[must_use]
pub fn inverse(matrix: &Matrix) -> Matrix {
    let n = matrix.nrows();
    solved(matrix, &Matrix::identity(n, n))
}

/// Least-squares solution of a full-rank system with no more columns than rows, by QR; NaN if the rank is less.
///
/// # Panics
///
/// If there are fewer rows than columns, or the right side is shorter than the matrix.
pub(crate) fn least_squares(matrix: &Matrix, right: &[f64]) -> Vec<f64> {
    let n = matrix.ncols();
    if n == 0 {
        return Vec::new();
    }
    let factors = matrix.clone().qr();
    let mut reflected = Matrix::from_column_slice(right.len(), 1, right);
    factors.q_tr_mul(&mut reflected);
    let solution = factors
        .r()
        .solve_upper_triangular(&reflected.rows(0, n).into_owned());
    solution.map_or_else(|| vec![f64::NAN; n], |found| found.as_slice().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn symmetric() -> Matrix {
        Matrix::from_fn(3, 3, |i, j| {
            [[4.0, 1.0, 0.0], [1.0, 3.0, 1.0], [0.0, 1.0, 2.0]][i][j]
        })
    }

    fn is_near(one: &Matrix, other: &Matrix) -> bool {
        (one - other).amax() < 1e-12
    }

    #[test]
    fn scaled_vectors_are_a_root() {
        let eigen = symmetric_eigen(&symmetric()).unwrap();
        assert!(eigen.values.is_sorted());
        let root = eigen.scaled_vectors();
        assert!(is_near(&(&root * root.transpose()), &symmetric()));
    }

    #[test]
    fn singular_values_are_those_of_the_square() {
        let matrix = Matrix::from_fn(3, 3, |i, j| ((3 * i + j) as f64).sin());
        let found = singular(&matrix).unwrap();
        assert!(found.values.is_sorted_by(|a, b| a >= b));
        let scaled = Matrix::from_fn(3, 3, |k, j| found.values[k] * found.directions[(k, j)]);
        assert!(is_near(&gram(&scaled, 0..3), &gram(&matrix, 0..3)));
    }

    #[test]
    fn solutions_and_inverse_agree() {
        let right = Matrix::from_fn(3, 2, |i, j| (i + 2 * j) as f64);
        let expected = inverse(&symmetric()) * &right;
        assert!(is_near(&solved(&symmetric(), &right), &expected));
        assert!(is_near(&symmetric_solved(&symmetric(), &right), &expected));
        // Indefinite: Cholesky's factor does not exist.
        let indefinite = Matrix::from_fn(2, 2, |i, j| if i == j { 0.0 } else { 1.0 });
        let right = Matrix::from_fn(2, 1, |i, _| i as f64);
        let swapped = Matrix::from_fn(2, 1, |i, _| 1.0 - i as f64);
        assert!(is_near(&symmetric_solved(&indefinite, &right), &swapped));
    }

    #[test]
    fn a_tall_system_is_solved_and_one_of_less_rank_is_not() {
        let matrix = Matrix::from_fn(3, 2, |row, column| {
            [[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]][row][column]
        });
        let solution = least_squares(&matrix, &[3.0, 4.0, 9.0]);
        assert!((solution[0] - 3.0).abs() < 1e-14 && (solution[1] - 2.0).abs() < 1e-14);
        let short = least_squares(&Matrix::zeros(3, 2), &[3.0, 4.0, 9.0]);
        assert!(short.iter().all(|value| !value.is_finite()));
    }

    #[test]
    fn products_are_of_the_rows_that_were_asked_for() {
        for n in 0..8 {
            let matrix = Matrix::from_fn(700, n, |i, j| ((i * 7 + j * 13) as f64).sin());
            let part = matrix.rows(20, 661);
            let expected = part.transpose() * part;
            assert!(
                (gram(&matrix, 20..681) - expected)
                    .iter()
                    .all(|e| e.abs() < 1e-11)
            );
            assert!(gram(&matrix, 5..5).iter().all(|product| *product == 0.0));
        }
    }

    #[test]
    fn of_what_is_no_number_nothing_is_decomposed() {
        let mut matrix = symmetric();
        (matrix[(1, 0)], matrix[(0, 1)]) = (f64::NAN, f64::NAN);
        let found = symmetric_eigen(&matrix);
        assert!(found.is_none_or(|eigen| eigen.values.iter().any(|value| value.is_nan())));
        let found = singular(&matrix);
        assert!(found.is_none_or(|found| found.values.iter().any(|value| value.is_nan())));
    }
}
