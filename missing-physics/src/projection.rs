//! What the baseline cannot absorb: series with the span of its sensitivities taken out.

use faer::Mat;

/// Singular value of the scaled sensitivities, relative to the largest, below which a direction is no
/// direction.
const SMALLEST_SINGULAR: f64 = 1e-9;

/// Orthonormal basis of the span of some columns.
#[derive(Debug, Clone)]
pub(crate) struct Span {
    basis: Mat<f64>,
}

impl Span {
    /// The span of columns of one length; their scales do not matter, and columns of zeros count for nothing.
    pub(crate) fn of(columns: &[Vec<f64>]) -> Self {
        let rows = columns.first().map_or(0, Vec::len);
        let norms: Vec<f64> = columns.iter().map(|column| norm(column)).collect();
        let kept: Vec<usize> = (0..columns.len()).filter(|&j| norms[j] > 0.0).collect();
        let scaled = Mat::from_fn(rows, kept.len(), |k, j| {
            columns[kept[j]][k] / norms[kept[j]]
        });
        let Ok(svd) = scaled.thin_svd() else {
            return Self {
                basis: Mat::zeros(rows, 0),
            };
        };
        let values = svd.S().column_vector();
        let largest = (0..kept.len()).map(|j| values[j]).fold(0.0, f64::max);
        let rank = (0..kept.len())
            .filter(|&j| values[j] > SMALLEST_SINGULAR * largest)
            .count();
        Self {
            basis: svd.U().get(.., ..rank).to_owned(),
        }
    }

    /// The part of a series outside the span.
    pub(crate) fn outside(&self, series: &[f64]) -> Vec<f64> {
        let mut outside = series.to_vec();
        // Twice is enough: what rounding leaves of the span the first time is gone after the second.
        for _ in 0..2 {
            for j in 0..self.basis.ncols() {
                let column = self.basis.col(j);
                let along: f64 = (0..outside.len()).map(|k| column[k] * outside[k]).sum();
                for (k, value) in outside.iter_mut().enumerate() {
                    *value -= along * column[k];
                }
            }
        }
        outside
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_the_span_is_left() {
        let columns: Vec<Vec<f64>> = (0..4)
            .map(|j| {
                (0..50)
                    .map(|k| ((k * (j + 1)) as f64 * 0.1).sin() * 10f64.powi(3 * j))
                    .collect()
            })
            .collect();
        let mut with_twin = columns.clone();
        with_twin.push(columns[1].iter().map(|value| -2.0 * value).collect());
        with_twin.push(vec![0.0; 50]);
        let span = Span::of(&with_twin);
        assert_eq!(span.basis.ncols(), 4);
        let series: Vec<f64> = (0..50).map(|k| (k as f64).sqrt()).collect();
        let outside = span.outside(&series);
        for column in &columns {
            assert!((dot(&outside, column) / norm(column)).abs() < 1e-11);
        }
        assert!(norm(&span.outside(&columns[2])) < 1e-10 * norm(&columns[2]));
    }
}
