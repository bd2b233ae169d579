use faer::Mat;
use faer::linalg::solvers::{Qr, SolveLstsqCore};

/// Rows gathered before they are absorbed into the triangle.
const ROWS: usize = 256;

/// Triangular factor of a tall matrix that arrives row by row: memory does not grow with its length.
///
/// ```text
/// A = Q R,   A stacked from blocks:  R_new from the QR decomposition of [R_old; block]
/// ```
#[derive(Debug, Clone)]
pub(crate) struct Triangle {
    columns: usize,
    /// R above, new rows below.
    stack: Mat<f64>,
    filled: usize,
}

impl Triangle {
    pub(crate) fn new(columns: usize) -> Self {
        Self {
            columns,
            stack: Mat::zeros(columns + ROWS, columns),
            filled: columns,
        }
    }

    /// Adds one row: `value(column)`.
    pub(crate) fn push(&mut self, value: impl Fn(usize) -> f64) {
        if self.filled == self.stack.nrows() {
            self.absorb();
        }
        for column in 0..self.columns {
            self.stack[(self.filled, column)] = value(column);
        }
        self.filled += 1;
    }

    fn absorb(&mut self) {
        let r = Qr::new(self.stack.get(..self.filled, ..))
            .thin_R()
            .to_owned();
        self.stack = Mat::zeros(self.columns + ROWS, self.columns);
        self.stack.get_mut(..self.columns, ..).copy_from(&r);
        self.filled = self.columns;
    }

    /// R, square and upper triangular.
    pub(crate) fn r(mut self) -> Mat<f64> {
        self.absorb();
        self.stack.get(..self.columns, ..).to_owned()
    }
}

/// Least-squares solution of a small full-rank system, by QR.
pub(crate) fn solve(matrix: &Mat<f64>, right: &[f64]) -> Vec<f64> {
    let mut solution = Mat::from_fn(right.len(), 1, |row, _| right[row]);
    Qr::new(matrix.as_ref()).solve_lstsq_in_place_with_conj(faer::Conj::No, solution.as_mut());
    (0..matrix.ncols()).map(|row| solution[(row, 0)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_row_by_row_has_the_factor_of_the_whole() {
        // More rows than one absorption takes; RᵀR = AᵀA whatever the order of the rows.
        let value = |row: usize, column: usize| ((row * 7 + column * 13) as f64).sin();
        let n_rows = 3 * ROWS + 17;
        let mut triangle = Triangle::new(4);
        for row in 0..n_rows {
            triangle.push(|column| value(row, column));
        }
        let r = triangle.r();
        for i in 0..4 {
            for j in 0..4 {
                let whole: f64 = (0..n_rows).map(|row| value(row, i) * value(row, j)).sum();
                let factored: f64 = (0..4).map(|k| r[(k, i)] * r[(k, j)]).sum();
                assert!((whole - factored).abs() < 1e-10 * n_rows as f64);
            }
        }
    }

    #[test]
    fn a_small_system_is_solved() {
        let matrix = Mat::from_fn(3, 2, |row, column| {
            [[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]][row][column]
        });
        let solution = solve(&matrix, &[3.0, 4.0, 9.0]);
        assert!((solution[0] - 3.0).abs() < 1e-14 && (solution[1] - 2.0).abs() < 1e-14);
    }
}
