//! Dense linear algebra of small matrices.
//!
//! The solvers of `faer` are generic: each crate that calls one compiles it anew. These functions are compiled here, once for
//! all crates that depend on this one.

use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, MatRef, Side};

/// Eigenvalues and eigenvectors of a symmetric matrix.
#[derive(Debug, Clone)]
pub struct SymmetricEigen {
    /// In ascending order.
    pub values: Vec<f64>,
    /// Column k belongs to value k.
    pub vectors: Mat<f64>,
}

impl SymmetricEigen {
    /// Columns of length √λ (0 where rounding left λ below zero): R with R Rᵀ the matrix.
    #[must_use]
    pub fn scaled_vectors(&self) -> Mat<f64> {
        let n = self.values.len();
        Mat::from_fn(n, n, |i, k| {
            self.vectors[(i, k)] * self.values[k].max(0.0).sqrt()
        })
    }
}

/// Eigenvalues and eigenvectors of a symmetric matrix, of which the lower triangle is read; `None` if the iteration did not
/// converge, as on a matrix with NaN.
#[must_use]
pub fn symmetric_eigen(matrix: &Mat<f64>) -> Option<SymmetricEigen> {
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let values = eigen.S().column_vector();
    Some(SymmetricEigen {
        values: (0..matrix.nrows()).map(|k| values[k]).collect(),
        vectors: eigen.U().to_owned(),
    })
}

/// Product of two matrices.
#[must_use]
pub fn product(left: MatRef<'_, f64>, right: MatRef<'_, f64>) -> Mat<f64> {
    left * right
}

/// Solution of a square system for each column on the right, by LU with row exchanges.
#[must_use]
pub fn solved(matrix: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    matrix.partial_piv_lu().solve(right)
}

/// The same for a symmetric matrix: by Cholesky's factor where it is positive definite, else by LU.
#[must_use]
pub fn symmetric_solved(matrix: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    match matrix.llt(Side::Lower) {
        Ok(factor) => factor.solve(right),
        Err(_) => solved(matrix, right),
    }
}

/// Inverse of a square matrix, by LU with row exchanges.
#[must_use]
pub fn inverse(matrix: &Mat<f64>) -> Mat<f64> {
    matrix.partial_piv_lu().inverse()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn symmetric() -> Mat<f64> {
        Mat::from_fn(3, 3, |i, j| {
            [[4.0, 1.0, 0.0], [1.0, 3.0, 1.0], [0.0, 1.0, 2.0]][i][j]
        })
    }

    fn is_near(one: &Mat<f64>, other: &Mat<f64>) -> bool {
        (one - other).norm_max() < 1e-12
    }

    #[test]
    fn scaled_vectors_are_a_root() {
        let root = symmetric_eigen(&symmetric()).unwrap().scaled_vectors();
        let squared = product(root.as_ref(), root.transpose());
        assert!(is_near(&squared, &symmetric()));
    }

    #[test]
    fn solutions_and_inverse_agree() {
        let right = Mat::from_fn(3, 2, |i, j| (i + 2 * j) as f64);
        let expected = product(inverse(&symmetric()).as_ref(), right.as_ref());
        assert!(is_near(&solved(&symmetric(), &right), &expected));
        assert!(is_near(&symmetric_solved(&symmetric(), &right), &expected));
        // Indefinite: Cholesky's factor does not exist.
        let indefinite = Mat::from_fn(2, 2, |i, j| if i == j { 0.0 } else { 1.0 });
        let right = Mat::from_fn(2, 1, |i, _| i as f64);
        let swapped = Mat::from_fn(2, 1, |i, _| 1.0 - i as f64);
        assert!(is_near(&symmetric_solved(&indefinite, &right), &swapped));
    }

    #[test]
    fn of_what_is_no_number_nothing_is_decomposed() {
        let mut matrix = symmetric();
        matrix[(1, 0)] = f64::NAN;
        let found = symmetric_eigen(&matrix);
        assert!(found.is_none_or(|eigen| eigen.values.iter().any(|value| value.is_nan())));
    }
}
