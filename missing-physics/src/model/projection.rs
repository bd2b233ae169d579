//! Projections of series outside the span of sensitivities: the part that a model cannot absorb.

use wiener::widest_vectors;

/// Length of a column outside the others, relative to its own, below which it adds no direction.
const SMALLEST_OUTSIDE: f64 = 1e-8;

/// Orthonormal basis of the span of some columns.
#[derive(Debug, Clone, Default)]
pub(crate) struct Span {
    basis: Vec<Vec<f64>>,
}

impl Span {
    /// The span of columns of one length; their scales do not matter, and columns of zeros count for nothing.
    pub(crate) fn of<'a>(columns: impl IntoIterator<Item = &'a Vec<f64>>) -> Self {
        let mut span = Self::default();
        for column in columns {
            span.widen(column);
        }
        span
    }

    /// Takes in one column more; whether it added a direction.
    pub(crate) fn widen(&mut self, column: &[f64]) -> bool {
        let own = norm(column);
        let mut outside = self.outside(column);
        let left = norm(&outside);
        let adds = left > SMALLEST_OUTSIDE * own;
        if adds {
            outside.iter_mut().for_each(|value| *value /= left);
            self.basis.push(outside);
        }
        adds
    }

    /// The directions, each of length 1.
    pub(crate) fn basis(&self) -> &[Vec<f64>] {
        &self.basis
    }

    /// The part of a series outside the span.
    #[inline(never)]
    pub(crate) fn outside(&self, series: &[f64]) -> Vec<f64> {
        let mut outside = series.to_vec();
        widest_vectors(
            #[inline(always)]
            || {
                // Twice is enough: what rounding leaves of the span the first time is gone after the second.
                for _ in 0..2 {
                    for direction in &self.basis {
                        let along = strands(direction, &outside);
                        for (value, direction) in outside.iter_mut().zip(direction) {
                            *value -= along * direction;
                        }
                    }
                }
            },
        );
        outside
    }
}

/// Sum of products.
#[inline(never)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    widest_vectors(
        #[inline(always)]
        || strands(a, b),
    )
}

/// Sum of products, in eight strands that the processor takes side by side.
#[inline(always)]
fn strands(a: &[f64], b: &[f64]) -> f64 {
    let mut strands = [0.0; 8];
    let (chunks_a, chunks_b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = chunks_a
        .remainder()
        .iter()
        .zip(chunks_b.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in chunks_a.zip(chunks_b) {
        for l in 0..8 {
            strands[l] += a[l] * b[l];
        }
    }
    strands.iter().sum::<f64>() + rest
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
        assert_eq!(span.basis().len(), 4);
        let series: Vec<f64> = (0..50).map(|k| (k as f64).sqrt()).collect();
        let outside = span.outside(&series);
        for column in &columns {
            assert!((dot(&outside, column) / norm(column)).abs() < 1e-11);
        }
        assert!(norm(&span.outside(&columns[2])) < 1e-10 * norm(&columns[2]));
    }
}
