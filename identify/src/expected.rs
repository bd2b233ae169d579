//! What is to be expected of parameters before a recording is looked at, as squares beside those of the residual.

use crate::parameter::ParameterVector;

/// How what is to be expected of parameters ([`ParameterInfo::ordinary`](crate::ParameterInfo::ordinary)) counts beside what was recorded.
///
/// ```text
/// P = Σ ((x - x_before)/s)²,   s the ordinary deviation
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Expecting {
    /// Not at all.
    #[default]
    Nothing,
    /// Against errors of this variance σ², in the square of the output unit: least is S + σ² P.
    Variance(f64),
    /// Against as many independent samples N, whose errors are as large as the model leaves them: least is S exp(P/N), of which the
    /// logarithm is that of a likelihood and of what is expected.
    Independent(f64),
}

impl Expecting {
    /// What counts in all, of the squares S of residuals and of P.
    pub(crate) fn sum(self, squares: f64, expected: f64) -> f64 {
        match self {
            Self::Nothing => squares,
            Self::Variance(variance) => squares + variance * expected,
            Self::Independent(n) => squares * (expected / n).exp(),
        }
    }

    /// Variance of an error beside which P counts, near squares S of residuals, ≥ 0.
    #[must_use]
    pub fn variance(self, squares: f64) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::Variance(variance) => variance,
            Self::Independent(n) => squares / n,
        }
    }
}

/// What is to be expected of a coordinate: the root of its part of P.
#[derive(Debug, Clone, Copy)]
pub struct Expectation {
    coordinate: usize,
    /// The coordinate from which it goes on.
    previous: Option<usize>,
    /// 1/s.
    per_unit: f64,
}

impl Expectation {
    /// (x - x_before)/s at coordinates, as [`ParameterVector`] has them.
    #[must_use]
    pub fn value(&self, point: &[f64]) -> f64 {
        let from = self.previous.map_or(0.0, |previous| point[previous]);
        self.per_unit * (point[self.coordinate] - from)
    }

    /// Its derivative by a coordinate.
    #[must_use]
    pub fn derivative(&self, coordinate: usize) -> f64 {
        if coordinate == self.coordinate {
            self.per_unit
        } else if Some(coordinate) == self.previous {
            -self.per_unit
        } else {
            0.0
        }
    }
}

/// What is to be expected of coordinates.
#[must_use]
pub fn expected(vector: &ParameterVector) -> Vec<Expectation> {
    let row = |coordinate: usize| {
        let parameter = vector.parameter(coordinate);
        let ordinary = vector.infos()[parameter].ordinary?;
        // Of one recording they stand in the order of the parameters.
        let before = coordinate.checked_sub(1);
        let is_next = |&before: &usize| vector.parameter(before) + 1 == parameter;
        Some(Expectation {
            coordinate,
            previous: before.filter(|before| ordinary.from_previous && is_next(before)),
            per_unit: 1.0 / ordinary.deviation,
        })
    };
    (0..vector.len()).filter_map(row).collect()
}
