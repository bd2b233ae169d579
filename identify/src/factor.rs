use wiener::widest_vectors;

use crate::dense::{Matrix, dot};

/// Rows gathered before they are absorbed into the triangle.
const ROWS: usize = 256;

/// Triangular factor of a tall matrix that arrives row by row: memory does not grow with its length.
///
/// ```text
/// A = Q R,   A stacked from blocks:  R_new from the QR decomposition of [R_old; block]
/// ```
///
/// By Householder's reflections, each of which leaves the rows of R_old below its own alone, because they are zero there
/// \[GolubVanLoan, section 5.2\].
#[derive(Debug, Clone)]
pub(crate) struct Triangle {
    columns: usize,
    /// R, column after column.
    r: Vec<f64>,
    /// New rows, column after column, `ROWS` long.
    block: Vec<f64>,
    filled: usize,
}

impl Triangle {
    pub(crate) fn new(columns: usize) -> Self {
        Self {
            columns,
            r: vec![0.0; columns * columns],
            block: vec![0.0; columns * ROWS],
            filled: 0,
        }
    }

    /// Adds one row: `value(column)`.
    pub(crate) fn push(&mut self, value: impl Fn(usize) -> f64) {
        if self.filled == ROWS {
            self.absorb();
        }
        for column in 0..self.columns {
            self.block[ROWS * column + self.filled] = value(column);
        }
        self.filled += 1;
    }

    fn absorb(&mut self) {
        widest_vectors(
            #[inline(always)]
            || {
                for column in 0..self.columns {
                    self.reflect(column);
                }
            },
        );
        self.filled = 0;
    }

    /// Reflects what stands below the diagonal in a column into it.
    #[inline(always)]
    fn reflect(&mut self, column: usize) {
        let (before, after) = self.block.split_at_mut(ROWS * (column + 1));
        let below = &mut before[ROWS * column..][..self.filled];
        let diagonal = self.columns * column + column;
        let head = self.r[diagonal];
        let square = dot(below, below);
        // Nothing to be done, or so little that its square has no digits.
        if square < f64::MIN_POSITIVE {
            return;
        }
        let length = (head * head + square).sqrt();
        let reflected = if head > 0.0 { -length } else { length };
        let factor = (reflected - head) / reflected;
        let per_head = 1.0 / (head - reflected);
        for value in below.iter_mut() {
            *value *= per_head;
        }
        self.r[diagonal] = reflected;
        for (ahead, other) in after.chunks_exact_mut(ROWS).enumerate() {
            let other = &mut other[..self.filled];
            let top = &mut self.r[self.columns * (column + 1 + ahead) + column];
            let share = factor * (*top + dot(below, other));
            *top -= share;
            for (value, &below) in other.iter_mut().zip(&*below) {
                *value -= share * below;
            }
        }
    }

    /// R, square and upper triangular.
    pub(crate) fn r(mut self) -> Matrix {
        self.absorb();
        Matrix::from_fn(self.columns, self.columns, |row, column| {
            self.r[self.columns * column + row]
        })
    }
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
    fn what_is_no_number_stays_none_and_nothing_stays_nothing() {
        let mut triangle = Triangle::new(2);
        triangle.push(|column| if column == 0 { 0.0 } else { 1.0 });
        triangle.push(|column| if column == 0 { 0.0 } else { f64::NAN });
        let r = triangle.r();
        assert!(r[(0, 0)].abs() + r[(1, 0)].abs() <= 0.0);
        assert!(r[(1, 1)].is_nan());
    }
}
