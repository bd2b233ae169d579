//! What is to be expected of parameters before a recording is looked at, as squares beside those of the residual.

use crate::IdentifyError;
use crate::least_squares::{Linearized, SumOfSquares};
use crate::parameter::ParameterVector;
use crate::problem::Problem;

/// A coordinate, the one from which it goes on, and the root of what their difference counts.
#[derive(Debug, Clone, Copy)]
struct Expectation {
    coordinate: usize,
    previous: Option<usize>,
    per_unit: f64,
}

impl Expectation {
    fn row(&self, point: &[f64]) -> f64 {
        let from = self.previous.map_or(0.0, |previous| point[previous]);
        self.per_unit * (point[self.coordinate] - from)
    }

    /// The row's derivative by a coordinate.
    fn derivative(&self, coordinate: usize) -> f64 {
        if coordinate == self.coordinate {
            self.per_unit
        } else if Some(coordinate) == self.previous {
            -self.per_unit
        } else {
            0.0
        }
    }
}

/// A problem and what is to be expected of its parameters.
///
/// ```text
/// Σ w r² + σ² Σ ((x - x_before)/s)²,   s the ordinary deviation
/// ```
#[derive(Debug)]
pub(crate) struct Expecting<'p, 'a> {
    problem: &'p Problem<'a>,
    rows: Vec<Expectation>,
}

impl<'p, 'a> Expecting<'p, 'a> {
    /// `error_variance` is σ², that of one sample; with 0 nothing is expected.
    pub(crate) fn new(problem: &'p Problem<'a>, error_variance: f64) -> Self {
        let rows = match error_variance {
            variance if variance > 0.0 => rows(problem.vector(), variance.sqrt()),
            _ => Vec::new(),
        };
        Self { problem, rows }
    }

    fn squares(&self, point: &[f64]) -> f64 {
        self.rows.iter().map(|one| one.row(point).powi(2)).sum()
    }
}

fn rows(vector: &ParameterVector, error: f64) -> Vec<Expectation> {
    let row = |coordinate: usize| {
        let parameter = vector.parameter(coordinate);
        let ordinary = vector.infos()[parameter].ordinary?;
        // Of one recording they stand in the order of the parameters.
        let before = coordinate.checked_sub(1);
        let is_next = |&before: &usize| vector.parameter(before) + 1 == parameter;
        Some(Expectation {
            coordinate,
            previous: before.filter(|before| ordinary.from_previous && is_next(before)),
            per_unit: error / ordinary.deviation,
        })
    };
    (0..vector.len()).filter_map(row).collect()
}

impl SumOfSquares for Expecting<'_, '_> {
    fn linearized(
        &self,
        points: &[Vec<f64>],
        around: usize,
    ) -> Result<(Vec<f64>, Linearized), IdentifyError> {
        let (mut sums, local) = self.problem.linearized(points, around)?;
        if self.rows.is_empty() {
            return Ok((sums, local));
        }
        for (sum, point) in sums.iter_mut().zip(points) {
            *sum += self.squares(point);
        }
        let point = &points[around];
        let rows = self.rows.iter().map(|one| {
            let derivatives = (0..point.len()).map(|column| one.derivative(column));
            (derivatives.collect(), one.row(point))
        });
        let local = local.with_rows(rows, sums[around]);
        Ok((sums, local))
    }

    fn rounding(&self) -> f64 {
        self.problem.rounding()
    }

    fn n_derivatives(&self) -> usize {
        self.problem.n_derivatives()
    }

    fn sums(&self, points: &[Vec<f64>]) -> Result<Vec<f64>, IdentifyError> {
        let sums = self.problem.sums(points)?.into_iter().zip(points);
        Ok(sums.map(|(sum, point)| sum + self.squares(point)).collect())
    }
}
