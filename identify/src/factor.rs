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
