//! Priors of parameters, as squares beside those of the residual.

use crate::parameter::ParameterVector;

/// How the prior of parameters ([`ParameterInfo::ordinary`](crate::ParameterInfo::ordinary)) counts beside what was recorded.
///
/// ```text
/// P = Σ ((x - x_before)/s)²,   s the ordinary deviation
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Prior {
    /// Not at all.
    #[default]
    Nothing,
    /// Against errors of this variance σ², in the square of the output unit: least is S + σ² P.
    Variance(f64),
    /// With the error variance profiled out over N effective samples: least is S exp(P/N), so that N ln S + P is twice the negative
    /// logarithm of the posterior density.
    Profiled(f64),
}

impl Prior {
    /// Total cost of the squares S of residuals and of the prior's P.
    pub(crate) fn sum(self, squares: f64, of_prior: f64) -> f64 {
        match self {
            Self::Nothing => squares,
            Self::Variance(variance) => squares + variance * of_prior,
            Self::Profiled(n) => squares * (of_prior / n).exp(),
        }
    }

    /// Variance of an error beside which P counts, near squares S of residuals, ≥ 0.
    #[must_use]
    pub fn variance(self, squares: f64) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::Variance(variance) => variance,
            Self::Profiled(n) => squares / n,
        }
    }
}

/// The prior of a coordinate: the root of its part of P.
#[derive(Debug, Clone, Copy)]
pub struct PriorRow {
    coordinate: usize,
    /// The coordinate from which it goes on.
    previous: Option<usize>,
    /// 1/s.
    per_unit: f64,
}

impl PriorRow {
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

/// The priors of coordinates that have one.
#[must_use]
pub fn prior_rows(vector: &ParameterVector) -> Vec<PriorRow> {
    let row = |coordinate: usize| {
        let parameter = vector.parameter(coordinate);
        let ordinary = vector.infos()[parameter].ordinary?;
        // Of one recording they stand in the order of the parameters.
        let before = coordinate.checked_sub(1);
        let is_next = |&before: &usize| vector.parameter(before) + 1 == parameter;
        Some(PriorRow {
            coordinate,
            previous: before.filter(|before| ordinary.from_previous && is_next(before)),
            per_unit: 1.0 / ordinary.deviation,
        })
    };
    (0..vector.len()).filter_map(row).collect()
}
